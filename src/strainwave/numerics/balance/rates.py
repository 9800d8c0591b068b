"""Rates of a system for the balance equations, their derivatives, the number of states, and the test of repetition.

With a `strength` s what varies with the base angle at a fixed state is multiplied there: f = m + s (f - m), with the
mean m over the angles `turn`, if any.
"""

import itertools
import math
from typing import Any

import numpy as np

from ...base.law import is_spring, repeating
from ...base.protocols import Balance, System, has_jacobian, lacking, omega_of
from ...base.quantities import positive_count
from ...base.results import Floats
from ...compile.jit import routine
from ..addressed import rates_of

MOST_STATES = 64
STATE, EQUAL = 1e-4, 1e-8  # size of the states, and of the largest rate, where a system is asked whether it repeats
SAME = ("J", "B", "law", "excitation", "omega", "error")  # what a system of the form of `Oscillator` has
DIFFERENCE = 6e-6  # of a state's size: the cube root of rounding, for central differences


def base_speed(problem: Balance, values: Any) -> Any:
    """Base frequency [rad/s] at values of a problem's parameter."""
    return values if problem.leaf == problem.omega_leaf else omega_of(problem.system) + 0.0 * values


def rates_at(system: System, angles: Floats, y: Floats) -> Floats:
    """Rates (states, ...) of a system in the states y (states, ...) at base angles [rad]."""
    return np.array([np.broadcast_to(rate, y.shape[1:]) for rate in system.rhs(angles, tuple(y))], float)


def jacobians_at(system: Any, angles: Floats, y: Floats, sizes: Floats, difference: float = DIFFERENCE) -> Floats:
    """Derivatives (states, states, ...) of the rates by the states; by central differences if the system has none.

    `difference` is half of each, in units of the states' `sizes`. An `Oscillator` knows them for a law
    torque(x) alone.
    """
    if has_jacobian(system):
        rows = system.jacobian(angles, tuple(y))
        return np.array([[np.broadcast_to(entry, y.shape[1:]) for entry in row] for row in rows], float)
    n, d = len(y), difference * np.asarray(sizes)
    moved = y[..., None] + np.hstack([np.diag(d), -np.diag(d)]).reshape(n, *[1] * (y.ndim - 1), 2 * n)
    everywhere = np.broadcast_to(np.asarray(angles)[..., None], moved.shape[1:]).ravel()
    columns = moved.reshape(n, -1)
    try:
        rates = rates_at(system, everywhere, columns).reshape(moved.shape)
    except (TypeError, ValueError):  # a law that takes numbers alone
        pairs = zip(everywhere, columns.T, strict=True)
        rates = np.stack([rates_at(system, np.asarray(angle), y) for angle, y in pairs], axis=-1).reshape(moved.shape)
    return np.moveaxis((rates[..., :n] - rates[..., n:]) / (2.0 * d), -1, 1)


@routine
def strengthened(system: Any, angle: float, y: Floats, turn: Any, strength: float, w: Floats) -> None:
    """Write the rates of a system of a strength at an angle [rad] in several states y (n, states) to w[0].

    w (3, n, states) is a buffer.
    """
    rates_of(system, angle, y, w[0])
    if len(turn) == 0:
        return
    w[1] = 0.0
    for other in turn:
        rates_of(system, other, y, w[2])
        for i in range(y.shape[0]):
            for j in range(y.shape[1]):
                w[1, i, j] += w[2, i, j] / len(turn)
    for i in range(y.shape[0]):
        for j in range(y.shape[1]):
            w[0, i, j] = w[1, i, j] + strength * (w[0, i, j] - w[1, i, j])


def of_strength(of: Any, system: System, angles: Floats, y: Floats, turn: Floats, strength: float) -> Floats:
    """Rates or derivatives of a strength, by what gives those of a system in states at base angles [rad]."""
    mean = of(system, turn, np.broadcast_to(y[..., None], (*y.shape, len(turn)))).mean(axis=-1)
    return np.asarray(mean + strength * (of(system, angles, y) - mean))


def number_of_states(system: System) -> int:
    """Number of states that `rhs` takes: the smallest of which it returns as many rates.

    Raises
    ------
    TypeError
        If there is none.
    """
    for n in range(1, MOST_STATES + 1):
        try:
            with np.errstate(all="ignore"):
                if len(system.rhs(np.zeros(1), tuple(np.zeros((n, 1))))) == n:
                    return n
        except (IndexError, ValueError):  # it takes more
            continue
    name = type(system).__name__
    raise TypeError(f"{name}.rhs(phase, y) returns as many rates as y has states for no number up to {MOST_STATES}")


def is_second_order(system: System) -> bool:
    """True for a system J x'' + B u' + T(u) = tau, with the fields of `Oscillator` and a law torque(x)."""
    return not lacking(system, *SAME) and is_spring(system)


def periodic(verb: str, system: System, turns: int = 1) -> Any:
    """Return the system, or refuse one whose rates differ so many turns of the base angle apart (ValueError).

    An oscillator with orders on its base angle repeats by its form; others are asked at two states.
    """
    system, turns = repeating(verb, system), positive_count("period", turns)
    if is_second_order(system) or lacking(system, "rhs"):
        return system
    places = list(itertools.product((0.0, 1.0, 2.5), (0.0, STATE)))
    states, later = number_of_states(system), 2.0 * math.pi * turns
    with np.errstate(all="ignore"):
        rates = np.array([[system.rhs(phase + by, (y,) * states) for phase, y in places] for by in (0.0, later)], float)
    if np.any(np.abs(rates[1] - rates[0]) > EQUAL * np.nanmax(np.abs(rates), initial=0.0)):
        raise ValueError(
            f"{type(system).__name__} does not repeat after {turns} turn{'s' if turns > 1 else ''} of the base angle; "
            f"{verb} takes what repeats: with gravity at the load give the number of motor turns after which it "
            "does, the ratio, as period where there is one, or use simulate or drive_run"
        )
    return system
