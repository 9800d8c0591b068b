"""Elementary functions on numbers, arrays and symbols, and their compiled versions."""

import math

import mpmath
import numpy as np
import pytest
import sympy

from strainwave import maths

EPS = np.finfo(float).eps
FUNCTIONS = {"cos": math.cos, "sin": math.sin, "exp": math.exp, "sqrt": math.sqrt}


@pytest.mark.parametrize("name", FUNCTIONS)
def test_function_takes_numbers_arrays_and_symbols(name):
    ours, reference = getattr(maths, name), FUNCTIONS[name]
    assert ours(0.7) == ours(np.float64(0.7)) == reference(0.7)
    assert ours(np.array([0.7, 2.0])) == pytest.approx([reference(0.7), reference(2.0)], rel=2 * EPS)
    assert ours(sympy.Symbol("x")) == getattr(sympy, name)(sympy.Symbol("x"))


@pytest.mark.parametrize("x", [-2.5, 0.0, 3, np.float64(-1.0), np.int64(4)])
def test_sign_of_numbers(x):
    assert maths.sign(x) == np.sign(x)


def test_sign_of_arrays_and_symbols():
    assert list(maths.sign(np.array([-2.0, 0.0, 5.0]))) == [-1.0, 0.0, 1.0]
    assert maths.sign(sympy.Symbol("x")) == sympy.sign(sympy.Symbol("x"))


def test_numbers_out_of_range_behave_as_in_compiled_code():
    assert maths.exp(1000.0) == math.inf
    assert math.isnan(maths.sqrt(-1.0))
    assert math.isnan(maths.cos(math.inf))


def ulps(function, points):
    """Largest error of maths.compiled_<function> in units of the last place of the exact value."""
    ours, exact = getattr(maths, f"compiled_{function}"), getattr(mpmath, function)
    with mpmath.workprec(200):
        errors = [(abs(ours(x) - y), math.ulp(float(y))) for x in points for y in [exact(mpmath.mpf(x))]]
        return max(float(error / ulp) for error, ulp in errors)


@pytest.mark.parametrize("largest", [1.0, 100.0, 1e6, 1e9, 3.2e9])
@pytest.mark.parametrize("function", ["cos", "sin"])
def test_compiled_cosine_and_sine_are_right_to_two_units_in_the_last_place(function, largest):
    assert ulps(function, np.random.default_rng(3).uniform(-largest, largest, 2000).tolist()) < 2.0


@pytest.mark.parametrize("function", ["cos", "sin"])
def test_compiled_cosine_and_sine_are_right_next_to_their_zeros(function):
    turns = [*range(-200, 201), *np.random.default_rng(4).integers(1000, 2_100_000_000, 2000).tolist()]
    assert ulps(function, [quarter * math.pi / 2.0 for quarter in turns]) < 2.0


@pytest.mark.parametrize("x", [3.31e9, -1e300, math.inf, -math.inf, math.nan])
def test_compiled_cosine_and_sine_of_a_meaningless_phase_are_nan(x):
    assert math.isnan(maths.compiled_cos(x))
    assert math.isnan(maths.compiled_sin(x))
