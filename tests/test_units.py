"""Text with units: what is read, and what is refused with which help."""

import math
import re
import runpy
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from strainwave.base.units import convert, parse

ARCMIN = math.pi / 10800.0


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("7160 N*m/rad", "N*m/rad", 7160.0),
        ("7.16 kN*m/rad", "N*m/rad", 7160.0),
        ("2*1.5 kg*m^2", "kg*m**2", 3.0),
        ("1/3", "", 1.0 / 3.0),
        ("-1/4 1/rad^2", "1/rad**2", -0.25),
        ("2 * 3/4 s", "s", 1.5),
        ("3 Nm/arcmin", "N*m/rad", 3.0 / ARCMIN),
        ("0.25 kg*cm^2", "kg*m**2", 0.25e-4),
        ("4.5 kg*cm^2", "kg*m**2", 4.5e-4),
        ("60 rpm", "rad/s", 2.0 * math.pi),
        ("1 rev/s", "rad/s", 2.0 * math.pi),
        ("23 arcsec", "rad", 23.0 / 60.0 * ARCMIN),
        ("23″", "rad", 23.0 / 60.0 * ARCMIN),
        ("1′", "rad", ARCMIN),
        ("90°", "rad", math.pi / 2.0),
        ("1.2e-3 rad", "rad", 1.2e-3),
        ("5 µrad", "rad", 5e-6),
        ("-5 mrad", "rad", -5e-3),
        ("−5 mrad", "rad", -5e-3),
        ("0.1 1/rad^2", "1/rad**2", 0.1),
        ("0.1 rad⁻²", "1/rad**2", 0.1),
        ("0.1 1/mrad²", "1/rad**2", 1e5),
        ("20 N*cm", "N*m", 0.2),
        ("1 lbf*in", "N*m", 4.4482216152605 * 0.0254),
        ("1 ozf*in", "N*m", 4.4482216152605 * 0.0254 / 16.0),
        ("1 kgf*m", "N*m", 9.80665),
        ("1 in-lb", "N*m", 4.4482216152605 * 0.0254),
        ("1 ft*lbf", "N*m", 4.4482216152605 * 0.3048),
        ("16 oz-in", "N*m", 4.4482216152605 * 0.0254),
        ("1 in-lb/arcmin", "N*m/rad", 4.4482216152605 * 0.0254 / ARCMIN),
        ("1 lb*in^2", "kg*m**2", 0.45359237 * 0.0254**2),  # a mass where an inertia is wanted
        ("1 lb-in-s2", "kg*m**2", 4.4482216152605 * 0.0254),
        ("4.5 kgcm2", "kg*m**2", 4.5e-4),
        ("4.5 gcm²", "kg*m**2", 4.5e-7),
        ("2 N-m", "N*m", 2.0),
        ('30"', "rad", 0.5 * ARCMIN),
        ("1'", "rad", ARCMIN),
        ("3.1×10⁴ N*m/rad", "N*m/rad", 3.1e4),
        ("3.1x10^4 N*m/rad", "N*m/rad", 3.1e4),
        ("3.1*10**4 N*m/rad", "N*m/rad", 3.1e4),
        ("10⁴ N*m/rad", "N*m/rad", 1e4),
        ("1 N*m/(rad/s)", "N*m*s/rad", 1.0),
        ("1 N m s/rad", "N*m*s/rad", 1.0),
        ("5 N*m/rad^3", "N*m/rad**3", 5.0),
        ("0.02", "", 0.02),
        ("2 %", "", 0.02),
    ],
)
def test_a_quantity_is_read_in_si_and_radians(text, unit, value):
    assert parse(text, unit) == pytest.approx(value, rel=1e-14)


@pytest.mark.parametrize(("text", "unit", "value"), [("4.5 kg*cm^2", "kg*m**2", 4.5e-4), ("5 µrad", "rad", 5e-6)])
def test_a_decimal_prefix_costs_no_digit(text, unit, value):
    assert parse(text, unit) == value


