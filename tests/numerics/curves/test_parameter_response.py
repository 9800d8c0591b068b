"""Sweeps of any parameter: folds where the frequency curve has them, zero load, kinematic error, bad input."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import strainwave as sw

pytestmark = pytest.mark.slow

DUFFING = sw.Oscillator(1.0, 0.05, sw.Cubic(1.0, 0.1), sw.Harmonic(0.18), 1.2)  # NLvib example 01


def test_folds_of_an_amplitude_sweep_are_folds_of_the_frequency_curve():
    sweep = sw.numerics.parameter_response(DUFFING, "excitation.amplitude", (0.05, 0.5), harmonics=7)
    assert sweep.status
    assert len(sweep.folds) == 2
    for fold in sweep.folds:
        at = sw.replaced(DUFFING, {"excitation.amplitude": fold.value})
        curve = sw.frequency_response(at, (0.8, 2.2), harmonics=7)
        assert min(abs(f.omega - 1.2) for f in curve.folds) < 1e-8


def test_a_sweep_may_start_without_any_load():
    sweep = sw.numerics.parameter_response(DUFFING, "excitation.amplitude", (0.0, 0.5))
    assert sweep.values[0] == 0.0
    assert sweep.values[-1] == 0.5
    assert sweep.peak[0] < 1e-12
    assert sweep.tail < 1e-6


def test_load_changes_the_sign_of_the_mean():
    sweep = sw.numerics.parameter_response(DUFFING, "excitation.mean", (-1.0, 1.0))
    mean = np.interp([-0.8, 0.8], sweep.values, sweep.amplitude(0))
    assert mean[0] == pytest.approx(-mean[1], rel=1e-3)
    assert mean[1] > 0.5


def test_kinematic_error_is_part_of_the_displacement():
    # x/e of J x'' + B (x' - e') + K (x - e) = 0
    J, B, K, omega, k = 2.0, 0.3, 5.0, 0.9, 2
    system = sw.Oscillator(J, B, sw.Linear(K), sw.Harmonic(0.0), omega, sw.KinematicError((sw.Line(k, 0.1),)))
    sweep = sw.numerics.parameter_response(system, "error.lines.0.amplitude", (0.1, 0.3), harmonics=3)
    w = k * omega
    gain = abs((K + 1j * B * w) / (K - J * w * w + 1j * B * w))
    np.testing.assert_allclose(sweep.amplitude(k), gain * sweep.values, rtol=1e-9)
    np.testing.assert_allclose(sweep.peak, gain * sweep.values, rtol=1e-9)


def test_a_sweep_from_an_orbit_follows_its_branch_both_ways():
    curve = sw.frequency_response(DUFFING, (0.5, 1.6), harmonics=7)
    upper = np.flatnonzero(curve.stable & (curve.peak > 1.5) & (curve.omega > 1.19) & (curve.omega < 1.25))[0]
    x = np.stack([curve.coefficients[upper], 0.0 * curve.coefficients[upper]], axis=1)
    system = sw.replaced(DUFFING, {"omega": float(curve.omega[upper])})
    orbit = sw.find_orbit(system, guess=x, harmonics=7)
    sweep = sw.numerics.parameter_response(system, "excitation.amplitude", (0.15, 0.3), start=orbit, harmonics=7)
    assert np.interp(0.18, sweep.values[::-1], sweep.peak[::-1]) == pytest.approx(orbit.peak, rel=1e-3) or (
        np.interp(0.18, sweep.values, sweep.peak) == pytest.approx(orbit.peak, rel=1e-3)
    )
    assert {sweep.values[0], sweep.values[-1]} <= {0.15, 0.3}


@pytest.mark.parametrize(
    ("path", "span", "sentence"),
    [
        ("excitation.order", (1.0, 2.0), "no continuous parameter 'excitation.order'"),
        ("law.beta", (0.0, 1.0), "no continuous parameter 'law.beta'"),
        ("law.alpha", (1.0, 0.0), "low < high"),
        ("law.alpha", (0.0, float("nan")), "low < high"),
        ("omega", (0.0, 1.0), "0 < low < high"),
        ("B", 1.0, "two finite numbers"),
        ("B", "ab", "two finite numbers"),
    ],
)
def test_bad_sweeps_are_refused_in_a_sentence(path, span, sentence):
    with pytest.raises(ValueError, match=sentence):
        sw.numerics.parameter_response(DUFFING, path, span)


def test_a_start_outside_the_range_is_refused():
    orbit = sw.find_orbit(DUFFING, harmonics=3)
    with pytest.raises(ValueError, match="outside the range"):
        sw.numerics.parameter_response(DUFFING, "law.alpha", (0.2, 0.3), start=orbit)


def test_a_resonance_without_damping_is_said_to_have_no_response():
    resonant = sw.Oscillator(1.0, 0.0, sw.Linear(1.0), sw.Harmonic(0.1), 1.0)
    branch = sw.numerics.parameter_response(resonant, "excitation.amplitude", (0.1, 0.3), harmonics=1, points=20)
    assert not branch.status
    assert len(branch) == 0
    assert "no periodic response was found at excitation.amplitude = 0.1 or 0.3, omega = 1 rad/s" in branch.message
    assert "give damping" in branch.message


def test_damping_swept_to_none_at_resonance_grows_without_bound():
    resonant = sw.Oscillator(1.0, 0.1, sw.Linear(1.0), sw.Harmonic(0.1), 1.0)
    branch = sw.numerics.parameter_response(resonant, "B", (0.0, 0.2), harmonics=1, points=20)
    assert not branch.status
    assert "the response grows without bound at B = " in branch.message
    assert "omega = 1 rad/s; give more damping" in branch.message


def test_too_few_harmonics_are_said_with_the_place():
    bent = sw.Oscillator(1.0, 0.05, sw.Cubic(1.0, 1.0), sw.Harmonic(0.5), 1.0)
    branch = sw.numerics.parameter_response(bent, "excitation.amplitude", (0.1, 0.5), harmonics=1, points=20)
    assert "at excitation.amplitude = 0.5, omega = 1 rad/s, the harmonics left out hold about" in branch.message
    orbit = sw.find_orbit(bent, harmonics=1)
    assert "at omega = 1 rad/s the harmonics left out hold about" in orbit.message
    assert "take more than 1 harmonics" in orbit.message
    assert sw.find_orbit(bent, harmonics=15).message == "finished"


def test_isolas_without_forcing_are_refused():
    still = sw.Oscillator(1.0, 0.05, sw.Cubic(1.0, 1.0), sw.Harmonic(0.0, mean=0.1), 1.0)
    with pytest.raises(ValueError, match="without forcing no resonance responds; give one of them an amplitude"):
        sw.isolas(still, (2.5, 4.0))


CORNERS = sw.PiecewiseLinear(1e5, 1.4e5, 1.8e5, 54.0, 196.0)


@pytest.mark.slow
def test_a_sweep_from_an_orbit_refined_by_shooting_takes_as_many_harmonics_as_it_needs():
    """Folds by the exact flow of the segments; the orbit itself has 1023 harmonics."""
    drive = sw.Drive(4.5e-4, 1.3, 50.0, 9.82317898446, CORNERS)
    error = sw.KinematicError((sw.Line(2, 1.1e-4),))
    system = drive.error_equation(kinematic_error=error, omega=222.0, motor="held")._replace(J=drive.J)
    start = sw.find_orbit(system)
    assert len(start.coefficients) == 2047
    sweep = sw.numerics.parameter_response(system, "omega", (215.0, 255.0), start=start, points=20)
    assert sweep.coefficients.shape[1] <= 255
    assert sweep.status
    assert sorted(fold.value for fold in sweep.folds) == pytest.approx([226.448419, 249.057291], abs=1e-5)


@pytest.mark.parametrize("points", [39, 51, 117])
def test_no_fold_is_missed_where_a_motion_reaches_a_corner_of_the_law(points):
    # DOP853 at 1e-10 with the variational equations, by Newton's method for y(T) = y(0) and det(M - 1) = 0.
    law, J = sw.catalogue.gear("SHG-25-100").law, 0.6
    error = sw.KinematicError((sw.Line(2, np.radians(40.0 / 3600.0)),))
    system = sw.Oscillator(J, 0.06 * np.sqrt(J * law.K1), law, sw.Harmonic(0.0), 100.0, error)
    curve = sw.frequency_response(system, (400.0 * np.pi / 30.0, 1500.0 * np.pi / 30.0), harmonics=16, points=points)
    assert [fold.omega for fold in curve.folds] == pytest.approx([148.178377660, 142.312007789], rel=1e-6)


def unstable_rest(omega, damping=0.01, depth=0.06):
    """Least multiplier over two turns, less 1, of x'' + c x' + (1 + depth cos(omega t)) x = 0 (Floquet, by SciPy)."""

    def rates(t, y):
        return y[1], -damping * y[1] - (1.0 + depth * math.cos(omega * t)) * y[0]

    turn = 2.0 * math.pi / omega
    columns = [solve_ivp(rates, (0.0, turn), y, "DOP853", rtol=1e-12, atol=1e-14).y[:, -1] for y in np.eye(2)]
    return float(np.sum(np.diag(columns))) + 1.0 + math.exp(-damping * turn)  # of a multiplier -1


def test_a_branch_born_from_rest_has_no_folds_and_ends_where_it_is_born():
    ripple = sw.gears.Variation((sw.gears.Ripple(1, 0.06),))
    system = sw.gears.VaryingOscillator(
        1.0, sw.gears.GearDamping(0.01), sw.Cubic(1.0, 1.0), sw.Harmonic(0.0), 2.0, variation=ripple
    )
    x, v = sw.simulate(system, (0.1, 0.0), np.linspace(0.0, 400.0 * np.pi, 401)).y[:, -1]
    orbit = sw.find_orbit(system, period=2, guess=np.array([[0.0, 0.0], [x, v], [v, -x]]))
    branch = sw.numerics.parameter_response(system, "omega", (1.9, 2.3), start=orbit)
    assert branch.folds == []
    birth = brentq(unstable_rest, 1.96, 1.99, xtol=1e-12)
    assert np.min(branch.values) == pytest.approx(birth, rel=1e-7)
    assert branch.message.startswith("is born at omega = 1.97158")
    assert np.max(branch.values) == 2.3
    steps = np.diff(branch.values)
    assert np.all(steps > 0.0) or np.all(steps < 0.0)
