"""Run-ups and run-downs at a rate, against SciPy's DOP853 in the equations written out on the angle w t + r t^2/2."""

import math
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import strainwave as sw
from strainwave.base.units import ARCSEC
from strainwave.files.reading import from_text

STRONG = sw.Oscillator(1.0, 0.05, sw.Cubic(1.0, 0.1), sw.Harmonic(0.5), 1.0)
LOOSE = sw.Oscillator(1.0, 0.08, sw.Backlash(1.0, 0.5), sw.Harmonic(0.2, mean=0.3), 1.0)
K, ALPHA, J_M, J_L, B, RATIO = 1.1e5, 7e4, 4.5e-4, 1.3, 22.0, 50.0
K_P, K_D, GRAVITY, LINE, RIPPLE = 35.0, 0.25, 60.0, 20.0 * ARCSEC, 4.0
JOINT = f"""\
gear: {{ratio: {RATIO}, law: {{type: cubic, K: {K} N*m/rad, alpha: {ALPHA} rad^-2}}}}
motor: {{inertia: {J_M} kg*m^2, loop: {{type: position_loop, K_p: {K_P} N*m/rad, K_d: {K_D} N*m*s/rad}}}}
load: {{inertia: {J_L} kg*m^2, drag: {{type: angle_torque, amplitude: {GRAVITY} N*m}}}}
damping: {{B: {B} N*m*s/rad}}
speed: {{from: 70 rad/s, to: 160 rad/s, shaft: motor}}
excitation:
  kinematic_error: [{{order: 2, amplitude: {LINE / ARCSEC} arcsec}}]
  load_torque: {{lines: [{{order: 3, amplitude: {RIPPLE} N*m}}]}}
"""


def strong(angle, _speed, _rate, y):
    return y[1], 0.5 * math.cos(angle) - 0.05 * y[1] - y[0] - 0.1 * y[0] ** 3


def loose(angle, _speed, _rate, y):
    return y[1], 0.3 + 0.2 * math.cos(angle) - 0.08 * y[1] - y[0] + min(max(y[0], -0.5), 0.5)


def joint(angle, speed, rate, y):
    """Error x and the motor's deviation from its reference, with their rates."""
    x, v, off, slip = y
    e, slope = LINE * math.cos(2.0 * (angle + off)), -2.0 * LINE * math.sin(2.0 * (angle + off))
    u = x - e
    torque = K * (u + ALPHA * u**3) + B * (v - slope * (speed + slip))
    motor = (-K_P * off - K_D * slip - (1.0 / RATIO - slope) * torque) / J_M
    weight = GRAVITY * math.sin((angle + off) / RATIO - x)
    load = (torque + RIPPLE * math.cos(3.0 * angle) - weight) / J_L
    return v, motor / RATIO - load, slip, motor - rate


def written_out(equation, states, speeds, rate, wait, error=lambda y: y[0]):
    """Largest |error| from one speed to another, after a time at the first one under the torque of the acceleration."""
    (first, last), rate = speeds, math.copysign(rate, speeds[1] - speeds[0])

    def rates(t, y):
        after = max(t, 0.0)
        return equation(first * t + 0.5 * rate * after * after, first + rate * after, rate, y)

    how = {"method": "DOP853", "rtol": 1e-9, "atol": 1e-13}
    start = solve_ivp(rates, (-wait, 0.0), np.zeros(states), **how).y[:, -1]
    duration = (last - first) / rate
    times = np.linspace(0.0, duration, 25 * math.ceil(duration * max(speeds)))
    return np.max(np.abs(error(solve_ivp(rates, (0.0, duration), start, t_eval=times, **how).y)))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("system", "equation", "speeds", "rates"),
    [(STRONG, strong, (0.5, 2.5), [4e-3, 0.02, 0.1]), (LOOSE, loose, (0.4, 1.6), [4e-3, 0.02, 0.1])],
    ids=["jump", "backlash"],
)
def test_an_error_equation_on_its_way(system, equation, speeds, rates):
    found = sw.run_up(system, rates, speeds=speeds)
    for i, rate in enumerate(rates):
        for way, ends in enumerate((speeds, speeds[::-1])):
            assert found.largest[way, i] == pytest.approx(written_out(equation, 2, ends, rate, 700.0), rel=2e-3)
    assert np.all((found.at >= speeds[0]) & (found.at <= speeds[1]))
    assert found.largest[0, 0] > 1.15 * found.largest[1, 0]  # both hang over to higher speeds: a run-up goes further
    assert found.at[0, 0] > found.at[1, 0] + 0.2


