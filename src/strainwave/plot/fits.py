"""Figures of measurements and of what was fitted to them."""

from collections.abc import Sequence

import numpy as np

from ..base.results import Floats
from ..base.sentences import number
from ..base.units import ARCSEC
from ..study.identification.free_decay.decay import DecayFit
from ..study.identification.friction.friction_model import FrictionFit
from ..study.identification.identified import Identified
from ..study.identification.log import Log, LogSegment
from ..study.identification.loops.loop_result import LoopFit
from ..study.identification.orders.order_result import OrderScan
from ..study.identification.response_curve.response_fit import ResponseFit
from .colours import BLACK, BLUE, DASHES, GREY, ORANGE, PALE
from .panels import TIME, Axis, Note, Panel, angle, panels_of

TORSION = Axis("torsion", "arcmin", 60.0 * ARCSEC)
REACH = 1.96  # standard errors of an interval of 95 %
# Light to dark also without colour; constant speed, of which there is most, is left white.
SHADES = {"still": "#e8e8e8", "run-up": "#9ecae1", "run-down": "#fdae6b", "other": "#909090"}
MOST, SOME = 4000, 600  # samples of a loop and of its residual that are drawn
KINDS = {"order": (BLUE, "stays with the angle"), "frequency": (ORANGE, "stays with the time")}


@panels_of.register
def log_panels(found: Log, segments: Sequence[LogSegment] | None = None) -> list[Panel]:
    """Every channel over the time, its segments shaded and named; they are looked for unless they are given."""
    parts = segments if segments is not None else found.segments() if found.moving else ()
    panels = [_channel(found, name, parts) for name in found.channels]
    for part in parts:
        speed = f", {number(part.speed, 3)} rad/s" if part.kind == "constant speed" else ""
        panels[0].notes.append(Note(0.5 * (part.start + part.stop), 0.0, part.kind + speed, above=True))
    return panels


def _channel(found: Log, name: str, segments: Sequence[LogSegment]) -> Panel:
    values = found.channels[name]
    low, high = float(np.min(values)), float(np.max(values))
    pad = 0.06 * (high - low) or 0.05 * abs(high) or 1.0
    panel = Panel("", TIME, Axis(name.replace("_", " "), found.units[name]))
    panel.xlim, panel.ylim = (float(found.time[0]), float(found.time[-1])), (low - pad, high + pad)
    for part in segments:
        if part.kind in SHADES:
            panel.band([part.start, part.stop], -np.inf, np.inf, SHADES[part.kind], part.kind)
    for rows in found.unbroken():
        panel.line(found.time[rows], values[rows], width=1.2)
    return panel


@panels_of.register
def decay_panels(found: DecayFit) -> list[Panel]:
    """Frequency and damping ratio of a free decay against its amplitude, with 95 % bars, and those of the fit."""
    order = np.argsort(found.amplitude)
    x = angle("amplitude of the first harmonic", found.amplitude)
    frequency, damping = Panel("", x, Axis("frequency", "rad/s")), Panel("", x, Axis("damping ratio", "%", 0.01))
    ratio, fitted = found.rate / found.omega, found.fitted_rate / found.fitted_omega
    for panel, values, error, curve, colour, dash in (
        (frequency, found.omega, found.omega_deviation, found.fitted_omega, BLUE, ""),
        (damping, ratio, found.rate_deviation / found.omega, fitted, ORANGE, DASHES),
    ):
        panel.bars(found.amplitude, values - REACH * error, values + REACH * error, colour)
        panel.points(found.amplitude, values, colour, panel.y.name, "o" if panel is frequency else "s")
        panel.line(found.amplitude[order], curve[order], colour, "fitted", dash)
    damping.ylim = (0.0, 2.0 * float(np.max(fitted)))
    return [frequency, damping]


@panels_of.register
def response_fit_panels(found: ResponseFit) -> list[Panel]:
    """The measured first harmonics, up and down, and the curve of the fitted system with its folds."""
    curve = found.curve()
    size = curve.amplitude(1)
    panel = Panel("", Axis("omega", "rad/s"), angle("amplitude of the first harmonic", size))
    for jump in found.jumps:
        panel.band(jump, -np.inf, np.inf, PALE, "jump")
    panel.parted(curve.omega, size, curve.stable, GREY, "fitted", widths=(1.2, 1.2))
    for up, marker, colour, way in ((True, "^", BLUE, "up"), (False, "v", ORANGE, "down")):
        chosen = found.up == up
        panel.points(found.omega[chosen], np.abs(found.measured[chosen]), colour, f"measured, sweep {way}", marker)
    folds = curve.folds
    panel.points([fold.omega for fold in folds], [fold.amplitude(1) for fold in folds], BLACK, "folds", "o", BLACK)
    return [panel]


