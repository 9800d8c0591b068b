"""The figure of one speed in time.

Colours are those of Okabe & Ito (colour-blind safe); every curve also differs by line style or marker.
"""

import numpy as np
from numpy.typing import NDArray

from ...results import Floats
from ...study.analysis.in_time import Cycle, TimeCase
from ...study.analysis.in_time.drive_motion import DriveMotion
from ..console import number
from ..units import AngleUnit
from .svg import Curve, Panel, figure

BLUE, ORANGE, BLACK, GREY = "#0072B2", "#D55E00", "#222222", "#777777"
DASHES, DOT_DASH = "6 3", "8 3 2 3"
BINS, MOST_CYCLES = 350, 40
ACROSS = 1500  # bins across a panel: of more samples the smallest and the largest in each are drawn


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
