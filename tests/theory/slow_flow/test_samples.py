"""Second order by samples for laws that are linear between breakpoints: what `error` says is true."""

from dataclasses import replace

import numpy as np
import pytest

import strainwave as sw
from strainwave.theory.slow_flow.averaging import probes_of
from strainwave.theory.slow_flow.second_order import second_order
from strainwave.theory.slow_flow.setting import setting

GEAR = sw.PiecewiseLinear(1e5, 1.4e5, 1.8e5, 54.0, 196.0)
TWO_LINES = sw.Harmonics((sw.Harmonic(0.3, mean=0.4), sw.Harmonic(0.2, order=3)))


@pytest.mark.slow
@pytest.mark.parametrize(
    "system",
    [
        sw.Oscillator(1.3, 10.0, GEAR, sw.Harmonic(30.0), 280.0),
        sw.Oscillator(1.3, 10.0, GEAR, sw.Harmonic(30.0, mean=60.0), 300.0),
        sw.Oscillator(1.0, 0.05, sw.Backlash(1.0, 0.2), sw.Harmonic(0.3, mean=0.4), 0.9),
        sw.Oscillator(1.0, 0.05, sw.Backlash(1.0, 0.2), TWO_LINES, 0.9),
    ],
    ids=["gear", "gear under load", "backlash", "backlash under two lines"],
)
def test_error_of_samples_is_what_64_times_as_many_show(system):
    s = setting(system, sw.PRIMARY)
    flow = second_order(s)
    samples, probes = flow.force, probes_of(s)
    finer = replace(samples, points=(64 * samples.points[0],))
    here, exact = samples.values(s, probes)[1], finer.values(s, probes)[1]
    true = np.max(np.abs(here - exact)) / np.max(np.abs(exact))
    assert 0.0 < true <= flow.error
    assert flow.error < 1e-3
