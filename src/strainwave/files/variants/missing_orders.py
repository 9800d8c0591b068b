"""Lines of the kinematic error that a drive has and its file has not, from what an identification leaves.

A line that is missing is seen through the drive: its amplitude and phase change on the way through a resonance. The
model therefore runs with a little of every line, and what that changes is fitted to the residual. What else a model may
lack (a gap, dry friction, asymmetry) repeats with the orders of the file too, and is taken up by lines in part: a line
is one that the drive has only where it leaves little of the residual, and explains more of it than any other term.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from ...base.results import Floats, SolveError
from ...study.identification.discrepancy import white
from ...study.identification.driven import lanes_of
from ...study.identification.experiment import MoreLines, OrderLine
from ...study.identification.identified import Identified, record_of
from ...study.identification.identify import candidate_columns
from ...study.identification.intervals import orthogonal, whitened, whitener
from ...study.identification.orders.order_scan import SHARE, order_scan
from ...study.identification.run import Run
from ...study.identification.windows import LeastSquares, Point, Window, cleared, solve

HIGHEST = 30.0  # order looked for
MOST_LINES = 4  # lines at once
STEPS = 12  # of the iteration with lines
BATCH = 40  # orders that run side by side
LITTLE = 1e-8  # rad: amplitude of a line that is tried
BESIDE = 0.5  # orders: what stands nearer to a line of the file is its modulation
CHANCE = 0.01  # probability that noise alone names an order
COLOURED = 0.01  # probability below which a remainder is no white noise
MASTERS = 3.0  # times what is left beside noise: what a line must explain
BESIDE_LARGEST = 0.02  # of what the largest line explains: less is what that line is followed wrongly by
BETTER = 2.0  # times what another term explains: the same
EXACT = 0.01  # of what the best other term leaves: a line that leaves less is none of its shadows
HIDING = 0.02  # of the motion: what a model leaves of it where lines hide
SAME = 1e-3  # of a column's size: what others leave of it when they can stand for it
AROUND, LOBE = 24, 0.25  # places beside an order that are tried, and how far apart, of 1/turns


class MissingLine(NamedTuple):
    """A line that the file lacks: its order and amplitude [rad], and whether a sensor has it and not the gear."""

    order: float
    amplitude: float
    in_reading: bool


class Place(NamedTuple):
    """Where a line is looked for: an order, in the gear or in what was read."""

    order: float
    in_reading: bool


@dataclass(frozen=True, eq=False)
class Left:
    """A model with these lines at its best numbers, and the motor's angles [rad] of its records."""

    problem: LeastSquares
    point: Point
    angles: tuple[Floats, ...]
    places: tuple[Place, ...]

    def fitted(self) -> tuple[Floats, Floats]:
        """Columns (n, p) of the numbers and of lines that were read, and computed less measured (n,)."""
        base, rest = self.point.reduced()
        read = [place for place in self.places if place.in_reading]
        return (_beside(base, self.columns(read)) if read else base), rest

    def remains(self) -> float:
        """Squares that the model leaves with its lines."""
        base, rest = self.fitted()
        basis = _basis(base)
        return float(np.sum((orthogonal(basis, rest)) ** 2))

    def columns(self, places: Sequence[Place]) -> Floats:
        """Changes (n, places, 2) of the outputs by a cosine and a sine of each place, in units of noise and rad."""
        gear = [place.order for place in places if not place.in_reading]
        parts = iter([part for i in range(0, len(gear), BATCH) for part in self._of_gear(gear[i : i + BATCH])])
        return np.stack([self._of_reading(p.order) if p.in_reading else next(parts) for p in places], axis=1)

    def _of_gear(self, orders: Sequence[float]) -> list[Floats]:
        of, first = self.problem.of, self.problem.windows[0].record
        model = of.model(self.point.values, first.step, self.problem.parts, of.delays(self.point.values))
        lines = model.error.lines
        tried = [OrderLine(k, a, b) for k in orders for a, b in ((LITTLE, 0.0), (0.0, LITTLE))]
        more = [model, *(model._replace(error=model.error._replace(lines=(*lines[:-1], line))) for line in tried)]
        lanes = lanes_of(more)
        rows = zip(self.problem.windows, self.point.starts, self.point.by_start, strict=True)
        every = np.concatenate([self.problem.differences(w, self.point.values, lanes, *own) for w, *own in rows])
        return [every[:, 2 * i : 2 * i + 2] / LITTLE for i in range(len(orders))]

    def _of_reading(self, order: float) -> Floats:
        found = []
        for w, angle, by_start in zip(self.problem.windows, self.angles, self.point.by_start, strict=True):
            own = angle[np.isfinite(w.record.outputs[0])] * order
            found.append(cleared(np.column_stack([np.cos(own), np.sin(own)]) / self.problem.noise[0], by_start))
        return np.concatenate(found)


