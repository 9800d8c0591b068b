"""Figures over speed: the computed response with stability, folds and jumps, multiple scales and integration over it.

Colours are those of `plots`; stable parts are full lines, unstable ones dashed. The speed axis names its shaft.
"""

from itertools import pairwise
from typing import Any

import numpy as np

from ...files.project import Project
from ...results import Floats
from ...study.analysis.runup import RunUp
from ...study.response.resonances import Regime
from ...study.response.response import ExactResponse
from ..console import BETWEEN
from ..units import AngleUnit
from ..view import View
from .fine_curve import fine
from .plots import BLACK, BLUE, DASHES, DOT_DASH, GREY, ORANGE
from .svg import Arrow, Note, Panel, figure

HEIGHT = 330.0


def speed_axis(project: Project) -> tuple[str, float]:
    """Label and factor of the speed axis: motor rpm, or rad/s where the base angle is a forcing phase."""
    return f"{project.speeds.name} ({project.speeds.unit})", project.speeds.scale


def range_panel(
    project: Project, angle: AngleUnit, exact: ExactResponse, regimes: tuple[Regime, ...], run: RunUp | None = None
) -> Panel:
    """Largest error through the speed range: exact, by multiple scales, and simulated up and down."""
    curve, factor, speeds = fine(exact).curve, angle.factor, project.speeds.limits
    label, scale = speed_axis(project)
    low, high = scale * speeds[0], scale * speeds[1]
    margin = 0.02 * (high - low)
    panel = Panel("", label, f"largest |x| {BETWEEN}\n({angle.name})", xlim=(low - margin, high + margin))
    _exact(panel, exact.method, scale * curve.omega, factor * curve.peak, curve.stable)
    if exact.back is not None:
        panel.line(scale * exact.back.omega, factor * exact.back.peak, BLUE, "run-down by integration", DOT_DASH)
    for regime in regimes:
        for branch in regime.response.branches if regime.response else ():
            shown = _within(branch.omega, *speeds)
            for keep, dash in ((branch.stable, ""), (~branch.stable, DASHES)):
                _runs(panel, scale * branch.omega, factor * branch.peak, keep & shown, ORANGE, "multiple scales", dash)
    for motions, marker in ((run.up, "^"), (run.down, "v")) if run is not None else ():
        good = [m for m in motions if m.status]
        _simulated(panel, [scale * m.omega for m in good], [factor * m.peak for m in good], marker)
    _folds(panel, [fold.omega for fold in curve.folds], [fold.peak for fold in curve.folds], scale, factor)
    jumps = (*exact.sweep.on_run_up, *exact.sweep.on_run_down) if exact.sweep else ()
    panel.arrows += [Arrow(scale * j.value, factor * j.before, factor * j.after) for j in jumps]
    heights = np.concatenate([c.y for c in panel.curves])
    panel.log = bool(np.max(heights) > 30.0 * np.min(heights) > 0.0)
    if not panel.log:
        panel.ylim = (0.0, 1.05 * float(np.max(heights)))
    _mark_resonances(panel, regimes, scale, 0.03 * (high - low), named=run is None)
    gear = project.gear
    limit = gear.max_rpm if gear is not None and project.speeds.by_motor else None
    if limit is not None and limit <= 1.05 * high:
        _upright(panel, limit, BLACK, "2 2", 1.6, f"largest input speed, {limit:.0f} rpm")
    return panel


def report_panel(view: View) -> Panel:
    """`range_panel` of a report: of the whole train, with the error equation over it, where there is a curve of it."""
    (project, analysis, angle), regimes = view, view.analysis.regimes
    if analysis.train_curve is None:
        return range_panel(project, angle, analysis.exact, regimes, analysis.run_up)
    panel = range_panel(project, angle, analysis.response, ())
    exact = fine(analysis.exact).curve
    x, y = view.speeds.scale * exact.omega, angle.factor * exact.peak
    panel.line(x, y, BLACK, "error equation, a reduction", DOT_DASH, 1.3)
    top = max(float(np.max(y)), angle.factor * float(np.max(analysis.response.curve.peak)))
    panel.ylim = None if panel.log else (0.0, 1.05 * top)
    return panel


