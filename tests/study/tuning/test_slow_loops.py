"""Gains that are far slower than those of the file: the phase margins by Nyquist curves of their own."""

import math
from dataclasses import replace

import numpy as np
import pytest
from sampled_axis import Axis
from scipy.optimize import brentq

import strainwave as sw
from strainwave.drive.loops.linear_control import control_parts
from strainwave.files.reading import from_text
from strainwave.study.tuning.open_loop import OpenLoop

# with the gains of the slower cascade; the last two have no controller, and 0 or 0.5 ms of delay in the margins
AXES = {
    "sampled every 0.25 ms": (
        Axis(1.5e-4, 0.9, 80, 2e4, 8.0, 0.0, None, 40.0, 0.15, 0.012, None, 0.0, None, "motor", 2.5e-4, 2.5e-4),
        (0.0262, 8.508e-5, 2443.0),
    ),
    "delay of 0.5 ms": (
        Axis(4.5e-4, 1.2, 50, 3e4, 11.0, 0.0, None, 60.0, 0.23, 0.016, None, 0.0, None, "motor", 0.0, 5e-4),
        (0.05, 4e-4, 300.0),
    ),
    "no delay": (
        Axis(2e-4, 3.0, 100, 4e4, 20.0, 0.0, None, 30.0, 0.1, 0.02, None, 0.0, None, "motor", 0.0, 0.0),
        (0.002, 1e-4, 2000.0),
    ),
}


def nyquist(axis, omega):
    """Open loop L at one frequency, of two inertias and a cascade, sampled or not."""
    if axis.period:
        return complex(axis.open_loop([omega])[0])
    s, gear = 1j * omega, axis.K + 1j * omega * axis.B
    load = axis.J_l * s * s
    motor = (load + gear) / (s * s * (axis.J_m * (load + gear) + axis.J_l * gear / axis.N**2))
    return axis.K_p * (s + axis.K_v) * (1.0 + 1.0 / (axis.T_n * s)) * motor * np.exp(-s * axis.delay)


@pytest.mark.parametrize("name", AXES)
def test_a_crossing_far_below_those_of_the_file_counts(name, tmp_path):
    axis, gains = AXES[name]
    text = axis.text() if axis.period else "".join(
        line for line in axis.text().splitlines(True) if not line.startswith("controller")
    )  # fmt: skip
    whole, loop = from_text(text, tmp_path / "axis.yaml"), sw.train.CascadeLoop(*gains)
    slow = replace(axis, K_v=gains[0], K_p=gains[1], T_n=gains[2])
    at = brentq(lambda w: math.log(abs(nyquist(slow, w))), 1e-2, 10.0)
    margin = np.angle(-nyquist(slow, at))
    found = OpenLoop(whole.train, 0.0 if axis.period else axis.delay, whole.sampling).figures(control_parts(loop), loop)
    assert found.phase_margin == pytest.approx(margin, abs=1e-4)
    margins = sw.margins(whole.train.with_motor(control=loop), speed=whole.train.omega, sampling=whole.sampling)
    late = 0.0 if axis.period else axis.delay * margins.gain_crossings[0]
    assert margins.gain_crossings == pytest.approx([at], rel=1e-4)
    assert margins.phase_margin - late == pytest.approx(margin, abs=1e-4)
