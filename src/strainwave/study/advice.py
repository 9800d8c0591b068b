"""What an engineer is told to do: the speeds to avoid, and what would make the error smaller."""

from dataclasses import dataclass
from typing import Any

from ..model.drive_train import DriveTrain
from .avoid import Avoid, Motions, speeds_to_avoid
from .exact import ExactResponse
from .regimes import OperatingPoint
from .remedies import Remedy, remedies


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
) -> Advice | None:
    """`speeds_to_avoid` and, where there are any, `remedies`; None where no motion is stable."""
    avoid = speeds_to_avoid(system, response, point, limit, passed)
    if avoid is None:
        return None
    return Advice(avoid, remedies(system, response, avoid, speeds, torque, train, loads) if avoid.bands else ())
