"""Figures of moves, speed maps, designs and tunings."""

import numpy as np

from ..base.number_text import number
from ..base.results import Floats
from ..base.units import RPM
from ..drive.asked import PEAK, RMS, MotorLimits
from ..model.gears.gear import Gear
from ..study.design.result import Design
from ..study.move.result import Move
from ..study.speed_map.result import SpeedMap
from ..study.tuning.cost import GOALS
from ..study.tuning.result import TunedLoop
from . import panels
from .panels import BLACK, BLUE, DOT_DASH, DOTS, GREY, ORANGE, TIME, Axis, Panel, angle, of_speeds, panels_of

AFTER = 0.4  # durations of the profile shown after its end, and twice the time to settle
LIMIT_REACH = 2.0  # times the largest value: limits up to there are drawn
SHADE = "#909090"  # bands, which are drawn half transparent
RPMS, TORQUE = Axis("", "rpm", RPM), Axis("", "N*m")

BAND, LOADS, STYLES = "#8c2d04", (BLUE, panels.GREEN, panels.PINK), ("", "7 3", "2 3")  # of the loads shown
BAR = 0.42  # of the distance between loads
GREYS = range(0xFA, 0x8F, -9)  # of oscillations from small to large

SIZES = (("o", BLUE), ("^", ORANGE), ("v", BLACK))
HEADROOM = 1.25


UNLIMITED = MotorLimits()


@panels_of.register
def move_panels(move: Move, gear: Gear | None = None, limits: MotorLimits = UNLIMITED) -> list[Panel]:
    """Commanded speed, pointing error, torque of the motor and in the gear over the time, with the limits given."""
    samples = move.time <= move.duration * (1.0 + AFTER) + 2.0 * (move.settling_time or 0.0)
    t = move.time[samples]
    error = Panel("pointing error of the load", TIME, angle("", move.peak_error))
    low, high = move.rest_error - move.window, move.rest_error + move.window
    error.band([move.duration, t[-1]], low, high, SHADE, "window of a settled load")
    error.line(t, move.pointing_error[samples], width=1.5)
    motor, torque = move.motor_torque[samples], move.gear_torque[samples]
    lower = Panel(f"torque of the motor, rms {number(move.rms_motor_torque, 3)} N·m", TIME, TORQUE)
    lower.line(t, motor, width=1.5)
    _allowed(lower, limits, t, move.motor_speed[samples], motor)
    lowest = Panel(f"torque in the gear, cubic mean {number(move.average_gear_torque, 3)} N·m", TIME, TORQUE)
    lowest.line(t, torque, width=1.5)
    for name, dash in {"rated_torque": "4 2", "repeated_peak_torque": "8 3", "momentary_torque": "2 3"}.items():
        rating, label = getattr(gear, name, None), f"{name.replace('_', ' ')} of the gear"
        _limit(lowest, rating, move.peak_gear_torque, torque, label, dash)
    drawn = [_speed(move, t, move.reference_speed[samples], gear, limits), error, lower, lowest]
    for panel in drawn:
        panel.xlim = (0.0, float(t[-1]))
        panel.upright(move.duration, GREY, "end of the profile", DOTS)
    return drawn


def _allowed(panel: Panel, limits: MotorLimits, t: Floats, speed: Floats, torque: Floats) -> None:
    """Draw what the motor gives at most, and of continuous duty, at the speeds of a move."""
    _limit(panel, limits.torque, float(np.max(np.abs(torque))), torque, "largest torque of the motor", DOT_DASH)
    for limit, points, name in ((PEAK, limits.peak_torque, "peak"), (RMS, limits.continuous_torque, "continuous")):
        for side in _sides(torque) if points else ():
            panel.line(t, side * limits.at(limit, speed), ORANGE, f"{name} torque of the motor", DOTS, 1.4)


