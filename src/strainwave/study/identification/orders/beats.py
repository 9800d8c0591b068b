"""Lines of two turns that beat: one line or two, which pair of turns each belongs to, and how long a run must be.

A gear has the turn of its motor and that of its output. A line of the pair (j, k) is A cos(j theta_1 + k theta_2 +
phase), theta_2 = theta_1/ratio. What repeats with the wave generator against a fixed spline has the pair (j, 0),
against the spline that turns (j, -j); both beat j times per turn of the output.
"""

import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from ....base.quantities import number, shown
from ....base.results import Floats, Integers
from ....model.orders import Turn, whole_ratio
from ..run import Run
from .line_gains import SEARCH_STEP, LineGains, misfit
from .order_fit import SAME_SPEED, fit_run
from .order_search import FoundLine, Pair, chance_of

BEATS = 0.5  # beats that a run must hold to part two lines
SEARCH_WIDTH = 8.0  # resolutions beside a line where a second is looked for
SMALLEST_N, LARGEST_N = 29.0, 161.0  # ratios that are looked for without a ratio
PAIR_CHANCE, SECOND_SHARE = 0.01, 0.5  # probability that one line looks like two; share of a line that a second has
USUAL_ORDERS, LOBE_ORDERS = (1, 2, 4, 6, 8), (2, 4, 6, 8, 10, 12)  # of a wave generator; that both splines can have
OUTPUT_ORDERS, LINE_GAP = 4, 1.3  # lines of the output's turn alone; resolutions: lines that are nearer are one
WHOLE_DEVIATIONS = 3.0  # fewer leave whole orders where noise moved them most, and phases at angle 0 with them


class Clocks(NamedTuple):
    """Two turns: the motor's, and the output's, which is slower by a ratio (negative: it turns the other way)."""

    ratio: float
    shaft: Turn  # whose angle the runs have

    def order(self, pair: Pair) -> float:
        """Order of a pair on the angle of the runs."""
        j, k = pair
        return abs(j * self.ratio + k) if self.shaft == "output" else abs(j + k / self.ratio)

    def pairs(self, lowest: float, highest: float) -> dict[Pair, float]:
        """Pairs with their orders between two: of the wave generator against either spline, and of the output."""
        count = int(highest / self.order((1, 0))) + 1
        pairs = [(j, k) for j in range(1, count + 1) for k in ((0, -j, j) if j in LOBE_ORDERS else (0,))]
        pairs += [(0, k) for k in range(1, OUTPUT_ORDERS + 1)]
        return {pair: self.order(pair) for pair in pairs if lowest <= self.order(pair) <= highest}

    def beat(self, pair: Pair) -> float:
        """Turns of the runs' angle in which the lines of a wave generator beat once against both splines."""
        return 1.0 / abs(self.order(pair) - self.order((pair[0], 0 if pair[1] else -pair[0])))


def clocks(ratio: float | None, shaft: Turn) -> Clocks | None:
    """Both turns of a gear of this ratio; None without one."""
    if shaft not in ("motor", "output"):
        raise ValueError(f"shaft is {shown(shaft)}; it is 'motor' or 'output', whose angle the runs have")
    given = 0.0 if ratio is None else number("ratio", ratio)
    if ratio is None and shaft != "motor":
        raise ValueError(f"shaft is {shown(shaft)}, which counts with a ratio alone; give the ratio")
    return None if ratio is None else Clocks(math.copysign(whole_ratio(abs(given)), given), shaft)


def _gains_around(
    runs: Sequence[Run], places: Floats, neighbours: Sequence[FoundLine], order: float, pairs: int = 0,
    loose: bool = False,
) -> LineGains:  # fmt: skip
    """Places around an order: the first ones of pairs, and others that are apart from the neighbours."""
    turns = [line.place for line in neighbours if line.kind != "frequency"]
    standing = [line.place for line in neighbours if line.kind == "frequency"]
    resolution = 1.0 / max(run.turns for run in runs)
    free = np.min(np.abs(places[:, None] - turns), axis=1, initial=np.inf) >= resolution
    free = (free & (places > resolution)) | (np.arange(len(places)) < pairs)
    orders = sorted({order, *turns})
    top = 1.2 * orders[-1] + 20.0 / min(run.turns for run in runs)
    estimates = [fit_run(run, orders, 0.0, top, standing).floor.estimates(order) for run in runs]
    noise = [(0.25 * len(run.time) * float(m[0]), float(f[0])) for run, (m, f) in zip(runs, estimates, strict=True)]
    return LineGains(runs, places[free], neighbours, noise, loose)


