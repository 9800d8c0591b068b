"""The operating point: where a law carries a constant torque. Every part of the package asks here.

It is the torsion nearest to zero at which the torque is the mean one: of a law that rises at rest the first one on the
way from rest in the direction of the torque, where a slow load arrives and the stiffness is not negative. A law that
softens has a largest torque; beyond it there is no operating point. `slow_path` does the same for laws with memory, at
a rate that does not matter.

Root of one function in a bracket, also one that asks for the values and is told them; roots of polynomials.
"""

import itertools
import math
import warnings
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ..base.law import breakpoints_of, depends, states_of, torque_of, z_rate_of
from ..base.results import Floats, SolveError
from ..base.sentences import Angle, Sentence
from ..compile.jit import routine

TORSIONS = np.append(0.0, np.geomspace(1e-6, 1e6, 2401))  # looked at, over that of the linear law: 1.2 % apart
GOLDEN = 0.5 * (math.sqrt(5.0) - 1.0)
SHRINKINGS = 80  # of an interval around a largest torque: to the last bit
ROUNDING = 4e-16  # share of the mean torque by which a largest torque may fall short of it

Function = Callable[[Any], Any]

STEPS = 200
OVERLAP = 1.1  # of the large and the small roots
NEARLY_REAL = 1e-3  # imaginary over real part of a root that rounding may have split off a double real one
A, FA, B, FB, SHARE = range(5)  # of a bracket: its latest place, its other end, and where between them to look next


def bracketed_root(f: Callable[[float], float], a: float, b: float, *, xtol: float, rtol: float = 1e-15) -> float:
    """Root of a continuous function between a and b, where it has opposite signs or is 0.

    Parameters
    ----------
    f : callable
        Function of one number.
    a, b : float
        Ends of the bracket.
    xtol, rtol : float
        The root is right to xtol + rtol |root|.

    Raises
    ------
    ValueError
        If f has the same sign at both ends.
    """
    fa, fb = f(a), f(b)
    if fa * fb > 0.0:
        raise ValueError(f"f has one sign at both ends of ({a:g}, {b:g}): {fa:g} and {fb:g}; widen the bracket")
    bracket = [a, fa, b, fb, 0.5]
    for _ in range(STEPS):
        a, fa, b, fb, _share = bracket
        best, least = (a, fa) if abs(fa) < abs(fb) else (b, fb)
        tolerance = xtol + rtol * abs(best)
        if 2.0 * tolerance >= abs(b - a) or least == 0.0:
            break
        x = next_place(bracket, tolerance)
        narrow(bracket, x, f(x))
    return bracket[A] if abs(bracket[FA]) < abs(bracket[FB]) else bracket[B]


@routine
def next_place(bracket: Any, tolerance: float) -> float:
    """Next place for a value, no nearer to an end of the bracket than the tolerance."""
    width = bracket[B] - bracket[A]
    least = min(0.5, tolerance / abs(width))
    return float(bracket[A] + min(1.0 - least, max(least, bracket[SHARE])) * width)


@routine
def narrow(bracket: Any, x: float, fx: float) -> None:
    """Make a place inside the latest of the bracket."""
    a, fa, b, fb = bracket[A], bracket[FA], bracket[B], bracket[FB]
    c, fc = a, fa
    if math.copysign(1.0, fx) != math.copysign(1.0, fa):
        c, b, fc, fb = b, a, fb, fa
    xi, phi = (x - b) / (c - b), (fx - fb) / (fc - fb)
    share = 0.5
    if phi * phi < xi and (1.0 - phi) ** 2 < 1.0 - xi:
        share = fx / (fb - fx) * fc / (fb - fc) + (c - x) / (b - x) * fx / (fc - fx) * fb / (fc - fb)
    bracket[A], bracket[FA], bracket[B], bracket[FB], bracket[SHARE] = x, fx, b, fb, share


