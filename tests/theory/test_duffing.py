"""Exact oscillations of Duffing's equation: tables, integration, harmonic balance, mpmath, bad input."""

import math

import exact_duffing
import mpmath
import numpy as np
import pytest
from exact_duffing import cn_and_fall, cn_lines
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from scipy.special import ellipk

import strainwave as sw

HARD, SOFT = sw.Cubic(1.0, 0.1), sw.Cubic(1.0, -0.1)  # the well of SOFT ends at sqrt(10) rad


def constant(law, mean=0.0, J=1.0):
    return sw.Oscillator(J, 0.0, law, sw.Harmonic(0.0, mean=mean), 1.0)


def driven(law, torque, omega, J=1.0):
    return sw.Oscillator(J, 0.0, law, sw.Harmonic(torque), omega)


def integrated(J, torque, law, start, t):
    """Torsions and rates at t of J u'' + T(u) = torque(t), from rest."""
    run = solve_ivp(
        lambda s, y: (y[1], (torque(s) - law.torque(y[0])) / J),
        (0.0, t[-1]),
        (start, 0.0),
        "DOP853",
        t_eval=t,
        rtol=1e-13,
        atol=1e-16,
    )
    return run.y


FREE = [
    (constant(HARD), 5.0),
    (constant(SOFT), 1.0),
    (constant(SOFT), 3.1),
    (constant(sw.Cubic(1.0, 0.0)), 1.0),
    (constant(sw.Linear(2.0), 0.3, 0.5), 1.0),
    (constant(sw.Cubic(1.0, 0.3), 0.7, 2.0), -1.0),
    (constant(sw.Cubic(1.0, 0.3), 0.7), 0.0),
    (constant(SOFT, 0.5), 1.5),
    (constant(sw.Cubic(-1.0, -1.0)), 1.2),  # in one of two wells
    (constant(sw.Cubic(-1.0, -1.0)), 1.5),  # through both
    (constant(sw.Polynomial((0.1, 1.0, 0.4, 0.2))), 1.0),
    (constant(sw.Polynomial((0.0, 1.0, 0.4))), -1.5),
    (constant(sw.Cubic(1e4, 1.5e5), 20.0, 0.6), 2e-3),
]


@pytest.mark.parametrize(("system", "release"), FREE, ids=str)
def test_free_oscillation_solves_the_equation(system, release):
    motion = exact_duffing.free(system, release)
    t = np.linspace(0.0, 1.5 * motion.period, 40)
    u, rate = integrated(system.J, system.excitation.torque, system.law, release, t)
    swing = abs(motion.start - motion.turn) / 2.0
    np.testing.assert_allclose(motion.torsion(t), u, rtol=0.0, atol=1e-10 * swing)
    np.testing.assert_allclose(motion.velocity(t), rate, rtol=0.0, atol=1e-10 * swing * motion.omega)
    assert motion.torsion(0.5 * motion.period) == pytest.approx(motion.turn, abs=1e-13 * swing)


@pytest.mark.parametrize(("system", "release"), FREE, ids=str)
def test_fourier_coefficients_add_up_to_the_motion(system, release):
    motion, k = exact_duffing.free(system, release), np.arange(1, 61)
    z, t = motion.coefficients(60), np.linspace(0.0, motion.period, 50)
    series = z[0] + np.cos(motion.omega * np.outer(t, k)) @ z[1::2]
    np.testing.assert_allclose(series, motion.torsion(t), rtol=0.0, atol=2e-14 * np.max(np.abs(motion.torsion(t))))
    assert not np.any(z[2::2])


# Elliptic integrals to ten decimals (Abramowitz & Stegun, ch. 16 and 17)
@pytest.mark.parametrize(
    ("alpha", "releases", "omega"),
    [
        (0.1, [1.0, -1.0], [1.0367169071, 1.0367169071]),
        (1.0, [1.0, 2.0], [1.3177760650, 1.9760163641]),
        (10.0, [1.0], [2.8666401366]),
    ],
)
def test_frequencies_are_the_tabulated_ones(alpha, releases, omega):
    found = exact_duffing.frequency(constant(sw.Cubic(1.0, alpha)), releases)
    np.testing.assert_allclose(found, omega, rtol=0.0, atol=0.5e-10)


