"""Folds of harmonic balance against folds of the shooting problem, solved tightly by other means.

The independent solver is SciPy's DOP853 with the variational equations of the system, written here: at a fold the map
over one period has a fixed point where a Floquet multiplier is 1, so that three equations (the orbit closes, twice;
det(M - I) = 0) determine the start and the frequency. Nothing of them knows Fourier series.
"""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import root

import strainwave as sw


def random_system(seed):
    """Cubic springs, and polynomials with a square term under a mean torque, so that even harmonics matter too."""
    rng = np.random.default_rng(seed)
    if seed % 2:
        law = sw.Polynomial((0.0, 1.0, float(rng.uniform(-0.1, 0.1)), float(rng.uniform(0.05, 0.3))))
    else:
        law = sw.Cubic(1.0, float(rng.uniform(0.02, 0.5)))
    mean = float(rng.uniform(0.05, 0.3)) if seed % 2 else 0.0
    excitation = sw.Harmonic(float(rng.uniform(0.3, 1.0)), mean=mean)
    return sw.Oscillator(1.0, float(rng.uniform(0.02, 0.1)), law, excitation, 1.0)


def polynomial(law):
    """Coefficients of the torque, lowest first."""
    return law.coefficients if isinstance(law, sw.Polynomial) else (0.0, law.K, 0.0, law.K * law.alpha)


def shooting_fold(system, guess):
    """Fold (x, v, omega) of the shooting problem next to a guess, and the largest of its three residuals."""
    c = np.array(polynomial(system.law))
    slope = c[1:] * np.arange(1, len(c))
    force, mean, B = system.excitation.amplitude, system.excitation.mean, system.B

    def residual(unknowns):
        x0, v0, w = unknowns

        def flow(t, y):
            x, v = y[:2]
            stiffness = np.polyval(slope[::-1], x)
            rate = mean + force * np.cos(w * t) - B * v - np.polyval(c[::-1], x)
            return [v, rate, y[3], -stiffness * y[2] - B * y[3], y[5], -stiffness * y[4] - B * y[5]]

        y = solve_ivp(flow, (0.0, 2.0 * np.pi / w), [x0, v0, 1, 0, 0, 1], method="DOP853", rtol=3e-14, atol=1e-15).y
        a, b, p, q, r, s = y[:, -1]
        return [a - x0, b - v0, (p - 1.0) * (s - 1.0) - q * r]

    found = root(residual, guess, tol=1e-14)
    return found.x, float(np.max(np.abs(found.fun)))


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(2))
def test_folds_are_those_of_a_tight_shooting_solution(seed):
    system = random_system(seed)
    curve = sw.frequency_response(system, (0.3, 3.0), harmonics=31)
    assert len(curve.folds) >= 2
    for fold in curve.folds[-2:]:
        exact, residual = shooting_fold(system, [*fold.state(0.0), fold.omega])
        assert residual < 1e-10
        assert fold.omega == pytest.approx(exact[2], rel=1e-11)  # 1e-8 is asked for
