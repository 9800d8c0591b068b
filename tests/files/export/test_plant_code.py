"""The plant in C against Python: every law, kinematic error, friction, gravity, couplings, on recorded torques."""

import math
from typing import NamedTuple

import numpy as np
import pytest
from c_compiler import compiled, doubles, exported_parameters, needs_cc, parameters_of
from canonical import LAWS
from scipy.integrate import solve_ivp

import strainwave as sw
from strainwave.files.export.plant import OUTPUTS, plant_of
from strainwave.files.export.plant_code import plant_code
from strainwave.files.export.traced import Unrecordable

GEAR = sw.Drive(J_m=4.5e-4, J_l=1.3, N=50.0, B=40.0, law=sw.Linear(1e5))
LINES = sw.KinematicError((sw.Line(2, 1.1e-4), sw.Line(4, 3e-5, 0.7), sw.Line(100, 4e-6, -1.2)))
STIFFENING = sw.PiecewiseLinear(1e5, 1.4e5, 1.8e5, 5.0, 20.0)
RESONANCE = math.sqrt(1e5 * (1 / 1.3 + 1 / (2500 * 4.5e-4)))  # rad/s, of small motions of a free motor
CASES = {
    "linear": GEAR.train(),
    "cubic": GEAR._replace(law=sw.Cubic(1e5, 6.9e4)).train(kinematic_error=LINES),
    "three slopes": GEAR._replace(law=STIFFENING).train(kinematic_error=LINES, friction=sw.laws.LoadFriction(0.08)),
    "backlash": GEAR._replace(law=sw.Backlash(1e5, 1e-5)).train(kinematic_error=LINES),
    "hysteresis": GEAR._replace(law=sw.Parallel(STIFFENING, sw.BoucWen(2e4, 0.0, 8e-5, n=2))).train(
        kinematic_error=LINES,
        load_drag=sw.train.AngleTorque(12.0),
        motor_drag=sw.laws.LuGre(3.0, 0.02, 1e-3, 0.03, 0.05, 0.3),
    ),
    "friction": GEAR.train(
        control=sw.train.SpeedLoop(0.5, 20.0),
        kinematic_error=LINES,
        load_drag=sw.Parallel(sw.train.AngleTorque(12.0, phase=0.4), sw.laws.Stribeck(2.0, 3.0, 0.1)),
        motor_drag=sw.laws.Viscous(1e-3, warming=10.0),
    ),
    "coupling": GEAR.train(kinematic_error=LINES)._replace(
        load=sw.train.Elastic(
            0.4, 3.0, sw.Play(1e-5, sw.Cubic(3e5, 1e4)), sw.train.Load(0.9, drag=sw.laws.Coulomb(1.0))
        )
    ),
}


def assert_equal_to_1e_12(theirs, ours):
    """Each column, relative to its largest size."""
    assert np.max(np.abs(theirs - ours) / np.max(np.abs(ours), axis=0)) <= 1e-12


