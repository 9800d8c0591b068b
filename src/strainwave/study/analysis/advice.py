"""What an engineer is told to do: the speeds to avoid, and what would make the error smaller."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from ...model.train.drive_train import DriveTrain
from ..response.resonances import OperatingPoint
from ..response.response import ExactResponse
from .avoid import Avoid, Motions, speeds_to_avoid
from .remedies import Remedy, remedies
from .runup import silent


@dataclass(frozen=True)
class Advice:
    """Speeds to avoid, and what would help, the most helpful first."""

    avoid: Avoid
    remedies: tuple[Remedy, ...]


def advise(
    system: Any,
    response: ExactResponse,
    point: OperatingPoint,
    speeds: tuple[float, float],
    torque: float,
    train: DriveTrain | None = None,
    *,
    limit: float | None = None,
    loads: tuple[tuple[float, Any], ...] = (),
    passed: Motions | None = None,
    progress: Callable[[str], None] = silent,
) -> Advice | None:
    """`speeds_to_avoid` and, where there are any, `remedies`; None where no motion is stable.

    `progress` is told every change before it is tried.
    """
    avoid = speeds_to_avoid(system, response, point, limit, passed)
    if avoid is None:
        return None
    if not avoid.bands:
        return Advice(avoid, ())
    return Advice(avoid, remedies(system, response, avoid, speeds, torque, train, loads, progress))
