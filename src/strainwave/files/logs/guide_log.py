"""Guide logs of PHD2: the error of a mount in right ascension, in the longest guided stretch, over its axis' angle."""

import re
from importlib import import_module
from io import StringIO
from math import pi
from typing import Any

import numpy as np

from ...base.number_text import counted

GUIDE = "PHD2 version"
SIDEREAL = 2.0 * pi / 86_164.0905  # rad/s of the axis
FRAME = re.compile(r"\d+,[\d.]+,")
SCALE = re.compile(r"Pixel scale = ([\d.]+) arc-sec/px")


def guide_table(text: str) -> tuple[list[tuple[str, str, Any]], list[str], list[int]] | None:
    """Columns (name, unit, values), notes and line numbers of the longest guided stretch of a log; None without one.

    Pulses have moved the mount: what they took out is put back.
    """
    lines, stretches = text.splitlines(), list[tuple[float | None, str, list[int]]]()
    scale = None
    for i, line in enumerate(lines):
        if match := SCALE.search(line):
            scale = float(match.group(1))
        elif line.startswith("Frame,Time,"):
            stretches.append((scale, line, []))
        elif stretches and FRAME.match(line):
            stretches[-1][2].append(i)
        elif line.startswith("Guiding Ends") and stretches:
            stretches.append((scale, stretches[-1][1], []))
    scale, header, frames = max(stretches, key=lambda one: len(one[2]), default=(None, "", []))
    if len(frames) < 2:
        return None
    frame = import_module("pandas").read_csv(StringIO("\n".join([header, *(lines[i] for i in frames)])))
    seen = np.flatnonzero(np.isfinite(frame["RARawDistance"]))
    raw, guided = frame["RARawDistance"].to_numpy(float)[seen], frame["RAGuideDistance"].fillna(0.0).to_numpy(float)
    error, time = raw + (np.cumsum(guided) - guided)[seen], frame["Time"].to_numpy(float)[seen]
    notes = [
        f"{counted(len(seen), 'frame')} of the longest guided stretch were read; the angle assumes sidereal speed, "
        "86164.09 s per turn"
    ]
    if scale is None:
        notes.append("the log has no pixel scale: its errors are in pixels, and 1 px counts as 1 arcsec")
    if np.any(guided):
        notes.append("the corrections by guider pulses were reversed; corrections without pulses are unknown")
    columns = [("time", "s", time), ("angle", "rad", SIDEREAL * time), ("error", "arcsec", (scale or 1.0) * error)]
    return columns, notes, [frames[i] + 1 for i in seen]
