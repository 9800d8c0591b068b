"""Bands of a motion whose cycles would not show."""

import numpy as np

from strainwave.app.report.sections.single_speeds import _even, envelope
from strainwave.study.speed_map.ramp import turns


def test_the_band_of_a_run_up_holds_a_whole_turn_at_every_speed():
    # from 20 to 240 rad/s: a turn takes twelve times as many samples at the start as at the end
    t = np.linspace(0.0, 40.0, 400_001)
    speed = 20.0 + 5.5 * t
    angle = 20.0 * t + 2.75 * t * t
    between = 1.0 - np.cos(0.5 * speed[-1] * t[1])  # what lies between two samples
    for most in (angle[-1] / (2.0 * np.pi) + 1.0, 350):
        low, high, at = envelope(speed, 3.0 * np.cos(angle + 0.7), turns(t, speed))
        assert len(low) <= most
        np.testing.assert_allclose(high[:-1], 3.0, rtol=between)  # the last turn need not be whole
        np.testing.assert_allclose(low[:-1], -3.0, rtol=between)
        assert np.all(np.diff(at) > 0.0)
        assert (at[0], at[-1]) == (speed[0], speed[-1])


def test_a_motor_that_sticks_or_turns_back_has_the_turns_that_it_has_come_to():
    t = np.arange(5.0)
    assert turns(t, np.array([-1e-18, -2e-16, -7e-17, 8e-17, 0.0])).tolist() == [0]
    # 0, 4, 8, 6, 8, 14 rad: a turn, 2 pi, is passed with the third sample and again with the fifth, two with the last
    assert turns(np.arange(6.0), np.array([4.0, 4.0, 4.0, -8.0, 12.0, 0.0])).tolist() == [0, 2, 5]


def test_the_band_of_a_run_of_few_samples_has_each_of_them_once():
    t, x = np.arange(5.0), np.array([1.0, -2.0, 3.0, 0.0, 1.0])
    low, high, at = envelope(t, x, _even(5, 12))
    assert np.array_equal(low, x)
    assert np.array_equal(high, x)
    assert np.array_equal(at, t)
