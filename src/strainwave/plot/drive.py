"""Figures of a drive: the oscillation of its error, the torque in its gear and that of its motor against the speed.

The mean of the error, its static wind-up, is left out: it stands beside the figure. Stable parts are full lines,
unstable ones dashed.
"""

import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..base.number_text import number
from ..base.results import Floats
from ..base.units import RPM
from ..drive.demands.motor_limits import PEAK, RMS, MotorLimits
from ..drive.drive_response import DriveResponse
from ..drive.project import Project
from .panels import BLACK, BLUE, DASHES, DOT_DASH, DOTS, GREY, ORANGE, Axis, Panel, angle, of_speeds, panels_of
from .smooth_curve import fine

if TYPE_CHECKING:  # a curve alone is drawn without them
    from ..study.analysis.analysis import Analysis
    from ..study.analysis.load_cases import AtTorque
    from ..study.analysis.regimes import Regime
    from ..study.analysis.time_domain.run_up_check import RunUp
    from ..study.speed_map.avoid import Avoid

SHADE, SURE = "#d9d9d9", "#c6dcec"  # speeds to avoid, and what assumed numbers leave open
HEIGHT = 290.0  # of a panel [px]
LIMIT_REACH = 2.0  # times the largest torque: limits up to there are drawn
BAND_REACH = 3.0  # times the largest oscillation of the drive: the band is drawn up to there
THIN = 0.9  # width of the line of the held motor
HELD = "motor held, load rigid (error equation)"


class Drawn(NamedTuple):
    """Additions of an analysis to the curve of the drive; all empty without an analysis."""

    cases: "tuple[AtTorque, ...]" = ()
    avoid: "Avoid | None" = None
    run: "RunUp | None" = None
    reduced: DriveResponse | None = None
    regimes: "tuple[Regime, ...]" = ()
    sure: Any = None


def reference(project: Project) -> Drawn:
    """The curve of the drive with its motor held, where it is another one, and the range of assumed numbers."""
    return Drawn(reduced=project.held_response(), sure=project.sureness)


def of_analysis(analysis: "Analysis") -> Drawn:
    """Curves under other torques of the load, speeds to avoid, and the computations that check the curve."""
    cases, of_train = analysis.load_cases, analysis.train_curve is not None
    if of_train:
        return Drawn(cases, analysis.avoid, None, analysis.exact)
    return Drawn(cases, analysis.avoid, analysis.run_up, None, analysis.regimes)


NOTHING = Drawn()


@panels_of.register
def drive_panels(
    drive: DriveResponse, project: Project | None = None, y: Axis | None = None, extras: Drawn = NOTHING
) -> list[Panel]:
    """Oscillation of the error above, the largest torque in the gear below, over the same speeds.

    Limits come from the project, and `y` is the axis of the oscillation in a unit that a report chose.
    """
    y = y or angle(f"oscillation of the {drive.name}", drive.oscillation)
    x = Axis("speed of the base angle", "rpm", RPM) if project is None else of_speeds(project.speeds)
    error, torque = Panel("", x, y), Panel("", x, Axis("largest torque in the gear", "N*m"))
    if project is not None:
        low, high = project.speeds.limits
        error.xlim = torque.xlim = low - 0.02 * (high - low), high + 0.02 * (high - low)
    _draw_oscillation(error, project, drive, extras)
    panels = [error]
    if np.size(drive.torque):
        _draw_torque(torque, project, drive, extras)
        panels.append(torque)
    sheet = None if project is None else project.motor_limits
    if sheet is not None and (sheet.peak_torque or sheet.lasts):
        motor = Panel("", x, Axis("torque of the motor", "N*m"), xlim=error.xlim)
        _draw_motor(sheet, motor, drive, extras)
        panels.append(motor)
    for panel in panels:
        panel.fit()
    _draw_references(error, extras)
    for panel in panels:
        for i, band in enumerate(() if extras.avoid is None else extras.avoid.bands):
            panel.band(band, -np.inf, np.inf, SHADE, "" if i else "speeds to avoid")
    for i, regime in enumerate(extras.regimes, 1):  # numbered as in the table
        if regime.inside:
            error.upright(regime.place, GREY, "", "5 4", 0.9)
            error.note(regime.place, 0.0, str(i), above=True)
    return panels


def _draw_references(panel: Panel, extras: Drawn) -> None:
    """The held motor, thin and up to the top of the axis, which is that of the drive, and the band of assumptions."""
    top = panel.ylim[1] or np.inf
    if extras.sure is not None and extras.sure.doubts:
        finite = np.flatnonzero(np.isfinite(extras.sure.high))
        top = max(top, min(BAND_REACH * top, 1.08 * float(np.max(extras.sure.high[finite], initial=0.0))))
        panel.ylim = panel.ylim if panel.ylim[1] is None else (0.0, top)
        low, high = np.minimum(extras.sure.low, top), np.minimum(extras.sure.high, top)
        label = f"range for assumed values{extras.sure.load}"
        for i, part in enumerate(np.split(finite, np.flatnonzero(np.diff(finite) > 1) + 1)):
            panel.band(extras.sure.omega[part], low[part], high[part], SURE, "" if i else label)
    if extras.reduced is not None and len(extras.reduced.curve):
        held = fine(extras.reduced).curve
        panel.line(held.omega, np.where(held.oscillation < top, held.oscillation, np.nan), BLACK, HELD, DOT_DASH, THIN)


