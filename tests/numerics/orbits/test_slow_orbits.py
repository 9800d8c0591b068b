"""Orbits that are slow against the free vibration: many vibrations a period, as when the output turn is the base."""

import math

import numpy as np
import pytest

import strainwave as sw
from strainwave.numerics.stability import first_order as variational


@pytest.mark.parametrize("ratio", [10.0, 37.0, 60.0, 150.0])
@pytest.mark.parametrize("law", [sw.Linear(1.0), sw.Cubic(1.0, 0.1)])
def test_multipliers_of_a_slow_orbit_shrink_as_damping_says(ratio, law):
    # A complex pair has the modulus exp(-B period/(2J)) by Liouville's formula.
    B = 0.05
    orbit = sw.find_orbit(sw.Oscillator(1.0, B, law, sw.Harmonic(0.1), 1.0 / ratio))
    assert orbit.stable
    assert np.abs(orbit.multipliers) == pytest.approx(math.exp(-math.pi * B * ratio), rel=1e-6)


def test_phase_of_the_multipliers_of_a_slow_linear_orbit_is_that_of_its_vibration():
    B, ratio = 0.02, 40.3
    orbit = sw.find_orbit(sw.Oscillator(1.0, B, sw.Linear(1.0), sw.Harmonic(0.1), 1.0 / ratio))
    turned = math.sqrt(1.0 - 0.25 * B * B) * 2.0 * math.pi * ratio
    # 16 steps a vibration: Numerov's frequency is off by (2 pi/16)^4/480 = 5e-5 of 253 rad
    assert np.cos(np.angle(orbit.multipliers[0])) == pytest.approx(math.cos(turned), abs=0.02)


def test_a_curve_that_begins_at_a_slow_speed_is_stable_there():
    curve = sw.frequency_response(sw.Oscillator(1.0, 0.1, sw.Linear(1.0), sw.Harmonic(0.1), 1.0), (0.01, 0.5))
    assert np.all(curve.stable)


@pytest.mark.parametrize("omega", [1e-5, 1e-8])
def test_an_orbit_slower_than_any_grid_decays_and_is_no_nan(omega):
    orbit = sw.find_orbit(sw.Oscillator(1.0, 0.1, sw.Cubic(1.0, 0.1), sw.Harmonic(0.5), omega))
    assert np.array_equal(orbit.multipliers, [0.0, 0.0])  # exp(-0.05 * 2 pi/omega) is below every float
    assert orbit.stable


def test_a_slow_overdamped_orbit_creeps_back_as_stiffness_over_damping_says():
    """The slow rate is -K/B (1 + K J/B^2), the fast one has long died out: exp(-2 pi K/(B omega))."""
    for omega in (1e-2, 1e-3):
        orbit = sw.find_orbit(sw.Oscillator(1e-6, 1.0, sw.Linear(1e-3), sw.Harmonic(5e-4), omega))
        expected = np.exp(-2.0 * np.pi * 1e-3 / omega * (1.0 + 1e-9))
        assert abs(orbit.multipliers[0]) == pytest.approx(expected, rel=1e-6)
        assert orbit.stable


def test_a_slow_orbit_on_a_hilltop_is_unstable_and_its_multiplier_finite():
    orbit = sw.find_orbit(sw.Oscillator(1.0, 0.1, sw.Cubic(-1.0, -1.0), sw.Harmonic(0.01), 1e-8))
    assert not orbit.stable
    assert np.all(np.isfinite(orbit.multipliers))


@pytest.mark.parametrize("omega", [1e-5, 1e-8])
def test_a_general_system_slower_than_any_steps_decays_and_is_no_nan(omega):
    law = sw.Parallel(sw.Cubic(1.0, 0.1), sw.laws.Viscous(0.1))
    orbit = sw.find_orbit(sw.Oscillator(1.0, 0.1, law, sw.Harmonic(0.5), omega))
    assert np.array_equal(np.abs(orbit.multipliers), [0.0, 0.0])
    assert orbit.stable


def test_the_rates_of_the_moment_join_the_period_map_where_steps_still_resolve_it(monkeypatch):
    """A linear spring beside viscous friction: 100 vibrations a period, decay exp(-B period/(2J))."""
    law = sw.Parallel(sw.Linear(1.0), sw.laws.Viscous(0.01))
    system = sw.Oscillator(1.0, 0.01, law, sw.Harmonic(0.5), 0.01)
    resolved = sw.find_orbit(system).multipliers
    monkeypatch.setattr(variational, "SLOW", 300.0)
    np.testing.assert_allclose(np.abs(sw.find_orbit(system).multipliers), np.abs(resolved), rtol=1e-6)
    assert np.abs(resolved) == pytest.approx(math.exp(-math.pi * 0.02 / 0.01), rel=1e-6)


def test_a_slow_orbit_with_damping_that_drives_is_unstable_without_a_warning():
    driven = sw.Oscillator(1.0, -0.1, sw.Cubic(1.0, 0.3), sw.Harmonic(0.3), 1e-5)
    orbit = sw.find_orbit(driven)
    assert not orbit.stable
    assert abs(orbit.multipliers[0]) > 1e100  # exp(0.1 period/2) is exp(31416)
