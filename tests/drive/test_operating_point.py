"""The state in which the mean torques hold a train: under gravity, with a law that remembers how it was loaded."""

from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import strainwave as sw
from strainwave.files.reading import from_text

SPRING, HYSTERESIS = sw.Cubic(4e4, 2e4), sw.BoucWen(K=2e4, ratio=0.0, yield_twist=6e-5)
DRIVE = sw.Drive(J_m=4e-4, J_l=0.6, N=100.0, B=8.0, law=sw.Parallel(SPRING, HYSTERESIS))
GRAVITY = 30.0


def loaded_to(torque):
    """Torsion and internal state of the law that is loaded slowly from rest: SciPy's solution of dz/dx."""
    path = solve_ivp(
        lambda x, z: HYSTERESIS.z_rate(x, 1.0, tuple(z)), (0.0, 2e-3), [0.0], rtol=1e-11, atol=1e-16, dense_output=True
    )
    carried = lambda x: SPRING.torque(x) + HYSTERESIS.torque(x, 0.0, tuple(path.sol(x))) - torque  # noqa: E731
    x = brentq(carried, 0.0, 2e-3, xtol=1e-18)
    return x, path.sol(x)[0]


@pytest.mark.parametrize("control", [sw.train.SpeedLoop(0.072, 2.8), sw.train.PositionLoop(5.0, 0.1), sw.train.Held()])
@pytest.mark.parametrize("angle", [5.0, 60.0, 100.0])
def test_a_law_with_memory_is_loaded_to_the_gravity_at_the_angle_of_the_load(control, angle):
    train = DRIVE.train(control=control, load_drag=sw.train.AngleTorque(GRAVITY))
    state = dict(zip(train.state_names(), sw.study.operating_state(train, 100.0, angle=angle), strict=True))
    theta = (angle + state.get("motor deviation", 0.0)) / 100.0 - state["x"]
    x, z = loaded_to(GRAVITY * np.sin(theta))
    assert (state["x"], state["gear z1"]) == pytest.approx((x, z), rel=1e-6)


@pytest.mark.parametrize("control", [sw.train.PositionLoop(18.0, 0.03), sw.train.Held()])
@pytest.mark.parametrize("amplitude", [0.0, 2e-5])
@pytest.mark.parametrize("place", [-30.0, -3.0, -1.2, -0.5, -1e-3, 0.0, 0.3, 1.1, 2.5, 100.0])
@pytest.mark.parametrize("balance", [0.0, np.pi])
def test_a_load_near_its_balance_rests_beside_a_gap_or_in_it(control, amplitude, place, balance):
    """Angles from the balance of gravity on in half gaps; the hand-written equations of rest hold."""
    gap, K, N, pull = 5e-5, 3e4, 100.0, 5.0
    train = sw.DriveTrain(
        sw.train.Motor(2e-5, control=control), N, 10.0, sw.Play(gap, sw.Linear(K)),
        sw.train.Load(0.3, drag=sw.train.AngleTorque(pull)), 1.0, sw.KinematicError((sw.Line(2, amplitude, 0.4),)),
        sw.train.AtRest(),
    )  # fmt: skip
    angle = N * (balance + place * gap)
    state = dict(zip(train.state_names(), sw.study.operating_state(train, 0.0, angle=angle), strict=True))
    turned = state.get("motor deviation", 0.0)
    e, slope = (f(2.0 * (angle + turned) + 0.4) for f in (np.cos, np.sin))
    u = state["x"] - amplitude * e
    torque = K * np.sign(u) * max(abs(u) - gap, 0.0)
    assert torque == pytest.approx(pull * np.sin((angle + turned) / N - state["x"]), abs=1e-9 * K * gap)
    if turned:
        assert 18.0 * turned == pytest.approx(-(1.0 / N + 2.0 * amplitude * slope) * torque, abs=1e-9 * K * gap)
    if balance:
        assert abs(u) > gap  # inside the gap it would fall
    elif abs(u) < gap:
        assert state["x"] == pytest.approx(place * gap, abs=1e-6 * gap)


@pytest.mark.parametrize("control", [sw.train.SpeedLoop(0.072, 2.8), sw.train.Held()])
def test_a_run_that_begins_there_stays_there(control):
    train = DRIVE.train(
        control=control, load_drag=sw.train.AngleTorque(GRAVITY, phase=0.5), reference=sw.train.AtRest()
    )
    run = sw.drive_run(train, t=0.05)
    assert np.ptp(run.error) < 1e-4 * abs(run.error[0])


