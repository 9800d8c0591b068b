"""Backbone: the elliptic integrals of the cubic spring, multiple scales at small amplitude, laws with play or bias."""

import math

import numpy as np
import pytest
from scipy.special import ellipk

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
