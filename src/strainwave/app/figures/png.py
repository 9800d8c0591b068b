"""A panel of `svg` as a PNG file, drawn by matplotlib, for slides and word processors."""

from importlib.util import find_spec
from pathlib import Path
from textwrap import wrap
from typing import Any

import numpy as np

from .svg import LINE, Panel

INCHES, DOTS = (7.6, 4.2), 200


def check() -> None:
    """Refuse (RuntimeError) where there is no matplotlib, before anything is computed."""
    if find_spec("matplotlib") is None:
        raise RuntimeError("a PNG needs matplotlib; pip install 'strainwave[plot]', or write .svg")


def write(panel: Panel, path: Path) -> None:
    """Write one panel of lines and markers with its legend; errors as `check`."""
    check()
    from matplotlib.figure import Figure

    figure = Figure(figsize=INCHES, layout="constrained")
    axes = figure.add_subplot(xlabel=panel.xlabel, ylabel=panel.ylabel, title=panel.title)
    axes.grid(color="#dddddd")
    names = {""}
    for curve in panel.curves:
        look: dict[str, Any] = {"color": curve.colour, "lw": curve.width, "marker": curve.marker or None}
        look |= {"mfc": curve.face or None, "ls": "none" if curve.marker else _dashes(curve.dash)}
        ends = np.isinf(curve.y)
        if np.any(ends):
            axes.axvline(curve.x[0], **look, label="_" if curve.label in names else curve.label)
        else:
            axes.plot(curve.x, curve.y, **look, label="_" if curve.label in names else curve.label)
        names.add(curve.label)
    for note in panel.notes:
        where: Any = axes.get_xaxis_transform() if note.above else "data"
        axes.annotate(f" {note.text}", (note.x, 1.02 if note.above else note.y), xycoords=where, fontsize=8)
    for arrow in panel.arrows:
        axes.annotate("", (arrow.x, arrow.end), (arrow.x, arrow.start), arrowprops={"arrowstyle": "->", "ls": "--"})
    xlim, ylim = panel.limits()
    axes.set(xlim=xlim, ylim=ylim, yscale="log" if panel.log else "linear")
    axes.legend(fontsize=8, frameon=False)
    if panel.caption:
        figure.supxlabel(
            "\n".join(line for text in panel.caption for line in wrap(text, LINE)), fontsize=7, x=0.02, ha="left"
        )
    figure.savefig(path, dpi=DOTS)


def _dashes(dash: str) -> Any:
    return (0, tuple(float(part) for part in dash.split())) if dash else "-"
