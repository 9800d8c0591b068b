"""Figures of a drive: oscillation of its error and torque in its gear against speed, several drives side by side; Bode.

The mean of the error, its static wind-up, is left out: it stands beside the figure. Stable parts are full lines,
unstable ones dashed. Curves have more points than were computed: between those their harmonics follow a smooth curve.
"""

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..base.number_text import number
from ..base.results import Floats
from ..base.series import largest_size
from ..base.units import RPM, Speeds
from ..drive.asked import PEAK, RMS, MotorLimits
from ..drive.drive_response import DriveResponse
from ..drive.loop_margin import Bode
from ..drive.project import Project
from .panels import (
    BLACK,
    BLUE,
    DASHES,
    DOT_DASH,
    DOTS,
    GREY,
    ORANGE,
    Axis,
    Panel,
    angle,
    bode_pair,
    of_speeds,
    panels_of,
)

if TYPE_CHECKING:  # a curve alone is drawn without them
    from ..files.variants.comparison import ProjectComparison
    from ..study.analysis.analysis import Analysis
    from ..study.analysis.in_time import RunUp
    from ..study.analysis.load_cases import AtTorque
    from ..study.speed_map.avoid import Avoid
    from ..study.speed_map.resonances import Regime

SHADE, SURE = "#d9d9d9", "#c6dcec"  # speeds to avoid, and what assumed numbers leave open
HEIGHT = 290.0  # of a panel [px]
LIMIT_REACH = 2.0  # times the largest torque: limits up to there are drawn
BAND_REACH = 3.0  # times the largest oscillation of the drive: the band is drawn up to there
HELD = "motor held, load rigid (the error equation)"
PARTS = 5  # of each step
SHORTEST = 1e-9  # step along the arc, of the curve's extent
COLOURS, STYLES = (BLUE, ORANGE, BLACK, GREY), ("", DASHES, DOT_DASH, "2 3")  # of several drives
THIN, THICK = 0.9, 2.0  # of unstable and stable motions
TITLE_LETTERS = 44  # letters of a title in the legend


def fine(response: DriveResponse) -> DriveResponse:
    """Draw a curve with cubics between its points.

    Speed and harmonics are smooth along the arc where the largest |x| has corners, so they are what is interpolated,
    and with them the sizes of motions that beat. Computed points stay what they are.
    """
    curve = response.curve
    if len(curve) < 3:
        return response
    waves, table = curve.coefficients.shape[1], curve.coefficients
    if curve.envelope is not None:
        table = np.column_stack([table, curve.envelope, curve.peak])
    speed, size = np.ptp(curve.omega), np.max(np.ptp(table, axis=0))
    if not (speed > 0.0 and size > 0.0):
        return response
    scales = np.array([speed, *[size] * table.shape[1]])
    points = _between(np.column_stack([curve.omega, table]) / scales) * scales
    points[::PARTS] = np.column_stack([curve.omega, table])
    seams = np.diff(curve.omega) == 0.0  # of two arcs, between which no line is drawn
    points[1:].reshape(-1, PARTS, points.shape[1])[seams, :-1] = np.nan
    coefficients, envelope, peak = points[:, 1 : waves + 1], points[:, waves + 1 : -1], points[:, -1]
    if curve.envelope is None:
        peak = largest_size(coefficients)
        peak[::PARTS] = curve.peak
    steps = np.arange(len(points)) // PARTS  # a step is drawn as its first point is
    drawn = replace(
        curve, values=points[:, 0], omega=points[:, 0], coefficients=coefficients, peak=peak,
        multipliers=curve.multipliers[steps], stable=curve.stable[steps],
        envelope=None if curve.envelope is None else envelope, waves=None,
    )  # fmt: skip
    return replace(response, curve=drawn)