@pytest.mark.parametrize(
    "asked",
    [
        lambda train: sw.find_orbit(train),
        lambda train: sw.frequency_response(train, (90.0, 110.0)),
        lambda train: sw.numerics.parameter_response(train, "B", (7.0, 9.0)),
        lambda train: sw.numerics.shoot(train, np.zeros(len(train.state_names()))),
    ],
)
def test_gravity_at_the_load_does_not_repeat_with_a_turn_of_the_motor(asked):
    drive = DRIVE._replace(law=SPRING)
    error = sw.KinematicError((sw.Line(2, 1e-4),))
    train = drive.train(
        control=sw.train.PositionLoop(5.0, 0.1), load_drag=sw.train.AngleTorque(GRAVITY), kinematic_error=error
    )
    with pytest.raises(ValueError, match="DriveTrain does not repeat after 1 turn of the base angle"):
        asked(train._replace(omega=100.0))


@pytest.mark.slow
def test_gravity_repeats_after_as_many_turns_as_the_ratio():
    drive = DRIVE._replace(law=SPRING, N=2.0, J_m=0.1)
    train = drive.train(control=sw.train.PositionLoop(500.0, 50.0), load_drag=sw.train.AngleTorque(GRAVITY))
    orbit = sw.find_orbit(train._replace(omega=100.0), period=2)
    turn = 2.0 * np.pi / 100.0
    run = sw.simulate(train._replace(omega=100.0), np.zeros(4), np.array([0.0, 60 * turn, 61 * turn, 62 * turn]))
    start = orbit.coefficients[0] + orbit.coefficients[1::2].sum(axis=0)
    np.testing.assert_allclose(run.y[:, 1], start, rtol=1e-6, atol=1e-6 * np.max(orbit.peak))


def test_a_torque_that_vanishes_where_the_load_turns_to_ends_the_search():
    """An integrator turns the load to the angle without gravity: what is carried there is rounding, not a torque."""
    memory = sw.BoucWen(K=9e3, ratio=0.0, yield_twist=1.2e-4, beta=0.6, gamma=0.4)
    law = sw.Parallel(sw.catalogue.gear("SHG-20-80").law, memory)
    control = sw.train.CascadeLoop(35.0, 0.028, 18e-3)
    train = sw.Drive(J_m=1.1e-4, J_l=0.35, N=80.0, B=4.5, law=law).train(
        control=control, motor_drag=sw.laws.Viscous(1.5e-4), load_drag=sw.train.AngleTorque(26.0)
    )
    for speed in (31.4159, 100.0, 314.0):
        state = dict(zip(train.state_names(), sw.study.operating_state(train, speed), strict=True))
        holding = 1.5e-4 * speed * 18e-3 / 0.028  # the integral that gives what the drag takes
        np.testing.assert_allclose(np.abs(list(state.values())), [0.0] * 4 + [holding, 0.0], rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize(
    ("asked", "sentence"),
    [
        ({"speed": np.nan}, "speed is nan; it must be a finite number"),
        ({"speed": 1.0, "angle": np.inf}, "angle is inf; it must be a finite number"),
        ({"speed": 1.0, "near": (1e-3,)}, r"near is \(0\.001,\); it must be 2 finite numbers"),
        ({"speed": 1.0, "near": (1e-3, np.nan)}, r"near is .*; it must be 2 finite numbers"),
    ],
)
def test_a_speed_an_angle_or_a_start_that_is_none_is_refused_in_one_sentence(asked, sentence):
    with pytest.raises(ValueError, match=sentence):
        sw.study.operating_state(DRIVE.train(control=sw.train.SpeedLoop(0.072, 2.8)), **asked)


@pytest.mark.slow
@pytest.mark.parametrize("answer", [lambda p: p.response(), sw.tune], ids=["response", "tune"])
def test_a_law_that_cannot_carry_the_mean_torque_is_the_reason_that_is_said(answer):
    # T = K x (1 - 3000 x^2) is largest at x = 1/sqrt(9000), where it is 2/3 K x
    project = from_text(
        """
gear: {ratio: 100, law: {type: cubic, K: 3e4 N*m/rad, alpha: -3000 1/rad^2}}
motor: {inertia: 4.5 kg*cm^2, loop: {bandwidth: 40 Hz}}
load: {inertia: 3 kg*m^2}
damping: {ratio: 5 %}
speed: {from: 300 rpm, to: 3000 rpm, shaft: motor}
excitation: {kinematic_error: [{order: 2, amplitude: 15 arcsec}], load_torque: {mean: -1e4 N*m}}
""",
        Path("soft.yaml"),
    )
    with pytest.raises(sw.SolveError, match=rf"Cubic carries at most {2e4 / 9000**0.5:.6g} N\*m, .* 10000 N\*m"):
        answer(project)