def completed(
    runs: Sequence[Run], lines: Sequence[FoundLine], turning: Clocks | None, false_alarm: float,
    span: tuple[float, float],
) -> list[FoundLine]:  # fmt: skip
    """Lines with those of the wave generator that stand out at their places, and two in the place of one that beats."""
    turns, once = max(run.turns for run in runs), 1.0 if turning is None else turning.order((1, 0))
    complete, present = list(lines), [line.place for line in lines if line.kind != "frequency"]
    usual = [j * once for j in USUAL_ORDERS if span[0] <= j * once <= span[1]]
    lacking = [k for k in usual if all(abs(k - order) * turns > LINE_GAP for order in present)]
    while lacking:
        tried = [_tested(runs, complete, k, turning, len(usual)) for k in lacking]
        best = min(range(len(tried)), key=lambda i: tried[i].false_alarm)
        if not tried[best].false_alarm < false_alarm:
            break
        complete.append(tried[best])
        del lacking[best]
    return _with_beats(runs, complete, turning)


def _grid(order: float, turning: Clocks | None, turns: float) -> tuple[Floats, float]:
    """Places of two lines around an order, and how far from it; the order alone where the runs cannot part them."""
    if turning is not None or order >= SMALLEST_N or order / LARGEST_N * turns < BEATS:
        return np.array([order]), 0.0
    reach = SEARCH_STEP * math.ceil(min(SEARCH_WIDTH, turns * order / SMALLEST_N) / SEARCH_STEP) + 1.0
    return order + np.arange(-reach, reach + SEARCH_STEP / 2.0, SEARCH_STEP) / turns, reach / turns


def _tested(
    runs: Sequence[Run], lines: Sequence[FoundLine], order: float, turning: Clocks | None, trials: int
) -> FoundLine:  # fmt: skip
    """The line of an order, alone or with one that beats with it, and the probability that noise has it."""
    turns = max(run.turns for run in runs)
    (places, reach), group = _grid(order, turning, turns), _group(order, turning, turns)
    if group:
        places, reach = np.array(list(group.values())), 0.0
    fit = _gains_around(runs, places, lines, order, len(group), loose=True)
    alone = fit.sure(float(fit.gains(np.array([[int(np.argmin(np.abs(fit.places - order)))]]))[0]))
    alarm = chance_of(alone, trials, len(runs), between=False)
    if len(places) > 1:
        both = fit.sure(float(np.max(fit.gains(_pairs_half_a_beat_apart(fit, order)))))
        alarm = min(alarm, chance_of(both, trials * max(3.0, 2.0 * reach * turns), 2 * len(runs)))
    speeds = np.abs([run.speed for run in runs])
    several = float(np.ptp(speeds)) > SAME_SPEED * float(np.max(speeds))
    error = math.sqrt(6.0 / max(alone, 1.0)) / (2.0 * np.pi * turns)
    return FoundLine(order, error, "order" if several else "undecided", 0.0, alarm)


def _pairs_half_a_beat_apart(fit: LineGains, order: float) -> Integers:
    """Indices (m, 2) of places that half a beat parts, as far apart as the turns of some gear put lines."""
    turns = max(run.turns for run in fit.runs)
    first, second = np.triu_indices(len(fit.places), 1)
    apart = np.abs(fit.places[second] - fit.places[first])
    return np.column_stack([first, second])[(apart * turns > 0.99 * BEATS) & (apart <= max(order / SMALLEST_N, BEATS))]


def _with_beats(runs: Sequence[Run], lines: Sequence[FoundLine], turning: Clocks | None) -> list[FoundLine]:
    """Lines with their pairs, and two in the place of one where the runs hold two that beat."""
    turns, remaining = max(run.turns for run in runs), list(lines)
    for line in lines:
        if line.kind == "frequency" or line not in remaining:
            continue
        group = _group(line.place, turning, turns)
        if short := _group(line.place, turning, turns, short=True):
            members = [k for k in remaining if k.kind != "frequency" and _beside(k.place, short, turns)]
            first = members[0] if len(members) == 1 else line._replace(place=short[next(iter(short))])
            reach = max(abs(member.place - first.place) for member in members)
            remaining = [k for k in remaining if k not in members] + [first._replace(pairs=tuple(short), reach=reach)]
        elif group or len(_grid(line.place, turning, turns)[0]) > 1:
            remaining = _resolved(runs, line, remaining, turning, group)
    return sorted(remaining, key=lambda line: line.place)