@pytest.mark.slow
def test_a_whole_drive_with_a_loop_under_gravity_on_its_way():
    rates = [60.0, 400.0]
    found = sw.run_up(from_text(JOINT, Path("joint.yaml")), rates)
    assert found.speeds == pytest.approx((70.0, 160.0))
    for i, rate in enumerate(rates):
        for way, ends in enumerate(((70.0, 160.0), (160.0, 70.0))):
            own = written_out(joint, 4, ends, rate, 1.0, lambda y: y[0] - y[2] / RATIO)
            assert found.largest[way, i] == pytest.approx(own, rel=2e-3)


@pytest.mark.slow
def test_a_slow_run_meets_the_peak_of_the_steady_response_and_a_fast_one_less():
    system = STRONG._replace(B=0.4, law=sw.Cubic(1.0, 0.0), excitation=sw.Harmonic(0.1))
    found = sw.run_up(system, [5e-4, 0.5])
    assert found.speeds == pytest.approx((0.5, 2.0))
    assert found.largest[:, 0] == pytest.approx(0.1 / (0.4 * math.sqrt(1.0 - 0.04)), rel=3e-3)
    assert found.at[:, 0] == pytest.approx(math.sqrt(1.0 - 0.08), abs=0.02)
    assert np.all(found.largest[:, 1] < 0.9 * found.largest[:, 0])


def test_the_begin_of_a_run_shakes_nothing():
    # without excitation a held drive is twisted by J_l r/N from begin to end
    drive = sw.Drive(4.5e-4, 1.3, 50.0, 60.0, sw.Linear(1e5))
    found = sw.run_up(drive.train(control=sw.train.Held()), 200.0, speeds=(100.0, 150.0))
    assert found.largest[:, 0] == pytest.approx(1.3 * 200.0 / (50.0 * 1e5), rel=1e-6)


def test_a_system_that_varies_by_nothing_is_the_one_that_does_not():
    plain = sw.Oscillator(1.0, 0.3, sw.Cubic(1.0, 0.1), sw.Harmonic(0.3), 1.0, sw.KinematicError((sw.Line(2, 0.05),)))
    varying = sw.gears.VaryingOscillator(plain.J, sw.gears.GearDamping(plain.B), *plain[2:])
    found, same = [sw.run_up(system, 0.05, speeds=(0.5, 1.5)) for system in (plain, varying)]
    np.testing.assert_allclose(same.largest, found.largest, rtol=1e-7)


@pytest.mark.parametrize("rates", [0.0, -1.0, math.nan, math.inf, [], [0.1, 0.0], "fast", [[0.1]]], ids=str)
def test_a_rate_that_is_none_is_told(rates):
    with pytest.raises(ValueError, match=r"^rates \[rad/s\^2\] is .*; (give positive ones|it must be one or)"):
        sw.run_up(STRONG, rates)


@pytest.mark.parametrize(
    ("system", "given", "said"),
    [
        (STRONG, {"rates": 1e-9}, r"takes 3e\+08 turns, more than 100,000; use rates of at least 3e-06 rad/s\^2"),
        (STRONG, {"speeds": (2.0, 1.0)}, r"speeds \[rad/s\] is \(2.0, 1.0\); it must be two finite numbers"),
        (STRONG, {"speeds": (0.0, 1.0)}, r"speeds \[rad/s\] is 0 .. 1; it must be 0 < low < high"),
        (STRONG._replace(B=0.0), {}, "has no damping and never settles at the first speed; add damping"),
        (
            STRONG._replace(law=sw.Backlash(1.0, 0.1)),
            {},
            "this Oscillator has no known resonance to run through; give",
        ),
        (sw.HDC_40_050.train(), {"speeds": (1.0, 2.0)}, "a free motor follows a torque, not a speed; add a"),
    ],
)
def test_what_cannot_be_run_through_is_told(system, given, said):
    with pytest.raises(ValueError, match=said):
        sw.run_up(system, **{"rates": 0.1, **given})


def test_a_system_of_another_kind_and_one_that_diverges_are_told():
    with pytest.raises(TypeError, match=r"run_up takes a Project, a DriveTrain or an Oscillator, not 3\.0"):
        sw.run_up(3.0, 0.1)
    soft = STRONG._replace(law=sw.Cubic(1.0, -0.1), excitation=sw.Harmonic(2.0))
    with pytest.raises(sw.SolveError, match=r"the run from 0\.5 to 2 rad/s at 0\.1 rad/s\^2 ends early: .* left every"):
        sw.run_up(soft, 0.1)
