"""Roots in a bracket: known roots, hard shapes, refusal."""

import math

import pytest

from strainwave.numerics.roots import bracketed_root


@pytest.mark.parametrize(
    ("f", "a", "b", "root"),
    [
        (lambda x: x * x - 2.0, 0.0, 2.0, math.sqrt(2.0)),
        (lambda x: math.cos(x) - x, 0.0, 1.0, 0.7390851332151607),  # Dottie number, OEIS A003957
        (lambda x: (x - 0.3) ** 3, -1.0, 2.0, 0.3),
        (lambda x: math.copysign(1.0, x - 0.7), 0.0, 1.0, 0.7),
        (lambda x: x - 1e-12, -1.0, 1.0, 1e-12),
        (lambda x: x, 0.0, 1.0, 0.0),
        (lambda x: 1.0 - x, 0.0, 1.0, 1.0),
    ],
)
def test_known_roots_from_both_sides(f, a, b, root):
    for low, high in ((a, b), (b, a)):
        assert bracketed_root(f, low, high, xtol=1e-15) == pytest.approx(root, rel=0, abs=3e-15)


def test_smooth_function_takes_few_calls():
    calls = []

    def f(x):
        calls.append(x)
        return math.exp(x) - 5.0

    assert bracketed_root(f, 0.0, 10.0, xtol=1e-14) == pytest.approx(math.log(5.0), abs=1e-14)
    assert len(calls) < 20  # bisection alone needs 50


def test_bracket_without_a_change_of_sign_is_refused():
    with pytest.raises(ValueError, match="one sign at both ends"):
        bracketed_root(lambda x: x * x + 1.0, -1.0, 1.0, xtol=1e-9)
