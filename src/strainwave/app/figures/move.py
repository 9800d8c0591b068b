"""The figure of a move: commanded speed, pointing error, torque of the motor and in the gear over the time.

It is narrow, so that its text is read on a telephone too.
"""

import numpy as np
from numpy.typing import NDArray

from ...base.results import Floats
from ...base.units import RPM
from ...drive.asked import MotorLimits
from ...model.gears.gear import Gear
from ...study.move.result import Move
from ..console import number
from ..view import angle_unit
from .curves import BLACK, BLUE, DOT_DASH, GREY, ORANGE, thin, upright
from .drive import NEAR
from .svg import Curve, Panel, figure

WIDTH, HEIGHT = 430.0, 215.0  # of the figure and of a panel [px]
AFTER = 0.4  # durations of the profile shown after its end, and twice the time to settle
END, SHADE = "2 2", "#909090"  # line of the end of the profile; bands, which are drawn half transparent


def move_figure(found: Move, gear: Gear | None, limits: MotorLimits) -> str:
    """Draw a move as SVG."""
    return figure([[panel] for panel in panels(found, gear, limits)], HEIGHT, "a move over the time", WIDTH)


def panels(found: Move, gear: Gear | None, limits: MotorLimits) -> list[Panel]:
    """Four panels of the same time."""
    shown = found.time <= found.duration * (1.0 + AFTER) + 2.0 * (found.settling_time or 0.0)
    t = found.time[shown]
    drawn = [
        _speed(found, t, shown, gear, limits),
        _error(found, t, shown),
        _motor_torque(found, t, shown, limits),
        _gear_torque(found, t, shown, gear),
    ]
    for panel in drawn:
        panel.xlim = (0.0, float(t[-1]))
        upright(panel, found.duration, GREY, END, 1.2, "end of the profile")
    drawn[-1].xlabel = "time (s)"
    return drawn


def _speed(found: Move, t: Floats, shown: NDArray[np.bool_], gear: Gear | None, limits: MotorLimits) -> Panel:
    panel = Panel("commanded speed of the motor", "", "rpm")
    speed = found.reference_speed[shown] / RPM
    top = float(np.max(np.abs(speed)))
    sides = _sides(speed)
    for i, (low, high) in enumerate(found.bands):
        for side in sides:
            name = "speeds to avoid" if i == 0 and side == sides[0] else ""
            ends = (np.full(2, side * level / RPM) for level in (low, high))
            panel.curves.append(Curve(t[[0, -1]], next(ends), SHADE, name, upper=next(ends)))
    panel.line(*thin(t, speed), BLUE, width=1.8)
    if found.passes:
        at = np.array([crossing.time for crossing in found.passes])
        panel.points(at, np.interp(at, t, speed), BLACK, "resonance passed", "o", "#ffffff")
    bounds = [limits.speed / RPM, *([] if gear is None or gear.max_rpm is None else [gear.max_rpm])]
    _limit(panel, min(bounds), top, sides, "largest speed of motor or gear", DOT_DASH)
    edge = 1.08 * max(
        [top, *(high / RPM for _, high in found.bands if high / RPM < NEAR * top), _near(min(bounds), top)]
    )
    panel.ylim = (-edge if -1.0 in sides else 0.0, edge if 1.0 in sides else 0.0)
    return panel


def _error(found: Move, t: Floats, shown: NDArray[np.bool_]) -> Panel:
    unit = angle_unit(found.peak_error)
    panel = Panel("pointing error of the load", "", unit.name)
    after = np.array([found.duration, t[-1]])
    low, high = (np.full(2, unit.factor * (found.rest_error + side * found.window)) for side in (-1.0, 1.0))
    panel.curves.append(Curve(after, low, SHADE, "window of a settled load", upper=high))
    panel.line(*thin(t, unit.factor * found.pointing_error[shown]), BLUE, width=1.5)
    return panel


def _motor_torque(found: Move, t: Floats, shown: NDArray[np.bool_], limits: MotorLimits) -> Panel:
    panel = Panel(f"torque of the motor, rms {number(found.rms_motor_torque, 3)} N·m", "", "N·m")
    panel.line(*thin(t, found.motor_torque[shown]), BLUE, width=1.5)
    sides = _sides(found.motor_torque[shown])
    _limit(panel, limits.torque, found.peak_motor_torque, sides, "largest torque of the motor", DOT_DASH)
    return panel


def _gear_torque(found: Move, t: Floats, shown: NDArray[np.bool_], gear: Gear | None) -> Panel:
    panel = Panel(f"torque in the gear, cubic mean {number(found.average_gear_torque, 3)} N·m", "", "N·m")
    torque = found.gear_torque[shown]
    panel.line(*thin(t, torque), BLUE, width=1.5)
    sides = _sides(torque)
    names = {"rated_torque": "4 2", "repeated_peak_torque": "8 3", "momentary_torque": "2 3"}
    for name, dash in names.items():
        bound = None if gear is None else getattr(gear, name)
        if bound is not None:
            _limit(panel, bound, found.peak_gear_torque, sides, f"{name.replace('_', ' ')} of the gear", dash)
    return panel


def _sides(values: Floats) -> list[float]:
    """Signs of what reaches a fifth of the largest size."""
    return [side for side in (1.0, -1.0) if np.max(side * values) > 0.2 * np.max(np.abs(values))]


def _near(bound: float, top: float) -> float:
    return bound if bound < NEAR * top else 0.0


def _limit(panel: Panel, bound: float, top: float, sides: list[float], name: str, dash: str) -> None:
    """A limit as a level line on the sides where there are values, if these come near it."""
    if _near(bound, top):
        for i, side in enumerate(sides):
            panel.line([-np.inf, np.inf], [side * bound] * 2, ORANGE, name if i == 0 else "", dash, 1.4)
