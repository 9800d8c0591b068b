"""Text with units, and conversion at the edges: "7160 N*m/rad" to a float in SI and radians, radians to arcsec.

Our own unit file makes the angle a base dimension. What stock unit libraries let pass (Hz for rad/s, N*m for N*m/rad)
is then a mismatch, refused with help. Text meets a strict grammar first, because it may come from a stranger and pint
evaluates what looks like arithmetic.
"""

import re
import sys
from functools import cache, lru_cache
from math import inf, pi
from pathlib import Path
from typing import Any

from ..compile.tree import shown

RPM, ARCSEC = pi / 30.0, pi / 648_000.0  # one revolution a minute [rad/s], one second of arc [rad]
HERTZ = 2.0 * pi  # rad/s
NUMBER = re.compile(r"[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]{1,3})?")
_FACTOR = r"[A-Za-z]+(?:\^-?1?[0-9])?"
_GROUP = rf"(?:{_FACTOR}|\({_FACTOR}(?:[*/]{_FACTOR})*\)(?:\^-?1?[0-9])?)"
UNIT = re.compile(rf"(?:1?/)?{_GROUP}(?:[*/]{_GROUP})*")
PREFIX = re.compile("^(?:nano|micro|milli|centi|kilo|mega|[numckM])")
LONGEST_TEXT = 60
REMEDY = "units are written like N*m/rad, rpm or arcsec"
# One plain spelling for each sign that people type.
_SPELLING = str.maketrans({"·": "*", "⋅": "*", "×": "*", "−": "-", "µ": "u", "μ": "u", "\u00a0": " ", "\u202f": " "} | {
    "°": "deg", "′": "arcmin", "″": "arcsec", "'": "arcmin", '"': "arcsec", "%": "percent"
} | dict(zip("⁰¹²³⁴⁵⁶⁷⁸⁹⁻", "0123456789-", strict=True)))  # fmt: skip
_TEN = re.compile(r"(?:([0-9.]+) ?[*x] ?)?10(?:\^|\*\*)([+-]?[0-9]+)")  # 3.1*10^4, 10^4
_PRODUCT = re.compile(rf"{NUMBER.pattern}(?: ?[*/] ?{NUMBER.pattern})+(?=[ A-Za-z]|$)")  # 2*1.5, 1/3
_RUN_TOGETHER = re.compile(r"\b(k?g|kgf|lbf?|ozf?)(mm|cm|m|in|ft)(?![a-z])")  # kgcm^2
_HYPHEN = re.compile(r"\b(in|ft|lbf?|ozf?|kgf?|k?N)-(?=[a-z])")  # in-lb
_KIND = {
    "N*m/rad": ("a torsional stiffness", "7160 N*m/rad or 3 Nm/arcmin"),
    "kg*m**2": ("an inertia", "1.3 kg*m^2 or 0.25 kg*cm^2"),
    "rad/s": ("an angular speed", "60 rpm or 6.28 rad/s"),
    "rad": ("an angle", "23 arcsec or 1.2e-3 rad"),
    "N*m": ("a torque", "0.5 N*m or 20 N*cm"),
    "1/rad**2": ("a quantity per square radian", "0.1 1/rad^2"),
    "N*m*s/rad": ("a rotational damping", "0.017 N*m*s/rad"),
    "K": ("a difference of temperature", "20 K"),
    "Hz": ("a frequency", "30 Hz"),
    "s": ("a time", "0.5 ms"),
    "": ("a plain number", "0.02 or 2 %"),
}


def parse(text: str, unit: str) -> float:
    """Read text such as "7160 N*m/rad", "3 Nm/arcmin", "0.25 kg*cm^2", "60 rpm" or "23 arcsec".

    One number with a decimal point, or a product of numbers (1/3, 2*1.5), one unit, at most 60 characters; powers are
    ^2, **2 or ², products *, · or a space; powers of ten are e4, *10^4 or ×10⁴. Pounds and ounces are forces where a
    torque is wanted: 30 in-lb, 5 ft*lb.

    Parameters
    ----------
    text : str
        Number and unit. An angle is a dimension of its own: Hz is no angular speed, N*m no stiffness.
    unit : str
        Unit of the result in the package's spelling, for example "N*m/rad" or "kg*m**2"; "" for a plain number.

    Returns
    -------
    float
        The value in `unit`, finite.

    Raises
    ------
    ValueError
        If the text is no such quantity; one sentence with the fact, the value and the remedy.
    """
    if _unit_text(unit) is None or _unknown(unit):
        raise ValueError(f"unknown unit {shown(unit)}; {REMEDY}")
    if len(text) > LONGEST_TEXT:
        raise ValueError(
            f"{text[:20] + '...'!r} has {len(text)} characters; write one number and one unit, at most {LONGEST_TEXT}"
        )
    plain = _plain(text)
    if re.match(r"[+-]?[0-9.]*,[0-9]", plain):
        raise ValueError(f"{text!r} has a comma; write {_decimal_point(plain)}")
    number = NUMBER.match(plain)
    if number is None:
        raise ValueError(f"{text!r} does not begin with a finite number; write {example(unit)}")
    text_unit = _unit_text(plain[number.end() :])
    if text_unit is None:
        raise ValueError(f"{text!r} is not one number and one unit made of names, *, / and ^; write {example(unit)}")
    if not text_unit and unit:
        raise ValueError(f"{text!r} has no unit; write {example(unit)}")
    text_unit = _with_forces(text_unit, unit)
    try:
        value: float = _scaled(float(number.group()), text_unit, unit)
    except KeyError as unknown:
        raise ValueError(f"{text!r} has the unknown unit {shown(unknown.args[0])}; write {example(unit)}") from None
    except ArithmeticError:
        raise ValueError(_mismatch(text, float(number.group()), text_unit, unit)) from None
    if abs(value) == inf:
        raise ValueError(f"{text!r} is too large a number; write {example(unit)}")
    if value == 0.0 and re.search("[1-9]", re.split("[eE]", number.group())[0]):
        raise ValueError(f"{text!r} is too small a number to be told from 0; write 0 if that is meant")
    return value