def _resolved(
    runs: Sequence[Run], line: FoundLine, lines: list[FoundLine], turning: Clocks | None, group: dict[Pair, float]
) -> list[FoundLine]:  # fmt: skip
    """Lines with one or two in the place of those around a line; frequencies there may be the second one too."""
    turns = max(run.turns for run in runs)
    centres, width = np.array([*group.values()] or [line.place]), (3.0 if turning is None else LINE_GAP) / turns
    members = [k for k in lines if k.kind != "frequency" and np.min(np.abs(k.place - centres)) <= width]
    if line not in members or len(members) > 2 or any(member.joint for member in members):
        return lines  # a line beside its group is one of its own
    once = np.array([2.0 * np.pi / abs(run.speed) for run in runs])  # order of 1 Hz
    standing = [
        k for k in lines if k.kind == "frequency" and np.min(np.abs(k.place * once - centres[:, None])) <= width
    ]
    places, reach = _grid(line.place, turning, turns)
    if group:
        places = np.array([*group.values(), *(line.place + np.arange(-2.0, 2.0, SEARCH_STEP) / turns)])
    for taken in [[*members, *standing], members] if standing else [members]:
        neighbours = [k for k in lines if k not in taken]
        fit = _gains_around(runs, places, neighbours, line.place, len(group))
        new = _of_ratio(fit, members, group) if group else _of_any_ratio(fit, members, reach * turns)
        complete = [*neighbours, *new]
        if taken == members or misfit(runs, complete) < misfit(runs, lines):
            return complete
    return lines


def _group(order: float, turning: Clocks | None, turns: float, *, short: bool = False) -> dict[Pair, float]:
    """Pairs of the wave generator's lines around an order, if the runs can part them, or cannot; else none."""
    j = 0 if turning is None else max(1, round(order / turning.order((1, 0))))
    if turning is None or j not in LOBE_ORDERS or short != (turns < BEATS * turning.beat((j, 0))):
        return {}
    group = {pair: turning.order(pair) for pair in ((j, 0), (j, -j), (j, j))}
    if turns * abs(turning.order((j, 1)) - group[j, 0]) > 2.0 * BEATS:  # sidebands
        group |= {pair: turning.order(pair) for pair in ((j, -1), (j, 1))}
    return group if _beside(order, group, turns) else {}


def _beside(order: float, group: dict[Pair, float], turns: float) -> bool:
    """True if an order is within a resolution of those of a group."""
    return min(group.values()) - 1.0 / turns < order < max(group.values()) + 1.0 / turns


def _of_any_ratio(fit: LineGains, members: Sequence[FoundLine], places: float) -> list[FoundLine]:
    """One line or two at any place, as far apart as both turns of some gear put them."""
    turns = max(run.turns for run in fit.runs)
    single = fit.gains(np.arange(len(fit.places))[:, None])
    index_pairs = _pairs_half_a_beat_apart(fit, members[0].place)
    both = fit.gains(index_pairs)
    best, member = index_pairs[int(np.argmax(both))], int(np.argmax(single))
    chance = chance_of(fit.sure(float(np.max(both) - single[member])), 2.0 * places, len(fit.runs))
    if chance >= PAIR_CHANCE:
        return [members[0]._replace(second=_largest_second(fit, member, best))] if len(members) == 1 else list(members)
    settled, errors = fit.settled(fit.places[best], np.ones(2, dtype=bool))
    apart = float(np.ptp(settled))
    if apart * turns < BEATS or np.inf in errors or np.max(np.abs(settled - fit.places[best])) * turns > 1.0:
        return [line._replace(second=1.0) for line in members]
    reach = np.minimum(WHOLE_DEVIATIONS * errors, 0.4 * apart)
    orders = np.where(np.abs(settled - np.round(settled)) <= reach, np.round(settled), settled)
    loose = orders != np.round(orders)
    if loose.any() and not loose.all():
        orders, closer = fit.settled(orders, loose)
        errors[loose] = closer[loose]
    return [
        members[0]._replace(place=k, error=2.0 * e, joint=True)
        for k, e in zip(orders.tolist(), errors.tolist(), strict=True)
    ]


