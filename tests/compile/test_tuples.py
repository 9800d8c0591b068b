"""Tuples of numbers: compiled code makes the same ones as Python."""

import pytest

from strainwave.compile.jit import run
from strainwave.compile.tree import alike, axpy, times

pytestmark = pytest.mark.slow


def all_of(y, h, k):
    return axpy(y, h, k), times(h, k), alike(y, h)


@pytest.mark.parametrize("rates", [(4.0, -2.0, 8.0), (4.0, -2, 8), (4, -2, 8)])
def test_compiled_code_makes_the_tuples_of_python(rates):
    """Exact in binary numbers; a law may well return 0 as a rate."""
    y = (1.0, 2.0, 3.0)
    sums, products, copies = run(all_of, y, 0.5, rates)
    assert sums == (3.0, 1.0, 7.0)
    assert products == (2.0, -1.0, 4.0)
    assert copies == (0.5, 0.5, 0.5)
    assert (sums, products, copies) == all_of(y, 0.5, rates)


def test_nothing_makes_nothing():
    assert (times(2.0, ()), alike((), 1.0)) == ((), ())


def test_axpy_works_on_tuples():
    assert axpy((1.0, 2.0), 0.5, (4.0, -2.0)) == (3.0, 1.0)
    with pytest.raises(ValueError, match="zip"):
        axpy((1.0, 2.0, 3.0), 0.5, (4.0, 5.0))
