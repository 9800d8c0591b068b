"""A limit below the error of slow rotation, of a loop on the encoder of the motor and on that of the load."""

import math
from pathlib import Path

import numpy as np
import pytest

from strainwave.base.units import ARCSEC
from strainwave.files.reading import from_text
from strainwave.study.analysis.verdict import Answer, judged

LINES = (1, 6.5), (2, 26.0), (4, 6.5)  # arcsec
DRIVE = """
gear: {{ratio: 100, law: {{type: linear, K: 6.7e4 N*m/rad}}}}
motor:
  inertia: 2.5 kg*cm^2
  loop: {{type: cascade, K_v: 8 1/s, K_p: 0.1 N*m*s/rad, T_n: 60 ms, lag: 1 ms, encoder: {encoder}}}
load: {{inertia: 18 kg*m^2}}
damping: {{B: 44 N*m*s/rad}}
speed: {{from: 0.167 rpm, to: 1.667 rpm, shaft: motor}}
excitation: {{kinematic_error: [{{order: 1, amplitude: 6.5 arcsec}}, {{order: 2, amplitude: 26 arcsec}},
  {{order: 4, amplitude: 6.5 arcsec}}]}}
limit: {{oscillation: 2 arcsec}}
"""


def largest(rpm, K_v=8.0, K_p=0.1, T_n=0.06, lag=1e-3, K=6.7e4, B=44.0, J_m=2.5e-4, J_l=18.0, N=100.0):
    """Largest deviation of the load [arcsec], the position loop closed on it: linear algebra for every harmonic.

    The error is that at the motor's angle, which deviates by what corrects it.
    """
    phase, d = 2.0 * math.pi * np.arange(256) / 256, np.zeros(256)
    for _ in range(20):
        error = np.fft.rfft(sum(size * ARCSEC * np.cos(order * (phase + d)) for order, size in LINES))
        motor, load = 0.0 * error, 0.0 * error
        for order in range(1, 60):
            s = 1j * order * rpm * math.pi / 30.0
            gear, loop = K + B * s, K_p * (1.0 + 1.0 / (s * T_n)) / (1.0 + s * lag)
            matrix = [
                [J_m * s * s + loop * s + gear / N**2, loop * K_v * N - gear / N],
                [-gear / N, J_l * s * s + gear],
            ]
            motor[order], load[order] = np.linalg.solve(matrix, np.array([gear / N, -gear]) * error[order])
        d = np.fft.irfft(motor)
    return float(np.max(np.abs(np.fft.irfft(load, 4096)))) * 16.0 / ARCSEC


def test_a_loop_on_the_load_meets_a_limit_below_the_error_of_slow_rotation_and_is_not_told_that_it_cannot():
    project = from_text(DRIVE.format(encoder="load"), Path("drive.yaml"))
    found = project.response()
    assert found.oscillation[found.top] / ARCSEC == pytest.approx(largest(1.667), rel=1e-4)
    said = judged(project, found)
    assert (said.verdict.answer, said.failures) == (Answer.ALL_RIGHT, ())
    assert "cannot" not in said.below
    assert "only above the resonances" not in " ".join(said.remarks)
    assert "only where the loop on the load's encoder reduces this error" in said.remarks[0]


def test_a_loop_on_the_load_that_fails_is_not_told_that_its_limit_is_out_of_reach():
    fast = DRIVE.format(encoder="load").replace("1.667 rpm", "60 rpm")
    project = from_text(fast, Path("drive.yaml"))
    said = judged(project, project.response())
    assert said.verdict.answer is Answer.BUT
    assert not any("slow rotation" in failure for failure in said.failures)


def test_a_loop_on_the_motor_fails_by_a_limit_below_the_error_of_slow_rotation():
    project = from_text(DRIVE.format(encoder="motor"), Path("drive.yaml"))
    said = judged(project, project.response())
    assert said.verdict.answer is Answer.NOT
    assert "it can be met only above the resonances" in said.failures[0]
