"""Prediction: the pointing error over speed by harmonic balance of the whole drive, and by closed forms beside it."""

from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any, ClassVar, NamedTuple

import numpy as np

from ...base.number_text import number
from ...base.protocols import System
from ...base.quantities import interval, shown
from ...base.quantities import number as real
from ...base.records import Labelled, Result
from ...base.results import Booleans, Complexes, Floats, Integers, SolveError
from ...base.terminal import on_screen
from ...base.units import ARCSEC
from ...drive.project import Project
from ...drive.speeds import BASES, Speeds
from ...drive.train_curve import in_turns
from ...model.controllers.feedforward import SpeedTable
from ...model.oscillator import Oscillator
from ...model.train.motion import MOST_POINTS
from ...theory.resonance import Resonance
from ...theory.slow_flow.flow import slow_flow
from ...theory.slow_flow.predictor.predictor import BEYOND, OK, motion, state_of, swing
from ...theory.slow_flow.setting import active_orders
from ..speed_map.error_equation import operating_point
from .bench import Bench, bench_of
from .gains import torque_against

RANGE_MARGIN = 1e-3  # of the speed: a predictor's range beyond the motions that it is compared with
ANGLES_PER_PERIOD = 8  # angles on a period of the highest order


class ResponseMotions(NamedTuple):
    """Motions of a response curve in arc order.

    Speeds (n,) [rad/s] of the base angle, orders (orders,) of it, amplitudes A e^(i phi) (orders, n) [rad], and whether
    each motion is stable (n,).
    """

    omega: Floats
    orders: Integers
    amplitudes: Complexes
    stable: Booleans

    def others(self, i: int) -> Complexes:
        """Amplitudes (orders, m) where the curve passes the speed of motion i elsewhere, straight between motions."""
        off = self.omega - self.omega[i]
        parts = np.flatnonzero(off[:-1] * off[1:] <= 0.0)
        parts = parts[(parts != i) & (parts != i - 1)]
        share = off[parts] / (off[parts] - off[parts + 1] + 1e-300)
        return np.asarray((1.0 - share) * self.amplitudes[:, parts] + share * self.amplitudes[:, parts + 1])


class ClosedForm(NamedTuple):
    """Complex amplitudes (orders, n) [rad] of the closed forms, where they are valid (n,), and sentences."""

    amplitudes: Complexes
    valid: Booleans
    remarks: tuple[str, ...]


def closed_form(system: System, motions: ResponseMotions, axis: Speeds = BASES["motor"]) -> ClosedForm:
    """Steady motions of the second-order predictors of an error equation, at the motions of a response curve.

    At every speed the predictor is that of the order whose resonance is nearest. A steady state of it with the
    stability of the motion is taken for it where no other motion of the curve at that speed is nearer; NaN where there
    is none.

    Parameters
    ----------
    system : Oscillator
        The error equation; its omega is not used.
    motions : ResponseMotions
        The curve.
    axis : Speeds
        Unit of its speeds.
    """
    shape = motions.amplitudes.shape
    forms = ClosedForm(np.full(shape, np.nan + 0.0j), np.zeros(shape[1], bool), ())
    if not isinstance(system, Oscillator):
        reason = "No closed form exists: damping or stiffness varies with the angle."
        return forms._replace(remarks=(reason,))
    try:
        natural, lines = operating_point(system).omega_0, np.array(active_orders(system))
    except (ValueError, SolveError) as error:
        return forms._replace(remarks=(f"There is no closed form: {error}.",))
    if not len(lines) or not natural:
        return forms._replace(remarks=("A closed form needs an excitation and a stiffness at rest.",))
    nearest = lines[np.argmin(np.abs(np.log(np.outer(motions.omega, lines) / natural)), axis=1)]
    remarks = []
    for k in np.unique(nearest).tolist():
        indices = np.flatnonzero(nearest == k)
        try:
            remarks += _write_about(system._replace(omega=natural / k), k, indices, motions, forms)
        except (ValueError, SolveError) as error:
            ends = number(axis.scale * np.min(motions.omega[indices])), axis.said(np.max(motions.omega[indices]))
            remarks.append(f"There is no closed form about order {k}'s resonance, {' to '.join(ends)}: {error}.")
    return forms._replace(remarks=tuple(remarks))


