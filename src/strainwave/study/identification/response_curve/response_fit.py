"""`fit_response`: a measured response curve, up and down with its jumps, to the parameters of a system."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from ....base.arguments import typed
from ....base.law import springs_only
from ....base.protocols import with_parts
from ....base.quantities import SMALLEST, complex_numbers, number, numbers, positive_count
from ....base.records import Along
from ....base.results import Branch, Floats, SolveError
from ....base.sentences import on_screen
from ....compile.tree import leaves as numbers_in
from ....model.excitation import NoError
from ....numerics.balance.rates import SAME
from ....numerics.curves.response import frequency_response
from ..discrepancy import discrepancy
from ..fitted import Fitted, bounds, free_leaves, refuse_unidentifiable, scales, with_values
from ..intervals import spread
from .balanced_points import Complexes, Points

FEWEST = 5  # points
JUMP = 4.0  # times the usual step of the amplitude, and
LARGE = 0.15  # of the largest amplitude: a jump
FAR = 1.0  # of its size: what the first guess may move a parameter that the points do not tell
WORTH = 0.02  # of the force: how well the first guess is known
NO_START = 0.01
ASTRAY = 0.15  # of the largest amplitude: a point so far off is solved from its measurement again
NEAR = 2.0  # widths of a jump: a fold farther away is another one
ROUNDS = 2  # of weights
LEFT = 0.3  # of the measurement's size: what a fit may leave


class Jump(NamedTuple):
    """A jump of a sweep: after the point `before`, between two frequencies [rad/s]."""

    before: int
    low: float
    high: float


@dataclass(frozen=True, eq=False)
class ResponseFit(Fitted):
    """A system fitted to a measured response curve.

    Attributes
    ----------
    system, names, values, covariance, freedom, discrepancy
        As of `Fitted`.
    omega : (n,) array
        Frequencies measured [rad/s], in their order.
    measured, computed : (n,) complex arrays
        First harmonics c of the measurement and of the system on the same branch: x = Re(c exp(i omega t)) [rad].
        Without phases the measured ones have those of the system.
    up : (n,) array of bool
        Whether the frequency was rising.
    solved : (n,) array of bool
        Whether the system has a motion there on the branch of the measurement.
    jumps : (m, 2) array
        Frequencies [rad/s] between which each measured jump lies.
    folds, fold_deviation : (m,) arrays
        Where the system jumps [rad/s], and the standard deviation of that by the scatter of the parameters; nan where
        it has no fold.
    harmonics : int
        Highest harmonic of the balance.
    """

    omega: Floats
    measured: Complexes
    computed: Complexes
    up: NDArray[np.bool_]
    solved: NDArray[np.bool_]
    jumps: Floats
    folds: Floats
    fold_deviation: Floats
    harmonics: int

    rows: ClassVar[str] = "point"
    arrays: ClassVar[Along] = {
        "point": {"measured": "rad", "computed": "rad", "up": "", "solved": ""},
        ("jump", "end"): {"jumps": "rad/s"},
        "jump": {"folds": "rad/s", "fold_deviation": "rad/s"},
    }
    places: ClassVar[Along] = {"point": {"omega": "rad/s"}}

    def curve(self) -> Branch:
        """Response curve of the fitted system over the frequencies measured."""
        span = float(np.min(self.omega)), float(np.max(self.omega))
        return frequency_response(self.system, span, harmonics=self.harmonics)

    def __str__(self) -> str:
        lines = [
            f"Response: {len(self.omega)} points, omega {np.min(self.omega):.6g} to {np.max(self.omega):.6g} rad/s, "
            f"{len(self.jumps)} jumps",
            *self.lines(),
            *[
                f"  jump measured {low:.6g} to {high:.6g} rad/s, fold at {fold:.6g} +- {deviation:.2g} rad/s"
                for (low, high), fold, deviation in zip(self.jumps, self.folds, self.fold_deviation, strict=True)
            ],
            f"  {self.discrepancy}",
        ]
        return on_screen("\n".join(lines))


@typed
def fit_response(
    omega: Any, amplitude: Any, system: Any, *, free: Sequence[str], phase: Any = None, harmonics: int = 7,
    speed_error: float = 1e-4,
) -> ResponseFit:  # fmt: skip
    """Find free parameters of a system from the first harmonic of its response, measured point by point.

    The points are in the order in which they were measured: a rising frequency is an up sweep, a falling one a down
    sweep, and several may follow each other. A first guess puts the measured motion into the balance of forces; then
    the distance of each point to the computed motion on its own branch is made least. A jump says that the fold lies
    between the two frequencies around it.

    Parameters
    ----------
    omega : (n,) array_like
        Forcing frequency (speed of the base angle) [rad/s].
    amplitude : (n,) array_like
        First harmonic of x: complex c with x = Re(c exp(i omega t)), or its amplitude, 0-to-peak [rad].
    system : Oscillator
        The system with start values within a factor of about 2, and its own excitation and kinematic error; a spring.
    free : sequence of str
        Paths of the parameters to find, such as ("B", "law.K", "law.alpha", "excitation.amplitude").
    phase : (n,) array_like, optional
        Phase [rad] of x = amplitude cos(omega t + phase), where the amplitude is real. Without it amplitudes alone
        count, which takes a system without kinematic error.
    harmonics : int
        Highest harmonic of the balance.
    speed_error : float
        Relative error of the frequencies; it weighs down the points where the curve is steep, next to folds.

    Returns
    -------
    ResponseFit
        `system` with the numbers found, in SI; `value(path)` and `interval(path)`; first harmonics `measured`
        and `computed` [rad] at `omega` [rad/s].

    Raises
    ------
    ValueError
        If the points are too few, of one frequency or without motion, a path does not exist, or the points do not
        tell a parameter: the sentence says which combination they tell.
    TypeError
        If the law is no spring, or phases are missing for a kinematic error.
    SolveError
        If no values of the parameters come near the points.
    """
    system = with_parts("fit_response", system, *SAME)
    springs_only("fit_response", system)
    leaves, sizes = free_leaves(system, free), scales(system, free)
    if not leaves:
        raise ValueError("free is empty; name the parameters to find, such as ('B', 'law.K')")
    omega, measured, phased = _measured(omega, amplitude, phase, system, len(leaves))
    points = Points(system, leaves, sizes, omega, measured, positive_count("harmonics", harmonics))
    limits = bounds(system, free)
    fit = _Fit(points, phased, number("speed_error", speed_error, positive=True), sweeps(omega), limits)
    p = fit.start()
    slopes, _ = points.keep(p)
    refuse_unidentifiable(fit.rows(slopes), free, p)
    p = fit.refined(p)
    return _described(fit, p, tuple(free))


def _measured(omega: Any, amplitude: Any, phase: Any, system: Any, free: int) -> tuple[Floats, Complexes, bool]:
    """Frequencies, first harmonics, and whether their phases are known."""
    w, c = numbers("omega [rad/s]", omega), complex_numbers("amplitude [rad]", amplitude)
    if c.shape != w.shape:
        raise ValueError(f"omega has {len(w)} values and amplitude the shape {c.shape}; give one amplitude for each")
    if not np.all(w > 0.0):
        raise ValueError(f"omega is {np.min(w):g} rad/s at point {int(np.argmin(w))}; frequencies must be positive")
    phased = bool(np.iscomplexobj(np.asarray(amplitude))) or phase is not None
    if phase is not None:
        c = np.abs(c) * np.exp(1j * numbers("phase [rad]", phase, count=len(w)))
    if not phased and not isinstance(system.error, NoError):
        raise TypeError("a kinematic error takes phases: without them the torsion is not known; give phase [rad]")
    if not np.ptp(w) > 0.0:
        raise ValueError(f"all points are at {w[0]:g} rad/s; a response curve needs several frequencies")
    if not np.max(np.abs(c)) >= SMALLEST:
        raise ValueError(f"the largest amplitude is {np.max(np.abs(c)):g} rad: there is no motion; excite the system")
    least = max(FEWEST, -(-(free + 1) // (1 + phased)))
    if len(w) < least:
        raise ValueError(f"there are {len(w)} points; {free} free parameters need {least} or more")
    return w, c, phased


def sweeps(omega: Floats) -> list[slice]:
    """Runs of rising or falling frequency."""
    runs, first, sense = [], 0, 0.0
    for i, step in enumerate(np.sign(np.diff(omega)).tolist(), 1):
        if sense != 0.0 and step != sense:
            runs.append(slice(first, i))
            first, sense = i, 0.0
        else:
            sense = step
    return [*runs, slice(first, len(omega))]


def jumps_of(omega: Floats, size: Floats, runs: list[slice]) -> list[Jump]:
    """Jumps of amplitude (n,) inside sweeps."""
    steps = [np.abs(np.diff(size[run])) for run in runs]
    least = max(JUMP * float(np.median(np.concatenate(steps))), LARGE * float(np.max(size)))
    found = []
    for run, step in zip(runs, steps, strict=True):
        around = np.concatenate([[0.0], step, [0.0]])
        largest = (step > least) & (step >= around[:-2]) & (step >= around[2:])
        found += [run.start + int(i) for i in np.flatnonzero(largest)]
    return [Jump(i, *sorted((float(omega[i]), float(omega[i + 1])))) for i in found]


class _Fit:
    """Residuals of points and jumps over the parameters."""

    def __init__(self, points: Points, phased: bool, speed_error: float, runs: list[slice], bounds: Any) -> None:
        self.points, self.phased, self.runs, self.speed_error, self.bounds = points, phased, runs, speed_error, bounds
        self.measured, self.size = points.measured, np.abs(points.measured)
        self.jumps = jumps_of(points.omega, self.size, runs)
        self.weights, self.noise = np.ones(len(self.size)), 0.05 * float(np.max(self.size))
        self.folds: list[Floats | None] = [None] * len(self.jumps)
        self.asked = False

    def start(self) -> Floats:
        """Parameters over their sizes by the balance of forces at the measured motion; phases where they miss."""
        points = self.points
        values = np.array(numbers_in(points.system))[list(points.leaves)] / points.sizes
        begin = np.where(values == 0.0, NO_START, values)
        inertial = float(points.system.J) * float(np.max(points.omega**2 * self.size))
        scale = WORTH * np.sqrt(len(self.size)) * inertial

        def off(p: Floats) -> Floats:
            needed, applied = points.pull(p)
            less = needed - applied
            both = np.append(less.real, less.imag) if self.phased else np.abs(needed) - np.abs(applied)
            return np.append(both / scale, (p - begin) / FAR / len(needed))

        with np.errstate(all="ignore"):  # of numbers far beyond those of a system; they fit nothing
            p = np.asarray(least_squares(off, begin, x_scale="jac", bounds=self.bounds).x)
        if not self.phased:
            needed, applied = points.pull(p)
            points.measured = self.size * np.exp(1j * (np.angle(applied) - np.angle(needed)))
        return p

    def rows(self, change: Any) -> Floats:
        """Weighted changes (rows, ...) of what was measured, from those of first harmonics (n, ...)."""
        turned = (change.T * (np.exp(-1j * np.angle(self.points.measured)) * self.weights)).T
        return np.concatenate([turned.real, turned.imag]) if self.phased else np.asarray(turned.real)

    def off(self, p: Floats) -> Floats:
        """Residual (rows + jumps,): computed less measured, and how far folds are from their jumps."""
        found = self.points.solve(p)
        if not self.phased:
            self.points.measured = self.size * np.exp(1j * np.angle(found))
        rows = self.rows(found - self.points.measured)
        return np.append(rows, [self._missed(jump, k, p)[0] for k, jump in enumerate(self.jumps)])

    def slopes(self, p: Floats) -> Floats:
        """Derivatives of `off`."""
        by_p, _ = self.points.keep(p)
        missed = [self._missed(jump, k, p)[1] for k, jump in enumerate(self.jumps)]
        return np.vstack([self.rows(by_p), *missed])

    def _missed(self, jump: Jump, k: int, p: Floats) -> tuple[float, Floats]:
        """By how much a fold is outside its jump, in units of the noise, and the derivatives."""
        fold = self.fold(k, p)
        if fold is None:
            return 0.0, np.zeros(len(p))
        slack = self.speed_error * fold[0]
        out = max(0.0, fold[0] - jump.high - slack) - max(0.0, jump.low - slack - fold[0])
        unit = self.noise / (jump.high - jump.low + slack)
        return out * unit, (fold[1] if out else 0.0 * fold[1]) * unit

    def fold(self, k: int, p: Floats) -> tuple[float, Floats, Floats] | None:
        """Fold of jump k with its derivatives and its point, or None.

        It is sought from the last one, from the point before the jump, and where these lead elsewhere on the curve.
        """
        jump = self.jumps[k]
        z, omega = self.points.solutions[jump.before], self.points.omega[jump.before]
        for start in (self.folds[k], None if z is None else np.append(z, omega)):
            found = None if start is None else self.points.fold(p, start)
            if found is not None and abs(found[0] - 0.5 * (jump.low + jump.high)) < NEAR * (jump.high - jump.low):
                self.folds[k] = found[2]
                return found
        return None if self.asked else self._of_curve(k, p)

    def _of_curve(self, k: int, p: Floats) -> tuple[float, Floats, Floats] | None:
        """Fold of the computed curve that is nearest to jump k; it is computed once for all jumps."""
        self.asked, omega = True, self.points.omega
        span = 0.97 * float(np.min(omega)), 1.03 * float(np.max(omega))
        found = frequency_response(self.points.at(p), span, harmonics=self.points.h).folds
        for i, jump in enumerate(self.jumps):
            if found:
                near = found[int(np.argmin([abs(orbit.omega - 0.5 * (jump.low + jump.high)) for orbit in found]))]
                problem = self.points.problem(self.points.at(p), near.omega)
                self.folds[i] = problem.point(near.coefficients, near.omega)
        start = self.folds[k]
        return None if start is None else self.points.fold(p, start)

    def _refuse_far(self, p: Floats) -> None:
        """Refuse parameters that leave too much of the measurement (SolveError)."""
        computed = self.points.solve(p)
        missed = np.abs(computed - self.measured) if self.phased else np.abs(computed) - self.size
        left = float(np.linalg.norm(missed)) / float(np.linalg.norm(self.size))
        if not left < LEFT:
            raise SolveError(
                f"the nearest system is {100.0 * left:.2g} % away from the measured curve: its law is another one, a "
                "sweep is in the wrong order, or the start values are too far; free more parameters or start closer"
            )

    def refined(self, p: Floats) -> Floats:
        """Parameters that make the residual least, with weights of its own noise."""
        for k in range(ROUNDS):
            self.asked = False
            # A point that is solved on another branch at first must not draw the parameters there.
            loss: dict[str, Any] = {"loss": "soft_l1", "f_scale": self.noise} if k == 0 else {}
            p = self._least(p, xtol=1e-4, ftol=1e-5, **loss)
            self.points.again(np.abs(self.points.solve(p) - self.points.measured) > ASTRAY * np.max(self.size))
            self._refuse_far(p)
            self.weights = np.ones(len(self.size))
            plain = np.abs(self.off(p)[: len(self.size)])
            self.noise = max(1.4826 * float(np.median(plain)), 1e-9 * float(np.max(self.size)))
            _, along = self.points.keep(p)
            self.weights = 1.0 / np.hypot(1.0, np.abs(along) * self.speed_error * self.points.omega / self.noise)
        return self._least(p, x_scale="jac", xtol=1e-9)

    def _least(self, p: Floats, **options: Any) -> Floats:
        return np.asarray(least_squares(self.off, p, self.slopes, bounds=self.bounds, max_nfev=30, **options).x)


def _described(fit: _Fit, p: Floats, names: tuple[str, ...]) -> ResponseFit:
    points = fit.points
    slopes, _ = points.keep(p)
    jacobian, computed = fit.rows(slopes), points.solve(p)
    rows = -fit.off(p)[: len(jacobian)]
    refuse_unidentifiable(jacobian, names, p)
    records = [slice(run.start + k, run.stop + k) for k in range(0, len(rows), len(computed)) for run in fit.runs]
    scatter, units = spread(jacobian, rows, records), np.outer(points.sizes, points.sizes)
    fit.asked = False
    folds = [fit.fold(k, p) for k in range(len(fit.jumps))]
    fold_speeds = np.array([np.nan if f is None else f[0] for f in folds])
    deviations = [np.nan if f is None else float(np.sqrt(f[1] @ scatter.covariance @ f[1])) for f in folds]
    return ResponseFit(
        with_values(points.system, points.leaves, p * points.sizes), names, p * points.sizes,
        scatter.covariance * units, scatter.freedom, discrepancy(rows, jacobian, records=records), points.omega,
        points.measured, computed, rising(points.omega, fit.runs), np.array([z is not None for z in points.found]),
        np.array([jump[1:] for jump in fit.jumps]).reshape(-1, 2), fold_speeds, np.array(deviations), points.h,
    )  # fmt: skip


def rising(omega: Floats, runs: list[slice]) -> NDArray[np.bool_]:
    """Whether each point (n,) is of a sweep with rising frequency."""
    return np.concatenate([np.full(run.stop - run.start, omega[run.stop - 1] >= omega[run.start]) for run in runs])
