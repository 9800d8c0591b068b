"""Crests of a curve of orbits: the largest |x| and |x - mean| among their neighbours."""

import math

import numpy as np
import pytest

import strainwave as sw
from strainwave.compile.tree import leaf_of
from strainwave.numerics.balance.choice import balance_of
from strainwave.numerics.continuation.trace import solve, with_crests
from strainwave.numerics.labels import STEP, TOP


def test_the_crests_of_x_and_of_its_oscillation_at_one_speed_are_one_point():
    ratio = 0.05  # under a constant torque as well: both crests of a linear drive are at sqrt(1 - 2 ratio^2)
    linear = sw.Oscillator(1.0, 2.0 * ratio, sw.Linear(1.0), sw.Harmonic(0.1, mean=0.3), 1.0)
    leaf = leaf_of(linear, "omega")
    problem = balance_of(linear, leaf, leaf, 3)
    speeds = np.linspace(0.97, 1.03, 8)
    points = np.array([solve(problem, problem.linear_response(w)) for w in speeds])
    found, labels = with_crests(problem, points, np.full(len(points), STEP))
    assert len(found) == len(points) + 1
    assert found[labels == TOP, -1] == pytest.approx([math.sqrt(1.0 - 2.0 * ratio**2)], abs=1e-6)
