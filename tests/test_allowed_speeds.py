"""Every face allows the same speeds: `analyze`, the speed map, the report and the function that decides."""

import math
from pathlib import Path

import numpy as np
import pytest
from allowed_speeds import told
from scipy.integrate import solve_ivp

import strainwave as sw
from strainwave.files.reading import from_text

DRIVE = """
gear: CSF-32-50
{gap}motor: {{inertia: 4 kg*cm^2, {motor}}}
load: {{inertia: 2 kg*m^2{drag}}}
damping: {{{damping}}}
speed: {{from: 500 rpm, to: 3000 rpm, shaft: motor}}
excitation: {{accuracy: catalogue{torque}}}
limit: {{oscillation: 80 arcsec}}
{more}"""
USUAL = {"gap": "", "motor": "mode: held", "drag": "", "torque": "", "damping": "B: 40 N*m*s/rad", "more": ""}
LOOP = "loop: {bandwidth: 30 Hz, damping: 0.7}"
CASCADE = "loop: {type: cascade, bandwidth: 20 Hz, damping: 0.8}"
PROJECTS = {
    "a gap": {"gap": "backlash: {half_gap: 10 arcsec}\n", "torque": ", load_torque: {mean: -20 N*m}"},
    "gravity": {"motor": LOOP, "drag": ", drag: {type: angle_torque, amplitude: 41 N*m}", "damping": "ratio: 3 %"},
    "a cascade": {"motor": CASCADE, "torque": ", load_torque: {mean: {from: -30 N*m, to: 10 N*m}}"},
    "samples": {"motor": CASCADE, "more": "controller: {period: 250 us, delay: 250 us}\n"},
    "postures": {
        "motor": LOOP,
        "more": "postures: [{inertia: 1 kg*m^2}, {name: out, inertia: 3 kg*m^2, torque: -40 N*m}]\n",
    },
}
ARCSEC = math.pi / 648000.0


@pytest.mark.slow
@pytest.mark.parametrize("name", PROJECTS)
def test_every_face_allows_the_same_speeds(name, tmp_path):
    path = tmp_path / "drive.yaml"
    path.write_text(DRIVE.format(**USUAL | PROJECTS[name]), encoding="utf-8")
    rows = told(path, tmp_path / "report")
    assert rows.keys() == {"API", "speed-map", "analyze", "report"}
    for row in rows.values():
        assert row == pytest.approx(rows["API"], rel=1e-9)
    if name == "gravity":
        found, analysis = sw.speed_map(sw.read_project(path)), sw.read_project(path).analyze(advice=False)
        assert len(found.run_up) > 0
        np.testing.assert_allclose(analysis.avoid.passed, found.run_up, rtol=1e-9)


WORN = """
gear: CSG-25-100
backlash: {half_gap: 10 arcsec}
motor: {mode: held}
load: {inertia: 2 kg*m^2}
damping: {B: 8 N*m*s/rad}
speed: {from: 1700 rpm, to: 2100 rpm, shaft: motor}
excitation: {accuracy: catalogue, load_torque: {mean: -10 N*m}}
limit: {oscillation: 40 arcsec}
"""


def settled(project, omega, state, gap=10.0 * ARCSEC, B=8.0, J=2.0, torque=10.0):
    """Oscillation [rad] of the motion on which a start settles, by DOP853."""
    law, lines = project.gear.law, project.kinematic_error.lines
    ends = law.T1 / law.K1, law.T1 / law.K1 + (law.T2 - law.T1) / law.K2

    def spring(u):
        size = np.maximum(np.abs(u) - gap, 0.0)
        beyond = np.where(size < ends[1], law.T1 + law.K2 * (size - ends[0]), law.T2 + law.K3 * (size - ends[1]))
        return np.sign(u) * np.where(size < ends[0], law.K1 * size, beyond)

    def rates(phase, y):
        error = sum(line.amplitude * math.cos(line.order * phase + line.phase) for line in lines)
        slope = -sum(line.order * line.amplitude * math.sin(line.order * phase + line.phase) for line in lines)
        force = torque - spring(y[0] - error) - B * (y[1] - omega * slope)
        return y[1] / omega, float(force) / (J * omega)

    last = 2.0 * np.pi * np.linspace(250.0, 262.0, 12 * 200)
    x = solve_ivp(rates, (0.0, last[-1]), state, "DOP853", last, rtol=1e-8, atol=1e-12).y[0]
    return np.max(np.abs(x - np.mean(x)))


