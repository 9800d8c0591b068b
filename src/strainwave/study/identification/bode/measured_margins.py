"""Margins of a loop that was measured open or closed: between its frequencies by splines.

Size and phase of the open loop follow a cubic spline of log L over log omega. Where a straight line says otherwise, the
frequencies are too far apart to tell.
"""

from collections.abc import Callable
from math import degrees, inf, isfinite, nan, pi
from typing import Any, NamedTuple

import numpy as np
from scipy.interpolate import CubicSpline

from ....base.facts import Fact
from ....base.number_text import number
from ....base.results import Complexes, Floats
from ....drive.loops.margins import Margins
from ....drive.loops.worst_margins import weakness
from ....model.train.controls import HERTZ

Logarithm = Callable[[Floats], Complexes]

GRID_STEPS = 64  # places from one frequency to the next
LOWEST_PHASE = -1.75 * pi  # least phase at the lowest frequency: three integrators, and an eighth of a turn
PHASE_DOUBT_RAD = pi / 180.0  # of phase: a larger difference of spline and straight line is told


class MeasuredMargins(NamedTuple):
    """Margins of a measured loop.

    Attributes
    ----------
    margins : Margins
        Between the lowest and the highest frequency; `stable` where the open loop has no unstable pole, and crosses
        nothing outside. Its slowest pole is not known, and nan.
    at : float
        Frequency [rad/s] of the largest |1/(1 + L)|.
    band : (float, float)
        The lowest and the highest frequency [rad/s].
    doubts : tuple of str
        Crossings that the frequencies do not resolve.
    """

    margins: Margins
    at: float
    band: tuple[float, float]
    doubts: tuple[str, ...]

    @property
    def weak(self) -> str:
        """That the loop is close to instability, in one sentence; empty where it is not."""
        margins = self.margins
        phase, sizes = abs(degrees(margins.phase_margin)), (margins.gain_margin, margins.gain_reduction)
        return weakness(phase, *sizes, margins.peak_sensitivity) if margins.stable else ""

    def facts(self) -> tuple[Fact, ...]:
        """Everything that is said of the margins, once."""
        margins, band = self.margins, f"{number(self.band[0] / HERTZ)} to {number(self.band[1] / HERTZ)} Hz"
        angles = np.degrees(margins.phase_margins)
        phases = ", ".join(_at("°", angles, margins.gain_crossings)) or f"none (|L| never equals 1 from {band})"
        none = f"none (L is never real and negative from {band})"
        gains = ", ".join(_at("", margins.gain_margins, margins.phase_crossings)) or none
        sizes = {"phase_margin_deg": degrees(margins.phase_margin), "gain_margin": margins.gain_margin}
        sizes |= {"gain_reduction": margins.gain_reduction, "delay_margin_s": margins.delay_margin}
        sizes |= {"peak_sensitivity": margins.peak_sensitivity}
        peak = f"{number(margins.peak_sensitivity)} at {number(self.at / HERTZ)} Hz" if margins.stable else "none"
        rows = {"gain_crossings_rad_per_s": margins.gain_crossings, "phase_margins_deg": angles}
        rows |= {"phase_crossings_rad_per_s": margins.phase_crossings, "gain_margins": margins.gain_margins}
        state = (
            f"the measured loop is {'stable' if margins.stable else 'unstable'}, if the open loop has no unstable pole "
        )
        return (
            Fact("margins.stable", margins.stable), Fact("", f"{state}and crosses nothing outside {band}", "{}"),
            Fact("", phases, "phase margins: {}"), Fact("", gains, "gain margins: {}"),
            *(Fact(f"margins.{key}", value if isfinite(value) else None) for key, value in sizes.items()),
            *(Fact(f"margins.{key}", values) for key, values in rows.items()),
            Fact("", peak, "peak sensitivity: {}"), Fact("margins.weak", self.weak, "{}" if self.weak else ""),
            Fact("margins.doubts", self.doubts), Fact("", self.doubts, "note: {}"),
        )  # fmt: skip


def _at(unit: str, values: Floats, places: Floats) -> list[str]:
    """Values with their frequencies [rad/s] in words."""
    return [f"{number(value)}{unit} at {number(w / HERTZ)} Hz" for value, w in zip(values, places, strict=True)]


