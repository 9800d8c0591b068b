"""Ends of the motions of a slow flow against integrations of the full equation."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import strainwave as sw
from strainwave.theory.slow_flow.passage.basins import destinations

OMEGA = 1.10
DUFFING = sw.Oscillator(1.0, 0.06, sw.Cubic(1.0, 0.1), sw.Harmonic(0.12), OMEGA)


@pytest.mark.slow
def test_basins_of_both_motions_agree_with_an_ensemble_of_integrations():
    flow = sw.slow_flow(DUFFING, sw.PRIMARY, order=2)
    half = 1.5 * flow.steady_states()[0].amplitude
    z = half * np.array([1.0, 1j]) @ np.random.default_rng(1).uniform(-1.0, 1.0, (2, 60))
    states, ends = destinations(flow._flow, z)
    assert len(states) == 2
    assert np.all(np.bincount(ends) > 6)
    d, n = 1e-5, len(z)
    x = np.array([float(flow.steady_x(one, 0.0)) for one in z])
    turning = np.array([float(flow.steady_x(one, d) - flow.steady_x(one, -d)) / (2.0 * d) for one in z])

    def rhs(t, y):
        x, v = y[:n], y[n:]
        return np.concatenate([v, 0.12 * np.cos(OMEGA * t) - 0.06 * v - x - 0.1 * x**3])

    end = 2.0 * np.pi / OMEGA * 90
    start = np.concatenate([x, turning + flow.rates(z).real])
    y = solve_ivp(rhs, (0.0, end), start, method="DOP853", rtol=1e-6, atol=1e-8).y[:, -1]
    amplitude = np.hypot(y[:n], y[n:] / OMEGA)
    label = np.argmin(np.abs(amplitude[:, None] - np.abs(np.array(states))), axis=1)
    assert np.count_nonzero(label != ends) <= 3  # next to the edge


def test_where_there_is_one_motion_everything_ends_on_it():
    flow = sw.slow_flow(DUFFING._replace(omega=1.3), sw.PRIMARY)
    z = np.multiply.outer([0.1, 0.5, 2.0], np.exp(1j * np.arange(6.0))).ravel()
    states, label = destinations(flow._flow, z)
    assert len(states) == 1
    assert not np.any(label)
