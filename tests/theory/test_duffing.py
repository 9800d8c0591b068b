"""Exact oscillations of Duffing's equation, against an integration; theory and harmonic balance against them."""

import math

import exact_duffing
import numpy as np
import pytest
from scipy.integrate import solve_ivp

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


@pytest.mark.slow
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