@panels_of.register
def order_scan_panels(found: OrderScan, channel: str = "") -> list[Panel]:
    """The amplitude of each line over its order: stems from zero, and a bar over the interval of 95 %."""
    unit = ("arcsec", ARCSEC) if found.unit == "rad" else (found.unit or "–", 1.0)
    title = f"lines of {channel.replace('_', ' ')}" if channel else ""
    highest = max((line.order for line in found.lines), default=1.0)
    panel = Panel(title, Axis("order per turn"), Axis("amplitude", *unit), xlim=(0.0, 1.05 * highest), ylim=(0.0, None))
    for line in found.lines:
        colour, label = KINDS.get(line.kind, (GREY, "undecided"))
        low, high = (max(end, 0.0) for end in line.interval())
        panel.bars([line.order], 0.0, line.amplitude, colour, label, 3.0)
        panel.bars([line.order], low, high, colour)
        for end in (low, high):
            panel.line(line.order + 0.006 * highest * np.array([-1.0, 1.0]), end, colour, width=1.0)
    return [panel]


@panels_of.register
def identified_panels(found: Identified) -> list[Panel]:
    """What is left of the first output over the time."""
    left = found.residual[0]
    panel = Panel(f"{found.outputs[0]}: {found.rms[0]:.3g} rms", TIME, Axis("measured less computed"))
    panel.line(found.step * np.arange(len(left)), left, width=0.5)
    return [panel]


def torsion_panels(found: Identified, measured: Sequence[Floats]) -> list[list[Panel]]:
    """Rows of panels: every record of the torsion [rad] beside the computed one, and below it what is left."""
    begin, columns = 0, []
    for values in measured:
        left = found.residual[0][begin : begin + len(values)]
        begin += len(values)
        time = found.step * np.arange(len(left), dtype=float)
        torsion = Panel("torsion", TIME, TORSION)
        torsion.line(time, values, PALE, "measured", width=3.0)
        torsion.line(time, values - left, BLUE, "computed", width=1.0)
        rms = number(float(np.sqrt(np.nanmean(left * left))) / ARCSEC, 3)
        rest = Panel(f"measured less computed, {rms} arcsec rms", TIME, Axis("residual", "arcsec", ARCSEC))
        rest.line(time, left, ORANGE, width=0.7)
        columns.append((torsion, rest))
    return [list(row) for row in zip(*columns, strict=True)]


@panels_of.register
def loop_fit_panels(found: LoopFit) -> list[Panel]:
    """Measured and fitted torque over the torsion, and what is left."""
    take = np.unique(np.linspace(0, len(found.torque) - 1, MOST).astype(int))
    loop = Panel("torque over torsion", TORSION, Axis("torque", "N*m"))
    loop.line(found.torsion[take], found.torque[take], PALE, "measured", width=4.5)
    loop.line(found.torsion[take], found.fitted[take], BLUE, "fitted", width=1.0)
    title = f"measured minus fitted torque, {number(found.residual_rms, 3)} N·m rms"
    rest, some = Panel(title, TORSION, Axis("residual", "N*m")), take[:: max(1, len(take) // SOME)]
    rest.points(found.torsion[some], (found.torque - found.fitted)[some], ORANGE, "residual", ".", ORANGE)
    return [loop, rest]


@panels_of.register
def friction_fit_panels(found: FrictionFit) -> list[Panel]:
    """Measured and fitted torque over the speed."""
    order = np.argsort(found.speed)
    panel = Panel("", Axis("speed", "rad/s"), Axis("torque", "N*m"))
    panel.points(found.speed, found.torque, ORANGE, "measured")
    panel.line(found.speed[order], found.fitted[order], BLUE, "fitted", width=1.0)
    panel.points(found.speed[order], found.fitted[order], BLUE, "", ".", BLUE)
    return [panel]
