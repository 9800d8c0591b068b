"""Figures of single resonances and of single speeds in time: the computed motion, multiple scales and integration."""

import numpy as np
from numpy.typing import NDArray

from ..base.results import Floats
from ..base.sentences import number
from ..plot.colours import BLACK, BLUE, DASHES, DOT_DASH, GREY, ORANGE
from ..plot.drive import draw_exact, draw_folds, fine, of_speeds, simulated
from ..plot.panels import TIME, Axis, Panel
from ..plot.svg import figure
from ..study.analysis.in_time import DriveMotion
from ..study.analysis.resonances import Regime
from ..study.analysis.time_case import Cycle, TimeCase
from .view import AngleUnit, View

HEIGHT = 330.0
BINS, MOST_CYCLES = 350, 40
MILLISECONDS = Axis("time", "ms", 1e-3)


def time_figure(case: TimeCase, angle: AngleUnit, drive: DriveMotion | None = None) -> str:
    """One speed in time as SVG: from rest, the steady motion, its phase portrait, and the transmitted torque.

    Beside those of the error equation the steady motion and the torque of the whole drive, where it is given.
    """
    start = _from_rest(case, angle)
    label = f"time response, {case.name}"
    if case.cycle is None:
        return figure([[start]], 260.0, label)
    times = 2 if case.steady.period == 1 else 1
    steady, orbit = _steady(case, case.cycle, times, angle), _orbit(case, case.cycle, times, angle)
    if drive is not None:
        count = 1 + times * case.steady.period * drive.per_turn
        name = f"whole drive, {drive.name}"
        steady.line(drive.t[:count], drive.error[:count], BLACK, name, DOT_DASH)
        orbit[-1].line(drive.t[:count], drive.torque[:count], BLACK, "whole drive", DOT_DASH)
    return figure([[start, steady], orbit], 228.0, label)


def _from_rest(case: TimeCase, angle: AngleUnit) -> Panel:
    """The start: both solutions as lines, or the band between their extremes where cycles would not show."""
    run = case.transient
    title = f"from rest, largest |x| {angle.text(case.peak_from_rest)}"
    panel = Panel(title, TIME if run.t[-1] > 0.5 else MILLISECONDS, angle.axis("x"))
    theory = None if case.comparison is None else case.comparison.theory
    crossings = np.count_nonzero(np.diff(np.sign(run.y[0] - np.mean(run.y[0]))))
    if crossings < 2 * MOST_CYCLES:
        panel.line(run.t, run.y[0], BLUE, "integration", width=1.2)
        if theory is not None:
            panel.line(theory.t, theory.x, ORANGE, "multiple scales", DASHES, 1.3)
        return panel
    turns = max(12, int(run.t[-1] * case.omega / (2.0 * np.pi)))
    low, high, t = envelope(run.t, run.y[0], _even(len(run.t), turns))
    panel.band(t, low, high, BLUE, "integration (band of its cycles)")
    if theory is not None:
        low, high, t = envelope(theory.t, theory.x, _even(len(theory.t), turns))
        panel.line(t, high, ORANGE, "multiple scales", DASHES, 1.3)
        panel.line(t, low, ORANGE, "multiple scales", DASHES, 1.3)
    return panel


def _even(count: int, pieces: int) -> NDArray[np.int64]:
    """First numbers of equal pieces of a row, at most `BINS`, none of them empty."""
    return np.linspace(0, count, min(BINS, pieces, count), endpoint=False).astype(np.int64)


def _steady(case: TimeCase, cycle: Cycle, times: int, angle: AngleUnit) -> Panel:
    panel = Panel("steady motion", MILLISECONDS, angle.axis("x"))
    t = _repeated_time(cycle, times)
    panel.line(t, np.tile(cycle.x, times), BLUE, "integration")
    if case.steady_theory is not None:
        panel.line(t, np.tile(case.steady_theory, times), ORANGE, "multiple scales", DASHES, 1.3)
    return panel