def missing_lines(fit: Identified, logs: Sequence[Mapping[str, Any]]) -> list[MissingLine]:
    """Lines over the motor's angle that the drive of these logs has and the system found has not, the largest first."""
    file_orders = [float(line.order) for line in getattr(fit.system.error, "lines", ())]
    angles = tuple(np.asarray(log["motor_angle"], float) for log in logs)
    turns = max(float(np.ptp(angle)) / (2.0 * np.pi) for angle in angles)
    orders = [k for k in _orders(fit, logs, angles, turns) if _apart_from(k, file_orders)]
    places = [Place(k, in_reading) for k in orders for in_reading in (False, True)]
    if not places:
        return []
    try:
        left = _left(fit, logs, angles, ())
        while len(left.places) < MOST_LINES:
            taken = [place.order for place in left.places]
            free = [place for place in places if _apart_from(place.order, taken)]
            chosen = _chosen(left, free)[: MOST_LINES - len(left.places)]
            if not chosen:
                break
            exact = [_placed(left, chosen, i, 1.0 / turns) for i in range(len(chosen))]
            added = (place for place in exact if _apart_from(place.order, file_orders))
            more = _best(fit, logs, angles, (*left.places, *added))
            if not more.remains() < left.remains():  # the fit is lost over lines that are not there
                break
            left = more
        return _confirmed(left, len(places)) if left.places else []
    except (SolveError, ValueError):  # a line with which the motion leaves every bound is none
        return []


def hidden(fit: Identified) -> list[str]:
    """That lines may hide in what a model leaves, where it is more than a little and no noise; nothing elsewhere."""
    if fit.discrepancy.white >= COLOURED or not fit.rms[0] > HIDING * fit.size[0]:
        return []
    return ["What the model leaves is no noise: lines of the kinematic error that the file lacks may hide in it."]


def _apart_from(order: float, orders: Sequence[float]) -> bool:
    """Whether an order is at least BESIDE away from each of others."""
    return all(abs(order - other) >= BESIDE for other in orders)


def _orders(
    fit: Identified, logs: Sequence[Mapping[str, Any]], angles: Sequence[Floats], turns: float
) -> list[float]:  # fmt: skip
    """Orders to look at: whole ones, and what a scan of the residual adds."""
    runs, begin, scanned = [], 0, []
    resolved = min(SHARE * len(angle) / max(float(np.ptp(angle)) / (2.0 * np.pi), 1e-9) for angle in angles)
    highest = min(HIGHEST, 0.99 * resolved)
    try:
        for log, angle in zip(logs, angles, strict=True):
            residual = fit.residual[0][begin : begin + len(angle)]
            begin += len(angle)
            finite = np.isfinite(residual)
            runs.append(Run(np.asarray(log["time"], float)[finite], angle[finite], residual[finite], "rad"))
        scanned = [line.order for line in order_scan(runs, highest=highest).lines if line.kind != "frequency"]
    except ValueError:  # too short, or no way in one direction: whole orders do
        pass
    whole = [float(k) for k in range(1, math.floor(highest) + 1)]
    return whole + [k for k in scanned if abs(k - round(k)) * turns > 1.0]


