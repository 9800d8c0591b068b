"""Figures over speed: the exact response with stability, folds and jumps, multiple scales and integration over it.

Colours are those of `plots`; stable parts are full lines, unstable ones dashed. Amplitudes are 0-to-peak; the speed
axis names its shaft.
"""

from itertools import pairwise
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from ..results import Floats
from ..study.analysis import Analysis
from ..study.exact import ExactResponse
from ..study.regimes import Regime
from ..study.runup import RunUp
from .facts import RPM
from .plots import BLACK, BLUE, GREY, ORANGE, angle_unit
from .project import Project

# Place of the axes in the figure, fixed: measuring every label twice would take as long as drawing.
WIDE = (0.115, 0.3, 0.865, 0.62)
DASHES = (0, (4, 2))


def speed_axis(project: Project) -> tuple[str, float]:
    """Label and factor of the speed axis: motor rpm, or rad/s where the base angle is a forcing phase."""
    return ("forcing frequency ω (rad/s)", 1.0) if project.shaft == "forcing" else ("motor speed (rpm)", RPM)


def speed_range(
    project: Project, exact: ExactResponse, regimes: tuple[Regime, ...], speeds: tuple[float, float], run: RunUp | None
) -> Figure:
    """Largest error through the speed range: exact, by multiple scales, and simulated up and down."""
    curve = exact.curve
    tops = [float(np.max(curve.peak))] if len(curve) else []
    tops += [m.peak for m in (*run.up, *run.down) if m.status] if run else []
    unit, factor = angle_unit(max(tops))
    label, scale = speed_axis(project)
    figure = Figure(figsize=(7.2, 3.6))
    axes = figure.add_axes(WIDE)
    _exact_line(axes, scale * curve.omega, factor * curve.peak, curve.stable)
    first = True
    for regime in regimes:
        for branch in regime.response.branches if regime.response else ():
            shown = _within(branch.omega, *speeds)
            name = "multiple scales" if first else None
            _line(axes, scale * branch.omega, factor * branch.peak, branch.stable & shown, ORANGE, "-", name, 1.1)
            _line(axes, scale * branch.omega, factor * branch.peak, ~branch.stable & shown, ORANGE, DASHES, None, 1.1)
            first = False
    if run is not None:
        for motions, marker, name in (
            (run.up, "^", "run-up (integration)"),
            (run.down, "v", "coast-down (integration)"),
        ):
            good = [m for m in motions if m.status]
            _points(axes, [scale * m.omega for m in good], [factor * m.peak for m in good], marker, name)
    _folds(axes, [fold.omega for fold in curve.folds], [fold.peak for fold in curve.folds], scale, factor)
    _jumps(axes, exact, scale, factor)
    visible = factor * np.concatenate([curve.peak[_within(curve.omega, *speeds)], tops])
    if np.max(visible) > 30.0 * np.min(visible) > 0.0:
        axes.set_yscale("log")
    else:
        axes.set_ylim(bottom=0.0)
    _mark_resonances(axes, regimes, speeds, scale)
    gear = project.gear
    if gear is not None and project.shaft != "forcing" and gear.max_rpm <= 1.05 * scale * speeds[1]:
        axes.axvline(
            gear.max_rpm, color=BLACK, lw=1.2, ls=(0, (1, 1)), label=f"largest input speed, {gear.max_rpm:.0f} rpm"
        )
    axes.set_xlabel(label)
    axes.set_ylabel(f"largest |x| at the load\n({unit}, 0-to-peak)")
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.17), ncols=3)
    return figure


def _within(omega: Floats, low: float, high: float) -> Any:
    return (omega >= low * (1.0 - 1e-12)) & (omega <= high * (1.0 + 1e-12))


def _line(axes: Any, x: Floats, y: Floats, keep: Any, colour: str, style: Any, name: str | None, width: float) -> None:
    """The kept runs of an arc, each one point longer so that the line does not break."""
    cuts = [0, *(np.flatnonzero(np.diff(keep.astype(int))) + 1), len(keep)]
    for a, b in pairwise(cuts):
        if keep[a]:
            axes.plot(x[a : b + 1], y[a : b + 1], color=colour, ls=style, lw=width, label=name)
            name = None


def _exact_line(axes: Any, x: Floats, y: Floats, stable: Any) -> None:
    if len(x):
        _line(axes, x, y, stable, BLUE, "-", "harmonic balance, stable", 1.8)
        _line(axes, x, y, ~stable, BLUE, DASHES, "harmonic balance, unstable", 1.5)


def _points(axes: Any, x: list[float], y: list[float], marker: str, name: str) -> None:
    if x:
        face = BLACK if marker == "^" else "white"
        axes.plot(x, y, marker, color=BLACK, mfc=face, ms=5.5, ls="none", label=name, zorder=4)


