"""The figure of a log: every channel over the time, its segments shaded and named."""

from collections.abc import Sequence

import numpy as np

from ....base.results import Floats
from ....study.identification.log import Log, LogSegment
from ..curves import BLUE, thin
from ..svg import LEFT, LETTER, RIGHT, WIDTH, Curve, Note, Panel, figure

HEIGHT = 165.0  # of a panel [px]
# Light to dark also without colour; constant speed, of which there is most, is left white.
SHADES = {"still": "#e8e8e8", "run-up": "#9ecae1", "run-down": "#fdae6b", "other": "#909090"}
ROWS = 2  # of names above a panel


def log_figure(log: Log, segments: Sequence[LogSegment]) -> str:
    """Draw a log as SVG, one panel a channel."""
    panels = [_panel(log, name, segments) for name in log.channels]
    if panels:
        panels[0].notes += _names(log, segments)
        panels[-1].xlabel = "time (s)"
    return figure([[panel] for panel in panels], HEIGHT, "a log over the time")


def _panel(log: Log, name: str, segments: Sequence[LogSegment]) -> Panel:
    values = log.channels[name]
    low, high = float(np.min(values)), float(np.max(values))
    pad = 0.06 * (high - low) or 0.05 * abs(high) or 1.0
    unit = log.units[name].replace("*", "·")
    panel = Panel("", "", name.replace("_", " ") + (f"\n({unit})" if unit else ""))
    panel.xlim, panel.ylim = (float(log.time[0]), float(log.time[-1])), (low - pad, high + pad)
    for part in segments:
        if part.kind in SHADES:
            ends = np.array([part.start, part.stop])
            bottom, top = (np.full(2, level) for level in panel.ylim)
            panel.curves.append(Curve(ends, bottom, SHADES[part.kind], part.kind, upper=top))
    for rows in log.unbroken():
        panel.line(*thin(log.time[rows], values[rows]), BLUE, width=1.2)
    return panel


def _names(log: Log, segments: Sequence[LogSegment]) -> list[Note]:
    """Names of the segments above the first panel, as far as they do not meet."""
    across = WIDTH - LEFT - RIGHT
    scale: Floats = (log.time[-1] - log.time[0]) / across
    ends = [0.0] * ROWS
    notes = []
    for part in segments:
        text = (
            f"{part.kind}, {part.speed:.3g} rad/s".replace("-0", "−0") if part.kind == "constant speed" else part.kind
        )
        half = 0.5 * LETTER * len(text)
        at = min(max((0.5 * (part.start + part.stop) - log.time[0]) / scale, half), across - half)
        row = next((row for row in range(ROWS) if at - half >= ends[row]), None)
        if row is not None:
            ends[row] = at + half + LETTER
            notes.append(Note(float(log.time[0] + at * scale), float(row), text, above=True))
    return notes
