"""The datasheet's measurements on a law with hysteresis, and a law fitted to the datasheet's values.

The input is locked and the torque at the output goes slowly 0 -> +T -> -T -> +T. `hysteresis loss` is the width of that
loop at zero torque after full load; `lost motion` is the difference of torsion between the ends of a small loop, at
+-4 % of the rated torque (Harmonic Drive catalogues, "hysteresis loss" and "lost motion").
"""

import itertools
import warnings
from dataclasses import dataclass
from typing import Any

import numpy as np

from .._dispatch import check_law, states_of, torque_of, z_rate_of
from ..model.hysteresis import BoucWen, Parallel
from ..model.laws import PiecewiseLinear
from ..quantities import checked, number, shown
from ..results import Floats, SolveError

SMALL_LOOP = 0.04  # of the rated torque
SAMPLES = 400  # of each branch
SPEED = 1e-9  # torsion rate [rad/s] of the quasi-static loop
DOUBLINGS = 12  # a law 4000 times softer than at rest does not carry the torque
MOST = 50_000  # evaluations of a law along a branch
RTOL = 1e-10
FINEST = 1e-13  # tolerance
RTOL_OF_FIT = 1e-7
INSIDE = 0.8  # of full load: up to there the two branches of a loop are apart


@dataclass(frozen=True)
class HysteresisLoop:
    """Torsion against torque, 0 -> +T -> -T -> +T, with the input locked.

    Attributes
    ----------
    torque, torsion : (n,) arrays
        The path [N*m], [rad]; the three branches one after the other, equally long.
    loss : float
        Hysteresis loss [rad]: width of the loop at zero torque.
    span : float
        Torsion [rad] from -T to +T.
    energy : float
        Area of the loop [J]: what one cycle dissipates.
    """

    torque: Floats
    torsion: Floats
    loss: float
    span: float
    energy: float

    def middle(self, torque: float) -> float:
        """Torsion [rad] midway between unloading and loading at a torque [N*m] inside the loop."""
        n = len(self.torque) // 3
        down, up = slice(n, 2 * n), slice(2 * n, None)
        on_the_way_down = np.interp(-torque, -self.torque[down], self.torsion[down])
        return float(0.5 * (on_the_way_down + np.interp(torque, self.torque[up], self.torsion[up])))


def hysteresis_loop(law: Any, torque: float, *, speed: float = SPEED, rtol: float = RTOL) -> HysteresisLoop:
    """Twist a law slowly through 0 -> +T -> -T -> +T and measure the loop.

    Parameters
    ----------
    law : NamedTuple
        Any law; at rest and without torque at the start.
    torque : float
        Full load T [N*m].
    speed : float
        Torsion rate [rad/s]. It does not matter for a rate-independent law (springs, `BoucWen`); dry friction smoothed
        over a width shows only well above that width, viscous friction only at a speed.
    rtol : float
        Tolerance of the integration along the loop.

    Returns
    -------
    HysteresisLoop

    Raises
    ------
    ValueError
        If the torque or speed is not positive, or the law does not carry the torque.
    TypeError
        If `law` is no law.
    SolveError
        If the law is so rough that the integration does not end.
    """
    law = _twistable(law)
    torque, speed = number("torque [N*m]", torque, positive=True), number("speed [rad/s]", speed, positive=True)
    if not FINEST <= (rtol := number("rtol", rtol)) < 1.0:
        raise ValueError(f"rtol is {rtol:g}; it must be from {FINEST:g}, where rounding begins, to below 1")
    state = np.zeros(2 + states_of(law))  # torsion, internal states, work
    branches, at_zero, work, ends = [], [], [], []
    for target in (torque, -torque, torque):
        x, t, state, zero = _branch(law, state, target, speed, rtol)
        branches.append((t, x))
        at_zero.append(zero)
        work.append(float(state[-1]))
        ends.append(float(state[0]))
    return HysteresisLoop(
        np.concatenate([t for t, _ in branches]),
        np.concatenate([x for _, x in branches]),
        at_zero[1] - at_zero[2],
        ends[2] - ends[1],
        work[2] - work[0],
    )


def loaded_state(law: Any, torque: float) -> tuple[float, ...]:
    """Torsion [rad] and internal states of a law that was loaded slowly from rest to a torque [N*m].

    Raises
    ------
    ValueError
        If the law does not carry the torque.
    """
    state = np.zeros(2 + states_of(law))
    if torque != 0.0:
        state = _branch(law, state, torque, SPEED, RTOL)[2]
    return tuple(state[:-1].tolist())


def _twistable(law: Any) -> Any:
    """Checked law that has a torque and a stiffness."""
    law = checked(law)
    missing = [method for method in ("torque", "stiffness") if not hasattr(law, method)]
    if missing:
        raise TypeError(f"{type(law).__name__} has no {missing[0]}; give a law such as Parallel(spring, BoucWen(...))")
    check_law("the law", law)
    return law


