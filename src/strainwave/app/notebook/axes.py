"""Axes that take the calls by which `strainwave.plot` draws and give an SVG figure, without matplotlib.

They know the calls that `plot` makes. Ornaments (places of legends, sizes of ticks) are passed over.

Maps as curves of a panel: cells in shades of grey, and lines of equal height.
"""

from collections.abc import Iterator, Sequence
from contextlib import suppress
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ...base.results import Floats
from ..figures.svg import Arrow, Curve, Note, Panel, figure

CYCLE = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#A08A00", "#555555")
LETTERS = {"k": "#000000", "w": "#ffffff", "black": "#000000", "white": "#ffffff", "none": "none"}
DASHES = {"-": "", "--": "6 3", "-.": "6 3 1 3", ":": "2 3"}
MARKERS = {"o": "o", "^": "^", "v": "v", ".": "o"}
OTHER_MARKER = "s"
MOST = 4000  # points of a curve; of more the least and the largest of stretches are drawn
WIDTH, TALL, LOW = 620.0, 270.0, 170.0  # of the figure, of a panel on its own, and of one of several [px]

STEPS = 12  # shades
LIGHTEST, DARKEST = 0xFA, 0x50


def shades(x: Floats, y: Floats, values: Floats, ends: Sequence[Any]) -> list[Curve]:
    """Bands of cells with one shade; values (rows, columns) between edges x (columns+1,) and y (rows+1,)."""
    low = np.nanmin(values) if ends[0] is None else ends[0]
    high = np.nanmax(values) if ends[1] is None else ends[1]
    share = (values - low) / ((high - low) or 1.0)
    level = np.where(np.isfinite(share), np.clip(share, 0.0, 1.0) * (STEPS - 1), -1.0).round().astype(int)
    out = []
    for row, (bottom, top) in zip(level, pairwise(y), strict=True):
        cuts = [0, *(np.flatnonzero(np.diff(row)) + 1).tolist(), len(row)]
        for a, b in pairwise(cuts):
            if row[a] >= 0:
                grey = round(LIGHTEST + (DARKEST - LIGHTEST) * int(row[a]) / (STEPS - 1))
                band = np.array([x[a], x[b]]), np.full(2, bottom), f"#{3 * f'{grey:02x}'}"
                out.append(Curve(*band, upper=np.full(2, top)))
    return out


def contours(x: Floats, y: Floats, height: Floats, levels: Sequence[float]) -> Iterator[tuple[Floats, Floats]]:
    """Lines on which a height (rows, columns) over x (columns,) and y (rows,) has a level, cell by cell.

    Each line crosses one triangle of half a cell, in which the height is linear.
    """
    for level in levels:
        for i in range(len(y) - 1):
            for j in range(len(x) - 1):
                corners = [(x[j + a], y[i + b], height[i + b, j + a] - level) for b in (0, 1) for a in (0, 1)]
                for three in ((0, 1, 3), (0, 2, 3)):
                    ends = list(_crossings([corners[k] for k in three]))
                    if len(ends) == 2:
                        yield np.array([ends[0][0], ends[1][0]]), np.array([ends[0][1], ends[1][1]])


def _crossings(corners: list[tuple[float, float, float]]) -> Iterator[tuple[float, float]]:
    """Places on the sides of a triangle where the third number changes its sign."""
    for (x0, y0, h0), (x1, y1, h1) in zip(corners, corners[1:] + corners[:1], strict=True):
        if (h0 < 0.0) != (h1 < 0.0):
            share = h0 / (h0 - h1)
            yield x0 + share * (x1 - x0), y0 + share * (y1 - y0)


def colour(name: Any, otherwise: str = CYCLE[0]) -> str:
    """Colour of SVG by its name in matplotlib: "0.5" is a grey, "C1" the second of the cycle."""
    if name is None:
        return otherwise
    if not isinstance(name, str):
        return "#" + "".join(f"{round(255.0 * part):02x}" for part in name[:3])
    if name[:1] == "C" and name[1:].isdigit():
        return CYCLE[int(name[1:]) % len(CYCLE)]
    with suppress(ValueError):
        return "#" + 3 * f"{round(255.0 * float(name)):02x}"
    return LETTERS.get(name, name)


