"""Folds and crests of a drive train against the shooting problem of its equations by hand.

SciPy's DOP853 integrates the angles of motor and load. The period map is its derivative by complex steps of the start.
At a fold it has the multiplier 1: the orbit closes and det(M - 1) = 0.
"""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import root

import strainwave as sw

pytestmark = pytest.mark.slow

N, J_M, J_L, B, K, ALPHA, K_P, K_D, A, PHASE, MEAN = 100.0, 1e-4, 0.6, 6.0, 5e4, 5e5, 40.0, 0.05, 3e-4, 0.4, -15.0
ERROR = sw.KinematicError((sw.Line(2, A, PHASE),))
LOAD = sw.train.Load(J_L, sw.Harmonic(0.0, mean=MEAN))
TRAIN = sw.DriveTrain(
    sw.train.Motor(J_M, control=sw.train.PositionLoop(K_P, K_D)), N, B, sw.Cubic(K, ALPHA), LOAD, 140.0, ERROR
)


def rates(t, y, omega):
    """Motor's and load's deviations from omega t and omega t/N, and their rates; complex too."""
    theta = omega * t + y[0]
    e, slope = A * np.cos(2.0 * theta + PHASE), -2.0 * A * np.sin(2.0 * theta + PHASE)
    u, du = y[0] / N - y[2] - e, y[1] / N - y[3] - slope * (omega + y[1])
    torque = K * (u + ALPHA * u**3) + B * du
    fast = (-K_P * y[0] - K_D * y[1] - (1.0 / N - slope) * torque) / J_M
    return [y[1], fast, y[3], (torque + MEAN) / J_L]


def turn(start, omega, **options):
    return solve_ivp(
        rates, (0.0, 2.0 * np.pi / omega), start, "DOP853", args=(omega,), rtol=1e-12, atol=1e-14, **options
    )  # fmt: skip


def by_hand(state):
    x, v, angle, speed = state
    return np.array([angle, speed, angle / N - x, speed / N - v])


@pytest.fixture(scope="module")
def curve():
    return sw.frequency_response(TRAIN, (90.0, 200.0))


@pytest.mark.slow
def test_folds_of_a_train_are_those_of_the_shooting_problem(curve):
    def residual(unknowns):
        start, omega = unknowns[:4] * units, unknowns[4] * fold.omega
        ends = [turn(start + 1e-30j * row, omega).y[:, -1] for row in np.eye(4)]
        flow = np.array([end.imag / 1e-30 for end in ends]).T
        return np.append((ends[0].real - start) / units, np.linalg.det(flow - np.eye(4)))

    assert len(curve.folds) == 2
    for fold in curve.folds:
        start = by_hand(fold.state(0.0))
        units = np.abs(start)
        exact = root(residual, np.append(start / units, 1.0), tol=1e-12)
        assert np.max(np.abs(exact.fun)) < 1e-8
        assert fold.omega == pytest.approx(fold.omega * exact.x[4], rel=1e-8)


def test_the_crest_of_a_train_is_no_lower_than_its_orbits_beside_it(curve):
    top = int(np.argmax(curve.peak))
    sizes = []
    for omega in curve.omega[top] * np.array([1.0 - 1e-3, 1.0, 1.0 + 1e-3]):
        guess = sw.find_orbit(TRAIN._replace(omega=float(omega)), guess=near_top(curve, top))
        run = turn(by_hand(guess.state(0.0)), omega, t_eval=np.linspace(0.0, 2.0 * np.pi / omega, 4001))
        sizes.append(np.max(np.abs(run.y[0] / N - run.y[2])))
    low, size, high = sizes
    assert curve.peak[top] == pytest.approx(size, rel=1e-6)
    assert size >= max(low, high)
    # The parabola through them has its vertex in the middle; nearer to it the 4001 samples of a period are too few.
    assert abs(high - low) < 0.01 * (2.0 * size - low - high)


def near_top(curve, top):
    """Table of all states near the crest: the orbit of the fold beside it, at its speed."""
    fold = min(curve.folds, key=lambda orbit: abs(orbit.omega - curve.omega[top]))
    guess = fold.coefficients.copy()
    guess[:, 0] = curve.coefficients[top]
    return guess
