"""The closed form of Bouc-Wen between reversals, against SciPy, and its derivatives against differences."""

import numpy as np
import pytest
from loop_machines import loop
from scipy.integrate import solve_ivp

from strainwave.study.identification.loops.loop_model import Shape, state_after, torque
from strainwave.study.identification.loops.loop_path import read_loop


@pytest.mark.parametrize("n", [1, 2])
@pytest.mark.parametrize("kappa", [0.0, 0.4, 1.0, 3.0])
@pytest.mark.parametrize("a", [-0.95, -0.3, 0.0, 0.6])
def test_the_state_follows_its_equation(n, kappa, a):
    def rate(_, z):
        return 1.0 - np.abs(z) ** n * np.where(z > 0.0, 1.0, -kappa)

    way = np.linspace(0.0, 3.0, 7)
    found = solve_ivp(rate, (0.0, 3.0), [a], t_eval=way, rtol=1e-11, atol=1e-13, max_step=0.01).y[0]
    assert state_after(np.full(7, a), way, n, kappa) == pytest.approx(found, abs=1e-7)
    assert [float(state_after(a, s, n, kappa)) for s in way.tolist()] == pytest.approx(found.tolist(), abs=1e-7)


@pytest.mark.parametrize(
    "shape", [Shape(3, True, 1, True), Shape(3, False, 2, True), Shape(2, True, 2, False), Shape(1, False, 1, False)]
)
def test_derivatives_are_those_of_the_torque(shape):
    read = read_loop(*loop(samples=200))
    size = {"K1": 3e4, "K2": 5e4, "K3": 6e4, "x1": 4.57e-4, "x2": 1.131e-3, "half_gap": 1.03e-4, "K": 4e4}
    size |= {"yield_twist": 8e-5, "kappa": 0.6, "start 1": 0.2, "torsion_offset": 1.1e-5, "torque_offset": 0.4}
    p = np.array([size[name] for name in shape.names()])
    found = torque(shape, p, read.path, read.torsion)
    for i, name in enumerate(shape.names()):
        h = 1e-6 * p[i] * (np.arange(len(p)) == i)
        low, high = (torque(shape, q, read.path, read.torsion).value for q in (p - h, p + h))
        column = (high - low) / (2e-6 * p[i])
        close = np.abs(found.jacobian[:, i] - column) < 1e-4 * np.max(np.abs(column))
        assert np.mean(close) > 0.97, name  # a sample may lie on a corner
    h = 1e-10
    slope = (torque(shape, p, read.path, read.torsion + h).value - found.value) / h
    inside = np.abs(slope - found.slope) < 1e-3 * np.max(slope)
    assert np.mean(inside) > 0.95  # but at reversals and corners
