"""A control of the motor, linear about a state: its matrices, its frequency response, places around its poles."""

from typing import Any, NamedTuple

import numpy as np

from ...base.law import share, states_of, torque_of, z_rate_of
from ...base.protocols import Control
from ...base.results import Complexes, Floats
from ...model.train.controls import inertia_of

STEP = 1e-6  # of the states of a control, for differences


class LinearControl(NamedTuple):
    """A control about a state: the torque by_angle x + by_speed v + inertia v' + C z, with z' = A z + B (x, v).

    x and v are the angle as the control sees it [rad] and the motor's speed [rad/s], z its own states.
    """

    by_angle: float
    by_speed: float
    inertia: float
    A: Floats
    B: Floats
    C: Floats


def control_response(parts: LinearControl, omega: Floats) -> Complexes:
    """Torques (n, 2) of a `linear_control` against an angle as it sees it, and by its speed against the motor's."""
    by_angle, by_speed, inertia, A, B, C = parts
    s = 1j * omega
    inner = (C @ np.linalg.solve(s[:, None, None] * np.eye(len(A)) - A, B + 0j))[:, 0]
    return np.column_stack([by_angle + inner[:, 0], s * (by_speed + s * inertia + inner[:, 1])])


def around_poles(poles: Complexes, places: Floats) -> Floats:
    """Frequencies [rad/s] at poles that vibrate, and close around them at places in half widths."""
    waves = poles[poles.imag > 0.0]
    omega = waves.imag[:, None] + np.abs(waves.real)[:, None] * np.append(places, 0.0)
    return np.asarray(omega[omega > 0.0])


def control_parts(control: Control) -> LinearControl:
    """A control, linear about rest, as `linear_control` gives it."""
    count = states_of(control)
    return linear_control(control, np.zeros(4 + count), np.arange(4 + count) >= 4)


def linear_control(control: Control, state: Floats, of_control: Any) -> LinearControl:
    """A control about the state of its drive, by differences; `of_control` marks its own states."""
    z, count = state[of_control], states_of(control)
    start = np.concatenate([state[2:4], z])

    def slopes(f: Any, size: int) -> Floats:
        steps = STEP * np.eye(len(start))
        rows = [(np.reshape(f(start + d), size) - np.reshape(f(start - d), size)) / (2.0 * STEP) for d in steps]
        return np.array(rows).reshape(len(start), size).T

    def torque(y: Floats) -> Any:
        return torque_of(control, y[0], y[1], share(control, tuple(y[2:])))

    def rates(y: Floats) -> Any:
        return np.array(z_rate_of(control, y[0], y[1], share(control, tuple(y[2:]))), float)

    by, own_rates = slopes(torque, 1), slopes(rates, count)
    inertia = float(inertia_of(control))
    return LinearControl(by[0, 0], by[0, 1], inertia, own_rates[:, 2:], own_rates[:, :2], by[:, 2:])
