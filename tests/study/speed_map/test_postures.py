"""Speed map and moves over the postures of an arm, against its two inertias integrated from equations written here."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import strainwave as sw
from strainwave.base.facts import data
from strainwave.base.units import ARCSEC, RPM
from strainwave.files.reading import from_text

ARM = """
gear: {{ratio: 50, law: {{type: piecewise_linear,
  K1: 4e4 N*m/rad, K2: 6.1e4 N*m/rad, K3: 7.1e4 N*m/rad, T1: 14 N*m, T2: 48 N*m}}}}
motor: {{inertia: 6 kg*cm^2, loop: {{bandwidth: 30 Hz, damping: 0.7}}{motor}}}
load: {{inertia: 1.3 kg*m^2}}
damping: {{B: 36 N*m*s/rad}}
speed: {{from: 600 rpm, to: 2400 rpm, shaft: motor}}
excitation: {{kinematic_error: [{{order: 1, amplitude: 6 arcsec}}, {{order: 2, amplitude: 23 arcsec}}]}}
limit: {{oscillation: 40 arcsec}}
postures:
  links: [{{mass: 6 kg, length: 0.4 m}}, {{mass: 4 kg, length: 0.35 m}}]
  payload: 2 kg
  angles: [[0 deg, 0 deg], [0 deg, 140 deg], [45 deg, 60 deg], [-80 deg, 20 deg], [85 deg, 0 deg], [20 deg, 100 deg]]
