"""Basins of the slow flow against integrations of the full equation."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import strainwave as sw

OMEGA = 1.10
DUFFING = sw.Oscillator(1.0, 0.06, sw.Cubic(1.0, 0.1), sw.Harmonic(0.12), OMEGA)


@pytest.mark.slow
def test_basins_of_both_motions_agree_with_an_ensemble_of_integrations():
    flow = sw.slow_flow(DUFFING, sw.PRIMARY, order=2)
    found = flow.basins(points=25)
    assert len(found.states) == 2
    assert found.share.sum() == pytest.approx(1.0)
    assert np.all(found.share > 0.1)
    rows, columns = np.random.default_rng(1).integers(0, 25, (2, 60))
    z = found.re[columns] + 1j * found.im[rows]
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
    label = np.argmin(np.abs(amplitude[:, None] - np.abs(np.array(found.states))), axis=1)
    assert np.count_nonzero(label != found.label[rows, columns]) <= 3  # next to the edge


def test_where_there_is_one_motion_everything_ends_on_it():
    found = sw.slow_flow(DUFFING._replace(omega=1.3), sw.PRIMARY).basins(points=9)
    assert found.share.tolist() == [1.0]
    assert "100 %" in str(found)


@pytest.mark.parametrize(
    ("system", "given", "said"),
    [
        (DUFFING, {"points": 1}, "points is 1; it must be from 2 to 401"),
        (DUFFING, {"points": 402}, "points is 402"),
        (DUFFING, {"size": 0.0}, "size .* must be a positive finite number"),
        (DUFFING._replace(B=0.0), {}, "basins need positive damping"),
    ],
)
def test_basins_that_make_no_sense_are_refused(system, given, said):
    with pytest.raises(ValueError, match=said):
        sw.slow_flow(system, sw.PRIMARY).basins(**given)
