"""Panels of `svg` as a PNG file, drawn by matplotlib, for slides and word processors."""

from collections.abc import Sequence
from importlib.util import find_spec
from pathlib import Path
from textwrap import wrap
from typing import Any

import numpy as np

from .svg import LINE, Panel

WIDTH, HEIGHT, DOTS = 7.6, 3.4, 200  # of a panel [inch]


def check() -> None:
    """Refuse (RuntimeError) where there is no matplotlib, before anything is computed."""
    if find_spec("matplotlib") is None:
        raise RuntimeError("a PNG needs matplotlib; pip install 'strainwave[plot]', or write .svg")


def write(panels: Sequence[Panel], path: Path) -> None:
    """Write panels of lines, bands and markers below each other, with one legend; errors as `check`."""
    check()
    from matplotlib.figure import Figure

    figure = Figure(figsize=(WIDTH, HEIGHT * len(panels)), layout="constrained")
    rows = figure.subplots(len(panels), 1, squeeze=False)[:, 0]
    entries: dict[str, Any] = {}
    for axes, panel in zip(rows, panels, strict=True):
        _draw(axes, panel, entries)
    said = [line for panel in panels for text in panel.caption for line in wrap(text, LINE)]
    figure.legend(entries.values(), entries.keys(), loc="outside upper center", fontsize=8, frameon=False, ncols=2)
    if said:
        figure.supxlabel("\n".join(said), fontsize=7, x=0.02, ha="left")
    figure.savefig(path, dpi=DOTS)


def _draw(axes: Any, panel: Panel, entries: dict[str, Any]) -> None:
    """Draw one panel, and add what its legend needs to the entries."""
    axes.set(xlabel=panel.xlabel, ylabel=panel.ylabel, title=panel.title)
    axes.grid(color="#dddddd")
    for curve in panel.curves:
        look: dict[str, Any] = {"color": curve.colour, "lw": curve.width, "marker": curve.marker or None}
        look |= {"mfc": curve.face or None, "ls": "none" if curve.marker else _dashes(curve.dash)}
        if curve.upper is not None:
            drawn = axes.fill_between(curve.x, curve.y, curve.upper, color=curve.colour, alpha=0.6, lw=0.0)
        elif np.any(np.isinf(curve.x)):
            drawn = axes.axhline(curve.y[0], **look)
        elif np.any(np.isinf(curve.y)):
            drawn = axes.axvline(curve.x[0], **look)
        else:
            (drawn,) = axes.plot(curve.x, curve.y, **look)
        if curve.label:
            entries.setdefault(curve.label, drawn)
    for note in panel.notes:
        where: Any = axes.get_xaxis_transform() if note.above else "data"
        axes.annotate(f" {note.text}", (note.x, 1.02 if note.above else note.y), xycoords=where, fontsize=8)
    for arrow in panel.arrows:
        axes.annotate("", (arrow.x, arrow.end), (arrow.x, arrow.start), arrowprops={"arrowstyle": "->", "ls": "--"})
    xlim, ylim = panel.limits()
    axes.set(xlim=xlim, ylim=ylim, yscale="log" if panel.log else "linear")


def _dashes(dash: str) -> Any:
    return (0, tuple(float(part) for part in dash.split())) if dash else "-"
