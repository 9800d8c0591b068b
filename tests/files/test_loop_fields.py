"""The motor of a project file as engineers say it: bandwidth and damping, gains, a lag, or nothing at all."""

import math
from pathlib import Path

import numpy as np
import pytest

import strainwave as sw
from strainwave.files.reading import ProjectError, from_text

HZ = 2.0 * math.pi
DRIVE = """\
gear: {{ratio: 50, law: {{type: linear, K: 1e5 N*m/rad}}}}
motor: {{inertia: 4.5 kg*cm^2{motor}}}
load: {{inertia: 1.3 kg*m^2{load}}}
damping: {{B: 20 N*m*s/rad}}
speed: {{from: 1000 rpm, to: 2000 rpm, shaft: motor}}
excitation: {{kinematic_error: [{{order: 2, amplitude: 23 arcsec}}]}}
"""
J = 4.5e-4 + 1.3 / 50.0**2


def project(motor="", load=""):
    return from_text(DRIVE.format(motor=motor and ", " + motor, load=load and ", " + load), Path("project.yaml"))


def control(loop):
    return project(f"loop: {loop}").train.motor.control


@pytest.mark.parametrize(
    ("loop", "expected"),
    [
        ("{bandwidth: 30 Hz, damping: 0.7}", sw.train.PositionLoop(J * (30 * HZ) ** 2, 1.4 * J * 30 * HZ)),
        ("{bandwidth: 30 Hz}", sw.train.PositionLoop(J * (30 * HZ) ** 2, 1.4 * J * 30 * HZ)),
        ("{type: position, bandwidth: 200 rad/s, damping: 50 %}", sw.train.PositionLoop(J * 200.0**2, J * 200.0)),
        ("{type: speed, bandwidth: 30 Hz, damping: 1}", sw.train.SpeedLoop(J * 30 * HZ, J * (30 * HZ) ** 2 / 4.0)),
        ("{type: speed_loop, bandwidth: 30 Hz, damping: 1}", sw.train.SpeedLoop(J * 30 * HZ, J * (30 * HZ) ** 2 / 4.0)),
        ("{type: speed_loop, K_p: 0.5 N*m*s/rad, K_i: 20 N*m/rad}", sw.train.SpeedLoop(0.5, 20.0)),
        ("{type: speed, K_p: 0.5 N*m*s/rad}", sw.train.SpeedLoop(0.5)),
        ("{type: position, K_p: 30 N*m/rad, K_d: 0.3 N*m*s/rad}", sw.train.PositionLoop(30.0, 0.3)),
    ],
)
def test_a_loop_is_given_by_bandwidth_or_by_gains(loop, expected):
    found = control(loop)
    assert type(found) is type(expected)
    assert found == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("loop", ["{bandwidth: 30 Hz, lag: 0.1 ms}", "{type: speed, K_p: 0.1 N*m*s/rad, lag: 0.1 ms}"])
def test_the_lag_of_a_current_loop_is_a_state_of_the_control(loop):
    found = control(loop)
    assert found.lag == pytest.approx(1e-4, rel=1e-14)
    assert found.loop == control(loop.replace(", lag: 0.1 ms", ""))


def test_the_inertia_that_a_loop_turns_has_both_sides_of_every_coupling():
    coupling = "{inertia: 0.3 kg*m^2, law: {type: linear, K: 4e5 N*m/rad}}"
    found = project("loop: {bandwidth: 200 rad/s}", f"couplings: [{coupling}, {coupling}]")
    whole = 4.5e-4 + 1.9 / 50.0**2
    assert found.loop_inertia == pytest.approx(whole, rel=1e-14)
    assert found.train.motor.control.K_p == pytest.approx(whole * 4e4, rel=1e-12)


@pytest.mark.parametrize("loop", ["{bandwidth: 30 Hz, damping: 0.7, lag: 0.2 ms}", "{type: speed, bandwidth: 9 Hz}"])
def test_a_loop_by_bandwidth_is_written_as_its_gains_and_read_back_as_the_same(loop):
    train = project(f"loop: {loop}").train
    again = from_text(sw.project_text(train), Path("project.yaml")).train
    assert again.motor.control == train.motor.control


