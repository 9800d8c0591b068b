"""Response curves of the slow flow: branches, folds, peaks, stability; the certificate."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq, root

import strainwave as sw
from strainwave.theory.slow_flow.averaging import averaged_flow
from strainwave.theory.slow_flow.response import response
from strainwave.theory.slow_flow.setting import setting

T4 = sw.Oscillator(1.0, 0.01, sw.Cubic(1.0, 0.2), sw.Harmonic(0.01), 1.05)
NEXT_TO_A_FOLD = sw.Oscillator(0.3633274, 4.2345343, sw.Cubic(405.19695, -56.437648), sw.Harmonic(42.279498), 9.0)
DOUBLING = sw.Oscillator(
    1.0, 0.0136, sw.Cubic(1.0, 0.2035),
    sw.Harmonics((sw.Harmonic(0.5334, 2, 1.83), sw.Harmonic(0.163, 3, 0.06))), 0.5079,
)  # fmt: skip
DOUBLING_AT_REST = sw.Oscillator(
    1.0, 0.01288, sw.PiecewiseLinear(1.0, 1.2053, 2.3225, 0.3965, 1.2438),
    sw.Harmonics((sw.Harmonic(0.4154, 3, 1.689, 0.4567),)), 0.23877,
)  # fmt: skip
T7 = sw.Oscillator(1.0, 0.01, sw.Cubic(1.0, 0.2), sw.Harmonic(2.0), 3.15)


@pytest.fixture(scope="module")
def curve():
    return sw.slow_flow(T4, sw.PRIMARY).response((0.9, 1.2))


def test_peak_of_the_primary_curve_is_at_its_vertex(curve):
    """T4: first-order multiple scales peak 1.000 at 1.0750."""
    assert curve.peak == pytest.approx((1.0750, 1.000), abs=1e-12)


def test_folds_are_double_roots_of_e4(curve):
    """Both sides of E4 and their derivative in s = a^2 vanish: mu^2/4 + (sigma - k s)^2 - 2 k s (sigma - k s) = 0."""
    assert len(curve.folds) == 2
    k, mu = 0.075, 0.01
    for omega, a in zip(curve.folds, curve.fold_amplitudes, strict=True):
        rest = omega - 1.0 - k * a * a
        assert mu**2 / 4.0 + rest**2 - 2.0 * k * a * a * rest == pytest.approx(0.0, abs=1e-10)
    # discriminant of the cubic in s, an independent way to the same speeds

    def discriminant(omega):
        sigma = omega - 1.0
        a, b, c, d = k * k, -2.0 * k * sigma, mu**2 / 4.0 + sigma**2, -((0.01 / 2.0) ** 2)
        return 18 * a * b * c * d - 4 * b**3 * d + b * b * c * c - 4 * a * c**3 - 27 * a * a * d * d

    for omega in curve.folds:
        assert discriminant(omega - 1e-9) * discriminant(omega + 1e-9) < 0.0


def test_curve_is_ordered_along_its_arc_and_turns_back_between_the_folds(curve):
    (branch,) = curve.branches
    assert branch.omega[0] == pytest.approx(0.9, rel=1e-12)
    assert branch.omega[-1] == pytest.approx(1.2, rel=1e-12)
    turns = np.flatnonzero(np.diff(np.sign(np.diff(branch.omega))))
    assert branch.omega[turns + 1] == pytest.approx(curve.folds[::-1], rel=1e-12)
    assert np.array_equal(curve.omega, branch.omega)
    jumps = np.hypot(np.diff(branch.omega) / 0.3, np.diff(branch.amplitude))
    assert np.max(jumps) < 0.08


def test_curve_is_unstable_exactly_between_the_folds(curve):
    (branch,) = curve.branches
    falling = np.gradient(branch.omega) < 0.0
    inside = np.abs(branch.omega[:, None] - np.array(curve.folds)).min(axis=1) > 1e-6
    assert np.array_equal(branch.stable[inside], ~falling[inside])
    assert not np.all(branch.stable)


def test_every_point_of_a_curve_is_a_steady_state(curve):
    flow = sw.slow_flow(T4, sw.PRIMARY)
    for omega, a, phase in zip(curve.omega[::7], curve.amplitude[::7], curve.branches[0].phase[::7], strict=True):
        moved = sw.slow_flow(T4._replace(omega=float(omega)), sw.PRIMARY)
        assert abs(moved.rates(a * np.exp(-1j * phase))) < 1e-10
    assert abs(flow.rates(1.0 + 0j)) > 1e-3


def test_integrals_trace_the_same_curve_as_the_closed_form(curve):
    by_integrals = response(averaged_flow(setting(T4, sw.PRIMARY)), 0.9, 1.2)
    assert by_integrals.folds == pytest.approx(curve.folds, abs=1e-10)
    assert by_integrals.peak == pytest.approx(curve.peak, rel=1e-9)


def test_subharmonic_curve_starts_at_a_fold_where_existence_begins():
    """T7's oscillator: from E6 the two states merge where k C^2 (4 sigma - 7 k C^2) = 9 mu^2."""
    found = sw.slow_flow(T7, sw.SUBHARMONIC).response((2.8, 4.0))
    (omega,) = found.folds
    C, k = 2.0 / (1.0 - omega**2), 9.0 / 8.0 * 0.2
    assert k * C**2 * (4.0 * (omega - 3.0) - 7.0 * k * C**2) == pytest.approx(9.0 * 0.01**2, rel=1e-8)
    assert len(found.branches) == 1
    assert all(stable for _, stable in found.trivial)


