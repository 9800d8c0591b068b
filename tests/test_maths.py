"""Elementary functions on numbers, arrays and symbols, and their compiled versions.

Exact values are those of mpmath at 140 bits.
"""

import math

import mpmath
import numpy as np
import pytest
import sympy

from strainwave import maths
from strainwave.compile import jit, maths_kernels

EPS = np.finfo(float).eps
FUNCTIONS = {name: getattr(math, name) for name in ("cos", "sin", "exp", "log", "tanh", "sqrt")}


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
    assert maths.log(0.0) == -math.inf
    assert maths.power(-10.0, 309) == -math.inf
    assert math.isnan(maths.cos(math.inf))


# Largest errors in units of the last place of the exact value; a million random points gave 2.3, 0.97, 0.81, 2.4, 0.97.
BOUNDS = {"cos": 2.5, "sin": 2.5, "exp": 1.1, "log": 1.0, "tanh": 2.6, "power": 1.1}


def uniform(seed, low, high, number=1000):
    return np.random.default_rng(seed).uniform(low, high, number)


def points(name):
    """Return ten thousand arguments (pairs for `power`), with those where an approximation is likely to fail."""
    if name in ("cos", "sin"):
        turns = np.concatenate([np.arange(-1500, 1501), np.random.default_rng(4).integers(1500, 2_100_000_000, 3000)])
        return np.concatenate([turns * (math.pi / 2.0), *(uniform(1, -m, m) for m in (1.0, 100.0, 1e6, 1e9, 3.2e9))])
    if name == "exp":
        edges = ((-1.0, 1.0), (-50.0, 50.0), (-1e-9, 1e-9), (709.0, 709.78), (-745.1, -708.0), (-0.36, -0.33))
        return np.concatenate([uniform(1, -708.0, 709.0, 4000), *(uniform(2, *edge) for edge in edges)])
    if name == "log":
        near = ((0.5, 2.0), (0.99, 1.01), (1.0 - 1e-7, 1.0 + 1e-7), (0.7, 0.715), (1.4, 1.42))
        subnormal = 10.0 ** uniform(3, -323.0, -307.0)
        return np.concatenate([10.0 ** uniform(1, -307.0, 308.0, 4000), subnormal, *(uniform(2, *e) for e in near)])
    if name == "tanh":
        tiny = 10.0 ** uniform(3, -322.0, -2.0)
        return np.concatenate([uniform(1, -1.0, 1.0, 4000), uniform(2, -25.0, 25.0, 2000), uniform(2, 0.1, 0.3), tiny])
    low = ((0.0, 10.0), (0.5, 2.0), (0.9, 1.1), (0.7, 0.715), (1.4, 1.42), (0.0, 1e-300), (1e300, 1.7e308))
    high = ((-3.0, 3.0), (-700.0, 700.0), (-7e3, 7e3), (-2e3, 2e3), (-2e3, 2e3), (0.0, 1.05), (-1.03, 1.0))
    pairs = [np.stack([uniform(1, *x), uniform(2, *y)], axis=-1) for x, y in zip(low, high, strict=True)]
    return np.concatenate([*pairs, np.stack([uniform(3, 0.0, 5.0, 3000), uniform(4, 0.0, 4.0, 3000)], axis=-1)])


def ulps(name, arguments, values):
    """Return the largest error of the values in units of the last place of the exact value."""
    exact = getattr(mpmath, name)
    worst = 0.0
    with mpmath.workprec(140):
        for argument, value in zip(arguments.tolist(), values, strict=True):
            wanted = exact(*map(mpmath.mpf, argument)) if name == "power" else exact(mpmath.mpf(argument))
            worst = max(worst, float(abs(value - wanted) / math.ulp(float(wanted))))
    return worst


@pytest.mark.parametrize("name", BOUNDS)
def test_compiled_function_is_right_to_the_last_places_as_python(name):
    function, arguments = getattr(maths_kernels, name), points(name)[::5]
    values = [function(*a) if name == "power" else function(a) for a in arguments.tolist()]
    assert ulps(name, arguments, values) < BOUNDS[name]


