"""Error equation of a drive: its equilibrium, the orders that excite it, and its oscillation in slow rotation."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...base.law import is_spring
from ...base.protocols import lines_of, orders_of
from ...base.results import Floats, SolveError
from ...base.series import largest_of_samples
from ...model.excitation import KinematicError, NoError, mean_torque
from ...numerics.operating_point import loaded_state
from ...theory.slow_flow.setting import active_orders

SAMPLES_PER_CYCLE = 64  # of the highest order
BEAT_TURNS, BEAT_STARTS = 500, 192  # turns in one of which the lines of a beat meet, and starts of turns in each
PEAK_AMPLIFICATION = 2.0  # times the oscillation of slow rotation, from which on a peak is one


@dataclass(frozen=True)
class OperatingPoint:
    """Equilibrium of the drive under its mean torque.

    Attributes
    ----------
    mean_torque : float
        Mean of the excitation [N*m, output side].
    x : float
        Static dynamic error [rad] under the mean torque.
    stiffness : float
        Small-signal stiffness T'(x) [N*m/rad].
    omega_0 : float
        Small-signal natural frequency [rad/s]; 0 where the law has no stiffness there (backlash).
    odd : bool
        Whether the law is odd about the operating point, so that no even terms arise.
    z : tuple of float
        Internal states of a law with memory that was loaded slowly from rest.
    """

    mean_torque: float
    x: float
    stiffness: float
    omega_0: float
    odd: bool
    z: tuple[float, ...] = ()

    @property
    def start(self) -> tuple[float, ...]:
        """State of the error equation at rest there."""
        return (self.x, 0.0, *self.z)


def operating_point(system: Any) -> OperatingPoint:
    """Find the equilibrium under the mean torque; of a law with memory the one that a slow load from rest leads to.

    Raises
    ------
    SolveError
        If the law cannot carry the mean torque.
    """
    mean, law = mean_torque(system.excitation), system.law
    try:
        x, *z = loaded_state(law, mean)
    except ValueError as error:
        raise SolveError(str(error)) from None
    odd = _is_odd(system.law, x, mean) if is_spring(system) else mean == 0.0
    stiffness = float(system.law.stiffness(x))
    return OperatingPoint(mean, x, stiffness, math.sqrt(max(stiffness, 0.0) / system.J), odd, tuple(z))


def _is_odd(law: Any, x: float, mean: float) -> bool:
    """True if a spring is odd about its torsion x [rad] under the mean torque [N*m]."""
    steps = np.geomspace(1e-6, 1.0, 25) * max(abs(x), 1e-2)
    around = law.torque(x + steps) + law.torque(x - steps) - 2.0 * mean
    size = np.abs(law.torque(x + steps)) + np.abs(law.torque(x - steps)) + abs(mean) + 1e-300
    return bool(np.all(np.abs(around) <= 1e-9 * size))


def equation_orders(equation: Any) -> tuple[float, ...]:
    """Orders on the motor's turn that excite an error equation, those of two turns included."""
    lines = [line for line in lines_of(equation.error) if line.amplitude]
    fractional = tuple(line.order for line in lines if line.order % 1)
    if fractional:
        whole = tuple(line for line in lines if not line.order % 1)
        equation = equation._replace(error=KinematicError(whole) if whole else NoError())
    return (*active_orders(equation), *fractional)


def quasi_static(system: Any, point: OperatingPoint) -> float:
    """Oscillation [rad] of a drive that follows its excitation without inertia; of a beat in its largest turn."""
    orders = tuple(orders_of(system))
    beats = any(order % 1 for order in orders)
    per_turn = SAMPLES_PER_CYCLE * math.ceil(max((1, *orders)))
    angles = 2.0 * np.pi * np.arange(BEAT_TURNS * per_turn if beats else per_turn) / per_turn
    stiffness = point.stiffness if point.stiffness > 0.0 else math.inf
    twist = (system.excitation.torque(angles) - point.mean_torque) / stiffness
    error = system.error.value(angles) + twist + 0.0 * angles
    deviation = _largest_turn(error, per_turn) if beats else error - np.mean(error)
    return float(largest_of_samples(deviation[None])[0])


def _largest_turn(error: Floats, per_turn: int) -> Floats:
    """Error (per_turn + 1,) [rad] about its mean over the turn in which it is largest, of samples of many turns."""
    step, sums = max(1, per_turn // BEAT_STARTS), np.append(0.0, np.cumsum(error))
    ends = 0.5 * (error[per_turn:] - error[:-per_turn])
    means = (sums[per_turn:-1] - sums[: -per_turn - 1] + ends) / per_turn
    turns = np.lib.stride_tricks.sliding_window_view(error, per_turn + 1)
    some, mean = turns[::step], means[::step]
    worst = step * int(np.argmax(np.maximum(some.max(axis=1) - mean, mean - some.min(axis=1))))
    return np.asarray(turns[worst] - means[worst])
