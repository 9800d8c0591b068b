"""Figures of moves, speed maps and designs."""

import numpy as np

from ..base.results import Floats
from ..base.sentences import number
from ..base.units import RPM
from ..drive.asked import MotorLimits
from ..model.gears.gear import Gear
from ..study.design.result import Design
from ..study.move.result import Move
from ..study.speed_map.result import SpeedMap
from .colours import BLACK, BLUE, DOT_DASH, DOTS, GREEN, GREY, ORANGE, PINK
from .panels import MOTOR, TIME, Axis, Cells, Note, Panel, angle, panels_of

AFTER = 0.4  # durations of the profile shown after its end, and twice the time to settle
NEAR = 2.0  # times the largest value: limits up to there are drawn
SHADE = "#909090"  # bands, which are drawn half transparent
RPMS, TORQUE = Axis("", "rpm", RPM), Axis("", "N*m")

BAND, LOADS, STYLES = "#8c2d04", (BLUE, GREEN, PINK), ("", "7 3", "2 3")  # of the loads shown
BAR = 0.42  # of the distance between loads
GREYS = range(0xFA, 0x8F, -9)  # of oscillations from small to large

SIZES = (("o", BLUE), ("^", ORANGE), ("v", BLACK))
HEADROOM = 1.25


UNLIMITED = MotorLimits()


@panels_of.register
def move_panels(found: Move, gear: Gear | None = None, limits: MotorLimits = UNLIMITED) -> list[Panel]:
    """Commanded speed, pointing error, torque of the motor and in the gear over the time, with the limits given."""
    shown = found.time <= found.duration * (1.0 + AFTER) + 2.0 * (found.settling_time or 0.0)
    t = found.time[shown]
    error = Panel("pointing error of the load", TIME, angle("", found.peak_error))
    low, high = (found.rest_error + side * found.window for side in (-1.0, 1.0))
    error.band([found.duration, t[-1]], low, high, SHADE, "window of a settled load")
    error.line(t, found.pointing_error[shown], width=1.5)
    motor, torque = found.motor_torque[shown], found.gear_torque[shown]
    below = Panel(f"torque of the motor, rms {number(found.rms_motor_torque, 3)} N·m", TIME, TORQUE)
    below.line(t, motor, width=1.5)
    _limit(below, limits.torque, found.peak_motor_torque, motor, "largest torque of the motor", DOT_DASH)
    last = Panel(f"torque in the gear, cubic mean {number(found.average_gear_torque, 3)} N·m", TIME, TORQUE)
    last.line(t, torque, width=1.5)
    for name, dash in {"rated_torque": "4 2", "repeated_peak_torque": "8 3", "momentary_torque": "2 3"}.items():
        _limit(
            last,
            getattr(gear, name, None),
            found.peak_gear_torque,
            torque,
            f"{name.replace('_', ' ')} of the gear",
            dash,
        )
    drawn = [_speed(found, t, found.reference_speed[shown], gear, limits), error, below, last]
    for panel in drawn:
        panel.xlim = (0.0, float(t[-1]))
        panel.upright(found.duration, GREY, "end of the profile", DOTS)
    return drawn


def _speed(found: Move, t: Floats, speed: Floats, gear: Gear | None, limits: MotorLimits) -> Panel:
    panel = Panel("commanded speed of the motor", TIME, RPMS)
    top, sides = float(np.max(np.abs(speed))), _sides(speed)
    for low, high in found.bands:
        for side in sides:
            panel.band(t[[0, -1]], side * low, side * high, SHADE, "speeds to avoid")
    panel.line(t, speed, width=1.8)
    times = [crossing.time for crossing in found.passes]
    panel.points(times, np.interp(times, t, speed), BLACK, "resonance passed")
    bound = min(limits.speed, *([] if gear is None or gear.max_rpm is None else [gear.max_rpm * RPM]), np.inf)
    _limit(panel, bound, top, speed, "largest speed of motor or gear", DOT_DASH)
    near = [size for size in (bound, *(high for _, high in found.bands)) if size < NEAR * top]
    edge = 1.08 * max([top, *near])
    panel.ylim = (-edge if -1.0 in sides else 0.0, edge if 1.0 in sides else 0.0)
    return panel


def _sides(values: Floats) -> list[float]:
    """Signs of what reaches a fifth of the largest size."""
    return [side for side in (1.0, -1.0) if np.max(side * values) > 0.2 * np.max(np.abs(values))]


def _limit(panel: Panel, bound: float | None, top: float, values: Floats, name: str, dash: str) -> None:
    """A limit as a level line on the sides where there are values, if these come near it."""
    if bound is not None and bound < NEAR * top:
        for side in _sides(values):
            panel.level(side * bound, ORANGE, name, dash, 1.4)


