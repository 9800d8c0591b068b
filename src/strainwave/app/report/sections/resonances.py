"""The resonances: where the computed curve is largest and jumps, and multiple scales against it."""

from typing import Any

import numpy as np

from ....base.number_text import percent
from ....base.sentences import Angle, Sentence, Speed, listed
from ....drive.drive_response import DriveResponse
from ....plot.drive import draw_exact, draw_folds, simulated
from ....plot.panels import DOT_DASH, GREY, ORANGE, Panel, of_speeds
from ....plot.smooth_curve import fine
from ....plot.svg import figure
from ....study.analysis.analysis import Analysis
from ....study.analysis.regimes import Regime
from ....study.speed_map.error_equation import equation_orders
from ....theory.slow_flow.results import Certificate
from ...console import number
from ...view import View, sizes
from ..section import Part, Table

NO_STIFFNESS = "the torsion law has no stiffness at the operating point (backlash), or the drive has no excitation."

COLUMNS = (
    "number name order inside_range omega_rad_per_s top.amplitude_rad top.omega_rad_per_s jumps.omega_rad_per_s "
    "peak.amplitude_rad peak_error.amplitude folds.omega_rad_per_s"
)
HEADS = (
    "Speed: resonance speed for small oscillations. Amplitudes: 0-to-peak, of the torsion component near the natural "
    "frequency. Top: largest amplitude of the computed curve near the resonance, without subharmonics; –: no maximum. "
    "Peak and folds (turning points of the curve): by multiple scales of first order, or of second order where the "
    "first is invalid. Peak error: relative to the computed curve, or estimated; –: no resonant oscillation."
)


def resonances(view: View) -> Part:
    """Every resonance with its number, by ascending speed, and a figure of those with a curve by multiple scales."""
    regimes, jumps = view.analysis.regimes, _jumps(view.analysis)
    rows = [_resonance(view, i, regime, jumps[i - 1]) for i, regime in enumerate(regimes, 1)]
    data = {"resonances": rows, "resonance_remark": "" if rows else _remark(view)}
    inside = [(i, regime) for i, regime in enumerate(regimes, 1) if regime.inside]
    without = (reason + "." for reason in dict.fromkeys(regime.reason for _, regime in inside if regime.reason))
    notes = [f"{HEADS} Order: periods per turn of the {view.speeds.base_angle}.", *without]
    drawn = [(figure_of(view, r), verdict(row)) for r, row in zip(regimes, rows, strict=True) if row["peak"]]
    return Part(
        "Resonances", data, [] if rows else ["No resonance can be listed: " + _remark(view)], [Table(rows, COLUMNS)],
        notes if rows else [], drawn, appendix=True,
    )  # fmt: skip


def verdict(row: dict[str, Any]) -> str:
    """Text below the figure of a resonance."""
    peak = row["peak"]
    return Sentence(
        "{}, {}, order {}. Multiple scales{} put the peak at {} and {}: {}.{}",
        row["number"], row["name"], row["order"],
        " of second order" if row["certificate_at_peak"]["order"] == 2 else "",
        Angle(peak["amplitude_rad"]), Speed(peak["omega_rad_per_s"]), peak_verdict(row), escalation(row),
    )  # fmt: skip


def peak_verdict(row: dict[str, Any]) -> str:
    """Error of the peak by multiple scales, in words."""
    error = row["peak_error"]
    if error is None:
        return ""
    size, speed = percent(abs(error["amplitude"]), 2), percent(abs(error["speed"]), 2)
    if error["predicted"]:
        estimate = f"about {size} in amplitude and {speed} in speed"
        return f"no computed curve to compare with; estimated error: {estimate}"
    large, high = "large" if error["amplitude"] > 0.0 else "small", "high" if error["speed"] > 0.0 else "low"
    difference = f"the amplitude is {size} too {large} and the resonance speed {speed} too {high}"
    return f"relative to the computed curve, {difference}"


def escalation(row: dict[str, Any]) -> str:
    """Sentence on the second order where the first is not valid; "" otherwise."""
    first, used = row["certificate_first_order"], row["certificate_at_peak"]
    if first["valid"]:
        return ""
    difference = f" First order has an amplitude error of {percent(first['predicted_error'], 2)} at its peak"
    if used["order"] == 2 and used["valid"]:
        return f"{difference}; the second order is shown."
    return f"{difference}. The second order is invalid too: use the computed curve."


def _remark(view: View) -> str | Sentence:
    """Reason why no resonance is listed; of motions that beat, the speeds of small oscillations."""
    omega_0, orders = view.analysis.point.omega_0, equation_orders(view.analysis.system)
    if not (omega_0 and any(order % 1 for order in orders)):
        return NO_STIFFNESS
    met = listed(Sentence("order {} at {}", number(k, 5), Speed(omega_0 / k, digits=5)) for k in orders)
    text = "multiple scales requires motions that repeat with every turn, but these beat. Small oscillations: {}."
    return Sentence(text, met)


