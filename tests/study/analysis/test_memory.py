"""The response of laws with memory: that of a slow run-up integrated by another program, and its jumps."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import strainwave as sw
from strainwave.drive.equation.gear_torque import gear_torque
from strainwave.drive.response import exact_response

pytestmark = pytest.mark.slow

BOUC_WEN = sw.Parallel(sw.Linear(1.0), sw.BoucWen(0.5, 0.0, 0.2))
HARDENING = sw.Oscillator(
    1.0, 0.04, sw.Parallel(sw.Cubic(1.0, 1.0), sw.BoucWen(0.15, 0.0, 0.1)), sw.Harmonic(0.12, mean=-0.1), 1.0
)


def swept(system, speeds, turns=25):
    """Half peak to peak on a slow sweep of a cubic spring beside Bouc-Wen of exponent 1, by scipy."""
    spring, yielding = system.law
    force, mean, start, sizes = system.excitation.amplitude, system.excitation.mean, [0.0, 0.0, 0.0], []
    for omega in speeds:

        def rates(phase, y, omega=omega):
            x, v, z = y
            torque = spring.K * (x + spring.alpha * x**3) + yielding.K * z
            slip = abs(z) / yielding.yield_twist * (0.5 * abs(v) * np.sign(z) + 0.5 * v)
            return np.array([v, force * np.cos(phase) + mean - system.B * v - torque, v - slip]) / omega

        end = 2.0 * np.pi * turns
        last = np.linspace(end - 2.0 * np.pi, end, 200)
        run = solve_ivp(rates, (0.0, end), start, "LSODA", last, rtol=1e-6, atol=1e-8)
        start = run.y[:, -1]
        sizes.append(0.5 * np.ptp(run.y[0]))
    return np.array(sizes)


def half_ranges(curve):
    """Half peak to peak of every motion of a curve, and of its stable points alone."""
    h = curve.coefficients.shape[1] // 2
    angle = np.linspace(0.0, 2.0 * np.pi, 400, endpoint=False)
    k = np.arange(1, h + 1)[:, None] * angle
    x = curve.coefficients[:, 1::2] @ np.cos(k) + curve.coefficients[:, 2::2] @ np.sin(k)
    return 0.5 * np.ptp(x, axis=1)


def test_a_run_up_stays_on_the_large_motion_as_far_as_an_integrated_one_does():
    found = exact_response(HARDENING, (0.8, 1.7), coexisting=False)
    assert found.curve.status
    up = found.sweep.run_up
    (drop,) = found.sweep.on_run_up
    ahead = np.arange(0.8, 0.99 * drop.value, 0.025)
    *own, before, after = swept(HARDENING, [*ahead, 0.993 * drop.value, 1.007 * drop.value])
    assert np.interp(ahead, found.curve.omega[up], half_ranges(found.curve)[up]) == pytest.approx(own, rel=0.01)
    assert after < 0.5 * before


def test_a_run_down_rises_where_an_integrated_one_does_and_between_lies_a_band():
    found = exact_response(HARDENING, (0.8, 1.7), coexisting=False)
    (rise,), (drop,) = found.sweep.on_run_down, found.sweep.on_run_up
    (band,) = found.sweep.jumping
    assert (band.low, band.high) == (rise.value, drop.value)
    *_, before, after = swept(
        HARDENING, [*np.linspace(1.7, 1.02 * rise.value, 8), 1.007 * rise.value, 0.99 * rise.value]
    )
    assert after > 2.0 * before


def test_a_range_that_ends_in_a_band_has_the_small_motion_too():
    whole = exact_response(HARDENING, (0.8, 1.7), coexisting=False)
    (band,) = whole.sweep.jumping
    end = 0.5 * (band.low + band.high)
    found = exact_response(HARDENING, (0.8, end), coexisting=False)
    there = np.sort(found.curve.peak[(found.curve.omega == end) & found.curve.stable])
    assert len(there) == 2
    assert found.sweep.on_run_down[0].value == pytest.approx(band.low, rel=1e-4)


def test_response_of_hysteresis_is_that_of_single_orbits():
    system = sw.Oscillator(1.0, 0.05, BOUC_WEN, sw.Harmonic(0.1), 1.0)
    found = exact_response(system, (0.9, 1.3), coexisting=False)
    assert np.all(found.curve.stable)
    for omega in (0.9, 1.3):
        orbit = sw.find_orbit(system._replace(omega=omega), harmonics=31)
        at = int(np.argmin(np.abs(found.curve.omega - omega)))
        assert found.curve.omega[at] == pytest.approx(omega)
        # the series of the balance falls with the cube of the order, as the force has corners
        assert found.curve.peak[at] == pytest.approx(orbit.peak, rel=1e-3)


def test_torque_of_the_curve_is_the_torque_of_the_law():
    system = sw.Oscillator(1.0, 0.05, BOUC_WEN, sw.Harmonic(0.1), 1.0)
    found = exact_response(system, (1.0, 1.05), coexisting=False)
    orbit = sw.find_orbit(system._replace(omega=float(found.curve.omega[0])), harmonics=31)
    angle = np.linspace(0.0, 2.0 * np.pi, 400, endpoint=False)
    state = orbit.state(angle)
    torque = gear_torque(system, angle, state[0], state[1], tuple(state[2:]))
    assert found.torque[0] == pytest.approx(np.max(np.abs(torque)), rel=5e-3)


def test_a_hardening_law_with_friction_jumps_apart_up_and_down():
    law = sw.Parallel(sw.Cubic(1.0, 1.0), sw.laws.Coulomb(0.01, 0.01))
    system = sw.Oscillator(1.0, 0.04, law, sw.Harmonic(0.1), 1.0)
    found = exact_response(system, (0.9, 2.2), coexisting=False)
    assert found.sweep.jump_down > found.sweep.jump_up + 0.05
    assert [jump.after < jump.before for jump in found.sweep.on_run_up] == [True]
    assert [jump.after > jump.before for jump in found.sweep.on_run_down] == [True]
