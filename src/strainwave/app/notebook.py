"""A result as HTML: its text, its figure as SVG, and a table of its arrays.

Everything is in the text: no style sheet, no script, no file. Text has the notebook's own colour; the figure has a
white ground, and so looks the same in light and in dark notebooks.
"""

from html import escape
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..plot.svg import stacked
from .console import number
from .view import sign

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


def _arrays(result: Any) -> str:
    """Closed table of the arrays: name, unit, dimensions, least and largest value."""
    labelled = {**result.coordinates(), **result.variables()}
    if not labelled:
        return ""
    head = "".join(f'<th scope="col" style="{CELL}">{name}</th>' for name in ("array", "unit", "size", "from", "to"))
    rows = []
    for name, (_, values, unit) in labelled.items():
        array = np.asarray(values)
        size = " × ".join(map(str, array.shape))
        cells = [sign(unit), size, *_ends(array)]
        body = "".join(f'<td style="{CELL}">{escape(cell)}</td>' for cell in cells)
        rows.append(f'<tr><th scope="row" style="{CELL}">{escape(name)}</th>{body}</tr>')
    table = f"<table><thead><tr>{head}</tr></thead><tbody>{''.join(rows)}</tbody></table>"
    return f"<details><summary>arrays</summary>{table}</details>"


def _ends(array: NDArray[Any]) -> tuple[str, str]:
    """Smallest and largest real number or absolute value of a complex one; of words the first and the last."""
    if not array.size:
        return "", ""
    if array.dtype.kind not in "biufc":
        return str(array.flat[0]), str(array.flat[-1])
    sizes = np.abs(array) if array.dtype.kind == "c" else array.astype(float)
    good = sizes[np.isfinite(sizes)]
    return (number(float(np.min(good))), number(float(np.max(good)))) if good.size else ("–", "–")
