"""Controllers in C against their own Python, on recorded measurements."""

from typing import NamedTuple

import numpy as np
import pytest
from c_compiler import compiled, doubles, needs_cc

from strainwave.files.export.controller import controller_code
from strainwave.files.export.traced import Unrecordable
from strainwave.maths import cos, sin
from strainwave.numerics.choices import larger, smaller


class Seen(NamedTuple):
    """A measurement."""

    reference: float
    angle: float
    speed: float


class Limited(NamedTuple):
    """PI with a limit, anti-windup, a notch of two old samples, and a term at an order of the angle."""

    K_p: float
    K_i: float
    limit: float
    order: int = 2

    def start(self):
        return (0.25, (0.0, -0.5))

    def update(self, state, seen):
        integral, (last, before) = state
        error = seen.reference - seen.angle
        wanted = self.K_p * error + integral - 0.1 * seen.speed + 0.3 * (last - before)
        wanted = wanted + 0.05 * cos(self.order * seen.angle) - 0.02 * sin(self.order * seen.angle)
        torque = smaller(larger(wanted, -self.limit), self.limit)
        free = (abs(wanted) < self.limit) * 1.0
        return (integral + free * self.K_i * error, (error, last)), torque


class Holding(NamedTuple):
    """Holds its torque where the measurement is not a number."""

    gain: float

    def start(self):
        return Held(0.0)

    def update(self, state, seen):
        lost = (seen.angle != seen.angle) | (seen.speed != seen.speed)
        torque = np.where(lost, state.torque, -self.gain * seen.angle)
        return Held(torque), torque


class Held(NamedTuple):
    """A state by name."""

    torque: float


class Proportional(NamedTuple):
    """A controller without a state."""

    gain: float

    def start(self):
        return ()

    def update(self, state, seen):
        return state, -self.gain * seen.angle


class Counting(NamedTuple):
    """A controller with a whole number in its state."""

    gain: float

    def start(self):
        return (0,)

    def update(self, state, seen):
        return state, 0.0


class Deciding(NamedTuple):
    """A controller with a branch."""

    gain: float

    def start(self):
        return (0.0,)

    def update(self, state, seen):
        if abs(seen.angle) > 1.0:
            return state, 0.0
        return state, -self.gain * seen.angle


RECORD = np.random.default_rng(4).normal(size=(400, 3))
NOTHING = Seen(0.0, 0.0, 0.0)


def by_c(folder, controller, record):
    library = compiled(controller_code(controller, NOTHING, "loop").write(folder / "loop.c"))
    library.loop_update.restype = type(doubles(0.0))._type_
    state = doubles(*[9.0] * 8)
    library.loop_init(state)
    return np.array([library.loop_update(state, doubles(*row)) for row in record])


def by_python(controller, record):
    state, torques = controller.start(), []
    for row in record:
        state, torque = controller.update(state, Seen(*row.tolist()))
        torques.append(torque)
    return np.array(torques, float)


@needs_cc
@pytest.mark.parametrize("controller", [Limited(0.8, 0.2, 1.0), Proportional(3.0)], ids=["Limited", "Proportional"])
def test_c_gives_what_python_gives_on_recorded_measurements(controller, tmp_path):
    ours = by_python(controller, RECORD)
    np.testing.assert_allclose(by_c(tmp_path, controller, RECORD), ours, rtol=1e-12, atol=1e-15)
    assert len(set(ours)) > 100


@needs_cc
def test_the_limit_is_met_from_both_sides(tmp_path):
    torques = by_c(tmp_path, Limited(0.8, 0.2, 1.0), RECORD)
    assert np.max(torques) == 1.0
    assert np.min(torques) == -1.0


@needs_cc
def test_lost_measurements_hold_the_torque(tmp_path):
    record = np.where(np.arange(9)[:, None] % 3 == 1, np.nan, RECORD[:9])
    torques = by_c(tmp_path, Holding(2.0), record)
    np.testing.assert_array_equal(torques, by_python(Holding(2.0), record))
    np.testing.assert_array_equal(torques[1::3], torques[::3])
    assert np.all(np.isfinite(torques))


def test_what_is_no_controller_is_refused():
    with pytest.raises(Unrecordable, match=r"Deciding\.update branches on a value .* in line \d+"):
        controller_code(Deciding(1.0), NOTHING, "loop")
    with pytest.raises(
        TypeError, match=r"Counting\.start\(\) has the whole number 0 at 0; a state is a tuple of floats"
    ):
        controller_code(Counting(1.0), NOTHING, "loop")
    with pytest.raises(TypeError, match=r"the controller is .*; it must be an object with a method start"):
        controller_code(NOTHING, NOTHING, "loop")
    with pytest.raises(TypeError, match=r"the measurement is 3; it must be a NamedTuple of floats"):
        controller_code(Proportional(1.0), 3, "loop")