def recorded_torques(n=900, every=7):
    """Torque steps on both shafts, new ones every few steps, that take the train up through its resonance."""
    rng = np.random.default_rng(15)
    steps = rng.uniform(-1.0, 1.0, (2, -(-n // every))).repeat(every, axis=1)[:, :n]
    return 4.8 + 2.4 * steps[0], -8.0 + 10.0 * steps[1]


def in_parts(plant, train, y, scheme):
    """State after one step in 1, 2, 4 ... equal parts, each near enough to its length times the mean of its rates."""
    units = np.array([plant.fastest if unit == "rad/s" else 1.0 for _, unit in plant.states()])
    rate = np.array(train.rhs(0.0, y))
    done, parts, most = 0, 1, 1
    while done < parts:
        h = plant.step / parts
        after = scheme.step(train, 0.0, h, y, h)
        then = np.array(train.rhs(0.0, after))
        small = units * (1e-12 + 4e-15 * np.max(np.abs(y)))
        off = np.abs(np.subtract(after, y) - 0.5 * h * (rate + then))
        share = np.max(off / (0.02 * h * np.maximum(np.abs(rate), np.abs(then)) + small))
        if share > 1.0:
            done, parts = 2 * done, 2 * parts
            continue
        y, rate, done, most = after, then, done + 1, max(most, parts)
        if share <= 0.25 and parts > 1 and done % 2 == 0:
            done, parts = done // 2, parts // 2
    return y, most


def by_python(plant, torques, scheme):
    """Outputs (n, 6) that the library's own steps give."""
    y, found = (0.0,) * len(plant.states()), []
    for motor, load in zip(*torques, strict=True):
        y, _ = in_parts(plant, plant.under(float(motor), float(load)), y, scheme)
        found.append(plant.outputs(y))
    return np.array(found, float)


def by_c(folder, plant, torques, **changed):
    """Outputs (n, 6) that the compiled code gives, with the exported parameters or with some changed."""
    code = plant_code(plant, "joint")
    library = compiled(code.write(folder / "joint.c"))
    numbers = exported_parameters(library, "joint", code.header, **changed)
    state, out, found = doubles(*[math.nan] * len(plant.states())), doubles(*[0.0] * 6), []
    library.joint_init(state)
    for pair in zip(*torques, strict=True):
        library.joint_step(numbers, state, doubles(*pair), out)
        found.append(list(out))
    return np.array(found)


@pytest.mark.slow
@needs_cc
@pytest.mark.parametrize("name", CASES)
def test_c_gives_what_python_gives_on_recorded_torques(name, tmp_path):
    plant = plant_of(CASES[name], step=1e-4)
    torques = recorded_torques()
    ours, theirs = by_python(plant, torques, sw.Dop8().scheme), by_c(tmp_path, plant, torques)
    assert 2.0 * ours[-1, 1] > RESONANCE > 100.0 * ours[0, 1]  # orders 2, 4 and 100 have gone through it
    assert_equal_to_1e_12(theirs, ours)


RETUNED = {
    "three slopes": {"law.K2": 1.25e5, "law.T1": 6.5, "error.lines.1.phase": -0.3, "B": 55.0, "friction.mu": 0.11},
    "hysteresis": {"motor.J": 6e-4, "law.second.yield_twist": 6e-5, "load.drag.amplitude": 9.0, "N": 51.0},
    "friction": {"law.K": 8e4, "load.J": 1.1, "motor.drag.per_torque": 0.02, "load.drag.second.v_s": 0.2},
    "coupling": {"load.law.half_gap": 2e-5, "load.load.J": 0.7, "load.B": 0.0},
}


@needs_cc
@pytest.mark.parametrize("name", RETUNED)
def test_parameters_changed_in_the_struct_give_what_python_gives_for_the_changed_train(name, tmp_path):
    exported = plant_of(CASES[name], step=1e-4)
    other = plant_of(sw.replaced(CASES[name], RETUNED[name]), step=1e-4)
    torques = recorded_torques(600)
    fields = {path.replace(".", "_"): value for path, value in RETUNED[name].items()}
    theirs = by_c(tmp_path, exported, torques, **fields)
    ours = by_python(other, torques, sw.Dop8().scheme)
    assert_equal_to_1e_12(theirs, ours)
    before = by_c(tmp_path, exported, torques)
    assert np.max(np.abs(ours - before)) > 1e-3 * np.max(np.abs(before))


def test_a_number_that_decides_a_branch_and_an_integer_are_no_parameters():
    train = GEAR._replace(law=Stepwise(1e5, 2.0, 3.0)).train(kinematic_error=LINES)
    fields = parameters_of(plant_code(plant_of(train, step=1e-6), "joint").header)
    assert {"law_K", "law_scale"} <= set(fields)
    assert {"law_choice", "error_lines_0_order"}.isdisjoint(fields)


@needs_cc
@pytest.mark.parametrize("method", [sw.Rk4(), sw.Dop8()])
def test_c_takes_the_steps_of_both_methods(method, tmp_path):
    plant = plant_of(CASES["three slopes"], step=1e-4, method=method)
    torques = recorded_torques(200)
    ours, theirs = by_python(plant, torques, method.scheme), by_c(tmp_path, plant, torques)
    assert_equal_to_1e_12(theirs, ours)


@needs_cc
def test_c_follows_the_equations_of_motion_as_scipy_integrates_them(tmp_path):
    """J_m theta_m'' = T_m - (1/N - e') T, J_l theta_l'' = T_l + T, T = K u (1 + alpha u^2) + B u', written out here."""
    law = sw.Cubic(1e5, 6.9e4)
    plant = plant_of(GEAR._replace(law=law).train(kinematic_error=sw.KinematicError((sw.Line(2, 1.1e-4),))), step=1e-4)

    def rhs(_, y):
        a, w, b, v = y
        e, slope = 1.1e-4 * math.cos(2 * a), -2.2e-4 * math.sin(2 * a)
        u, rate = a / 50 - b - e, w / 50 - v - slope * w
        torque = 1e5 * u * (1 + 6.9e4 * u * u) + 40.0 * rate
        return w, (0.9 - (1 / 50 - slope) * torque) / 4.5e-4, v, (torque - 5.0) / 1.3

    start = (0.0, 0.0, 0.0, 0.0)
    run = solve_ivp(rhs, (0.0, 0.2), start, "DOP853", t_eval=[0.1, 0.2], rtol=1e-12, atol=1e-14)
    found = by_c(tmp_path, plant, (np.full(2000, 0.9), np.full(2000, -5.0)))[[999, 1999]]
    np.testing.assert_allclose(found[:, :4], run.y[[0, 1, 2, 3]].T, rtol=1e-8)


@needs_cc
@pytest.mark.parametrize(("mu", "width", "inertia", "load"), [(0.2, 1.0, 1e-5, -50.0), (0.3, 0.1, 1e-5, -18.0)])
def test_friction_under_load_is_followed_where_it_sticks(mu, width, inertia, load, tmp_path):
    """A default step is up to 80 times the time constant of the stuck motor; scipy integrates the same, written out."""
    drive = sw.Drive(J_m=inertia, J_l=1.3, N=50.0, B=40.0, law=sw.Linear(3e4))
    plant = plant_of(drive.train(friction=sw.laws.LoadFriction(mu, width)))
    motor = -load / 50.0 * (1.0 + 0.3 * mu)
    stuck = mu * abs(load) / 50.0 / width / inertia
    assert plant.step > 3.0 / stuck

    def rhs(_, y):
        a, w, b, v = y
        torque = 3e4 * (a / 50 - b) + 40.0 * (w / 50 - v)
        drag = mu * abs(torque) / 50 * w / math.hypot(w, width)
        return w, (motor - torque / 50 - drag) / inertia, v, (torque + load) / 1.3

    n = int(0.5 / plant.step)
    run = solve_ivp(rhs, (0.0, n * plant.step), (0.0,) * 4, "LSODA", rtol=1e-9, atol=1e-12)
    found = by_c(tmp_path, plant, (np.full(n, motor), np.full(n, load)))[-1]
    np.testing.assert_allclose(found[:4], run.y[:, -1], rtol=1e-5)
    assert found[5] == pytest.approx(
        3e4 * (run.y[0, -1] / 50 - run.y[2, -1]) + 40.0 * (run.y[1, -1] / 50 - run.y[3, -1])
    )


@needs_cc
def test_a_state_that_no_part_of_a_step_follows_is_refused_and_left_as_it_was(tmp_path):
    plant = plant_of(GEAR.train(friction=sw.laws.LoadFriction(0.2, 1e-9)))
    library = compiled(plant_code(plant, "joint").write(tmp_path / "joint.c"))
    header = plant_code(plant, "joint").header
    numbers, state, out = exported_parameters(library, "joint", header), doubles(*[0.0] * 4), doubles(*[7.0] * 6)
    before = (1e-3, 0.0, 0.0, 1e-10)
    state[:] = before
    assert library.joint_step(numbers, state, doubles(1.0, -50.0), out) == 1
    assert tuple(state) == before
    assert tuple(out) == (7.0,) * 6
    state[:] = (math.nan, 0.0, 0.0, 0.0)
    assert library.joint_step(numbers, state, doubles(0.0, 0.0), out) == 1
    state[:] = (0.0,) * 4
    assert library.joint_step(numbers, state, doubles(0.1, 0.0), out) == 0
    assert out[1] > 0.0


@needs_cc
def test_a_plant_that_begins_in_balance_stays_there(tmp_path):
    """Gravity of 12 N*m at 90 degrees twists the gear; 12/50 N*m of the motor hold it."""
    angle = 0.5 * math.pi
    train = GEAR._replace(law=STIFFENING).train(load_drag=sw.train.AngleTorque(12.0))
    twist = 5.0 / 1e5 + 7.0 / 1.4e5
    plant = plant_of(train, step=1e-4, start=(twist, 0.0, 50.0 * (angle + twist), 0.0))
    found = by_c(tmp_path, plant, (np.full(500, 12.0 / 50.0), np.zeros(500)))
    np.testing.assert_allclose(found[-1, [0, 2, 4, 5]], (50.0 * (angle + twist), angle, twist, 12.0), rtol=1e-9)
    np.testing.assert_allclose(found[-1, [1, 3]], 0.0, atol=1e-9)


def test_a_start_with_another_number_of_states_is_refused():
    with pytest.raises(ValueError, match=r"start is \(0\.1, 0\.0\); it must be 4 finite numbers"):
        plant_of(GEAR.train(), start=(0.1, 0.0))


@pytest.mark.parametrize("name", LAWS)
def test_every_law_can_be_recorded(name):
    code = plant_code(plant_of(GEAR._replace(law=LAWS[name]).train(), step=1e-6), "joint")
    assert "static void rates" in code.source
    assert "Traced" not in code.source


class Stepwise(NamedTuple):
    """A user's law whose numbers choose its form."""

    K: float
    scale: float
    choice: float

    def torque(self, x):
        return self.K * x * (math.exp(self.choice) if self.choice > 0.0 else 1.0) / self.scale

    def stiffness(self, x):
        return self.K * math.exp(self.choice) / self.scale + 0.0 * x


class Bent(NamedTuple):
    """A user's law with a branch."""

    K: float

    def torque(self, x):
        return self.K * x if x > 0.0 else 0.5 * self.K * x

    def stiffness(self, x):
        return self.K if x > 0.0 else 0.5 * self.K


def test_a_law_with_a_branch_is_refused_with_its_place():
    with pytest.raises(
        Unrecordable, match=r"Bent\.torque branches on a value .* line \d+: .*write it without branches"
    ):
        plant_code(plant_of(GEAR._replace(law=Bent(1e5)).train(), step=1e-6), "joint")


def test_steps_that_are_too_long_for_the_train_are_refused():
    fastest = math.sqrt(1.8e5 * (1 / 1.3 + 1 / (2500 * 4.5e-4)))  # in the third range of the law, which is the stiffest
    train = GEAR._replace(law=STIFFENING, B=0.0).train()
    assert plant_of(train, step=0.99 / fastest).step == 0.99 / fastest
    with pytest.raises(ValueError, match=r"the step is 0\.1 s but the fastest motion of the train allows"):
        plant_of(train, step=0.1)
    assert plant_of(train).step == pytest.approx(2 * math.pi / fastest / 16, rel=1e-6)


def test_the_step_counts_with_couplings_that_have_come_through_their_play():
    coupling = sw.train.Elastic(0.4, 0.0, sw.Play(1e-5, sw.Linear(3e6)), sw.train.Load(0.9))
    touching = GEAR._replace(B=0.0).train()._replace(load=coupling._replace(law=sw.Linear(3e6)))
    assert plant_of(touching._replace(load=coupling)).step == pytest.approx(plant_of(touching).step, rel=1e-6)


def test_outputs_are_those_of_the_train():
    train = CASES["coupling"]
    plant = plant_of(train, step=1e-5)
    y = tuple(np.random.default_rng(3).normal(size=len(plant.states())) * 1e-3)
    values = dict(zip((name for name, _, _ in OUTPUTS), plant.outputs(y), strict=True))
    assert values["load_angle"] == pytest.approx(y[2] / 50 - y[0] - y[4], rel=1e-13)
    assert values["pointing_error"] == pytest.approx(values["motor_angle"] / 50 - values["load_angle"], rel=1e-12)
    assert values["load_speed"] == pytest.approx(y[3] / 50 - y[1] - y[5], rel=1e-13)


@pytest.mark.parametrize("name", ["2nd", "my joint", "double", ""])
def test_names_that_c_does_not_know_are_refused(name):
    with pytest.raises(ValueError, match="is not a name in C"):
        plant_code(plant_of(GEAR.train(), step=1e-4), name)
