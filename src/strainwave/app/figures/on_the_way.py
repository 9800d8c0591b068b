"""Figures of controllers through many speeds: a move in time, a run-up and a run-down over the speed."""

import numpy as np

from ...study.compensation.moves import CompensatedMove
from ...study.compensation.runup import CompensatedRunup
from ...units import RPM
from ..units import angle_unit
from .compensation import HEIGHT, LOOKS, TALL, WIDTH
from .plots import BLACK, GREY, thin
from .svg import Panel, figure


def move_figure(found: CompensatedMove) -> str:
    """Error of the load and torque of the motor over the time, under each controller, as SVG."""
    unit = angle_unit(float(np.max(np.abs(found.error))))
    error = Panel("angle of the load in the profile less its angle", "", unit.name)
    torque = Panel("torque of the motor", "time (s)", "N·m")
    for i, name in enumerate(found.names):
        colour, dash = (BLACK, "") if i == 0 else LOOKS[(i - 1) % len(LOOKS)]
        error.line(*thin(found.time, found.error[i] * unit.factor), colour, name, dash)
        torque.line(*thin(found.time, found.torque[i]), colour, "", dash)
    for panel in (error, torque):
        low, high = panel.limits()[1]
        panel.line([found.duration] * 2, [low, high], GREY, "", "1 3", 1.0)
    return figure([[error], [torque]], HEIGHT, "a move under several controllers", WIDTH)


def run_up_figure(found: CompensatedRunup) -> str:
    """Largest error over the speed on the way up and down, under each controller, as SVG."""
    unit = angle_unit(float(max(np.max(found.up), np.max(found.down))))
    panel = Panel("largest pointing error about its mean", "motor speed (rpm)", unit.name, log=True)
    for i, name in enumerate(found.names):
        colour = BLACK if i == 0 else LOOKS[(i - 1) % len(LOOKS)][0]
        for sizes, way, dash in ((found.up, "up", ""), (found.down, "down", "5 3")):
            panel.line(found.speed / RPM, sizes[i] * unit.factor, colour, f"{name}, {way}", dash, 1.8)
    return figure([[panel]], TALL, "a run-up and a run-down under several controllers", WIDTH)
