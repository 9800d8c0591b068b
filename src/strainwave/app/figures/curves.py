"""Figures of single resonances: the computed response, multiple scales and integration over it; parts of figures.

Colours are those of `plots`; stable parts are full lines, unstable ones dashed. The speed axis names its shaft.
"""

from itertools import pairwise
from typing import Any

import numpy as np

from ...files.project import Project
from ...results import Floats
from ...study.response.resonances import Regime
from ..view import View
from .fine_curve import fine
from .plots import BLACK, BLUE, DASHES, DOT_DASH, GREY, ORANGE
from .svg import Note, Panel, figure

HEIGHT = 330.0


def speed_axis(project: Project) -> tuple[str, float]:
    """Label and factor of the speed axis: motor rpm, or rad/s where the base angle is a forcing phase."""
    return f"{project.speeds.name} ({project.speeds.unit})", project.speeds.scale


def response(view: View, regime: Regime) -> str:
    """One resonance as SVG: the torsion's component near omega_0, exact, by multiple scales, and simulated."""
    curve = regime.response
    if curve is None or not curve.branches:
        raise ValueError(f"the {regime.label} resonance has no response curve")
    (project, analysis, angle), (label, scale) = view, speed_axis(view.project)
    low, high = regime.band()
    p, q = regime.resonance
    turning = project.speeds.name.removeprefix("forcing frequency ")
    place = turning if regime.resonance.ratio == 1 else f"{regime.resonance.ratio} × {turning}"
    panel = Panel("", label, f"torsion amplitude at\n{place} ({angle.name})", xlim=(scale * low, scale * high))
    top, factor = curve.peak[1], angle.factor
    if q == 1:
        near = fine(analysis.close.get(regime.resonance, analysis.exact))
        exact = near.curve
        keep = _within(exact.omega, low, high)
        amplitude = near.torsion_amplitude(analysis.system, p)
        top = max(top, float(np.max(amplitude[keep], initial=0.0)))
        draw_exact(panel, near.method, scale * exact.omega, factor * amplitude, exact.stable, keep)
        folds = [fold.omega for fold in exact.folds if low <= fold.omega <= high]
        draw_folds(panel, folds, [factor * float(amplitude[exact.omega == omega][0]) for omega in folds], scale)
    for branch in curve.branches:
        x, y = scale * branch.omega, factor * branch.amplitude
        draw_motions(panel, x, y, branch.stable, ORANGE, "multiple scales, stable", "")
        draw_motions(panel, x, y, ~branch.stable, ORANGE, "multiple scales, unstable", DASHES)
    if regime.backbone is not None:
        panel.line(
            scale * regime.backbone[0], factor * regime.backbone[1], GREY, "free vibration (backbone)", DOT_DASH, 1.2
        )
    ratio = float(regime.resonance.ratio or 1)
    for motions, marker in ((analysis.run_up.up, "^"), (analysis.run_up.down, "v")):
        good = [m for m in motions if m.status and low <= m.omega <= high and abs(ratio * m.period % 1.0) < 1e-9]
        simulated(panel, [scale * m.omega for m in good], [factor * m.torsion_amplitude(ratio) for m in good], marker)
    panel.ylim = (0.0, 1.08 * factor * top)
    return figure([[panel]], HEIGHT, f"response curve, {regime.label}")


def _within(omega: Floats, low: float, high: float) -> Any:
    return (omega >= low * (1.0 - 1e-12)) & (omega <= high * (1.0 + 1e-12))


def draw_exact(panel: Panel, method: str, x: Floats, y: Floats, stable: Any, keep: Any = True) -> None:
    """A computed arc, its stable and its unstable parts."""
    draw_motions(panel, x, y, stable & keep, BLUE, f"{method}, stable", "", 2.2)
    draw_motions(panel, x, y, ~stable & keep, BLUE, f"{method}, unstable", DASHES, 1.9)


def draw_motions(
    panel: Panel, x: Floats, y: Floats, keep: Any, colour: str, name: str, dash: str, width: float = 1.4
) -> None:  # fmt: skip
    """The kept runs of an arc, each one point longer so that the line does not break."""
    cuts = [0, *(np.flatnonzero(np.diff(keep.astype(int))) + 1), len(keep)]
    for a, b in pairwise(cuts):
        if b > a and keep[a]:
            panel.line(x[a : b + 1], y[a : b + 1], colour, name, dash, width)


def simulated(panel: Panel, x: list[float], y: list[float], marker: str) -> None:
    """Markers of motions that were integrated, on a run-up or a run-down."""
    if x:
        name, face = ("run-up (integration)", BLACK) if marker == "^" else ("run-down (integration)", "#ffffff")
        panel.points(x, y, BLACK, name, marker, face)


def draw_folds(panel: Panel, folds: list[float], heights: list[float], scale: float) -> None:
    """Rings at the folds with their speeds."""
    x = [scale * omega for omega in folds]
    if folds:
        panel.points(x, heights, BLUE, "fold, where the curve turns", "o", "#ffffff")
    panel.notes += [Note(u, v, f"{u:.5g}") for u, v in zip(x, heights, strict=True)]


def upright(panel: Panel, at: float, colour: str, dash: str, width: float, name: str = "") -> None:
    """An upright line through the panel."""
    panel.line([at, at], [0.0 if panel.log else -np.inf, np.inf], colour, name, dash, width)


def mark_resonances(panel: Panel, regimes: tuple[Regime, ...], scale: float, close: float) -> None:
    """Thin lines at the resonances in the range, numbered as in the table."""
    last, level = -np.inf, 0
    for i, regime in enumerate(regimes, 1):
        if regime.inside:
            at = scale * regime.place
            level = (level + 1) % 3 if at - last < close else 0
            last = at
            upright(panel, at, GREY, "5 4", 0.9)
            panel.notes.append(Note(at, level, str(i), above=True))