def test_small_free_oscillations_about_a_mean_torque_have_the_frequency_of_the_small_signal():
    system = constant(sw.Cubic(2.0, 0.3), 1.5, 0.7)
    about = sw.small_signal(system.law, 1.5)
    omega_0, a = math.sqrt(about.stiffness / system.J), np.array([0.08, 0.04, 0.02])
    motions = [exact_duffing.free(system, about.x + x) for x in a]
    swing = np.array([abs(motion.start - motion.turn) / 2.0 for motion in motions])
    gap = [motion.omega / omega_0 - 1.0 for motion in motions] - about.backbone * swing**2
    np.testing.assert_allclose(np.log2(gap[:-1] / gap[1:]), 4.0, atol=0.15)


@pytest.mark.parametrize("law", [HARD, SOFT], ids=str)
def test_first_order_backbone_meets_the_exact_one_with_an_error_of_fourth_order(law):
    system = constant(law)
    motions = [exact_duffing.free(system, release) for release in (1.2, 0.6, 0.3)]
    first = sw.slow_flow(system, sw.NONRESONANT).backbone([motion.coefficients(1)[1] for motion in motions])
    gap = np.abs(first - [motion.omega for motion in motions])
    np.testing.assert_allclose(np.log2(gap[:-1] / gap[1:]), 4.0, atol=0.2)


@pytest.mark.compiled
def test_free_oscillation_lies_on_the_backbone_of_harmonic_balance():
    system = constant(sw.Cubic(1.0, 0.3), 0.7)
    motion = exact_duffing.free(system, 2.0)
    z = motion.coefficients(20)
    curve = sw.numerics.backbone(system, [z[1]], harmonics=20)
    assert curve.omega[0] == pytest.approx(motion.omega, rel=1e-11)
    np.testing.assert_allclose(curve.coefficients[0], z, rtol=0.0, atol=1e-10)


FORCED = [
    (driven(HARD, 0.5, 1.3), 3),
    (driven(HARD, 0.5, 0.7), 1),
    (driven(HARD, 0.5, 1.0), 1),  # at the natural frequency
    (driven(SOFT, 0.05, 0.8), 3),
    (driven(SOFT, 0.5, 0.8), 1),
    (driven(SOFT, 0.5, 1.4), 1),
    (driven(sw.Linear(1.0), 0.5, 1.4), 1),
    (driven(sw.Cubic(7160.0, 1e4), 1.0, 377.0, 0.05), 1),
    (driven(sw.Cubic(-1.0, -1.0), 0.3, 1.0), 3),  # two wells
    (driven(sw.Polynomial((0.0, 0.0, 0.0, 1.0)), 0.1, 0.7), 3),
]


@pytest.mark.parametrize(("system", "count"), FORCED, ids=str)
def test_forced_oscillation_solves_the_equation_with_its_own_torque(system, count):
    motions = exact_duffing.forced(system)
    assert len({motion.start for motion in motions}) == len(motions) == count
    for motion in motions:
        excitation = motion.system.excitation
        assert motion.omega == pytest.approx(system.omega, rel=1e-14)
        assert excitation.torque(0.0) == pytest.approx(system.excitation.amplitude, rel=1e-14)
        t = np.linspace(0.0, motion.period, 20)
        u, rate = integrated(system.J, lambda s, e=excitation: e.torque(system.omega * s), system.law, motion.start, t)
        size = abs(motion.start)
        np.testing.assert_allclose(motion.torsion(t), u, rtol=0.0, atol=1e-9 * size)
        np.testing.assert_allclose(motion.velocity(t), rate, rtol=0.0, atol=1e-9 * size * system.omega)
        # the torque has the shape of the motion
        np.testing.assert_allclose(
            excitation.torque(system.omega * t) * motion.start,
            motion.torsion(t) * excitation.torque(0.0),
            rtol=0.0,
            atol=1e-14 * size,
        )