def _write_about(system: System, k: int, indices: Any, motions: ResponseMotions, forms: ClosedForm) -> list[str]:
    """Write the motions of these indices, about the resonance of order k, to `forms`; return sentences on them."""
    omega = motions.omega[indices]
    flow = slow_flow(system, Resonance(k, 1), order=2)
    ends = (1.0 - RANGE_MARGIN) * float(np.min(omega)), (1.0 + RANGE_MARGIN) * float(np.max(omega))
    predictor = flow.predictor(speeds=ends)
    states, flags = flow.states_at(np.unique(omega)), np.full(len(omega), -1)
    for n, i in enumerate(indices.tolist()):
        w, others = float(omega[n]), motions.others(i)
        for j in np.flatnonzero((states.omega == w) & (states.stable == motions.stable[i])).tolist():
            z = states.amplitude[j] * np.exp(-1j * states.phase[j])
            rows, flag = _predicted_amplitudes(predictor, w, complex(z), motions.orders)
            off = float(np.linalg.norm(rows - motions.amplitudes[:, i]))
            if off <= np.min(np.linalg.norm(rows[:, None] - others, axis=0), initial=np.inf):
                forms.amplitudes[:, i], flags[n] = rows, flag
    forms.valid[indices] = flags == OK
    several = f"of the {len(omega)} motions about order {k}'s resonance"
    sentences = [
        f"At {np.sum(flags == flag)} {several} the closed form is not valid: {predictor.meaning(flag)}."
        for flag in np.unique(flags[flags > OK]).tolist()
    ]
    if np.any(flags < OK):
        sentences.append(f"At {np.sum(flags < OK)} {several} the closed form has no such motion.")
    return sentences


def _predicted_amplitudes(predictor: Any, omega: float, z: complex, orders: Integers) -> tuple[Complexes, int]:
    """Amplitudes (orders,) [rad] of the motion that a predictor makes of a steady state z [rad], and its flag."""
    count = ANGLES_PER_PERIOD * max(int(np.max(orders)), predictor.p)
    angle = 2.0 * np.pi * np.arange(count) / count
    rate, small = predictor.force.rate(predictor.drive, omega, 1.0, z)
    states = [state_of(z, (rate, rate, rate), theta, 0.0, omega, 1.0) for theta in angle.tolist()]
    x = np.array([motion(predictor, state, small)[0] for state in states])
    flag = OK if swing(predictor, z, omega, 1.0) <= predictor.reach else BEYOND
    return 2.0 / count * np.exp(-1j * np.outer(orders, angle)) @ x, flag


