"""Controllers in C against their own Python, on recorded measurements."""

from typing import NamedTuple

import numpy as np
import pytest
from c_compiler import compiled, doubles, exported_parameters, needs_cc, parameters_of

import strainwave as sw
from strainwave.compile.elementwise import larger, select, smaller
from strainwave.files.export.controller import controller_code
from strainwave.files.export.plant import plant_of
from strainwave.files.export.plant_code import plant_code
from strainwave.files.export.traced import Recording, Unrecordable
from strainwave.maths import cos, sin
from strainwave.model import controllers as own
from strainwave.numerics.ensemble.loops import run_loop


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
        torque = select(lost, state.torque, -self.gain * seen.angle)
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


SAMPLE = own.Measurement(*[0.0] * 7)
PERIOD = 250e-6
ERROR = sw.KinematicError((sw.Line(2, 1.1e-4), sw.Line(4, 3e-5, 0.7)))
PLANT = sw.Drive(J_m=5e-4, J_l=1.3, N=50.0, B=40.0, law=sw.PiecewiseLinear(1e5, 1.4e5, 1.8e5, 5.0, 20.0)).train(
    control=sw.train.Commanded(), kinematic_error=ERROR, motor_drag=sw.laws.Coulomb(0.02, 0.1), omega=150.0
)
PD = own.SampledPD(K_p=25.0, K_d=0.2, period=PERIOD, filter=2e-4, J=5e-4)
OWN = {
    "SampledPD": PD,
    "Cascade": own.Cascade(120.0, 0.3, 8.0, PERIOD, filter=1e-4, J=5e-4),
    "Notch": own.notch(PD, 400.0, PERIOD),
    "DisturbanceObserver": own.DisturbanceObserver(PD, 5e-4, 300.0, PERIOD),
    "AngleFeedforward": own.AngleFeedforward(PD, ERROR, 50.0, 3e-4, 5e-4),
    "TorqueTable": own.TorqueTable(PD, sw.Harmonics((sw.Harmonic(0.1, 2, 0.4), sw.Harmonic(0.02, 4))), 3e-4),
    "InverseDynamics": own.InverseDynamics(PD, PLANT, 3e-4),
    "SpeedTable": own.SpeedTable(PD, (20.0, 60.0, 90.0), (0.1, -0.2, 0.3), (0.0, 0.1, 0.2), order=2, lead=3e-4),
    "Repetitive": own.Repetitive(PD, 50.0, 50.0, 0.3, 0.05, 0.4, PERIOD),
    "AdaptiveCancellation": own.AdaptiveCancellation(PD, 50.0, 50.0, 0.6, 0.02, PERIOD),
}


def by_c(folder, controller, record, measurement=NOTHING, **changed):
    code = controller_code(controller, measurement, "loop")
    library = compiled(code.write(folder / "loop.c"))
    numbers = exported_parameters(library, "loop", code.header, **changed)
    library.loop_update.restype = type(doubles(0.0))._type_
    state = doubles(*[9.0] * 80)
    library.loop_init(numbers, state)
    return np.array([library.loop_update(numbers, state, doubles(*row)) for row in record])


def by_python(controller, record, measurement=NOTHING):
    state, torques = controller.start(), []
    for row in record:
        state, torque = controller.update(state, type(measurement)(*row.tolist()))
        torques.append(torque)
    return np.array(torques, float)


@needs_cc
@pytest.mark.parametrize("controller", [Limited(0.8, 0.2, 1.0), Proportional(3.0)], ids=["Limited", "Proportional"])
def test_c_gives_what_python_gives_on_recorded_measurements(controller, tmp_path):
    ours = by_python(controller, RECORD)
    np.testing.assert_allclose(by_c(tmp_path, controller, RECORD), ours, rtol=1e-12, atol=1e-15)
    assert len(set(ours)) > 100