def measured_margins(measured: Any) -> MeasuredMargins:
    """Margins of a `MeasuredBode` of an open or a closed loop; see `MeasuredBode.margins`."""
    if measured.quantity == "plant" or not measured.phased:
        lacks = "it has no phase" if measured.quantity != "plant" else "it is that of the plant alone"
        raise ValueError(f"margins take a Bode plot of the open or the closed loop with its phase, and {lacks}")
    L = measured.value if measured.quantity == "open loop" else measured.value / (1.0 - measured.value)
    x = np.log(measured.omega)
    phase = np.unwrap(np.angle(L))
    phase += 2.0 * pi * np.ceil((LOWEST_PHASE - phase[0]) / (2.0 * pi))
    logarithm = np.log(np.abs(L)) + 1j * phase
    spline: Logarithm = CubicSpline(x, logarithm)

    def straight(points: Floats) -> Complexes:
        return np.asarray(np.interp(points, x, logarithm.real) + 1j * np.interp(points, x, logarithm.imag))

    fine = np.interp(np.arange((len(x) - 1) * GRID_STEPS + 1) / GRID_STEPS, np.arange(len(x)), x)
    margins, coarse = _crossings(spline, fine), _crossings(straight, fine)
    top = int(np.argmin(np.abs(1.0 + np.exp(spline(fine)))))
    ends = float(measured.omega[0]), float(measured.omega[-1])
    return MeasuredMargins(margins, float(np.exp(fine[top])), ends, tuple(_doubts(margins, coarse)))


def _crossings(log_of: Logarithm, fine: Floats) -> Margins:
    """Crossings of |L| = 1 and of the negative real axis, by secants on a fine grid of log omega."""
    values = log_of(fine)
    turns = (values.imag + pi) / (2.0 * pi)  # whole on the negative real axis
    gains = _roots(fine, values.real, 0.0)
    levels = range(int(np.ceil(np.min(turns))), int(np.floor(np.max(turns))) + 1)
    phases = np.sort(np.concatenate([np.empty(0), *(_roots(fine, turns, level) for level in levels)]))
    logs = log_of(phases).real
    stable = _is_stable(values.real, turns)
    peak = float(np.max(np.abs(1.0 / (1.0 + np.exp(values))))) if stable else inf
    lags = np.angle(-np.exp(log_of(gains)))
    return Margins(np.exp(gains), lags, np.exp(phases), np.exp(-logs), stable, peak, complex(nan, nan))


def _is_stable(size: Floats, turns: Floats) -> bool:
    """True if the Nyquist plot of a stable open loop leaves -1 out: its crossings beyond -1, up less down, are none.

    The plot comes from as many integrators as the phase at the lowest frequency has quarters of a turn: one that
    begins behind half a turn of lag has crossed the axis once.
    """
    behind = np.floor(turns)  # half turns of lag passed
    steps = np.diff(behind)
    beyond = 0.5 * (size[1:] + size[:-1]) > 0.0
    return bool(behind[0] + np.sum(steps[beyond]) == 0.0)


def _roots(x: Floats, y: Floats, level: float) -> Floats:
    """Places where a sampled function passes a level, by straight lines."""
    off = y - level
    i = np.flatnonzero(off[:-1] * off[1:] < 0.0)
    return np.asarray(x[i] - off[i] * (x[i + 1] - x[i]) / (off[i + 1] - off[i]))


def _doubts(fine: Margins, coarse: Margins) -> Any:
    if len(fine.gain_crossings) != len(coarse.gain_crossings) or len(fine.gain_margins) != len(coarse.gain_margins):
        yield "the frequencies are too coarse to count the crossings of the loop: measure more frequencies"
        return
    for w, one, other in zip(fine.gain_crossings, fine.phase_margins, coarse.phase_margins, strict=True):
        if abs(one - other) > PHASE_DOUBT_RAD:
            low, high = (number(p * 180.0 / pi, 3) for p in sorted((one, other)))
            text = f"the phase margin at {number(w / HERTZ)} Hz is from {low}° to {high}°: "
            yield text + "its frequencies are too far apart, measure more of them"