@dataclass(frozen=True, eq=False)
class PredictionTable(Result):
    """Complex amplitudes of the pointing error along the response curve.

    Attributes
    ----------
    omega : (n,) array
        Speed of the motor [rad/s], in the order of the arc, from the low end.
    orders : (orders,) int array
        Orders of the motor's angle.
    amplitudes : (orders, n) complex array
        A e^(i phi) [rad] of A cos(order angle + phi).
    stable : (n,) bool array
        True for a stable motion; the fold at which a stable stretch ends counts as stable.
    jumps_up, jumps_down : tuple of float
        Speeds [rad/s] at which a slow run-up and a slow run-down jump.
    closed : (orders, n) complex array, or None
        The same amplitudes by the closed forms of second order of the drive's error equation; NaN where these have no
        such motion.
    valid : (n,) bool array, or None
        True where the predictor of the closed forms holds its motion valid.
    remarks : tuple of str
        Assumptions, and reasons for closed forms that are not valid or missing, as sentences.
    shaft : {"motor", "forcing"}
        Shaft that turns at the speeds.
    """

    rows: ClassVar[str] = "point"

    omega: Floats
    orders: Any
    amplitudes: Complexes
    stable: Booleans
    jumps_up: tuple[float, ...] = ()
    jumps_down: tuple[float, ...] = ()
    closed: Complexes | None = None
    valid: Booleans | None = None
    remarks: tuple[str, ...] = ()
    shaft: str = "motor"

    @property
    def axis(self) -> Speeds:
        """Name and unit of its speeds."""
        return BASES[self.shaft]

    def runs(self) -> list[tuple[int, int]]:
        """First and last point, this excluded, of each stretch of stable motions whose speed grows or falls.

        A stretch that ends at a fold has the fold in it.
        """
        direction = np.sign(np.diff(self.omega)) * (self.stable[:-1] & self.stable[1:])
        edges = [0, *(np.flatnonzero(np.diff(direction)) + 1).tolist(), len(direction)]
        return [(a, b + 1) for a, b in pairwise(edges) if b > a and direction[a] != 0.0]

    def at(self, speed: float, direction: int = 1, *, closed: bool = False) -> tuple[Complexes, str]:
        """Amplitudes (orders,) at a speed [rad/s] that is reached from below (1) or from above (-1), and a flag.

        Where several motions are stable a run-up stays on the one that it is on until that ends. The flag is empty
        where the prediction holds, else a sentence; where there is no prediction the amplitudes are NaN. With `closed`
        they are those of the closed forms, which are also given where they are not valid.
        """
        speed = real("speed [rad/s]", speed)
        if direction not in (1, -1):
            raise ValueError(f"direction is {shown(direction)}; it must be 1, from below, or -1, from above")
        rows, valid = (self.closed, self.valid) if closed else (self.amplitudes, self.stable)
        nothing = np.full(len(self.orders), np.nan + 0.0j)
        if rows is None or valid is None:
            return nothing, "this table has no closed forms"
        low, high = float(np.min(self.omega)), float(np.max(self.omega))
        if not low <= speed <= high:
            return nothing, f"the speed is outside of the table, {self.axis.said(low)} to {self.axis.said(high)}"
        runs = self.runs()
        for a, b in runs if direction > 0 else reversed(runs):
            x = self.omega[a:b]
            if min(x[0], x[-1]) <= speed <= max(x[0], x[-1]):
                up = slice(None, None, 1 if x[-1] > x[0] else -1)
                i = min(max(int(np.searchsorted(x[up], speed)), 1), b - a - 1)
                held = bool(np.all(valid[a:b][up][i - 1 : i + 1]))
                amplitudes = np.array([np.interp(speed, x[up], row[a:b][up]) for row in rows])
                return amplitudes, "" if held else "the closed form is not valid at this speed"
        return nothing, "no stable motion that repeats with every turn is known at this speed"

    def coordinates(self) -> Labelled:
        """Speeds and orders."""
        return {"omega": ("point", self.omega, "rad/s"), "order": ("order", self.orders, "")}

    def variables(self) -> Labelled:
        """Amplitudes, phases and stability; those of the closed forms and their validity."""
        dims, columns = ("order", "point"), dict[str, Any]()
        parts: list[tuple[str, Any, str]] = [("", self.amplitudes, "stable")]
        parts += [] if self.closed is None else [("closed_", self.closed, "valid")]
        for prefix, rows, flag in parts:
            columns[f"{prefix}amplitude"] = dims, np.abs(rows), "rad"
            columns[f"{prefix}phase"] = dims, np.angle(rows), "rad"
            columns[f"{prefix}{flag}"] = "point", getattr(self, flag), ""
        return columns

    def __str__(self) -> str:
        axis, low, high = self.axis, float(np.min(self.omega)), float(np.max(self.omega))
        lines = [
            f"PredictionTable: {len(self.omega)} motions from {number(axis.scale * low)} to {axis.said(high)}, "
            f"{len(self.runs())} stretches of stable ones"
        ]
        for k, row in zip(self.orders, np.abs(self.amplitudes), strict=True):
            top = int(np.argmax(row))
            lines.append(f"  order {k}: up to {row[top] / ARCSEC:.4g} arcsec, at {axis.said(self.omega[top])}")
        for direction, jumps in (("run-up", self.jumps_up), ("run-down", self.jumps_down)):
            if jumps:
                speeds = ", ".join(number(axis.scale * w, 5) for w in jumps)
                lines.append(f"  a slow {direction} jumps at {speeds} {axis.unit}")
        if self.closed is not None and self.valid is not None:
            lines.append(f"  closed forms: valid at {np.sum(self.valid)} of {len(self.omega)} motions")
            if np.any(self.valid):
                off = np.linalg.norm(self.closed - self.amplitudes, axis=0)[self.valid]
                share = float(np.max(off) / np.max(np.linalg.norm(self.amplitudes, axis=0)))
                lines[-1] += f", where they differ by up to {100.0 * share:.2g} % of the largest error"
        return on_screen("\n".join([*lines, *(f"  {text}" for text in self.remarks)]))


