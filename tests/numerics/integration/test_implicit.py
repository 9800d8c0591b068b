"""RODAS against closed forms: a state that a fast decay holds on a curve, and the order of its steps."""

from typing import NamedTuple

import numpy as np
import pytest

import strainwave as sw
from strainwave import maths
from strainwave.numerics.integration.implicit import Implicit
from strainwave.numerics.integration.methods import Dopri5, Rodas


class Led(NamedTuple):
    """y' = -rate (y - cos t) - sin t, whose solution from 1 is cos t (Prothero & Robinson 1974)."""

    rate: float

    def rhs(self, phase, y):
        return (-self.rate * (y[0] - maths.cos(phase)) - maths.sin(phase),)


class Pendulum(NamedTuple):
    """x'' = -x^3 - 0.3 x' + cos t."""

    def rhs(self, phase, y):
        return y[1], -(y[0] ** 3) - 0.3 * y[1] + maths.cos(phase)


def test_a_fast_decay_does_not_bound_the_steps():
    run = sw.simulate(Led(1e6), [1.0], 10.0, method=Rodas(rtol=1e-6, atol=1e-8))
    assert run.y[0] == pytest.approx(np.cos(run.t), abs=1e-6)
    assert run.steps < 2000 < 1e6 * 10.0 / 3.3  # steps at which Dopri5 is stable


def test_halved_steps_have_a_sixteenth_of_the_error():
    exact = sw.simulate(Pendulum(), [1.0, 0.0], 1.0, method=Dopri5(rtol=1e-13, atol=1e-14)).y[:, -1]
    errors = []
    for steps in (20, 40):
        h, y, w = 1.0 / steps, np.array([1.0, 0.0]), np.zeros((6, 2))
        for i in range(steps):
            w[0], w[1] = y, Pendulum().rhs(i * h, y)
            Implicit(Pendulum()).attempt(i * h, h, h, 1e-6, 1e-6, w)
            y = w[2].copy()
        errors.append(np.max(np.abs(y - exact)))
    assert errors[0] / errors[1] == pytest.approx(16.0, rel=0.1)


def test_machine_code_and_python_take_the_same_steps(monkeypatch):
    method = Rodas(rtol=1e-6, atol=1e-9)
    compiled = sw.simulate(Pendulum(), [1.0, 0.0], 3.0, method=method)
    monkeypatch.setenv("STRAINWAVE_JIT", "0")
    plain = sw.simulate(Pendulum(), [1.0, 0.0], 3.0, method=method)
    assert plain.steps == compiled.steps > 40
    assert plain.y[:, -1] == pytest.approx(compiled.y[:, -1], rel=1e-9)
