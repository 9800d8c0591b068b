"""The solvers' linear algebra as Python, small and large, against NumPy's own."""

import numpy as np
import pytest

from strainwave.numerics.balance.linear_algebra import LARGE, factor, reduce, substitute


@pytest.mark.parametrize("n", [LARGE // 5, LARGE, LARGE + 1, 2 * LARGE])
@pytest.mark.parametrize("swapped", [False, True])
def test_a_factored_matrix_solves_its_equations_and_tells_the_sign_of_its_determinant(n, swapped):
    rng = np.random.default_rng(n)
    matrix, right = rng.normal(size=(n, n)), rng.normal(size=n)
    if swapped:
        matrix[[0, 1]] = matrix[[1, 0]]
    a, pivots, b = matrix.copy(), np.empty(n, np.int64), right.copy()
    assert factor(a, pivots) == np.linalg.slogdet(matrix)[0]
    substitute(a, pivots, b)
    np.testing.assert_allclose(matrix @ b, right, atol=1e-9 * np.max(np.abs(b)))


@pytest.mark.parametrize("n", [LARGE, LARGE + 1])
def test_a_singular_matrix_leaves_non_finite_numbers(n):
    a, pivots, b = np.diag(np.arange(n, dtype=float)), np.empty(n, np.int64), np.ones(n)
    assert factor(a, pivots) == 0.0
    substitute(a, pivots, b)
    assert not np.all(np.isfinite(b))


@pytest.mark.parametrize("number", [4, 8])
def test_a_part_of_a_matrix_that_is_factored_leaves_its_complement(number):
    matrix = np.random.default_rng(number).normal(size=(11, 11))
    matrix[0, 0] = 0.0
    part, right, below = matrix[:number, :number], matrix[:number, number:], matrix[number:, :number]
    a = matrix.copy()
    assert reduce(a, np.empty(number, np.int64), number) == np.linalg.slogdet(part)[0]
    expected = matrix[number:, number:] - below @ np.linalg.solve(part, right)
    np.testing.assert_allclose(a[number:, number:], expected, atol=1e-12)
