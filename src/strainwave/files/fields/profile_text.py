"""Parts of a move as text: fields as in the group `move` of a project file, or the name of a CSV file."""

from typing import Any

from ..yaml_text import name, read
from .csv_files import read_profile
from .kinds import Entry, Kind, Wrong
from .kinds import read as read_value
from .schema import PART


class WrongText(ValueError):
    """Fields that are wrong; the sentence says which."""


def profile_part(text: str, **table: str | None) -> Any:
    """One part of a profile, as "trapezoid, angle: 90 deg, time: 0.6 s" (ValueError); `table` as `read_profile`."""
    if text.lower().endswith(".csv"):
        return read_profile(text, **table)
    return of_fields(text, f"{{type: {text}}}", PART, "profile")


def of_fields(text: str, fields: str, kind: Kind, subject: str) -> Any:
    """Read fields in the form of a project file (WrongText where the text is wrong)."""
    located, errors = read(f"{subject}: {fields}"), list[Wrong]()
    problems = [(problem.field, problem.sentence) for problem in located.problems]
    if not problems and located.content is not None:
        value = read_value(kind, located.content[subject], Entry((), errors))
        if not errors:
            return value
        problems = [(name(wrong.keys), wrong.sentence) for wrong in errors if wrong.sentence]
    reasons = "; ".join(sentence if field == "file" else f"{field}: {sentence}" for field, sentence in problems)
    raise WrongText(f"the {subject} {text!r} is wrong: {reasons}")
