"""The motion of a drive at a speed: that of its response, and of its equations written out and integrated elsewhere."""

from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from twelve_projects import PROJECTS

import strainwave as sw
from strainwave.base.units import ARCSEC
from strainwave.files.reading import from_text
from strainwave.study.analysis.time_domain.drive_motion import SHOWN_TURNS

K, J_M, J_L, B, RATIO = 3e4, 4.5e-4, 5.0, 25.0, 100.0  # of the joint below
K_P, K_D, STIFF, YIELD = 60.0, 0.5, 5e4, 1e-4
LINES = ((2, 25.0, 0.0), (4, 5.0, -60.0))  # order, arcsec, deg
JOINT = f"""\
gear:
  ratio: {RATIO}
  law:
    type: parallel
    first: {{type: linear, K: {K} N*m/rad}}
    second: {{type: bouc_wen, K: {STIFF} N*m/rad, ratio: 0, yield_twist: {YIELD} rad}}
motor: {{inertia: {J_M} kg*m^2, loop: {{type: position_loop, K_p: {K_P} N*m/rad, K_d: {K_D} N*m*s/rad}}}}
load: {{inertia: {J_L} kg*m^2, drag: {{type: angle_torque, amplitude: 60 N*m}}}}
damping: {{B: {B} N*m*s/rad}}
speed: {{from: 300 rpm, to: 1200 rpm, shaft: motor}}
excitation:
  kinematic_error: [{", ".join(f"{{order: {k}, amplitude: {a} arcsec, phase: {p} deg}}" for k, a, p in LINES)}]
  load_torque: {{mean: -20 N*m}}
"""


def read(text):
    return from_text(text, Path("drive.yaml"))


def written_out(omega, torque, turns):
    """Pointing error (samples) [rad] over the last two turns of the joint, its equations integrated by SciPy."""

    def error(angle):
        parts = [(k, a * ARCSEC, k * angle + np.radians(p)) for k, a, p in LINES]
        return sum(a * np.cos(w) for _, a, w in parts), -sum(k * a * np.sin(w) for k, a, w in parts)

    def rates(t, y):
        off, speed, load, load_speed, z = y  # of the motor from its reference, of the load, and of the hysteresis
        e, slope = error(omega * t + off)
        u = (omega * t + off) / RATIO - load - e
        v = (omega + speed) * (1.0 / RATIO - slope) - load_speed
        T = K * u + STIFF * z + B * v
        motor = (-K_P * off - K_D * speed - T * (1.0 / RATIO - slope)) / J_M
        slip = abs(z / YIELD) * (0.5 * abs(v) * np.sign(z) + 0.5 * v)
        return speed, motor, load_speed, (T + torque) / J_L, v - slip

    turn = 2.0 * np.pi / omega
    t = np.linspace((turns - 2) * turn, turns * turn, 2 * 96 + 1)
    start = [0.0, 0.0, torque / K, omega / RATIO, 0.0]
    found = solve_ivp(rates, (0.0, turns * turn), start, "DOP853", t, rtol=1e-8, atol=1e-12)
    return omega * t / RATIO - found.y[2]


@pytest.mark.slow
@pytest.mark.parametrize(("rpm", "load"), [(400.0, None), (900.0, 40.0)])
def test_the_motion_of_a_joint_is_that_of_its_equations_integrated_elsewhere(rpm, load):
    project, omega = read(JOINT), rpm * np.pi / 30.0
    found = sw.drive_motion(project, omega, load=load)
    assert found.load_torque == (-20.0 if load is None else load)
    assert not found.remark
    error = written_out(omega, found.load_torque, 60)
    mean = np.mean(error[:-1])
    assert found.mean == pytest.approx(mean, rel=0.01)  # where it slips to a stop depends on the start
    last = found.error[-1 - 2 * found.per_turn :: found.per_turn // 96]  # at the same times
    assert np.ptp(last) == pytest.approx(np.ptp(error), rel=1e-3)
    np.testing.assert_allclose(last - found.mean, error - mean, atol=2e-3 * np.ptp(error))


@pytest.mark.slow
@pytest.mark.parametrize(
    "name", ["loop by bandwidth, payload", "position loop, coupling", "free motor with a torque", "article"]
)
def test_the_motion_is_on_the_response_of_the_drive(name):
    project = read(PROJECTS[name])
    if name == "article":  # without damping no motion dies away
        assert "does not repeat with every turn" in sw.drive_motion(project, project.speeds.middle).remark
        return
    found = project.response(coexisting=False, points=30)
    at = np.flatnonzero(found.stable & found.curve.inside)[-3]
    motion = sw.drive_motion(project, float(found.omega[at]))
    share = 2.0 * found.curve.tail + 1e-5
    assert motion.oscillation == pytest.approx(found.oscillation[at], rel=share)
    assert motion.peak == pytest.approx(found.peak[at], rel=share)
    assert motion.peak_torque == pytest.approx(found.torque[at], rel=2e-3)
    assert motion.has_reference == found.has_reference
    assert len(motion.t) == SHOWN_TURNS * motion.per_turn + 1