def recorded_samples(n=400):
    """A motor near its reference, and a load whose encoder is silent now and then."""
    rng = np.random.default_rng(8)
    t = PERIOD * np.arange(n)
    speed, acceleration = 100.0 + 300.0 * t, np.full(n, 300.0)
    reference = 100.0 * t + 150.0 * t * t
    motor = reference + 1e-3 * rng.normal(size=n)
    load = np.where(rng.random(n) < 0.1, np.nan, motor / 50.0 + 1e-4 * rng.normal(size=n))
    return np.column_stack([reference, speed, acceleration, motor, load, *0.1 * rng.normal(size=(2, n))])


@needs_cc
@pytest.mark.parametrize("name", OWN)
def test_every_controller_of_the_library_is_the_same_in_c(name, tmp_path):
    record = recorded_samples()
    ours = by_python(OWN[name], record, SAMPLE)
    theirs = by_c(tmp_path, OWN[name], record, SAMPLE)
    assert np.max(np.abs(theirs - ours)) <= 1e-12 * np.max(np.abs(ours))
    assert np.all(np.isfinite(ours))


def test_no_controller_of_the_library_is_left_out():
    listed = {name: getattr(own, name) for name in own.__all__}
    found = {name for name, thing in listed.items() if hasattr(thing, "start") and hasattr(thing, "update")}
    assert found - {"ClosedLoop", "Demodulator", "Tracker"} == set(OWN)  # monitors give no torque


@needs_cc
def test_the_guard_of_the_adaptive_law_trips_in_c_too(tmp_path):
    eager = OWN["AdaptiveCancellation"]._replace(gain=1e5)
    record = recorded_samples()
    ours = by_python(eager, record, SAMPLE)
    assert np.max(np.abs(by_c(tmp_path, eager, record, SAMPLE) - ours)) <= 1e-12 * np.max(np.abs(ours))
    alone = by_python(PD, record, SAMPLE)
    assert np.any(ours != alone)
    np.testing.assert_array_equal(ours[-50:], alone[-50:])  # tripped


@needs_cc
def test_plant_and_controller_in_c_close_the_loop_as_python_does(tmp_path):
    """The torque acts one sample later; in C the motor's angle is absolute, in Python it is off its reference."""
    controller, n, steps = OWN["AngleFeedforward"], 1200, 4
    run = run_loop(own.ClosedLoop(PLANT, controller, own.Sampling(PERIOD, PERIOD)), n * PERIOD, steps=steps)
    plant = plant_of(PLANT, PERIOD / steps, sw.Rk4())
    codes = plant_code(plant, "joint"), controller_code(controller, SAMPLE, "loop")
    joint, loop = (compiled(code.write(tmp_path / f"{code.name}.c")) for code in codes)
    numbers = exported_parameters(joint, "joint", codes[0].header)
    gains = exported_parameters(loop, "loop", codes[1].header)
    loop.loop_update.restype = type(doubles(0.0))._type_
    state, memory, out = doubles(0.0, 0.0, 0.0, 150.0), doubles(*[0.0] * 16), doubles(*[0.0] * 6)
    loop.loop_init(gains, memory)
    joint.joint_read(numbers, state, out)
    error, torques = np.zeros(n), [0.0]
    for k in range(n):
        error[k] = 150.0 * k * PERIOD / 50.0 - out[2]
        sample = doubles(150.0 * k * PERIOD, 150.0, 0.0, out[0], out[2], torques[-1], 0.0)
        torques.append(loop.loop_update(gains, memory, sample))
        for _ in range(steps):
            joint.joint_step(numbers, state, doubles(torques[-2], 0.0), out)
    assert np.max(np.abs(torques[1:] - run.torque)) < 1e-9 * np.max(np.abs(run.torque))
    assert np.max(np.abs(error - run.error)) < 1e-9 * np.max(np.abs(run.error))


