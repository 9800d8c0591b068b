"""Elementary functions on numbers, arrays and symbols, and their compiled versions."""

import math

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


@pytest.mark.parametrize("largest", [1.0, 100.0, 1e6])
def test_compiled_cosine_and_sine_are_right_to_the_last_digits(largest):
    x = np.random.default_rng(3).uniform(-largest, largest, 4000)
    exact = x.astype(np.longdouble)
    cosine, sine = (np.array([f(float(v)) for v in x]) for f in (maths.compiled_cos, maths.compiled_sin))
    assert np.max(np.abs(cosine - np.cos(exact))) < EPS
    assert np.max(np.abs(sine - np.sin(exact))) < EPS


def test_compiled_cosine_and_sine_at_special_places():
    assert (maths.compiled_cos(0.0), maths.compiled_sin(0.0)) == (1.0, 0.0)
    for quarter in range(-8, 9):
        x = quarter * math.pi / 2.0
        assert maths.compiled_cos(x) == pytest.approx(math.cos(x), rel=1e-14, abs=1e-30)
        assert maths.compiled_sin(x) == pytest.approx(math.sin(x), rel=1e-14, abs=1e-30)
    assert maths.compiled_cos(1e9) == math.cos(1e9)
    assert maths.compiled_sin(1e9) == math.sin(1e9)
