"""The formulas of the second order are those that SymPy derives."""

from fractions import Fraction

import numpy as np
import pytest
from second_order_form import second_order_form

from strainwave.theory.slow_flow.second_order_forms import FORMS

C2, C3, K, MU, W, V = 0.7, -1.3, 2.1, 0.23, 1.7, 0.41
Z, C = 0.31 - 0.42j, -0.27 + 0.19j


@pytest.mark.parametrize("ratio", list(FORMS))
def test_the_written_formula_is_the_derived_one(ratio: Fraction | None) -> None:
    form, derived = FORMS[ratio], second_order_form(ratio)
    c = 0j if ratio == 1 else C
    at = dict(zip(derived.symbols, (C2, C3, Z, Z.conjugate(), c, c.conjugate()), strict=True))
    small, on_fast, back = form.values(C2, C3, K, MU, W, V, Z, c)

    assert set(form.numbers) == set(derived.others)
    line = (0, 1) if ratio is None else (ratio.denominator, 0)
    for (m, n), value in zip(form.numbers, small, strict=True):
        speed = m * W + n * V
        force = complex(derived.others[m, n].subs(at)) + (1j * MU * speed * c if (m, n) == line else 0.0)
        assert value == pytest.approx(-force / (K - speed**2 + 1j * MU * speed), rel=1e-12)
        at |= dict(zip(derived.small[m, n], (value, np.conj(value)), strict=True))
    assert on_fast == pytest.approx(complex(derived.on_fast.subs(at)), rel=1e-12)
    assert back == pytest.approx(complex(derived.back.subs(at)), rel=1e-12)