def _speed(move: Move, t: Floats, speed: Floats, gear: Gear | None, limits: MotorLimits) -> Panel:
    panel = Panel("commanded speed of the motor", TIME, RPMS)
    top, sides = float(np.max(np.abs(speed))), _sides(speed)
    for low, high in move.bands:
        for side in sides:
            panel.band(t[[0, -1]], side * low, side * high, SHADE, "speeds to avoid")
    panel.line(t, speed, width=1.8)
    times = [crossing.time for crossing in move.passes]
    panel.points(times, np.interp(times, t, speed), BLACK, "resonance passed")
    bound = min(limits.fastest, *([] if gear is None or gear.max_rpm is None else [gear.max_rpm * RPM]), np.inf)
    _limit(panel, bound, top, speed, "largest speed of motor or gear", DOT_DASH)
    sizes = [size for size in (bound, *(high for _, high in move.bands)) if size < LIMIT_REACH * top]
    edge = 1.08 * max([top, *sizes])
    panel.ylim = (-edge if -1.0 in sides else 0.0, edge if 1.0 in sides else 0.0)
    return panel


def _sides(values: Floats) -> list[float]:
    """Signs with which values reach a fifth of the largest absolute value."""
    return [side for side in (1.0, -1.0) if np.max(side * values) > 0.2 * np.max(np.abs(values))]


def _limit(panel: Panel, bound: float | None, top: float, values: Floats, name: str, dash: str) -> None:
    """Draw a limit as a level line on each side (sign) that values reach, if they come near it."""
    if bound is not None and bound < LIMIT_REACH * top:
        for side in _sides(values):
            panel.level(side * bound, ORANGE, name, dash, 1.4)


