"""A jump through a resonance: found where many starts at constant speed find two motions, and nowhere else."""

from types import SimpleNamespace

import numpy as np
import pytest
from one_bench import DRIVE, LOOP, SAMPLING, B, loop

import strainwave as sw
from strainwave.base.units import ARCSEC
from strainwave.study.compensation.runup import _cells

STRONG, HARD = SAMPLING._replace(limit=100.0, period=5e-5, delay=5e-5), sw.Cubic(1e5, 3e6)
STIFF = sw.controllers.SampledPD(
    40.0 * LOOP.K_p, 6.0 * LOOP.K_d, 5e-5
)  # nearly a held motor: the gear's own resonance jumps
LIGHT = DRIVE._replace(law=HARD, B=B / 6.0)


def motions(controller, speed, damping, sampling):
    """Distinct rms [arcsec] at a constant speed from 24 starts."""
    y0 = np.zeros((5, 24))
    y0[0] = np.linspace(0.0, 2e-3, 24)
    own = loop(controller, speed, sampling, law=HARD, B=damping)
    found = sw.numerics.loop_ensemble(own, {"train.omega": np.full(24, speed)}, 6.0, settle=5.0, y0=y0)
    return found.rms / ARCSEC


@pytest.mark.compiled
def test_a_jump_is_where_two_motions_are_and_the_inverse_removes_it():
    found = sw.compensate_run_up(LIGHT, (40.0, 90.0), 15.0, ("loop", "inverse"), sampling=STRONG, loop=STIFF)
    assert np.isfinite(found.jump[0])
    assert np.isnan(found.jump[1])
    rms = motions(STIFF, float(found.jump[0]), B / 6.0, STRONG)
    assert np.max(rms) > 5.0 * np.min(rms)
    assert "it jumps" in str(found)
    assert np.max(found.up[1]) < 0.1 * np.max(found.up[0])


@pytest.mark.compiled
def test_a_resonance_that_is_passed_quickly_is_no_jump():
    """Both ways differ by more than 2 at a speed where all starts lead to one motion."""
    drive = DRIVE._replace(law=HARD, B=B / 4.0)
    sampling = SAMPLING._replace(limit=100.0)
    found = sw.compensate_run_up(drive, (40.0, 90.0), 15.0, ("loop",), sampling=sampling)
    ratio = found.up[0] / found.down[0]
    assert np.max(ratio) > 2.0
    assert np.isnan(found.jump[0])
    plain = sw.controllers.SampledPD(LOOP.K_p, LOOP.K_d, sampling.period)
    assert np.ptp(motions(plain, float(found.speed[np.argmax(ratio)]), B / 4.0, sampling)) < 2.0


@pytest.mark.parametrize("ends", [(30.0, 120.0), (120.0, 30.0)])
def test_the_largest_error_is_that_of_a_whole_period_where_a_cell_is_shorter(ends):
    """An order 1 of amplitude 3e-5 on a mean of 1e-3: a cell of 10 ms sees a twentieth of a turn at 30 rad/s."""
    time = 2.0
    t = np.arange(0.0, time, 5e-4)
    angle = ends[0] * t + 0.5 * (ends[1] - ends[0]) / time * t * t
    run = SimpleNamespace(time=t, error=1e-3 + 3e-5 * np.cos(angle))
    found = _cells(run, ends, time, np.linspace(30.0, 120.0, 201), 1)
    np.testing.assert_allclose(found, 3e-5, rtol=0.01)


@pytest.mark.parametrize(
    ("call", "sentence"),
    [
        (lambda: sw.compensate_run_up(DRIVE, (90.0, 40.0), 1.0), r"speeds \[rad/s\]"),
        (lambda: sw.compensate_run_up(DRIVE, (40.0, 90.0), 0.0), r"time \[s\] is 0"),
        (lambda: sw.compensate_run_up(DRIVE, (40.0, 90.0), 1.0, ("adaptive",)), "designed for one speed"),
        (lambda: sw.compensate_run_up(DRIVE, (40.0, 90.0), 1e-6), r"time is 1e-06 s and a period of order 2 lasts"),
    ],
)
def test_what_cannot_be_run_up_gets_a_sentence(call, sentence):
    with pytest.raises(ValueError, match=sentence):
        call()
