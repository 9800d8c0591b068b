"""Shafts with dry friction slide and stick: closed forms, and event-located integration of equations by hand."""

import json
import random

import numpy as np
import pytest
from click.testing import CliRunner
from dry_inertias import ARCSEC, DryInertias, Friction, drawn

import strainwave as sw
from strainwave.app.commands.cli import cli
from strainwave.drive.friction.stick_slip import in_time
from strainwave.files.reading import ProjectError, from_text
from strainwave.study.speed_map.ramp import ramp_of

NO_GEAR, J_M, J_L, N = sw.Linear(0.0), 2e-4, 1.5, 100.0


def apart(motor, load, excitation=None):
    """Motor and load that no gear ties together."""
    shafts = sw.train.Motor(J_M, drag=motor), sw.train.Load(J_L, drag=load)
    if excitation is not None:
        shafts = shafts[0]._replace(excitation=excitation), shafts[1]
    return sw.train.DriveTrain(shafts[0], N, 0.0, NO_GEAR, shafts[1], reference=sw.train.AtRest())


def test_a_sliding_shaft_stops_after_its_speed_over_its_deceleration_and_stays():
    T_m, T_l, v_m, v_l = 0.05, 2.0, 40.0, -0.8
    run = sw.drive_run(
        apart(sw.laws.Coulomb(T_m), sw.laws.Coulomb(T_l)), [0.0, v_m / N - v_l, 0.0, v_m], np.linspace(0.0, 2.0, 401)
    )
    turned = run.trajectory.y[2, -1], run.trajectory.y[2, -1] / N - run.trajectory.y[0, -1]
    assert turned == pytest.approx((0.5 * J_M * v_m**2 / T_m, -0.5 * J_L * v_l**2 / T_l), rel=1e-9)
    for speed, end in ((run.motor_speed, v_m * J_M / T_m), (run.load_speed, -v_l * J_L / T_l)):
        assert np.max(np.abs(speed[run.trajectory.t > end])) < 1e-11
        assert np.all(np.abs(speed[run.trajectory.t < end]) > 0.0)
    assert run.work["motor drag"][-1] == pytest.approx(0.5 * J_M * v_m**2, rel=1e-9)
    assert run.imbalance < 1e-9


def test_a_torque_below_the_break_away_moves_nothing_and_one_above_it_moves_by_the_excess():
    stribeck = sw.laws.Stribeck(0.05, 0.08, 1.0)
    still = sw.drive_run(apart(stribeck, NO_GEAR, sw.Harmonic(0.079)), None, np.linspace(0.0, 3.0, 50))
    assert np.max(np.abs(still.motor_speed)) < 1e-12
    mean = sw.Harmonic(0.0, mean=0.081)
    moved = sw.drive_run(apart(sw.laws.Coulomb(0.08), NO_GEAR, mean), None, np.linspace(0.0, 3.0, 50))
    assert moved.motor_speed[-1] == pytest.approx(0.001 / J_M * 3.0, rel=1e-6)


@pytest.mark.slow
def test_a_load_behind_a_coupling_sticks_until_the_coupling_has_wound_up():
    # The gear's output is moved by a ramp of a held motor; the load breaks away at T_s, and the coupling has T_s/K.
    K, T_s, speed = 2e3, 5.0, 0.02
    load = sw.train.Elastic(0.1, 8.0, sw.Linear(K), sw.train.Load(J_L, drag=sw.laws.Stribeck(4.0, T_s, 0.05)))
    motor = sw.train.Motor(J_M, control=sw.train.Held())
    train = sw.train.DriveTrain(motor, N, 300.0, sw.Linear(1e6), load, omega=speed * N)
    run = sw.drive_run(train, [0.0, 0.0, 0.0, speed], np.linspace(0.0, 0.25, 2001))
    first = np.flatnonzero(np.abs(run.load_speed) > 1e-9)[0]
    passed = K * run.trajectory.y[2] + 8.0 * run.trajectory.y[3]
    assert passed[first] == pytest.approx(T_s, rel=2e-3)
    assert np.max(passed[:first]) <= T_s * (1.0 + 1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [3, 5])
def test_moves_with_dry_friction_agree_with_an_integration_that_locates_every_stop(seed):
    draw = random.Random(seed)
    drive, angle, time = drawn(draw), draw.uniform(0.3, 1.0), 0.4
    train = drive.train()
    found = sw.move(train, sw.Trapezoid(angle, time), tail=0.4)
    start = drive.own(train, sw.drive_run(train, None, 1e-9).trajectory.y[:, 0])
    t, error = own_move(drive, start, angle, time)
    assert found.pointing_error[-1] == pytest.approx(error[-1], abs=0.01 * ARCSEC)
    assert found.peak_error == pytest.approx(np.max(np.abs(error)), rel=1e-4)
    assert np.interp(t, found.time, found.pointing_error) == pytest.approx(error, abs=2e-3 * found.peak_error)