@pytest.mark.slow
def test_a_speed_at_which_only_a_motion_apart_from_the_curve_is_too_large_is_allowed_by_no_face():
    """At 1926 rpm the curve has 6.9 arcsec, and a start settles on three turns with five times the limit."""
    project, omega = from_text(WORN, Path("worn.yaml")), 1926.3523702136044 * math.pi / 30.0
    curve = project.response(coexisting=False)
    assert np.interp(omega, curve.omega, curve.oscillation) < 0.2 * project.limit
    assert settled(project, omega, (0.0, 0.0)) < 0.2 * project.limit
    size = settled(project, omega, (-0.00055408621, 0.07169628601))
    assert size > 4.0 * project.limit
    analysis, found = project.analyze(advice=False), sw.speed_map(project)
    np.testing.assert_allclose(analysis.verdict.allowed, found.windows, rtol=1e-9)
    assert not any(low < omega < high for low, high in found.windows)
    assert np.interp(omega, found.speeds, found.oscillation[0]) == pytest.approx(size, rel=0.01)
    assert analysis.avoid.apart[1] >= 0.99 * size


SERVO = """
gear:
  ratio: 100
  law: {type: piecewise_linear, T1: 14 N*m, T2: 48 N*m, K1: 31000 N*m/rad, K2: 50000 N*m/rad, K3: 57000 N*m/rad}
backlash: {half_gap: 7.5 arcsec}
motor: {inertia: 1.5e-4 kg*m^2, loop: {bandwidth: 120 Hz, damping: 0.7}}
load: {inertia: 0.45 kg*m^2}
damping: {B: 4.0 N*m*s/rad}
speed: {from: 600 rpm, to: 5000 rpm, shaft: motor}
excitation: {kinematic_error: [{order: 2, amplitude: 14 arcsec}], load_torque: {mean: -0.5 N*m}}
limit: {oscillation: 30 arcsec}
"""


def settled_servo(omega, state, turns=600):
    """Oscillation [rad] of the error of SERVO, and its difference after two turns, from a state by DOP853."""
    J_m, J, N, B, gap = 1.5e-4, 0.45, 100.0, 4.0, 7.5 * ARCSEC
    inertia, w = J_m + J / N**2, 2.0 * math.pi * 120.0

    def rates(phase, y):
        q, q_rate, d, d_rate = y
        angle = phase + d
        error, slope = 14.0 * ARCSEC * math.cos(2.0 * angle), -28.0 * ARCSEC * math.sin(2.0 * angle)
        u = q + d / N - error
        size = max(abs(u) - gap, 0.0)
        assert 31000.0 * size < 14.0
        gear = B * (q_rate + d_rate / N - slope * (omega + d_rate)) + math.copysign(31000.0 * size, u)
        motor = -inertia * w * (w * d + 1.4 * d_rate) - (1.0 / N - slope) * gear
        return np.array([q_rate, -(gear - 0.5) / J, d_rate, motor / J_m]) / omega

    last = 2.0 * np.pi * np.linspace(turns - 4.0, turns, 4 * 200 + 1)
    x = solve_ivp(rates, (0.0, last[-1]), state, "DOP853", last, rtol=1e-8, atol=1e-13).y[0]
    return np.max(np.abs(x - np.mean(x[:-1]))), np.max(np.abs(x[400:] - x[:401]))


@pytest.mark.slow
def test_a_motion_that_is_not_followed_forbids_the_speeds_beside_those_that_are_searched():
    """Two turns of a gap in a loop, from 4182 to 4258 rpm; a start at 4113 rpm meets it."""
    project, omega = from_text(SERVO, Path("servo.yaml")), 4221.588235294117 * math.pi / 30.0
    state = (9.668180739032663e-05, 0.033743994111054734, -2.1799860860736204e-05, 0.00813408250457743)
    size, change = settled_servo(omega, state)
    assert size > 1.1 * project.limit
    assert change < 1e-3 * size
    assert not any(low < omega < high for low, high in sw.speed_map(project).windows)