@pytest.mark.parametrize("system", [FORCED[0][0], FORCED[3][0]], ids=str)
def test_harmonic_balance_finds_each_forced_oscillation(system):
    for motion in exact_duffing.forced(system):
        h, k = 31, np.arange(1, 32)
        u = motion.coefficients(h)
        rate = np.zeros_like(u)
        rate[2::2] = -k * system.omega * u[1::2]
        orbit = sw.find_orbit(motion.system, harmonics=h, guess=0.999 * np.column_stack([u, rate]))
        np.testing.assert_allclose(orbit.coefficients[:, 0], u, rtol=0.0, atol=1e-11 * abs(motion.start))


def torque_needed(k1, k3, omega, a):
    """Torque per inertia under which a cn has the frequency: what the spring of that free frequency lacks."""

    def too_fast(r):
        return math.pi * r / (2.0 * ellipk(k3 * a * a / (2.0 * r * r))) - omega

    r = brentq(too_fast, math.sqrt(max(k3 * a * a / 2.0, 0.0)) + 1e-12, 10.0 * (omega + a), xtol=1e-14)
    return a * (k1 + k3 * a * a - r * r)


def test_every_forced_oscillation_is_found():
    rng, a, counts = np.random.default_rng(3), np.linspace(0.002, 3.0, 300), set()
    for k1, k3, omega, torque in rng.uniform((0.3, -1.0, 0.6, 0.05), (2.0, 1.0, 2.5, 0.5), (40, 4)):
        motions = exact_duffing.forced(driven(sw.Cubic(k1, k3 / k1), torque, omega))
        found = np.array([motion.start for motion in motions if abs(motion.start) < a[-1]])
        need = np.array([torque_needed(k1, k3, omega, size) for size in a])
        changes = [np.sum(np.diff(np.sign(need - side * torque)) != 0.0) for side in (1.0, -1.0)]
        assert [np.sum(found > 0.0), np.sum(found < 0.0)] == changes
        counts.add(len(motions))
        for start in found:
            assert torque_needed(k1, k3, omega, abs(start)) == pytest.approx(math.copysign(torque, start), rel=1e-9)
    assert counts == {1, 3}


@pytest.mark.parametrize("m", [-1e5, -3.0, -1e-3, 0.0, 1e-9, 0.5, 0.999, 1.0 - 1e-6])
def test_elliptic_functions_and_their_series_are_those_of_mpmath(m):
    K = float(mpmath.ellipk(m))
    z = np.linspace(0.0, 3.0 * K, 25)
    cn, fall = cn_and_fall(z, m)
    exact = [float(mpmath.re(mpmath.ellipfun("cn", x, m=m))) for x in z]
    product = [float(mpmath.re(mpmath.ellipfun("sn", x, m=m) * mpmath.ellipfun("dn", x, m=m))) for x in z]
    np.testing.assert_allclose(cn, exact, rtol=0.0, atol=1e-11)
    np.testing.assert_allclose(fall, product, rtol=0.0, atol=1e-11 * max(1.0, math.sqrt(1.0 - m)))
    orders = 2 * np.arange(200) + 1
    np.testing.assert_allclose(np.cos(np.outer(math.pi * z / (2.0 * K), orders)) @ cn_lines(m, 200), cn, atol=1e-11)


def test_text_of_an_oscillation_says_where_it_goes_and_how_fast():
    assert str(exact_duffing.free(constant(HARD), 1.0)) == (
        "Duffing oscillation, free: from 1 to -1 rad and back, omega 1.03671691 rad/s, m 0.0454545"
    )
    assert str(exact_duffing.forced(driven(HARD, 0.5, 0.7))[0]).startswith("Duffing oscillation, forced: from 0.880500")


