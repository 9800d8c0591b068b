"""Free vibration of the undamped cubic spring, whose frequency is an elliptic integral.

x'' + x + alpha x^3 = 0 released from rest at X: omega = (pi/2) sqrt(1 + alpha X^2)/K(m) with the complete elliptic
integral K(m), m = alpha X^2/(2 (1 + alpha X^2)) (Abramowitz & Stegun, ch. 16 and 17).
"""

import math

import mpmath
import numpy as np
import pytest
from scipy.special import ellipk

import strainwave as sw

# alpha, X, omega [rad/s] to ten decimals
CASES = [(0.1, 1.0, 1.0367169071), (1.0, 1.0, 1.3177760650), (1.0, 2.0, 1.9760163641), (10.0, 1.0, 2.8666401366)]
HALF_DIGIT = 0.5e-10


def exact_frequency(alpha, X, elliptic_integral):
    stretch = 1 + alpha * X * X
    return math.pi / 2 * stretch**0.5 / elliptic_integral(alpha * X * X / (2 * stretch))


@pytest.mark.parametrize(("alpha", "X", "omega"), CASES)
def test_printed_frequencies_are_the_elliptic_integrals(alpha, X, omega):
    assert exact_frequency(alpha, X, ellipk) == pytest.approx(omega, abs=HALF_DIGIT)
    assert float(exact_frequency(mpmath.mpf(alpha), X, mpmath.ellipk)) == pytest.approx(omega, abs=HALF_DIGIT)


@pytest.mark.slow
@pytest.mark.parametrize(("alpha", "X", "omega"), CASES)
def test_integration_gives_the_printed_frequencies(alpha, X, omega):
    system = sw.Oscillator(1.0, 0.0, sw.Cubic(1.0, alpha), sw.Harmonic(0.0), 1.0)
    periods = 10
    t_end = periods * 2.0 * math.pi / omega
    run = sw.simulate(system, (X, 0.0), t_end, method=sw.Dopri5(rtol=1e-13, atol=1e-14))
    # After whole periods the velocity is zero again; x'' there turns what is left of it into time.
    late = run.y[1, -1] / run.rate[1, -1]
    assert periods * 2.0 * math.pi / (t_end - late) == pytest.approx(omega, abs=HALF_DIGIT)
    np.testing.assert_allclose(run.y[0, -1], X, rtol=0, atol=1e-9)
