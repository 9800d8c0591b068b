"""A section of the report: one object with a heading, its data, its sentences and its figures.

The functions below are the only place that asks a section for what it may have.
"""

import re
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple, Protocol

from ..console import number, plain
from ..view import View

PRODUCT = re.compile(r"(?<=[A-Za-z])\*(?=[A-Za-z])")  # of units, which sentences for the terminal write as N*m

DEFAULT = Path(__file__).with_name("section.html.j2")


class Section(Protocol):
    """A part of the report; no class needs to inherit from it.

    With `appendix = True` it stands in the appendix. It may have `sentences(view)`: texts, each a `str` or a `Sentence`
    with its values in SI; `figures(view)`: texts of SVG; `lines(view, data)`: what the terminal says, otherwise its
    sentences. Its part of the page is a Jinja file that stands beside that of its class, with the same name and the
    ending ".html.j2", or that of its `template`; otherwise its sentences, a table of its data, and its figures.
    """

    @property
    def heading(self) -> str:
        """Heading of its part of the page; a part without content is left out with it."""

    def data(self, view: View) -> dict[str, Any]:
        """Its keys of results.json, with units in their names: numbers, texts, lists and dictionaries of them."""


class Part(NamedTuple):
    """A section with its data and its texts in the units of the report."""

    section: Section
    view: View
    data: dict[str, Any]
    sentences: list[str]
    figures: list[str]

    @property
    def template(self) -> Path:
        """The file of its part of the page."""
        home = getattr(sys.modules.get(type(self.section).__module__), "__file__", None)
        beside = Path(home or DEFAULT)
        own = beside.with_name(getattr(self.section, "template", "") or f"{beside.stem}.html.j2")
        return own if own.exists() else DEFAULT

    @property
    def rows(self) -> list[tuple[str, str]]:
        """Name and value of all its data, for a table."""
        return list(_rows(plain(self.data), ""))

    @property
    def lines(self) -> list[str]:
        """Lines for the terminal."""
        if hasattr(self.section, "lines"):
            return list(self.view.told(self.section.lines(self.view, self.data)))
        return self.sentences


def _rows(value: Any, name: str) -> Iterator[tuple[str, str]]:
    items: list[tuple[Any, Any]] = []
    if isinstance(value, dict):
        items = list(value.items())
    elif isinstance(value, list) and any(isinstance(item, dict | list) for item in value):
        items = list(enumerate(value, 1))
    elif isinstance(value, list):
        yield name, ", ".join(number(item, 5) for item in value)
    else:
        yield name, number(value, 5)
    for key, item in items:
        yield from _rows(item, f"{name}.{key}" if name else str(key))


def asked(section: Section, view: View) -> Part:
    """Part of a report with the data, sentences and figures of a section."""
    sentences, figures = _texts(section, "sentences", view), _texts(section, "figures", view)
    sentences = [PRODUCT.sub("·", text).replace("m^2", "m²") for text in sentences]
    return Part(section, view, view.told(section.data(view)), sentences, figures)


def _texts(section: Section, method: str, view: View) -> list[str]:
    """Texts of an optional method of a section; empty without that method."""
    texts: list[str] = view.told(list(getattr(section, method)(view)) if hasattr(section, method) else [])
    return texts
