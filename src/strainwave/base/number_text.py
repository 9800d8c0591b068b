"""Text of numbers and units, as people read them: 1234, 1.2×10⁷, 3.4 %, 2 samples, kg·m²."""

import math

RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def rounded(value: float, digits: int, side: int) -> float:
    """The value itself, or rounded down (-1) or up (1) to so many significant digits, and never coarser than to 1."""
    if not side or not value or not math.isfinite(value):
        return value
    step = 10.0 ** min(0, math.floor(math.log10(abs(value))) + 1 - digits)
    steps = value / step
    count = round(steps) if abs(steps - round(steps)) < 1e-6 else math.floor(steps) if side < 0 else math.ceil(steps)
    return float(f"{count * step:.12g}")


def number(value: float | str | bool | None, digits: int = 4) -> str:
    """Write a number with at least so many significant digits, from 10 million on by powers of ten; None is a dash."""
    if value is None:
        return "–"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, str):
        return value
    if not math.isfinite(value):
        return "–"
    rounded = float(f"{value:.{digits}g}") + 0.0  # 99.99 may become 100, and -0.0 is 0.0
    text = f"{value:.0f}" if 10.0**digits <= abs(rounded) < 1e7 else f"{rounded:.{digits}g}"
    mantissa, mark, exponent = text.partition("e")
    if not mark:
        return text.replace("-", "−")
    return mantissa.replace("-", "−") + "×10" + str(int(exponent)).translate(RAISED)


def percent(share: float, digits: int = 4) -> str:
    """Write a share in percent, with its unit."""
    return f"{number(100.0 * share, digits)} %"


def counted(count: int, noun: str) -> str:
    """A number of things: "1 sample", "2 samples"."""
    return f"{count} {noun}{'' if count == 1 else 's'}"


def unit_text(unit: str) -> str:
    """A unit such as "kg*m**2" as it is printed: "kg·m²"."""
    return unit.replace("**2", "²").replace("**3", "³").replace("*", "·")