def lost_motion(law: Any, rated_torque: float, *, share: float = SMALL_LOOP, speed: float = SPEED) -> float:
    """Lost motion [rad]: torsion between the ends of a loop at +-share (4 %) of the rated torque [N*m]."""
    rated = number("rated_torque [N*m]", rated_torque, positive=True)
    return hysteresis_loop(law, number("share", share, positive=True) * rated, speed=speed).span


def _branch(law: Any, state: Floats, target: float, speed: float, rtol: float) -> tuple[Floats, Floats, Floats, float]:
    """Torsions and torques until the torque is the target, the state there, and the torsion where it is zero."""
    # Here and in `fit_hysteresis`, because SciPy's solvers take longer to load than most analyses, which need none.
    from scipy.integrate import solve_ivp

    direction = 1.0 if target > 0.0 else -1.0

    def torque(y: Floats) -> float:
        return float(torque_of(law, float(y[0]), direction * speed, tuple(y[1:-1].tolist())))

    evaluations = itertools.count()

    def rates(s: float, y: Floats) -> Any:
        if next(evaluations) > MOST:
            raise SolveError(
                f"{type(law).__name__} was asked {MOST} times on the way to {target:g} N*m and is only at "
                f"{torque(y):.4g} N*m; take less torque, a smoother law or a larger rtol"
            )
        z_rates = z_rate_of(law, float(y[0]), direction * speed, tuple(y[1:-1].tolist()))
        return [direction, *(rate / speed for rate in z_rates), direction * torque(y)]

    def reached(s: float, y: Floats) -> float:
        return torque(y) - target

    def zero(s: float, y: Floats) -> float:
        return torque(y)

    reached.terminal = True  # type: ignore[attr-defined]
    length = abs(target) / max(float(law.stiffness(0.0)), 1e-12 * abs(target))
    xs, ts, at_zero = [], [], float(state[0])
    if direction * torque(state) >= abs(target):
        raise ValueError(
            f"{type(law).__name__} carries {torque(state):.4g} N*m before it is twisted towards {target:g} N*m; take "
            "more torque, less speed, or a law without torque at rest"
        )
    for _ in range(DOUBLINGS):
        tolerances = {"rtol": rtol, "atol": 1e-3 * rtol * length}
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)  # the status says it
            run = solve_ivp(
                rates, (0.0, length), state, "LSODA", events=(reached, zero), dense_output=True, **tolerances
            )
        if run.status < 0:
            raise SolveError(
                f"twisting {type(law).__name__} to {target:g} N*m stopped: {run.message}; take another torque"
            )
        s = np.linspace(0.0, run.t[-1], SAMPLES)
        y = run.sol(s)
        xs.append(y[0])
        ts.append(torque_of(law, y[0], direction * speed, tuple(y[1:-1])) + 0.0 * s)
        state = run.y[:, -1]
        if len(run.y_events[1]):
            at_zero = float(run.y_events[1][-1][0])
        if len(run.t_events[0]):
            x, t = np.concatenate(xs), np.concatenate(ts)
            pick = np.linspace(0, len(x) - 1, SAMPLES).round().astype(int)
            return x[pick], t[pick], state, at_zero
        length *= 2.0
    raise ValueError(
        f"{type(law).__name__} carries {torque(state):.4g} N*m at {state[0]:.3g} rad and does not reach {target:g} "
        "N*m; take less torque, or put a spring in parallel"
    )


@dataclass(frozen=True)
class HysteresisFit:
    """A law with hysteresis that meets a datasheet.

    Attributes
    ----------
    law : Parallel or BoucWen
        The law.
    loss, lost_motion : float
        Its hysteresis loss and lost motion [rad], measured as the datasheet does.
    misfit : dict of str to float
        Relative differences from the datasheet: "hysteresis loss", "lost motion", and the torsion midway between
        unloading and loading at T1, T2 and half load (as far as they are below 80 % of full load).
    """

    law: Any
    loss: float
    lost_motion: float
    misfit: dict[str, float]

    def __str__(self) -> str:
        parts = ", ".join(f"{name} {100.0 * value:+.2g} %" for name, value in self.misfit.items())
        return f"{self.law}\n  off the datasheet by: {parts}"


