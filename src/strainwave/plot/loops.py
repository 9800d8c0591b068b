"""Figures of identification: a fitted loop, fitted friction."""

from typing import Any

import numpy as np

from ..study.identification.friction.friction_result import FrictionFit
from ..study.identification.loops.loop_result import LoopFit
from ..units import ARCSEC

BLUE, ORANGE, PALE = "#0072B2", "#D55E00", "#c0c0c0"


def draw_loop_fit(axes: Any, found: LoopFit) -> None:
    """Draw measured and fitted torque over the torsion."""
    x = found.torsion / (60.0 * ARCSEC)
    axes.plot(x, found.torque, color=PALE, linewidth=4.0, label="measured")
    axes.plot(x, found.fitted, color=BLUE, linewidth=1.0, label="fitted")
    axes.set(xlabel="torsion (arcmin)", ylabel="torque (N m)")
    axes.legend(frameon=False)


def draw_friction_fit(axes: Any, found: FrictionFit) -> None:
    """Draw measured and fitted torque over the speed."""
    order = np.argsort(found.speed)
    axes.plot(found.speed, found.torque, "o", color=ORANGE, markerfacecolor="none", label="measured")
    axes.plot(found.speed[order], found.fitted[order], "x", color=BLUE, markersize=4.0, label="fitted")
    axes.set(xlabel="speed (rad/s)", ylabel="torque (N m)")
    axes.legend(frameon=False)
