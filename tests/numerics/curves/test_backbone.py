"""Backbone: the elliptic integrals of the cubic spring, multiple scales at small amplitude, laws with play or bias."""

import math

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.special import ellipk, ellipkm1

import strainwave as sw


def free(law, mean=0.0, J=1.0):
    return sw.Oscillator(J, 0.3, law, sw.Harmonic(0.7, mean=mean), 0.4)


def elliptic(alpha, X):
    stretch = 1.0 + alpha * X * X
    return math.pi / 2 * math.sqrt(stretch) / ellipk(alpha * X * X / (2.0 * stretch))


# Free vibration released at X: elliptic integrals (Abramowitz & Stegun, ch. 16 and 17), printed to ten decimals.
@pytest.mark.parametrize(
    ("alpha", "X", "omega"),
    [(0.1, 1.0, 1.0367169071), (1.0, 1.0, 1.3177760650), (1.0, 2.0, 1.9760163641), (10.0, 1.0, 2.8666401366)],
)
def test_backbone_of_the_cubic_spring_is_the_elliptic_integral(alpha, X, omega):
    system = free(sw.Cubic(1.0, alpha))
    a = 0.97 * X
    for _ in range(8):  # the amplitude of the first harmonic that belongs to the peak X
        a *= X / sw.numerics.backbone(system, [a]).peak[0]
    assert sw.numerics.backbone(system, [a]).omega[0] == pytest.approx(omega, abs=0.5e-10)


def test_every_point_of_the_backbone_is_exact_at_its_own_peak():
    curve = sw.numerics.backbone(free(sw.Cubic(1.0, -0.1)), np.linspace(0.1, 2.0, 6))
    assert curve.status
    np.testing.assert_allclose(curve.omega, [elliptic(-0.1, X) for X in curve.peak], rtol=1e-10)


def test_multiple_scales_meets_the_backbone_with_an_error_of_fourth_order():
    system = free(sw.Cubic(1.0, 0.2))
    amplitudes = np.array([0.4, 0.2, 0.1])
    gap = np.abs(
        sw.numerics.backbone(system, amplitudes).omega - sw.slow_flow(system, sw.NONRESONANT).backbone(amplitudes)
    )
    np.testing.assert_allclose(np.log2(gap[:-1] / gap[1:]), 4.0, atol=0.2)


def test_a_mean_torque_moves_the_start_of_the_backbone_to_the_tangent_stiffness():
    law = sw.Cubic(2.0, 0.3)
    curve = sw.numerics.backbone(free(law, mean=1.5, J=0.7), [1e-4])
    u0 = curve.coefficients[0, 0]
    assert law.torque(u0) == pytest.approx(1.5, rel=1e-7)
    assert curve.omega[0] == pytest.approx(math.sqrt(law.stiffness(u0) / 0.7), rel=1e-7)


def test_backbone_of_a_gear_with_play_says_where_nothing_vibrates():
    # free flight through the gap 2 b, then half a period of the spring: T = 2 pi/w0 + 4 b/v, v the speed of entry
    K, b = 1.0, 0.5
    curve = sw.numerics.backbone(free(sw.Backlash(K, b)), [0.3, 1.5])
    assert not curve.status
    assert "0.3" in curve.message
    assert len(curve.omega) == 1
    deflection = curve.peak[0] - b
    period = 2.0 * math.pi + 4.0 * b / deflection
    assert curve.omega[0] == pytest.approx(2.0 * math.pi / period, rel=1e-5)


def test_bad_amplitudes_are_refused():
    for amplitudes in ([0.0], [-1.0], [float("nan")], [[1.0]]):
        with pytest.raises(ValueError, match=r"amplitudes \[rad\] (are|is) .*; (it|they) must be"):
            sw.numerics.backbone(free(sw.Linear(1.0)), amplitudes)


def test_inside_a_gap_nothing_vibrates_whatever_the_order_of_amplitudes():
    # after an amplitude beyond the gap the next inside it was "found", with a frequency near 0
    system = free(sw.Backlash(1e4, 1e-3))
    first, last = (sw.numerics.backbone(system, amplitudes) for amplitudes in ([2e-3, 5e-4, 8e-4], [5e-4, 8e-4, 2e-3]))
    assert first.amplitude.tolist() == last.amplitude.tolist() == [2e-3]
    assert first.omega.tolist() == last.omega.tolist()
    assert first.status == last.status == sw.Status.NO_CONVERGENCE


def separatrix(amplitude):
    """Frequency and peak of x'' + x - x^3 = 0: x = A sn, A^2 = 2m/(1+m), Omega = pi/(2 K sqrt(1+m)).

    Its first harmonic is 2 pi A sqrt(q)/(sqrt(m) K (1 - q)), q the nome (Byrd & Friedman 1971, 908.01).
    """

    def of(exponent):
        d = 10.0**-exponent
        m, K = 1.0 - d, ellipkm1(d)
        q, A = math.exp(-math.pi * ellipk(d) / K), math.sqrt(2.0 * m / (1.0 + m))
        first = 2.0 * math.pi * A * math.sqrt(q) / (math.sqrt(m) * K * (1.0 - q))
        return first, math.pi / (2.0 * K * math.sqrt(1.0 + m)), A

    return of(brentq(lambda u: of(u)[0] - amplitude, 1e-3, 300.0))[1:]


@pytest.mark.parametrize("amplitudes", [(1.15,), (1.05, 1.15, 1.2, 1.25)])
def test_the_backbone_of_a_softening_spring_goes_on_to_its_separatrix(amplitudes):
    system = sw.Oscillator(1.0, 0.0, sw.Cubic(1.0, -1.0), sw.Harmonic(0.0), 1.0)
    found = sw.numerics.backbone(system, amplitudes)
    exact = np.array([separatrix(a) for a in amplitudes]).T
    assert np.array([found.omega, found.peak]) == pytest.approx(exact, rel=1e-8)


def test_an_amplitude_that_is_not_found_is_told_without_a_reason():
    system = sw.Oscillator(1.0, 0.0, sw.Cubic(1.0, -1.0), sw.Harmonic(0.0), 1.0)
    found = sw.numerics.backbone(system, (0.5, 1.3))  # beyond 4/pi there is none
    assert (len(found.omega), found.status) == (1, sw.Status.NO_CONVERGENCE)
    assert found.message.startswith("Newton's method found no free vibration of amplitude(1) 1.3 rad")