def fit_hysteresis(
    spring: PiecewiseLinear, hysteresis_loss: float, lost_motion: float, *, rated_torque: float,
    load: float | None = None, replace_spring: bool = False, n: int = 1, tolerance: float = 0.05,
) -> HysteresisFit:  # fmt: skip
    """Fit Bouc-Wen hysteresis to a datasheet: stiffness, hysteresis loss and lost motion.

    In parallel with the gear's spring (whose slopes stay) an element with ratio = 0, A = 1, beta = gamma = 1/2 carries
    at most the torque T_h; its two unknowns, T_h and the yield twist, are set by hysteresis loss and lost motion.
    Replacing the spring, a `BoucWen` of unknown K, ratio and yield twist meets the torsions too; it can only soften, so
    that gears whose K3 is well above K1 are refused.

    Parameters
    ----------
    spring : PiecewiseLinear
        K1, K2, K3, T1, T2 of the datasheet.
    hysteresis_loss, lost_motion : float
        Of the datasheet [rad].
    rated_torque : float
        Of the datasheet [N*m]; lost motion is taken at +-4 % of it.
    load : float, optional
        Full load [N*m] of the hysteresis loop. Default: the rated torque.
    replace_spring : bool
        Whether the law replaces the spring.
    n : int
        Exponent of Bouc-Wen: the larger, the sharper the yield.
    tolerance : float
        Largest relative misfit that is accepted.

    Returns
    -------
    HysteresisFit

    Raises
    ------
    ValueError
        If a number is not positive.
    TypeError
        If the spring is no `PiecewiseLinear`.
    SolveError
        If the values cannot be met; the sentence says by how much.
    """
    if not isinstance(spring, PiecewiseLinear):
        raise TypeError(
            f"the spring is {shown(spring)}; it must be the datasheet's PiecewiseLinear(K1, K2, K3, T1, T2), for "
            "example catalogue.gear('CSG-40-50').law"
        )
    spring = checked(spring)
    names = ("hysteresis_loss [rad]", "lost_motion [rad]", "rated_torque [N*m]", "tolerance")
    values = (hysteresis_loss, lost_motion, rated_torque, tolerance)
    wanted_loss, wanted_motion, rated, tolerance = (
        number(name, value, positive=True) for name, value in zip(names, values, strict=True)
    )
    full = rated if load is None else number("load [N*m]", load, positive=True)
    small = SMALL_LOOP * rated
    places = sorted({t for t in (spring.T1, spring.T2, 0.5 * full) if t <= INSIDE * full})
    labels = ["hysteresis loss", "lost motion", *(f"torsion at {t:g} N*m" for t in places)]

    def law_of(p: Floats) -> Any:
        if replace_spring:
            K, twist = (float(value) for value in np.exp(p[:2]))
            return BoucWen(K, float(1.0 / (1.0 + np.exp(-p[2]))), twist, 1.0, 0.5, 0.5, n)
        limit, twist = (float(value) for value in np.exp(p[:2]))
        return Parallel(spring, BoucWen(limit / twist, 0.0, twist, 1.0, 0.5, 0.5, n))

    def misfit(p: Floats, rtol: float = RTOL_OF_FIT) -> Floats:
        law = law_of(p)
        loop = hysteresis_loop(law, full, rtol=rtol)
        measured = [loop.loss / wanted_loss, hysteresis_loop(law, small, rtol=rtol).span / wanted_motion]
        return np.array([*measured, *(loop.middle(t) / _torsion(spring, t) for t in places)]) - 1.0

    start = [spring.K1, wanted_loss] if replace_spring else [0.5 * spring.K1 * wanted_loss, 0.25 * wanted_loss]
    p0 = np.log(start + ([1.0] if replace_spring else []))
    weights = np.ones(len(labels)) if replace_spring else np.array([1.0, 1.0, *[1e-4] * len(places)])
    from scipy.optimize import least_squares

    found = least_squares(lambda p: weights * misfit(p), p0, bounds=(p0 - 12.0, p0 + 12.0), xtol=1e-6, diff_step=1e-3)
    off = dict(zip(labels, (float(value) for value in misfit(found.x, RTOL)), strict=True))
    law = law_of(found.x)
    worst = max(off, key=lambda name: abs(off[name]))
    if abs(off[worst]) > tolerance:
        elastic = 2.0 * small / spring.K1
        raise SolveError(
            f"no such law meets the datasheet: {worst} is off by {100.0 * off[worst]:+.3g} %; with this spring the "
            f"lost motion is below {elastic:.3g} rad (the spring alone) and falls as the hysteresis loss grows: a "
            "datasheet's 'less than' is a limit and not a value, give smaller ones, a softer spring, or Play"
        )
    return HysteresisFit(law, wanted_loss * (1.0 + off[labels[0]]), wanted_motion * (1.0 + off[labels[1]]), off)


def _torsion(spring: PiecewiseLinear, torque: float) -> float:
    """Torsion [rad] of the datasheet's curve at a torque [N*m] >= 0."""
    first = min(torque, spring.T1) / spring.K1
    second = max(0.0, min(torque, spring.T2) - spring.T1) / spring.K2
    return first + second + max(0.0, torque - spring.T2) / spring.K3