def _left(
    fit: Identified, logs: Sequence[Mapping[str, Any]], angles: tuple[Floats, ...], places: tuple[Place, ...]
) -> Left:  # fmt: skip
    """The model found, or with these lines and solved again."""
    gear = [place.order for place in places if not place.in_reading]
    lines = [OrderLine(k, 0.0, 0.0) for k in gear] + [OrderLine(1.0, 0.0, 0.0)] * (MOST_LINES + 1 - len(gear))
    experiment = fit.experiment
    models = experiment.system, experiment.driven
    system, driven = [model._replace(error=MoreLines(model.error, tuple(lines))) for model in models]
    free = [f"error.{path}" if path.startswith("error.") else path for path in experiment.free]
    more = [f"error.lines.{i}.{part}" for i in range(len(gear)) for part in ("cosine", "sine")]
    experiment = replace(experiment, system=system, driven=driven, free=(*free, *more))
    records = [record_of(experiment, log, None) for log in logs]
    problem = LeastSquares(experiment, [Window(r, 0, len(r)) for r in records], fit.size, fit.parts)
    point, _ = solve(problem, problem.begin(np.append(fit.values, np.zeros(len(more)))), STEPS)
    return Left(problem, point, angles, places)


def _best(
    fit: Identified, logs: Sequence[Mapping[str, Any]], angles: tuple[Floats, ...], places: tuple[Place, ...]
) -> Left:  # fmt: skip
    """The model with these lines, or with all of them in the gear, which a lost fit takes wrongly."""
    left = _left(fit, logs, angles, places)
    in_gear = tuple(place._replace(in_reading=False) for place in places)
    if in_gear == places:
        return left
    try:
        return min(left, _left(fit, logs, angles, in_gear), key=Left.remains)
    except (SolveError, ValueError):  # the motion leaves every bound with them
        return left


def _chosen(left: Left, places: Sequence[Place]) -> list[Place]:
    """Places that together explain the residual: one after the other, what explains most of the rest."""
    base, residual = left.fitted()
    basis, columns = _basis(base), left.columns(places)
    sizes = np.linalg.norm(columns, axis=0)
    residual, chosen = orthogonal(basis, residual), list[int]()
    for _ in range(MOST_LINES):
        columns -= np.tensordot(basis, np.tensordot(basis, columns, ((0,), (0,))), 1)
        allowed = [_apart_from(place.order, [places[i].order for i in chosen]) for place in places]
        drops = np.where(allowed, _drops(columns, residual, sizes), 0.0)
        chosen.append(int(np.argmax(drops)))
        if drops[chosen[-1]] == 0.0:
            break
        basis = np.linalg.qr(columns[:, chosen[-1]])[0]
        residual = orthogonal(basis, residual)
    all_columns = left.columns([places[i] for i in chosen])
    for count in range(len(chosen), 0, -1):
        drops, residual = _apart(base, all_columns[:, :count], left.point.reduced()[1])
        if np.all(drops > _needed(residual, len(places), 1.0)):
            return [places[i] for i in chosen[:count]]
    return []


def _drops(columns: Floats, rest: Floats, sizes: Floats) -> Floats:
    """What the two columns of each place (n, places, 2) take from the squares of the rest (n,)."""
    grams = np.einsum("nij,nik->ijk", columns, columns)
    pulls = np.einsum("nij,n->ij", columns, rest)
    there = np.all(np.linalg.norm(columns, axis=0) > SAME * sizes, axis=1)
    there &= np.linalg.det(grams) > SAME**2 * grams[:, 0, 0] * grams[:, 1, 1]
    solved = np.linalg.solve(np.where(there[:, None, None], grams, np.eye(2)), pulls[:, :, None])[:, :, 0]
    return np.where(there, np.sum(pulls * solved, axis=1), 0.0)


def _beside(base: Floats, columns: Floats) -> Floats:
    """Columns (n, p) with those of places (n, places, 2) after them."""
    return np.column_stack([base, columns.reshape(len(base), -1)])


def _basis(columns: Floats) -> Floats:
    """Orthonormal columns of the same space."""
    return np.asarray(np.linalg.qr(columns / np.linalg.norm(columns, axis=0))[0])


def _apart(base: Floats, columns: Floats, residual: Floats) -> tuple[Floats, Floats]:
    """What each place (n, places, 2) explains that the others do not (places,), and what all leave (n,)."""
    sizes, drops = np.linalg.norm(columns, axis=0), np.empty(columns.shape[1])
    for i in range(len(drops)):
        basis = _basis(_beside(base, np.delete(columns, i, axis=1)))
        column = orthogonal(basis, columns[:, i])[:, None]
        drops[i] = _drops(column, orthogonal(basis, residual), sizes[i : i + 1])[0]
    basis = _basis(_beside(base, columns))
    return drops, orthogonal(basis, residual)