RETUNED = {
    "SampledPD": {"K_p": 30.0, "filter": 1e-4},
    "Notch": {"loop.K_d": 0.3, "a1": 0.1},
    "AngleFeedforward": {"error.lines.0.amplitude": 2e-4, "error.lines.1.phase": 0.0},
    "InverseDynamics": {"train.law.K2": 1.3e5, "train.motor.drag.T_c": 0.0, "loop.J": 6e-4},
    "SpeedTable": {"speeds.1": 70.0, "cosines.2": -0.4},
    "Repetitive": {"gain": 5e3, "loop.K_d": 0.25},
}


@needs_cc
@pytest.mark.parametrize("name", RETUNED)
def test_a_gain_changed_in_the_struct_gives_what_python_gives_for_the_changed_controller(name, tmp_path):
    record = recorded_samples()
    ours = by_python(sw.replaced(OWN[name], RETUNED[name]), record, SAMPLE)
    fields = {path.replace(".", "_"): value for path, value in RETUNED[name].items()}
    theirs = by_c(tmp_path, OWN[name], record, SAMPLE, **fields)
    assert np.max(np.abs(theirs - ours)) <= 1e-12 * np.max(np.abs(ours))
    assert np.max(np.abs(ours - by_python(OWN[name], record, SAMPLE))) > 1e-3 * np.max(np.abs(ours))


class Starting(NamedTuple):
    """A controller whose first state is a parameter, beside one whose name C does not have, and an integer gain."""

    double: float
    gain: float

    def start(self):
        return (2.0 * self.double,)

    def update(self, state, seen):
        return state, state[0] - self.gain * seen.angle


@needs_cc
def test_a_first_state_follows_its_parameter_and_a_name_of_c_is_replaced(tmp_path):
    exported = Starting(0.5, 3)
    fields = parameters_of(controller_code(exported, NOTHING, "loop").header)
    assert fields == ["parameter_0", "gain"]
    found = by_c(tmp_path, exported, RECORD, parameter_0=-1.5, gain=2.0)
    np.testing.assert_allclose(found, by_python(Starting(-1.5, 2.0), RECORD), rtol=1e-12, atol=1e-15)


@needs_cc
def test_a_controller_without_numbers_has_a_struct_too(tmp_path):
    np.testing.assert_array_equal(by_c(tmp_path, Silent(), RECORD[:3]), 0.0)


class Silent(NamedTuple):
    """A controller without parameters."""

    def start(self):
        return ()

    def update(self, state, seen):
        return state, 0.0


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


@pytest.mark.slow
@needs_cc
@pytest.mark.parametrize("name", OWN)
@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf, 1e300])
def test_a_measurement_that_is_none_leaves_the_state_and_holds_the_torque(name, bad, tmp_path):
    """Never NaN, and what follows is as if the sample had not been; after 20 of them the torque is 0."""
    record = recorded_samples(60)
    lost = record.copy()
    lost[20, 3] = bad
    lost[30, :] = np.nan
    torques = by_c(tmp_path, OWN[name], lost, SAMPLE)
    assert np.all(np.isfinite(torques))
    if not np.isfinite(bad):
        assert torques[20] == torques[19]
        assert torques[30] == torques[29]
        without = by_c(tmp_path, OWN[name], np.delete(record, [20, 30], axis=0), SAMPLE)
        np.testing.assert_array_equal(np.delete(torques, [20, 30]), without)
    gone = np.where(np.arange(60)[:, None] >= 30, np.nan, record)
    silent = by_c(tmp_path, OWN[name], gone, SAMPLE)
    assert np.all(silent[30:50] == silent[29])
    assert np.all(silent[50:] == 0.0)


def test_operations_in_place_are_recorded_and_a_refusal_names_the_function_that_asks():
    recording = Recording()
    x = recording.given("x")
    value = x
    value += 1.0
    value *= (x < 2.0) & ~(x > 1.0)
    assert recording.code((value,))[0] == "const double a0 = x + 1.0;"
    assert "(double)(a1 != 0.0 && a3 != 0.0)" in recording.code((value,))[4]
    assert (x == "word") is False

    def asks():
        return x % 2

    with pytest.raises(Unrecordable, match="asks takes a remainder"):
        asks()
