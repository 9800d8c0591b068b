"""Rest under gravity and dry friction against closed forms, hunting against a long integration of equations by hand."""

import json
import math
import re

import numpy as np
import pytest
from click.testing import CliRunner
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import strainwave as sw
from strainwave.app.commands.cli import cli
from strainwave.drive.friction.standstill import standing
from strainwave.model.train.filters import around
from strainwave.study.analysis.verdict_words import first_lines

pytestmark = pytest.mark.slow

ARCSEC = math.pi / 648000.0
N, J_M, J_L, B, G = 100.0, 4.5e-4, 5.0, 30.0, 110.0  # an elbow with SHG-32-100
SPRING, ELEMENT = sw.catalogue.gear("SHG-32-100").law, sw.BoucWen(9e3, 0.0, 1e-4)
SMOOTH = sw.Linear(0.0)
BANDWIDTH = 2.0 * math.pi * 40.0


def loop(kind):
    return sw.train.from_bandwidth(BANDWIDTH, J_M + J_L / N**2, 0.7, kind=kind)


def elbow(control, motor=SMOOTH, load=SMOOTH, gear=None):
    law = gear or sw.Parallel(SPRING, ELEMENT)
    train = sw.Drive(J_M, J_L, N, B, law).train(control=control, load_torque=sw.Harmonic(0.0, mean=-G))
    train = train._replace(motor=train.motor._replace(drag=motor))
    return train._replace(load=train.load._replace(drag=load))


def twist(torque):
    """Twist [rad] of the gear under a slow load from rest: z = yield (1 - exp(-x/yield)), beta = gamma = 1/2."""
    Y = ELEMENT.yield_twist

    def missing(x):
        return float(SPRING.torque(x)) + ELEMENT.K * Y * (1.0 - math.exp(-x / Y)) - torque

    return brentq(missing, 0.0, 0.1, xtol=1e-16)


def test_an_integrator_takes_the_motor_to_its_reference_and_the_gear_alone_winds_up():
    found = sw.study.standstill(elbow(loop("cascade")))
    assert found.integrates
    assert np.abs(found.sag) == pytest.approx(0.0, abs=1e-6 * ARCSEC)
    assert found.error == pytest.approx((twist(G), twist(G)), rel=1e-6)
    assert "motor deviates by 0 arcsec" in str(found)
    assert not found.hunts


@pytest.mark.parametrize(("encoder", "mixing"), [("load", 0.0), ("both", 50.0)])
def test_with_an_encoder_on_the_load_the_integrator_takes_the_load_to_its_reference(encoder, mixing):
    gains = sw.train.CascadeLoop(3.0, (J_M + J_L / N**2) * BANDWIDTH, 0.05)
    found = sw.study.standstill(elbow(around(gains, encoder=encoder, mixing_frequency=mixing)))
    assert found.integrates
    assert np.abs(found.error) == pytest.approx(0.0, abs=1e-6 * ARCSEC)
    assert found.sag == pytest.approx((twist(G), twist(G)), rel=1e-6)  # the motor goes on by the twist of the gear


def test_gravity_of_an_angle_sags_by_what_it_takes_at_every_angle():
    control = loop("position")
    train = elbow(control, load=sw.train.AngleTorque(60.0))  # beside 110 N*m at every angle
    found = sw.study.standstill(train)
    assert found.loads == pytest.approx((-170.0, -50.0))
    assert found.sag == pytest.approx([-torque / N / control.K_p / N for torque in (170.0, 50.0)], rel=1e-6)
    assert "under a load torque of −170 to −50 N·m" in " ".join(str(found).split())