def thinned(x: Floats, y: Floats) -> tuple[Floats, Floats]:
    """A curve with at most `MOST` points: of every stretch its least and its largest."""
    if len(x) <= MOST:
        return x, y
    parts = np.array_split(np.arange(len(x)), MOST // 2)
    found = {int(part[at]) for part in parts for at in (np.argmin(y[part]), np.argmax(y[part]))}
    keep = sorted(found | {0, len(x) - 1})
    return x[keep], y[keep]


class Axes:
    """One panel; `figure` is the figure, which holds those that are added."""

    def __init__(self, whole: "Figure | None" = None) -> None:
        self.panel = Panel("", "", "")
        self.figure = whole or Figure()
        self.figure.all.append(self)
        self.edges: list[tuple[bool, tuple[float, float], str, str]] = []  # what reaches from edge to edge
        self.xends: tuple[Any, Any] = (None, None)
        self.yends: tuple[Any, Any] = (None, None)

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        return _Nothing()  # an ornament

    def plot(self, x: ArrayLike, y: ArrayLike, style: str = "", **look: Any) -> None:
        """Add a line or a row of markers, as matplotlib's `plot`."""
        across, up = (np.atleast_1d(np.asarray(values, float)) for values in (x, y))
        mark = look.get("marker") or next((letter for letter in style if letter in "os^vDPX*.x+"), "")
        dash = next((d for d in ("--", "-.", "-", ":") if style.replace(mark or " ", "").endswith(d)), "")
        dash = look.get("ls", look.get("linestyle", dash)) or ("" if mark else "-")
        own = next((letter for letter in style if letter in "kw"), None)
        ink = colour(look.get("color", look.get("mec", own)), CYCLE[len(self.panel.curves) % len(CYCLE)])
        label, width = look.get("label") or "", float(look.get("lw", look.get("linewidth", 1.6)))
        if dash in DASHES:
            self._pieces(across, up, Curve(across, up, ink, "" if mark else label, DASHES[dash], width))
        if mark:
            face = look.get("mfc", look.get("markerfacecolor"))
            good = np.isfinite(across) & np.isfinite(up)
            shape = MARKERS.get(mark, OTHER_MARKER)
            row = Curve(across[good], up[good], ink, label, width=1.1, marker=shape, face=colour(face, ink))
            self.panel.curves.append(row)

    def _pieces(self, x: Floats, y: Floats, curve: Curve) -> None:
        """The stretches of a curve between values that are not numbers."""
        good = np.isfinite(x) & np.isfinite(y)
        cuts = np.flatnonzero(np.diff(good.astype(int))) + 1
        pieces = [part for part in np.split(np.arange(len(x)), cuts) if len(part) and good[part[0]]]
        for part in pieces or [np.arange(0)]:
            across, up = thinned(x[part], y[part])
            self.panel.curves.append(curve._replace(x=across, y=up))

    def step(self, x: ArrayLike, y: ArrayLike, where: str = "post", **look: Any) -> None:
        """Add stairs."""
        across, up = np.repeat(np.asarray(x, float), 2), np.repeat(np.asarray(y, float), 2)
        self.plot(across[1:] if where == "post" else across[:-1], up[:-1] if where == "post" else up[1:], **look)

    def errorbar(self, x: ArrayLike, y: ArrayLike, yerr: Any = None, xerr: Any = None, **look: Any) -> None:
        """Add markers with upright and level bars."""
        across, up = np.atleast_1d(np.asarray(x, float)), np.atleast_1d(np.asarray(y, float))
        ink, bars = colour(look.get("color")), []
        for error, level in ((yerr, False), (xerr, True)):
            if error is not None:
                low, high = np.broadcast_to(np.asarray(error, float), (2, len(across)))
                ends = (across - low, across + high) if level else (up - low, up + high)
                bars += [(a, b, v, level) for a, b, v in zip(*ends, up if level else across, strict=True)]
        for a, b, v, level in bars:
            self.plot(*(([a, b], [v, v]) if level else ([v, v], [a, b])), color=ink, lw=1.0)
        self.plot(
            across, up, look.get("fmt", "o"), **{k: v for k, v in look.items() if k in ("mfc", "label")}, color=ink
        )

    def vlines(self, x: ArrayLike, low: ArrayLike, high: ArrayLike, **look: Any) -> None:
        """Add upright lines."""
        for at, a, b in np.broadcast(x, low, high):
            self.plot([at, at], [a, b], **{**look, "label": ""})

    def scatter(self, x: ArrayLike, y: ArrayLike, **look: Any) -> None:
        """Add small markers of one colour."""
        self.plot(x, y, ".", label=look.get("label", ""))

    def axhline(self, y: float, **look: Any) -> None:
        """Add a level line from edge to edge."""
        self._edge(False, (y, y), look)

    def axvline(self, x: float, **look: Any) -> None:
        """Add an upright line from edge to edge."""
        self._edge(True, (x, x), look)

    def axvspan(self, low: float, high: float, **look: Any) -> None:
        """Shade what lies between two places."""
        self._edge(True, (low, high), look)

    def _edge(self, upright: bool, ends: tuple[float, float], look: dict[str, Any]) -> None:
        dash = DASHES.get(look.get("ls", "-"), "")
        self.edges.append((upright, ends, colour(look.get("color")), dash))
        if look.get("label"):
            self.panel.curves.append(Curve(np.empty(0), np.empty(0), colour(look.get("color")), look["label"], dash))

    def fill_between(self, x: ArrayLike, low: ArrayLike, high: ArrayLike = 0.0, **look: Any) -> None:
        """Shade what lies between two curves."""
        across = np.asarray(x, float)
        ends = (np.broadcast_to(np.asarray(v, float), across.shape) if len(across) else across for v in (low, high))
        lower, upper = ends
        self.panel.curves.append(Curve(across, lower, colour(look.get("color")), look.get("label") or "", upper=upper))

    def broken_barh(self, parts: Sequence[tuple[float, float]], rows: tuple[float, float], **look: Any) -> None:
        """Add bars, each from its begin and its width, on one row."""
        ink, label = colour(look.get("edgecolor")), look.get("label") or ""
        for begin, width in parts or [(np.nan, 0.0)]:
            x = np.array([begin, begin + width]) if np.isfinite(begin) else np.empty(0)
            low, high = np.full(len(x), rows[0]), np.full(len(x), rows[0] + rows[1])
            self.panel.curves.append(Curve(x, low, ink, label, upper=high))

    def pcolormesh(self, x: ArrayLike, y: ArrayLike, values: ArrayLike, **look: Any) -> None:
        """Shade cells between edges x and y by their values."""
        ends = (look.get("vmin"), look.get("vmax"))
        self.panel.curves += shades(np.asarray(x, float), np.asarray(y, float), np.asarray(values, float), ends)

    def contour(self, x: ArrayLike, y: ArrayLike, height: ArrayLike, levels: Sequence[float], **look: Any) -> Any:
        """Add the lines on which the height over (y, x) has the levels."""
        ink, dash = colour(look.get("colors")), DASHES.get(look.get("linestyles", "-"), "")
        for across, up in contours(np.asarray(x, float), np.asarray(y, float), np.asarray(height, float), levels):
            self.panel.curves.append(Curve(across, up, ink, "", dash, float(look.get("linewidths", 1.2))))

    def annotate(self, text: str, xy: Any, xytext: Any = None, arrowprops: Any = None, **look: Any) -> None:
        """Add a text beside a point, or an upright arrow to it."""
        if arrowprops:
            self.panel.arrows.append(Arrow(float(xy[0]), float(xytext[1]), float(xy[1])))
        if text:
            self.panel.notes.append(Note(float(xy[0]), float(xy[1]), text))

    def twinx(self) -> "Axes":
        """Give a panel below this one in place of a second scale."""
        return self.figure.add_axes(sharex=self)

    def set(self, **what: Any) -> None:
        """Name and scale the axes, as matplotlib's `set`."""
        for name, value in what.items():
            getattr(self, f"set_{name}")(value)

    def set_xlabel(self, text: str, **look: Any) -> None:
        """Name the level axis."""
        self.panel.xlabel = text

    def set_ylabel(self, text: str, **look: Any) -> None:
        """Name the upright axis."""
        self.panel.ylabel = text

    def set_title(self, text: str, **look: Any) -> None:
        """Write above the panel."""
        self.panel.title = text

    def set_xscale(self, scale: str, **look: Any) -> None:
        """Choose "log" or "linear"."""
        self.panel.xlog = scale == "log"

    def set_yscale(self, scale: str, **look: Any) -> None:
        """Choose "log" or "linear"."""
        self.panel.log = scale == "log"

    def set_xlim(self, ends: Sequence[float]) -> None:
        """Fix the ends of the level axis."""
        self.xends = (ends[0], ends[1])

    def set_ylim(self, ends: Any = (None, None), top: Any = None, *, bottom: Any = None) -> None:
        """Fix ends of the upright axis; None leaves one as it is."""
        self.yends = ends if isinstance(ends, tuple) and ends != (None, None) else (bottom, top)
        if not isinstance(ends, tuple):
            self.yends = (ends, top)

    def get_xlabel(self) -> str:
        """Name of the level axis."""
        return self.panel.xlabel

    def get_ylim(self) -> tuple[float, float]:
        """Ends of the upright axis."""
        return self.panel.limits()[1]

    def get_legend_handles_labels(self) -> tuple[list[Any], list[str]]:
        """Lines and names of the legend, which the figure makes of its own."""
        return [], []

    def finished(self) -> Panel | None:
        """The panel with all that reaches its edges; None where nothing is to be seen."""
        panel = self.panel
        x = np.concatenate([np.empty(0), *(c.x for c in panel.curves)])
        y = np.concatenate([np.empty(0), *(c.y for c in panel.curves)])
        if not np.any(np.isfinite(x)) or not np.any(np.isfinite(y)):
            return None
        if panel.xlog and 0.0 < np.min(x) < np.max(x):
            pad = (np.max(x) / np.min(x)) ** 0.03
            panel.xlim = (float(np.min(x) / pad), float(np.max(x) * pad))
        else:
            panel.xlog = False
        panel.log = panel.log and len(set(y[y > 0.0].tolist())) > 1
        levels = [ends[0] for upright, ends, _, _ in self.edges if not upright]
        panel.curves += [Curve(x[:1], np.array([v]), "none") for v in levels]  # within the limits
        xlim, ylim = panel.limits()
        panel.xlim, panel.ylim = _ends(self.xends, xlim), _ends(self.yends, ylim)
        for upright, (low, high), ink, dash in self.edges:
            if low == high and upright:
                panel.line([low, low], panel.ylim, ink, dash=dash, width=0.9)
            elif low == high:
                panel.line(panel.xlim, [low, low], ink, dash=dash, width=0.9)
            else:
                bottom, top = (np.full(2, end) for end in panel.ylim)
                panel.curves.insert(0, Curve(np.array([low, high]), bottom, ink, upper=top))
        return panel


class Figure:
    """What the panels stand in, one below the other."""

    def __init__(self) -> None:
        self.all: list[Axes] = []

    def add_axes(self, _place: Any = None, sharex: Any = None) -> Axes:
        """Add a panel below."""
        return Axes(self)

    def colorbar(self, drawn: Any, ax: Axes, label: str) -> None:
        """Say above the panel what the shades mean."""
        ax.panel.title = f"shades: {label}, dark is large"

    def set_layout_engine(self, name: str) -> None:
        """Pass over: panels have their places."""

    def svg(self, label: str) -> str:
        """The figure; "" where nothing is to be seen."""
        panels = [panel for axes in self.all if (panel := axes.finished()) is not None]
        for panel in panels[:-1]:
            if panel.xlabel == panels[-1].xlabel:
                panel.xlabel = ""
        height = TALL if len(panels) < 2 else LOW
        return figure([[panel] for panel in panels], height, label, WIDTH) if panels else ""


class _Nothing:
    """What an ornament gives: it may be called, and has ornaments of its own."""

    bounds = (0.0, 0.0, 1.0, 1.0)

    def __call__(self, *given: Any, **named: Any) -> "_Nothing":
        return self

    def __getattr__(self, name: str) -> "_Nothing":
        if name.startswith("__"):
            raise AttributeError(name)
        return self


def _ends(fixed: tuple[Any, Any], found: tuple[float, float]) -> tuple[float, float]:
    low, high = (own if end is None else float(end) for end, own in zip(fixed, found, strict=True))
    return low, high