@pytest.mark.parametrize("release", [math.sqrt(10.0), 3.3, -3.3])
def test_a_softening_law_swings_only_inside_its_well(release):
    assert exact_duffing.free(constant(SOFT), 0.9999 * math.sqrt(10.0)).omega < 0.3
    with pytest.raises(ValueError, match=r"^(Cubic.K=1.0, alpha=-0.1. released at|release is) .* rad[^.]*$"):
        exact_duffing.free(constant(SOFT), release)


@pytest.mark.parametrize(
    ("system", "release", "words"),
    [
        (constant(SOFT), 3.3, "take a release of less energy than at the saddles, -3.16228, 3.16228 rad"),
        (constant(SOFT, 0.5), -1.5, "take a release of less energy than at the saddles, -3.38762, 2.87408 rad"),
        (constant(sw.Linear(-1.0)), 1.0, "released at 1 rad does not swing back; take a law with a well"),
        (constant(HARD), 0.0, "release is 0 rad, where Cubic.* is in equilibrium; take another one"),
        (constant(SOFT), math.sqrt(10.0) * (1.0 - 1e-7), "too near a saddle"),
        (constant(HARD), math.nan, "release .rad. is nan; it must be a finite number"),
        (constant(HARD)._replace(B=0.1), 1.0, r"B is 0.1 N\*m\*s/rad; .* take B = 0"),
        (driven(HARD, 1.0, 1.0), 1.0, "free takes a constant torque"),
        (constant(HARD)._replace(error=sw.KinematicError((sw.Line(2, 1e-4),))), 1.0, "takes no kinematic error"),
    ],
)
def test_a_free_oscillation_without_closed_form_is_refused(system, release, words):
    with pytest.raises(ValueError, match=words):
        exact_duffing.free(system, release)


@pytest.mark.parametrize(
    ("system", "words"),
    [
        (driven(HARD, 0.0, 1.0), "amplitude .N.m. is 0.0; it must be a positive finite number"),
        (driven(HARD, 1.0, 0.0), "omega .rad/s. is 0.0; it must be a positive finite number"),
        (driven(HARD, 1.0, 0.01), "needs elliptic functions of 1 - m outside .* take a higher omega or less torque"),
        (driven(sw.Polynomial((0.0, 1.0, 0.1)), 1.0, 1.0), "takes an odd law"),
        (driven(HARD, 1.0, 1.0)._replace(B=0.1), r"B is 0.1 N\*m\*s/rad; .* take B = 0"),
        (constant(HARD, 1.0), "takes a cosine without phase and mean"),
        (driven(HARD, 1.0, 1.0)._replace(excitation=sw.Harmonic(1.0, order=3)), "takes a cosine without phase"),
    ],
)
def test_a_forced_oscillation_without_closed_form_is_refused(system, words):
    with pytest.raises(ValueError, match=words):
        exact_duffing.forced(system)


def test_other_laws_excitations_and_models_are_refused():
    for law in (sw.Backlash(1.0, 0.5), sw.Polynomial((0.0, 1.0, 0.0, 0.0, 0.1))):
        with pytest.raises(TypeError, match=r"free takes Linear, Cubic or Polynomial up to the third power, not"):
            exact_duffing.free(constant(law), 1.0)
    lines = sw.Harmonics((sw.Harmonic(1.0),))
    with pytest.raises(TypeError, match="forced takes a Harmonic as excitation, not Harmonics"):
        exact_duffing.forced(constant(HARD)._replace(excitation=lines))
    with pytest.raises(TypeError, match="forced takes a system such as an Oscillator; Drive has no"):
        exact_duffing.forced(sw.HDC_40_050)


def test_a_linear_law_has_no_steady_motion_at_its_resonance():
    assert exact_duffing.forced(driven(sw.Linear(4.0), 1.0, 2.0)) == ()