def _between(points: Floats) -> Floats:
    """Points (rows) with others between them, evenly along the chord."""
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    arc = np.concatenate([[0.0], np.cumsum(np.maximum(steps, SHORTEST))])
    h, rise = np.diff(arc)[:, None], np.diff(points, axis=0)
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
    _error(error, project, drive, extras)
    panels = [error]
    if np.size(drive.torque):
        _torque(torque, project, drive, extras)
        panels.append(torque)
    sheet = None if project is None else project.motor_limits
    if sheet is not None and (sheet.peak_torque or sheet.lasts):
        motor = Panel("", x, Axis("torque of the motor", "N*m"), xlim=error.xlim)
        _motor(sheet, motor, drive, extras)
        panels.append(motor)
    for panel in panels:
        panel.fit()
    _beside(error, extras)
    for panel in panels:
        for i, band in enumerate(() if extras.avoid is None else extras.avoid.bands):
            panel.band(band, -np.inf, np.inf, SHADE, "" if i else "speeds to avoid")
    for i, regime in enumerate(extras.regimes, 1):  # numbered as in the table
        if regime.inside:
            error.upright(regime.place, GREY, "", "5 4", 0.9)
            error.note(regime.place, 0.0, str(i), above=True)
    return panels


def _beside(panel: Panel, extras: Drawn) -> None:
    """The held motor, thin and up to the top of the axis, which is that of the drive, and the band of assumptions."""
    top = panel.ylim[1] or np.inf
    if extras.sure is not None and extras.sure.doubts:
        finite = np.flatnonzero(np.isfinite(extras.sure.high))
        top = max(top, min(BAND_REACH * top, 1.08 * float(np.max(extras.sure.high[finite], initial=0.0))))
        panel.ylim = panel.ylim if panel.ylim[1] is None else (0.0, top)
        low, high = np.minimum(extras.sure.low, top), np.minimum(extras.sure.high, top)
        label = f"range for assumed numbers{extras.sure.load}"
        for i, part in enumerate(np.split(finite, np.flatnonzero(np.diff(finite) > 1) + 1)):
            panel.band(extras.sure.omega[part], low[part], high[part], SURE, "" if i else label)
    if extras.reduced is not None and len(extras.reduced.curve):
        held = fine(extras.reduced).curve
        panel.line(held.omega, np.where(held.oscillation < top, held.oscillation, np.nan), BLACK, HELD, DOT_DASH, THIN)


def _error(panel: Panel, project: Project | None, drive: DriveResponse, extras: Drawn) -> None:
    smooth = fine(drive)
    for case in extras.cases:
        curve = fine(case.drive).curve
        _case(panel, extras, curve.omega, curve.oscillation, curve.stable)
    name, curve = _method(project, drive, extras), smooth.curve
    draw_exact(panel, name, curve.omega, curve.oscillation, curve.stable)
    for motions, marker in ((extras.run.up, "^"), (extras.run.down, "v")) if extras.run is not None else ():
        good = [m for m in motions if m.status]
        heights = [float(np.max(np.abs(m.x - np.mean(m.x[:-1])))) for m in good]
        simulated(panel, [m.omega for m in good], heights, marker)
    if (envelope := smooth.curve.envelope) is not None:
        name, keep = "the same in the smallest turn of the beat", smooth.curve.stable
        panel.parted(smooth.curve.omega, envelope[:, 1], True, BLUE, name, widths=(1.0, 1.0), keep=keep)
    oscillation, omega = drive.oscillation, drive.omega
    folds = [(fold.omega, float(oscillation[np.argmin(np.abs(omega - fold.omega))])) for fold in drive.folds]
    draw_folds(panel, [w for w, _ in folds], [y for _, y in folds])
    sweep = drive.sweep
    for jump in (*sweep.on_run_up, *sweep.on_run_down) if sweep else ():
        before = oscillation[_nearest(drive, jump.value, jump.before)]
        after = oscillation[_nearest(drive, jump.value, jump.after)]
        panel.arrow(jump.value, float(before), float(after))
    if project is None:
        return
    if project.limit is not None:
        panel.level(project.limit, BLACK, "limit of the project", DOTS, 1.6)
    gear = project.gear
    limit = gear.max_rpm if gear is not None and project.speeds.by_motor else None
    if gear is not None and limit is not None and limit <= 1.05 * project.speeds.scale * project.speeds.limits[1]:
        panel.upright(limit / project.speeds.scale, BLACK, f"largest input speed of {gear.name}", DOTS, 1.6)