@pytest.mark.slow
def test_a_motor_that_dry_friction_holds_is_not_told_as_settled():
    train = STICKY.train()
    held = sw.move(train.with_motor(drag=sw.laws.Coulomb(1e6)), sw.Trapezoid(0.1, 0.3), tail=0.1)
    assert held.settling_times == (None,)
    assert "The motor does not move: dry friction holds the motor during the whole move." in held.remarks
    assert held.peak_error == pytest.approx(0.1, rel=1e-6)


@pytest.mark.slow
def test_while_one_shaft_sticks_the_other_vibrates_on_the_gear():
    found = sw.study.standstill(STICKY.train())
    assert found.stuck[0] == pytest.approx(np.sqrt(STICKY.K / STICKY.J_l), rel=1e-6)
    assert "While the motor sticks, the load vibrates on the gear at 7.503 Hz." in " ".join(str(found).split())
    stiff = STICKY._replace(K=1e6)
    found = sw.study.standstill(stiff.train())
    # J_m d'' = -K_p (w + z/T_n) - (K d + B d')/N^2, w = d' + K_v d, z' = w
    K_p, K_v, T_n, K, B = stiff.K_p, stiff.K_v, stiff.T_n, stiff.K / N**2, stiff.B / N**2
    poles = np.roots([stiff.J_m, K_p + B, K_p * (K_v + 1.0 / T_n) + K, K_p * K_v / T_n])
    (alone,) = np.abs(poles[poles.imag > 0.0])
    assert found.stuck == pytest.approx((np.sqrt(stiff.K / stiff.J_l), alone), rel=1e-4)
    stuck = f"While the load sticks, the motor with its loop vibrates on the gear at {alone / (2.0 * np.pi):.4g} Hz."
    assert stuck in " ".join(str(found).split())


STICKY = DryInertias(
    2.5e-4, 18.0, N, 4e4, 30.0, Friction(0.05, 0.12, 0.05), Friction(2.0, 2.0, 1.0), 0.0, 0.0, ((2, 1e-9),), 8.0, 0.1,
    0.06,
)  # fmt: skip


@pytest.mark.slow
def test_a_slow_axis_sticks_and_slips_with_the_period_and_the_size_of_an_own_integration():
    speed, end = 0.02, 16.0
    train = STICKY.train(sw.train.Steady())._replace(omega=speed)
    run = sw.drive_run(train, [0.0, 0.0, 0.0, -speed, 0.0], end)  # from rest
    t, y, asked = STICKY.run(np.zeros(5), [(0.0, end, lambda t: (speed * t, speed))])
    own = asked / N - y[2]
    releases = [
        times[1:][(np.abs(v[:-1]) < 1e-9) & (np.abs(v[1:]) >= 1e-9)]
        for times, v in ((run.trajectory.t, run.motor_speed), (t, y[1]))
    ]
    assert len(releases[1]) > 10
    assert np.diff(releases[0]) == pytest.approx(np.diff(releases[1]), rel=1e-4)
    late = run.trajectory.t > 0.5 * end
    assert np.ptp(run.pointing[late]) == pytest.approx(np.ptp(own[t > 0.5 * end]), rel=1e-3)
    whole = (t >= releases[1][-7]) & (t <= releases[1][-1])  # six cycles
    off = own[whole] - np.trapezoid(own[whole], t[whole]) / np.ptp(t[whole])
    assert in_time(train, speed).oscillation == pytest.approx(np.max(np.abs(off)), rel=0.01)


@pytest.mark.slow
def test_an_axis_that_slides_through_a_turn_of_minutes_has_the_error_and_the_friction_of_all_of_it():
    # Quasi-static: the error of the gear is that of the load, and the motor turns against the friction of both shafts.
    size, speed = 8.0 * ARCSEC, 0.02
    drive = STICKY._replace(motor=Friction(0.05, 0.08, 1.0), lines=((2, 8.0),))
    sizes = in_time(drive.train(sw.train.Steady())._replace(omega=speed), speed)
    assert sizes.part == 0.0
    assert (sizes.oscillation, sizes.across - sizes.mean_torque / STICKY.K) == pytest.approx((size, size), rel=1e-3)
    friction = 0.05 + 0.03 * np.exp(-((speed / 1.0) ** 2))
    assert sizes.motor_mean == pytest.approx(friction + 2.0 / N, rel=1e-3)