def _orbit(case: TimeCase, cycle: Cycle, times: int, angle: AngleUnit) -> list[Panel]:
    """Phase portrait and transmitted torque."""
    rate = Axis("x'", "rad/s") if np.max(np.abs(cycle.v)) > 1.0 else Axis("x'", "mrad/s", 1e-3)
    portrait = Panel("phase portrait of the steady motion", angle.axis("x"), rate)
    portrait.line(cycle.x, cycle.v, BLUE, "integration")
    samples = (len(cycle.x) - 1) // case.steady.period
    portrait.points(cycle.x[:-1:samples], cycle.v[:-1:samples], BLACK, "once per turn of the base angle", "o", ORANGE)
    title = f"steady torque through the gear, largest {number(cycle.peak_torque)} N·m"
    torque = Panel(title, MILLISECONDS, Axis("torque", "N*m"))
    torque.line(_repeated_time(cycle, times), np.tile(cycle.torque, times), BLUE, "integration")
    mean = cycle.mean_torque if abs(cycle.mean_torque) > 1e-6 * cycle.peak_torque else 0.0
    torque.level(mean, BLACK, f"mean torque {number(mean)} N·m", DOT_DASH, 1.0)
    return [portrait, torque]


def _repeated_time(cycle: Cycle, times: int) -> Floats:
    """Times of the cycle shown so many times."""
    return np.concatenate([cycle.t + i * cycle.t[-1] for i in range(times)])


def envelope(t: Floats, x: Floats, starts: NDArray[np.int64]) -> tuple[Floats, Floats, Floats]:
    """Lowest and highest value in each piece that begins with a sample of `starts`, and where: its middle, or the end.

    Of more than `BINS` pieces neighbours are taken together.
    """
    starts = starts[:: -(-len(starts) // BINS)]
    low, high = np.minimum.reduceat(x, starts), np.maximum.reduceat(x, starts)
    at = np.add.reduceat(t, starts) / np.diff([*starts, len(t)])
    at[0], at[-1] = t[0], t[-1]
    return low, high, at


def response(view: View, regime: Regime) -> str:
    """One resonance as SVG: the torsion's component near omega_0, exact, by multiple scales, and simulated."""
    curve = regime.response
    if curve is None or not curve.branches:
        raise ValueError(f"the {regime.label} resonance has no response curve")
    analysis, speeds = view.analysis, view.speeds
    low, high = regime.band()
    p, q = regime.resonance
    turning = speeds.name.removeprefix("forcing frequency ")
    place = turning if regime.resonance.ratio == 1 else f"{regime.resonance.ratio} × {turning}"
    panel = Panel("", of_speeds(speeds), view.angle.axis(f"torsion amplitude at {place}"), xlim=(low, high))
    top = curve.peak[1]
    if q == 1:
        near = fine(analysis.close.get(regime.resonance, analysis.exact))
        exact = near.curve
        keep = (exact.omega >= low * (1.0 - 1e-12)) & (exact.omega <= high * (1.0 + 1e-12))
        amplitude = near.torsion_amplitude(analysis.system, p)
        top = max(top, float(np.max(amplitude[keep], initial=0.0)))
        draw_exact(panel, near.method, exact.omega, amplitude, exact.stable, keep)
        folds = [fold.omega for fold in exact.folds if low <= fold.omega <= high]
        draw_folds(panel, folds, [float(amplitude[exact.omega == omega][0]) for omega in folds])
    for branch in curve.branches:
        names = (", stable", ", unstable")
        panel.parted(branch.omega, branch.amplitude, branch.stable, ORANGE, "multiple scales", names, (1.4, 1.4))
    if regime.backbone is not None:
        panel.line(regime.backbone[0], regime.backbone[1], GREY, "free vibration (backbone)", DOT_DASH, 1.2)
    ratio = float(regime.resonance.ratio or 1)
    for motions, marker in ((analysis.run_up.up, "^"), (analysis.run_up.down, "v")):
        good = [m for m in motions if m.status and low <= m.omega <= high and abs(ratio * m.period % 1.0) < 1e-9]
        simulated(panel, [m.omega for m in good], [m.torsion_amplitude(ratio) for m in good], marker)
    panel.ylim = (0.0, 1.08 * top)
    return figure([[panel]], HEIGHT, f"response curve, {regime.label}")
