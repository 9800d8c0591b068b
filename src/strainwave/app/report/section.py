"""A section of the report: one object with a heading, its data, its sentences, tables and figures.

The functions below are the only place that asks a section for what it may have, and that writes HTML of it.
"""

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from html import escape
from types import MappingProxyType
from typing import Any, NamedTuple

from ...base.facts import NUMBERS, UNITS
from ...base.number_text import percent
from ...base.sentences import Angle, Speed
from ..console import number, plain
from ..view import View

PRODUCT = re.compile(r"(?<=[A-Za-z])\*(?=[A-Za-z])")  # of units, which sentences for the terminal write as N*m
TWINS = ("_arcsec", "motor_speed_rpm", "_rpm")  # ends of keys that say in another unit what another key says
ENDINGS = {
    "_J_per_turn": "J per turn", "_J_per_cycle": "J per cycle", "_per_s": "1/s", "_Nm": "N·m", "_W": "W", "_dB": "dB",
    "hertz": "Hz", **{ending: unit for ending, (unit, _) in UNITS.items()},
}  # fmt: skip
RIGHT = ' class="n"'  # of a number
SHARE = re.compile(r"relative|_ratio|_difference|damping_needed|peak_error|^stiffness$")  # in keys of shares


class Table(NamedTuple):
    """Data as a table: a row for each dictionary of a list, or for each number of one dictionary; or a list of texts.

    `columns` are the keys of the rows that are shown, groups and their keys parted by dots; "" are all. Heads and units
    are those of the keys.
    """

    data: Any
    columns: str = ""
    title: str = ""


class Part(NamedTuple):
    """A part of the report.

    Attributes
    ----------
    heading : str
        Of its part of the page; a part without content is left out with it.
    data : dict
        Its keys of results.json, with units in their names: numbers, texts, lists and dictionaries of them.
    sentences, notes : list of str
        Texts, each a `str` or a `Sentence` with its values in SI; notes are in small print.
    tables : list of Table
        Between sentences and notes.
    figures : list of str or (str, str)
        SVG, and its caption.
    lines : list of str
        Lines of the terminal.
    appendix : bool
        True for a part of the appendix.
    kind : str
        Class of the box around the sentences, or of the row of figures.
    page : str
        HTML in place of all these.
    """

    heading: str = ""
    data: Mapping[str, Any] = MappingProxyType({})
    sentences: Sequence[str] = ()
    tables: Sequence[Table] = ()
    notes: Sequence[str] = ()
    figures: Sequence[Any] = ()
    lines: Sequence[str] = ()
    appendix: bool = False
    kind: str = ""
    page: str = ""

    def html(self, view: View) -> str:
        """Its part of the page, without its heading."""
        sentences = "".join(map(paragraph, self.sentences))
        small = "".join(paragraph(text, "note") for text in self.notes)
        shown = "".join(tabled(view, table) for table in self.tables)
        drawn = "".join(figured(*((one, "") if isinstance(one, str) else one)) for one in self.figures)
        text = sentences + shown + small
        if self.kind and text:
            return f'<div class="{self.kind}">{drawn}{f"<div>{text}</div>" if drawn else text}</div>'
        return self.page or (text + drawn if self.appendix else drawn + text)  # on paper a heading keeps its figure


Section = Callable[[View], Part]  # gives a part of the report


def paragraph(text: str, kind: str = "") -> str:
    """A text of the page."""
    return f"<p{kind and f' class={kind!r}'}>{escape(text)}</p>\n" if text else ""


def figured(svg: str, caption: str = "") -> str:
    """A figure of the page with its caption."""
    return f"<figure>{svg}{caption and f'<figcaption>{escape(caption)}</figcaption>'}</figure>\n"


