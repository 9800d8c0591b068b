"""Response curves of awkward and of random systems: each ends with a status and a sentence, and none is unsound."""

import importlib.util
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import root

import strainwave as sw

pytestmark = pytest.mark.slow

BENCHMARKS = Path(__file__).resolve().parents[3] / "benchmarks"


def oscillator(law, B=0.05, amplitude=0.1, mean=0.0):
    return sw.Oscillator(1.0, B, law, sw.Harmonic(amplitude, mean=mean), 1.0)


def response(system, span=(0.5, 1.5), harmonics=5, points=100):
    branch = sw.frequency_response(system, span, harmonics=harmonics, points=points)
    for numbers in (branch.values, branch.omega, branch.coefficients, branch.peak, branch.multipliers):
        assert np.all(np.isfinite(numbers))
    return branch


@pytest.mark.slow
def test_without_damping_the_linear_resonance_is_said_to_have_no_bound():
    branch = response(oscillator(sw.Linear(1.0), B=0.0), span=(0.6, 1.5))
    assert not branch.status
    assert "grows without bound at omega = 1 rad/s" in branch.message
    assert "give more damping" in branch.message
    with pytest.raises(sw.SolveError, match="grows without bound"):
        sw.frequency_response(oscillator(sw.Linear(1.0), B=0.0), (0.6, 1.5), harmonics=5, points=100, throw=True)


@pytest.mark.slow
def test_without_damping_a_hardening_curve_reaches_both_ends():
    branch = response(oscillator(sw.Cubic(1.0, 0.1), B=0.0))
    assert branch.status
    assert {0.5, 1.5} <= set(branch.values)


def test_a_backlash_without_bias_floats_beyond_its_contact_and_the_sentence_says_where():
    law, B, F = sw.Backlash(1.0, 0.5), 0.1, 0.6
    branch = response(oscillator(law, B=B, amplitude=F), span=(0.6, 1.5), harmonics=15)
    ends = np.sqrt((-B * B + np.sqrt(B**4 + 4.0 * (F / law.half_gap) ** 2)) / 2.0)  # w sqrt(w^2 + B^2) = F/b
    assert branch.status
    assert "any mean is in balance" in branch.message
    assert "a mean torque would place it" in branch.message
    said = float(branch.message.split("at omega = ")[-1].split(" ..")[0])
    assert said == pytest.approx(ends, abs=0.03)  # the first point beyond
    assert said >= ends
    free = branch.values > ends
    exact = F / (branch.values * np.hypot(branch.values, B))
    assert branch.amplitude(1)[free] == pytest.approx(exact[free], rel=1e-9)
    assert branch.amplitude(0) == pytest.approx(0.0, abs=1e-9)


def test_a_range_through_rest_is_refused():
    for span in ((-0.5, 1.5), (0.0, 1.5)):
        with pytest.raises(ValueError, match=r"it must be 0 < low < high \(at rest there is no response\)"):
            sw.frequency_response(oscillator(sw.Linear(1.0)), span)


@pytest.mark.parametrize("law", [sw.Cubic(1.0, 0.1), sw.Backlash(1.0, 0.5)], ids=["Cubic", "Backlash"])
def test_without_forcing_the_response_is_rest(law):
    branch = response(oscillator(law, amplitude=0.0))
    assert branch.status
    assert np.all(branch.peak == 0.0)


@pytest.mark.slow
def test_with_a_mean_torque_alone_the_response_is_the_static_torsion():
    branch = response(oscillator(sw.Cubic(1.0, 0.1), amplitude=0.0, mean=0.3))
    x = branch.coefficients[:, 0]
    assert branch.status
    assert x + 0.1 * x**3 == pytest.approx(0.3, rel=1e-9)


def test_a_spring_without_stiffness_cannot_bear_a_mean_torque():
    branch = response(oscillator(sw.Linear(0.0), mean=0.1))
    assert not branch.status
    assert len(branch) == 0
    assert "no periodic response was found at omega = 0.5 or 1.5 rad/s" in branch.message
    assert "take less of it, or another range" in branch.message


def test_a_curve_without_a_stable_point_says_so():
    branch = response(oscillator(sw.Linear(1.0), B=-0.05))
    assert "no point of it is stable" in branch.message