def positive_roots(*coefficients: Any) -> Floats:
    """Positive real roots of many polynomials at once, as eigenvalues of companion matrices.

    The large ones are those of the polynomial, the small ones those of the polynomial of 1/s: each is right to its own
    size.

    Parameters
    ----------
    coefficients : (...) arrays
        Highest power first; the first ones may be 0. There are no roots where the last one is.

    Returns
    -------
    (2 degree, ...) array
        Not finite where there are fewer. A root may be listed twice. A pair that rounding may have split off a double
        root is listed too: it is to be corrected, and may be none.
    """
    with np.errstate(all="ignore"):
        c = np.stack(np.broadcast_arrays(*coefficients), axis=-1).astype(float)
        mean = np.abs(c[..., -1] / c[..., 0]) ** (1.0 / (c.shape[-1] - 1))
        large, small = _positive(c), 1.0 / _positive(c[..., ::-1])
        large[~(large > mean / OVERLAP)], small[~(small < mean * OVERLAP)] = np.nan, np.nan
        return np.where(c[..., -1] != 0.0, np.concatenate([large, small]), np.nan)


def _positive(c: Floats) -> Floats:
    """Nearly real positive roots (degree, ...) of polynomials (..., degree + 1), highest power first."""
    powers = np.arange(1.0, c.shape[-1])
    monic = c[..., 1:] / c[..., :1]
    size = np.max(np.abs(monic) ** (1.0 / powers), axis=-1)
    sound = np.isfinite(size) & (size > 0.0)
    scaled = monic / np.where(sound, size, 1.0)[..., None] ** powers
    companion = np.zeros((*sound.shape, len(powers), len(powers)))
    companion[..., 0, :] = np.where(sound[..., None], -scaled, 0.0)
    companion[..., np.arange(1, len(powers)), np.arange(len(powers) - 1)] = 1.0
    root = np.linalg.eigvals(companion).astype(complex)
    good = sound[..., None] & (root.real > 0.0) & (np.abs(root.imag) <= NEARLY_REAL * root.real)
    return np.moveaxis(np.where(good, (root.real + root.imag) * size[..., None], np.nan), -1, 0)


def operating_point(law: Any, mean: float) -> float:
    """Torsion [rad] nearest to zero at which a spring carries the mean torque [N*m].

    Raises
    ------
    ValueError
        If no torsion carries it; the sentence says how much the law carries.
    """
    offset = float(law.torque(0.0)) - mean
    if offset == 0.0:
        return 0.0
    toward, slope = 1.0 if offset < 0.0 else -1.0, float(law.stiffness(0.0))

    def missing(x: Any) -> Any:
        return toward * (law.torque(x) - mean)

    far = max(map(abs, breakpoints_of(law)), default=1.0)  # how far to look for the stiffness behind a gap
    places = toward * (abs(offset) / slope if slope > 0.0 else far) * TORSIONS
    low, high = first_reached(missing, places, ROUNDING * abs(mean))
    if slope < 0.0:  # a law that falls at rest may have it on either side
        opposite = first_reached(missing, -places, ROUNDING * abs(mean))
        if not (math.isnan(opposite[1]) or abs(high) <= abs(opposite[1])):
            low, high = opposite
    if math.isnan(high):
        torsion, missed = _largest(missing, places)
        text = (
            f"{type(law).__name__} carries at most {mean + toward * missed:.6g} N*m, at {{}}, and the mean torque is "
            f"{mean:.6g} N*m; lower the mean torque or stiffen the law"
        )
        raise ValueError(Sentence(text, Angle(torsion, digits=3)))
    return root_between(lambda x: float(missing(x)), low, high, xtol=1e-300)


def first_reached(f: Function, places: Floats, slack: float = 0.0) -> tuple[float, float]:
    """Places between which a function first reaches zero from below on its way; nan where it does not.

    A summit between two places counts too.

    Parameters
    ----------
    f : callable
        Values at places, one or (n,).
    places : (n,) array
        The way, rising or falling.
    slack : float
        Distance below zero at which a summit counts as zero.
    """
    with np.errstate(all="ignore"):
        values = np.asarray(f(places), float) + 0.0 * places[0]
        values = np.where(np.isnan(values), -np.inf, values)
        reached = np.flatnonzero(values >= 0.0)
        first = int(reached[0]) if len(reached) else len(values)
        for j in _summits(values[: first + 1]).tolist():
            summit, value = _summit(f, places[j - 1], places[j + 1])
            if value >= -slack:
                return (float(places[j - 1]) if value > 0.0 else summit), summit
    return (float(places[first - 1]), float(places[first])) if len(reached) else (math.nan, math.nan)


