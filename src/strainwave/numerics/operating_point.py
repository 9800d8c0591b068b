"""Operating point of a law: the torsion where it carries a constant torque. Every part of the package asks here.

It is the torsion nearest to zero at which the torque is the mean one: of a law that rises at rest the first one on the
way from rest in the direction of the torque, where a slow load arrives and the stiffness is not negative. A law that
softens has a largest torque; beyond it there is no operating point. `slow_path` does the same for laws with memory, at
a rate that does not matter.
"""

import itertools
import math
import warnings
from typing import Any, NamedTuple

import numpy as np

from ..base.law import breakpoints_of, depends, states_of, torque_of, z_rate_of
from ..base.results import Floats, SolveError
from ..base.sentences import Angle, Sentence
from .roots import _largest, first_reached, root_between

TORSIONS = np.append(0.0, np.geomspace(1e-6, 1e6, 2401))  # looked at, over that of the linear law: 1.2 % apart
ROUNDING = 4e-16  # share of the mean torque by which a largest torque may fall short of it


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
