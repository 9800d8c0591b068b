"""Panels on axes of matplotlib (extra `plot`), and as a PNG file for slides and word processors."""

from collections.abc import Sequence
from importlib.util import find_spec
from pathlib import Path
from textwrap import wrap
from typing import Any

import numpy as np

from ..base.protocols import need
from ..base.quantities import shown
from .panels import Curve, Panel, panels_of, placed_above
from .svg import LINE, log_ticks

WIDTH, HEIGHT, DOTS = 7.6, 3.4, 200  # of a panel [inch], and dots an inch
LETTERS, BELOW = 44, 0.45  # of the name of an upright axis, and distance of a legend below the axes [inch]
ENTRIES, NAME_LETTERS = 6, 36  # names of a legend that stands in the panel, and letters of one
LEGEND_POINTS = 2000  # points of a panel from which on the best place of a legend takes too long


def draw(result: object, axes: Any = None) -> Any:
    """Draw a result on axes of matplotlib.

    Parameters
    ----------
    result : Branch, Orbit, Trajectory, DriveRun, ...
        It has `panels()`, or a function for its class is registered with `plot.panels_of`.
    axes : matplotlib Axes, optional
        Several panels share the place of these axes. Default: axes of a new figure.

    Returns
    -------
    matplotlib Axes
        The axes of the upper panel, for titles and for `axes.figure.savefig(...)`.

    Raises
    ------
    TypeError
        If there is no figure of such a result.
    ModuleNotFoundError
        If axes are to be made and matplotlib is missing.
    """
    if axes is not None:
        need("axes", axes, "set", "plot", remedy=" of matplotlib")
    method = None if isinstance(result, type) else getattr(result, "panels", None)
    panels = panels_of(result) if method is None else method()
    if not panels:
        drawable = ", ".join(cls.__name__ for cls in panels_of.registry if cls is not object)
        raise TypeError(f"there is no figure of {shown(result)}; there is one of each of {drawable}")
    if axes is None:
        try:
            from matplotlib import pyplot
        except ModuleNotFoundError:
            raise ModuleNotFoundError("figures need the extra `plot`: pip install 'strainwave[plot]'") from None
        size = (WIDTH, max(4.8, 2.4 * len(panels)))
        axes = pyplot.subplots(figsize=size if len(panels) > 1 else None, layout="constrained")[1]
    _draw_all(axes, panels)
    return axes


