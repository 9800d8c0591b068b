"""The figure of a design: oscillation over reflected inertia, every size with its own marker, the front with names."""

import numpy as np

from ...base.results import Floats
from ...study.design.result import Candidate, Design
from ..view import angle_unit
from .curves import BLACK, BLUE, ORANGE
from .svg import Note, Panel, figure

WIDTH, HEIGHT = 430.0, 360.0  # narrow, so that its text is read on a telephone too
MARKERS = (("o", BLUE), ("^", ORANGE), ("v", BLACK))
HEADROOM = 1.25


def design_figure(found: Design) -> str:
    """Draw the feasible designs of an answer as SVG."""
    unit = angle_unit(found.specification.limit)
    panel = Panel("designs that serve", "motor and wave generator at the load (kg·m²)", f"oscillation ({unit.name})")
    sizes = sorted({c.size for c in found.feasible})
    for i, size in enumerate(sizes):
        marker, colour = MARKERS[i % len(MARKERS)]
        face = "#ffffff" if (i // len(MARKERS)) % 2 == 0 else colour
        chosen = [c for c in found.feasible if c.size == size]
        panel.points(*_places(chosen, unit.factor), colour, f"size {size}", marker, face)
    limit = unit.factor * found.specification.limit
    x, y = _places(list(found.feasible), unit.factor)
    panel.xlog = bool(x.max() > 5.0 * x.min())
    panel.xlim = (x.min() / HEADROOM, x.max() * HEADROOM**2)
    panel.line(panel.xlim, [limit, limit], BLACK, "limit", "2 2", 1.4)
    low = y.min()
    panel.ylim = (low - 0.15 * (limit - low) - 1e-9 * limit, limit + 0.1 * (limit - low) + 1e-9 * limit)
    named: set[str] = set()
    for c in found.pareto:
        if c.gear not in named:
            panel.notes.append(Note(c.reflected_inertia, unit.factor * c.oscillation, c.gear))
            named.add(c.gear)
    panel.caption = ["Named: no other is better in oscillation, size and inertia at once."]
    return figure([[panel]], HEIGHT, "designs that serve, oscillation over inertia", WIDTH)


def _places(candidates: list[Candidate], factor: float) -> tuple[Floats, Floats]:
    x = np.array([c.reflected_inertia for c in candidates])
    return x, factor * np.array([c.oscillation for c in candidates])
