"""Steady motions of a train or an error equation, by the balance of one turn of the motor or of two."""

from typing import Any

from ..base.protocols import lacking
from ..base.results import SolveError
from ..model.train import DriveTrain
from .drive_response import DriveResponse
from .response import exact_response
from .train_curve import Crest, follows_its_angle, largest_crest, train_curve
from .two_turns import NONE_STABLE, BeatCrest, beating_response, largest_beat


def is_beating(error: Any) -> bool:
    """Whether lines of a kinematic error belong to the output's turn, or to both, so that motions beat."""
    return not lacking(error, "lines") and any(line.order % 1 for line in error.lines)


def leaves_angle_out(train: DriveTrain) -> bool:
    """Whether the steady curve has the mean alone of a torque that follows the angle of the load."""
    return not (train.motor.free or is_beating(train.error)) and follows_its_angle(train)


def drive_curve(train: DriveTrain, speeds: tuple[float, float], **how: Any) -> DriveResponse | None:
    """As `train_motions`; None where it raises."""
    try:
        return train_motions(train, speeds, **how)
    except SolveError:
        return None


def train_motions(
    train: DriveTrain, speeds: tuple[float, float], level: float | None = None, **how: Any
) -> DriveResponse | None:  # fmt: skip
    """Motions of a train, in one turn or in two: as `train_curve`, or as `beating_response` with points at a level.

    Raises
    ------
    SolveError
        If no motion of two turns is found, or none of them is stable.
    """
    if not is_beating(train.error):
        return train_curve(train, speeds, **how)
    return _of_two_turns(train, speeds, level)


def equation_curve(
    equation: Any, speeds: tuple[float, float], level: float | None = None, train: DriveTrain | None = None,
    **how: Any,
) -> DriveResponse:  # fmt: skip
    """Motions of an error equation, as `exact_response`; in two turns those of the `train` that has it (SolveError)."""
    if is_beating(equation.error):
        return _of_two_turns(train, speeds, level)
    return exact_response(equation, speeds, train=train, **how)


def _of_two_turns(train: DriveTrain | None, speeds: tuple[float, float], level: float | None) -> DriveResponse:
    found = beating_response(train, speeds, level)
    if found.sweep is None:
        raise SolveError(NONE_STABLE)
    return found


def top_of(
    system: Any, speeds: tuple[float, float], harmonics: int | None, coexisting: bool = True, pairs: Any = ()
) -> Crest | BeatCrest | None:  # fmt: skip
    """The largest oscillation of a train or of an error equation, as `largest_crest` or `largest_beat`."""
    if isinstance(system, DriveTrain) and is_beating(system.error):
        return largest_beat(system, speeds, pairs)
    return largest_crest(system, speeds, harmonics, coexisting)