def root_between(f: Callable[[float], float], low: float, high: float, *, xtol: float) -> float:
    """Root in what `first_reached` gives: `high` where that is no bracket, at a summit or by rounding."""
    return high if f(low) * f(high) >= 0.0 else bracketed_root(f, low, high, xtol=xtol)


def _summits(values: Floats) -> Any:
    """Places of inner values (n,) that stand at a summit that may reach zero before the values do.

    A parabola through a sample and its neighbours rises above it by an eighth of what the lower one falls at most.
    """
    before, middle, after = values[:-2], values[1:-1], values[2:]
    return 1 + np.flatnonzero((middle > before) & (middle >= after) & (2.0 * middle >= np.minimum(before, after)))


def _largest(f: Function, places: Floats) -> tuple[float, float]:
    """Place and value of the largest value on the way."""
    with np.errstate(all="ignore"):
        values = np.nan_to_num(f(places), nan=-np.inf, posinf=-np.inf)
        j = min(max(int(values.argmax()), 1), len(values) - 2)
        return _summit(f, places[j - 1], places[j + 1])


def _summit(f: Function, a: Any, b: Any) -> tuple[float, float]:
    """Place and value of the largest value between places, by golden sections."""
    left, right = b - GOLDEN * (b - a), a + GOLDEN * (b - a)
    f_left, f_right = f(left), f(right)
    for _ in range(SHRINKINGS):
        a, b = (a, right) if f_left > f_right else (left, b)
        left, right = b - GOLDEN * (b - a), a + GOLDEN * (b - a)
        f_left, f_right = f(left), f(right)
    return (float(left), float(f_left)) if f_left > f_right else (float(right), float(f_right))


SAMPLES = 400  # of a path
SPEED = 1e-9  # torsion rate [rad/s]
DOUBLINGS = 12  # a law 4000 times softer than at rest does not carry the torque
MOST_EVALUATIONS = 50_000  # evaluations of a law along a path
RTOL = 1e-10


def loaded_state(law: Any, torque: float) -> tuple[float, ...]:
    """Torsion [rad] and internal states of a law that was loaded slowly from rest to a torque [N*m].

    Of a spring it is the operating point alone.

    Raises
    ------
    ValueError
        If the law does not carry the torque; the sentence says how much it carries.
    """
    if depends(law) == 1:
        return (operating_point(law, torque),)
    state = np.zeros(2 + states_of(law))
    if torque != 0.0:
        state = slow_path(law, state, torque, SPEED, RTOL)[2]
    return tuple(state[:-1].tolist())