@pytest.mark.parametrize(
    ("text", "unit", "sentence"),
    [
        ("1/0 s", "s", "'1/0 s' does not begin with a finite number; write for example 0.5 ms"),
        ("2*1/s", "1/s", "'2*1/s' is not one number and one unit"),
        ("7160", "N*m/rad", "'7160' has no unit; write for example 7160 N*m/rad or 3 Nm/arcmin"),
        (
            "20 Hz",
            "rad/s",
            "'20 Hz' is a frequency, not an angular speed; write 20 rev/s or 125.7 rad/s, not 20 Hz",
        ),
        (
            "60 1/min",
            "rad/s",
            "'60 1/min' is a frequency, not an angular speed; write 60 rpm or 6.283 rad/s, not 60 1/min",
        ),
        (
            "7160 N*m",
            "N*m/rad",
            "'7160 N*m' is not per radian, so it is not a torsional stiffness; write 7160 N*m/rad if that is meant",
        ),
        ("5 N*m/rad", "N*m", "'5 N*m/rad' is per radian, so it is not a torque"),
        ("5 kg", "kg*m**2", "'5 kg' is not an inertia; write for example 1.3 kg*m^2"),
        ("3 lb", "N*m", "'3 lb' is not a torque"),
        ("3 lb-in", "kg*m**2", "'3 lb-in' is not an inertia"),
        ("1' 30\"", "rad", "is not one number and one unit"),
        ("10^400 rad", "rad", "is too large a number"),
        ("0.02 rad", "", "'0.02 rad' is not a plain number"),
        ("5 N*m", "N*m/rad**3", "write for example 1.5 N*m/rad^3"),
        ("7160,5 N*m/rad", "N*m/rad", "'7160,5 N*m/rad' has a comma; write 7160.5, not 7160,5"),
        ("1,500 rpm", "rad/s", "'1,500 rpm' has a comma; write 1500 or 1.5, as it is meant: 1,500 may be either"),
        ("-12,000 N*m", "N*m", "write -12000 or -12.0, as it is meant: -12,000 may be either"),
        ("0,500 N*m", "N*m", "write 0.500, not 0,500"),
        ("1,25 N*m", "N*m", "write 1.25, not 1,25"),
        ("1.234,5 rpm", "rad/s", "write 1234.5, not 1.234,5"),
        ("1,234.5 rpm", "rad/s", "write 1234.5 without separators, not 1,234.5"),
        ("1 000 rpm", "rad/s", "is not one number and one unit"),
        ("5 Nms/rad", "N*m/rad", "unknown unit 'Nms'"),
        ("5 foo", "rad", "'5 foo' has the unknown unit 'foo'; write for example 23 arcsec"),
        ("5 RAD", "rad", "unknown unit 'RAD'"),
        ("5 N*m/rad s", "N*m*s/rad", "is not one number and one unit"),
        ("9**9**9**9 rad", "rad", "is not one number and one unit"),
        ("5 __import__('os')", "rad", "is not one number and one unit"),
        ("nan rad", "rad", "does not begin with a finite number"),
        (".inf", "rad", "does not begin with a finite number"),
        ("٣ rad", "rad", "does not begin with a finite number"),
        ("", "rad", "does not begin with a finite number"),
        ("1e999 rad", "rad", "'1e999 rad' is too large a number"),
        ("1e308 Nm/arcmin", "N*m/rad", "is too large a number"),
        ("1 rad", "N*m/", "unknown unit 'N*m/'"),
        ("1e-400 rad", "rad", "is too small a number to be told from 0"),
        ("20\n Hz", "rad/s", "not 20 Hz"),
        ("1 rad" + " " * 60, "rad", "has 65 characters; write one number and one unit, at most 60"),
    ],
)
def test_text_that_is_no_such_quantity_is_refused_with_help(text, unit, sentence):
    with pytest.raises(ValueError, match=re.escape(sentence)) as refusal:
        parse(text, unit)
    assert "\n" not in str(refusal.value)


def outcome(text, unit):
    """The number, or the sentence that refuses the text."""
    try:
        return parse(text, unit)
    except ValueError as refusal:
        return str(refusal)


def is_finite_number_or_one_line(result):
    return math.isfinite(result) if isinstance(result, float) else len(result.splitlines()) == 1


@given(st.text(max_size=70), st.sampled_from(["rad", "N*m/rad", "rad/s", "", "kg*m**2", "1/rad**2"]))
def test_any_text_gives_a_finite_number_or_one_sentence(text, unit):
    assert is_finite_number_or_one_line(outcome(text, unit))


@given(st.from_regex(r"[0-9]{1,3} [Nmradsgk*/^()0-9 ]{1,20}", fullmatch=True))
def test_anything_that_looks_like_a_unit_gives_a_finite_number_or_one_sentence(text):
    assert is_finite_number_or_one_line(outcome(text, "N*m/rad"))


@given(st.floats(-1e12, 1e12, allow_subnormal=False))
def test_a_number_written_in_si_comes_back_exactly(value):
    for unit in ("N*m/rad", "kg*m**2", "rad/s", "rad", "N*m", "1/rad**2", "N*m*s/rad", ""):
        assert parse(f"{value!r} {unit}", unit) == value


def test_convert_serves_the_edges():
    assert convert(1e-3, "rad", "arcsec") == pytest.approx(206.26480624709637, rel=1e-14)
    assert convert(math.pi, "rad", "arcmin") == pytest.approx(10800.0, rel=1e-14)
    assert convert(2.0 * math.pi, "rad/s", "rpm") == pytest.approx(60.0, rel=1e-14)
    np.testing.assert_allclose(convert(np.array([0.0, math.pi]), "rad", "deg"), [0.0, 180.0], rtol=1e-14)


@pytest.mark.parametrize(
    ("unit", "to", "sentence"),
    [
        ("rad", "N*m", "cannot convert 'rad' to 'N*m': they measure different things"),
        ("Hz", "rad/s", "cannot convert 'Hz' to 'rad/s'"),
        ("foo", "rad", "unknown unit 'foo'"),
        ("rad", "rad**x", "unknown unit 'rad**x'"),
    ],
)
def test_convert_refuses_what_does_not_match(unit, to, sentence):
    with pytest.raises(ValueError, match=re.escape(sentence)):
        convert(1.0, unit, to)


def test_pint_is_imported_at_the_first_unit_that_is_not_usual():
    code = (
        "import sys; from strainwave.base.quantities import parse; "
        "print(parse('23 arcsec', 'rad'), parse('0.25 kg*cm^2', 'kg*m**2'), 'pint' in sys.modules, "
        "parse('30 in-lb', 'N*m'), 'pint' in sys.modules)"
    )
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    angle, inertia, before, torque, after = run.stdout.split()
    assert (before, after) == ("False", "True")
    given = 23.0 * math.pi / 648_000.0, 2.5e-5, 30.0 * 0.0254 * 4.4482216152605
    assert [float(angle), float(inertia), float(torque)] == pytest.approx(given)


def test_the_table_of_common_units_is_what_pint_computes():
    table = runpy.run_path(str(Path(__file__).resolve().parents[1] / "tools" / "units.py"))
    assert table["TARGET"].read_text(encoding="utf-8").splitlines() == table["rows"]()
