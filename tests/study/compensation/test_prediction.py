"""Predictions against runs of the loop, by branch; and a torque over speed that cancels a run-up."""

from pathlib import Path

import numpy as np
import pytest

import strainwave as sw
from strainwave.files.reading import from_text
from strainwave.study.compensation.bench import bench_of
from strainwave.study.compensation.prediction import PredictionTable
from strainwave.study.compensation.runup import _run

TEXT = """
gear: {ratio: 50, law: {type: linear, K: 1e5 N*m/rad}}
motor: {inertia: 14.5 kg*cm^2, loop: {bandwidth: 30 Hz}}
load: {inertia: 10 kg*m^2}
damping: {ratio: 3 %}
speed: {from: 20 rad/s, to: 70 rad/s, shaft: motor}
excitation: {kinematic_error: [{order: 2, amplitude: 23 arcsec}, {order: 4, amplitude: 6 arcsec, phase: 40 deg}]}
"""
QUICK = sw.Sampling(2e-5, 0.0)


def project():
    return from_text(TEXT, Path("axis.yaml"))


@pytest.mark.compiled
def test_a_prediction_is_what_the_loop_does():
    table, bench = sw.prediction_table(project()), bench_of(project(), QUICK)
    assert table.orders.tolist() == [2, 4]
    for speed in (25.0, 40.0, 55.0):
        amplitudes, flag = table.at(speed)
        assert flag == ""
        run = sw.loop_ensemble(
            bench.closed(bench.loop, speed), {}, 3.0 + 10.0 * np.pi / speed, settle=3.0, orders=[2, 4]
        )
        seen = run.amplitude[:, 0] * np.exp(1j * run.phase[:, 0])
        np.testing.assert_allclose(amplitudes, seen, atol=0.01 * np.max(np.abs(seen)))


@pytest.mark.compiled
def test_a_table_over_speed_cancels_a_run_up():
    sampling = sw.Sampling(2.5e-4, 2.5e-4)
    bench = bench_of(project(), sampling)
    controller = sw.speed_table(project(), (22.0, 68.0), sampling=sampling)
    plain, better = (_run(bench, c, (25.0, 65.0), 20.0) for c in (bench.loop, controller))
    assert better.rms(2.0) < 0.15 * plain.rms(2.0)


def test_each_direction_stays_on_its_motion_until_it_ends():
    """A hardening curve: up to 5, back to 3 unstable, on from 3."""
    omega = np.array([1.0, 2.0, 3.0, 4.0, 5.0, 4.5, 4.0, 3.5, 3.0, 4.0, 5.0, 6.0])
    size = np.array([1.0, 2.0, 3.0, 4.0, 5.0, 4.0, 3.5, 3.0, 1.5, 1.0, 0.8, 0.6])
    stable = np.array([1, 1, 1, 1, 1, 0, 0, 0, 1, 1, 1, 1], bool)
    table = PredictionTable(omega, np.array([2]), size[None].astype(complex), stable)
    assert table.at(4.0)[0][0] == 4.0
    assert table.at(4.0, -1)[0][0] == 1.0
    assert table.at(5.5)[0][0] == pytest.approx(0.7)
    assert table.at(2.5, -1)[0][0] == 2.5
    assert np.isnan(table.at(7.0)[0][0])
    assert "outside of the table" in table.at(7.0)[1]
    with pytest.raises(ValueError, match="direction is 2"):
        table.at(4.0, 2)


def test_what_has_no_prediction_gets_a_sentence():
    with pytest.raises(TypeError, match="give what read_project returns"):
        sw.prediction_table(5)
    for orders in ((0,), (-2,), (1.5,), (100_000,)):
        with pytest.raises(ValueError, match="give integers from 1 to"):
            sw.prediction_table(project(), orders)
    table = PredictionTable(np.array([30.0, 40.0]), np.array([2]), np.ones((1, 2), complex), np.ones(2, bool))
    with pytest.raises(ValueError, match="no prediction at"):
        sw.speed_table(project(), (30.0, 50.0), table=table)
