"""Figures as plain data: curves in SI, with the unit of each axis. Any renderer draws them.

The figure of a result is defined once: by its `panels()`, or by a function that is registered here for its class.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import singledispatch
from itertools import pairwise
from textwrap import wrap
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..base.above import above
from ..base.number_text import unit_text
from ..base.results import Floats
from ..base.units import angle_unit as unit_of
from ..drive.speeds import BASES, Speeds

# Colours that colour-blind people tell apart (Okabe and Ito), and dashes for readers without colours.
BLUE, ORANGE, GREEN, PINK = "#0072B2", "#D55E00", "#009E73", "#CC79A7"
BLACK, GREY, PALE = "#222222", "#777777", "#c0c0c0"
DASHES, DOT_DASH, DOTS = "6 3", "8 3 2 3", "2 2"
LOOKS = (
    (BLUE, ""), (ORANGE, DASHES), (GREEN, DOTS), (PINK, "10 3"), (GREY, ""), (BLUE, DOTS), (ORANGE, DOT_DASH),
    (GREEN, ""), (PINK, DASHES), (GREY, DOTS),
)  # fmt: skip

ROWS = 2  # of texts above a panel
NAME_LETTERS = 44  # letters of the name of a drive above a panel
Ends = tuple[float | None, float | None]


class Axis(NamedTuple):
    """Name of an axis, and the unit in which it is shown: its own name, and its size in SI."""

    name: str
    unit: str = ""
    size: float = 1.0

    def __str__(self) -> str:
        unit = unit_text(self.unit)
        return f"{self.name} ({unit})" if self.name and unit else self.name or unit

    def lines(self, letters: int) -> list[str]:
        """Name and unit in one line, or in two where they are longer than a count of letters."""
        text = str(self)
        if len(text) > letters >= len(self.name):
            return [self.name, f"({unit_text(self.unit)})"]
        return wrap(text, max(letters, round(0.6 * len(text))))


def of_speeds(speeds: Speeds) -> Axis:
    """Axis of the speed of the base angle: motor rpm, or rad/s where that angle is a forcing phase."""
    return Axis(speeds.name, speeds.unit, 1.0 / speeds.scale)


MOTOR = of_speeds(BASES["motor"])
TIME = Axis("time", "s")
HERTZ = Axis("frequency", "Hz", 2.0 * np.pi)


def angle_unit(values: ArrayLike) -> tuple[str, float]:
    """Name and size [rad] of the unit that suits angles whose largest is that of `values`."""
    finite = np.abs(np.asarray(values, float))
    return unit_of(float(np.max(finite[np.isfinite(finite)], initial=0.0)))


def angle(name: str, values: ArrayLike, per: str = "") -> Axis:
    """Axis of angles [rad], in the unit that suits their largest; `per` is the unit that divides them, as "/s"."""
    unit, size = angle_unit(values)
    return Axis(name, unit + per, size)


class Curve(NamedTuple):
    """A polyline, a row of markers, or (with `upper`) the band between two curves."""

    x: Floats
    y: Floats
    colour: str
    label: str = ""
    dash: str = ""
    width: float = 1.6
    marker: str = ""  # "o", "s", "^" or "v" instead of a line
    face: str = ""
    upper: Floats | None = None


class Note(NamedTuple):
    """A text beside a point, or `above` the panel, where there is room for it."""

    x: float
    y: float
    text: str
    above: bool = False


class Arrow(NamedTuple):
    """A dashed upright arrow."""

    x: float
    start: float
    end: float


class Cells(NamedTuple):
    """Coloured cells between edges x (columns + 1,) and y (rows + 1,): numbers of colours, -1 where there is none."""

    x: Floats
    y: Floats
    shade: Any  # (rows, columns) integers
    colours: Sequence[str]


def named(panels: Sequence["Panel"], name: str) -> list["Panel"]:
    """Panels with the name of their drive above the first, so that a file of them says whose they are."""
    return [replace(panels[0], title=": ".join(filter(None, (name[:NAME_LETTERS], panels[0].title)))), *panels[1:]]


@dataclass
class Panel:
    """One pair of axes with its curves, notes and arrows, in SI; ends that are None follow from the curves."""

    title: str
    x: Axis
    y: Axis
    curves: list[Curve] = field(default_factory=list)
    notes: list[Note] = field(default_factory=list)
    arrows: list[Arrow] = field(default_factory=list)
    xlim: Ends = (None, None)
    ylim: Ends = (None, None)
    log: bool = False
    xlog: bool = False
    ystep: float = 0.0  # in the unit shown, of which the distance of the ticks is a multiple
    cells: Cells | None = None
    caption: Sequence[str] = ()  # sentences below the figure

    def line(
        self, x: ArrayLike, y: ArrayLike, colour: str = BLUE, label: str = "", dash: str = "", width: float = 1.6
    ) -> None:
        """Add a polyline that breaks where a value is no number; infinite values reach the edge of the panel."""
        across, up = np.broadcast_arrays(np.asarray(x, float), np.asarray(y, float))
        self.curves.append(Curve(across, up, colour, label, dash, width))

    def points(
        self, x: ArrayLike, y: ArrayLike, colour: str, label: str = "", marker: str = "o", face: str = "#ffffff"
    ) -> None:
        """Add a row of markers, if there are any."""
        across, up = np.asarray(x, float), np.asarray(y, float)
        if len(across):
            self.curves.append(Curve(across, up, colour, label, marker=marker, face=face, width=1.1))

    def band(self, x: ArrayLike, low: ArrayLike, high: ArrayLike, colour: str, label: str = "") -> None:
        """Shade the area between two curves, behind everything else."""
        across, lower, upper = np.broadcast_arrays(*(np.asarray(v, float) for v in (x, low, high)))
        self.curves.insert(0, Curve(across, lower, colour, label, upper=upper))

    def level(self, y: float, colour: str, label: str = "", dash: str = "", width: float = 1.2) -> None:
        """Add a level line from edge to edge."""
        self.line([-np.inf, np.inf], [y, y], colour, label, dash, width)

    def upright(self, x: float, colour: str, label: str = "", dash: str = "", width: float = 1.2) -> None:
        """Add an upright line from edge to edge."""
        self.line([x, x], [-np.inf, np.inf], colour, label, dash, width)

    def arrow(self, x: float, start: float, end: float) -> None:
        """Add a dashed upright arrow."""
        self.arrows.append(Arrow(x, start, end))

    def note(self, x: float, y: float, text: str, above: bool = False) -> None:
        """Add a text beside a point, or above the panel."""
        self.notes.append(Note(x, y, text, above))

    def bars(
        self, x: ArrayLike, low: ArrayLike, high: ArrayLike, colour: str, label: str = "", width: float = 1.0
    ) -> None:
        """Add upright lines between values."""
        uprights, bottom, top = np.broadcast_arrays(*(np.asarray(v, float) for v in (x, low, high)))
        gap = np.full(uprights.shape, np.nan)
        across, up = np.stack([uprights, uprights, gap], -1).ravel(), np.stack([bottom, top, gap], -1).ravel()
        self.line(across, up, colour, label, width=width)

    def parted(
        self,
        x: Floats,
        y: Floats,
        stable: Any,
        colour: str = BLUE,
        label: str = "",
        names: tuple[str, str] = ("", ", unstable"),
        widths: tuple[float, float] = (1.6, 1.6),
        dashes: tuple[str, str] = ("", DASHES),
        keep: Any = True,
    ) -> None:
        """Add a curve along its arc, stable and unstable parts apart; each ends at the first point of the next."""
        kind = np.where(keep, np.where(stable, 0, 1), 2)
        for a, b in pairwise([0, *(np.flatnonzero(np.diff(kind)) + 1).tolist(), len(kind)]):
            if b > a and kind[a] < 2:
                look = int(kind[a])
                name = label and label + names[look]
                self.line(x[a : b + 1], y[a : b + 1], colour, name, dashes[look], widths[look])

    def share(self, values: Floats, colour: str, label: str = "", dash: str = "") -> None:
        """Add the cumulative distribution of values: the share [%] of all that is below each finite one."""
        good = np.sort(values[np.isfinite(values)])
        share = 100.0 * np.arange(1, len(good) + 1) / len(values)
        self.line(np.repeat(good, 2), [0.0, *np.repeat(share, 2)[:-1]], colour, label, dash, 1.8)

    def fit(self, spread: float = 30.0, room: float = 1.08) -> None:
        """Scale the upright axis from zero, or logarithmically where heights in `xlim` differ over `spread` times."""
        low = -np.inf if self.xlim[0] is None else self.xlim[0]
        high = np.inf if self.xlim[1] is None else self.xlim[1]
        inside = [c.y[np.isfinite(c.y) & ((c.x >= low) & (c.x <= high) | np.isinf(c.x))] for c in self.curves]
        heights = np.concatenate([np.zeros(1), *inside])
        positive = heights[heights > 0.0]
        self.log = len(positive) > 0 and bool(np.max(positive) > spread * np.min(positive))
        self.ylim = (None, None) if self.log else (0.0, room * float(np.max(heights)) or 1.0)

    def scales(self) -> tuple[tuple[float, float, bool], tuple[float, float, bool]]:
        """Ends of both axes, those given or the reach of the curves with a margin, and whether each is logarithmic."""
        across, up = [c.x for c in self.curves], [v for c in self.curves for v in (c.y, c.upper) if v is not None]
        if self.cells is not None:
            across, up = [*across, self.cells.x], [*up, self.cells.y]
        return _scale(across, self.xlim, self.xlog), _scale(up, self.ylim, self.log)

    @property
    def empty(self) -> bool:
        """True for a panel that shows nothing."""
        drawn = (np.any(np.isfinite(c.x)) and np.any(np.isfinite(c.y)) for c in self.curves)
        return self.cells is None and not any(drawn)


def _scale(values: list[Floats], limits: Ends, log: bool) -> tuple[float, float, bool]:
    finite = np.concatenate([np.empty(0), *values])
    finite = finite[np.isfinite(finite)]
    log = log and bool(np.any(finite > 0.0)) and (limits[0] is None or limits[0] > 0.0)
    finite = np.log(finite[finite > 0.0]) if log else finite
    low, high = (float(np.min(finite)), float(np.max(finite))) if len(finite) else (0.0, 1.0)
    pad = 0.05 * (high - low) or 0.05 * abs(high) or 1.0
    ends = [float(np.exp(end)) if log else float(end) for end in (low - pad, high + pad)]
    low = ends[0] if limits[0] is None else limits[0]
    high = ends[1] if limits[1] is None else limits[1]
    return low, high, log


def placed_above(
    notes: Sequence[Note], positions: Floats, width: float, letter: float
) -> Iterator[tuple[str, float, int]]:
    """Texts above a panel of a width, with their middles and rows, as far as they do not meet; all in one unit."""
    ends = [-letter] * ROWS
    for note, position in zip(notes, positions, strict=True):
        half = 0.5 * letter * len(note.text)
        middle = min(max(float(position), half), width - half)
        row = next((row for row in range(ROWS) if middle - half >= ends[row] + letter), None)
        if row is not None and -1.0 < position < width + 1.0:
            ends[row] = middle + half
            yield note.text, middle, row


def bode_pair(title: str, size: Axis, ends: tuple[float, float]) -> tuple[Panel, Panel]:
    """Magnitude and phase over frequencies between two ends [rad/s]."""
    phase = Panel("", HERTZ, Axis("phase", "deg"), xlim=ends, xlog=True, ystep=90.0)
    return Panel(title, HERTZ, size, xlim=ends, xlog=True), phase


@singledispatch
def panels_of(result: object) -> list[Panel]:
    """Panels of the figure of a result, from top to bottom; none where nothing is drawn of it."""
    for load in above("figure_loaders")():  # where one is drawn: they know all studies
        load()
        function = panels_of.dispatch(type(result))
        if function is not panels_of.dispatch(object):
            return list(function(result))
    return []
