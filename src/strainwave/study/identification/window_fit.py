"""Multiple shooting: least squares over windows of records, each window with a state at its start of its own.

A motion's derivatives by the numbers of the system and by its start are differences of lanes: of the system as it is
and of variants that differ by so little that the outputs change by `EFFECT` of their size.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from ...base.quantities import checked
from ...base.results import Floats, SolveError
from .experiment import Experiment, Record, sizes_of, start_states
from .intervals import without
from .lane_march import Lanes

EFFECT = 1e-6  # of the outputs' size: what a variation of a number changes
FIRST_VARIATION = 1e-6  # of a number, before its effect is known
MOST_VARIATION = 1e-3  # of a number
NO_EFFECT = 1e-12  # of the outputs' size: rounding
DAMPING = 1e-3  # Levenberg's first factor near a solution
WEAK_SHARE = 1e-2  # of what the strongest number changes
LARGEST_DAMPING = 1e8
CONVERGED_SHARE = 1e-2  # of a number's standard deviation, were the residual white
START_SAMPLES = 50  # samples that a start is taken to move
START_DAMPING = 1e-6  # of a start that is fitted alone


@dataclass(frozen=True)
class Window:
    """Samples `first` up to `stop` of a record."""

    record: Record
    first: int
    stop: int

    def __len__(self) -> int:
        return self.stop - self.first


@dataclass(frozen=True)
class Point:
    """Values, starts of all windows, and what follows: residuals and derivatives of each window, in units of noise."""

    values: Floats
    starts: list[Floats]
    residuals: list[Floats]
    by_value: list[Floats]
    by_start: list[Floats]

    def cost(self) -> float:
        """Sum of the squares of the residuals; infinite for a motion that left every bound."""
        with np.errstate(all="ignore"):
            total = float(sum(np.sum(r * r) for r in self.residuals))
        return total if np.isfinite(total) else np.inf

    def reduced(self) -> tuple[Floats, Floats]:
        """Derivatives (n, free) and residuals (n,) with what the starts can do taken out."""
        columns, residuals = [], []
        for r, j, s in zip(self.residuals, self.by_value, self.by_start, strict=True):
            columns.append(without_start(j, s))
            residuals.append(without_start(r[:, None], s)[:, 0])
        return np.concatenate(columns), np.concatenate(residuals)


@dataclass
class LeastSquares:
    """Least squares of an experiment over windows; it learns how far to vary a number.

    Attributes
    ----------
    experiment : Experiment
        The measured records, and the system with its free numbers.
    windows : list of Window
        Samples that are compared, each window from a start of its own.
    noise : (outputs,) array
        Size of the noise of each output.
    parts : int
        Steps between two samples.
    variations : (free,) array
        Change of each number in its variant.
    unmeasured_sizes : (states,) array
        Sizes of the states as computed in the first window, for those that were not measured.
    prepared : dict
        Inputs and outputs of each record by the delays for which they were prepared.
    """

    experiment: Experiment
    windows: list[Window]
    noise: Floats
    parts: int
    variations: Floats = field(default_factory=lambda: np.zeros(0))
    unmeasured_sizes: Floats = field(default_factory=lambda: np.zeros(0))
    prepared: dict[Any, Any] = field(default_factory=dict)

    def begin(self, values: Floats) -> Point:
        """Values with starts from the measured outputs."""
        of = self.experiment.of_outputs(values)
        starts = []
        for window in self.windows:
            outputs = (window.record.outputs - of["offset"][:, None]) / of["gain"][:, None]
            starts.append(start_states(self.experiment, outputs, window.first, window.record.step))
        w, start = self.windows[0], starts[0]
        lanes = self.experiment.lanes([values], w.record.step, self.parts)
        seen = self._run(w, self._prepared(w.record, values)[0], lanes, start[:, None], np.arange(len(start)))
        size = np.std(seen[:, :, 0], axis=1)  # how large all states become in the first window
        self.unmeasured_sizes = np.where(np.isfinite(size) & (size > 0.0), size, 1.0)
        return self.point_at(values, starts)

    def sizes(self, record: Record) -> Floats:
        """Sizes of the states (states,) of a record, those that were not measured as computed."""
        sizes = sizes_of(self.experiment, record)
        return np.where(sizes > 0.0, sizes, self.unmeasured_sizes if len(self.unmeasured_sizes) else 1.0)

    def point_at(self, values: Floats, starts: Sequence[Floats]) -> Point:
        """Residuals and derivatives at values and starts."""
        if not len(self.variations):
            self.variations = np.where(values != 0.0, FIRST_VARIATION * np.abs(values), FIRST_VARIATION)
            for _ in range(3):
                self._learn(values, starts[0])
        delta = self.variations
        variants = [values, *(values + delta[i] * np.eye(len(values))[i] for i in range(len(values)))]
        step = self.windows[0].record.step
        lanes = self.experiment.lanes(variants + [values] * len(starts[0]), step, self.parts)
        rows = [
            self._window(w, self._prepared(w.record, values), lanes, values, start)
            for w, start in zip(self.windows, starts, strict=True)
        ]
        residuals, by_value, by_start = map(list, zip(*rows, strict=True))
        return Point(values, list(starts), residuals, by_value, by_start)

    def residuals(self, values: Floats, starts: Sequence[Floats]) -> list[Floats]:
        """Residuals alone, of each window."""
        lanes = self.experiment.lanes([values], self.windows[0].record.step, self.parts)
        outputs = self.experiment.of_outputs(values)
        rows = []
        for w, start in zip(self.windows, starts, strict=True):
            pieces, measured, _ = self._prepared(w.record, values)
            seen = self._run(w, pieces, lanes, start[:, None])[:, :, 0]
            model = outputs["offset"][:, None] + outputs["gain"][:, None] * seen
            residual = (model - measured[:, w.first : w.stop]) / self.noise[:, None]
            rows.append(residual[np.isfinite(residual) | ~np.isfinite(seen)])
        return rows

    def _prepared(self, record: Record, values: Floats) -> tuple[Floats, Floats, Floats]:
        """Pieces of the inputs, outputs as they are compared, and their rates."""
        delays = self.experiment.delays(values), self.experiment.of_outputs(values)["delay"]
        key = id(record), tuple(np.concatenate(delays).tolist())
        if key not in self.prepared:
            self.prepared = {old: ready for old, ready in self.prepared.items() if old[0] != id(record)}
            pieces = record.pieces(self.experiment, values, self.parts)
            self.prepared[key] = pieces, *record.shifted(delays[1])
        pieces, outputs, rates = self.prepared[key]
        return pieces, outputs, rates

    def _run(self, w: Window, pieces: Floats, lanes: Lanes, starts: Floats, states: Any = None) -> Floats:
        some = pieces[:, w.first * self.parts : (w.stop - 1) * self.parts]
        begin = w.record.begin + w.first
        seen = self.experiment.seen() if states is None else states
        return lanes.run(starts, np.ascontiguousarray(some), seen, len(w), self.parts, w.record.step, begin)

    def _learn(self, values: Floats, start: Floats) -> None:
        """Set the variations so that each changes the outputs of the first window by `EFFECT` of their size."""
        w, free = self.windows[0], len(values)
        w = Window(w.record, w.first, min(w.stop, w.first + 4000))
        variants = [values, *(values + self.variations[i] * np.eye(free)[i] for i in range(free))]
        lanes = self.experiment.lanes(variants, w.record.step, self.parts)
        pieces = self._prepared(w.record, values)[0]
        seen = self._run(w, pieces, lanes, np.repeat(start[:, None], len(variants), axis=1))
        size = np.sqrt(np.mean(seen[:, :, :1] ** 2, axis=1, keepdims=True)) + 1e-300
        change = np.sqrt(np.max(np.mean(((seen[:, :, 1:] - seen[:, :, :1]) / size) ** 2, axis=1), axis=0))
        good = np.isfinite(change) & (change > NO_EFFECT)
        factor = np.where(good, np.clip(EFFECT / np.where(good, change, 1.0), 1e-4, 1e4), 1.0)
        largest = np.where(values != 0.0, MOST_VARIATION * np.abs(values), np.inf)
        self.variations = np.minimum(self.variations * factor, largest)

    def differences(self, w: Window, values: Floats, lanes: Lanes, start: Floats, by_start: Floats) -> Floats:
        """Differences of lanes (n, lanes - 1) from the first one in a window, in units of noise, the start cleared."""
        pieces, measured, _ = self._prepared(w.record, values)
        seen = self._run(w, pieces, lanes, np.repeat(start[:, None], lanes.table.shape[1], axis=1))
        scale = self.experiment.of_outputs(values)["gain"] / self.noise
        change = scale[:, None, None] * (seen[:, :, 1:] - seen[:, :, :1])
        return without_start(change[np.isfinite(measured[:, w.first : w.stop])], by_start)

    def _window(
        self, w: Window, ready: Any, lanes: Lanes, values: Floats, start: Floats
    ) -> tuple[Floats, Floats, Floats]:  # fmt: skip
        """Residuals (n,) and derivatives by the values (n, free) and the start (n, states) of a window."""
        pieces, measured, rates = ready
        free, states = len(values), len(start)
        outputs = self.experiment.of_outputs(values)
        starts = np.repeat(start[:, None], 1 + free + states, axis=1)
        delta = EFFECT * self.sizes(w.record)
        starts[np.arange(states), 1 + free + np.arange(states)] += delta
        motion = self._run(w, pieces, lanes, starts)
        samples = slice(w.first, w.stop)
        gain, noise = outputs["gain"][:, None], self.noise[:, None]
        residual = (outputs["offset"][:, None] + gain * motion[:, :, 0] - measured[:, samples]) / noise
        by_lane = gain[:, :, None] * (motion[:, :, 1:] - motion[:, :, :1]) / noise[:, :, None]
        by_value, by_start = by_lane[:, :, :free] / self.variations, by_lane[:, :, free:] / delta
        for i, output in enumerate(self.experiment.of_free()):
            if output is None:
                continue
            by_value[:, :, i] = 0.0
            change = {"gain": motion[output[0], :, 0], "offset": 1.0, "delay": -rates[output[0], samples]}[output[1]]
            by_value[output[0], :, i] = change / self.noise[output[0]]
        good = np.isfinite(residual) | ~np.isfinite(motion[:, :, 0])  # what was not measured tells nothing
        return residual[good], by_value[good], by_start[good]


def without_start(columns: Floats, by_start: Floats) -> Floats:
    """Columns (n, m) with what a change of the start can do taken out."""
    return without(by_start / np.maximum(np.linalg.norm(by_start, axis=0), 1e-300), columns)


def solve(
    problem: LeastSquares, point: Point, steps: int, damping: float = DAMPING,
    progress: Callable[[int, float], None] = lambda _i, _c: None, keep_signs: bool = False,
) -> tuple[Point, bool]:  # fmt: skip
    """Minimise the sum of squares from a point by Levenberg and Marquardt's method; and whether it converged.

    Inertias, dampings and a law's numbers keep their signs; where signs are kept all other numbers of the model do too,
    as far from the solution an amplitude could change its own.

    Moré 1978, Lecture Notes in Mathematics 630, 105-116 (scaling by the columns' sizes).
    """
    for i in range(steps):
        progress(i, point.cost())
        columns, residual = point.reduced()
        size = _scale(columns, point.values)
        while True:
            stacked = np.concatenate([columns / size, np.sqrt(damping) * np.eye(len(size))])
            wanted = np.concatenate([-residual, np.zeros(len(size))])
            if not np.all(np.isfinite(stacked)):
                raise SolveError(
                    "the motion diverges close to the present numbers; use other start values, or fix some of them"
                )
            change = np.linalg.lstsq(stacked, wanted, rcond=None)[0] / size
            if keep_signs:
                change = problem.experiment.without_crossing(point.values, change)
            change = problem.experiment.within_bounds(point.values, change)
            trial = _stepped(problem, point, change, damping)
            if trial is not None and trial.cost() < point.cost():
                break
            damping *= 10.0
            if damping > LARGEST_DAMPING:
                return point, small(columns, residual, change)
        damping = max(damping / 10.0, 1e-12)
        done = small(columns, residual, change)
        point = trial
        if done:
            return point, True
    return point, False


def _scale(columns: Floats, values: Floats) -> Floats:
    """Sizes of the columns; of one that hardly tells its number as if the number told `WEAK_SHARE` of the strongest."""
    size = np.linalg.norm(columns, axis=0)
    share = size * np.abs(values)
    least = WEAK_SHARE * np.max(share, initial=0.0) / np.where(values != 0.0, np.abs(values), np.inf)
    return np.where(np.maximum(size, least) > 0.0, np.maximum(size, least), 1.0)


def small(columns: Floats, residual: Floats, change: Floats, share: float = CONVERGED_SHARE) -> bool:
    """True if a change is below a share of the standard deviations that white residuals would give."""
    singular = np.linalg.svd(columns, compute_uv=True, full_matrices=False)
    spread = singular[2].T / np.where(singular[1] > 0.0, singular[1], np.inf)
    deviation = np.sqrt(np.sum(residual * residual) / len(residual) * np.sum(spread * spread, axis=1))
    return bool(np.all(np.abs(change) <= share * deviation + 1e-14))


def _stepped(problem: LeastSquares, point: Point, change: Floats, damping: float) -> Point | None:
    """The point after a change of the values, and a damped change of the starts with it; None outside the model."""
    starts = []
    rows = zip(problem.windows, point.residuals, point.by_value, point.by_start, point.starts, strict=True)
    for w, r, j, s, start in rows:
        size = problem.sizes(w.record)
        held = np.sqrt(damping * min(len(r), START_SAMPLES)) * np.eye(len(start))
        stacked, wanted = np.concatenate([s * size, held]), np.concatenate([r + j @ change, np.zeros(len(start))])
        starts.append(start - np.linalg.lstsq(stacked, wanted, rcond=None)[0] * size)
    try:
        checked(problem.experiment.fitted(point.values + change))
        return problem.point_at(point.values + change, starts)
    except ValueError:  # a value that the model refuses
        return None


def windows_of(records: Sequence[Record], length: int) -> list[Window]:
    """All windows of so many samples of all records."""
    return [
        Window(record, first, min(first + length, len(record)))
        for record in records
        for first in range(0, max(len(record) - length // 2, 1), length)
    ]


def reweighted(problem: LeastSquares, point: Point) -> LeastSquares:
    """The problem with the noise of each output from its residuals."""
    total, counts = np.zeros(len(problem.noise)), np.zeros(len(problem.noise))
    for w, r in zip(problem.windows, point.residuals, strict=True):
        many = np.sum(np.isfinite(w.record.outputs[:, w.first : w.stop]), axis=1)
        total += [np.sum(part**2) for part in np.split(r, np.cumsum(many)[:-1])]
        counts += many
    return replace(problem, noise=problem.noise * np.sqrt(total / np.maximum(counts, 1)))


def finite(point: Point) -> Point:
    """The point, unless its motion left every bound (SolveError)."""
    if not np.isfinite(point.cost()):
        raise SolveError("the motion diverged from the start values; use others, for example with more damping")
    return point


@np.errstate(over="ignore", invalid="ignore", divide="ignore")  # as `identify`
def fitted_start(of: Experiment, values: Floats, record: Record, samples: int, parts: int) -> Floats:
    """State at the first sample from so many measured ones."""
    measured = [row[np.isfinite(row)] for row in record.outputs]
    noise = np.array([float(np.std(row)) or 1.0 if len(row) else 1.0 for row in measured])
    problem = LeastSquares(of, [Window(record, 0, samples)], noise, parts)
    point = finite(problem.begin(values))
    for _ in range(10):
        trial = _stepped(problem, point, np.zeros(len(values)), START_DAMPING)
        if trial is None or not trial.cost() < point.cost():
            break
        point = trial
    return point.starts[0]