def _draw_oscillation(panel: Panel, project: Project | None, drive: DriveResponse, extras: Drawn) -> None:
    """Oscillation of the drive and under other torques of the load, with jumps, integrated motions and limits."""
    curve = fine(drive).curve
    for case in extras.cases:
        other = fine(case.drive).curve
        _draw_other_load(panel, extras, other.omega, other.oscillation, other.stable)
    draw_exact(panel, _curve_name(project, drive, extras), curve.omega, curve.oscillation, curve.stable)
    if extras.run is not None:
        for motions, marker in ((extras.run.up, "^"), (extras.run.down, "v")):
            good = [m for m in motions if m.status]
            heights = [float(np.max(np.abs(m.x - np.mean(m.x[:-1])))) for m in good]
            simulated(panel, [m.omega for m in good], heights, marker)
    if curve.envelope is not None:
        name, smallest = "smallest turn of the beat", curve.envelope[:, 1]
        panel.parted(curve.omega, smallest, True, BLUE, name, widths=(1.0, 1.0), keep=curve.stable)
    oscillation, folds = drive.oscillation, [fold.omega for fold in drive.folds]
    draw_folds(panel, folds, [float(oscillation[np.argmin(np.abs(drive.omega - omega))]) for omega in folds])
    sweep = drive.sweep
    for jump in (*sweep.on_run_up, *sweep.on_run_down) if sweep else ():
        ends = (float(oscillation[_nearest(drive, jump.value, size)]) for size in (jump.before, jump.after))
        panel.arrow(jump.value, *ends)
    if project is not None:
        _draw_limits(panel, project)


def _draw_limits(panel: Panel, project: Project) -> None:
    """Limit of the oscillation, and the largest input speed of the gear, if the speeds of the project come near it."""
    if project.limit is not None:
        panel.level(project.limit, BLACK, "oscillation limit", DOTS, 1.6)
    gear, speeds = project.gear, project.speeds
    if gear is None or gear.max_rpm is None or not speeds.by_motor:
        return
    if gear.max_rpm <= 1.05 * speeds.scale * speeds.limits[1]:
        panel.upright(gear.max_rpm / speeds.scale, BLACK, f"largest input speed of {gear.name}", DOTS, 1.6)


def _draw_other_load(panel: Panel, extras: Drawn, x: Floats, y: Floats, stable: Any) -> None:
    """Stable motions under another torque of the load."""
    name = f"load torque {number(extras.cases[0].torque)} to {number(extras.cases[-1].torque)} N·m"
    panel.parted(x, y, True, ORANGE, name, widths=(1.0, 1.0), keep=stable)


def _curve_name(project: Project | None, drive: DriveResponse, extras: Drawn) -> str:
    """Name of the curve of the drive, with the torque of the load where there are others."""
    return drive.method + (f" at {number(project.mean_load_torque)} N·m" if project and extras.cases else "")


def _nearest(drive: DriveResponse, omega: float, peak: float) -> int:
    """Number of the motion next to a speed [rad/s] and a largest |error| [rad]."""
    return int(np.argmin(np.abs(drive.omega / omega - 1.0) + np.abs(drive.peak - peak) / np.max(drive.peak)))


def _draw_torque(panel: Panel, project: Project | None, drive: DriveResponse, extras: Drawn) -> None:
    for case in extras.cases:
        response = case.drive
        _draw_other_load(panel, extras, response.omega, response.torque, response.stable)
    draw_exact(panel, _curve_name(project, drive, extras), drive.omega, drive.torque, drive.stable)
    gear = None if project is None else project.gear
    if gear is None:
        return
    top = max(float(np.max(case.torque)) for case in (drive, *(case.drive for case in extras.cases)))
    repeated, momentary = (gear.repeated_peak_torque, "8 3"), (gear.momentary_torque, DOTS)
    for name, (limit, dash) in {"repeated peak torque": repeated, "momentary torque": momentary}.items():
        if limit is not None and limit < LIMIT_REACH * top:
            panel.level(limit, BLACK, f"{name} of {gear.name}", dash)


def _draw_motor(sheet: MotorLimits, panel: Panel, drive: DriveResponse, extras: Drawn) -> None:
    """Largest and rms torque of the motor, under every load, below its curves."""
    for response in (drive, *(case.drive for case in extras.cases)):
        if response.motor_torque is not None and response.motor_rms is not None:
            panel.parted(response.omega, response.motor_torque, True, BLUE, "largest", keep=response.stable)
            panel.parted(response.omega, response.motor_rms, True, ORANGE, "rms", keep=response.stable)
    speeds = np.linspace(np.min(drive.omega), np.max(drive.omega), 200)
    for limit, name, dash in ((PEAK, "peak torque", DASHES), (RMS, "continuous torque", DOTS)):
        if math.isfinite(sheet.at(limit, 0.0)):
            panel.line(speeds, sheet.at(limit, speeds), BLACK, f"{name} of the motor", dash)


def draw_exact(panel: Panel, method: str, x: Floats, y: Floats, stable: Any, keep: Any = True) -> None:
    """A computed arc, its stable and its unstable parts."""
    panel.parted(x, y, stable, BLUE, method, (", stable", ", unstable"), (2.2, 1.9), keep=keep)


def simulated(panel: Panel, x: list[float], y: list[float], marker: str) -> None:
    """Markers of motions that were integrated, on a run-up or a run-down."""
    name, face = ("run-up (integration)", BLACK) if marker == "^" else ("run-down (integration)", "#ffffff")
    panel.points(x, y, BLACK, name, marker, face)


def draw_folds(panel: Panel, folds: list[float], heights: list[float]) -> None:
    """Rings at the folds with their speeds."""
    panel.points(folds, heights, BLUE, "fold (turning point of the curve)")
    for u, v in zip(folds, heights, strict=True):
        panel.note(u, v, f"{u / panel.x.size:.5g}")