"""
N, J_M, B, LIMIT = 50.0, 6e-4, 36.0, 40.0
LOOP, J_LOOP = 2.0 * math.pi * 30.0, 6e-4 + 1.3 / 2500.0


def arm(motor=""):
    return from_text(ARM.format(motor=motor), Path("arm.yaml"))


def oscillation(omega, J_l, torque, settle=120, turns=3, each=300):
    """Largest |error - mean| [arcsec] of lanes at speeds (n,) by Runge-Kutta: d = theta_m - omega t, q = error."""

    def spring(u):
        size = np.abs(u)
        u_1, u_2 = 14.0 / 4e4, 14.0 / 4e4 + 34.0 / 6.1e4
        beyond = 48.0 + 7.1e4 * (size - u_2)
        return np.sign(u) * np.where(size < u_1, 4e4 * size, np.where(size < u_2, 14.0 + 6.1e4 * (size - u_1), beyond))

    def rates(phase, y):
        d, d_rate, q, q_rate = y
        theta = phase + d
        e = ARCSEC * (6.0 * np.cos(theta) + 23.0 * np.cos(2.0 * theta))
        slope = -ARCSEC * (6.0 * np.sin(theta) + 46.0 * np.sin(2.0 * theta))
        gear = spring(d / N - q - e) + B * (d_rate / N - q_rate - slope * (omega + d_rate))
        motor = -J_LOOP * LOOP * (LOOP * d + 1.4 * d_rate) - (1.0 / N - slope) * gear
        return np.array([d_rate, motor / J_M, q_rate, (gear + torque) / J_l])

    y, step, kept = np.zeros((4, len(omega))), 2.0 * math.pi / each, []
    h = step / omega
    for i in range(each * (settle + turns)):
        phase = i * step
        a = rates(phase, y)
        b = rates(phase + 0.5 * step, y + 0.5 * h * a)
        c = rates(phase + 0.5 * step, y + 0.5 * h * b)
        y = y + h / 6.0 * (a + 2.0 * b + 2.0 * c + rates(phase + step, y + h * c))
        if i >= each * settle:
            kept.append(y[2])
    return np.max(np.abs(kept - np.mean(kept, axis=0)), axis=0) / ARCSEC


@pytest.mark.slow
def test_no_posture_is_called_safe_at_a_speed_where_integration_finds_too_much():
    project = arm()
    found = sw.speed_map(project)
    rows = np.repeat(np.arange(len(project.postures)), 10)
    speeds = np.random.default_rng(3).uniform(600.0, 2400.0, len(rows)) * RPM
    J_l, torque = np.array([row[:2] for row in project.postures])[rows].T
    size = oscillation(speeds, J_l, torque)
    allowed = np.array([found.is_allowed(float(w), float(i + 1)) for w, i in zip(speeds, rows, strict=True)])
    assert 5 < np.sum(size > LIMIT) < len(rows) - 5
    assert not np.any(allowed & (size > LIMIT))
    assert not np.any(~allowed & (size < 0.99 * LIMIT))
    computed = np.array([np.interp(w, found.speeds, found.oscillation[i]) for w, i in zip(speeds, rows, strict=True)])
    assert computed / ARCSEC == pytest.approx(size, rel=0.01)
    everywhere = [all(found.is_allowed(w, i) for i in found.loads) for w in found.speeds]
    inside = [any(low <= w <= high for low, high in found.windows) for w in found.speeds]
    assert inside[1:-1] == everywhere[1:-1]  # a band that begins at the end of the range allows that end itself
    worst = int(np.argmax(np.max(found.oscillation, axis=1)))
    assert data(found.facts())["worst_load"] == worst + 1
    assert found.postures[:2] == ("posture 1 (0 and 0 deg)", "posture 2 (0 and 140 deg)")
    assert found.postures[-1] == "nominal load, 0 N*m"
    assert f"largest oscillation: {found.postures[worst]}" in str(found)


@pytest.mark.slow
def test_postures_without_gravity_and_a_short_motor_are_named():
    rows = (sw.Posture(1.0), sw.Posture(2.5, -70.0, None, "stretched"))
    sheet = ", peak_torque: [[0 rpm, 1.3 N*m], [2400 rpm, 1.3 N*m]], brake: 1 N*m"
    found = sw.speed_map(arm(sheet), postures=rows, search=False)
    assert "1 of 2 postures have no gravity torque: they use the mean, 0 N*m" in found.remarks
    assert any("N*m short" in said and "under posture 2 (stretched)" in said for said in found.failures)
    assert any("the brake needs 1.4 N*m" in said for said in found.failures)
    with pytest.raises(ValueError, match="loads and postures are both given"):
        sw.speed_map(arm(), loads=[0.0], postures=rows)


@pytest.mark.slow
def test_a_move_in_every_posture_names_the_worst():
    project = arm(", max_torque: 2.6 N*m")
    rough = {"method": sw.Dopri5(rtol=1e-6, atol=1e-9), "tail": 0.2}
    profile, rows = sw.SCurve(math.radians(30.0), 0.3), project.postures[:3]
    found = sw.move_postures(project, profile, postures=rows, **rough)
    for row, move in zip(rows, found.moves, strict=True):
        alone = sw.move(project.with_load_inertia(row.inertia).under(row.torque), profile, **rough)
        assert move.peak_motor_torque == alone.peak_motor_torque
    facts = data(found.facts())
    assert facts["worst"]["motor_peak_torque_N_m"] == 1  # stretched along the horizontal
    assert facts["postures"][0]["torque_N_m"] == pytest.approx(rows[0].torque)
    failing = [i for i, move in enumerate(found.moves) if np.max(np.abs(move.motor_torque)) > 2.6]
    assert [said.split(":")[0] for said in facts["failures"]] == [found.title(i) for i in failing]
    assert facts["passes"] is (not failing)
    with pytest.raises(ValueError, match="there are no postures"):
        sw.move_postures(replace(project, postures=()), profile)


def test_a_posture_that_the_law_cannot_carry_is_named():
    law = "{type: bouc_wen, K: 6e4 N*m/rad, ratio: 0, yield_twist: 0.5 mrad}"
    text = f"""
gear: {{ratio: 50, law: {law}}}
motor: {{inertia: 6 kg*cm^2, mode: held}}
load: {{inertia: 1.3 kg*m^2}}
damping: {{B: 36 N*m*s/rad}}
speed: {{from: 600 rpm, to: 2400 rpm, shaft: motor}}
excitation: {{kinematic_error: [{{order: 2, amplitude: 23 arcsec}}]}}
postures: [{{inertia: 1 kg*m^2}}, {{name: out, inertia: 1 kg*m^2, torque: 100 N*m}}]
"""
    with pytest.raises(sw.SolveError, match=r"^posture 2 \(out\): BoucWen carries at most -30 N\*m"):
        sw.speed_map(from_text(text, Path("arm.yaml")), search=False)