SLOW = """\
title: telescope
gear: CSF-32-100
motor:
  inertia: 2.5 kg*cm^2
  loop: {type: cascade, K_v: 8 1/s, K_p: 0.1 N*m*s/rad, T_n: 60 ms}
  drag: {type: stribeck, T_c: 0.05 N*m, T_s: 0.12 N*m, v_s: 0.02 rad/s}
load: {inertia: 18 kg*m^2}
damping: {ratio: 2 %}
speed: {from: 0.1 rpm, to: 3 rpm, shaft: motor}
excitation: {kinematic_error: [{order: 2, amplitude: 8 arcsec}]}
limit: {oscillation: 20 arcsec}
"""


@pytest.mark.slow
def test_a_slow_range_has_its_stick_slip_and_says_so(tmp_path):
    (tmp_path / "slow.yaml").write_text(SLOW)
    project = sw.read_project(tmp_path / "slow.yaml")
    found = project.response()
    slow = found.omega < 3.0 * 0.02
    assert np.min(found.oscillation[slow]) > 25.0 * ARCSEC > 9.0 * ARCSEC > np.max(found.oscillation[~slow])
    assert "a shaft may stick, and friction that falls with speed makes the loop unstable" in str(found.message)
    assert found.motor_torque[np.argmax(found.omega)] == pytest.approx(0.05, abs=2e-3)
    with pytest.raises(ProjectError, match=r"motor\.drag\.width: is not a field here: dry friction of a shaft"):
        from_text(SLOW.replace("v_s: 0.02 rad/s", "v_s: 0.02 rad/s, width: 0.001 rad/s"), tmp_path / "wide.yaml")


@pytest.mark.slow
def test_an_axis_that_sticks_in_its_run_up_has_a_report(tmp_path):
    (tmp_path / "slow.yaml").write_text(
        SLOW.replace("T_n: 60 ms", "T_n: 60 ms, lag: 1 ms, encoder: load").replace(
            "from: 0.1 rpm, to: 3 rpm, shaft: motor", "at: [15 arcsec/s], shaft: load"
        )
    )
    run = CliRunner().invoke(cli, ["analyze", str(tmp_path / "slow.yaml"), "-o", str(tmp_path / "report"), "--json"])
    assert run.exit_code == 0, run.output
    assert "hunting at standstill: ±" in json.loads(run.stdout)["verdict"]["headline"]
    assert (tmp_path / "report" / "report.html").exists()
    project = sw.read_project(tmp_path / "slow.yaml")
    ramp = ramp_of(project.train, project.system(reduced=True), project.speeds.limits)
    assert np.max(np.abs(ramp.run.motor_speed)) > 10.0 * project.train.omega  # it slips
    assert ramp.motor().torque == pytest.approx(0.12, rel=0.02)  # what breaks it away


def own_move(drive, start, angle, time):
    """Times and pointing errors of a trapezoid and 0.4 s of rest."""
    ramp, top = time / 3.0, 1.5 * angle / time * drive.N
    segments, at, speed, begin = [], 0.0, 0.0, 0.0
    for length, rate in ((ramp, top / ramp), (ramp, 0.0), (ramp, -top / ramp), (0.4, 0.0)):

        def reference(t, begin=begin, at=at, speed=speed, rate=rate):
            h = t - begin
            return at + h * (speed + 0.5 * h * rate), speed + h * rate

        segments.append((begin, begin + length, reference))
        begin += length
        at, speed = reference(begin)
    t, y, asked = drive.run(start, segments)
    return t, asked / drive.N - y[2]


def test_friction_across_a_gear_needs_a_width_and_that_of_a_shaft_steps_that_end():
    train = DryInertias(
        J_M, J_L, N, 1e4, 1.0, Friction(0.1, 0.1, 1.0), Friction(1.0, 1.0, 1.0), 0.0, 0.0, ((1, 1.0),), 10.0, 0.1, None
    ).train()
    rough = sw.Parallel(sw.Linear(1e4), sw.laws.Coulomb(1.0))
    with pytest.raises(ValueError, match=r"DriveTrain\.law has a Coulomb without a width; between two shafts"):
        sw.drive_run(train._replace(law=rough), None, 0.1)
    with pytest.raises(ValueError, match=r"Oscillator\.law has a Coulomb without a width"):
        sw.simulate(sw.Oscillator(1.0, 0.1, rough, sw.Harmonic(0.1), 1.0), (0.0, 0.0), 1.0)
    with pytest.raises(ValueError, match=r"Rk4 has equal steps, and dry friction ends some; integrate with Dopri5"):
        sw.drive_run(train, None, 0.1, method=sw.Rk4())
