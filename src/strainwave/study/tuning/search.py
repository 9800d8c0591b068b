"""Search for gains: points spread over a box, descents from the best of them, and a proof that no step is better.

All is deterministic. A gain is a logarithm in here; the measure is the mean of the logarithms of the goals.
"""

from collections.abc import Callable, Iterator, Sequence
from itertools import combinations, islice, product
from math import inf

import numpy as np
from scipy.stats import qmc

from ...base.results import Floats
from .trial import Trial, TuningPoint

SPREAD, TRIED, STARTS = 400, 12, 3  # points of the box that are linear, of these nonlinear, and descents
COARSE, FINE, PROOF = (0.5, 0.2), (0.1, 0.04), (0.2, 0.05, 0.02)  # relative changes of gains
WORTH, SMALL, GAINED = 0.02, 0.003, 0.008  # of the measure: what a coarse, a fine and a proving step must gain
INSIDE = 1e-9
MANY = 8  # drives from which on no points are computed to the end for the front alone


class Search:
    """The search of one trial in a box of logarithms of gains (low, high); every point is computed once.

    `reference` has the goals by which they are divided before they count together.
    """

    def __init__(self, trial: Trial, box: tuple[Floats, Floats], reference: Floats) -> None:
        self.trial, self.low, self.high = trial, *box
        self.reference = np.where(np.isfinite(reference) & (reference > 0.0), reference, 1.0)
        self.computed: dict[tuple[float, ...], TuningPoint] = {}

    def measure(self, x: Floats, bound: float = inf) -> float:
        """Mean logarithm of the goals; infinite outside the box, where a limit is broken, or if it exceeds a bound."""
        if np.any(x < self.low - INSIDE) or np.any(x > self.high + INSIDE):
            return inf
        key = tuple(x.round(12).tolist())
        if key not in self.computed:
            point = self.trial.kept(x, lambda goals: self._mean(goals) > bound and self._beaten(goals, x))
            if point is None:
                return inf
            self.computed[key] = point
        return self.of(self.computed[key])

    def of(self, point: TuningPoint) -> float:
        """The measure of a point; infinite where it breaks a limit."""
        broken = max(point.used(self.trial.setting.limits).values()) > 1.0
        return inf if broken else self._mean(np.array(point.goals))

    def _beaten(self, goals: Floats, x: Floats) -> bool:
        """Whether a computed point is better in all goals and the peak sensitivity; of many drives it is not asked."""
        if len(self.trial.drives) > MANY:
            return True
        peak = self.trial.linear(x).figures.peak_sensitivity
        return any(p.figures.peak_sensitivity <= peak and np.all(p.goals <= goals) for p in self.computed.values())

    def _mean(self, goals: Floats) -> float:
        with np.errstate(divide="ignore"):
            return float(np.mean(np.log(goals / self.reference)))

    def run(self, starts: Sequence[Floats], progress: Callable[[str, float], None]) -> Floats:
        """Best place of all, from the starts and points of the box; the starts have a place in the box."""
        sown = self.low + qmc.Halton(len(self.low), scramble=False).random(SPREAD + 1)[1:] * (self.high - self.low)
        fit = islice((x for x in sown if self.trial.fits(x)), TRIED)
        begins: list[Floats] = [*starts, *fit]
        values: list[float] = []
        for x in begins:
            values.append(self.measure(x, sorted(values)[STARTS - 1] if len(values) >= STARTS else inf))
        places = []
        for i, place in enumerate(np.argsort(values, kind="stable")[:STARTS]):
            progress(f"descent {i + 1} of {STARTS}", 0.2 + 0.15 * i)
            places.append(self.descend(begins[place], COARSE, WORTH))
        progress("fine steps", 0.6)
        x = self.descend(min(places, key=self.measure), FINE, SMALL)
        progress("proof", 0.7)
        return self.descend(x, PROOF, GAINED, mixed=True)

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
    """Where the linear limits are broken least, by steps of one or two gains."""
    for size in (*COARSE, *FINE):
        before = inf
        while 1.0 < trial.broken(x) < before:
            before = trial.broken(x)
            x = min([x, *(x + step for step in moves(len(x), (size,)))], key=trial.broken)
    return x
