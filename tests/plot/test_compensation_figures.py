"""Figures of a compensation show the numbers of the results, in units that are said."""

import math

import numpy as np
import pytest
from all_results import RESULTS, compensation

import strainwave as sw
from strainwave.plot import compensation as figures
from strainwave.plot.svg import stacked
from strainwave.study.compensation.bench import bench_of

ARCSEC = math.pi / 648_000.0


def named(panel, label):
    return next(curve for curve in panel.curves if curve.label == label)


@pytest.mark.slow
def test_the_error_in_time_has_the_size_that_the_ensemble_measures():
    error = sw.KinematicError((sw.Line(2, 20.0 * ARCSEC),))
    drive = sw.Drive(J_m=2e-4, J_l=0.8, N=50.0, B=60.0, law=sw.Linear(2e4))
    loop = sw.train.from_bandwidth(150.0, 2e-4 + 0.8 / 2500.0, 0.7)
    train = drive.train(kinematic_error=error, control=loop, omega=60.0)
    sampling = sw.controllers.Sampling(2e-3, 5e-4, motor_quantum=1e-7)
    bench = bench_of(train, sampling=sampling)
    found = sw.compensate(train, "angle", speed=60.0, sampling=sampling, robust=False)
    before, after = (figures.motion(bench, name, 60.0, name) for name in ("loop", "angle"))
    assert before.turns[0] == 0.0
    assert before.turns[-1] == pytest.approx(figures.TURNS, rel=0.02)
    for motion, residual in ((before, found.before), (after, found.after)):
        assert np.sqrt(np.mean(motion.error**2)) == pytest.approx(residual.rms, rel=0.02)
    above, below = figures.error_panels(before, [after])
    np.testing.assert_allclose(named(above, "loop").y, before.error, rtol=1e-12)
    np.testing.assert_allclose(named(below, "angle").y, after.error, rtol=1e-12)
    assert (str(above.y), str(below.x)) == ("arcsec", "turns of the motor")


def test_controllers_stand_beside_the_plain_loop_by_the_encoder_that_they_need():
    one = compensation()
    other = RESULTS["CompensationBench"]()
    results = tuple(
        tuple(type(one)(**{**vars(one), "name": name, "speed": speed, "load_encoder": seeing, "stable": name != "b"})
              for speed in (15.0, 150.0))
        for name, seeing in (("loop", False), ("a", False), ("b", True))
    )  # fmt: skip
    found = type(other)(np.array([15.0, 150.0]), ("loop", "a", "b"), results)
    blind, seeing = found.panels()
    np.testing.assert_allclose(named(blind, "plain loop").y, [1e-4, 1e-4], rtol=1e-12)
    np.testing.assert_allclose(named(blind, "a").y, [1e-6, 1e-6], rtol=1e-12)
    np.testing.assert_allclose(named(seeing, "b").x, [15.0, 150.0], rtol=1e-12)
    assert {curve.label for curve in blind.curves} == {"plain loop", "a", ""}
    assert "motor limit reached, or error grew" in {curve.label for curve in seeing.curves}
    assert blind.log
    assert blind.xlog
    assert (str(blind.x), str(blind.y)) == ("motor speed (rpm)", "rms of the error (arcsec)")
    assert 'viewBox="0 0 430 ' in stacked([seeing], 300.0, "")
    alone = type(other)(np.array([15.0, 150.0]), ("loop",), results[:1])
    assert stacked(figures.speed_panels(alone, load_encoder=False), 300.0, "") == ""


def test_amplitudes_stand_at_their_orders_before_and_after():
    found = compensation()
    (panel,) = found.panels()
    rings = {marker: [curve for curve in panel.curves if curve.marker == marker] for marker in ("o", "^")}
    for marker, amplitudes in (("o", found.amplitude_before), ("^", found.amplitude_after)):
        np.testing.assert_allclose([curve.y[0] for curve in rings[marker]], amplitudes, rtol=1e-12)
        assert [round(float(curve.x[0])) for curve in rings[marker]] == [2, 4]


def test_the_share_of_units_reaches_all_of_them():
    units = RESULTS["Units"]()
    (panel,) = figures.units_panels({"adaptive": units})
    curve = named(panel, "adaptive")
    assert curve.y[-1] == pytest.approx(100.0)
    assert curve.x[-1] == pytest.approx(np.max(units.after.rms), rel=1e-12)
    assert panel.xlog


def test_runs_of_unequal_length_share_one_scale():
    runs = [
        figures.Motion(name, np.linspace(0.0, 2.0, n), np.linspace(0.0, 1e-4, n)) for name, n in (("a", 9), ("b", 8))
    ]
    above, below = figures.error_panels(runs[0], runs)
    assert [len(named(below, name).y) for name in "ab"] == [9, 8]
    assert above.xlim == (0.0, 2.0)