def shown_loads(found: SpeedMap) -> list[int]:
    """Numbers of the loads that figures show: the first, the middle one and the last."""
    last = len(found.loads) - 1
    return sorted({0, last // 2, last})


@panels_of.register
def speed_map_panels(found: SpeedMap) -> list[Panel]:
    """Forbidden speeds on shades of the oscillation, its largest values, and where orders meet resonances."""
    ends = float(found.speeds[0]), float(found.speeds[-1])
    return [_bands(found, ends), _oscillation(found, ends), _campbell(found, ends)]


def _bands(found: SpeedMap, ends: tuple[float, float]) -> Panel:
    """Forbidden speeds as a bar for every load, and the vendors' resonance speed."""
    step = float(np.min(np.diff(found.loads))) if len(found.loads) > 1 else 1.0
    panel = Panel(
        "Forbidden speeds; grey: oscillation, dark is large",
        MOTOR,
        Axis(found.load_name, found.load_unit.replace("^", "**")),
        xlim=ends,
    )
    for load, some in zip(found.loads.tolist(), found.forbidden, strict=True):
        for band in some:
            panel.band(band, load - BAR * step, load + BAR * step, BAND, "forbidden")
    good = np.isfinite(found.oscillation) & (found.oscillation > 0.0)
    if np.any(good):
        size = np.log10(np.where(good, found.oscillation, np.min(found.oscillation[good])))
        share = (size - np.min(size)) / (np.ptp(size) or 1.0)
        shade = np.where(good, np.round((len(GREYS) - 1) * share), -1.0).astype(int)
        middle = np.concatenate([found.speeds[:1], 0.5 * (found.speeds[1:] + found.speeds[:-1]), found.speeds[-1:]])
        edges = np.append(found.loads - 0.5 * step, found.loads[-1] + 0.5 * step)
        panel.cells = Cells(middle, edges, shade, [f"#{3 * f'{grey:02x}'}" for grey in GREYS])
    if found.vendor:
        loads = np.array([rule.load for rule in found.vendor])
        up = np.column_stack([loads - 0.5 * step, loads + 0.5 * step]).ravel()
        across = np.repeat([rule.speed for rule in found.vendor], 2)
        panel.line(across, up, BLACK, "vendors' rule, 30 f_n", "5 4", 1.8)
    panel.ylim = (float(found.loads[0]) - 0.6 * step, float(found.loads[-1]) + 0.6 * step)
    return panel


def _oscillation(found: SpeedMap, ends: tuple[float, float]) -> Panel:
    """Largest oscillation of all stable motions: under all loads, under some of them, and the limit."""
    rows = np.where(np.isfinite(found.oscillation), found.oscillation, np.nan)
    panel = Panel("Largest of all stable motions", MOTOR, angle("oscillation", rows), xlim=ends, log=True)
    worst = np.nanmax(np.where(np.isnan(rows), 0.0, rows), axis=0)
    panel.line(found.speeds, worst, BLACK, "worst load", width=2.6)
    if len(found.loads) > 1:
        for i, colour, dash in zip(shown_loads(found), LOADS, STYLES, strict=False):
            panel.line(found.speeds, _filled(rows[i]), colour, found.load_text(i), dash)
    if found.scatter is not None:
        share, some = found.scatter.shares[-1], np.max(found.scatter.oscillation[-1], axis=0)
        name = f"{100 * share:.0f} % of units are below"
        panel.line(found.speeds, np.where(np.isfinite(some), some, worst), ORANGE, name, "8 2 2 2")
    if found.rules.limit is not None:
        panel.level(found.rules.limit, ORANGE, "limit", "8 4", 1.4)
    return panel


def _campbell(found: SpeedMap, ends: tuple[float, float]) -> Panel:
    """Amplitude against the motor speed at which each order meets the resonance, under some loads."""
    largest = max((float(line.amplitude[-1]) for line in found.lines), default=0.0) or 1e-6
    panel = Panel("Where orders meet resonances", MOTOR, angle("torsion amplitude", largest), xlim=ends)
    some = [float(found.loads[i]) for i in shown_loads(found)]
    for line in found.lines:
        speed, up = line.speed, line.amplitude
        if line.load not in some or not np.any((speed >= ends[0]) & (speed <= ends[1])):
            continue
        if len(up) == 1:  # one speed at every amplitude
            speed, up = np.repeat(speed, 2), np.array([0.0, largest])
        look, name = some.index(line.load), found.load_text(int(np.argmin(np.abs(found.loads - line.load))))
        panel.line(speed, up, LOADS[look], name, STYLES[look], 2.0 if line.excited else 1.0)
        if look == len(some) - 1:
            height = float(up[-1]) * (0.98 - 0.09 * (int(line.order) % 3))
            panel.notes.append(Note(float(speed[-1]), height, f"order {line.order:g}"))
    panel.ylim = (0.0, 1.05 * largest)
    if not panel.curves:
        panel.line(ends, [0.0, 0.0], BLACK, "no order meets a resonance in this range")
    return panel


def _filled(row: Floats) -> Floats:
    """A row whose gaps are closed by straight lines."""
    good = np.isfinite(row)
    return np.interp(np.arange(len(row)), np.flatnonzero(good), row[good]) if good.any() else np.zeros(len(row))


@panels_of.register
def design_panels(found: Design) -> list[Panel]:
    """The designs that serve: oscillation over reflected inertia, every size with its marker, the front with names."""
    limit = found.specification.limit
    inertia = Axis("motor and wave generator at the load", "kg*m**2")
    panel = Panel("designs that serve", inertia, angle("oscillation", limit))
    panel.level(limit, BLACK, "limit", DOTS, 1.4)
    panel.caption = ["Named: no other is better in oscillation, size and inertia at once."]
    if not found.feasible:
        return [panel]
    for i, size in enumerate(sorted({c.size for c in found.feasible})):
        marker, colour = SIZES[i % len(SIZES)]
        x, y = np.transpose([(c.reflected_inertia, c.oscillation) for c in found.feasible if c.size == size])
        panel.points(x, y, colour, f"size {size}", marker, ("#ffffff", colour)[i // len(SIZES) % 2])
    across, up = np.transpose([(c.reflected_inertia, c.oscillation) for c in found.feasible])
    panel.xlog = bool(across.max() > 5.0 * across.min())
    panel.xlim = (across.min() / HEADROOM, across.max() * HEADROOM**2)
    panel.ylim = (up.min() - 0.15 * (limit - up.min()) - 1e-9 * limit, limit + 0.1 * (limit - up.min()) + 1e-9 * limit)
    first = {c.gear: c for c in reversed(found.pareto)}
    panel.notes = [Note(c.reflected_inertia, c.oscillation, gear) for gear, c in first.items()]
    return [panel]