def prediction_table(
    project: Project,
    orders: tuple[int, ...] | None = None,
    *,
    speeds: tuple[float, float] | None = None,
    closed: bool = True,
) -> PredictionTable:
    """Predict the pointing error of a drive over a range of speeds, order by order.

    Harmonic balance takes the whole drive. The closed forms beside it are those of the drive's error equation, with an
    ideally held motor (or a free one, where the project says so).

    Parameters
    ----------
    project : Project
        From `read_project`.
    orders : tuple of int, optional
        Orders of the base angle. Default: those of the kinematic error and of the torques.
    speeds : (low, high), optional
        Speeds of the base angle [rad/s]: of the motor, or of a forcing. Default: the range of the project.
    closed : bool
        True to compute the closed forms too.

    Returns
    -------
    PredictionTable
        Complex `amplitudes` [rad] of the error at each order and speed `omega` [rad/s] of the motor, and the
        speeds of its jumps.

    Raises
    ------
    ValueError
        If an order is none of the response's harmonics, or the speeds are no range.
    SolveError
        If no periodic motion is found.
    """
    chosen = bench_of(project).orders if orders is None else tuple(orders)
    if broken := [order for order in chosen if orders is None and order % 1]:
        raise ValueError(
            f"order {in_turns(broken[0], project.whole)} is a line of the output's turn, and a prediction over the "
            "speed has those of the motor's turn; give orders of that, or take the controller 'predicted-table' at "
            "single speeds"
        )
    if speeds is not None:
        limits = interval("speeds [rad/s]", speeds, positive=True)
        project = replace(project, speeds=replace(project.speeds, limits=limits, single=()))
    response = project.response()
    curve, sweep = response.curve, response.sweep
    x = curve.coefficients
    up = slice(None, None, 1 if curve.omega[0] <= curve.omega[-1] else -1)
    count = x.shape[1] // 2
    if not chosen or any(k % 1 or not 1 <= k <= count for k in chosen):
        raise ValueError(f"orders is {shown(orders)}; give integers from 1 to {count}, the harmonics of this response")
    omega, rows = curve.omega[up], np.array([x[up, 2 * k - 1] - 1j * x[up, 2 * k] for k in chosen], complex)
    stable = curve.stable[up] | np.isin(omega, [fold.omega for fold in curve.folds])
    table = PredictionTable(
        omega=omega,
        orders=np.array(chosen),
        amplitudes=rows,
        stable=stable,
        jumps_up=() if sweep is None else tuple(jump.value for jump in sweep.on_run_up),
        jumps_down=() if sweep is None else tuple(jump.value for jump in sweep.on_run_down),
        shaft=project.speeds.base,
    )
    if not closed:
        return table
    forms = closed_form(project.system(reduced=True), ResponseMotions(omega, table.orders, rows, stable), table.axis)
    beside = f"The closed forms apply to a {project.motor} motor, the gear and a rigid load only."
    remarks = (beside, *forms.remarks) if project.train is not None else forms.remarks
    return replace(table, closed=forms.amplitudes, valid=forms.valid, remarks=remarks)


def speed_table(
    project: Project,
    speeds: tuple[float, float],
    *,
    table: PredictionTable | None = None,
    direction: int = 1,
    closed: bool = False,
    **bench: Any,
) -> Any:
    """Return the plain loop with the torque that cancels the predicted error over a range of speeds: `SpeedTable`.

    At 16 speeds the torque is the predicted amplitude over the response of the sampled loop; between them it is
    straight. Where the error is large enough to bend the gear's stiffness, or the model is wrong, a rest is left.

    Parameters
    ----------
    project : Project
        The drive.
    speeds : (low, high)
        Speeds of the motor [rad/s].
    table : PredictionTable, optional
        Default: that of the project.
    direction : int
        1 for run-ups, -1 for run-downs.
    closed : bool
        True for the amplitudes of the closed forms, the predictor's.
    **bench
        `sampling` and `loop` as of `compensate`.

    Raises
    ------
    ValueError
        If the table has no prediction at one of the speeds: the sentence says why.
    """
    low, high = interval("speeds [rad/s]", speeds, positive=True)
    test_bench: Bench = bench_of(project, bench.get("sampling"), bench.get("loop"))
    predicted = prediction_table(project, closed=closed) if table is None else table
    grid = np.linspace(low, high, MOST_POINTS)
    torque = np.empty((len(predicted.orders), MOST_POINTS), complex)
    for i, speed in enumerate(grid.tolist()):
        amplitudes, flag = predicted.at(speed, direction, closed=closed)
        if flag:
            raise ValueError(f"there is no prediction at {test_bench.speeds.said(speed)}: {flag}")
        torque[:, i] = torque_against(test_bench, speed, predicted.orders, amplitudes)
    loop: Any = test_bench.loop
    for k, row in zip(predicted.orders.tolist(), torque, strict=True):
        loop = SpeedTable(loop, tuple(grid.tolist()), tuple(row.real.tolist()), tuple((-row.imag).tolist()), order=k)
    return loop