def _jumps(analysis: Analysis) -> list[list[float]]:
    """Speeds [rad/s] of the jumps of the computed curve, each with the resonance next to it."""
    jumps: list[list[float]] = [[] for _ in analysis.regimes]
    main = [i for i, regime in enumerate(analysis.regimes) if regime.resonance.q == 1]
    if not main:
        return jumps
    tops = np.array([r.omega if r.top is None else r.top[0] for r in map(analysis.regimes.__getitem__, main)])
    for value in jump_speeds(analysis.exact):
        jumps[main[int(np.argmin(np.abs(np.log(tops / value))))]].append(value)
    for i, regime in enumerate(analysis.regimes):
        if regime.resonance in analysis.close:
            jumps[i] = jump_speeds(analysis.close[regime.resonance])
    return jumps


def jump_speeds(response: DriveResponse) -> list[float]:
    """Speeds [rad/s] at which a slow run-up or run-down jumps, ascending."""
    sweep = response.sweep
    return [] if sweep is None else sorted({jump.value for jump in (*sweep.on_run_up, *sweep.on_run_down)})


def _resonance(view: View, index: int, regime: Regime, jumps: list[float]) -> dict[str, Any]:
    curve = regime.response
    peak = None if curve is None or not curve.branches else curve.peak
    folds = [] if curve is None else list(zip(curve.folds, curve.fold_amplitudes, strict=True))
    return {
        "number": index,
        "name": regime.name,
        "order": regime.order,
        "resonance": f"{regime.resonance.p}:{regime.resonance.q}",
        **view.speed_data(regime.omega),
        "inside_range": regime.inside,
        "top": None if regime.top is None else _at(view, *regime.top),
        "jumps": [view.speed_data(value) for value in jumps],
        "steady_amplitudes_rad": [{"value": s.amplitude, "stable": s.stable} for s in regime.states],
        "existence": regime.existence,
        "certificate": _certificate(regime.certificate),
        "certificate_first_order": _certificate(regime.first_at_peak),
        "certificate_at_peak": _certificate(regime.at_peak),
        "peak": None if peak is None else _at(view, *peak),
        "peak_error": _peak_error(regime, peak),
        "folds": [_at(view, w, a) for w, a in folds],
        "response": "" if curve is None else curve.message,
        "reason": regime.reason,
    }


def _at(view: View, omega: float, amplitude: float) -> dict[str, Any]:
    return view.speed_data(omega) | sizes(amplitude, "amplitude")


def _peak_error(regime: Regime, peak: tuple[float, float] | None) -> dict[str, Any] | None:
    """Error of the peak by multiple scales: against the computed curve, or as its certificate predicts it."""
    if peak is None:
        return None
    if regime.top is not None:
        omega, amplitude = regime.top
        return {"amplitude": peak[1] / amplitude - 1.0, "speed": peak[0] / omega - 1.0, "predicted": False}
    if (predicted := regime.at_peak) is None:
        return None
    return {"amplitude": predicted.amplitude, "speed": abs(predicted.speed), "predicted": True}


def _certificate(certificate: Certificate | None) -> dict[str, Any] | None:
    if certificate is None:
        return None
    named = {name: getattr(certificate, name) for name in ("order", "valid", "sentence")}
    errors = {"predicted_error": certificate.amplitude, "error_at_speed": certificate.amplitude_at_speed}
    return named | errors | {"speed_error": abs(certificate.speed)}


HEIGHT = 330.0


def figure_of(view: View, regime: Regime) -> str:
    """One resonance as SVG: the torsion's component near omega_0, exact, by multiple scales, and simulated."""
    curve = regime.response
    if curve is None or not curve.branches:
        raise ValueError(f"the {regime.label} resonance has no response curve")
    analysis, speeds = view.analysis, view.speeds
    low, high = regime.band()
    p, q = regime.resonance
    turning = speeds.name.removeprefix("forcing frequency ")
    speed_name = turning if regime.resonance.ratio == 1 else f"{regime.resonance.ratio} × {turning}"
    panel = Panel("", of_speeds(speeds), view.angle.axis(f"torsion amplitude at {speed_name}"), xlim=(low, high))
    top = curve.peak[1]
    if q == 1:
        smooth = fine(analysis.close.get(regime.resonance, analysis.exact))
        exact = smooth.curve
        keep = (exact.omega >= low * (1.0 - 1e-12)) & (exact.omega <= high * (1.0 + 1e-12))
        amplitude = smooth.torsion_amplitude(analysis.system, p)
        top = max(top, float(np.max(amplitude[keep], initial=0.0)))
        draw_exact(panel, smooth.method, exact.omega, amplitude, exact.stable, keep)
        folds = [fold.omega for fold in exact.folds if low <= fold.omega <= high]
        draw_folds(panel, folds, [float(amplitude[exact.omega == omega][0]) for omega in folds])
    for branch in curve.branches:
        names = (", stable", ", unstable")
        panel.parted(branch.omega, branch.amplitude, branch.stable, ORANGE, "multiple scales", names, (1.4, 1.4))
    if regime.backbone is not None:
        panel.line(regime.backbone[0], regime.backbone[1], GREY, "free vibration (backbone)", DOT_DASH, 1.2)
    ratio = float(regime.resonance.ratio or 1)
    for motions, marker in ((analysis.run_up.up, "^"), (analysis.run_up.down, "v")):
        good = [m for m in motions if m.status and low <= m.omega <= high and abs(ratio * m.period % 1.0) < 1e-9]
        simulated(panel, [m.omega for m in good], [m.torsion_amplitude(ratio) for m in good], marker)
    panel.ylim = (0.0, 1.08 * top)
    return figure([[panel]], HEIGHT, f"response curve, {regime.label}")
