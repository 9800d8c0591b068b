"""A bar chart of relative changes as SVG: a row each with its name and its value; less is filled, more is hatched."""

from collections.abc import Sequence
from html import escape
from textwrap import wrap
from typing import NamedTuple

from ...plot.svg import FONT, GRID, INK, LETTER, WIDTH

ROW, LINE, THICK, TOP = 12.0, 16.0, 13.0, 40.0  # space between rows, of a line of text, of a bar, above them [px]
NAME, GAP = 42, 7.0  # letters of a line of a name, and distance of texts [px]
LARGEST = 1.0  # relative change from which on a bar is cut; its value stands beside it
FILL, HATCH = "#0072B2", "more"


class Bar(NamedTuple):
    """A relative change with the name of its cause and the text of its value."""

    name: str
    change: float
    value: str


def bars(rows: Sequence[Bar], title: str, label: str) -> str:
    """Draw the changes below each other, in their order.

    Parameters
    ----------
    rows : sequence of Bar
        From top to bottom.
    title : str
        Above the chart.
    label : str
        What a screen reader says.

    Returns
    -------
    str
        One SVG element, 760 px wide.
    """
    names = [wrap(row.name, NAME) or [""] for row in rows]
    shown = [min(max(row.change, -LARGEST), LARGEST) for row in rows]
    left = GAP + LETTER * max((len(line) for lines in names for line in lines), default=0) + GAP
    room = 2.0 * GAP + LETTER * max((len(row.value) for row in rows), default=0)
    low, high = min([0.0, *shown]), max([0.0, *shown])
    scale = (WIDTH - left - 2.0 * room) / ((high - low) or 1.0)
    zero, y, parts = left + room - low * scale, TOP, []
    for row, lines, change in zip(rows, names, shown, strict=True):
        middle = y + 0.5 * LINE * len(lines)
        parts += [_text(left - GAP, y + LINE * (i + 0.75), line, "end") for i, line in enumerate(lines)]
        parts.append(_bar(zero, middle, change * scale))
        at, anchor = (zero + change * scale - GAP, "end") if change < 0.0 else (zero + change * scale + GAP, "start")
        parts.append(_text(at, middle + 0.25 * LINE, row.value, anchor))
        y += LINE * len(lines) + ROW
    axis = f'<path d="M{zero:.1f} {TOP - 6.0:.1f}V{y - 0.5 * ROW:.1f}" stroke="{INK}"/>'
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" role="img" aria-label="{escape(label)}" '
        f'viewBox="0 0 {WIDTH:.0f} {y:.0f}" fill="{INK}" font-size="{FONT}" '
        f'font-family="Segoe UI, Helvetica Neue, Arial, DejaVu Sans, sans-serif">{_hatch()}'
        f"{_text(GAP, 18.0, title, 'start')}{''.join(parts)}{axis}</svg>"
    )


def _hatch() -> str:
    pattern = f'<pattern id="{HATCH}" width="6" height="6" patternUnits="userSpaceOnUse" patternTransform="rotate(45)">'
    return f'<defs>{pattern}<path d="M0 0V6" stroke="{INK}" stroke-width="2"/></pattern></defs>'


def _bar(zero: float, middle: float, width: float) -> str:
    look = f'fill="{FILL}"' if width < 0.0 else f'fill="url(#{HATCH})"'
    place = f'x="{min(zero, zero + width):.1f}" y="{middle - 0.5 * THICK:.1f}" width="{abs(width):.1f}"'
    return f'<rect {place} height="{THICK:g}" {look} stroke="{INK if width else GRID}"/>'


def _text(x: float, y: float, text: str, anchor: str) -> str:
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}">{escape(text)}</text>'
