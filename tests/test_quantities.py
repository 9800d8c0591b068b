"""Parameters by path: what a model lists, and what replacing one of them changes."""

import pytest

import strainwave as sw
from strainwave.base.protocols import with_parts
from strainwave.base.quantities import checked, floated, interval, number, numbers, parameters, positive_count, replace
from strainwave.compile.tree import is_model

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


@pytest.mark.parametrize("value", [float("nan"), float("inf"), 10**400])
def test_what_is_no_finite_number_is_named_with_its_value(value):
    with pytest.raises(ValueError, match=r"^near is .*; it (must be a finite number|is too large)") as error:
        number("near", value)
    assert "\n" not in str(error.value)
    assert len(str(error.value)) < 200


@pytest.mark.parametrize("value", [0.0, -1])
def test_a_positive_number_is_above_zero(value):
    assert number("span", value) == value
    with pytest.raises(ValueError, match=r"span is .*; it must be a positive finite number"):
        number("span", value, positive=True)


@pytest.mark.parametrize("values", [[], [[1.0]], (1.0, float("nan"))])
def test_what_are_no_finite_numbers_is_named(values):
    with pytest.raises(ValueError, match=r"y0 is .*; it must be one or more finite numbers"):
        numbers("y0", values)
    with pytest.raises(ValueError, match=r"y0 is 1.0; it must be 2 finite numbers"):
        numbers("y0", 1.0, count=2)


@pytest.mark.parametrize(
    "span",
    [1, (1, 2, 3), (float("nan"), 1.0), (2.0, 1.0), (0.1, float("inf")), [[1, 2]]],
)
def test_what_is_no_interval_is_named(span):
    with pytest.raises(ValueError, match=r"the range is .*; it must be two finite numbers"):
        interval("the range", span)


def test_an_interval_may_have_to_be_positive():
    assert interval("the range", (0, 2)) == (0.0, 2.0)
    with pytest.raises(ValueError, match=r"the range is 0 \.\. 2; it must be 0 < low < high"):
        interval("the range", (0, 2), positive=True)


@pytest.mark.parametrize("span", [(1e-300, 1.0), (1.0, 1e300), (-1e300, 1e300)])
def test_ends_of_an_interval_are_numbers_whose_powers_a_float_holds(span):
    with pytest.raises(ValueError, match=r"its ends must be from 1e-60 to 1e\+60 in size, or 0"):
        interval("the range", span)


def test_a_number_may_have_the_size_that_a_sentence_names():
    assert [number("x", size) for size in (1e-60, -1e-60, 1e60)] == [1e-60, -1e-60, 1e60]
    assert interval("the range", (1e-60, 1e60)) == (1e-60, 1e60)
    for size in (0.99e-60, 1.01e60):
        with pytest.raises(ValueError, match=r"it must be 0, or from 1e-60 to 1e\+60 in size"):
            number("x", size)


def test_a_count_has_an_upper_end():
    with pytest.raises(ValueError, match=r"points is 10000.* \(401 characters\); it must be at most 1000000000"):
        positive_count("points", 10**400)
    assert positive_count("harmonics", 1000, 1000) == 1000
    with pytest.raises(ValueError, match="harmonics is 1001; it must be at most 1000"):
        positive_count("harmonics", 1001, 1000)


def test_a_long_value_is_cut_in_the_sentence():
    with pytest.raises(ValueError, match=r"\(3002 characters\)") as error:
        replace(SYSTEM, {"x" * 3000: 1.0})
    assert len(str(error.value)) < 300


def test_a_parameter_whose_powers_no_float_holds_is_refused():
    for law in (sw.Cubic(1e70, 0.1), sw.Polynomial((0.0, 1.0, -1e300))):
        with pytest.raises(ValueError, match=r"must not exceed 1e\+60 in SI units"):
            checked(SYSTEM._replace(law=law))
    assert checked(SYSTEM._replace(B=2e-60)).B == 2e-60
    with pytest.raises(ValueError, match=r"Oscillator\.B is 1e-300; it must be 0, or from 1e-60 in size, in SI units"):
        checked(SYSTEM._replace(B=1e-300))


def test_a_verb_says_what_a_system_lacks():
    with pytest.raises(TypeError, match="find_orbit takes a system such as an Oscillator; Cubic has no rhs"):
        sw.find_orbit(sw.Cubic(1.0, 0.1))
    with pytest.raises(TypeError, match=r"Drive has no omega; drive\.error_equation\(\) gives one"):
        with_parts("isolas", sw.HDC_40_050, "law", "omega")
