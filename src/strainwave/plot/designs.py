"""Designs on axes of matplotlib: oscillation over reflected inertia, each size with its own marker."""

from typing import Any

import numpy as np

from ..study.design.result import Design
from ..units import ARCSEC

MARKERS = "o^vsDPX*"


def draw_design(axes: Any, found: Design) -> None:
    """Draw the designs that serve: oscillation over the inertia of motor and wave generator at the load.

    Those of the Pareto front are filled; the limit is a dashed line.

    Parameters
    ----------
    axes : matplotlib Axes
        Where to draw; matplotlib is in the extra `plot`.
    found : Design
        Without a feasible design the limit alone is drawn.
    """
    best = set(found.pareto)
    for i, size in enumerate(sorted({c.size for c in found.feasible})):
        marker = MARKERS[i % len(MARKERS)]
        chosen = [c for c in found.feasible if c.size == size]
        x, y = np.array([(c.reflected_inertia, c.oscillation / ARCSEC) for c in chosen]).T
        filled = np.array([c in best for c in chosen])
        axes.plot(x, y, marker, mfc="none", mec="C0", label=f"size {size}")
        axes.plot(x[filled], y[filled], marker, mfc="C0", mec="C0")
    for c in found.pareto:
        place = c.reflected_inertia, c.oscillation / ARCSEC
        axes.annotate(c.gear, place, (0, -8), textcoords="offset points", fontsize=8, ha="center", va="top")
    axes.axhline(found.specification.limit / ARCSEC, color="0.4", ls="--", lw=1.0, label="limit")
    axes.set(xlabel="motor and wave generator at the load (kg m²)", ylabel="oscillation (arcsec)")
    low, high = axes.get_ylim()
    axes.set_ylim(low - 0.06 * (high - low), high + 0.06 * (high - low))
    axes.legend(fontsize=8, title="filled: Pareto front", title_fontsize=8)
