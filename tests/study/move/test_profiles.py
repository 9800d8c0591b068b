"""Profiles against their closed forms: duration, largest speed, acceleration and jerk, splines, and what is refused."""

import math

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

import strainwave as sw
from strainwave.study.move.profiles import path_of

QUARTER = 0.5 * math.pi
# (part, duration, largest speed, largest acceleration, largest jerk), each by hand.
BY_HAND = [
    # thirds: speed 1.5 times the mean, reached in a third
    (sw.Trapezoid(QUARTER, 0.6), 0.6, 1.5 * QUARTER / 0.6, 4.5 * QUARTER / 0.36, 0.0),
    (sw.Trapezoid(-1.5, speed=2.0, acceleration=20.0), 0.85, 2.0, 20.0, 0.0),  # q/v + v/a
    (sw.Trapezoid(0.05, speed=2.0, acceleration=20.0), 0.1, 1.0, 20.0, 0.0),  # 2 sqrt(q/a): a triangle
    # a third for each ramp, each of it two rises: the acceleration is twice that of the trapezoid
    (sw.SCurve(QUARTER, 0.6), 0.6, 1.5 * QUARTER / 0.6, 9.0 * QUARTER / 0.36, 90.0 * QUARTER / 0.36),
    # Biagiotti & Melchiorri, sec. 3.4: T = q/v + v/a + a/j
    (sw.SCurve(1.5, speed=2.0, acceleration=20.0, jerk=400.0), 0.9, 2.0, 20.0, 400.0),
    (sw.SCurve(-0.1, speed=2.0, acceleration=20.0, jerk=400.0), 0.2, 1.0, 20.0, 400.0),  # speed not reached
    (sw.SCurve(1.5, speed=0.25, acceleration=20.0, jerk=400.0), 6.05, 0.25, 10.0, 400.0),  # nor the acceleration
    (sw.SCurve(0.0001, speed=2.0, acceleration=20.0, jerk=400.0), 0.02, 0.01, 2.0, 400.0),  # 4 cbrt(q/(2 j))
]


@pytest.mark.parametrize(("part", "time", "speed", "acceleration", "jerk"), BY_HAND)
def test_a_part_has_the_duration_and_the_extremes_of_its_closed_form(part, time, speed, acceleration, jerk):
    path = path_of(part)
    angle, v, a = path.motion_at(np.linspace(0.0, time, 20001)[:-1])
    steepest = np.max(np.abs(path.motion_at(path.knots[:-1])[2]))  # it is at a knot
    assert path.duration == pytest.approx(time, rel=1e-12)
    assert np.max(np.abs(v)) == pytest.approx(speed, rel=1e-6)
    assert steepest == pytest.approx(acceleration, rel=1e-9)
    assert np.max(np.abs(a)) <= acceleration * (1.0 + 1e-9)
    assert np.max(np.abs(path.jerk)) == pytest.approx(jerk, rel=1e-9)
    np.testing.assert_allclose(np.gradient(angle, time / 20000)[1:-1], v[1:-1], atol=1e-3 * speed)
    before, rest, _ = path.motion_at(np.nextafter(path.knots[-1:], 0.0))
    assert before[0] == pytest.approx(part.angle, rel=1e-12)
    assert abs(rest[0]) < 1e-12 * speed
    assert path.travel() == pytest.approx(abs(part.angle), rel=1e-12)


def test_angle_and_speed_are_continuous_at_every_knot():
    path = path_of([sw.SCurve(1.0, 0.5), sw.study.Dwell(0.1), sw.Trapezoid(-0.4, 0.3), sw.SCurve(0.2, 0.2)], start=0.3)
    knots = path.knots[1:-1]
    for left, right in zip(path.motion_at(np.nextafter(knots, 0.0))[:2], path.motion_at(knots)[:2], strict=True):
        np.testing.assert_allclose(left, right, atol=1e-13)
    assert path.motion_at(np.zeros(1))[0][0] == 0.3
    assert path.last == pytest.approx(1.1, rel=1e-15)
    assert path.motions() == [pytest.approx((0.0, 0.5)), pytest.approx((0.6, 1.1))]


