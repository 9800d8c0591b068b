"""Tuples of numbers: compiled code makes the same ones as Python."""

import numpy as np
import pytest

from strainwave.compile.jit import run
from strainwave.compile.tuples import alike, axpy, column, times


def all_of(y, h, k, table):
    return axpy(y, h, k), times(h, k), alike(y, h), column(y, table, 1)


@pytest.mark.parametrize("rates", [(4.0, -2.0, 8.0), (4.0, -2, 8), (4, -2, 8)])
def test_compiled_code_makes_the_tuples_of_python(rates):
    """Exact in binary numbers; a law may well return 0 as a rate."""
    y, table = (1.0, 2.0, 3.0), np.arange(12.0).reshape(4, 3)
    sums, products, copies, numbers = run(all_of, y, 0.5, rates, table)
    assert sums == (3.0, 1.0, 7.0)
    assert products == (2.0, -1.0, 4.0)
    assert copies == (0.5, 0.5, 0.5)
    assert numbers == (1.0, 4.0, 7.0)
    assert (sums, products, copies, numbers) == all_of(y, 0.5, rates, table)


def test_column_is_that_of_any_view_of_a_table():
    y, table = (0.0, 0.0), np.arange(24.0).reshape(4, 6)
    assert run(all_of, y, 1.0, y, table[1::2, ::-2])[3] == (9.0, 21.0)


def test_nothing_makes_nothing():
    assert (times(2.0, ()), alike((), 1.0)) == ((), ())


def test_axpy_works_on_tuples():
    assert axpy((1.0, 2.0), 0.5, (4.0, -2.0)) == (3.0, 1.0)
    with pytest.raises(ValueError, match="zip"):
        axpy((1.0, 2.0, 3.0), 0.5, (4.0, 5.0))
