"""Gains of lines at given orders: how much better they explain runs than the noise does.

The gain of lines is half of what they take from the sum of squares, over the variance of the noise: the logarithm of a
likelihood.
"""

import math
from collections.abc import Sequence

import numpy as np

from ....base.results import Booleans, Floats, Integers
from ..intervals import without
from ..run import Run
from .order_search import FoundLine

SEARCH_STEP = 0.25  # resolutions between two places at which a line is looked for
ROUNDS, CHUNK = 20, 20_000  # of least squares; samples at a time
RIDGE = 1e-9  # of a sample: keeps places solvable that are taken already


class LineGains:
    """Gains of one line or two at places around others, which are taken out with the slow parts of the runs.

    Parameters
    ----------
    runs : sequence of Run
        Runs.
    places : (m,) array
        Orders.
    neighbours : sequence of FoundLine
        Lines that are taken out, and if `loose` what they leave where they are a little beside their places.
    floor : sequence of (float, float)
        For each run the variance of the noise there, and how many values it is from.
    """

    def __init__(
        self, runs: Sequence[Run], places: Floats, neighbours: Sequence[FoundLine],
        floor: Sequence[tuple[float, float]], loose: bool = False,
    ) -> None:  # fmt: skip
        self.runs, self.places, self.floor = runs, places, floor
        self.freedom = min(freedom for _, freedom in floor)
        lowest = float(np.min(places))
        self.nuisances = [_columns(run, neighbours, lowest, loose) for run in runs]
        self.values = [without(q, run.value) for q, run in zip(self.nuisances, runs, strict=True)]
        self.grams, self.parts = [], []
        for run, nuisance, value in zip(runs, self.nuisances, self.values, strict=True):
            basis, many = np.linalg.qr(nuisance)[0], 2 * len(places)
            gram, part, shared = RIDGE * len(value) * np.eye(many), np.zeros(many), np.zeros((basis.shape[1], many))
            for i in range(0, len(value), CHUNK):
                waves = _waves(run.angle[i : i + CHUNK] - run.angle[0], places)
                gram, part = gram + waves.T @ waves, part + waves.T @ value[i : i + CHUNK]
                shared += basis[i : i + CHUNK].T @ waves
            self.grams.append(gram - shared.T @ shared)
            self.parts.append(part)

    def gains(self, chosen: Integers) -> Floats:
        """Gains (m,) of lines at the places of these indices (m, lines), all together."""
        columns = np.stack([2 * chosen, 2 * chosen + 1], axis=-1).reshape(len(chosen), -1)
        total = np.zeros(len(chosen))
        for gram, part, (variance, _) in zip(self.grams, self.parts, self.floor, strict=True):
            solved = np.linalg.solve(gram[columns[:, :, None], columns[:, None, :]], part[columns][..., None])[..., 0]
            total += np.sum(part[columns] * solved, axis=1) / (2.0 * variance)
        return total

    def amplitude(self, chosen: Sequence[int], i: int) -> tuple[float, float]:
        """Mean amplitude in the runs, and its deviation, of line i of those chosen, fitted together."""
        columns = np.array([c for k in chosen for c in (2 * k, 2 * k + 1)])
        sizes, weights = [], []
        for gram, part, (variance, _) in zip(self.grams, self.parts, self.floor, strict=True):
            inverse = np.linalg.inv(gram[np.ix_(columns, columns)])
            of_line = slice(2 * i, 2 * i + 2)
            sizes.append(float(np.linalg.norm((inverse @ part[columns])[of_line])))
            weights.append(2.0 / (variance * float(np.trace(inverse[of_line, of_line]))))
        return float(np.average(sizes, weights=weights)), 1.0 / math.sqrt(sum(weights))

    def sure(self, gain: float) -> float:
        """A gain as if the noise were known."""
        return self.freedom * math.log1p(max(gain, 0.0) / self.freedom)

    def settled(self, places: Floats, loose: Booleans) -> tuple[Floats, Floats]:
        """Places of lines, of those that are loose by least squares from these on, and the deviations of all."""
        nearest, deviations = SEARCH_STEP / max(run.turns for run in self.runs), np.zeros(len(places))
        for _ in range(ROUNDS):
            left, right = np.zeros((sum(loose), sum(loose))), np.zeros(sum(loose))
            for i, (run, value, (variance, _)) in enumerate(zip(self.runs, self.values, self.floor, strict=True)):
                x = run.angle - run.angle[0]
                waves = without(self.nuisances[i], _waves(x, places))
                shares = np.linalg.lstsq(waves, value, rcond=None)[0].reshape(-1, 2)
                turned = x[:, None] * places
                slopes = x[:, None] * (shares[:, 1] * np.cos(turned) - shares[:, 0] * np.sin(turned))
                slopes = without(waves, without(self.nuisances[i], slopes))[:, loose]
                left += slopes.T @ slopes / variance
                right += slopes.T @ value / variance
            change = np.zeros(len(places))
            change[loose] = np.linalg.solve(left, right)  # Gauss-Newton
            places = places + np.clip(change, -nearest, nearest)
            if np.max(np.abs(change)) < 1e-6 * nearest:
                break
        deviations[loose] = np.sqrt([v if v > 0.0 else np.inf for v in np.diag(np.linalg.inv(left)).tolist()])
        return places, deviations


def _waves(x: Floats, places: Floats) -> Floats:
    """Cosine and sine (n, 2 m) of lines, in turn."""
    turned = x[:, None] * places
    return np.stack([np.cos(turned), np.sin(turned)], axis=-1).reshape(len(x), -1)


def _columns(run: Run, lines: Sequence[FoundLine], lowest: float, loose: bool = False) -> Floats:
    """Slow parts, cosines and sines (n, m) of lines; with what they change by where their places do, if loose."""
    turns = [2.0 * np.pi * run.time if line.kind == "frequency" else run.angle for line in lines]
    waves = [_waves(x - x[0], np.array([line.place])) for line, x in zip(lines, turns, strict=True)]
    slopes = [(x - x[0])[:, None] / np.ptp(x) * wave for x, wave in zip(turns, waves, strict=True) if loose]
    return np.column_stack([run.slow_columns(lowest), *waves, *slopes])


def misfit(runs: Sequence[Run], lines: Sequence[FoundLine]) -> float:
    """Misfit of lines and slow parts to the runs: twice the logarithm of the likelihood, less is better."""
    lowest = min(line.place for line in lines if line.kind != "frequency")
    left = [without(_columns(run, lines, lowest), run.value) for run in runs]
    return sum(len(remainder) * math.log(max(float(remainder @ remainder), 1e-300)) for remainder in left)
