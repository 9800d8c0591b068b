"""Panels as SVG text, with ticks, a legend below them, and the same bytes every time.

The report's dozen figures take a few milliseconds each; matplotlib's, with 33 axes, took a third of the whole analysis.
A label beside a point stands where it crosses the fewest lines.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from html import escape
from itertools import pairwise
from textwrap import wrap

import numpy as np
from numpy.typing import ArrayLike

from ..base.number_text import number
from ..base.results import Floats
from .panels import Axis, Cells, Curve, Panel, placed_above

WIDTH, FONT, LETTER = 760.0, 12.5, 6.9  # of a figure, of its text, of a letter on average [px]
NARROW = 430.0  # of a figure whose text is read on a telephone, too [px]
ACROSS = 1500  # bins across a panel: of more points the smallest and the largest in each are drawn
LEFT, RIGHT, TOP, BOTTOM = 74.0, 12.0, 24.0, 44.0  # margins of a panel [px]
LEGEND_ROW, SAMPLE = 19.0, 30.0
CAPTION_ROW, LINE = 17.0, 104  # height of a line of the caption [px], and its letters
PAPER = '<rect width="100%" height="100%" fill="#ffffff"/>'
INK, GRID = "#222222", "#dddddd"
CHORD_PX = 0.08  # points nearer to the chord of their neighbours than this [px] are left out

Scale = Callable[[ArrayLike], Floats]

ROW, GAP = 12.0, 9.0  # height of the text, and its distance from the point [px]
STEP = 2.0  # between the points of a line that may cross a text [px]


def beside(
    u: float, v: float, width: float, lines: Sequence[tuple[Floats, Floats]], panel: float = np.inf
) -> tuple[float, float, str]:  # fmt: skip
    """Position [px] and anchor of a text of a width [px] beside the point (u, v), on the emptiest of four sides.

    Parameters
    ----------
    u, v : float
        The point, v downwards [px].
    width : float
        Of the text [px].
    lines : sequence of (x, y)
        Polylines of the panel [px].
    panel : float
        Width of the panel [px], which a text leaves only if it fits on no side.
    """
    middle = v + ROW / 3.0
    positions = (
        (u + GAP, middle, "start"),
        (u - GAP, middle, "end"),
        (u, v - GAP, "middle"),
        (u, v + GAP + ROW, "middle"),
    )
    shift = {"start": 0.0, "end": -width, "middle": -width / 2.0}

    def costs(position: tuple[float, float, str]) -> tuple[bool, int]:
        left = position[0] + shift[position[2]]
        return left < 0.0 or left + width > panel, _crossed(left, position[1], width, lines)

    return min(positions, key=costs)


def _crossed(left: float, base: float, width: float, lines: Sequence[tuple[Floats, Floats]]) -> int:
    """Number of points of the lines in the box of a text."""
    curves = (_dense(*line) for line in lines)
    inside = ((x > left) & (x < left + width) & (y > base - ROW) & (y < base + 3.0) for x, y in curves)
    return sum(int(np.sum(points)) for points in inside)


def _dense(x: Floats, y: Floats) -> tuple[Floats, Floats]:
    """A polyline with points so near that none of it slips through a text."""
    far = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(x), np.diff(y)))])
    arcs = np.arange(0.0, far[-1] + STEP, STEP)
    return np.interp(arcs, far, x), np.interp(arcs, far, y)


def ticks(low: float, high: float, count: int, unit: float = 0.0) -> tuple[list[float], list[str]]:
    """Round numbers between two ends, about `count`, or multiples of a unit, with their labels."""
    rough = (high - low) / count
    decade = 10.0 ** math.floor(math.log10(rough))
    step = decade * next(m for m in (1.0, 2.0, 2.5, 5.0, 10.0) if m * decade >= rough * (1.0 - 1e-9))
    step = unit * math.ceil(rough / unit) if unit else step
    values = [step * k for k in range(math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9) + 1)]
    decimals = max(0, (1 if abs(step / decade - 2.5) < 0.1 else 0) - math.floor(math.log10(step) + 1e-9))
    if decimals > 4 or max(abs(low), abs(high)) >= 1e6:
        return values, [number(v) for v in values]
    return values, [f"{v:.{decimals}f}".replace("-", "−") for v in values]


def log_ticks(low: float, high: float, count: int = 8) -> tuple[list[float], list[str]]:
    """Powers of ten between two ends, and 2 and 5 times them where there is room for `count`, with their labels."""
    finer = ((10.0 ** (0.5 * count), (1.0,)), (10.0, (1.0, 2.0, 5.0)), (0.0, (1.0, 2.0, 3.0, 5.0, 7.0)))
    parts = next(parts for ratio, parts in finer if high > ratio * low)
    decades = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
    values = [m * 10.0**k for k in decades for m in parts if low <= m * 10.0**k <= high]
    return (values, [number(v) for v in values]) if len(values) > 1 else ticks(low, high, 4)


def figure(rows: Sequence[Sequence[Panel]], height: float, label: str, width: float = WIDTH) -> str:
    """Draw rows of panels, each `height` px high, with one legend for all below them.

    Parameters
    ----------
    rows : sequence of sequences of Panel
        Panels from left to right, rows from top to bottom.
    height : float
        Height of a panel with its labels [px].
    label : str
        Text for screen readers.
    width : float
        Of the figure [px]; the text of a narrow one is larger on the same screen.

    Returns
    -------
    str
        One SVG element.
    """
    if all(panel.empty for row in rows for panel in row):
        return ""
    parts, panels = [], [panel for row in rows for panel in row]
    for i, row in enumerate(rows):
        panel_width = width / len(row)
        for j, panel in enumerate(row):
            next_row = rows[i + 1] if i + 1 < len(rows) else []
            named = len(next_row) != len(row) or next_row[j].x != panel.x
            parts.append(_panel(panel, j * panel_width, i * height, panel_width, height, named))
    entries: dict[str, Curve] = {}
    for curve in (curve for panel in panels for curve in panel.curves if curve.label):
        entries.setdefault(curve.label, curve)
    legend, room = _legend(entries, len(rows) * height, width)
    letters = int(LINE * width / WIDTH)
    captions = [line for panel in panels for text in panel.caption for line in wrap(text, letters)]
    top = len(rows) * height + room + 4.0
    below = legend + "".join(text_at(LEFT, top + CAPTION_ROW * i, line, "start") for i, line in enumerate(captions))
    room += CAPTION_ROW * len(captions)
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" role="img" aria-label="{escape(label)}" '
        f'viewBox="0 0 {width:.0f} {len(rows) * height + room:.0f}" fill="{INK}" font-size="{FONT}" '
        f'font-family="Segoe UI, Helvetica Neue, Arial, DejaVu Sans, sans-serif">{PAPER}{"".join(parts)}{below}</svg>'
    )


def stacked(panels: Sequence[Panel], height: float, label: str, width: float = NARROW) -> str:
    """Draw panels below each other; the width of a telephone unless another is given."""
    return figure([[panel] for panel in panels], height, label, width)


def _panel(panel: Panel, x: float, y: float, width: float, height: float, named: bool) -> str:
    """A panel with the corner (x, y): its axes, its curves inside them, then the marks and notes that may stand out."""
    w, h = width - LEFT - RIGHT, height - TOP - BOTTOM
    (left, right, xlog), (bottom, top, ylog) = panel.scales()

    def across(values: ArrayLike) -> Floats:
        return np.asarray(_shares(values, left, right, xlog) * w)

    def up(values: ArrayLike) -> Floats:
        return np.asarray(h - _shares(values, bottom, top, ylog) * h)

    svg = [f'<g transform="translate({x + LEFT:.1f} {y + TOP:.1f})">', *_axes(panel, across, up, (w, h), named)]
    # an inner svg clips what leaves the panel
    svg.append(f'<svg width="{w:.1f}" height="{h:.1f}" overflow="hidden">')
    svg += [] if panel.cells is None else _cells(panel.cells, across, up)
    svg += [_line(c, across, up) for c in panel.curves if not c.marker]
    svg += [_arrow(float(across(a.x)), float(up(a.start)), float(up(a.end))) for a in panel.arrows]
    svg.append("</svg>")
    for c in panel.curves:
        if c.marker:
            pixels = zip(across(c.x), up(c.y), strict=True)
            svg += [_marker(u, v, c) for u, v in pixels if -1 < u < w + 1 and -1 < v < h + 1]
    svg += _notes(panel, across, up, (w, h))
    return "".join(svg) + "</g>"


def _axes(panel: Panel, across: Scale, up: Scale, size: tuple[float, float], named: bool) -> Iterator[str]:
    """Grid, axes, ticks, title and names; of the axis to the right where it is `named`."""
    (left, right, xlog), (bottom, top, ylog) = panel.scales()
    w, h = size
    xs, names = _shown_ticks(panel.x, left, right, xlog, max(4, round(w / 75.0)))
    ys, heights = _shown_ticks(panel.y, bottom, top, ylog, max(8 if ylog else 4, round(h / 45.0)), panel.ystep)
    px, py = across(xs).tolist(), up(ys).tolist()
    grid = "".join(f"M{v:.1f} 0V{h:.1f}" for v in px) + "".join(f"M0 {v:.1f}H{w:.1f}" for v in py)
    yield f'<path d="{grid}" stroke="{GRID}"/><path d="M0 0V{h:.1f}H{w:.1f}" fill="none" stroke="{INK}"/>'
    for v, name in zip(px, names, strict=True):  # the last one ends within the figure
        yield text_at(min(v, w + RIGHT - 0.5 * LETTER * len(name)), h + 16.0, name, "middle")
    for v, name in zip(py, heights, strict=True):
        yield text_at(-6.0, v + 4.0, name, "end")
    yield text_at(0.0, -9.0, panel.title, "start")
    if named:
        yield text_at(w / 2.0, h + 35.0, str(panel.x), "middle")
    beside_ticks = -max(44.0, 12.0 + 7.4 * max(map(len, heights), default=0))
    for i, text in enumerate(reversed(panel.y.lines(int((h + TOP + 24.0) / LETTER)))):
        yield text_at(beside_ticks - 15.0 * i, h / 2.0, text, "middle", turned=True)


def _shares(values: ArrayLike, low: float, high: float, log: bool) -> Floats:
    """Positions of values on an axis, from 0 at its one end to 1 at the other."""
    v = np.asarray(values, float)
    with np.errstate(divide="ignore", invalid="ignore"):
        share = np.log(v / low) / math.log(high / low) if log else (v - low) / (high - low)
    return np.clip(np.nan_to_num(share, nan=-4.0), -4.0, 5.0)


def _shown_ticks(
    axis: Axis, low: float, high: float, log: bool, count: int, step: float = 0.0
) -> tuple[Floats, list[str]]:  # fmt: skip
    """Positions [SI] of the ticks of an axis, and their names in its unit."""
    ends = low / axis.size, high / axis.size
    values, names = log_ticks(*ends, count) if log else ticks(*ends, count, step)
    return axis.size * np.array(values), names


def _cells(cells: Cells, across: Scale, up: Scale) -> Iterator[str]:
    """Runs of cells of one colour in a row."""
    x, y = across(cells.x).tolist(), up(cells.y).tolist()
    for row, (bottom, top) in zip(np.asarray(cells.shade), pairwise(y), strict=True):
        for a, b in pairwise([0, *(np.flatnonzero(np.diff(row)) + 1).tolist(), len(row)]):
            if row[a] >= 0:
                size = f'width="{x[b] - x[a] + 0.2:.1f}" height="{bottom - top + 0.2:.1f}"'  # no seams
                yield f'<rect x="{x[a]:.1f}" y="{top:.1f}" {size} fill="{cells.colours[row[a]]}"/>'


def thin(x: Floats, y: Floats) -> tuple[Floats, Floats]:
    """The points of a curve, or of many the smallest and the largest of each bin of them."""
    if len(x) <= 4 * ACROSS:
        return x, y
    count = -(-len(x) // ACROSS)
    bins = -(-len(x) // count)
    rows = np.append(y, np.full(bins * count - len(y), y[-1])).reshape(bins, count)
    first = count * np.arange(bins)
    keep = np.unique(np.concatenate([[0], first + np.argmin(rows, 1), first + np.argmax(rows, 1), [len(x) - 1]]))
    keep = keep[keep < len(x)]
    return x[keep], y[keep]


def _notes(panel: Panel, across: Scale, up: Scale, size: tuple[float, float]) -> list[str]:
    """Texts above the panel, and those beside a point where they cross the fewest lines, arrows and edges."""
    w, h = size
    lines = [(across(c.x), up(c.y)) for c in panel.curves if c.x.size and not c.marker and np.all(np.isfinite(c.x))]
    lines += [(across([a.x, a.x]), up([a.start, a.end])) for a in panel.arrows]
    edge = np.array([0.0, w, w, 0.0, 0.0]), np.array([0.0, 0.0, h, h, 0.0])
    lines.append(edge)
    high = [note for note in panel.notes if note.above]
    rows = placed_above(high, across([note.x for note in high]), w, LETTER)
    texts = [text_at(middle, -4.0 - 13.0 * row, text, "middle") for text, middle, row in rows]
    for note in panel.notes:
        position = float(across(note.x))
        if not note.above and -1.0 < position < w + 1.0:
            u, v, anchor = beside(position, float(up(note.y)), LETTER * len(note.text), lines, w)
            texts.append(text_at(u, v, note.text, anchor, halo=True))
    return texts


def text_at(x: float, y: float, text: str, anchor: str, turned: bool = False, halo: bool = False) -> str:
    """A text at a position [px]."""
    if not text:
        return ""
    attributes = f'x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}"'
    attributes += f' transform="rotate(-90 {x:.1f} {y:.1f})"' if turned else ""
    attributes += ' stroke="#ffffff" stroke-width="3" paint-order="stroke"' if halo else ""
    return f"<text {attributes}>{escape(text)}</text>"


def _stroke(curve: Curve) -> str:
    dash = f' stroke-dasharray="{curve.dash}"' if curve.dash else ""
    return f'stroke="{curve.colour}" stroke-width="{curve.width:g}"{dash}'


def _line(curve: Curve, across: Scale, up: Scale) -> str:
    x, y = curve.x, curve.y
    if curve.upper is not None:
        x, y = across(np.concatenate([x, x[::-1]])), up(np.concatenate([y, curve.upper[::-1]]))
        return f'<path d="{_path(x, y)}Z" fill="{curve.colour}" fill-opacity="0.45"/>'
    good = ~(np.isnan(x) | np.isnan(y))
    parts = np.split(np.arange(len(x)), np.flatnonzero(np.diff(good)) + 1)
    pieces = [thin(x[part], y[part]) for part in parts if len(part) and good[part[0]]]
    path = "".join(_path(across(u), up(v)) for u, v in pieces)
    return f'<path d="{path}" fill="none" stroke-linejoin="round" {_stroke(curve)}/>' if path else ""


def _path(x: Floats, y: Floats) -> str:
    """Path through the points, without those that make no visible difference."""
    for _ in range(4):
        if len(x) < 200:
            break
        odd = np.arange(1, len(x) - 1, 2)
        ahead, aside = x[odd + 1] - x[odd - 1], y[odd + 1] - y[odd - 1]
        distance = np.abs(ahead * (y[odd] - y[odd - 1]) - aside * (x[odd] - x[odd - 1]))
        keep = np.ones(len(x), bool)
        keep[odd[distance < CHORD_PX * np.hypot(ahead, aside)]] = False
        x, y = x[keep], y[keep]
    flat = np.column_stack([x, y]).ravel().tolist()
    return "M" + ("%.1f %.1fL" * len(x))[:-1] % tuple(flat)


def _marker(x: float, y: float, curve: Curve) -> str:
    look = f'fill="{curve.face}" {_stroke(curve)}'
    if curve.marker == "o":
        return f'<circle cx="{x:.1f}" cy="{y:.1f}" r="4" {look}/>'
    if curve.marker == ".":
        return f'<circle cx="{x:.1f}" cy="{y:.1f}" r="1.6" fill="{curve.face}"/>'
    if curve.marker == "s":
        return f'<rect x="{x - 3.5:.1f}" y="{y - 3.5:.1f}" width="7" height="7" {look}/>'
    s = 1.0 if curve.marker == "^" else -1.0
    return f'<path d="M{x - 4.6:.1f} {y + 3.6 * s:.1f}h9.2L{x:.1f} {y - 4.6 * s:.1f}Z" {look}/>'


def _arrow(x: float, start: float, end: float) -> str:
    back = 7.0 if start > end else -7.0
    head = f'<path d="M{x - 3.5:.1f} {end + back:.1f}h7l-3.5 {-back:.1f}Z"/>'
    return f'<path d="M{x:.1f} {start:.1f}V{end + back:.1f}" stroke="{INK}" stroke-dasharray="3 2"/>{head}'


def _legend(entries: dict[str, Curve], top: float, width: float) -> tuple[str, float]:
    """Samples and names in as many columns as fit, and the height they take [px]."""
    for columns in range(min(4, len(entries)), 0, -1):
        names = list(entries)
        widths = [max(map(len, names[i::columns])) * LETTER + SAMPLE + 24.0 for i in range(columns)]
        if columns == 1 or sum(widths) <= width - LEFT:
            break
    else:
        return "", 0.0
    starts = max(0.0, width - sum(widths)) / 2.0 + np.cumsum([0.0, *widths])
    svg = []
    for i, (name, curve) in enumerate(entries.items()):
        x, y = float(starts[i % columns]), top + 6.0 + LEGEND_ROW * (i // columns)
        if curve.marker:
            svg.append(_marker(x + SAMPLE / 2.0, y, curve))
        elif curve.upper is not None:
            band = f'x="{x:.1f}" y="{y - 5.0:.1f}" width="{SAMPLE - 6.0}" height="10" fill="{curve.colour}"'
            svg.append(f'<rect {band} fill-opacity="0.45"/>')
        else:
            svg.append(f'<path d="M{x:.1f} {y:.1f}h{SAMPLE - 6.0}" fill="none" {_stroke(curve)}/>')
        svg.append(text_at(x + SAMPLE, y + 4.0, name, "start"))
    return "".join(svg), LEGEND_ROW * (1 + (len(entries) - 1) // columns) + 4.0
