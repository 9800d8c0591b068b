"""Period maps by Gauss's method against closed forms, SciPy's DOP853."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm

import strainwave as sw
from strainwave.compile.tree import leaf_of
from strainwave.numerics.balance.first_order import first_order
from strainwave.numerics.balance.linear_part import STRENGTH
from strainwave.numerics.balance.rates import rates_at
from strainwave.numerics.continuation.trace import solve
from strainwave.numerics.stability.first_order import period_maps
from strainwave.numerics.stability.gauss_steps import GAUSS_PLACES, gauss_steps

K, ALPHA, J_M, J_1, J_2, N, B, K_C, B_C, K_P, K_I, A = (
    1e5, 5e6, 4.5e-4, 0.1, 1.2, 50.0, 15.0, 4e5, 5.0, 0.5, 20.0, 1e-4,
)  # fmt: skip
OMEGA = 150.0


def train():
    drive = sw.Drive(J_m=J_M, J_l=J_2, N=N, B=B, law=sw.Cubic(K, ALPHA))
    error = sw.KinematicError((sw.Line(2, A),))
    made = drive.train(control=sw.train.SpeedLoop(K_P, K_I), kinematic_error=error, omega=OMEGA)
    return made._replace(load=sw.train.Elastic(J_1, B_C, sw.Linear(K_C), made.load))


def by_hand(t, y):
    """x, x', motor's deviation and its rate, twist of the coupling and its rate: a loop, a coupling, a cubic spring."""
    x, v, d, w, c, r = y
    angle, speed = OMEGA * t + d, OMEGA + w
    slope = -2.0 * A * np.sin(2.0 * angle)
    u = x - A * np.cos(2.0 * angle)
    torque = K * (u + ALPHA * u**3) + B * (v - slope * speed)
    motor = (-K_I * d - K_P * w - (1.0 / N - slope) * torque) / J_M
    passed = K_C * c + B_C * r
    before, behind = (torque - passed) / J_1, passed / J_2
    return v, motor / N - before, w, motor, r, before - behind


def problem_and_point(system, harmonics):
    leaf = leaf_of(system, "omega")
    problem = first_order(system, leaf, leaf, harmonics)
    return problem, solve(problem, problem.linear_response(system.omega))


def test_the_period_map_of_a_train_is_that_of_dop853_on_equations_written_by_hand():
    problem, point = problem_and_point(train(), 31)
    y0 = problem.series(point[None])[0] @ np.r_[1.0, np.ones(31), np.zeros(31)]
    turn = 2.0 * np.pi / OMEGA
    columns = []
    for step in np.diag(1e-4 * problem.sizes):
        ends = [
            solve_ivp(by_hand, (0.0, turn), y0 + s * step, method="DOP853", rtol=1e-12, atol=1e-16).y[:, -1]
            for s in (1.0, -1.0)
        ]
        columns.append((ends[0] - ends[1]) / (2.0 * np.max(step)))
    found = period_maps(problem, point[None])[0][0] * problem.sizes / problem.sizes[:, None]
    expected = np.array(columns).T * problem.sizes / problem.sizes[:, None]
    assert found == pytest.approx(expected, abs=3e-7 * np.max(np.abs(expected)))
    flow, (_, size, decay) = period_maps(problem, point[None], hill=True)
    whole = np.exp(decay + size)[:, None, None] * flow
    assert whole[0] == pytest.approx(period_maps(problem, point[None])[0][0], rel=1e-7, abs=1e-12)


@pytest.mark.parametrize("hill", [False, True])
def test_the_map_of_a_constant_matrix_is_its_exponential(hill):
    a = np.random.default_rng(3).standard_normal((5, 5))
    h = np.full(10, 0.1)
    flow = np.eye(5)
    size, decay = gauss_steps(np.broadcast_to(a, (10, 4, 5, 5)), h, hill, flow)
    assert np.exp(size + decay) * flow == pytest.approx(expm(a), rel=1e-10, abs=1e-10)
    assert decay == pytest.approx(np.trace(a) / 5.0 if hill else 0.0, abs=1e-12)


def test_the_error_of_the_map_falls_with_the_eighth_power_of_the_step():
    # y' = cos(t) S y with S^2 = -1: the map from 0 to t is the rotation by sin(t)
    def error(steps):
        h = 2.0 / steps
        places = h * (np.arange(steps)[:, None] + GAUSS_PLACES)
        turning = np.array([[0.0, 1.0], [-1.0, 0.0]])
        flow = np.eye(2)
        gauss_steps(np.cos(places)[..., None, None] * 4.0 * turning, np.full(steps, h), False, flow)
        angle = 4.0 * np.sin(2.0)
        return np.max(np.abs(flow - [[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]]))

    assert 180.0 < error(4) / error(8) < 360.0


def test_what_varies_with_the_angle_grows_with_the_strength():
    system = train()
    problem, point = problem_and_point(system, 7)
    y, angles = problem.series(point[None])[0] @ problem.synthesis, problem.angles
    at_strength = problem._replace(leaf=STRENGTH)
    whole, half, mean = (at_strength.along(rates_at, value, angles, y) for value in (0.0, np.log(0.5), -700.0))
    itself = np.array(system.rhs(angles, tuple(y)))
    assert whole == pytest.approx(itself, rel=1e-9, abs=1e-9 * np.max(np.abs(itself)))
    assert half == pytest.approx(0.5 * (whole + mean), rel=1e-9, abs=1e-9 * np.max(np.abs(itself)))
    turn = problem.angles_of_mean()
    around = np.array([np.broadcast_to(r, len(turn)) for r in system.rhs(turn, tuple(y[:, 3]))]).mean(axis=-1)
    assert mean[:, 3] == pytest.approx(around, rel=1e-6, abs=1e-6 * np.max(np.abs(itself)))
