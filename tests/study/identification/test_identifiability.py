"""What data do not tell is named."""

import numpy as np

from strainwave.study.identification.fitted import unidentifiable

RNG = np.random.default_rng(0)


def test_independent_columns_are_all_told():
    assert unidentifiable(RNG.standard_normal((50, 3)), "abc") is None


def test_a_common_factor_is_named():
    J, B, K = 2.0, 0.05, 300.0
    x = RNG.standard_normal((60, 2))
    table = np.column_stack([x, -(J * x[:, 0] + B * x[:, 1]) / K])  # J a + B b + K c = 0 at the true values
    said = unidentifiable(table, ["J", "B", "law.K"], [J, B, K])
    assert said.startswith("the data determine J, B and law.K up to a common factor only")


def test_a_product_of_two_parameters_is_named():
    x = RNG.standard_normal((40, 2))
    table = np.column_stack([3.0 * x[:, 0], x[:, 1], 5.0 * x[:, 0]])  # a b with a = 5, b = 3
    said = unidentifiable(table, ["a", "c", "b"], [5.0, 1.0, 3.0])
    assert said.startswith("the data do not separate a and b: changing a by +1 % and b by -1 % changes nothing")


def test_a_parameter_without_effect_is_named():
    table = np.column_stack([RNG.standard_normal(20), np.zeros(20)])
    assert unidentifiable(table, ["a", "law.alpha"]).startswith("the data do not determine law.alpha: it changes")


def test_of_two_lost_combinations_the_shorter_is_named():
    x = RNG.standard_normal((30, 2))
    table = np.column_stack([x[:, 0], x[:, 0], x[:, 1], 2.0 * x[:, 1] + x[:, 0]])
    assert "a and b: changing a by +1 and b by -1" in unidentifiable(table, "abcd")
