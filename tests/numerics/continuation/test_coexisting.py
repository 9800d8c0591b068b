"""Ranges that begin or end inside a bistable band: the curve passes every motion at their ends, or tells of it."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import strainwave as sw
from strainwave.compile.tree import leaf_of
from strainwave.numerics.balance.harmonics import SEARCH_PER_TURN
from strainwave.numerics.balance.second_order import second_order
from strainwave.numerics.continuation.connected import connected

pytestmark = pytest.mark.slow

HARDENING = sw.Oscillator(1.0, 0.05, sw.Cubic(1.0, 0.1), sw.Harmonic(0.18), 1.0)  # NLvib example 01
SOFTENING = HARDENING._replace(law=sw.Cubic(1.0, -0.05), excitation=sw.Harmonic(0.1))
FOLDS = (1.115700, 1.269602)  # T1, to the digits printed there


def amplitudes_at(branch, omega):
    """Amplitudes of all orbits of a curve at one of its end frequencies."""
    return sorted(branch.amplitude(1)[branch.omega == omega])


def one_harmonic_amplitudes(system, omega):
    """The three of the cubic equation of harmonic balance with one harmonic (Nayfeh & Mook 1979, eq. 4.1.20)."""
    k, a3, F = system.law.K, 0.75 * system.law.K * system.law.alpha, system.excitation.amplitude
    detuning, loss = k - omega**2, system.B * omega
    squares = np.roots([a3**2, 2.0 * a3 * detuning, detuning**2 + loss**2, -(F**2)])
    return sorted(np.sqrt(r.real) for r in squares if abs(r.imag) < 1e-9 and r.real > 0.0)


@pytest.mark.parametrize("span", [(1.2, 2.0), (0.5, 1.2), (1.15, 1.25)])
@pytest.mark.parametrize("harmonics", [3, 4])
def test_a_range_that_begins_or_ends_in_the_band_shows_all_three_motions(span, harmonics):
    curve = sw.frequency_response(HARDENING, span, harmonics=harmonics, points=60)
    assert curve.message == "reached both ends"
    for end in span:
        expected = one_harmonic_amplitudes(HARDENING, end)
        assert len(expected) == (3 if FOLDS[0] < end < FOLDS[1] else 1)
        np.testing.assert_allclose(amplitudes_at(curve, end), expected, rtol=0.03)  # of the third harmonic
    assert sorted(f.omega for f in curve.folds) == pytest.approx(FOLDS, abs=0.01)


def test_a_softening_band_at_the_upper_end_is_shown_too():
    curve = sw.frequency_response(SOFTENING, (0.5, 0.92), harmonics=3, points=60)
    np.testing.assert_allclose(amplitudes_at(curve, 0.92), one_harmonic_amplitudes(SOFTENING, 0.92), rtol=0.03)


def test_the_run_up_from_inside_the_band_drops_at_its_fold():
    curve = sw.frequency_response(HARDENING, (1.2, 2.0), harmonics=7, points=60)
    told = sw.jumps(curve)
    assert told.jump_down == pytest.approx(FOLDS[1], abs=0.5e-6)
    assert "outside the range" in " ".join(str(told).split())


def test_a_range_without_coexisting_motions_is_not_left():
    curve = sw.frequency_response(HARDENING, (0.8, 1.1), harmonics=3, points=60)
    assert curve.omega.min() == 0.8
    assert curve.omega.max() == 1.1


def settled(rates, omega, size, turns):
    """States (x, x'/omega) at phase 0 on which random starts settle; rates(phase, x, v) is x'' of all of them."""
    rng, starts = np.random.default_rng(7), 16
    radius, angle = size * np.exp(rng.uniform(np.log(0.02), np.log(2.0), starts)), rng.uniform(0.0, 2.0 * np.pi, starts)
    y = np.concatenate([radius * np.cos(angle), radius * np.sin(angle)])

    def slopes(phase, y):
        return np.concatenate([y[starts:], rates(phase, y[:starts], omega * y[starts:]) / omega**2])

    ends = 2.0 * np.pi * np.array([0.0, turns, turns + 1.0])
    run = solve_ivp(slopes, ends[[0, 2]], y, method="DOP853", t_eval=ends[1:], rtol=1e-7, atol=1e-8 * size)
    before, after = run.y.T.reshape(2, 2, starts)
    still = np.hypot(*(after - before)) < 1e-3 * size
    assert np.mean(still) > 0.5
    return after[:, still].T


def motions_at(curve, omega):
    """States (x, x'/omega) at phase 0 of the stable motions at an end of a range, on the curve or told of beside it."""
    tables = [*curve.coefficients[(curve.omega == omega) & curve.stable]]
    tables += [orbit.coefficients[:, 0] for orbit in curve.elsewhere if orbit.omega == omega and orbit.stable]
    assert tables
    return states(tables)


def states(tables):
    """States (x, x'/omega) at phase 0 of orbits with these coefficients of x."""
    return np.array([(x[0] + np.sum(x[1::2]), np.arange(1, len(x) // 2 + 1) @ x[2::2]) for x in tables])


def none_lost(system, span, omega, rates, size, turns, **options):
    """Assert that the curve passes, or tells of, two or more motions at an end and all on which starts settle."""
    curve = sw.frequency_response(system, span, **options)
    known, found = motions_at(curve, omega), settled(rates, omega, size, turns)
    assert curve.status
    assert len(known) >= 2
    near = np.linalg.norm(found[:, None] - known, axis=2) < 0.02 * size
    assert near.any(axis=1).all()
    assert near.any(axis=0).sum() >= 2  # starts do settle on two of them


@pytest.mark.parametrize(("span", "omega"), [((1.2433, 2.0), 1.2433), ((0.5, 1.25), 1.25), ((1.26, 2.0), 1.26)])
def test_no_motion_of_a_hardening_spring_is_lost_near_the_upper_fold(span, omega):
    def rates(phase, x, v):
        return 0.18 * np.cos(phase) - 0.05 * v - x - 0.1 * x**3

    none_lost(HARDENING, span, omega, rates, 3.0, 90)


@pytest.mark.slow
def test_no_motion_is_lost_where_three_lines_excite_a_gear():
    J, B, K, alpha = 94.77774888530446, 10925.82863829914, 39917587.08021615, 26833.206572168852
    lines = (
        (89755.1510566948, 1, -0.9207774993123348),
        (35845.15463565017, 5, -1.302477080113946),
        (265624.2532125036, 4, 1.5651580313230387),
    )
    excitation = sw.Harmonics(tuple(sw.Harmonic(*line) for line in lines))
    omega = 362.88007663033864

    def rates(phase, x, v):
        return (sum(a * np.cos(k * phase + p) for a, k, p in lines) - B * v - K * (x + alpha * x**3)) / J

    system = sw.Oscillator(J, B, sw.Cubic(K, alpha), excitation, omega)
    none_lost(system, (omega, 1515.2597465696838), omega, rates, 0.02, 25)


@pytest.mark.slow
def test_no_motion_of_a_law_with_corners_is_lost_at_a_narrow_superharmonic_resonance():
    # two orbits lie on closed curves over strength and constant torque; only that over the speed connects them
    outer = 0.5 + 1.0 / 3.35

    def rates(phase, x, v):
        u = np.abs(x)
        torque = np.where(u < 0.5, u, np.where(u < outer, 0.5 + 3.35 * (u - 0.5), 1.5 + 1.416 * (u - outer)))
        return 1.744 * np.cos(phase) - 0.034 * v - np.sign(x) * torque

    law = sw.PiecewiseLinear(1.0, 3.35, 1.416, 0.5, 1.5)
    system = sw.Oscillator(1.0, 0.034, law, sw.Harmonic(1.744), 1.0)
    none_lost(system, (0.4449, 0.5), 0.4449, rates, 2.0, 45, harmonics=15)


@pytest.mark.parametrize("omega", [1.2, 1.35])
def test_no_motion_of_a_varying_stiffness_is_lost(omega):
    def rates(phase, x, v):
        return 0.3 * np.cos(phase) - 0.06 * v - (1.0 + 0.1 * np.cos(phase)) * (x + 0.1 * x**3)

    variation = sw.gears.Variation((sw.gears.Ripple(1, 0.1),))
    parts = sw.gears.GearDamping(0.06), sw.Cubic(1.0, 0.1), sw.Harmonic(0.3), 1.0, sw.NoError(), variation
    none_lost(sw.gears.VaryingOscillator(1.0, *parts), (omega, 2.5), omega, rates, 4.0, 80)


@pytest.mark.slow
def test_no_motion_without_the_symmetry_of_its_system_is_lost():
    # curves of symmetric motions pass by those without the symmetry, which begin on them at other strengths
    lines = (3, 0.14109204523148583, 1.42000551944892), (5, 0.10785390313782177, -0.4373281041459611)
    B, alpha, omega = 0.036291867240299945, 0.5887602807613852, 0.28
    error = sw.KinematicError(tuple(sw.Line(*line) for line in lines))
    system = sw.Oscillator(1.0, B, sw.Cubic(1.0, alpha), sw.Harmonic(0.0), omega, error)

    def rates(t, y):
        u = y[0] - sum(a * np.cos(k * omega * t + p) for k, a, p in lines)
        du = y[1] + omega * sum(k * a * np.sin(k * omega * t + p) for k, a, p in lines)
        return y[1], -B * du - u - alpha * u**3

    turns = 2.0 * np.pi / omega * np.array([0.0, 39.5, 40.0, 41.0])
    run = solve_ivp(rates, turns[[0, -1]], (-0.645, -0.316), method="DOP853", t_eval=turns[1:], rtol=1e-8, atol=1e-8)
    half, before, after = run.y.T / (1.0, omega)
    np.testing.assert_allclose(after, before, atol=1e-4)
    assert np.linalg.norm(half + after) > 0.1  # it is not minus itself half a turn later
    leaf = leaf_of(system, "omega")
    problem = second_order(system, leaf, leaf, 15)
    found = connected(problem, omega, [])
    known = states([problem.state_table(table)[:, 0] for table in found.tables])
    for motion in (after, -half):
        assert np.min(np.linalg.norm(known - motion, axis=1)) < 1e-3


def test_the_harmonics_of_a_search_are_those_that_the_lines_need_however_many_the_curve_has():
    # an error of order 2 alone is rounding in the others
    error = sw.KinematicError((sw.Line(2, 0.01, 0.3),))
    system = HARDENING._replace(error=error, excitation=sw.Harmonic(0.0))
    leaf = leaf_of(system, "omega")
    found = connected(second_order(system, leaf, leaf, 60), 0.3, [])
    assert [table.shape for table in found.tables] == [(2 * SEARCH_PER_TURN + 1, 1)]
