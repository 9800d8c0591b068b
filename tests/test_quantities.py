"""Parameters by path: what a model lists, and what replacing one of them changes."""

import pytest

import strainwave as sw
from strainwave.quantities import floated, is_model, parameters, replace

SYSTEM = sw.Oscillator(
    J=1.0,
    B=0.1,
    law=sw.Cubic(K=2.0, alpha=0.5),
    excitation=sw.Harmonic(3.0, order=2),
    omega=4.0,
    error=sw.KinematicError((sw.Line(2, 1e-4), sw.Line(4, 2e-5, 0.3))),
)


def test_parameters_lists_every_number_with_its_path_and_unit():
    found = {p.path: (p.value, p.unit) for p in parameters(SYSTEM)}
    assert found["J"] == (1.0, "kg*m**2")
    assert found["law.alpha"] == (0.5, "1/rad**2")
    assert found["excitation.order"] == (2, "")
    assert found["error.lines.1.phase"] == (0.3, "rad")
    assert len(found) == 3 + 2 + 4 + 6


def test_replace_changes_one_number_and_nothing_else():
    changed = replace(SYSTEM, {"law.alpha": 2.0, "error.lines.0.amplitude": 5e-4})
    before, after = ({p.path: p.value for p in parameters(s)} for s in (SYSTEM, changed))
    assert {path: after[path] for path in after if after[path] != before[path]} == {
        "law.alpha": 2.0,
        "error.lines.0.amplitude": 5e-4,
    }
    assert SYSTEM.law.alpha == 0.5
    assert type(changed.law) is sw.Cubic


@pytest.mark.parametrize("path", [p.path for p in parameters(SYSTEM)])
def test_every_listed_path_can_be_replaced(path):
    assert {p.path: p.value for p in parameters(replace(SYSTEM, {path: 7}))}[path] == 7


@pytest.mark.parametrize(
    ("path", "sentence"),
    [
        ("law.k9", "Cubic has no parameter 'k9' .*; it has K, alpha"),
        ("mass", "Oscillator has no parameter 'mass'"),
        ("error.lines.2.amplitude", "no parameter '2'"),
        ("J.x", "'J' in 'J.x' is a number"),
    ],
)
def test_replace_says_which_parameters_there_are(path, sentence):
    with pytest.raises(ValueError, match=sentence):
        replace(SYSTEM, {path: 1.0})


def test_floated_turns_ints_to_floats_in_float_fields_and_leaves_orders_alone():
    model = floated(sw.Oscillator(1, 0, sw.Cubic(1, 2), sw.Harmonic(1, 3), 5))
    assert [type(v) for v in (model.J, model.B, model.law.K, model.excitation.amplitude, model.omega)] == [float] * 5
    assert model.excitation.order == 3
    assert type(model.excitation.order) is int


def test_floated_refuses_text():
    with pytest.raises(TypeError, match="K must be a number"):
        floated(sw.Linear("stiff"))


def test_a_plain_tuple_is_no_model():
    assert is_model(SYSTEM)
    assert not is_model((1.0, 2.0))
