"""Search for the orders of lines in runs, each put on a whole order or a multiple of the ratio where it may be one."""

from collections.abc import Sequence

import numpy as np

from ....base.quantities import number
from ..run import Run
from .beats import LINE_GAP, Clocks, completed, named
from .order_search import FoundLine, Search

HIGHEST_ORDER = 1000.0  # order that is looked for
LEAST_PERIODS = 4.0  # periods of an order that a run must hold to be looked for
RATIOS = (30, 50, 80, 100, 120, 160)  # of strain wave gears: multiples of them are looked for first
PEAK_WIDTH = 0.18  # resolutions beside its peak a line has 90 % of its power
CHANCE = 0.05  # probability up to which chance is not believed
MOST_LINES = 24  # that are looked for


def placed_lines(
    runs: Sequence[Run], limit: float, highest: float | None, false_alarm: float, turning: Clocks | None = None
) -> tuple[list[FoundLine], float]:  # fmt: skip
    """Lines of runs whose samples show orders up to a limit, and the number that most are multiples of (0: none)."""
    top = min(HIGHEST_ORDER, limit) if highest is None else number("highest", highest, positive=True)
    if top > limit:
        raise ValueError(f"highest order {top:g} is too high; these samples show orders below {limit:.4g}")
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
