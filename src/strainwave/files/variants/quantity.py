"""A value of a project file taken apart: its number and its unit."""

from ...units import NUMBER


def quantity(text: str) -> tuple[float | None, str]:
    """Number of a text and the unit after it; None of a word."""
    plain = " ".join(text.split())
    found = NUMBER.match(plain)
    return (float(found.group()), plain[found.end() :].strip()) if found else (None, "")
