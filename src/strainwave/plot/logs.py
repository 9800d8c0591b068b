"""Logs on axes of matplotlib: every channel over the time, its segments shaded and named."""

from typing import Any

from ..study.identification.logs.log import Log
from .ensembles import STRONG

# Constant speed, of which there is most, is left white.
SHADES = {"still": "0.93", "run-up": "#c5e0ef", "run-down": "#fdd7b5", "other": "0.75"}


def draw_log(axes: Any, found: Log) -> None:
    """Draw a log, its channels one below the other.

    Parameters
    ----------
    axes : matplotlib Axes
        Where to draw; all channels share its place.
    found : Log
        Its segments are shaded, where it has an angle or a speed.
    """
    figure, (left, bottom, width, height) = axes.figure, axes.get_position().bounds
    each = height / len(found.channels)
    parts = found.segments() if found.moving else ()
    for i, (name, values) in enumerate(found.channels.items()):
        place = (left, bottom + height - (i + 1) * each, width, 0.74 * each)
        below = axes if i == 0 else figure.add_axes(place, sharex=axes)
        if i == 0:
            figure.set_layout_engine("none")
            axes.set_position(place)
        for part in parts:
            if part.kind in SHADES:
                below.axvspan(part.start, part.stop, color=SHADES[part.kind], lw=0.0)
        for rows in found.unbroken():
            below.plot(found.time[rows], values[rows], color=STRONG[0], lw=0.8)
        below.set_title(name.replace("_", " "), loc="left", fontsize=8, pad=2.0)
        below.set(xlabel="t (s)", ylabel=found.units[name].replace("*", "·") or "–", xlim=found.time[[0, -1]])
        last = i + 1 == len(found.channels)
        below.tick_params(labelbottom=last, labelsize=8)
        below.xaxis.label.set_visible(last)
    named: set[str] = set()
    for part in parts:
        if part.kind in SHADES and part.kind not in named:
            named.add(part.kind)
            axes.fill_between([], [], color=SHADES[part.kind], label=part.kind)
    if named:
        axes.legend(fontsize=7, frameon=False, ncols=len(named), loc="lower right", bbox_to_anchor=(1.0, 1.0))
