"""The datasheet's measurements on a law with hysteresis.

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
from ..quantities import checked, number
from ..results import Floats, SolveError

SMALL_LOOP = 0.04  # of the rated torque
SAMPLES = 400  # of each branch
SPEED = 1e-9  # torsion rate [rad/s] of the quasi-static loop
DOUBLINGS = 12  # a law 4000 times softer than at rest does not carry the torque
MOST = 50_000  # evaluations of a law along a branch
RTOL = 1e-10
FINEST = 1e-13  # tolerance


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
    # Here, because SciPy's solvers take longer to load than most analyses, which need none.
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