@pytest.mark.slow
def test_an_imperfect_pitchfork_is_followed_on_its_own_side():
    # Found by the random systems: two branches 1e-3 apart, the other one closed; without the sign of the determinant
    # the curve changed to it and went round for ever.
    branch = sw.frequency_response(*robustness().random_system(101)[1:], harmonics=15)
    assert "reached both ends" in branch.message
    assert len(branch) < 3000


def robustness():
    spec = importlib.util.spec_from_file_location("robustness", BENCHMARKS / "robustness.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.slow
def test_random_systems_reach_both_ends_of_their_range():
    module = robustness()
    lost, unsound = [], []
    for seed in range(154):
        kind, branch, reached, fault = module.judge(seed, 15)
        if not reached:
            lost.append((seed, kind, branch.message))
        if fault:
            unsound.append((seed, kind, fault))
    assert unsound == []
    assert len(lost) <= 1, lost


def test_a_kinked_law_with_damping_beyond_every_float_lets_the_error_pass():
    law = sw.PiecewiseLinear(1e5, 1.3e5, 1.5e5, 14.0, 48.0)
    error = sw.KinematicError((sw.Line(2, 1e-4),))
    system = sw.Oscillator(1.3, 1e9, law, sw.Harmonic(0.0, mean=20.0), 100.0, error)
    branch = sw.frequency_response(system, (50.0, 300.0), harmonics=5)
    # B (x' - e') outweighs the rest: x - e keeps its mean, and the slowest motion decays with K/B
    np.testing.assert_allclose(branch.oscillation, 1e-4, rtol=1e-5)
    assert branch.stable.all()
    assert np.abs(branch.multipliers[:, 0]) == pytest.approx(
        np.exp(-1.3e5 / 1e9 * 2.0 * np.pi / branch.omega), rel=1e-6
    )


def quiet_and_large(system, y, omega):
    """Largest |x| of the period-1 motion near a state, by shooting with SciPy alone."""
    turn = 2.0 * np.pi / omega

    def rates(t, y):
        force = system.excitation.amplitude * np.cos(omega * t)
        return y[1], (force - system.B * y[1] - system.law.K * (y[0] + system.law.alpha * y[0] ** 3)) / system.J

    def turned(y):
        return solve_ivp(rates, (0.0, turn), y, "DOP853", rtol=1e-10, atol=1e-13).y[:, -1] - y

    start = root(turned, y, tol=1e-11).x
    assert np.max(np.abs(turned(start))) < 1e-6 * np.max(np.abs(start))
    run = solve_ivp(rates, (0.0, turn), start, "DOP853", rtol=1e-10, atol=1e-13, max_step=turn / 300.0)
    return float(np.max(np.abs(run.y[0])))


@pytest.mark.slow
def test_a_softening_curve_has_the_quiet_motion_that_does_not_join_the_large_one():
    """The article's drive with alpha = -0.1: the arc from rest folds at 382.7 rad/s and goes back to the saddles."""
    drive = sw.HDC_40_050._replace(law=sw.Cubic(7160.0, -0.1))
    system = drive.error_equation(motor_torque=sw.Harmonic(10.0), omega=1.0)
    branch = response(system, (150.0, 600.0), harmonics=15, points=200)
    assert [fold.omega for fold in branch.folds] == pytest.approx([382.669], abs=1e-3)
    assert (branch.omega[0], branch.stable[0]) == (150.0, True)
    assert branch.peak[0] == pytest.approx(0.003, rel=0.01)
    sweep = sw.jumps(branch)
    assert (sweep.jump_up, sweep.finished_up, sweep.finished_down) == (branch.folds[0].omega, True, True)
    assert sweep.on_run_down == ()
    for omega, sizes in ((250.0, (0.00441, 2.710)), (350.0, (0.01454, 1.531)), (375.0, (0.04755, 0.869))):
        crossed = np.flatnonzero((branch.omega[1:] - omega) * (branch.omega[:-1] - omega) < 0.0)
        found = [i for i in crossed if branch.stable[i] and branch.stable[i + 1]]
        assert len(found) == 2
        for i, size in zip(found, sizes, strict=True):
            c, orders = branch.coefficients[i], np.arange(1, 16)
            state = c[0] + c[1::2].sum(), omega * (orders * c[2::2]).sum()
            exact = quiet_and_large(system, state, omega)
            assert exact == pytest.approx(size, rel=1e-3)
            low, high = sorted(branch.peak[i : i + 2])
            assert low * (1.0 - 1e-3) <= exact <= high * (1.0 + 1e-3)