def speed_range(panel: Panel) -> str:
    """`range_panel` as SVG."""
    return figure([[panel]], HEIGHT, "largest error against speed")


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
        _exact(panel, near.method, scale * exact.omega, factor * amplitude, exact.stable, keep)
        folds = [fold.omega for fold in exact.folds if low <= fold.omega <= high]
        _folds(panel, folds, [float(amplitude[exact.omega == omega][0]) for omega in folds], scale, factor)
    for branch in curve.branches:
        x, y = scale * branch.omega, factor * branch.amplitude
        _runs(panel, x, y, branch.stable, ORANGE, "multiple scales, stable", "")
        _runs(panel, x, y, ~branch.stable, ORANGE, "multiple scales, unstable", DASHES)
    if regime.backbone is not None:
        panel.line(
            scale * regime.backbone[0], factor * regime.backbone[1], GREY, "free vibration (backbone)", DOT_DASH, 1.2
        )
    ratio = float(regime.resonance.ratio or 1)
    for motions, marker in ((analysis.run_up.up, "^"), (analysis.run_up.down, "v")):
        good = [m for m in motions if m.status and low <= m.omega <= high and abs(ratio * m.period % 1.0) < 1e-9]
        _simulated(panel, [scale * m.omega for m in good], [factor * m.torsion_amplitude(ratio) for m in good], marker)
    panel.ylim = (0.0, 1.08 * factor * top)
    return figure([[panel]], HEIGHT, f"response curve, {regime.label}")


def _within(omega: Floats, low: float, high: float) -> Any:
    return (omega >= low * (1.0 - 1e-12)) & (omega <= high * (1.0 + 1e-12))


def _exact(panel: Panel, method: str, x: Floats, y: Floats, stable: Any, keep: Any = True) -> None:
    _runs(panel, x, y, stable & keep, BLUE, f"{method}, stable", "", 2.2)
    _runs(panel, x, y, ~stable & keep, BLUE, f"{method}, unstable", DASHES, 1.9)


def _runs(panel: Panel, x: Floats, y: Floats, keep: Any, colour: str, name: str, dash: str, width: float = 1.4) -> None:
    """The kept runs of an arc, each one point longer so that the line does not break."""
    cuts = [0, *(np.flatnonzero(np.diff(keep.astype(int))) + 1), len(keep)]
    for a, b in pairwise(cuts):
        if b > a and keep[a]:
            panel.line(x[a : b + 1], y[a : b + 1], colour, name, dash, width)


def _simulated(panel: Panel, x: list[float], y: list[float], marker: str) -> None:
    if x:
        name, face = ("run-up (integration)", BLACK) if marker == "^" else ("run-down (integration)", "#ffffff")
        panel.points(x, y, BLACK, name, marker, face)


def _folds(panel: Panel, folds: list[float], heights: list[float], scale: float, factor: float) -> None:
    """Rings at the folds with their speeds."""
    x, y = [scale * omega for omega in folds], [factor * height for height in heights]
    if folds:
        panel.points(x, y, BLUE, "fold (jump)", "o", "#ffffff")
    panel.notes += [Note(u, v, f"{u:.5g}") for u, v in zip(x, y, strict=True)]


def _upright(panel: Panel, at: float, colour: str, dash: str, width: float, name: str = "") -> None:
    panel.line([at, at], [0.0 if panel.log else -np.inf, np.inf], colour, name, dash, width)


def _mark_resonances(panel: Panel, regimes: tuple[Regime, ...], scale: float, close: float, named: bool) -> None:
    """Thin lines at the resonances in the range, numbered as in the table; `named` in the legend of a lone figure."""
    last, level = -np.inf, 0
    for i, regime in enumerate(regimes, 1):
        if regime.inside:
            at = scale * regime.place
            level = (level + 1) % 3 if at - last < close else 0
            last = at
            _upright(panel, at, GREY, "5 4", 0.9, f"{i}: {regime.label}" if named else "")
            panel.notes.append(Note(at, level, str(i), above=True))
