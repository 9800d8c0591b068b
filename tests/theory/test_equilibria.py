"""Rests of laws that never fall and of laws with play, against the same laws examined on samples."""

import math

import pytest

import strainwave as sw
from strainwave.base.law import depends
from strainwave.files.fields.rows import law_types, rows_of
from strainwave.theory.equilibria import landscape

SLOPES = sw.PiecewiseLinear(2.0, 3.0, 4.0, 0.5, 1.5)
TABLE = sw.tabulated([(-1.0, -2.0), (0.0, 0.0), (0.4, 0.0), (1.5, 1.0)])
FLAT_END = sw.laws.Tabulated((sw.laws.Knot(-1.0, -2.0, 2.0), sw.laws.Knot(0.0, 0.0, 1.0), sw.laws.Knot(1.0, 0.5, 0.0)))
LAWS = {
    "rounded": sw.laws.RoundedPiecewiseLinear(*SLOPES, 0.1),
    "table": TABLE,
    "table with a flat end": FLAT_END,
    "play": sw.Play(0.3, SLOPES),
    "play and a table": sw.Play(0.3, sw.tabulated([(-1.0, -2.0), (0.0, 0.0), (0.7, 1.0)])),
    "play and a softening spring": sw.Play(0.3, sw.Cubic(1.0, -0.2)),
    "play and a double well": sw.Play(0.3, sw.Cubic(-1.0, -1.0)),
}


@pytest.mark.parametrize("tau_0", [0.0, 0.1, -0.3, 0.45, 2.5])
@pytest.mark.parametrize("name", LAWS)
def test_known_rests_are_those_found_on_samples(name, tau_0):
    law = LAWS[name]
    changed = {"torque": lambda self, x: type(law).torque(self, x)}
    foreign = type("Foreign", (type(law),), changed)(*law)  # a subclass with a torque of its own: only sampled
    known, sampled = landscape(law, tau_0, None), landscape(foreign, tau_0, 6.0)
    assert (known.low, known.high) == (-math.inf, math.inf)
    assert known.signs == sampled.signs
    for (low, high), (first, last) in zip(known.rests, sampled.rests, strict=True):
        assert (low, high) == (pytest.approx(first, abs=1e-3), pytest.approx(last, abs=1e-3))
        middle = 0.5 * (low + high)
        assert law.torque(middle) == pytest.approx(tau_0, abs=1e-12)


def test_a_torque_that_a_flat_end_cannot_carry_has_no_rest():
    assert landscape(FLAT_END, 0.6, None).rests == ()
    assert landscape(FLAT_END, 0.5, None).rests == ((1.0, math.inf),)


def test_every_spring_of_a_project_file_says_where_its_torque_turns():
    silent = {name for name, cls in law_types().items() if depends(cls(*cls._fields)) == 1 and not says(cls)}
    assert silent == {"angle_torque"}  # a torque of a shaft's angle, not of a torsion


def test_every_field_of_a_law_of_a_project_file_has_a_sentence():
    silent = {
        f"{name}.{key}" for name, cls in law_types().items() for key, row in rows_of(cls).items() if not row.description
    }
    assert silent == set()


def says(cls):
    return bool({"polynomial", "turning_points"} & set(vars(cls)))