def html_table(heads: Sequence[str], rows: Iterable[Sequence[Any]]) -> str:
    """A table of texts or numbers as HTML, columns of numbers to the right."""
    body = [[one if isinstance(one, str) else number(one) for one in row] for row in rows]
    right = [all(map(NUMBERS.fullmatch, column)) for column in zip(*body, strict=True)] or [False] * len(heads)
    head = "".join(f"<th{RIGHT * n}>{escape(name)}</th>" for n, name in zip(right, heads, strict=True))
    cells = [
        [f"<td{RIGHT * bool(NUMBERS.fullmatch(one))}{_bar(one)}>{escape(one)}</td>" for one in row] for row in body
    ]
    lines = "".join(f"<tr>{''.join(row)}</tr>\n" for row in cells)
    return f'<div class="scroll"><table><thead><tr>{head}</tr></thead>\n<tbody>{lines}</tbody></table></div>\n'


class Share(str):
    """A share as text, behind which a cell of a table has a bar."""


def _bar(text: Any) -> str:
    width = text.rstrip(" %") if isinstance(text, Share) else ""
    return f' style="background: linear-gradient(90deg, #cfe3f1 {width}%, #fff0 0)"' if width else ""


def tabled(view: View, table: Table) -> str:
    """A table of data as HTML; "" of none."""
    rows, title = table.data, table.title and f"<h3>{escape(table.title)}</h3>\n"
    if not rows:
        return ""
    if isinstance(rows, dict):
        named = list(_flat(plain(rows), ""))
        return title + html_table(("name in results.json", "value"), named) if named else ""
    if isinstance(rows[0], str):
        return f"{title}<ul>{''.join(f'<li>{escape(text)}</li>' for text in rows)}</ul>\n"
    keys = table.columns.split() or [key for key in rows[0] if not key.endswith(TWINS)]
    columns = [[_at(row, key) for row in rows] for key in keys]
    shown = [[cell(view, key, value) for value in column] for key, column in zip(keys, columns, strict=True)]
    return title + html_table([head(view, key) for key in keys], zip(*shown, strict=True))


def head(view: View, key: str) -> str:
    """Head of a column: the name of a key, with the unit of its numbers."""
    ending = next((ending for ending in sorted(ENDINGS, key=len, reverse=True) if key.endswith(ending)), "")
    units = {"_rad": "rad" if "phase" in key else view.angle.name, "_rad_per_s": view.speeds.unit}
    name = key.removesuffix(ending).removesuffix(".omega").replace(".", " ").replace("_", " ").strip()
    name = {"omega": view.speeds.name, "": "frequency"}.get(name, name)
    return f"{name} ({units.get(ending, ENDINGS[ending])})" if ending else name


def cell(view: View, key: str, value: Any) -> str:
    """Value of a key as text in the unit of its head."""
    if isinstance(value, dict):
        return ", ".join(f"{name}: {cell(view, key, one)}" for name, one in value.items())
    if isinstance(value, list):
        return ", ".join(cell(view, key, one) for one in value) or "–"
    if isinstance(value, bool) or not isinstance(value, int | float):
        return number(value)
    if key.endswith("rad_per_s"):
        return view.write(Speed(value, digits=5, bare=True))
    if key.endswith("_rad") and "phase" not in key:
        return view.write(Angle(value, bare=True))
    digits = {"from": 6, "to": view.project.digits()}.get(key, 4)
    if SHARE.search(key):
        return (Share if 0.001 < value <= 1.0 else str)(percent(value, 3))
    return number(value, digits)


def _at(row: Any, path: str) -> Any:
    """Value at a path of keys; that of every row of a list."""
    name, _, below = path.partition(".")
    value = [_at(one, path) for one in row] if isinstance(row, list) else row and row.get(name)
    return value if isinstance(row, list) or not below else _at(value, below)


def _flat(value: Any, name: str) -> Iterator[tuple[str, str]]:
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
        yield from _flat(item, f"{name}.{key}" if name else str(key))


def rendered_part(section: Section, view: View) -> Part:
    """Part of a report, with its data and its texts in the units of the report."""
    part = section(view)
    rendered = {name: view.rendered(getattr(part, name)) for name in ("data", "sentences", "notes", "figures", "lines")}
    for name in ("sentences", "notes"):
        rendered[name] = [PRODUCT.sub("·", text).replace("m^2", "m²") for text in rendered[name]]
    return part._replace(tables=[one._replace(data=view.rendered(one.data)) for one in part.tables], **rendered)
