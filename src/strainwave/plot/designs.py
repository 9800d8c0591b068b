"""Figures of designs, and of the gains of a motor's loop."""

import numpy as np

from ..study.design.result import Design
from ..study.tuning.cost import GOALS
from ..study.tuning.result import TunedLoop
from . import panels
from .panels import BLACK, BLUE, DOTS, GREY, ORANGE, Axis, Panel, angle, panels_of

SIZES = (("o", BLUE), ("^", ORANGE), ("v", BLACK))
HEADROOM = 1.25


@panels_of.register
def design_panels(design: Design) -> list[Panel]:
    """Feasible designs: oscillation over reflected inertia, a marker for each size, names on the Pareto front."""
    limit = design.specification.limit
    inertia = Axis("motor inertia with wave generator, at the load", "kg*m**2")
    panel = Panel("feasible designs", inertia, angle("oscillation", limit))
    panel.level(limit, BLACK, "limit", DOTS, 1.4)
    panel.caption = ["Labelled designs: no other design is better in oscillation, size and inertia."]
    if not design.feasible:
        return [panel]
    for i, size in enumerate(sorted({c.size for c in design.feasible})):
        marker, colour = SIZES[i % len(SIZES)]
        x, y = np.transpose([(c.reflected_inertia, c.oscillation) for c in design.feasible if c.size == size])
        panel.points(x, y, colour, f"size {size}", marker, ("#ffffff", colour)[i // len(SIZES) % 2])
    across, up = np.transpose([(c.reflected_inertia, c.oscillation) for c in design.feasible])
    panel.xlog = bool(across.max() > 5.0 * across.min())
    panel.xlim = (across.min() / HEADROOM, across.max() * HEADROOM**2)
    panel.ylim = (up.min() - 0.15 * (limit - up.min()) - 1e-9 * limit, limit + 0.1 * (limit - up.min()) + 1e-9 * limit)
    first = {c.gear: c for c in reversed(design.pareto)}
    for gear, c in first.items():
        panel.note(c.reflected_inertia, c.oscillation, gear)
    return [panel]


@panels_of.register
def tuning_panels(tuning: TunedLoop) -> list[Panel]:
    """Nonlinear response before and after, and what the first goal costs in peak sensitivity."""
    named = ((tuning.response_before, GREY, "present gains"), (tuning.response_after, BLUE, "recommended gains"))
    drawn = [(response, colour, name) for response, colour, name in named if response is not None]
    largest = [float(np.max(response.oscillation)) for response, _, _ in drawn]
    size = angle("oscillation of the error", largest)
    swept = Panel("Under the load with the largest oscillation", panels.MOTOR, size)
    for response, colour, name in drawn:
        swept.parted(response.omega, response.oscillation, response.stable, colour, name)
    swept.fit()
    goal, points, best = GOALS[tuning.goals[0]], tuning.front, tuning.recommended
    values = [p.goals[0] for p in points]
    y = angle(goal.words, values) if goal.key.endswith("arcsec") else Axis(goal.words)
    front = Panel("Best gains for each peak sensitivity", Axis("peak sensitivity"), y)
    front.points([p.figures.peak_sensitivity for p in points], values, BLUE, "tried")
    front.points([best.figures.peak_sensitivity], [best.goals[0]], ORANGE, "recommended", "s", ORANGE)
    return [swept, front]
