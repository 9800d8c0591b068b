"""The tables of docs/validation.md, from their rows."""

import re
from pathlib import Path

from . import forms, methods, published, records
from .row import markdown

PAGE = Path(__file__).resolve().parents[2] / "docs" / "validation.md"
TABLES = {"published": published.ROWS, "forms": forms.ROWS, "methods": methods.ROWS, "records": records.ROWS}
HEADS = {"published": "published", "forms": "formula", "methods": "the other", "records": "known"}


def table(name: str) -> str:
    """A table, computed."""
    head = f"| case, source, recipe | what | {HEADS[name]} | strainwave | difference |\n|---|---|---|---|---|\n"
    return head + "\n".join(map(markdown, TABLES[name])) + "\n"


def place(name: str) -> re.Pattern[str]:
    """The place of a table on the page; its text is the second group."""
    return re.compile(rf"(<!-- {name} -->\n\n)(.*?)(\n<!-- end -->)", re.DOTALL)


def written(name: str) -> str:
    """A table as it stands on the page."""
    found = place(name).search(PAGE.read_text(encoding="utf-8"))
    assert found is not None
    return found.group(2)


def write() -> None:
    """Compute all tables and put them on the page."""
    text = PAGE.read_text(encoding="utf-8")
    for name in TABLES:
        new = table(name)
        text = place(name).sub(lambda found, new=new: found.group(1) + new + found.group(3), text)
    PAGE.write_text(text, encoding="utf-8")
