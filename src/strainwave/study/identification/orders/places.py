"""Search for the orders of lines in runs, each put on a whole order or a multiple of the ratio where it may be one.

Ratio and arrangement of a gear from the counts of encoders on both sides.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ....base.quantities import SMALLEST, array_of, number, positive_count
from ....base.units import ARCSEC
from ....model.orders import TURNING_SPLINE, USUAL, Arrangement, whole_ratio
from ..run import Run
from .beats import LINE_GAP, Clocks, completed, named
from .order_search import FoundLine, Search

HIGHEST_ORDER = 1000.0  # order that is looked for
LEAST_PERIODS = 4.0  # periods of an order that a run must hold to be looked for
RATIOS = (30, 50, 80, 100, 120, 160)  # of strain wave gears: multiples of them are looked for first
PEAK_WIDTH = 0.18  # resolutions beside its peak a line has 90 % of its power
CHANCE = 0.05
MOST_LINES = 24


def placed_lines(
    runs: Sequence[Run], limit: float, highest: float | None, false_alarm: float, turning: Clocks | None = None
) -> tuple[list[FoundLine], float]:  # fmt: skip
    """Lines of runs whose samples show orders up to a limit, and the number that most are multiples of (0: none)."""
    top = min(HIGHEST_ORDER, limit) if highest is None else number("highest", highest, positive=True)
    if top > limit:
        raise ValueError(f"highest is {top:g}; these samples show orders below {limit:.4g}")
    lowest = LEAST_PERIODS / min(run.turns for run in runs)
    if lowest >= top:
        raise ValueError(
            f"the shortest run travels {LEAST_PERIODS / lowest:.3g} turns and its samples show orders below {top:.4g}; "
            "take longer runs or more samples to find orders, or give them"
        )
    search = Search(runs, lowest, top)
    strong: list[FoundLine] = []
    while len(strong) < MOST_LINES and (line := search.strongest(false_alarm)) is not None:
        strong.append(line)
    strong = search.reconsidered(strong)
    sharp = _merged(strong, runs)
    base = _base([_widened(line, _resolution(line, runs)) for line in sharp])
    if base:
        multiples = [k for k in np.arange(base, top, base) if k >= lowest]
        weak = [search.around(k, len(multiples), false_alarm) for k in multiples]
        sharp = _merged([*sharp, *(line for line in weak if line is not None)], runs)
    placed = [_whole(line, base, _resolution(line, runs)) for line in sharp]
    lines = completed(runs, placed, turning, false_alarm, (lowest, top))
    wide = [line if line.alone else _widened(line, _resolution(line, runs)) for line in lines]
    return [named(line, turning, runs) for line in wide], base


def _merged(lines: Sequence[FoundLine], runs: Sequence[Run]) -> list[FoundLine]:
    """Lines that the runs resolve: nearer ones are one, at the place of the stronger."""
    merged: list[FoundLine] = []
    for line in lines:  # the strongest first
        width = _resolution(line, runs)
        neighbours = [
            i
            for i, other in enumerate(merged)
            if (other.kind == "frequency") == (line.kind == "frequency")
            and abs(other.place - line.place) < LINE_GAP * width
        ]
        if neighbours:
            old = merged[neighbours[0]]
            merged[neighbours[0]] = old._replace(reach=max(old.reach, abs(line.place - old.place)))
        else:
            merged.append(line)
    return merged


def _resolution(line: FoundLine, runs: Sequence[Run]) -> float:
    """Distance of two lines that the longest run tells apart: in orders, or in Hz."""
    if line.kind == "frequency":
        return 1.0 / max(float(run.time[-1] - run.time[0]) for run in runs)
    return 1.0 / max(run.turns for run in runs)


def _base(lines: Sequence[FoundLine]) -> float:
    """Largest whole number of which most lines may be multiples, three at least, and not by chance; 0 without one."""
    over_angle = [line for line in lines if line.kind != "frequency"]
    for bases in (RATIOS, range(10, 501)):
        for base in sorted(bases, reverse=True):
            chance = [min(1.0, 2.0 * line.error / base) for line in over_angle]
            hits = [abs(line.place - base * max(1, round(line.place / base))) <= line.error for line in over_angle]
            many = sum(hits)
            if many >= max(3, 0.5 * len(over_angle)) and _by_chance(chance, many) * len(bases) < CHANCE:
                return float(base)
    return 0.0


def _by_chance(chances: Sequence[float], many: int) -> float:
    """Probability that so many of independent events happen."""
    counts = np.array([1.0])
    for p in chances:
        counts = np.convolve(counts, [1.0 - p, p])
    return float(np.sum(counts[many:]))


def _whole(line: FoundLine, base: float, resolution: float) -> FoundLine:
    """The line at a multiple of the base or at a whole order, where that is as good a place."""
    if line.kind == "frequency":
        return line
    for step in (base, 1.0 if resolution < 1.0 else 0.0):
        nearest = step * round(line.place / step) if step else 0.0
        if nearest > 0.0 and abs(line.place - nearest) <= 2.0 * line.error + PEAK_WIDTH * resolution:
            return line._replace(place=nearest)
    return line


def _widened(line: FoundLine, resolution: float) -> FoundLine:
    """The line with what its place may be off by: of two that are not told apart it shows their middle, or one."""
    return line._replace(error=2.0 * line.error + max(0.5 * LINE_GAP * resolution, line.reach))


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
            f"the output turns by {np.degrees(travel):.3g} deg: wind-up may change the ratio {abs(slope):.4g} by "
            f"{error:.2g}; give counts of a longer motion"
        )
    ratio = round(slope)
    if abs(slope - ratio) > error:
        raise ValueError(f"the ratio is {slope:.6g} +- {error:.2g}, which the teeth of a strain wave gear cannot have")
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
