"""Orbits of laws with memory are refined by shooting: beside them SciPy's integration of the same equations."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import strainwave as sw


@pytest.mark.slow
def test_an_orbit_with_hysteresis_is_that_of_an_integration_that_has_settled():
    # At this speed a step of Newton's method stays above the tolerance of the finest integration.
    J, B, ratio, limit, F, omega = 0.9144449594, 0.04758858562, 0.3326170325, 0.4418159468, 0.3672845472, 1.1
    system = sw.Oscillator(J, B, sw.BoucWen(1.0, ratio, limit), sw.Harmonic(F), omega)

    def rhs(t, y):
        x, v, z = y
        torque = ratio * x + (1.0 - ratio) * z
        slip = abs(z / limit) * (0.5 * abs(v) * np.sign(z) + 0.5 * v)
        return v, (F * np.cos(omega * t) - B * v - torque) / J, v - slip

    turn = 2.0 * np.pi / omega  # a disturbance shrinks to 0.31 in each
    start = solve_ivp(rhs, (0.0, 20.0 * turn), (0.0, 0.0, 0.0), method="DOP853", rtol=1e-10, atol=1e-12).y[:, -1]
    times = np.linspace(0.0, turn, 4001)
    end = solve_ivp(rhs, (0.0, turn), start, t_eval=times, method="DOP853", rtol=1e-10, atol=1e-12, max_step=turn / 400)
    orbit = sw.find_orbit(system)
    assert orbit.status
    assert orbit.peak == pytest.approx(np.max(np.abs(end.y[0])), rel=1e-6)
    assert orbit.state(0.0)[:2] == pytest.approx(end.y[:2, 0], rel=1e-6)


@pytest.mark.compiled
@pytest.mark.parametrize("start", [(-2.0, 0.0), (2.0, 1.0), (0.0, -2.0), (0.5, 2.0)])
def test_shooting_from_far_away_finds_the_motion_on_which_an_integration_settles(start):
    system = sw.Oscillator(1.0, 0.1, sw.Cubic(1.0, 0.1), sw.Harmonic(0.2), 1.1)
    period = 2.0 * np.pi / 1.1

    def rates(t, y):
        return y[1], 0.2 * np.cos(1.1 * t) - 0.1 * y[1] - y[0] - 0.1 * y[0] ** 3

    settled = solve_ivp(rates, (0.0, 100.0 * period), start, rtol=1e-10, atol=1e-12).y[:, -1]
    orbit = sw.numerics.shoot(system, start)
    assert orbit.status
    assert orbit.state(0.0) == pytest.approx(settled, abs=1e-6)
