"""Figures of single resonances: the computed response, multiple scales and integration over it; parts of figures.

Colours are those of `plots`; stable parts are full lines, unstable ones dashed. The speed axis names its shaft.

The figure of one speed in time. A response curve with more points, for figures: between those computed its harmonics
follow a smooth curve.
"""

from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...base.results import Floats
from ...drive.project import Project
from ...drive.response import ExactResponse
from ...numerics.balance.fourier import synthesis, to_blocks
from ...study.analysis.in_time import Cycle, TimeCase
from ...study.analysis.in_time.drive_motion import DriveMotion
from ...study.analysis.resonances import Regime
from ..console import number
from ..view import AngleUnit, View
from .svg import Curve, Note, Panel, figure

HEIGHT = 330.0

BLUE, ORANGE, BLACK, GREY = "#0072B2", "#D55E00", "#222222", "#777777"
DASHES, DOT_DASH = "6 3", "8 3 2 3"
BINS, MOST_CYCLES = 350, 40
ACROSS = 1500  # bins across a panel: of more samples the smallest and the largest in each are drawn

PARTS, SAMPLES = 5, 128  # of each step, and of the period of the highest harmonic
SHORTEST = 1e-9  # step along the arc, of the curve's extent


def fine(response: ExactResponse) -> ExactResponse:
    """Draw a curve with cubics between its points.

    Speed and harmonics are smooth along the arc where the largest |x| has corners, so they are what is interpolated.
    Computed points stay what they are.
    """
    curve = response.curve
    if len(curve) < 3:
        return response
    speed, size = np.ptp(curve.omega), np.max(np.ptp(curve.coefficients, axis=0))
    if not (speed > 0.0 and size > 0.0):
        return response
    found = _between(np.column_stack([curve.omega / speed, curve.coefficients / size])) * np.array(
        [speed, *[size] * curve.coefficients.shape[1]]
    )
    found[::PARTS] = np.column_stack([curve.omega, curve.coefficients])
    series = to_blocks(found[:, 1:].T).T
    peak = np.max(np.abs(series @ synthesis(series.shape[1] // 2, SAMPLES * (series.shape[1] // 2))), axis=1)
    peak[::PARTS] = curve.peak
    own = np.arange(len(found)) // PARTS  # a step is drawn as its first point is
    drawn = replace(
        curve, values=found[:, 0], omega=found[:, 0], coefficients=found[:, 1:], peak=peak,
        multipliers=curve.multipliers[own], stable=curve.stable[own],
    )  # fmt: skip
    return replace(response, curve=drawn)


def _between(points: Floats) -> Floats:
    """Points (rows) with others between them, evenly along the chord."""
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    place = np.concatenate([[0.0], np.cumsum(np.maximum(steps, SHORTEST))])
    h, rise = np.diff(place)[:, None], np.diff(points, axis=0)
    slope = rise / h
    # Tangents of the cubic spline: its curvature has no jumps; at the ends those of parabolas through three points.
    matrix, right = np.eye(len(points)), np.empty_like(points)
    i = np.arange(1, len(points) - 1)
    matrix[i, i - 1], matrix[i, i], matrix[i, i + 1] = h[1:, 0], 2.0 * (h[1:, 0] + h[:-1, 0]), h[:-1, 0]
    right[i] = 3.0 * (h[1:] * slope[:-1] + h[:-1] * slope[1:])
    right[0] = slope[0] - h[0] * (slope[1] - slope[0]) / (h[0] + h[1])
    right[-1] = slope[-1] + h[-1] * (slope[-1] - slope[-2]) / (h[-1] + h[-2])
    tangents = np.linalg.solve(matrix, right)
    s = (np.arange(PARTS) / PARTS)[:, None]
    start, end = (h * tangents[:-1] - rise)[:, None], (h * tangents[1:] - rise)[:, None]
    among = points[:-1, None] + s * (rise[:, None] + (1.0 - s) * (start * (1.0 - s) - end * s))
    return np.concatenate([among.reshape(-1, points.shape[1]), points[-1:]])


def time_figure(case: TimeCase, angle: AngleUnit, drive: DriveMotion | None = None) -> str:
    """One speed in time as SVG: from rest, the steady motion, its phase portrait, and the transmitted torque.

    Beside those of the error equation the steady motion and the torque of the whole drive, where it is given.
    """
    rest = _from_rest(case, angle)
    label = f"time response, {case.name}"
    if case.cycle is None:
        return figure([[rest]], 260.0, label)
    shown = 2 if case.steady.period == 1 else 1
    steady, orbit = _steady(case, case.cycle, shown, angle), _orbit(case, case.cycle, shown, angle)
    if drive is not None:
        count = 1 + shown * case.steady.period * drive.per_turn
        name = f"whole drive, {drive.name}"
        steady.line(1e3 * drive.t[:count], drive.error[:count] * angle.factor, BLACK, name, DOT_DASH)
        orbit[-1].line(1e3 * drive.t[:count], drive.torque[:count], BLACK, "whole drive", DOT_DASH)
    return figure([[rest, steady], orbit], 228.0, label)


def _from_rest(case: TimeCase, angle: AngleUnit) -> Panel:
    """The start: both solutions as lines, or the band between their extremes where cycles would not show."""
    run = case.transient
    seconds, name = (1.0, "s") if run.t[-1] > 0.5 else (1e3, "ms")
    title = f"from rest, largest |x| {angle.text(case.peak_from_rest)}"
    panel = Panel(title, f"time ({name})", f"x ({angle.name})")
    theory = None if case.comparison is None else case.comparison.theory
    crossings = np.count_nonzero(np.diff(np.sign(run.y[0] - np.mean(run.y[0]))))
    if crossings < 2 * MOST_CYCLES:
        panel.line(run.t * seconds, run.y[0] * angle.factor, BLUE, "integration", width=1.2)
        if theory is not None:
            panel.line(theory.t * seconds, theory.x * angle.factor, ORANGE, "multiple scales", DASHES, 1.3)
        return panel
    turns = max(12, int(run.t[-1] * case.omega / (2.0 * np.pi)))
    low, high, t = envelope(run.t * seconds, run.y[0] * angle.factor, _even(len(run.t), turns))
    panel.curves.append(Curve(t, low, BLUE, "integration (band of its cycles)", upper=high))
    if theory is not None:
        low, high, t = envelope(theory.t * seconds, theory.x * angle.factor, _even(len(theory.t), turns))
        panel.line(t, high, ORANGE, "multiple scales", DASHES, 1.3)
        panel.line(t, low, ORANGE, "multiple scales", DASHES, 1.3)
    return panel


def _even(count: int, pieces: int) -> NDArray[np.int64]:
    """First numbers of equal pieces of a row, at most `BINS`."""
    return np.linspace(0, count, min(BINS, pieces), endpoint=False).astype(np.int64)


def _steady(case: TimeCase, cycle: Cycle, shown: int, angle: AngleUnit) -> Panel:
    panel = Panel("steady motion", "time (ms)", f"x ({angle.name})")
    t = _repeated_time(cycle, shown)
    panel.line(t, np.tile(cycle.x, shown) * angle.factor, BLUE, "integration")
    if case.steady_theory is not None:
        panel.line(t, np.tile(case.steady_theory, shown) * angle.factor, ORANGE, "multiple scales", DASHES, 1.3)
    return panel


def _orbit(case: TimeCase, cycle: Cycle, shown: int, angle: AngleUnit) -> list[Panel]:
    """Phase portrait and transmitted torque."""
    unit, rate = ("rad/s", 1.0) if np.max(np.abs(cycle.v)) > 1.0 else ("mrad/s", 1e3)
    portrait = Panel("phase portrait of the steady motion", f"x ({angle.name})", f"x' ({unit})")
    portrait.line(cycle.x * angle.factor, cycle.v * rate, BLUE, "integration")
    each = (len(cycle.x) - 1) // case.steady.period
    once = (cycle.x[:-1:each] * angle.factor, cycle.v[:-1:each] * rate)
    portrait.points(*once, BLACK, "once per turn of the base angle", "o", ORANGE)
    torque = Panel(
        f"steady torque through the gear, largest {number(cycle.peak_torque)} N·m", "time (ms)", "torque (N·m)"
    )
    torque.line(_repeated_time(cycle, shown), np.tile(cycle.torque, shown), BLUE, "integration")
    mean = cycle.mean_torque if abs(cycle.mean_torque) > 1e-6 * cycle.peak_torque else 0.0
    torque.line([-np.inf, np.inf], [mean, mean], BLACK, f"mean torque {number(mean)} N·m", DOT_DASH, 1.0)
    return [portrait, torque]


def _repeated_time(cycle: Cycle, shown: int) -> Floats:
    """Times [ms] of the cycle shown so many times."""
    return np.concatenate([cycle.t + i * cycle.t[-1] for i in range(shown)]) * 1e3


def envelope(t: Floats, x: Floats, starts: NDArray[np.int64]) -> tuple[Floats, Floats, Floats]:
    """Lowest and highest value in each piece that begins with a sample of `starts`, and where: its middle, or the end.

    Of more than `BINS` pieces neighbours are taken together.
    """
    starts = starts[:: -(-len(starts) // BINS)]
    low, high = np.minimum.reduceat(x, starts), np.maximum.reduceat(x, starts)
    at = np.add.reduceat(t, starts) / np.diff([*starts, len(t)])
    at[0], at[-1] = t[0], t[-1]
    return low, high, at


def thin(t: Floats, y: Floats) -> tuple[Floats, Floats]:
    """The samples, or of many the smallest and the largest of each bin."""
    if len(t) <= 4 * ACROSS:
        return t, y
    each = -(-len(t) // ACROSS)
    bins = -(-len(t) // each)
    rows = np.append(y, np.full(bins * each - len(y), y[-1])).reshape(bins, each)
    first = each * np.arange(bins)
    keep = np.unique(np.concatenate([first + np.argmin(rows, 1), first + np.argmax(rows, 1), [len(t) - 1]]))
    keep = keep[keep < len(t)]
    return t[keep], y[keep]


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