@pytest.mark.parametrize(
    ("motor", "load", "T_m", "T_l"),
    [
        (sw.laws.Coulomb(0.05), sw.laws.Coulomb(8.0), 0.05, 8.0),
        (sw.Parallel(sw.laws.Viscous(1e-4), sw.laws.Stribeck(0.05, 0.08, 0.5)), sw.Linear(0.0), 0.08, 0.0),
        (sw.Linear(0.0), sw.laws.LuGre(1e5, 10.0, 1.0, 5.0, 6.0, 1e-2), 0.0, 6.0),
    ],
)
def test_with_dry_friction_rest_is_the_set_between_both_signs_over_the_stiffness_of_the_loop(motor, load, T_m, T_l):
    control = loop("position")
    found = sw.study.standstill(elbow(control, motor, load))
    sag = [-(((G + s * T_l) / N + s * T_m) / control.K_p) / N for s in (1.0, -1.0)]
    assert found.sag == pytest.approx(sag, rel=1e-6)
    error = [twist(G + s * T_l) + ((G + s * T_l) / N + s * T_m) / control.K_p / N for s in (-1.0, 1.0)]
    assert found.error == pytest.approx(error, rel=1e-6)
    assert not found.integrates
    ends = " to ".join(f"{end / ARCSEC:.4g}" for end in sag).replace("-", "−")
    assert f"deviates by {ends} arcsec (output) from its reference" in " ".join(str(found).split())


def hunted(control, dry, end, lag=0.0):
    """Period [s] and size [rad, motor] of the last cycles of a long stiff integration, friction with a sharp sign."""
    Y, width = ELEMENT.yield_twist, 1e-5

    def rates(_, y):
        x_m, v_m, z, x_l, v_l, b, u = y
        x, v = x_m / N - x_l, v_m / N - v_l
        gear = float(SPRING.torque(x)) + ELEMENT.K * b + B * v
        w = v_m + control.K_v * x_m
        wanted = control.K_p * (w + z / control.T_n)
        torque = u if lag else wanted
        friction = v_m / math.hypot(v_m, width) * (dry.T_c + (dry.T_s - dry.T_c) * math.exp(-((v_m / dry.v_s) ** 2)))
        slip = v - (0.5 * abs(v) * b + 0.5 * v * abs(b)) / Y
        follow = (wanted - u) / (lag or 1.0)
        return v_m, (-torque - friction - gear / N) / J_M, w, v_l, (gear - G) / J_L, slip, follow

    x0 = twist(G)
    start = [3e-3, 0.0, -G / N * control.T_n / control.K_p, 3e-5 - x0, 0.0, Y * (1.0 - math.exp(-x0 / Y)), -G / N]
    run = solve_ivp(rates, (0.0, end), start, method="BDF", rtol=1e-6, atol=1e-10, max_step=0.02)
    assert run.success, run.message
    x, t = run.y[0], run.t
    i = np.flatnonzero((x[:-1] < 0.0) & (x[1:] >= 0.0))
    moments = t[i] - x[i] * (t[i + 1] - t[i]) / (x[i + 1] - x[i])
    return float(np.mean(np.diff(moments)[-3:])), 0.5 * float(np.ptp(x[t > moments[-4]]))


@pytest.mark.slow
@pytest.mark.parametrize(("K_v", "T_n", "v_s", "lag"), [(20.0, 0.05, 0.02, 0.0), (15.0, 0.06, 0.01, 5e-4)])
def test_hunting_has_the_period_and_size_of_a_long_integration(K_v, T_n, v_s, lag):
    control = sw.train.CascadeLoop(K_v, (J_M + J_L / N**2) * BANDWIDTH, T_n)
    dry = sw.laws.Stribeck(0.05, 0.1, v_s)
    found = sw.study.standstill(elbow(around(control, lag, ()), dry))
    period, size = hunted(control, dry, 20.0, lag)
    assert found.hunts
    assert found.regular
    assert found.period == pytest.approx(period, rel=0.02)
    assert found.size * N == pytest.approx(size, rel=0.02)
    assert "Hunting" in str(found)


def test_friction_that_does_not_fall_with_the_speed_lets_an_integrator_come_to_rest():
    """Bisoffi, Da Lio, Teel & Zaccarian 2018, IEEE Trans. Automatic Control 63(8), 2654-2661."""
    found = sw.study.standstill(elbow(loop("cascade"), sw.laws.Coulomb(0.05), gear=sw.Linear(5e4)))
    assert not found.hunts
    assert "No hunting was found" in str(found)