def slow_path(
    law: Any, state: Floats, target: float, speed: float, rtol: float
) -> tuple[Floats, Floats, Floats, float]:
    """Twist a law in one direction until its torque is first the target [N*m].

    Parameters
    ----------
    state : (2 + z,) array
        Torsion [rad], internal states, and work [J] at the start.
    speed : float
        Torsion rate [rad/s].
    rtol : float
        Tolerance of the integration over the torsion.

    Returns
    -------
    tuple
        Torsions (n,) [rad] and torques (n,) [N*m] on the way, the state there, and the torsion where the torque was 0.

    Raises
    ------
    ValueError
        If the law does not carry the torque.
    SolveError
        If the integration does not end.
    """
    name, direction = type(law).__name__, 1.0 if target > 0.0 else -1.0
    counter = itertools.count()
    length = abs(target) / max(float(law.stiffness(0.0)), 1e-12 * abs(target))
    start = _torque(law, state, direction * speed)
    xs, ts, at_zero, largest = [], [], float(state[0]), (direction * start, float(state[0]))
    if largest[0] >= abs(target):
        raise ValueError(
            f"{name} carries {start:.4g} N*m before it is twisted towards {target:g} N*m; take more torque, less "
            "speed, or a law without torque at rest"
        )
    for _ in range(DOUBLINGS):
        run = _twisted(law, state, target, length, speed, rtol, counter)
        path = _Path(law, run.sol, direction * speed)
        end, arrived = path.first(target, float(run.t[-1]), run.status == 1)
        x, t = path.at(np.linspace(0.0, end, SAMPLES))
        xs.append(x)
        ts.append(t)
        state = run.sol(end) if end < run.t[-1] else run.y[:, -1]
        before = run.t_events[1] <= end
        if before.any():
            at_zero = float(run.y_events[1][before][-1][0])
        if arrived:
            x, t = np.concatenate(xs), np.concatenate(ts)
            pick = np.linspace(0, len(x) - 1, SAMPLES).round().astype(int)
            return x[pick], t[pick], state, at_zero
        top = int(np.argmax(direction * t))
        largest = max(largest, (float(direction * t[top]), float(x[top])))
        length *= 2.0
    carried = direction * largest[0] + 0.0  # no -0.0
    raise ValueError(
        Sentence(
            f"{name} carries at most {carried:.4g} N*m, at {{}}, and does not reach {target:g} N*m; take less torque, "
            "or put a spring in parallel",
            Angle(largest[1], digits=3),
        )
    )


def _torque(law: Any, y: Floats, rate: float) -> float:
    x, *z = y[:-1].tolist()
    return float(torque_of(law, x, rate, tuple(z)))


def _twisted(law: Any, start: Floats, target: float, length: float, speed: float, rtol: float, counter: Any) -> Any:
    """SciPy's solution over a length [rad] or until the torque is the target [N*m]; events: that, and no torque."""
    # Here, because SciPy's solvers take longer to load than most analyses, which need none.
    from scipy.integrate import solve_ivp

    name, direction = type(law).__name__, 1.0 if target > 0.0 else -1.0
    rate = direction * speed

    def rates(s: float, y: Floats) -> Any:
        torque = _torque(law, y, rate)
        if next(counter) > MOST_EVALUATIONS:
            raise SolveError(
                f"{name} was asked {MOST_EVALUATIONS} times on the way to {target:g} N*m and is "
                f"only at {torque:.4g} N*m; take less torque, a smoother law or a larger rtol"
            )
        x, *z = y[:-1].tolist()
        return [direction, *(change / speed for change in z_rate_of(law, x, rate, tuple(z))), direction * torque]

    def reached(s: float, y: Floats) -> float:
        return _torque(law, y, rate) - target

    def zero(s: float, y: Floats) -> float:
        return _torque(law, y, rate)

    reached.terminal = True  # type: ignore[attr-defined]
    tolerances = {"rtol": rtol, "atol": 1e-3 * rtol * length}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # the status says it
        run = solve_ivp(rates, (0.0, length), start, "LSODA", events=(reached, zero), dense_output=True, **tolerances)
    if run.status < 0:
        raise SolveError(f"twisting {name} to {target:g} N*m stopped: {run.message}; take another torque")
    return run


class _Path(NamedTuple):
    """Solution over the torsion's way s [rad] of a law that is twisted at a rate [rad/s]."""

    law: Any
    solution: Any
    rate: float

    def at(self, s: Floats) -> tuple[Floats, Floats]:
        """Torsions [rad] and torques [N*m]."""
        y = self.solution(s)
        return y[0], np.asarray(torque_of(self.law, y[0], self.rate, tuple(y[1:-1])) + 0.0 * s)

    def first(self, target: float, end: float, reached: bool) -> tuple[float, bool]:
        """Place where the torque is first the target, or the end, and whether it is; steps may pass over a summit."""
        side = math.copysign(1.0, target)

        def missing(s: Any) -> Any:
            return side * (self.at(s)[1] - target)

        low, high = first_reached(missing, np.linspace(0.0, end, SAMPLES))
        if math.isnan(high):
            return end, reached
        return root_between(lambda s: float(missing(s)), low, high, xtol=1e-16 * end), True
