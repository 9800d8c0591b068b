"""Fits to measurements on axes of matplotlib: what was measured with its deviations, and the system that was fitted.

Designs on axes of matplotlib: oscillation over reflected inertia, each size with its own marker.
"""

from typing import Any

import numpy as np

from ..base.units import ARCSEC
from ..study.design.result import Design
from ..study.identification.free_decay.decay import DecayFit
from ..study.identification.identified import Identified
from ..study.identification.orders.order_result import OrderScan
from ..study.identification.response_curve.response_fit import ResponseFit

MEASURED, FITTED = "#0072B2", "#D55E00"

MARKERS = "o^vsDPX*"


def draw_design(axes: Any, found: Design) -> None:
    """Draw the designs that serve: oscillation over the inertia of motor and wave generator at the load.

    Those of the Pareto front are filled; the limit is a dashed line.

    Parameters
    ----------
    axes : matplotlib Axes
        Where to draw; matplotlib is in the extra `plot`.
    found : Design
        Without a feasible design the limit alone is drawn.
    """
    best = set(found.pareto)
    for i, size in enumerate(sorted({c.size for c in found.feasible})):
        marker = MARKERS[i % len(MARKERS)]
        chosen = [c for c in found.feasible if c.size == size]
        x, y = np.array([(c.reflected_inertia, c.oscillation / ARCSEC) for c in chosen]).T
        filled = np.array([c in best for c in chosen])
        axes.plot(x, y, marker, mfc="none", mec="C0", label=f"size {size}")
        axes.plot(x[filled], y[filled], marker, mfc="C0", mec="C0")
    for c in found.pareto:
        place = c.reflected_inertia, c.oscillation / ARCSEC
        axes.annotate(c.gear, place, (0, -8), textcoords="offset points", fontsize=8, ha="center", va="top")
    axes.axhline(found.specification.limit / ARCSEC, color="0.4", ls="--", lw=1.0, label="limit")
    axes.set(xlabel="motor and wave generator at the load (kg m²)", ylabel="oscillation (arcsec)")
    low, high = axes.get_ylim()
    axes.set_ylim(low - 0.06 * (high - low), high + 0.06 * (high - low))
    axes.legend(fontsize=8, title="filled: Pareto front", title_fontsize=8)


def draw_decay(axes: Any, found: DecayFit) -> None:
    """Draw the frequency of a free decay against its amplitude, with 95 % bars, and that of the fitted system.

    Parameters
    ----------
    axes : matplotlib Axes
        Where to draw; matplotlib is in the extra `plot`.
    found : DecayFit
        The decay; the damping ratio is drawn on an axis to the right.
    """
    reach = 1.96
    order = np.argsort(found.amplitude)
    bars = {"fmt": "o", "ms": 4, "lw": 1.0}
    axes.errorbar(
        found.amplitude, found.omega, reach * found.omega_deviation, color=MEASURED, label="frequency", **bars
    )
    axes.plot(found.amplitude[order], found.fitted_omega[order], color=MEASURED, label="fitted")
    right = axes.twinx()
    ratio, fitted = 100.0 * found.rate / found.omega, 100.0 * found.fitted_rate / found.fitted_omega
    right.errorbar(
        found.amplitude, ratio, 100.0 * reach * found.rate_deviation / found.omega, color=FITTED, mfc="none",
        label="damping ratio", **bars,
    )  # fmt: skip
    right.plot(found.amplitude[order], fitted[order], "--", color=FITTED, label="fitted")
    right.set_ylabel("damping ratio (%)", color=FITTED)
    right.set_ylim(0.0, 2.0 * float(np.max(fitted)))
    axes.set_xlabel("amplitude of the first harmonic (rad)")
    axes.set_ylabel("frequency (rad/s)", color=MEASURED)
    lines = [*axes.get_legend_handles_labels()[0], *right.get_legend_handles_labels()[0]]
    axes.legend(handles=lines, fontsize=8, frameon=False)


def draw_response_fit(axes: Any, found: ResponseFit) -> None:
    """Draw the measured first harmonics, up and down, and the curve of the fitted system with its folds.

    Parameters
    ----------
    axes : matplotlib Axes
        Where to draw; matplotlib is in the extra `plot`.
    found : ResponseFit
        The fit; unstable parts of the curve are dashed.
    """
    curve = found.curve()
    size = curve.amplitude(1)
    for stable, dashes in ((True, "-"), (False, "--")):
        kept = np.where(curve.stable == stable, size, np.nan)
        axes.plot(curve.omega, kept, dashes, color="0.3", lw=1.2, label="fitted" if stable else "fitted, unstable")
    for up, mark, colour in ((True, "^", MEASURED), (False, "v", FITTED)):
        chosen = found.up == up
        if np.any(chosen):
            way = "up" if up else "down"
            shown = found.omega[chosen], np.abs(found.measured[chosen])
            axes.plot(*shown, mark, color=colour, ms=4, mfc="none", label=f"measured, sweep {way}")
    for low, high in found.jumps:
        axes.axvspan(low, high, color="0.88", lw=0.0)
    folds = curve.folds
    axes.plot([o.omega for o in folds], [o.amplitude(1) for o in folds], "ko", ms=5, label="folds")
    axes.set(xlabel="omega (rad/s)", ylabel="amplitude of the first harmonic (rad)")
    axes.legend(fontsize=8, frameon=False)


SHAPES = {
    "order": ("o", "stays with the angle"),
    "frequency": ("s", "stays with the time"),
    "undecided": ("^", "undecided"),
}


def draw_order_scan(axes: Any, found: OrderScan) -> None:
    """Draw the amplitude of each line over its order, with intervals of 95 %.

    Parameters
    ----------
    axes : matplotlib Axes
        Where to draw; matplotlib is in the extra `plot`.
    found : OrderScan
        The lines; the mark says what keeps a line in place.
    """
    for kind, (mark, label) in SHAPES.items():
        some = [line for line in found.lines if line.kind == kind]
        if not some:
            continue
        amplitudes = np.array([line.amplitude for line in some])
        errors = np.abs(np.clip([line.interval() for line in some], 0.0, None).T - amplitudes)
        orders, widths = [line.order for line in some], [line.order_error for line in some]
        axes.errorbar(orders, amplitudes, errors, widths, fmt=mark, ms=5, lw=1.0, color=MEASURED, mfc="w", label=label)
    axes.set(xlabel="order per turn", ylabel=f"amplitude ({found.unit.replace('*', '·') or '–'})")
    axes.set_ylim(bottom=0.0)
    if found.lines:
        axes.legend(fontsize=8, frameon=False)


def draw_identified(axes: Any, found: Identified) -> None:
    """Draw what is left of the first output over the time.

    Parameters
    ----------
    axes : matplotlib Axes
        Where to draw; matplotlib is in the extra `plot`.
    found : Identified
        The system and its residuals.
    """
    left = found.residual[0]
    axes.plot(found.step * np.arange(len(left)), left, color=MEASURED, lw=0.5)
    axes.set(xlabel="t (s)", ylabel="measured less computed", title=f"{found.outputs[0]}: {found.rms[0]:.3g} rms")
