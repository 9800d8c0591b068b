"""The search for gains: points spread over a box, descents from the best, and a proof that no step is better.

Steps of one or two gains end where several crests are equally high and each step raises one of them. There all gains
are changed at once, by linear programs of the crests and the limits.

Madsen 1975, An algorithm for minimax solution of overdetermined systems of non-linear equations, J. Inst. Maths Applics
16, 321-328; Fletcher 1987, Practical Methods of Optimization, sec. 14.4 (limits that bend).
"""

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from itertools import combinations, islice, product
from math import inf, nan
from typing import Any

import numpy as np

from ...base.results import Floats
from ..pareto import unbeaten
from .cost import NO_EXTRAS, Extras, Trial, TuningPoint
from .loop import with_control

SPREAD, TRIED, STARTS = 400, 12, 3  # points of the box with linear figures, of these with responses, and descents
COARSE, FINE, PROOF = (0.5, 0.2), (0.1, 0.04), (0.2, 0.05, 0.02)  # relative changes of gains
WORTH, SMALL, GAINED = 0.02, 0.003, 0.008  # of the measure: what a coarse, a fine and a proving step must gain
INSIDE = 1e-9
# Measures of gains that do not count: outside the box, given up above a bound, with a broken limit, too sensitive.
OUTSIDE, EXCEEDED, BROKEN, FRAGILE = inf, inf, inf, inf
Box = tuple[Floats, Floats]
MANY_DRIVES = 8  # drives from which on no points are computed to the end for the front alone
REACH, SHORTEST = 0.3, 0.01  # of the logarithm of a gain: the longest step of all at first, and in the end
LONGER, SHORTER = 2.0, 0.4  # times the longest step, after one that keeps half of its promise, and one that is no help
ROUNDS = 40
CHOICES = 20  # gains that are tried where the best are not sturdy
COUNTED = 0.7  # of the highest crest: lower ones do not count
DIFFERENCE = 1e-3  # of a gain, of slopes
PROMISED = 1e-3  # of the measure: a program that promises less is the last
WITHIN, CORRECTIONS = 1e-6, 4  # share of a limit that a step leaves, and how often it is corrected for this
LITTLE = 1e-3  # share of a limit that does not count


