"""Figures of measurements and of models fitted to them."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..base.number_text import number
from ..base.results import Complexes
from ..base.units import ARCSEC
from ..files.variants.identify_log import IdentifiedLog
from ..study.identification.bode.bode_fit import BodeFit
from ..study.identification.bode.measured_bode import MeasuredBode
from ..study.identification.identified import Identified
from ..study.identification.joint.answer import law_cloud, residual_orders, torsion_of
from ..study.identification.joint.metered import Metered
from ..study.identification.log import Log, LogSegment
from ..study.identification.loops.loop_result import LoopFit
from ..study.identification.orders.order_result import OrderScan
from .panels import BLUE, DASHES, GREY, ORANGE, PALE, TIME, Axis, Panel, bode_pair, panels_of

TORSION = Axis("torsion", "arcmin", 60.0 * ARCSEC)
REACH = 1.96  # standard errors of an interval of 95 %
# Light to dark also without colour; constant speed, of which there is most, is left white.
SHADES = {"still": "#e8e8e8", "run-up": "#9ecae1", "run-down": "#fdae6b", "other": "#909090"}
MOST_PIECES = 3  # of a log, that are drawn
MOST_SAMPLES, SOME = 4000, 600  # samples of a loop and of its residual that are drawn
KINDS = {"order": (BLUE, "fixed order (angle)"), "frequency": (ORANGE, "fixed frequency (time)")}


@panels_of.register
def log_panels(log: Log, segments: Sequence[LogSegment] | None = None) -> list[Panel]:
    """Every channel over the time, its segments shaded and named; without `segments` they are computed."""
    parts = segments if segments is not None else log.segments() if log.moving else ()
    panels = [_channel(log, name, parts) for name in log.channels]
    for part in parts:
        speed = f", {number(part.speed, 3)} rad/s" if part.kind == "constant speed" else ""
        panels[0].note(0.5 * (part.start + part.stop), 0.0, part.kind + speed, above=True)
    return panels


def _channel(log: Log, name: str, segments: Sequence[LogSegment]) -> Panel:
    values = log.channels[name]
    low, high = float(np.min(values)), float(np.max(values))
    pad = 0.06 * (high - low) or 0.05 * abs(high) or 1.0
    panel = Panel("", TIME, Axis(name.replace("_", " "), log.units[name]))
    panel.xlim, panel.ylim = (float(log.time[0]), float(log.time[-1])), (low - pad, high + pad)
    for part in segments:
        if part.kind in SHADES:
            panel.band([part.start, part.stop], -np.inf, np.inf, SHADES[part.kind], part.kind)
    for rows in log.unbroken():
        panel.line(log.time[rows], values[rows], width=1.2)
    return panel


@panels_of.register
def order_scan_panels(scan: OrderScan, channel: str = "") -> list[Panel]:
    """The amplitude of each line over its order: stems from zero, and a bar over the interval of 95 %."""
    unit = ("arcsec", ARCSEC) if scan.unit == "rad" else (scan.unit or "–", 1.0)
    title = f"lines of {channel.replace('_', ' ')}" if channel else ""
    highest = max((line.order for line in scan.lines), default=1.0)
    panel = Panel(title, Axis("order per turn"), Axis("amplitude", *unit), xlim=(0.0, 1.05 * highest), ylim=(0.0, None))
    for line in scan.lines:
        colour, label = KINDS.get(line.kind, (GREY, "undecided"))
        low, high = np.maximum(line.interval(), 0.0)
        panel.bars([line.order], 0.0, line.amplitude, colour, label, 3.0)
        panel.bars([line.order], low, high, colour)
        for end in (low, high):
            panel.line(line.order + 0.006 * highest * np.array([-1.0, 1.0]), end, colour, width=1.0)
    return [panel]


@panels_of.register
def identified_panels(fit: Identified) -> list[Panel]:
    """Residual of the first output over the time."""
    left = fit.residual[0]
    panel = Panel(f"{fit.outputs[0]}: {fit.rms[0]:.3g} rms", TIME, Axis("measured − computed"))
    panel.line(fit.step * np.arange(len(left)), left, width=0.5)
    return [panel]


def identified_log_rows(fit: IdentifiedLog) -> list[list[Panel]]:
    """Rows of panels: the torsion of each piece over the predicted one, the residual, its orders, and the law.

    A current or a torque follows, over the predicted one.
    """
    joint, columns = fit.answer.joint, []
    for i, (piece, left) in enumerate(zip(joint.pieces, joint.residuals(), strict=True)):
        time, values = piece.time, torsion_of(joint, i)
        some = np.linspace(0, len(time) - 1, min(len(time), MOST_SAMPLES)).astype(int)
        torsion = Panel("torsion", TIME, TORSION)
        torsion.line(time[some], values[some], PALE, "measured", width=3.0)
        torsion.line(time[some], (values + left)[some], BLUE, "predicted", width=1.0)
        rms = number(float(np.sqrt(np.mean(left * left))) / ARCSEC, 3)
        residual = Panel(f"measured − predicted, {rms} arcsec rms", TIME, Axis("residual", "arcsec", ARCSEC))
        residual.line(time[some], left[some], ORANGE, width=0.7)
        columns.append((torsion, residual))
    twist, torque, curve = law_cloud(joint)
    law = Panel("torsion law of the gear", TORSION, Axis("torque", "N·m"))
    law.points(twist, torque, PALE, "points of the log")
    law.line(*curve, BLUE, "found")
    orders = Panel("orders of the residual", Axis("order per turn of the motor"), Axis("amplitude", "arcsec", ARCSEC))
    orders.line(*residual_orders(joint), ORANGE, width=1.0)
    rows = [*([list(row) for row in zip(*columns[:MOST_PIECES], strict=True)]), [orders, law]]
    return rows + [_metered_row(channel) for channel in fit.answer.channels]


def _metered_row(channel: Metered) -> list[Panel]:
    """A channel over the predicted one, in the first pieces."""
    row, name = [], channel.name.replace("_", " ")
    for time, measured, predicted in channel.curves[:MOST_PIECES]:
        row.append(panel := Panel(name, TIME, Axis(name, "N·m" if channel.unit == "N*m" else channel.unit)))
        panel.line(time, measured, PALE, "measured", width=3.0)
        panel.line(time, predicted, BLUE, "predicted", width=1.0)
    return row


@panels_of.register
def identified_log_panels(fit: IdentifiedLog) -> list[Panel]:
    """The torsion of the first piece, its residual, and the orders of it."""
    return [row[0] for row in identified_log_rows(fit)]


@panels_of.register
def loop_fit_panels(fit: LoopFit) -> list[Panel]:
    """Measured and fitted torque over the torsion, and the residual."""
    rows = np.unique(np.linspace(0, len(fit.torque) - 1, MOST_SAMPLES).astype(int))
    loop = Panel("torque over torsion", TORSION, Axis("torque", "N*m"))
    loop.line(fit.torsion[rows], fit.torque[rows], PALE, "measured", width=4.5)
    loop.line(fit.torsion[rows], fit.fitted[rows], BLUE, "fitted", width=1.0)
    title = f"measured − fitted torque, {number(fit.residual_rms, 3)} N·m rms"
    residual, few = Panel(title, TORSION, Axis("residual", "N*m")), rows[:: max(1, len(rows) // SOME)]
    residual.points(fit.torsion[few], (fit.torque - fit.fitted)[few], ORANGE, "residual", ".", ORANGE)
    return [loop, residual]


@panels_of.register
def measured_bode_panels(
    measured: MeasuredBode, responses: Sequence[tuple[str, Complexes, str, str]] = ()
) -> list[Panel]:
    """Size and phase of a measured Bode plot; over them responses (n,) with their names, colours and dashes."""
    unit = "dB re 1 rad/(N*m*s)" if measured.quantity == "plant" else "dB"
    ends = float(measured.omega[0]), float(measured.omega[-1])
    size, phase = bode_pair("", Axis(measured.quantity, unit), ends)
    size.points(measured.omega, measured.decibels, ORANGE, "measured", ".", ORANGE)
    if measured.phased:
        phase.points(measured.omega, measured.degrees, ORANGE, "measured", ".", ORANGE)
    for name, response, colour, dash in responses:
        plot = replace(measured, value=response, phased=True)
        size.line(measured.omega, plot.decibels, colour, name, dash)
        phase.line(measured.omega, plot.degrees, colour, name, dash)
    return [size, phase]


@panels_of.register
def bode_fit_panels(fit: BodeFit) -> list[Panel]:
    """The measured Bode plot under that of the drive and that of the fit."""
    responses = [("drive", fit.model, GREY, DASHES)]
    if fit.values:
        responses.append(("fitted", fit.computed, BLUE, ""))
    return measured_bode_panels(fit.measured, responses)
