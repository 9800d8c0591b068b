"""The main figure: oscillation of the error of a drive and torque in its gear against speed.

The mean of the error, its static wind-up, is left out: it is told beside the figure. Colours are those of `plots`;
stable parts are full lines, unstable ones dashed.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...base.results import Floats
from ...drive.drive_response import DriveResponse
from ...drive.project import Project
from ...drive.response import ExactResponse
from ...study.analysis.analysis import Analysis
from ...study.analysis.avoid import Avoid
from ...study.analysis.load_cases import LoadCase
from ...study.analysis.resonances import Regime
from ...study.analysis.runup import RunUp
from ..console import number
from ..view import AngleUnit
from .curves import (
    BLACK,
    BLUE,
    DASHES,
    DOT_DASH,
    ORANGE,
    draw_folds,
    draw_motions,
    fine,
    mark_resonances,
    simulated,
    speed_axis,
    upright,
)
from .svg import Arrow, Curve, Panel

SHADE = "#d9d9d9"  # speeds to avoid
HEADROOM, HEIGHT = 1.08, 290.0  # of a panel
NEAR = 2.0  # times the largest torque: limits up to there are drawn
FAR = 3.0  # times the largest oscillation of the drive: the error equation is drawn up to there


class Drawn(NamedTuple):
    """What the figure has beside the curve of the drive: nothing of it where there is no analysis."""

    cases: tuple[LoadCase, ...] = ()
    avoid: Avoid | None = None
    run: RunUp | None = None
    reduced: ExactResponse | None = None
    regimes: tuple[Regime, ...] = ()


def of_analysis(analysis: Analysis) -> Drawn:
    """The same curve under other torques of the load, speeds to avoid, and what checks it or is compared with it."""
    cases, whole = analysis.load_cases, analysis.train_curve is not None
    if whole:
        return Drawn(cases, analysis.avoid, None, analysis.exact)
    return Drawn(cases, analysis.avoid, analysis.run_up, None, analysis.regimes)


def panels(project: Project, angle: AngleUnit, drive: DriveResponse, more: Drawn) -> list[Panel]:
    """Oscillation of the error above, the largest torque in the gear below, over the same speeds."""
    label, scale = speed_axis(project)
    low, high = (scale * omega for omega in project.speeds.limits)
    margin = 0.02 * (high - low)
    ends = low - margin, high + margin
    above = Panel("", label, f"oscillation of\nthe {drive.name} ({angle.name})", xlim=ends)
    below = Panel("", label, "largest torque in\nthe gear (N·m)", xlim=ends)
    _error(above, project, angle, drive, more, scale)
    _torque(below, project, drive, more, scale)
    for panel in (above, below):
        heights = np.concatenate([c.y[np.isfinite(c.y) & _inside(c.x, ends)] for c in panel.curves])
        positive = heights[heights > 0.0]
        panel.log = len(positive) > 0 and float(np.max(positive)) > 30.0 * float(np.min(positive))
        panel.ylim = None if panel.log else (0.0, HEADROOM * float(np.max(heights)))
        _shade(panel, more.avoid, scale)
    mark_resonances(above, more.regimes, scale, 0.03 * (high - low))
    return [above, below]


def _inside(x: Floats, ends: tuple[float, float]) -> NDArray[np.bool_]:
    return np.asarray(((x >= ends[0]) & (x <= ends[1])) | np.isinf(x))


def shows_reduced(drive: DriveResponse, more: Drawn) -> bool:
    """Whether the error equation is drawn beside the whole drive, whose own curve it would flatten if it were far."""
    if more.reduced is None or not len(more.reduced.curve):
        return False
    largest = (np.max(fine(response).curve.oscillation) for response in (more.reduced, drive.response))
    return bool(next(largest) <= FAR * next(largest))


def _error(
    panel: Panel, project: Project, angle: AngleUnit, drive: DriveResponse, more: Drawn, scale: float
) -> None:  # fmt: skip
    factor, smooth = angle.factor, fine(drive.response)
    for case in more.cases:
        near = fine(case.drive.response)
        name = f"load torque {number(more.cases[0].torque)} to {number(more.cases[-1].torque)} N·m"
        x, y = scale * near.curve.omega, factor * near.curve.oscillation
        draw_motions(panel, x, y, near.curve.stable, ORANGE, name, "", 1.0)
    curve, sizes = smooth.curve, factor * smooth.curve.oscillation
    name = smooth.method + (f" at {number(project.mean_load_torque)} N·m" if more.cases else "")
    draw_motions(panel, scale * curve.omega, sizes, curve.stable, BLUE, f"{name}, stable", "", 2.2)
    draw_motions(panel, scale * curve.omega, sizes, ~curve.stable, BLUE, f"{name}, unstable", DASHES, 1.9)
    if more.reduced is not None and shows_reduced(drive, more):
        other = fine(more.reduced).curve
        panel.line(scale * other.omega, factor * other.oscillation, BLACK, "error equation, a reduction", DOT_DASH, 1.3)
    for motions, marker in ((more.run.up, "^"), (more.run.down, "v")) if more.run is not None else ():
        good = [m for m in motions if m.status]
        heights = [factor * float(np.max(np.abs(m.x - np.mean(m.x[:-1])))) for m in good]
        simulated(panel, [scale * m.omega for m in good], heights, marker)
    own, omega = factor * drive.oscillation, drive.omega
    folds = [(fold.omega, float(own[np.argmin(np.abs(omega - fold.omega))])) for fold in drive.folds]
    draw_folds(panel, [w for w, _ in folds], [y for _, y in folds], scale)
    sweep = drive.response.sweep
    for jump in (*sweep.on_run_up, *sweep.on_run_down) if sweep else ():
        before, after = (own[_nearest(drive, jump.value, peak)] for peak in (jump.before, jump.after))
        panel.arrows.append(Arrow(scale * jump.value, float(before), float(after)))
    if project.limit is not None:
        panel.line([-np.inf, np.inf], [factor * project.limit] * 2, BLACK, "limit of the project", "2 2", 1.6)
    gear = project.gear
    limit = gear.max_rpm if gear is not None and project.speeds.by_motor else None
    if gear is not None and limit is not None and limit <= 1.05 * scale * project.speeds.limits[1]:
        upright(panel, limit, BLACK, "2 2", 1.6, f"largest input speed of {gear.name}")


def _nearest(drive: DriveResponse, omega: float, peak: float) -> int:
    """Number of the motion next to a speed [rad/s] and a largest |error| [rad]."""
    return int(np.argmin(np.abs(drive.omega / omega - 1.0) + np.abs(drive.peak - peak) / np.max(drive.peak)))


def _torque(panel: Panel, project: Project, drive: DriveResponse, more: Drawn, scale: float) -> None:
    for case in more.cases:
        there = case.drive
        draw_motions(panel, scale * there.omega, there.torque, there.stable, ORANGE, "", "", 1.0)
    draw_motions(panel, scale * drive.omega, drive.torque, drive.stable, BLUE, "", "", 2.2)
    draw_motions(panel, scale * drive.omega, drive.torque, ~drive.stable, BLUE, "", DASHES, 1.9)
    if project.gear is None:
        return
    top = max(float(np.max(case.torque)) for case in (drive, *(case.drive for case in more.cases)))
    limits = {
        "repeated peak torque": (project.gear.repeated_peak_torque, "8 3"),
        "momentary torque": (project.gear.momentary_torque, "2 2"),
    }
    for name, (limit, dash) in limits.items():
        if limit is not None and limit < NEAR * top:
            panel.line([-np.inf, np.inf], [limit, limit], BLACK, f"{name} of {project.gear.name}", dash, 1.2)


def _shade(panel: Panel, avoid: Avoid | None, scale: float) -> None:
    """Speeds to avoid as grey bands behind everything."""
    (_, _), (bottom, top) = panel.limits()
    bands = () if avoid is None else avoid.bands
    for i, (low, high) in enumerate(bands):
        x = scale * np.array([low, high])
        name = "speeds to avoid" if i == 0 else ""
        panel.curves.insert(0, Curve(x, np.full(2, bottom), SHADE, name, upper=np.full(2, top)))
    panel.ylim = (bottom, top)