def test_two_couplings_in_series_stand_from_the_gear_on():
    first, second = (
        "{inertia: 0.1 kg*m^2, B: 5 N*m*s/rad, law: {type: linear, K: 4e5 N*m/rad}}",
        ("{inertia: 0.2 kg*m^2, law: {type: cubic, K: 2e5 N*m/rad, alpha: 1e3 1/rad^2}}"),
    )
    found = project("loop: {bandwidth: 30 Hz}", f"couplings: [{first}, {second}]")
    behind = sw.train.Elastic(0.2, 0.0, sw.Cubic(2e5, 1e3), sw.train.Load(1.3))
    assert found.train.load == sw.train.Elastic(0.1, 5.0, sw.Linear(4e5), behind)
    assert found.drive.J_l == pytest.approx(1.6)
    alone = project(load=f"couplings: [{first}]").train
    assert alone == project(load=f"coupling: {first}").train


def complaint(motor="", load=""):
    with pytest.raises(ProjectError) as refusal:
        project(motor, load)
    return str(refusal.value)


@pytest.mark.parametrize(
    ("loop", "said"),
    [
        ("30 Hz", "2:37: motor.loop: '30 Hz' is not a group of fields; write for example 'loop: {type: cascade, b"),
        ("{damping: 0.7}", "2:37: motor.loop.bandwidth: is missing; write for example 'bandwidth: 30 Hz'"),
        ("{bandwidth: 30 rpm}", "motor.loop.bandwidth: '30 rpm' is a speed of a shaft, not a bandwidth; write 30 Hz"),
        ("{bandwidth: 30 Hz, damping: 0}", "motor.loop.damping: '0' is not positive"),
        ("{bandwidth: 30 Hz, type: torque}", "motor.loop.type: 'torque' is not known; write one of position, speed"),
        ("{bandwidth: 30 Hz, lag: 1 mm}", "motor.loop.lag: '1 mm' is not a time; write for example 0.5 ms"),
        ("{bandwidth: 30 Hz, K_p: 1 N*m}", "2:56: motor.loop.K_p: is a gain, and bandwidth and damping give the gains"),
        ("{bandwidth: 30 Hz, lags: 1 ms}", "motor.loop.lags: unknown field; did you mean 'lag'?"),
        (
            "{bandwidth: 200 Hz, lag: 0.5 ms}",
            "is too large: a bandwidth of 200 Hz is above half the inverse lag, 159.2",
        ),
        ("{K_p: 3 N*m/rad, lag: 1 ms}", "motor.loop.type: is missing; write one of speed_loop, position_loop"),
    ],
)
def test_what_is_wrong_with_a_loop_is_said_at_its_place(loop, said):
    (line,) = [line for line in complaint(f"loop: {loop}").splitlines() if said in line]
    assert line.startswith("project.yaml:2:")


def test_coupling_beside_couplings_is_refused():
    one = "{inertia: 0.1 kg*m^2, law: {type: linear, K: 4e5 N*m/rad}}"
    assert "load: gives coupling and couplings; write one coupling" in complaint(
        load=f"coupling: {one}, couplings: [{one}]"
    )
    assert "load.couplings: has 0 items; write at least 1" in complaint(load="couplings: []")


def poles(bandwidth, damping, lag, K=1e5):
    """Poles of motor, gear and load under a lagged PD loop, from the equations written by hand."""
    K_p, K_d, N, B = J * bandwidth**2, 2.0 * damping * J * bandwidth, 50.0, 20.0
    rows = [  # of theta_m, theta_m', theta_l, theta_l', T
        [0, 1, 0, 0, 0],
        [-K / N**2 / 4.5e-4, -B / N**2 / 4.5e-4, K / N / 4.5e-4, B / N / 4.5e-4, -1 / 4.5e-4],
        [0, 0, 0, 1, 0],
        [K / N / 1.3, B / N / 1.3, -K / 1.3, -B / 1.3, 0],
        [K_p / lag, K_d / lag, 0, 0, -1 / lag],
    ]
    return np.linalg.eigvals(np.array(rows, float))