def shown_loads(grid: SpeedMap) -> list[int]:
    """Numbers of the loads that figures show: the first, the middle one and the last."""
    last = len(grid.loads) - 1
    return sorted({0, last // 2, last})


@panels_of.register
def speed_map_panels(grid: SpeedMap) -> list[Panel]:
    """Forbidden speeds on shades of the oscillation, its largest values, and where orders meet resonances."""
    ends = float(grid.speeds[0]), float(grid.speeds[-1])
    return [_bands(grid, ends), _oscillation(grid, ends), _campbell(grid, ends)]


def _bands(grid: SpeedMap, ends: tuple[float, float]) -> Panel:
    """Forbidden speeds as a bar for every load, and the vendors' resonance speed."""
    step = float(np.min(np.diff(grid.loads))) if len(grid.loads) > 1 else 1.0
    y = Axis(grid.load_name, grid.load_unit.replace("^", "**"))
    panel = Panel("Forbidden speeds; grey: oscillation, dark is large", of_speeds(grid.axis), y, xlim=ends)
    for load, bands in zip(grid.loads.tolist(), grid.forbidden, strict=True):
        for band in bands:
            panel.band(band, load - BAR * step, load + BAR * step, BAND, "forbidden")
    good = np.isfinite(grid.oscillation) & (grid.oscillation > 0.0)
    if np.any(good):
        size = np.log10(np.where(good, grid.oscillation, np.min(grid.oscillation[good])))
        share = (size - np.min(size)) / (np.ptp(size) or 1.0)
        shade = np.where(good, np.round((len(GREYS) - 1) * share), -1.0).astype(int)
        middle = np.concatenate([grid.speeds[:1], 0.5 * (grid.speeds[1:] + grid.speeds[:-1]), grid.speeds[-1:]])
        edges = np.append(grid.loads - 0.5 * step, grid.loads[-1] + 0.5 * step)
        panel.cells = panels.Cells(middle, edges, shade, [f"#{3 * f'{grey:02x}'}" for grey in GREYS])
    if grid.vendor:
        loads = np.array([rule.load for rule in grid.vendor])
        up = np.column_stack([loads - 0.5 * step, loads + 0.5 * step]).ravel()
        across = np.repeat([rule.speed for rule in grid.vendor], 2)
        panel.line(across, up, BLACK, "vendors' rule, 30 f_n", "5 4", 1.8)
    panel.ylim = (float(grid.loads[0]) - 0.6 * step, float(grid.loads[-1]) + 0.6 * step)
    return panel


def _oscillation(grid: SpeedMap, ends: tuple[float, float]) -> Panel:
    """Largest oscillation of all stable motions: under all loads, under some of them, and the limit."""
    rows = np.where(np.isfinite(grid.oscillation), grid.oscillation, np.nan)
    x, y = of_speeds(grid.axis), angle("oscillation", rows)
    panel = Panel("Largest of all stable motions", x, y, xlim=ends, log=True)
    worst = np.nanmax(np.where(np.isnan(rows), 0.0, rows), axis=0)
    panel.line(grid.speeds, worst, BLACK, "worst load", width=2.6)
    if len(grid.loads) > 1:
        for i, colour, dash in zip(shown_loads(grid), LOADS, STYLES, strict=False):
            panel.line(grid.speeds, _filled(rows[i]), colour, grid.load_text(i), dash)
    if grid.scatter is not None:
        share, quantile = grid.scatter.shares[-1], np.max(grid.scatter.oscillation[-1], axis=0)
        name = f"{100 * share:.0f} % of units are below"
        panel.line(grid.speeds, np.where(np.isfinite(quantile), quantile, worst), ORANGE, name, "8 2 2 2")
    if grid.rules.limit is not None:
        panel.level(grid.rules.limit, ORANGE, "limit", "8 4", 1.4)
    return panel


def _campbell(grid: SpeedMap, ends: tuple[float, float]) -> Panel:
    """Amplitude against the motor speed at which each order meets the resonance, under some loads."""
    largest = max((float(line.amplitude[-1]) for line in grid.lines), default=0.0) or 1e-6
    panel = Panel("Where orders meet resonances", of_speeds(grid.axis), angle("torsion amplitude", largest), xlim=ends)
    loads = [float(grid.loads[i]) for i in shown_loads(grid)]
    for line in grid.lines:
        speed, up = line.speed, line.amplitude
        if line.load not in loads or not np.any((speed >= ends[0]) & (speed <= ends[1])):
            continue
        if len(up) == 1:  # one speed at every amplitude
            speed, up = np.repeat(speed, 2), np.array([0.0, largest])
        look, name = loads.index(line.load), grid.load_text(int(np.argmin(np.abs(grid.loads - line.load))))
        panel.line(speed, up, LOADS[look], name, STYLES[look], 2.0 if line.excited else 1.0)
        if look == len(loads) - 1:
            height = float(up[-1]) * (0.98 - 0.09 * (int(line.order) % 3))
            panel.note(float(speed[-1]), height, f"order {line.order:g}")
    panel.ylim = (0.0, 1.05 * largest)
    if not panel.curves:
        panel.line(ends, [0.0, 0.0], BLACK, "no order meets a resonance in this range")
    return panel


def _filled(row: Floats) -> Floats:
    """A row whose gaps are closed by straight lines."""
    good = np.isfinite(row)
    return np.interp(np.arange(len(row)), np.flatnonzero(good), row[good]) if good.any() else np.zeros(len(row))


@panels_of.register
def design_panels(design: Design) -> list[Panel]:
    """Feasible designs: oscillation over reflected inertia, a marker for each size, names on the Pareto front."""
    limit = design.specification.limit
    inertia = Axis("motor and wave generator at the load", "kg*m**2")
    panel = Panel("feasible designs", inertia, angle("oscillation", limit))
    panel.level(limit, BLACK, "limit", DOTS, 1.4)
    panel.caption = ["Named: no other is better in oscillation, size and inertia at once."]
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
    named = ((tuning.response_before, GREY, "gains of the file"), (tuning.response_after, BLUE, "recommended gains"))
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
    front = Panel("The best gains for each peak sensitivity", Axis("peak sensitivity"), y)
    front.points([p.figures.peak_sensitivity for p in points], values, BLUE, "tried")
    front.points([best.figures.peak_sensitivity], [best.goals[0]], ORANGE, "recommended", "s", ORANGE)
    return [swept, front]
