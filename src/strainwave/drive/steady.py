"""Steady motions of a train or an error equation, by the balance of one turn of the motor or of two."""

from dataclasses import replace
from typing import Any

from ..base.protocols import lacking
from ..base.quantities import positive_count
from ..base.results import SolveError
from ..model.train.drive_train import DriveTrain
from .drive_response import DriveResponse
from .response import POINTS, exact_response
from .train_curve import POINTS as OF_TRAIN
from .train_curve import Crest, as_train, follows_its_angle, has_curve, largest_crest, train_curve
from .two_turns import NONE_STABLE, BeatCrest, beating_response, largest_beat


def is_beating(error: Any) -> bool:
    """True if lines of a kinematic error belong to the output's turn, or to both, so that motions beat."""
    return not lacking(error, "lines") and any(line.order % 1 for line in error.lines)


def leaves_angle_out(train: DriveTrain) -> bool:
    """True if the steady curve has the mean alone of a torque that follows the angle of the load."""
    return not is_beating(train.error) and follows_its_angle(train)


def drive_curve(train: DriveTrain, speeds: tuple[float, float], **how: Any) -> DriveResponse | None:
    """Curve of `train_motions`; None where it raises."""
    try:
        return train_motions(train, speeds, **how)
    except SolveError:
        return None


def train_motions(
    train: DriveTrain, speeds: tuple[float, float], level: float | None = None, harmonics: int | None = None, *,
    coexisting: bool = True, points: int | None = None, torques: bool = True,
) -> DriveResponse | None:  # fmt: skip
    """Motions of a train, in one turn or in two: as `train_curve`, or as `beating_response` with points at a level.

    None where it has no curve in one turn, or none is found.

    Raises
    ------
    ValueError
        If harmonics are given where motions beat.
    SolveError
        If no motion of two turns is found, or none of them is stable.
    """
    if is_beating(train.error):
        response = _of_two_turns(train, speeds, level, harmonics, points)
        if response.sweep is None:
            raise SolveError(NONE_STABLE)
        return response
    if not has_curve(train):
        return None
    points = OF_TRAIN if points is None else points
    return train_curve(train, speeds, harmonics, coexisting=coexisting, points=points, torques=torques)


def equation_curve(
    equation: Any, speeds: tuple[float, float], level: float | None = None, train: DriveTrain | None = None,
    harmonics: int | None = None, *, coexisting: bool = True, points: int | None = None, has_reference: bool = True,
    ratio: float | None = None,
) -> DriveResponse:  # fmt: skip
    """Motions of an error equation, as `exact_response`, whose curve may be empty.

    In two turns those of the `train` that has it; without one, of a held motor with a rigid load at a `ratio`.

    Raises
    ------
    ValueError
        If harmonics are given where motions beat, or these have neither train nor ratio.
    SolveError
        If no motion of two turns is found.
    """
    if is_beating(equation.error):
        two = as_train(equation, ratio) if train is None and ratio is not None else train
        return replace(_of_two_turns(two, speeds, level, harmonics, points), has_reference=has_reference)
    points = POINTS if points is None else points
    return exact_response(equation, speeds, points, harmonics, coexisting, has_reference, train)


def _of_two_turns(
    train: DriveTrain | None, speeds: tuple[float, float], level: float | None, harmonics: int | None,
    points: int | None,
) -> DriveResponse:  # fmt: skip
    if points is not None:
        positive_count("points", points)
    if harmonics is not None:
        raise ValueError(f"harmonics is {harmonics}, but waves of beating motions are chosen automatically; omit it")
    return beating_response(train, speeds, level)


def top_of(
    system: Any, speeds: tuple[float, float], harmonics: int | None, coexisting: bool = True, pairs: Any = ()
) -> Crest | BeatCrest | None:  # fmt: skip
    """The largest oscillation of a train or of an error equation, as `largest_crest` or `largest_beat`."""
    if isinstance(system, DriveTrain) and is_beating(system.error):
        return largest_beat(system, speeds, pairs)
    return largest_crest(system, speeds, harmonics, coexisting)
