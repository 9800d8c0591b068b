"""Figures of a motor's loop: its margins in a Bode plot, its steps; and the Bode plot of a whole train."""

from math import degrees, isfinite, log10

import numpy as np

from ..base.number_text import number
from ..base.results import Complexes, Floats
from ..drive.loops.bode import Bode
from ..drive.loops.loop_curves import LoopCurves, loop_curves
from ..drive.loops.worst_margins import WorstMargins
from ..model.train.controls import HERTZ
from .panels import BLACK, BLUE, DASHES, DOTS, GREY, ORANGE, TIME, Axis, Panel, angle, bode_pair, panels_of

SPAN = 12.0  # how far the frequencies go below the first and above the last that is marked
LOWEST_DB, HIGHEST_DB = -60.0, 40.0
TURN = 360.0  # degrees


@panels_of.register
def motor_loop_panels(worst: WorstMargins) -> list[Panel]:
    """Magnitude and phase with the margins marked, then both steps where the loop is stable."""
    found = loop_curves(worst)
    turned = angle("angle", found.angles, "/(N*m)")
    reference = Panel("step of the speed reference", TIME, Axis("speed / reference speed"))
    disturbance = Panel("step of the load torque", TIME, turned)
    for panel, (motor, load) in ((reference, found.speeds), (disturbance, found.angles)):
        panel.xlim = (0.0, float(np.max(found.time, initial=0.0)))
        panel.line(found.time, load, ORANGE, "load", DASHES)
        panel.line(found.time, motor, BLUE, "motor")
    reference.level(1.0, GREY, "", DOTS)
    return _bode(found) + [reference, disturbance] * found.margins.stable


def loop_rows(worst: WorstMargins) -> list[list[Panel]]:
    """The same panels: the Bode plot on the left, the steps on the right."""
    size, phase, *steps = motor_loop_panels(worst)
    return [[size, *steps[:1]], [phase, *steps[1:]]]


def _bode(found: LoopCurves) -> list[Panel]:
    margins = found.margins
    marked = np.concatenate([margins.gain_crossings, margins.phase_crossings])
    marked = marked if len(marked) else found.omega
    ends = max(found.omega[0], marked.min() / SPAN), min(found.omega[-1], marked.max() * SPAN)
    size, phase = bode_pair("", Axis("magnitude", "dB"), ends)
    size.ylim, size.ystep, phase.ylim = (LOWEST_DB, HIGHEST_DB), 20.0, (-TURN, 0.0)
    size.line(found.omega, _decibels(found.closed), ORANGE, "closed loop", DASHES)
    size.line(found.omega, _decibels(found.open), BLUE, "open loop")
    turned = -np.mod(-np.degrees(np.angle(found.open)), TURN)  # in which a margin stands above -180 degrees
    for part in np.split(np.arange(len(turned)), np.flatnonzero(np.abs(np.diff(turned)) > 0.5 * TURN) + 1):
        phase.line(found.omega[part], turned[part], BLUE, "open loop")
    size.level(0.0, GREY, "", DOTS)
    phase.level(-0.5 * TURN, GREY, "", DOTS)
    crossings = zip(margins.phase_margins, margins.gain_crossings, strict=True)
    least, omega = min(crossings, key=lambda row: abs(row[0]), default=(np.inf, 0.0))
    if isfinite(least):
        size.points([omega], [0.0], BLUE, "gain crossover", "o", BLUE)
        level = degrees(least) - 0.5 * TURN
        phase.line([omega, omega], [-0.5 * TURN, level], BLACK, "margin", width=2.2)
        phase.note(omega, level, f"{number(degrees(least), 2)}° at {number(omega / HERTZ, 3)} Hz")
    for factor in (margins.gain_margin, margins.gain_reduction):
        if isfinite(factor) and factor:
            omega = float(margins.phase_crossings[margins.gain_margins == factor][0])
            height = -20.0 * log10(factor)
            size.line([omega, omega], [0.0, height], BLACK, "margin", width=2.2)
            size.note(omega, height, f"{number(-height, 2)} dB at {number(omega / HERTZ, 3)} Hz")
    return [size, phase]


def _decibels(values: Complexes) -> Floats:
    return np.asarray(20.0 * np.log10(np.maximum(np.abs(values), 1e-300)))


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