def convert(value: object, unit: str, to: str) -> Any:
    """Convert a number or an array from one unit to another, for example `convert(x, "rad", "arcsec")`.

    Raises
    ------
    ValueError
        If a unit is unknown, or the two do not measure the same thing.
    """
    source, target = [_unit_text(text.translate(_SPELLING)) for text in (unit, to)]
    try:
        if source is None or target is None:
            raise KeyError(unit if source is None else to)
        return _scaled(value, source, target)
    except KeyError as unknown:
        raise ValueError(f"unknown unit {shown(unknown.args[0])}; {REMEDY}") from None
    except ArithmeticError:
        raise ValueError(f"cannot convert {shown(unit)} to {shown(to)}: they measure different things") from None


def _decimal_point(plain: str) -> str:
    """Spell out the remedy for a number with commas: 7160.5, not 7160,5."""
    wrong = re.match(r"[+-]?[0-9.,]*[0-9]", plain)
    digits = wrong.group() if wrong else plain
    head, _, tail = digits.rpartition(",")
    if digits.count(",") > 1 or "." in tail:
        return f"{digits.replace(',', '')} without separators, not {digits}"
    if len(tail) == 3 and "." not in head and head.lstrip("+-0"):
        return f"{head}{tail} or {head}.{tail.rstrip('0') or '0'}, as it is meant: {digits} may be either"
    return f"{head.replace('.', '')}.{tail}, not {digits}"


def _plain(text: str) -> str:
    """The text in plain signs, powers of ten as 1e4."""
    raised = re.sub("(⁻?[⁰¹²³⁴⁵⁶⁷⁸⁹]+)", r"^\1", text.replace("''", "″"))
    plain = re.sub(r"\s+", " ", raised.translate(_SPELLING)).strip()
    ten = re.match(rf"([+-]?){_TEN.pattern}", plain)
    plain = plain if ten is None else f"{ten[1]}{ten[2] or 1}e{ten[3]}{plain[ten.end() :]}"
    product = _PRODUCT.match(plain)
    return plain if product is None else f"{_computed(product.group())!r}{plain[product.end() :]}"


def _computed(product: str) -> float:
    """Value of a product of numbers, as 2*1.5 or 1/3; inf of a division by 0."""
    first, *rest = re.split(" ?([*/]) ?", product)
    value = float(first)
    for sign, text in zip(rest[::2], map(float, rest[1::2]), strict=True):
        value = value * text if sign == "*" else value / text if 0.0 < abs(text) < inf else inf
    return value


@lru_cache(maxsize=1024)
def _unit_text(text: str) -> str | None:
    """Return the unit in one plain spelling, or None if it is not a product of powers of names."""
    text = _RUN_TOGETHER.sub(r"\1*\2", _HYPHEN.sub(r"\1*", text))
    text = re.sub(r"([A-Za-z])([23])(?![0-9])", r"\1^\2", text)
    text = re.sub(r" *(\*\*|[*/^()]) *", r"\1", text.strip()).replace("**", "^")
    before, slash, after = text.partition("/")
    # After a slash a space could mean a product above or below the bar: N*m/rad s.
    text = before.replace(" ", "*") + slash + after
    return text if not text or UNIT.fullmatch(text) else None


def _with_forces(given: str, to: str) -> str:
    """Take pounds and ounces for forces where that alone makes the unit what is wanted: in*lb of a torque."""
    forces = re.sub(r"\b(lb|oz)\b", r"\1f", given)
    return forces if forces != given and not _unknown(forces) and _matches(forces, to) else given