def test_isolated_loop_is_found_and_closed():
    """With more damping the subharmonic motion exists over a bounded range of speeds only."""
    found = sw.slow_flow(T7._replace(B=0.04), sw.SUBHARMONIC).response((2.8, 6.5))
    (branch,) = found.branches
    assert branch.closed
    assert (branch.omega[0], branch.amplitude[0]) == (branch.omega[-1], branch.amplitude[-1])
    assert len(found.folds) == 2
    for omega in found.folds:
        C, k = 2.0 / (1.0 - omega**2), 9.0 / 8.0 * 0.2
        assert k * C**2 * (4.0 * (omega - 3.0) - 7.0 * k * C**2) == pytest.approx(9.0 * 0.04**2, rel=1e-8)


def test_band_without_a_state_gives_an_empty_curve_and_a_sentence():
    found = sw.slow_flow(T7._replace(B=0.5), sw.SUBHARMONIC).response((2.8, 4.0))
    assert (found.branches, found.folds) == ((), ())
    assert found.omega.size == 0
    assert "no steady state with a > 0" in found.message


def primary_count(system, omega):
    """Steady states of the primary resonance of a cubic law: real positive roots of E4 in s = a^2, scaled."""
    omega_0, mu = np.sqrt(system.law.K / system.J), system.B / system.J
    k, sigma, f = 0.375 * system.law.alpha * omega_0, omega - omega_0, system.excitation.amplitude / system.J
    c = np.array([k * k, -2.0 * k * sigma, mu**2 / 4.0 + sigma**2, -((f / (2.0 * omega_0)) ** 2)])
    scale = abs(c[-1] / c[0]) ** (1.0 / 3.0)
    roots = np.roots(c * scale ** np.arange(3.0, -1.0, -1.0))
    return int(np.sum((np.abs(roots.imag) < 1e-9 * np.abs(roots)) & (roots.real > 0.0)))


def crossings(found, omega):
    """How often the branches of a response pass a speed."""
    return sum(int(np.sum((b.omega[1:] - omega) * (b.omega[:-1] - omega) < 0.0)) for b in found.branches)