def _draw_all(axes: Any, panels: Sequence[Panel]) -> None:
    """Draw panels below each other in the area of the axes, with one legend."""
    named: dict[str, Any] = {}
    stack = _stacked_axes(axes, len(panels))
    for each, panel in zip(stack, panels, strict=True):
        _draw(each, panel, named, LETTERS // len(panels))
    for each, panel, following in zip(stack, panels, panels[1:], strict=False):
        each.tick_params(labelbottom=following.x != panel.x)
        each.xaxis.label.set_visible(following.x != panel.x)
    if named:
        _legend(stack[-1], named, panels)


def _legend(axes: Any, named: dict[str, Any], panels: Sequence[Panel]) -> None:
    """Add a legend: in a single panel if it has few names, otherwise below all panels."""
    look: dict[str, Any] = {"fontsize": 8, "frameon": False}
    if len(panels) == 1 and panels[0].cells is None and len(named) <= ENTRIES and max(map(len, named)) <= NAME_LETTERS:
        points = sum(len(curve.x) for curve in panels[0].curves)
        axes.legend(loc="best" if points < LEGEND_POINTS else "upper right", **look)
        return
    from matplotlib.transforms import ScaledTranslation

    below = axes.transAxes + ScaledTranslation(0.0, -BELOW, axes.figure.dpi_scale_trans)
    look |= {"loc": "upper center", "bbox_to_anchor": (0.5, 0.0), "bbox_transform": below, "ncols": 2}
    axes.legend(named.values(), named.keys(), **look)


def _stacked_axes(axes: Any, count: int) -> list[Any]:
    """Axes below each other in the area of those given, which are the upper ones, over the same x."""
    if count == 1:
        return [axes]
    spec = axes.get_subplotspec()
    if spec is not None:
        grid = spec.subgridspec(count, 1, hspace=0.02 if axes.figure.get_layout_engine() else 0.35)
        axes.set_subplotspec(grid[0])
        return [axes, *(axes.figure.add_subplot(grid[i], sharex=axes) for i in range(1, count))]
    left, bottom, width, height = axes.get_position().bounds
    panel_height = height / count
    boxes = [(left, bottom + (count - 1 - i) * panel_height, width, 0.75 * panel_height) for i in range(count)]
    axes.set_position(boxes[0])
    return [axes, *(axes.figure.add_axes(box, sharex=axes) for box in boxes[1:])]


def check() -> None:
    """Refuse (RuntimeError) where there is no matplotlib, before anything is computed."""
    if find_spec("matplotlib") is None:
        raise RuntimeError("a PNG needs matplotlib; pip install 'strainwave[plot]', or write .svg")


def write(panels: Sequence[Panel], path: Path) -> None:
    """Write panels below each other, with one legend, as a PNG file; errors as `check`."""
    check()
    from matplotlib.figure import Figure

    figure = Figure(figsize=(WIDTH, HEIGHT * len(panels)), layout="constrained")
    _draw_all(figure.add_subplot(), panels)
    for axes in figure.axes:
        axes.grid(color="#dddddd")
    if caption := [line for panel in panels for text in panel.caption for line in wrap(text, LINE)]:
        figure.supxlabel("\n".join(caption), fontsize=7, x=0.02, ha="left")
    figure.savefig(path, dpi=DOTS)


def _draw(axes: Any, panel: Panel, named: dict[str, Any], letters: int) -> None:
    """Draw one panel, in the units of its axes, and add new entries of the legend to the names."""
    (left, right, xlog), (bottom, top, ylog) = panel.scales()
    across, up = panel.x.size, panel.y.size
    axes.set(xlabel=panel.x, ylabel="\n".join(panel.y.lines(letters)), title=panel.title)
    for curve in panel.curves:
        artist = _curve(axes, curve, across, up, curve.label if curve.label not in named else "")
        if curve.label:
            named.setdefault(curve.label, artist)
    if panel.cells is not None:
        from matplotlib.colors import ListedColormap

        shade = np.ma.masked_less(panel.cells.shade, 0)
        colours = ListedColormap(panel.cells.colours)
        ends = {"vmin": -0.5, "vmax": len(panel.cells.colours) - 0.5, "rasterized": True, "zorder": 0.5}
        axes.pcolormesh(panel.cells.x / across, panel.cells.y / up, shade, cmap=colours, **ends)
    for note in panel.notes:
        if not note.above:
            axes.annotate(f" {note.text}", (note.x / across, note.y / up), fontsize=8)
    for arrow in panel.arrows:
        end, start = (arrow.x / across, arrow.end / up), (arrow.x / across, arrow.start / up)
        axes.annotate("", end, start, arrowprops={"arrowstyle": "->", "ls": "--"})
    axes.set(xlim=(left / across, right / across), ylim=(bottom / up, top / up))
    for axis, name, log in ((axes.xaxis, "x", xlog), (axes.yaxis, "y", ylog)):
        axes.set(**{f"{name}scale": "log" if log else "linear"})
        if log:
            axis.set_ticks(*log_ticks(*axis.get_view_interval()))
            axis.set_ticks([], minor=True)
    headings = [note for note in panel.notes if note.above]
    width = axes.get_window_extent().width * 72.0 / axes.figure.dpi
    places = width * (np.array([note.x for note in headings]) - left) / (right - left)
    for text, middle, row in placed_above(headings, places, width, 5.0):
        foot, shift = (middle / width, 1.0), (0, 3 + 9 * row)
        axes.annotate(text, foot, shift, "axes fraction", "offset points", fontsize=8, ha="center")


def _curve(axes: Any, curve: Curve, across: float, up: float, label: str) -> Any:
    x, y = curve.x / across, curve.y / up
    if curve.upper is not None:
        look: dict[str, Any] = {"color": curve.colour, "alpha": 0.45, "lw": 0.0, "label": label}
        if np.all(np.isinf(y)):
            return axes.axvspan(x[0], x[-1], **look)
        return axes.fill_between(x, y, curve.upper / up, **look)
    dashes = (0, tuple(float(part) / max(1.0, curve.width) for part in curve.dash.split())) if curve.dash else "-"
    look = {"color": curve.colour, "lw": curve.width, "ls": dashes, "label": label}
    if curve.marker:
        size = 4.0 if curve.marker == "." else 6.0
        look |= {"marker": curve.marker, "ms": size, "mfc": curve.face or None, "ls": "none"}
    elif np.any(np.isinf(x)):
        return axes.axhline(y[0], **look)
    elif np.any(np.isinf(y)):
        return axes.axvline(x[0], **look)
    return axes.plot(x, y, **look)[0]