def test_points_are_met_by_a_clamped_spline_with_exact_dwells():
    t = np.linspace(1.0, 3.0, 41)
    moving = 0.5 * (1.0 - np.cos(np.pi * (t[:21] - 1.0)))
    angle = np.concatenate([moving, np.ones(20)])
    path = path_of(sw.AngleProfile(tuple(t), tuple(angle)))
    spline = CubicSpline(t[:21] - 1.0, moving, bc_type="clamped")
    dense = np.linspace(0.0, 1.0, 500)[:-1]
    for mine, theirs in zip(path.motion_at(dense), (spline(dense), spline(dense, 1), spline(dense, 2)), strict=True):
        np.testing.assert_allclose(mine, theirs, atol=1e-10)
    assert path.motions() == [pytest.approx((0.0, 1.0))]
    assert path.duration == pytest.approx(2.0)
    np.testing.assert_allclose(path.motion_at(t - 1.0)[0], angle, atol=1e-14)


def test_speeds_are_crossed_and_bands_are_spent_time_in_as_by_hand():
    path = path_of([sw.Trapezoid(1.5, speed=2.0, acceleration=20.0), sw.study.Dwell(0.2), sw.SCurve(-1.5, 0.6)])
    # ramps of 0.1 s up to 2 rad/s; the S-curve has 3.75 rad/s, reached in 0.2 s with the jerk 375 rad/s^3
    rise = math.sqrt(2.0 * 0.5 / 375.0)
    first, second = [0.025, 0.825], [1.05 + rise, 1.65 - rise]
    np.testing.assert_allclose(path.crossings(0.5), first + second, rtol=1e-12)
    assert len(path.crossings(3.0)) == 2
    assert path.time_within(0.5, 5.0) == pytest.approx(0.8 + 0.6 - 2.0 * rise, rel=1e-12)
    assert path.time_within(0.0, 5.0) == pytest.approx(path.duration, rel=1e-12)
    assert path.time_within(4.0, 5.0) == 0.0


REFUSED = [
    ([], ValueError, "the profile is empty"),
    (sw.study.Dwell(1.0), ValueError, "only waits for 1 s; give an angle"),
    (sw.AngleProfile((0.0, 1.0), (2.0, 2.0)), ValueError, "only waits for"),
    (sw.Trapezoid(1.0), ValueError, "neither a time nor limits"),
    (sw.Trapezoid(0.0, 1.0), ValueError, "angle is 0"),
    (sw.Trapezoid(0.3, 1e-300), ValueError, "time is 1e-300 s for 0.3 rad; give a longer time"),
    (sw.Trapezoid(1.0, 1.0, speed=1.0), ValueError, "a time and speed"),
    (sw.Trapezoid(1.0, -1.0), ValueError, "time is -1"),
    (sw.Trapezoid(1.0, 1.0, ramp=0.6), ValueError, "ramp is 0.6"),
    (sw.SCurve(1.0, 1.0, rounding=0.0), ValueError, "rounding is 0"),
    (sw.SCurve(1.0, speed=1.0, acceleration=3.0), ValueError, "jerk is 0"),
    (sw.study.Dwell(0.0), ValueError, "Dwell.time is 0"),
    (sw.Trapezoid(1.0, math.nan), ValueError, "Trapezoid.time is nan"),
    (sw.AngleProfile((0.0, 1.0), (0.0, math.nan)), ValueError, "must be finite"),
    (sw.AngleProfile((0.0, 1.0, 0.5), (0.0, 1.0, 2.0)), ValueError, "goes back from 1 s to 0.5 s at point 3"),
    (sw.AngleProfile((0.0, 1.0, 1.0), (0.0, 1.0, 2.0)), ValueError, "repeats 1 s at point 3"),
    (sw.AngleProfile((0.0, 1.0), (0.0,)), ValueError, "2 times and 1 angles"),
]


@pytest.mark.parametrize(("profile", "kind", "said"), REFUSED)
def test_a_profile_that_is_none_is_refused_in_one_sentence(profile, kind, said):
    with pytest.raises(kind, match=said) as caught:
        path_of(profile)
    assert "\n" not in str(caught.value)


def test_a_text_is_the_part_of_the_command():
    text = "trapezoid, angle: 90 deg, time: 0.6 s"
    path = path_of([text, "dwell, time: 0.1 s"])
    assert path.duration == pytest.approx(0.7, rel=1e-12)
    assert path.angle[-1] == pytest.approx(math.pi / 2.0, rel=1e-12)
    assert np.max(np.abs(path.speed)) == pytest.approx(1.5 * (math.pi / 2.0) / 0.6, rel=1e-12)  # ramps of a third each
    with pytest.raises(ValueError, match="the profile 'ramp, angle: 1 rad' is wrong: type: 'ramp' is not known"):
        path_of("ramp, angle: 1 rad")