@pytest.mark.parametrize(
    ("system", "band"),
    [
        # a state of the seeding grid lies next to a fold: the branch was traced twice, its fold listed twice
        (NEXT_TO_A_FOLD, (1.67, 136.7)),
        # little damping: steps went from the lower arm before the resonance to the one behind it
        (sw.Oscillator(1.0, 1e-4, sw.Cubic(1.0, 0.1), sw.Harmonic(1e-3), 1.0), (0.3, 2.0)),
        (sw.Oscillator(1.0, 1e-6, sw.Cubic(1.0, -0.1), sw.Harmonic(1e-3), 1.0), (0.3, 2.0)),
    ],
    ids=["next to a fold", "hardening", "softening"],
)
def test_as_many_states_as_roots_at_every_speed(system, band):
    found = sw.slow_flow(system, sw.PRIMARY).response(band)
    away = [w for w in np.linspace(*band, 202)[1:-1] if np.min(np.abs(w - np.array(found.folds)), initial=1.0) > 1e-6]
    assert [crossings(found, w) for w in away] == [primary_count(system, w) for w in away]
    changes = np.flatnonzero(np.diff([primary_count(system, w) for w in np.linspace(*band, 2000)]))
    assert len(found.folds) == len(changes)
    ends = [end for b in found.branches for end in (b.omega[0], b.omega[-1])]
    assert all(end in band for end in ends)
    assert len(ends) == sum(primary_count(system, w) for w in band)


@pytest.mark.parametrize("B", [1e-4, 1e-6])
def test_a_sharp_peak_is_climbed_whatever_the_damping(B):
    """The largest amplitude is F/(B omega_0), between speeds of the seeding grid."""
    found = sw.slow_flow(sw.Oscillator(1.0, B, sw.Linear(1.0), sw.Harmonic(1e-3), 1.1), sw.PRIMARY).response((0.3, 2.0))
    (branch,) = found.branches
    assert found.peak == pytest.approx((1.0, 1e-3 / B), rel=1e-6)
    assert (branch.omega[0], branch.omega[-1]) == (0.3, 2.0)


@pytest.mark.parametrize(
    ("c2", "c3", "F", "mu", "band", "near"),
    [
        (0.3, 0.2, 1.0, 0.05, (1.5, 3.0), ((1.8, 2.0), (2.05, 2.3))),
        # next to a = 0, where the speed stands still, rounding turned the branch back and forth: two more folds
        (0.2330213786487473, 0.2895419266043112, 2.164464348634745, 0.11182985639676844, (1.713067601682969,
         5.0862577806115095), ((2.0, 2.14), (2.16, 2.3))),
    ],
)  # fmt: skip
def test_a_branch_born_at_rest_is_listed_once_with_one_fold(c2, c3, F, mu, band, near):
    """A quadratic and a cubic term under a line at twice the speed: the loop through a = 0 holds each state twice.

    With C = F/(1 - omega^2) the flow is z' = -(mu/2 + i (omega/2 - 1 - (3/4) c3 C^2 - (3/8) c3 |z|^2)) z + i (c2/2)
    C conj(z): a = 0 loses its stability where mu^2/4 + (omega/2 - 1 - (3/4) c3 C^2)^2 = (c2 C/2)^2, and two states
    merge where c2 |C| = mu.
    """
    system = sw.Oscillator(1.0, mu, sw.Polynomial((0.0, 1.0, c2, c3)), sw.Harmonic(F), 0.506 * sum(band))
    found = sw.slow_flow(system, sw.Resonance(1, 2)).response(band)

    def margin(omega):
        C = F / (1.0 - omega**2)
        return mu**2 / 4.0 + (omega / 2.0 - 1.0 - 0.75 * c3 * C**2) ** 2 - (0.5 * c2 * C) ** 2

    births = [brentq(margin, *some, xtol=1e-14) for some in near]
    (branch,) = found.branches
    assert sorted((branch.omega[0], branch.omega[-1])) == pytest.approx(births, rel=1e-10)
    assert (branch.amplitude[0], branch.amplitude[-1]) == (0.0, 0.0)
    assert found.folds == pytest.approx([np.sqrt(1.0 + F * c2 / mu)], rel=1e-9)
    assert "begins at a = 0" in found.message


def test_kinematic_error_forces_with_the_square_of_the_speed():
    """The soft line of e is J omega^2 k^2 A_k, so the response is not that of a constant torque."""
    line = sw.KinematicError((sw.Line(2, 1e-3),))
    system = sw.Oscillator(1.0, 0.05, sw.Linear(1.0), sw.Harmonic(0.0), 0.5, line)
    found = sw.slow_flow(system, sw.Resonance(2, 1)).response((0.45, 0.55))
    expected = 1e-3 * (2.0 * found.omega) ** 2 / 2.0 / np.hypot(0.025, 2.0 * found.omega - 1.0)
    assert found.amplitude == pytest.approx(expected, rel=1e-9)


