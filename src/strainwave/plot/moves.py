"""Figures of a move: speed, pointing error and torques over the time, with their limits."""

import numpy as np

from ..base.number_text import number
from ..base.results import Floats
from ..base.units import RPM
from ..drive.demands.motor_limits import PEAK, RMS, MotorLimits
from ..model.gears.gear import Gear
from ..study.move.result import Move
from .panels import BLACK, DOT_DASH, DOTS, GREY, ORANGE, TIME, Axis, Panel, angle, panels_of

AFTER = 0.4  # durations of the profile shown after its end, and twice the time to settle
LIMIT_REACH = 2.0  # times the largest value: limits up to there are drawn
SHADE = "#909090"  # bands, which are drawn half transparent
RPMS, TORQUE = Axis("", "rpm", RPM), Axis("", "N*m")
UNLIMITED = MotorLimits()


@panels_of.register
def move_panels(move: Move, gear: Gear | None = None, limits: MotorLimits = UNLIMITED) -> list[Panel]:
    """Commanded speed, pointing error, torque of the motor and in the gear over the time, with the limits given."""
    samples = move.time <= move.duration * (1.0 + AFTER) + 2.0 * (move.settling_time or 0.0)
    t = move.time[samples]
    error = Panel("pointing error of the load", TIME, angle("", move.peak_error))
    low, high = move.rest_error - move.window, move.rest_error + move.window
    error.band([move.duration, t[-1]], low, high, SHADE, "settling window")
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
        panel.upright(move.duration, GREY, "end of the move", DOTS)
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
    panel.points(times, np.interp(times, t, speed), BLACK, "passage through resonance")
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