def test_a_loop_that_is_unstable_with_this_gear_is_refused_with_its_margin():
    lag, bandwidth = 1e-3, 64.0
    grows = poles(bandwidth * HZ, 0.1, lag)
    fastest = grows[np.argmax(grows.real)]
    assert fastest.real > 1.0
    said = complaint(f"loop: {{bandwidth: {bandwidth} Hz, damping: 0.1, lag: {lag} s}}")
    assert f"2:37: motor.loop: is unstable with this gear: a vibration of {abs(fastest) / HZ:.3g} Hz" in said
    assert f"grows by {fastest.real:.3g} 1/s" in said
    limit = float(said.split("up to a bandwidth of ")[1].split(" Hz")[0])
    assert max(poles(0.99 * limit * HZ, 0.1, lag).real) < 0.0 < max(poles(1.01 * limit * HZ, 0.1, lag).real)
    assert project(f"loop: {{bandwidth: {0.98 * limit} Hz, damping: 0.1, lag: {lag} s}}").train is not None
    assert project(f"loop: {{bandwidth: {bandwidth} Hz, damping: 0.1}}").train is not None  # without the lag


def test_the_poles_at_zero_of_a_hysteresis_are_no_growth_of_the_loop():
    hysteresis = "hysteresis: {type: bouc_wen, K: 6e4 N*m/rad, ratio: 0, yield_twist: 0.08 mrad}\n"

    def read(bandwidth, damping):
        loop = f", loop: {{bandwidth: {bandwidth} Hz, damping: {damping}, lag: 1 ms}}"
        return from_text(DRIVE.format(motor=loop, load="") + hysteresis, Path("project.yaml"))

    for bandwidth in np.linspace(5.0, 60.0, 23):
        assert max(poles(bandwidth * HZ, 0.7, 1e-3, K=1.6e5).real) < 0.0
        assert read(bandwidth, 0.7).train is not None
    with pytest.raises(ProjectError, match="is unstable with this gear") as error:
        read(64.0, 0.1)
    limit = float(str(error.value).split("up to a bandwidth of ")[1].split(" Hz")[0])
    below, above = (max(poles(share * limit * HZ, 0.1, 1e-3, K=1.6e5).real) for share in (0.99, 1.01))
    assert below < 0.0 < above


def test_the_margin_of_a_lagged_integral_is_that_of_routh():
    said = complaint("loop: {type: speed, K_p: 0.01 N*m*s/rad, K_i: 50 N*m/rad, lag: 1 ms}")
    # Routh on a rigid gear: K_p > lag K_i, so that K_p = J omega_b and K_i = K_p omega_b/(4 zeta^2) need
    # omega_b < 4 zeta^2/lag, with zeta^2 = K_p^2/(4 J K_i)
    limit = 0.01**2 / (J * 50.0) / 1e-3 / HZ
    assert float(said.split("up to a bandwidth of ")[1].split(" Hz")[0]) == pytest.approx(limit, rel=0.01)


def test_a_lagged_loop_without_damping_is_told_to_get_some():
    said = complaint("loop: {type: speed, K_p: 0 N*m*s/rad, K_i: 50 N*m/rad, lag: 1 ms}")
    assert "is unstable with this gear" in said
    assert "increase the damping of the loop (K_d for position, K_p for speed), or give a lag below 1 ms" in said


def test_a_file_that_names_no_motor_gives_the_three_between_which_the_answer_lies():
    motors = project().motors()
    assert list(motors) == ["held", "free", "position loop of 30 Hz, damping 0.7"]
    held, free, loop = motors.values()
    assert (held.motor.held, free.motor.free) == (True, True)
    assert loop.motor.control == control("{bandwidth: 30 Hz, damping: 0.7}")
    assert held._replace(motor=loop.motor) == loop
    assert project().train is None


@pytest.mark.parametrize(
    ("motor", "name"),
    [
        ("mode: held", "held"),
        ("mode: free", "free"),
        ("loop: {bandwidth: 12 Hz, damping: 1, type: speed}", "speed loop of 12 Hz, damping 1"),
        ("loop: {bandwidth: 12 Hz, lag: 0.2 ms}", "position loop of 12 Hz, damping 0.7, lag 0.2 ms"),
        ("loop: {type: speed, K_p: 1 N*m*s/rad}", "speed loop"),
    ],
)
def test_a_motor_that_is_named_is_the_only_one(motor, name):
    found = project(motor)
    assert list(found.motors()) == [name]
    assert found.motors()[name] == found.whole
    assert found.train in (None, found.whole)


def test_a_drive_without_a_train_has_no_motors():
    text = DRIVE.format(motor="", load="").replace("shaft: motor", "shaft: forcing")
    assert from_text(text, Path("project.yaml")).motors() == {}