# (A, peak error, error of its frequency) of first order against converged harmonic balance, case T5
PEAK_ERRORS = [
    (0.002, 0.0030, 0.0000), (0.005, 0.0180, 0.0008), (0.01, 0.0646, 0.0100), (0.02, 0.196, 0.089), (0.05, 0.596, 0.81),
]  # fmt: skip


@pytest.mark.parametrize(("A", "error", "shift"), PEAK_ERRORS)
def test_certificate_knows_the_error_of_the_peak(A, error, shift):
    peak = A / 0.01
    at_peak = T4._replace(excitation=sw.Harmonic(A), omega=1.0 + 0.075 * peak**2)
    certificate = sw.slow_flow(at_peak, sw.PRIMARY).certificate(curve=True)
    assert certificate.amplitude == pytest.approx(error, rel=0.01)
    assert certificate.speed == pytest.approx(shift, abs=6e-3)
    assert certificate.valid == (A <= 0.01)
    assert ("not valid" in certificate.sentence) == (not certificate.valid)


def test_a_state_beyond_the_end_of_the_true_curve_is_not_valid_though_the_curve_is():
    """The true curve ends at 1.064: at 1.075 the motion has jumped down."""
    flow = sw.slow_flow(T4._replace(omega=1.075), sw.PRIMARY)
    assert settled(T4._replace(omega=1.075), flow.steady_states()[0].z, 1) < 0.1
    certificate = flow.certificate()
    assert certificate.amplitude_at_speed is None
    assert not certificate.valid
    assert flow.certificate(curve=True).valid


def settled(system, z, k):
    """Amplitude [rad] at order k of the motion that equal equations settle to from a slow state z [rad]."""
    lines, law = system.excitation, system.law

    def rates(t, y):
        return y[1], (lines.torque(system.omega * t) - system.B * y[1] - law.torque(y[0])) / system.J

    period = 2.0 * np.pi / system.omega
    start = z.real, -system.omega * k * z.imag
    last = period * (round(18.0 / (system.B * period)) + np.arange(256) / 256)
    found = solve_ivp(rates, (0.0, last[-1]), start, "DOP853", last, rtol=1e-6, atol=1e-9)
    return 2.0 * abs(np.fft.rfft(found.y[0])[k]) / 256


def test_certificate_follows_the_true_curve_to_the_speed_of_the_state():
    """Between 3 % at equal phase and the true state at equal speed lie 7 % of speed, too far for one correction."""
    lines = sw.Harmonics((sw.Harmonic(0.174, 3, 1.0, 0.147), sw.Harmonic(0.922, 4, 0.5)))
    system = sw.Oscillator(1.0, 0.0242, sw.Cubic(1.0, 0.2546), lines, 0.27)
    flow = sw.slow_flow(system, sw.Resonance(4, 1), order=2)
    (state,), certificate = flow.steady_states(), flow.certificate()
    true = settled(system, state.z, 4)
    assert certificate.amplitude_at_speed == pytest.approx(1.0 - state.amplitude / true, rel=1e-3)
    assert certificate.amplitude_at_speed > 0.1
    assert not certificate.valid


@pytest.mark.slow
@pytest.mark.parametrize("order", [1, 2])
def test_a_component_that_symmetry_forbids_is_no_state(order):
    """Order 3 alone repeats every third of a turn, and so does its motion: nothing at 2/3 of the speed."""
    law = sw.PiecewiseLinear(1.0, 1.605, 2.2676, 0.7356, 1.6951)
    error = sw.KinematicError((sw.Line(3, 0.3373, 0.8411),))
    system = sw.Oscillator(1.0, 0.1606, law, sw.Harmonic(5.957, 3, -0.265, 0.2765), 1.3886, error)
    flow = sw.slow_flow(system, sw.Resonance(2, 3), order=order)
    assert [state.amplitude for state in flow.steady_states()] == [0.0]


