"""A result as HTML: its text, its figure as SVG, and a table of its arrays; a drive as a table of its numbers.

Everything is in the text: no style sheet, no script, no file. Text has the notebook's own colour; the figure has a
white ground, and so looks the same in light and in dark notebooks.
"""

from collections.abc import Sequence
from html import escape
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..base.number_text import unit_text
from ..base.quantities import parameters
from ..base.units import ARCSEC
from ..model.gears.gear import NUMBERS
from ..plot.svg import stacked
from .console import number

CELL = "text-align:left;vertical-align:top;padding:1px 10px 1px 0"
CARD_WIDTH, TALL, LOW = 620.0, 270.0, 190.0  # of the figure, of a panel on its own, and of one of several [px]
CARD = f"background:#ffffff;max-width:{CARD_WIDTH:.0f}px;border-radius:4px;margin:4px 0"


def html(result: object) -> str:
    """HTML of a result for a notebook.

    Parameters
    ----------
    result : Result
        Its lines are those of `str`; its figure is that of `plot`, if it has one.

    Returns
    -------
    str
        A div with `str(result)`, the figure if there is one, and a table of the arrays.
    """
    drawn = figure(result)
    card = f'<div style="{CARD}">{drawn}</div>' if drawn else ""
    return f"<div><pre>{escape(str(result))}</pre>{card}{_arrays(result)}</div>"


def figure(result: Any) -> str:
    """The figure of a result as SVG; "" where it has none."""
    panels = result.panels()
    return stacked(panels, TALL if len(panels) < 2 else LOW, f"figure of {str(result).splitlines()[0]}", CARD_WIDTH)


def card(subject: Any) -> str:
    """HTML of a project, a gear or a model for a notebook: its name, and a table of its numbers.

    Numbers of a project are those of its file, with the source of each; angles of others are in arcsec.
    """
    if sources := getattr(subject, "sources", ()):
        given = [(one.name, unit_text(one.value.replace("^", "**")), one.word) for one in sources]
        return _card(str(subject), ("number", "value", "source"), given)
    units = NUMBERS if hasattr(subject, "series") else {}
    numbers = [(name, getattr(subject, name), unit) for name, unit in units.items()] or parameters(subject)
    rows = [(name, *_shown(name, value, unit)) for name, value, unit in numbers if value is not None]
    return _card(f"{type(subject).__name__} {getattr(subject, 'name', '')}".strip(), ("number", "value", "unit"), rows)


def _card(title: str, heads: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    return f"<div><pre>{escape(title)}</pre>{_table(heads, rows)}</div>"


def _shown(name: str, value: float, unit: str) -> tuple[str, str]:
    angle = unit == "rad" and "phase" not in name
    return (number(value / ARCSEC), "arcsec") if angle else (number(value), unit_text(unit))


def _table(heads: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Table whose rows are named by their first texts."""
    head = "".join(f'<th scope="col" style="{CELL}">{name}</th>' for name in heads)
    body = "".join(
        f'<tr><th scope="row" style="{CELL}">{escape(name)}</th>'
        + "".join(f'<td style="{CELL}">{escape(cell)}</td>' for cell in cells)
        + "</tr>"
        for name, *cells in rows
    )
    return f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"


def _arrays(result: Any) -> str:
    """Closed table of the arrays: name, unit, dimensions, least and largest value."""
    rows = []
    for name, (_, values, unit) in {**result.coordinates(), **result.variables()}.items():
        array = np.asarray(values)
        rows.append((name, unit_text(unit), " × ".join(map(str, array.shape)), *_ends(array)))
    table = _table(("array", "unit", "size", "from", "to"), rows)
    return f"<details><summary>arrays</summary>{table}</details>" if rows else ""


def _ends(array: NDArray[Any]) -> tuple[str, str]:
    """Smallest and largest real number or absolute value of a complex one; of words the first and the last."""
    if not array.size:
        return "", ""
    if array.dtype.kind not in "biufc":
        return str(array.flat[0]), str(array.flat[-1])
    sizes = np.abs(array) if array.dtype.kind == "c" else array.astype(float)
    good = sizes[np.isfinite(sizes)]
    return (number(float(np.min(good))), number(float(np.max(good)))) if good.size else ("–", "–")