@pytest.mark.parametrize("control", [sw.train.Held(), sw.train.Free()])
def test_a_motor_without_a_loop_is_refused(control):
    with pytest.raises(ValueError, match="no loop that holds its angle"):
        sw.study.standstill(elbow(control))


@pytest.mark.parametrize(
    ("control", "torque"),
    [
        (sw.train.Held(), sw.Harmonic(0.0)),
        (sw.train.SpeedLoop(0.1), sw.Harmonic(0.0)),
        (loop("position"), sw.train.TorqueProfile((0.0, 1.0), (0.0, 5.0))),
    ],
)
def test_a_drive_that_no_loop_holds_or_without_a_mean_torque_has_no_standstill(control, torque):
    train = elbow(control, load=sw.laws.Coulomb(5.0), gear=sw.Linear(5e4))
    assert standing(train._replace(load=train.load._replace(excitation=torque))) is None


PROJECT = """
gear: SHG-32-100
motor: {inertia: 4.5 kg*cm^2, loop: {type: cascade, bandwidth: 40 Hz},
  drag: {type: coulomb, T_c: 0.05 N*m}}
load: {inertia: 5 kg*m^2}
damping: {ratio: 3 %}
speed: {from: 40 rad/s, to: 60 rad/s, shaft: motor}
excitation: {kinematic_error: [{order: 2, amplitude: 10 arcsec}], load_torque: {mean: -110 N*m}}
"""


@pytest.mark.slow
def test_the_command_response_and_the_analysis_say_it(tmp_path):
    (tmp_path / "elbow.yaml").write_text(PROJECT, encoding="utf-8")
    run = CliRunner().invoke(cli, ["response", str(tmp_path / "elbow.yaml"), "--json"])
    assert run.exit_code == 0, run.output
    found = json.loads(run.stdout)["standstill"]
    assert found["sag_arcsec"] == pytest.approx([0.0, 0.0], abs=1e-6)
    assert found["hunting"] is None
    assert found["integrates"]
    project = sw.read_project(tmp_path / "elbow.yaml")
    remarks = " ".join(project.analyze(advice=False).train.remarks)
    assert "At standstill the motor deviates by 0 arcsec" in remarks
    assert "No hunting was found" in remarks


HUNTING = """
gear: SHG-32-100
motor: {inertia: 4.5 kg*cm^2, loop: {type: cascade, K_v: 20 1/s, K_p: 0.24 N*m*s/rad, T_n: 50 ms},
  drag: {type: stribeck, T_c: 0.05 N*m, T_s: 0.1 N*m, v_s: 0.02 rad/s}}
load: {inertia: 5 kg*m^2}
damping: {B: 30 N*m*s/rad}
hysteresis: {type: bouc_wen, K: 9e3 N*m/rad, ratio: 0, yield_twist: 0.1 mrad}
speed: {from: 40 rad/s, to: 60 rad/s, shaft: motor}
excitation: {kinematic_error: [{order: 2, amplitude: 10 arcsec}], load_torque: {mean: -110 N*m}}
"""


def test_headline_response_and_move_say_that_a_drive_hunts(tmp_path):
    (tmp_path / "elbow.yaml").write_text(HUNTING, encoding="utf-8")
    project = sw.read_project(tmp_path / "elbow.yaml")
    size = hunted(sw.train.CascadeLoop(20.0, 0.24, 0.05), sw.laws.Stribeck(0.05, 0.1, 0.02), 20.0)[1] / N / ARCSEC
    headline = re.search(r"; hunting at standstill: ±([\d.]+) arcsec$", first_lines(project.analyze(advice=False))[0])
    assert float(headline[1]) == pytest.approx(size, rel=0.02)
    run = CliRunner().invoke(cli, ["response", str(tmp_path / "elbow.yaml"), "--json"])
    assert json.loads(run.stdout)["standstill"]["hunting"]["size_arcsec"] == pytest.approx(size, rel=0.02)
    remarks = " ".join(sw.move(project, sw.Trapezoid(0.1, 0.3), tail=0.1).remarks)
    stroke = re.search(r"At rest: Hunting: the integrator makes the motor stick and slip by up to ±([\d.]+)", remarks)
    assert float(stroke[1]) == pytest.approx(size, rel=0.02)