def _needed(residual: Floats, tried: int, masters: float) -> float:
    """Squares that a line must explain: more than chance, and so many times what is left beside noise."""
    parts = [slice(0, len(residual))]
    noise = power = float(residual @ residual) / len(residual)
    if white(residual, parts) < COLOURED:
        innovation = whitened(residual, whitener(residual, parts), parts)
        noise = float(innovation @ innovation) / len(residual)
    return 2.0 * noise * math.log(tried / CHANCE) + masters * len(residual) * (power - noise)


def _placed(left: Left, chosen: Sequence[Place], i: int, width: float) -> Place:
    """A place moved to the order that explains most; it stays where that leaves nearly as much."""
    base, residual = left.fitted()
    others = [place for j, place in enumerate(chosen) if j != i]
    basis = _basis(_beside(base, left.columns(others)) if others else base)
    residual = orthogonal(basis, residual)
    shifts = LOBE * width * np.arange(-AROUND, AROUND + 1)
    columns = left.columns([chosen[i]._replace(order=chosen[i].order + shift) for shift in shifts.tolist()])
    sizes = np.linalg.norm(columns, axis=0)
    columns -= np.tensordot(basis, np.tensordot(basis, columns, ((0,), (0,))), 1)
    remains = float(residual @ residual) - _drops(columns, residual, sizes)
    best = int(np.argmin(remains[1:-1])) + 1
    gain, noise = float(remains[AROUND] - remains[best]), float(remains[best]) / len(residual)
    if gain < max(2.0 * noise * math.log(len(shifts) / CHANCE), 0.5 * float(remains[AROUND])):
        return chosen[i]
    below, centre, above = remains[best - 1 : best + 2].tolist()
    shift = shifts[best] + 0.5 * LOBE * width * (below - above) / max(below - 2.0 * centre + above, 1e-300)
    return chosen[i]._replace(order=float(chosen[i].order + shift))


def _confirmed(left: Left, tried: int) -> list[MissingLine]:
    """Lines that explain the residual with the numbers solved again, and more of it than any other term."""
    of_gear = [not place.in_reading for place in left.places]
    columns, (base, residual) = left.columns(left.places), left.point.reduced()
    count = len(left.point.values) - 2 * sum(of_gear)
    coefficients = np.zeros((len(of_gear), 2))
    coefficients[of_gear] = left.point.values[count:].reshape(-1, 2)
    # what the numbers without lines leave
    base, whole = base[:, :count], np.einsum("nij,ij->n", columns, coefficients) - residual
    drops, remains = _apart(base, columns, whole)
    needed = max(_needed(remains, tried, MASTERS), BESIDE_LARGEST * float(np.max(drops)))
    terms = [*candidate_columns(left.problem, left.point).values()]
    sizes = np.linalg.norm(_beside(base, columns), axis=0)
    fit = np.linalg.lstsq(_beside(base, columns) / sizes, whole, rcond=None)[0] / sizes
    amplitudes = np.linalg.norm(fit[count:].reshape(-1, 2), axis=1)
    lines = []
    for i, place in enumerate(left.places):
        others = _basis(_beside(base, np.delete(columns, i, axis=1)))
        best = _best_term(others, terms, whole)
        exact = float(remains @ remains) < EXACT * float(remains @ remains + drops[i] - best)
        if drops[i] > max(needed, best if exact else BETTER * best):
            lines.append(MissingLine(place.order, float(amplitudes[i]), place.in_reading))
    return sorted(lines, key=lambda line: -line.amplitude)


def _best_term(basis: Floats, terms: Sequence[Floats], residual: Floats) -> float:
    """Squares that the best of other terms (n,) explains beside orthonormal columns."""
    best = 0.0
    for term in terms:
        column = orthogonal(basis, term)
        if np.linalg.norm(column) > SAME * np.linalg.norm(term):
            best = max(best, float(column @ residual) ** 2 / float(column @ column))
    return best
