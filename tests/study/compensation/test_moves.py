"""Moves in closed loop against the continuous loop, shaping on a linear drive, and what is refused."""

import numpy as np
import pytest
from one_bench import DRIVE, LINEAR, PERIOD, SAMPLING

import strainwave as sw
from strainwave.base.units import ARCSEC

STRAIGHT = LINEAR._replace(error=sw.KinematicError((sw.Line(2, 1e-9),)))
MOVE = sw.Trapezoid(0.3, 0.4)
IDEAL = sw.controllers.Sampling(PERIOD, 0.0)


@pytest.mark.compiled
def test_samples_that_are_quick_give_the_continuous_loop():
    quick = sw.controllers.Sampling(1e-5, 0.0)
    own = sw.compensate_move(DRIVE, MOVE, ("loop",), sampling=quick, window=20.0 * ARCSEC)
    whole = sw.move(DRIVE, MOVE, window=20.0 * ARCSEC, tail=1.0)
    score = own.scores[0]
    assert score.settling_time == pytest.approx(whole.settling_time, rel=0.01)
    assert score.rms == pytest.approx(whole.rms_error, rel=0.01)
    assert score.torque == pytest.approx(whole.peak_motor_torque, rel=0.01)


@pytest.mark.compiled
def test_shaping_leaves_a_linear_drive_at_rest():
    """After its end the shaped reference leaves a small share of the vibration that the plain one leaves."""
    found = sw.compensate_move(STRAIGHT, MOVE, ("loop",), shaping=("ZV", "ZVD"), sampling=IDEAL, window=5.0 * ARCSEC)
    plain, zv, zvd = found.scores
    assert zv.settling_time < 0.7 * plain.settling_time
    late = found.time > 0.4 + 0.3
    left = np.ptp(found.error[:, late], axis=1)
    assert left[2] < 0.15 * left[0]
    assert zvd.settling_time < plain.settling_time


@pytest.mark.compiled
def test_the_inverse_helps_a_move_against_gravity():
    heavy = DRIVE._replace(load=DRIVE.load._replace(drag=sw.train.AngleTorque(60.0)))
    found = sw.compensate_move(heavy, MOVE, ("loop", "nonlinear-inverse"), sampling=SAMPLING)
    assert found.scores[1].rms < 0.4 * found.scores[0].rms
    assert "Compensated move of" in str(found)
    assert found.to_xarray()["error"].dims == ("controller", "time")


@pytest.mark.parametrize(
    ("call", "error", "sentence"),
    [
        (lambda: sw.compensate_move(DRIVE, MOVE, ("adaptive",)), ValueError, "designed for one speed, or is none"),
        (lambda: sw.compensate_move(DRIVE, sw.SCurve(0.3, 0.4)), ValueError, "acceleration is not constant"),
        (lambda: sw.compensate_move(DRIVE, [MOVE] * 9), ValueError, "knots; a sampled loop takes up to 16"),
        (lambda: sw.compensate_move(DRIVE, MOVE, ()), ValueError, "nothing to run"),
        (lambda: sw.compensate_move(DRIVE, MOVE, window=0.0), ValueError, "window"),
        (lambda: sw.compensate_move(DRIVE, MOVE, shaping=("EI",)), ValueError, "it must be 'ZV' or 'ZVD'"),
    ],
)
def test_what_cannot_be_moved_gets_a_sentence(call, error, sentence):
    with pytest.raises(error, match=sentence):
        call()