def test_certificate_is_not_valid_where_the_amplitude_at_equal_speed_is_far_off():
    """Near a steep side of the curve 6 % at equal phase are 16 % at equal speed."""
    steep = T4._replace(B=0.1, excitation=sw.Harmonic(0.1), omega=1.075)
    certificate = sw.slow_flow(steep, sw.PRIMARY).certificate()
    assert certificate.amplitude < 0.1 < certificate.amplitude_at_speed
    assert not certificate.valid
    assert "not valid" in certificate.sentence


def multipliers(system, y):
    """Floquet multipliers over a turn of the motion that repeats from next to y."""

    def rates(t, y):
        phase = system.omega * t
        u, du = y[0] - system.error.value(phase), y[1] - system.omega * system.error.slope(phase)
        push, pull = system.excitation.torque(phase) - system.law.torque(u), system.law.stiffness(u)
        changes = [(y[i + 1], -(system.B * y[i + 1] + pull * y[i]) / system.J) for i in (2, 4)]
        return y[1], (push - system.B * du) / system.J, *changes[0], *changes[1]

    def after(y):
        start = *y, 1.0, 0.0, 0.0, 1.0
        return solve_ivp(rates, (0.0, 2.0 * np.pi / system.omega), start, "DOP853", rtol=1e-9, atol=1e-12).y[:, -1]

    def miss(y):
        end = after(y)
        return end[:2] - y, end[2:].reshape(2, 2).T - np.eye(2)

    found = root(miss, y, jac=True)
    assert found.success
    return np.linalg.eigvals(after(found.x)[2:].reshape(2, 2))


@pytest.mark.parametrize("share", [0.5, 1.0])
@pytest.mark.parametrize(("system", "p"), [(DOUBLING, 2), (DOUBLING_AT_REST, 5)], ids=["2:1", "5:1"])
def test_certificate_is_not_valid_where_the_period_doubles(system, p, share):
    """The slow flow calls both states stable: it turns with the common period and knows no other."""
    lines = tuple(line._replace(amplitude=share * line.amplitude) for line in system.excitation.terms)
    system = system._replace(excitation=sw.Harmonics(lines))
    flow = sw.slow_flow(system, sw.Resonance(p, 1), order=2)
    state, certificate = flow.steady_states()[0], flow.certificate()
    assert state.stable
    assert certificate.amplitude_at_speed < 0.1
    t = np.array([0.0, 1e-6])
    x = flow.steady_x(state.z, t)
    doubles = min(multipliers(system, (x[0], (x[1] - x[0]) / 1e-6)).real) < -1.0
    assert doubles == (share == 1.0)
    assert certificate.valid == (not doubles)
    assert certificate.sentence.endswith("the true motion is not stable, its period doubles") == doubles


@pytest.mark.slow
def test_certificate_is_not_valid_where_the_true_motion_grows_beside_its_resonance():
    """Order 4 pumps a motion of order 2, which a slow flow of 3:2 does not know."""
    law = sw.PiecewiseLinear(1.0, 2.0737, 2.5223, 0.7264, 1.2139)
    system = sw.Oscillator(1.0, 0.078238, law, sw.Harmonic(1.3734, 4, 2.4792, 0.54548), 0.59136)
    flow = sw.slow_flow(system, sw.Resonance(3, 2))
    (state,), certificate = flow.steady_states(), flow.certificate()
    assert state.stable
    assert certificate.amplitude < 0.1
    x = flow.steady_x(state.z, np.array([0.0, 1e-6]))
    assert max(multipliers(system, (x[0], (x[1] - x[0]) / 1e-6)).real) > 1.0
    assert not certificate.valid
    assert certificate.sentence.endswith("; the true motion is not stable")


def test_certificate_of_a_subharmonic_state_agrees_with_the_true_one():
    """T7: .86502 by multiple scales, .87516 true."""
    certificate = sw.slow_flow(T7, sw.SUBHARMONIC).certificate()
    assert certificate.amplitude == pytest.approx(1.0 - 0.86502 / 0.87516, abs=2e-5)
    assert certificate.valid