class Search:
    """The search of one trial in a box of logarithms of gains (low, high); every point is computed once.

    `reference` has the goals by which they are divided before they count together, `extras` what is computed beside
    them. Where it is `sturdy`, gains do not count of which 5 % more or less cost more than 20 % of compliance or
    settling.
    """

    def __init__(self, trial: Trial, box: Box, reference: Floats, extras: Extras = NO_EXTRAS, sturdy: bool = False):
        self.trial, self.low, self.high, self.extras, self.sturdy = trial, *box, extras, sturdy
        self.reference = np.where(np.isfinite(reference) & (reference > 0.0), reference, 1.0)
        self.computed: dict[tuple[float, ...], TuningPoint] = {}

    def measure(self, x: Floats, bound: float = inf) -> float:
        """Mean logarithm of the goals; infinite, as OUTSIDE, EXCEEDED, BROKEN and FRAGILE name it, of what is none."""
        if np.any(x < self.low - INSIDE) or np.any(x > self.high + INSIDE):
            return OUTSIDE
        key = tuple(x.round(12).tolist())
        if key not in self.computed:
            point = self.trial.evaluate(
                x, self.extras, lambda goals: self._mean(goals) > bound and self._beaten(goals, x)
            )
            if point is None:
                return EXCEEDED
            self.computed[key] = point
        value = self.measure_of(self.computed[key])
        fragile = self.sturdy and value < bound and not self.trial.sturdy(x, self.trial.linear)
        return FRAGILE if fragile else value

    def sturdiest(self, best: Floats) -> Floats:
        """Best gains that stay about as good where one is 5 % more or less; the best of all if none does."""
        value = self.measure(best)
        measures = {key: self.measure_of(point) for key, point in self.computed.items()}
        others = sorted((other, key) for key, other in measures.items() if value < other < inf)
        point = partial(self.trial.point, extras=self.extras)
        candidates = [best, *(np.array(key) for _, key in others[:CHOICES])]
        return next((x for x in candidates if self.measure(x) < inf and self.trial.sturdy(x, point)), best)

    def measure_of(self, point: TuningPoint) -> float:
        """The measure of a point; BROKEN where it breaks a limit."""
        broken = max(point.used(self.trial.setting.limits).values()) > 1.0
        return BROKEN if broken else self._mean(np.array(point.goals))

    def _beaten(self, goals: Floats, x: Floats) -> bool:
        """True for goals that a computed point beats, its peak sensitivity too; always of many drives."""
        if len(self.trial.drives) > MANY_DRIVES:
            return True
        peak = self.trial.linear(x).figures.peak_sensitivity
        return any(p.figures.peak_sensitivity <= peak and np.all(p.goals <= goals) for p in self.computed.values())

    def _mean(self, goals: Floats) -> float:
        with np.errstate(divide="ignore"):
            return float(np.mean(np.log(goals / self.reference)))

    def run(self, starts: Sequence[Floats], progress: Callable[[str, float], None]) -> Floats:
        """Best gains of all, from the starts and points of the box; the starts lie in the box."""
        from scipy.stats import qmc  # a second of every start that a search alone waits for

        sown = self.low + qmc.Halton(len(self.low), scramble=False).random(SPREAD + 1)[1:] * (self.high - self.low)
        begins: list[Floats] = [*starts, *islice((x for x in sown if self.trial.fits(x)), TRIED)]
        values: list[float] = []
        for x in begins:
            values.append(self.measure(x, sorted(values)[STARTS - 1] if len(values) >= STARTS else inf))
        ends = []
        for i, index in enumerate(np.argsort(values, kind="stable")[:STARTS]):
            progress(f"descent {i + 1} of {STARTS}", 0.2 + 0.15 * i)
            ends.append(self.descend(begins[index], COARSE, WORTH))
        progress("fine steps", 0.6)
        x = self.refine(min(ends, key=self.measure))
        progress("proof", 0.7)
        return self.descend(x, PROOF, GAINED, mixed=True)

    def refine(self, x: Floats) -> Floats:
        """Lower the measure by steps of all gains; by those of one or two where goals are not largest values."""
        goals, share = self.trial.setting.goals, self.trial.setting.share
        if share < 1.0 or not {*goals} <= {"pointing", "compliance"}:
            return self.descend(x, FINE, SMALL)
        reach, best = REACH, self.measure(x)
        for _ in range(ROUNDS):
            step, promised = self._program(x, reach)
            if promised > best - PROMISED:
                break
            value = self.measure(x + step, best)
            if value < best:
                reach *= LONGER if best - value > 0.5 * (best - promised) else 1.0
                x, best = x + step, value
            elif (reach := SHORTER * reach) < SHORTEST:
                break
        return x

    def _program(self, x: Floats, reach: float) -> tuple[Floats, float]:
        """The step that lowers the measure most by the slopes of its parts at x, and the measure by them after it.

        Limits are kept where the step ends, not by their slopes alone.
        """
        from scipy.optimize import linprog

        crests, count = self._highest(x), len(self.reference)
        values, of_goal, shares = self._parts(x, crests)
        beside = [self._parts(x + DIFFERENCE * unit, crests) for unit in np.eye(len(x))]
        slopes = np.array([part[0] - values for part in beside]).T / DIFFERENCE
        tilts = np.array([part[2] - shares for part in beside]).T / DIFFERENCE
        rows = np.block([[slopes, -of_goal], [tilts, np.zeros((len(shares), count))]])
        if not np.all(np.isfinite(rows)):  # a crest is lost, or the loop unstable, a little beside x
            return 0.0 * x, inf
        cost, bent = np.append(0.0 * x, np.full(count, 1.0 / count)), 0.0 * shares
        box = [*zip(np.maximum(self.low - x, -reach), np.minimum(self.high - x, reach), strict=True)]
        for _ in range(CORRECTIONS):
            solution = linprog(
                cost, rows, -np.concatenate([values, shares + bent]), bounds=box + [(None, None)] * count
            )
            if solution.status:
                return 0.0 * x, inf
            step = solution.x[: len(x)]
            after = self._parts(x + step, [])[2]
            if np.all(after <= 0.0) or not np.all(np.isfinite(after)):
                break
            bent = bent + np.maximum(after, 0.0) + WITHIN
        return step, float(solution.fun)

    def _highest(self, x: Floats) -> list[Any]:
        """Numbers of drive and load with a crest of it: the crests about as high as the highest with these gains."""
        crests = self.trial.crests if "pointing" in self.trial.setting.goals else {}
        every = [(case, crest) for case, some in crests.items() for crest in some]
        sizes = self._parts(x, every)[0][: len(every)]
        return [every[i] for i in np.flatnonzero(sizes > np.fmax.reduce(sizes, initial=-inf) + np.log(COUNTED))]

    def _parts(self, x: Floats, crests: Sequence[Any]) -> tuple[Floats, Floats, Floats]:
        """Logarithms (m,) of the parts of goals, 1 for the goal of each (m, goals), and those of the limits' shares."""
        trial, control, linear = self.trial, self.trial.control(x), self.trial.linear(x)
        goals, limits = trial.setting.goals, trial.setting.limits
        sizes = [crest.size_of(with_control(trial.loaded[i][k], control).train) or nan for (i, k), crest in crests]
        names = ["pointing"] * len(sizes) + [name for name in goals if name == "compliance"]
        of_goal = np.array([[name == goal for goal in goals] for name in names], float).reshape(-1, len(goals))
        sizes += [linear.figures.compliance] * (len(names) - len(sizes))
        values = np.log(sizes) - of_goal @ np.log(self.reference)
        return values, of_goal, np.log([max(share, LITTLE) for share in linear.used(limits).values()])

    def descend(self, x: Floats, sizes: Sequence[float], worth: float, mixed: bool = False) -> Floats:
        """Take steps of one or two gains as long as one gains so much; pairs have one size, or any (`mixed`)."""
        for group in [sizes] if mixed else [(size,) for size in sizes]:
            steps, best, k = list(moves(len(x), group)), self.measure(x), 0
            while k < len(steps):
                value, k = self.measure(x + steps[k], best - worth), k + 1
                if value < best - worth:
                    x, best = x + steps[k - 1], value
                    steps.insert(0, steps.pop(k - 1))  # what helped is tried again
                    k = 0
        return x


def moves(dimension: int, sizes: Sequence[float]) -> Iterator[Floats]:
    """Steps of one or two gains by relative sizes, up and down."""
    steps = [np.log1p(sign * size) for size in sizes for sign in (1.0, -1.0)]
    for row, step in product(np.eye(dimension), steps):
        yield row * step
    for (row, second), step, along in product(combinations(np.eye(dimension), 2), steps, steps):
        yield row * step + second * along


def least_broken(trial: Trial, x: Floats) -> Floats:
    """Gains that break the linear limits least, by steps of one or two gains."""
    for size in (*COARSE, *FINE):
        before = inf
        while 1.0 < trial.broken(x) < before:
            before = trial.broken(x)
            x = min([x, *(x + step for step in moves(len(x), (size,)))], key=trial.broken)
    return x


def front(search: Search) -> tuple[TuningPoint, ...]:
    """Points within the limits that no other beats in all goals and in the peak sensitivity at once."""
    marks = {(*p.goals, p.figures.peak_sensitivity): p for p in search.computed.values() if search.measure_of(p) < inf}
    return tuple(marks[mark] for mark in unbeaten(marks))