def _folds(axes: Any, folds: list[float], heights: list[float], scale: float, factor: float) -> None:
    """Rings at the folds with their speeds."""
    for omega, height in zip(folds, heights, strict=True):
        at = (scale * omega, factor * height)
        axes.plot(*at, "o", mfc="white", mec=BLUE, ms=6, zorder=5)
        axes.annotate(
            f"{scale * omega:.5g}", at, xytext=(7, 0), textcoords="offset points", fontsize=8, va="center", zorder=6,
            bbox={"fc": "white", "ec": "none", "pad": 0.8, "alpha": 0.8},
        )  # fmt: skip
    if folds:
        axes.plot([], [], "o", mfc="white", mec=BLUE, ms=6, ls="none", label="fold (jump)")


def _jumps(axes: Any, exact: ExactResponse, scale: float, factor: float) -> None:
    """Arrows from the fold to where the drive lands."""
    for jump in (*exact.sweep.on_run_up, *exact.sweep.on_run_down) if exact.sweep else ():
        at = scale * jump.value
        axes.annotate(
            "", (at, factor * jump.after), (at, factor * jump.before), zorder=3,
            arrowprops={"arrowstyle": "->", "color": GREY, "lw": 1.0, "ls": (0, (2, 2)), "shrinkA": 4, "shrinkB": 0},
        )  # fmt: skip


def _mark_resonances(axes: Any, regimes: tuple[Regime, ...], speeds: tuple[float, float], scale: float) -> None:
    """Thin lines at the resonances in the range, numbered as in the table."""
    inside = [(i, r) for i, r in enumerate(regimes, 1) if r.inside]
    low, high = scale * speeds[0], scale * speeds[1]
    axes.set_xlim(low - 0.02 * (high - low), high + 0.02 * (high - low))
    last, level = -np.inf, 0
    for i, regime in inside:
        at = scale * regime.omega
        level = (level + 1) % 3 if at - last < 0.03 * (high - low) else 0
        last = at
        axes.axvline(at, color=GREY, lw=0.7, ls=(0, (4, 3)), zorder=0)
        axes.annotate(
            f"{i}", (at, 1.0), xycoords=axes.get_xaxis_transform(), xytext=(0, 2 + 9 * level),
            textcoords="offset points", ha="center", va="bottom", fontsize=8, color=BLACK,
        )  # fmt: skip


def response(project: Project, analysis: Analysis, regime: Regime) -> Figure:
    """One resonance: the torsion's component near omega_0, exact, by multiple scales with backbone, and simulated."""
    curve = regime.response
    if curve is None or not curve.branches:
        raise ValueError(f"the {regime.label} resonance has no response curve")
    label, scale = speed_axis(project)
    unit, factor = angle_unit(curve.peak[1])
    figure = Figure(figsize=(7.2, 3.6))
    axes = figure.add_axes(WIDE)
    low, high = regime.band()
    p, q = regime.resonance
    top = curve.peak[1]
    if q == 1:
        near = analysis.close.get(regime.resonance, analysis.exact)
        exact = near.curve
        keep = _within(exact.omega, low, high)
        amplitude = near.torsion_amplitude(analysis.system, p)
        top = max(top, float(np.max(amplitude[keep], initial=0.0)))
        x, y = scale * exact.omega, factor * amplitude
        _line(axes, x, y, exact.stable & keep, BLUE, "-", "harmonic balance, stable", 1.8)
        _line(axes, x, y, ~exact.stable & keep, BLUE, DASHES, "harmonic balance, unstable", 1.5)
        folds = [fold.omega for fold in exact.folds if low <= fold.omega <= high]
        _folds(axes, folds, [float(amplitude[exact.omega == omega][0]) for omega in folds], scale, factor)
    name = "multiple scales"
    for branch in curve.branches:
        x, y = scale * branch.omega, factor * branch.amplitude
        _line(axes, x, y, branch.stable, ORANGE, "-", f"{name}, stable", 1.2)
        _line(axes, x, y, ~branch.stable, ORANGE, DASHES, f"{name}, unstable", 1.2)
        name = "_" + name.lstrip("_")
    if regime.backbone is not None:
        axes.plot(
            scale * regime.backbone[0], factor * regime.backbone[1], color=GREY, ls="-.", lw=1.0, label="backbone"
        )
    _simulated(axes, analysis, regime, (low, high), scale, factor)
    axes.set_xlim(scale * low, scale * high)
    axes.set_ylim(0.0, 1.08 * factor * top)
    turning = "ω" if project.shaft == "forcing" else "motor speed"
    place = turning if regime.resonance.ratio == 1 else f"{regime.resonance.ratio} × {turning}"
    axes.set_xlabel(label)
    axes.set_ylabel(f"torsion amplitude at\n{place} ({unit}, 0-to-peak)")
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.17), ncols=3)
    return figure


def _simulated(
    axes: Any, analysis: Analysis, regime: Regime, band: tuple[float, float], scale: float, factor: float
) -> None:
    """Points of the run-up and coast-down inside the band: the component that the curve shows."""
    ratio, run = float(regime.resonance.ratio or 1), analysis.run_up
    for motions, marker, name in ((run.up, "^", "run-up (integration)"), (run.down, "v", "coast-down (integration)")):
        good = [m for m in motions if m.status and band[0] <= m.omega <= band[1] and abs(ratio * m.period % 1.0) < 1e-9]
        _points(
            axes, [scale * m.omega for m in good], [factor * m.torsion_amplitude(ratio) for m in good], marker, name
        )