def test_certificate_of_the_forced_motion_is_exact_for_a_linear_law():
    """Without damping the hard line is the whole solution; damping is what first order leaves out of it."""
    system = sw.Oscillator(1.0, 0.0, sw.Linear(1.0), sw.Harmonic(0.3), 0.4)
    assert sw.slow_flow(system, sw.NONRESONANT).certificate().amplitude < 1e-14
    damped = sw.slow_flow(system._replace(B=0.1), sw.NONRESONANT).certificate()
    assert damped.amplitude == pytest.approx(0.1 * 0.4 / 0.84, rel=1e-12)  # |1 - (1 - w^2 + i mu w)/(1 - w^2)|


def test_certificate_is_honest_where_it_knows_nothing():
    """A strong quadratic law: the correction runs away, and the certificate says that nothing is known."""
    system = sw.Oscillator(1.0, 0.02, sw.Polynomial((0.0, 1.0, 0.3)), sw.Harmonic(0.3), 0.5)
    certificate = sw.slow_flow(system, sw.Resonance(2, 1)).certificate()
    assert not certificate.valid
    assert certificate.amplitude >= 1.0
    assert "nothing is known" in certificate.sentence
    assert np.isfinite(certificate.amplitude)


@pytest.mark.parametrize(
    ("A", "mu", "alpha", "band"),
    [
        ((0.0085, 0.0306), 0.0358, 0.287, (0.397, 1.193)),
        ((0.0294, 0.0481), 0.0589, 0.122, (0.314, 1.052)),
        ((0.003, 0.0185), 0.0113, 0.302, (0.337, 1.158)),
    ],
)
def test_a_curve_is_listed_once_on_both_sides_of_a_speed_at_which_a_line_sits_on_omega_0(A, mu, alpha, band):
    """Lines 1 and 2 of a kinematic error, the primary resonance of line 2, and line 1 on omega_0 = 1 in the range.

    The line 1 of amplitude C = omega^2 A_1/(1 - omega^2) moves the resonance by (3/4) alpha C^2 as the state does by
    (3/8) alpha a^2; the soft line is f = 4 omega^2 A_2.
    """
    error = sw.KinematicError((sw.Line(2, A[1]), sw.Line(1, A[0])))
    system = sw.Oscillator(1.0, mu, sw.Cubic(1.0, alpha), sw.Harmonic(0.0), 0.6, error)
    found = sw.slow_flow(system, sw.Resonance(2, 1)).response(band)

    def count(omega):
        C, f = omega**2 * A[0] / (1.0 - omega**2), 4.0 * omega**2 * A[1]
        k, sigma = 0.375 * alpha, 2.0 * omega - 1.0 - 0.75 * alpha * C * C
        roots = np.roots([k * k, -2.0 * k * sigma, mu**2 / 4.0 + sigma**2, -((f / 2.0) ** 2)])
        return int(np.sum((np.abs(roots.imag) < 1e-9 * np.abs(roots)) & (roots.real > 0.0)))

    away = [w for w in np.linspace(*band, 102)[1:-1] if np.min(np.abs(w - np.array([*found.folds, 1.0]))) > 5e-3]
    assert [crossings(found, w) for w in away] == [count(w) for w in away]
    assert "stops inside the range at omega" in found.message


@pytest.mark.parametrize("law", [sw.Cubic(1.0, 0.05), sw.Polynomial((0.0, 1.0, 0.0, 0.05, 0.0, 0.01))])
def test_a_curve_goes_through_the_speed_at_which_another_line_sits_on_omega_0(law):
    # order 2 meets omega_0 = 1 at 0.5, which is among the places where the curve is looked for
    terms = sw.Harmonics((sw.Harmonic(0.02), sw.Harmonic(0.001, order=2)))
    system = sw.Oscillator(1.0, 0.02, law, terms, 1.0)
    flow = sw.slow_flow(system, sw.PRIMARY)
    through = flow.response((0.5, 1.5))
    (branch,) = through.branches
    assert np.all(np.isfinite([branch.omega, branch.amplitude, branch.phase, branch.peak]))
    # at the top of the curve damping alone balances the line: a = A/(B omega_0)
    assert through.peak[1] == pytest.approx(0.02 / 0.02, rel=1e-6)
    assert through.peak == pytest.approx(flow.response((0.6, 1.5)).peak, rel=1e-6)
