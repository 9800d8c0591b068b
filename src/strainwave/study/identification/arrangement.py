"""`arrangement`: ratio and arrangement of a gear from the counts of encoders on both sides."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ...base.quantities import SMALLEST, array_of, positive_count
from ...base.units import ARCSEC
from ...model.orders import TURNING_SPLINE, USUAL, Arrangement, whole_ratio
from .orders.places import RATIOS

MOST_ERROR_RAD = 240.0 * ARCSEC  # rad: wind-up and error of gear and encoders that a motion may have, peak to peak
RATIO_DOUBT = 0.5  # turns of the motor per turn of the output
TURN = 2.0 * np.pi


class Counted(NamedTuple):
    """Counts of a gear.

    Attributes
    ----------
    ratio : int
        Motor turns per output turn, negative where the encoders count opposite ways.
    measured, error : float
        Slope of the motor's angle over the output's, and what wind-up of 240 arcsec changes in it.
    N : int
        Ratio of the same teeth with the circular spline fixed.
    arrangement : Arrangement or None
        Members that are fixed and the output; None where ratio and sense contradict each other.
    why : str
        The reason.
    """

    ratio: int
    measured: float
    error: float
    N: int
    arrangement: Arrangement | None
    why: str


def arrangement(motor_counts: ArrayLike, load_counts: ArrayLike, per_turn: int = 1 << 24) -> Counted:
    """Find ratio and arrangement of a gear from counts of encoders on motor and output.

    Parameters
    ----------
    motor_counts, load_counts : (n,) array_like
        Counts at the same times, sampled at least twice a turn of the motor; they may wrap after a turn.
    per_turn : int
        Counts per turn of both.

    Returns
    -------
    Counted
        `ratio`, motor turns per output turn, whole, and `measured`, the slope with its `error`, all numbers without
        unit; the `arrangement` and `why`. The sense of rotation assumes that both encoders count positive the same
        way; ratios of the catalogues (30, 50, 80, 100, 120, 160) or one more confirm it.

    Raises
    ------
    ValueError
        If the output turns too little to tell the ratio, or the teeth of a gear cannot have it.
    """
    steps = positive_count("per_turn", per_turn)
    motor = np.unwrap(array_of("motor_counts", motor_counts, None), period=steps) / steps
    load = np.unwrap(array_of("load_counts", load_counts, len(motor)), period=steps) / steps
    off, travel = load - np.mean(load), float(np.ptp(load)) * TURN
    moves = travel > SMALLEST
    slope = float(off @ motor) / float(off @ off) if moves else np.inf
    error = abs(slope) * MOST_ERROR_RAD / travel if moves else np.inf
    if not error < RATIO_DOUBT:
        raise ValueError(
            f"the output turns by {np.degrees(travel):.3g} deg: torsion may change the ratio {abs(slope):.4g} by "
            f"{error:.2g}; use counts of a longer motion"
        )
    ratio = round(slope)
    if abs(slope - ratio) > error:
        raise ValueError(f"the ratio is {slope:.6g} +- {error:.2g}, impossible for the teeth of a strain wave gear")
    size = whole_ratio(abs(ratio))
    by_sense = TURNING_SPLINE if ratio > 0 else USUAL
    sense = "the same way" if ratio > 0 else "opposite ways"
    usual = [one for one, N in ((USUAL, size), (TURNING_SPLINE, size - 1)) if N in RATIOS]
    N = size - 1 if (usual or [by_sense])[0] == TURNING_SPLINE else size
    if usual and by_sense not in usual:
        why = (
            f"{size} is usual with {usual[0]}, but the encoders count {sense}: one may count backward, or N is unusual"
        )
        return Counted(ratio, slope, error, N, None, why)
    reason = f"{N} is a usual ratio with the circular spline fixed" if usual else "its ratio is no usual one"
    return Counted(ratio, slope, error, N, by_sense, f"the encoders count {sense}, and {reason}")