def _largest_second(fit: LineGains, member: int, both: Sequence[int]) -> float:
    """Amplitude of a second line that the runs do not exclude (95 %), over that of the single line."""
    size, error = min(fit.amplitude(both, i) for i in (0, 1))
    return (size + 2.0 * error) / fit.amplitude([member], 0)[0]


def _of_ratio(fit: LineGains, members: Sequence[FoundLine], group: dict[Pair, float]) -> list[FoundLine]:
    """Lines of the pairs of one group: those without which noise does not explain the runs."""
    pairs = list(group)
    single = fit.gains(np.arange(len(fit.places))[:, None])
    chosen = [int(np.argmax(single[: len(pairs)]))]
    gain = float(single[chosen[0]])
    while len(chosen) < len(pairs):
        others = [i for i in range(len(pairs)) if i not in chosen]
        more = fit.gains(np.array([[*chosen, i] for i in others]))
        step = fit.sure(float(np.max(more)) - gain)
        if chance_of(step, len(others), len(fit.runs), between=False) >= PAIR_CHANCE:
            break
        chosen, gain = [*chosen, others[int(np.argmax(more))]], float(np.max(more))
    if np.max(single) > gain + 2.0 * len(chosen) + 1.0:
        return list(members)  # a line of another place
    names = _likely_pairs(fit, chosen, pairs, single) if len(chosen) == 1 else [(pairs[i],) for i in chosen]
    shared = members[0]._replace(error=0.0, reach=0.0)
    return [shared._replace(place=group[pairs[i]], pairs=some) for i, some in zip(chosen, names, strict=True)]


def _likely_pairs(fit: LineGains, chosen: list[int], pairs: list[Pair], single: Floats) -> list[tuple[Pair, ...]]:
    """Pair of a single line, with those that are as likely alone or beside it (Laplace's approximation)."""
    (first,) = chosen
    named, size = [pairs[first]], fit.amplitude([first], 0)[0]
    for i, pair in enumerate(pairs):
        if i != first:
            _, error = fit.amplitude([first, i], 1)
            more = float(fit.gains(np.array([[first, i]]))[0]) - float(single[first])
            together = fit.sure(more) - math.log1p(0.5 * (size / error) ** 2)
            if max(together, float(single[i]) - float(single[first]) + math.log(20.0)) > 0.0:
                named.append(pair)
    return [tuple(named)]


def named(line: FoundLine, turning: Clocks | None, runs: Sequence[Run]) -> FoundLine:
    """The line with all pairs that the runs cannot tell apart at its place."""
    if turning is None or line.kind == "frequency" or line.pairs:
        return line
    reach = BEATS / max(run.turns for run in runs)
    pairs = turning.pairs(max(line.place - reach, 0.0), line.place + reach)
    return line._replace(pairs=tuple(sorted(pairs, key=lambda pair: abs(pairs[pair] - line.place))))


def unparted(lines: Sequence[FoundLine], turning: Clocks | None, runs: Sequence[Run]) -> Iterator[str]:
    """Sentence on lines over the angle that runs are too short for, and the length that they need."""
    turns, lasting = max(run.turns for run in runs), f"{max(run.turns for run in runs):.3g} turns"
    short = [line for line in lines if not line.joint and turns * line.place / LARGEST_N < BEATS]
    if turning is None and short:
        yield (
            f"{lasting} cannot separate lines closer than {BEATS / turns:.2g} orders: order "
            f"{', '.join(f'{line.place:.4g}' for line in short)} may be two, of the wave generator against "
            "either spline; give the ratio, and run over half of their beat at least, which is a quarter of an output "
            "turn for order 2 of the motor, or over a whole one for separate intervals"
        )
    for line in lines:
        if line.second >= SECOND_SHARE:
            yield (
                f"order {line.place:.4g} may be two lines, the second of up to {line.second:.2g} times the amplitude"
            )
        if len(line.pairs) > 1 and turning is not None:
            beat = turning.beat(next((pair for pair in line.pairs if pair[0]), (0, 1)))
            yield (
                f"order {line.place:.6g} is one line or more of the pairs {', '.join(map(str, line.pairs))} (turns of "
                f"motor and output): {lasting} cannot separate them; the pairs beat every {beat:.4g} turns, "
                "half of which separate them and one of which gives each an interval of its own"
            )
