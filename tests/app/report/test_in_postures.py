"""Verdict over the postures of a file, against integration of the load written here."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from strainwave.app.report.report import write

pytestmark = pytest.mark.slow

DRIVE = """\
gear: CSG-40-50
motor: {inertia: 6 kg*cm^2, mode: held}
load: {inertia: 1.3 kg*m^2}
damping: {ratio: 12 %}
speed: {from: 600 rpm, to: 2000 rpm, shaft: motor}
excitation: {kinematic_error: [{order: 2, amplitude: 14 arcsec}]}
limit: {oscillation: 1000 arcsec}
postures: [{name: a, inertia: 1.3 kg*m^2, torque: -20 N*m}, {name: b, inertia: 1.3 kg*m^2, torque: -3000 N*m}]
"""
ARCSEC, RPM = math.pi / 648000.0, math.pi / 30.0


def integrated(project, torque, omega, J=1.3):
    """Largest torque in the gear [N*m] under a torque on the load, by DOP853."""
    law, B, line = project.gear.law, project.drive.B, 14.0 * ARCSEC
    ends = law.T1 / law.K1, law.T1 / law.K1 + (law.T2 - law.T1) / law.K2

    def spring(u):
        size = np.abs(u)
        beyond = np.where(size < ends[1], law.T1 + law.K2 * (size - ends[0]), law.T2 + law.K3 * (size - ends[1]))
        return np.sign(u) * np.where(size < ends[0], law.K1 * size, beyond)

    def carried(phase, y):
        error, slope = line * np.cos(2.0 * phase), -2.0 * line * np.sin(2.0 * phase)
        return spring(y[0] - error) + B * (y[1] - omega * slope)

    def rates(phase, y):
        return y[1] / omega, float(torque - carried(phase, y)) / (J * omega)

    last = 2.0 * np.pi * np.linspace(200.0, 203.0, 3000)
    run = solve_ivp(rates, (0.0, last[-1]), (0.02, 0.0), "DOP853", last, rtol=1e-9, atol=1e-13)
    return float(np.max(np.abs(carried(last, run.y))))


def test_a_posture_that_breaks_the_gear_is_the_verdict(tmp_path):
    path = tmp_path / "drive.yaml"
    path.write_text(DRIVE, encoding="utf-8")
    report = write(path)
    project, verdict = report.view.project, report.results["verdict"]
    largest = max(integrated(project, 3000.0, rpm * RPM) for rpm in np.linspace(1700.0, 1900.0, 21))
    said = f"{largest:.4g} N·m exceeds the ratcheting torque of 2300 N·m"
    assert verdict["headline"] == f"Fail; 1 of 2 postures fails, posture 2 (b): {said}"
    assert said in verdict["sentence"]
    assert "average torque of 255 N·m" in verdict["sentence"]