def _case(panel: Panel, extras: Drawn, x: Floats, y: Floats, stable: Any) -> None:
    """Stable motions under another torque of the load."""
    name = f"load torque {number(extras.cases[0].torque)} to {number(extras.cases[-1].torque)} N·m"
    panel.parted(x, y, True, ORANGE, name, widths=(1.0, 1.0), keep=stable)


def _method(project: Project | None, drive: DriveResponse, extras: Drawn) -> str:
    """Name of the curve of the drive, with the torque of the load where there are others."""
    return drive.method + (f" at {number(project.mean_load_torque)} N·m" if project and extras.cases else "")


def _nearest(drive: DriveResponse, omega: float, peak: float) -> int:
    """Number of the motion next to a speed [rad/s] and a largest |error| [rad]."""
    return int(np.argmin(np.abs(drive.omega / omega - 1.0) + np.abs(drive.peak - peak) / np.max(drive.peak)))


def _torque(panel: Panel, project: Project | None, drive: DriveResponse, extras: Drawn) -> None:
    for case in extras.cases:
        response = case.drive
        _case(panel, extras, response.omega, response.torque, response.stable)
    draw_exact(panel, _method(project, drive, extras), drive.omega, drive.torque, drive.stable)
    gear = None if project is None else project.gear
    if gear is None:
        return
    top = max(float(np.max(case.torque)) for case in (drive, *(case.drive for case in extras.cases)))
    repeated, momentary = (gear.repeated_peak_torque, "8 3"), (gear.momentary_torque, DOTS)
    for name, (limit, dash) in {"repeated peak torque": repeated, "momentary torque": momentary}.items():
        if limit is not None and limit < LIMIT_REACH * top:
            panel.level(limit, BLACK, f"{name} of {gear.name}", dash)


def _motor(sheet: MotorLimits, panel: Panel, drive: DriveResponse, extras: Drawn) -> None:
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
    panel.points(folds, heights, BLUE, "fold, where the curve turns")
    for u, v in zip(folds, heights, strict=True):
        panel.note(u, v, f"{u / panel.x.size:.5g}")


def comparison_panels(found: "ProjectComparison", speeds: Speeds) -> list[Panel]:
    """The oscillation of every drive over the speed, each with its own line, and their limit [rad] if they share it."""
    largest = [float(np.max(response.oscillation)) for response in found.responses]
    panel = Panel("largest oscillation of the error", of_speeds(speeds), angle("", largest))
    for i, (title, response) in enumerate(zip(found.titles, found.responses, strict=True)):
        name = f"{i + 1}: {title}"
        name = name if len(name) <= TITLE_LETTERS else name[: TITLE_LETTERS - 3] + "..."
        name += " (error equation alone)" * bool(np.isnan(found.oscillation[i]))
        x, y, dash = response.omega, response.oscillation, STYLES[(i + i // len(COLOURS)) % len(STYLES)]
        colour = COLOURS[i % len(COLOURS)]
        panel.parted(x, y, response.stable, colour, name, ("", ""), (THICK, THIN), (dash, dash))
        panel.note(float(x[np.argmax(y)]), float(np.max(y)), str(i + 1))
    known = set(found.limit[~np.isnan(found.limit)].tolist())
    if len(known) == 1:
        panel.level(known.pop(), GREY, "limit", "8 4")
    panel.fit()
    return [panel]


@panels_of.register
def bode_panels(bode: Bode) -> list[Panel]:
    """Magnitude and phase of the speeds of motor and load over a torque; a held motor has none."""
    ends, title = (float(bode.omega[0]), float(bode.omega[-1])), f"torque on the {bode.source}"
    size, phase = bode_pair(title, Axis("speed per torque", "dB re 1 rad/(N*m*s)"), ends)
    if np.any(bode.motor):
        size.line(bode.omega, bode.decibels("motor"), BLUE, "motor speed")
        phase.line(bode.omega, bode.degrees("motor"), BLUE, "motor speed")
    size.line(bode.omega, bode.decibels("load"), ORANGE, "load speed", DASHES)
    phase.line(bode.omega, bode.degrees("load"), ORANGE, "load speed", DASHES)
    return [size, phase]