@pytest.mark.parametrize("name", ["cos", "sin"])
def test_compiled_cosine_and_sine_are_right_to_the_last_place_of_one(name):
    with mpmath.workprec(140):
        for x in points(name)[::5].tolist():
            assert abs(getattr(maths_kernels, name)(x) - getattr(mpmath, name)(x)) < EPS


def each_function(a, b, out):
    for i in range(out.shape[1]):
        out[0, i] = maths.cos(a[0, i])
        out[1, i] = maths.sin(a[1, i])
        out[2, i] = maths.exp(a[2, i])
        out[3, i] = maths.log(a[3, i])
        out[4, i] = maths.tanh(a[4, i])
        out[5, i] = maths.power(a[5, i], b[i])


@pytest.mark.slow
def test_compiled_functions_are_right_to_the_last_places():
    number = 8000
    arguments = [points(name)[::-1][:number] for name in BOUNDS]
    a, b = np.stack([*arguments[:5], arguments[5][:, 0]]), np.ascontiguousarray(arguments[5][:, 1])
    out = np.empty_like(a)
    jit.run(each_function, a, b, out)
    errors = {n: ulps(n, x, v.tolist()) for n, x, v in zip(BOUNDS, arguments, out, strict=True)}
    assert {n: e for n, e in errors.items() if not e < BOUNDS[n]} == {}


SPECIAL = [0.0, 1.0, -1.0, 0.5, -0.5, 2.0, -2.5, 3.0, -3.0, 1e3, -1e3, 5e-324, 1e308, -1e308, 2.0**52 + 1.0, 2.0**53]
SPECIAL += [math.inf, -math.inf, math.nan]


@pytest.mark.parametrize("name", ["exp", "log", "tanh", "sqrt", "sign"])
def test_python_and_compiled_function_agree_with_numpy_at_special_values(name):
    with np.errstate(all="ignore"):
        for x in SPECIAL:
            wanted = getattr(np, name)(x) if not (name == "sign" and math.isnan(x)) else 0.0
            assert getattr(maths, name)(x) == pytest.approx(wanted, rel=2 * EPS, abs=0.0, nan_ok=True)
            if name != "sqrt" or x >= 0.0:  # as Python, the square root of libm raises
                assert getattr(maths_kernels, name)(x) == pytest.approx(wanted, rel=2 * EPS, abs=0.0, nan_ok=True)


@pytest.mark.parametrize("x", SPECIAL)
def test_power_agrees_with_numpy_at_special_values(x):
    with np.errstate(all="ignore"):
        for y in SPECIAL:
            wanted = np.float64(x) ** np.float64(y)
            if (abs(x) == 1.0 and math.isinf(y)) or (x == -math.inf and y % 1.0 != 0.0):
                continue  # limits that the C standard defines and no law takes
            for function in (maths.power, maths_kernels.power):
                assert function(x, y) == pytest.approx(wanted, rel=2 * EPS, abs=0.0, nan_ok=True), y


def test_power_takes_arrays_and_symbols():
    x, y = sympy.symbols("x y")
    assert list(maths.power(np.array([2.0, 3.0]), 2.0)) == [4.0, 9.0]
    assert list(maths.power(2.0, np.array([2.0, 3.0]))) == [4.0, 8.0]
    assert maths.power(x, y) == x**y


@pytest.mark.parametrize("x", [3.31e9, -1e300, math.inf, -math.inf, math.nan])
def test_compiled_cosine_and_sine_of_a_meaningless_phase_are_nan(x):
    assert math.isnan(maths_kernels.cos(x))
    assert math.isnan(maths_kernels.sin(x))


@pytest.mark.parametrize(
    ("a", "b", "c"), [(0.1, 10.0, -1.0), (1e308, 10.0, 0.0), (math.nan, 1.0, 1.0), (2.0, 3.0, 4.0)]
)
def test_fused_multiply_add_of_python_rounds_once(a, b, c):
    with mpmath.workprec(300):
        exact = mpmath.mpf(a) * b + c
    assert maths_kernels.fma(a, b, c) == pytest.approx(float(exact), rel=0.0, abs=0.0, nan_ok=True)
