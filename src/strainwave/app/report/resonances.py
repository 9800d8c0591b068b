"""The resonances of the report as plain data: on the computed curve, and by multiple scales."""

from typing import Any

import numpy as np

from ...speeds import Speeds
from ...study.analysis.analysis import Analysis
from ...study.response.resonances import Regime
from ...study.response.response import ExactResponse
from ...theory.slow_flow.results import Certificate
from ...units import ARCSEC


def resonances(speeds: Speeds, analysis: Analysis) -> list[dict[str, Any]]:
    """Every resonance with its number, by ascending speed."""
    told = _jumps(analysis)
    return [_resonance(speeds, i, regime, told[i - 1]) for i, regime in enumerate(analysis.regimes, 1)]


def place(speeds: Speeds, omega: float) -> dict[str, Any]:
    """Speed of the base angle and of the motor; None where the base angle is a forcing phase."""
    return {"omega_rad_per_s": omega, "motor_speed_rpm": speeds.rpm(omega)}


def _jumps(analysis: Analysis) -> list[list[float]]:
    """Speeds [rad/s] of the jumps of the computed curve, each with the resonance next to it."""
    told: list[list[float]] = [[] for _ in analysis.regimes]
    main = [i for i, regime in enumerate(analysis.regimes) if regime.resonance.q == 1]
    if not main:
        return told
    at = np.array([_top(analysis.regimes[i]) for i in main])
    for value in jump_speeds(analysis.exact):
        told[main[int(np.argmin(np.abs(np.log(at / value))))]].append(value)
    for i, regime in enumerate(analysis.regimes):
        if regime.resonance in analysis.close:
            told[i] = jump_speeds(analysis.close[regime.resonance])
    return told


def jump_speeds(response: ExactResponse) -> list[float]:
    """Speeds [rad/s] at which a slow run-up or run-down jumps, ascending."""
    sweep = response.sweep
    return [] if sweep is None else sorted({jump.value for jump in (*sweep.on_run_up, *sweep.on_run_down)})


def _top(regime: Regime) -> float:
    return regime.omega if regime.top is None else regime.top[0]


def _resonance(speeds: Speeds, index: int, regime: Regime, jumps: list[float]) -> dict[str, Any]:
    curve = regime.response
    peak = None if curve is None or not curve.branches else curve.peak
    folds = [] if curve is None else list(zip(curve.folds, curve.fold_amplitudes, strict=True))
    return {
        "number": index,
        "name": regime.name,
        "order": regime.order,
        "resonance": f"{regime.resonance.p}:{regime.resonance.q}",
        **place(speeds, regime.omega),
        "inside_range": regime.inside,
        "top": None if regime.top is None else _at(speeds, *regime.top),
        "jumps": [place(speeds, value) for value in jumps],
        "steady_amplitudes_rad": [{"value": s.amplitude, "stable": s.stable} for s in regime.states],
        "existence": regime.existence,
        "certificate": _certificate(regime.certificate),
        "certificate_at_peak": _certificate(regime.at_peak),
        "peak": None if peak is None else _at(speeds, *peak),
        "peak_error": _peak_error(regime, peak),
        "folds": [_at(speeds, w, a) for w, a in folds],
        "response": "" if curve is None else curve.message,
        "reason": regime.reason,
    }


def _at(speeds: Speeds, omega: float, amplitude: float) -> dict[str, Any]:
    return place(speeds, omega) | {"amplitude_rad": amplitude, "amplitude_arcsec": amplitude / ARCSEC}


def _peak_error(regime: Regime, peak: tuple[float, float] | None) -> dict[str, Any] | None:
    """Error of the peak by multiple scales: against the computed curve, or as its certificate predicts it."""
    if peak is None:
        return None
    if regime.top is not None:
        omega, amplitude = regime.top
        return {"amplitude": peak[1] / amplitude - 1.0, "speed": peak[0] / omega - 1.0, "predicted": False}
    if regime.at_peak is None:
        return None
    shift = abs(regime.at_peak.frequency_shift)
    return {"amplitude": regime.at_peak.predicted_error, "speed": shift, "predicted": True}


def _certificate(certificate: Certificate | None) -> dict[str, Any] | None:
    if certificate is None:
        return None
    return {
        "valid": certificate.valid,
        "predicted_error": certificate.predicted_error,
        "error_at_speed": certificate.error_at_speed,
        "speed_error": abs(certificate.frequency_shift),
        "sentence": certificate.sentence,
    }
