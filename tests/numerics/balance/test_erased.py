"""Compiled code of a curve over the frequency: its type is the law's, its numbers are the whole problem's."""

import numpy as np
import pytest

import strainwave as sw
from strainwave.numerics.balance import second_order as balance
from strainwave.numerics.balance.linear_part import quiet
from strainwave.numerics.balance.second_order import second_order
from strainwave.numerics.balance.work import linearised
from strainwave.tree import leaf_of, with_leaf

ONE = sw.Oscillator(1.3, 20.0, sw.Cubic(1e5, 6.9e4), sw.Harmonic(3.0, mean=20.0), 140.0)
TWO = ONE._replace(
    excitation=sw.Harmonics((sw.Harmonic(3.0), sw.Harmonic(2.0, 3, 0.2, 5.0))),
    error=sw.KinematicError((sw.Line(2, 1e-4, 0.3), sw.Line(4, 2e-5))),
)


def problem(system, path="omega"):
    return second_order(system, leaf_of(system, path), leaf_of(system, "omega"), 5)


def classes(model):
    return [type(model), *map(classes, model)] if isinstance(model, tuple) else type(model)


def test_problems_of_one_law_are_of_one_type_whatever_drives_them():
    assert classes(problem(ONE)) != classes(problem(TWO))
    assert classes(quiet(problem(ONE))) == classes(quiet(problem(TWO)))


@pytest.mark.parametrize("system", [ONE, TWO])
def test_a_quiet_problem_has_the_equations_of_the_whole_one(system):
    whole = problem(system)
    small = quiet(whole)
    assert with_leaf(small.system, small.leaf, 7.0).omega == 7.0
    z = np.append(1e-3 * np.random.default_rng(1).normal(size=len(whole.tau)), 150.0)
    found = []
    for one in (whole, small):
        r, jacobian, slope = linearised(one, z)
        found.append(np.concatenate([r, slope, jacobian.ravel()]))
    np.testing.assert_array_equal(*found)


def test_a_curve_over_another_parameter_keeps_its_torque():
    whole = problem(ONE, "excitation.amplitude")
    assert quiet(whole) is whole


def test_a_curve_is_the_same_to_the_last_bit(monkeypatch):
    one = sw.frequency_response(TWO, (200.0, 320.0), harmonics=5)
    monkeypatch.setattr(balance, "quiet", lambda problem: problem)
    two = sw.frequency_response(TWO, (200.0, 320.0), harmonics=5)
    for name in ("omega", "coefficients", "peak", "stable"):
        np.testing.assert_array_equal(getattr(one, name), getattr(two, name))