@lru_cache(maxsize=1024)
def _unknown(units: str) -> list[str]:
    """Names in units that are none of ours, with a prefix or without."""
    names = re.findall("[A-Za-z]+", units)
    if common()[1].issuperset(names):
        return []
    registered = set(_registry())
    # Left alone, pint takes any final s as a plural: Nms would be N*m.
    return [n for n in names if n not in registered and PREFIX.sub("", n, count=1) not in registered]


@cache
def common() -> tuple[dict[tuple[str, str], tuple[float, float]], frozenset[str]]:
    """Factors of the pairs of units that are usual, and the names in them, from the table that pint made."""
    lines = Path(__file__).with_name("common_units.txt").read_text(encoding="utf-8").splitlines()
    table = {(given, wanted): (float(p), float(q)) for given, wanted, p, q in (line.split("\t") for line in lines)}
    return table, frozenset(re.findall("[A-Za-z]+", " ".join(f"{given} {wanted}" for given, wanted in table)))


@cache
def _registry() -> Any:
    """Our own units; pint's file takes 1 Hz as 1 rad/s and N*m as N*m/rad."""
    # Where they are installed pint imports these, half a second and more, to know their arrays; we give it none.
    hidden = [name for name in ("dask", "scipy", "babel", "uncertainties") if name not in sys.modules]
    sys.modules.update(dict.fromkeys(hidden))  # type: ignore[arg-type]
    import pint

    for name in hidden:
        del sys.modules[name]
    return pint.UnitRegistry(str(Path(__file__).with_name("units.txt")))


def _scaled(value: Any, given: str, to: str) -> Any:
    p, q = _factors(given, to)
    return value * p / q


@lru_cache(maxsize=1024)
def _factors(source: str, target: str) -> tuple[float, float]:
    """Return p and q: a source unit is p/q target units.

    A KeyError names an unknown unit, an ArithmeticError reports a mismatch.
    """
    return common()[0].get((source, target)) or computed_factors(source, target)


def computed_factors(source: str, target: str) -> tuple[float, float]:
    """Return p and q by pint; errors as `_factors`."""
    if unknown := _unknown(f"{source} {target}"):
        raise KeyError(unknown[0])
    if not _matches(source, target):
        raise ArithmeticError
    factor = float(_registry().convert(1.0, _for_pint(source), _for_pint(target)))
    inverse = round(1.0 / factor)
    # 4.5 kg*cm^2 is 4.5/10000, the nearest number to 4.5e-4; 4.5 times 1e-4 is not.
    return (1.0, float(inverse)) if abs(inverse * factor - 1.0) < 1e-14 and inverse > 1 else (factor, 1.0)


def example(unit: str) -> str:
    """Return "for example ..." with one or two spellings of a quantity in the given unit."""
    return f"for example {_KIND[unit][1] if unit in _KIND else '1.5 ' + unit.replace('**', '^')}"


def _mismatch(text: str, number: float, text_unit: str, unit: str) -> str:
    """Sentence for a unit that measures something else, with help where a radian is all that lacks."""
    kind, example = _KIND.get(unit, (f"a quantity in {unit.replace('**', '^')}", f"1.5 {unit.replace('**', '^')}"))
    if unit == "rad/s" and _matches(text_unit, "1/s"):
        per_second = _scaled(number, text_unit, "1/s")
        turns = f"{number:.10g} rpm" if _scaled(1.0, text_unit, "1/min") == 1.0 else f"{per_second:.10g} rev/s"
        radians = f"{2.0 * pi * per_second:.4g} rad/s"
        return (
            f"{text!r} is a frequency, not an angular speed; write {turns} or {radians}, not {' '.join(text.split())}"
        )
    for bar, relation in (("/rad", "is not per radian"), ("/rad^2", "is not per square radian")):
        if unit and _matches(text_unit + bar, unit):
            return f"{text!r} {relation}, so it is not {kind}; write {number:.10g} {text_unit}{bar} if that is meant"
    if _matches(text_unit + "*rad", unit):
        return f"{text!r} is per radian, so it is not {kind}; write for example {example}"
    return f"{text!r} is not {kind}; write for example {example}"


def _matches(text_unit: str, unit: str) -> bool:
    units = [_registry().parse_units(_for_pint(text)) for text in (text_unit, unit)]
    return bool(units[0].dimensionality == units[1].dimensionality)


def _for_pint(unit: str) -> str:
    return re.sub("^/", "1/", unit).replace("^", "**")


def angle_unit(largest: float) -> tuple[str, float]:
    """Name and size [rad] of the unit that suits angles by their largest: arcsec up to a degree, mrad up to 0.1 rad."""
    if largest < 3600.0 * ARCSEC:
        return "arcsec", ARCSEC
    return ("mrad", 1e-3) if largest < 0.1 else ("rad", 1.0)
