"""Figures of the report as SVG text: reproducible bytes, legible in colour, in grey and in print.

Colours are those of Okabe & Ito (colour-blind safe); every curve also differs by line style or marker. Amplitudes are
0-to-peak; the speed axis names its shaft.
"""

import io
import re
from itertools import pairwise
from typing import Any, cast

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from ..results import Floats
from ..study.analysis import Analysis
from ..study.regimes import Regime
from ..study.time_case import TimeCase
from .console import number
from .facts import ARCSEC, RPM
from .project import Project

BLUE, ORANGE, GREEN, BLACK, GREY = "#0072B2", "#D55E00", "#009E73", "#222222", "#8a8a8a"
STYLE: dict[str, Any] = {
    "svg.fonttype": "none",
    "svg.hashsalt": "strainwave",
    "font.size": 9,
    "axes.titlesize": 9.5,
    "axes.titlelocation": "left",
    "font.family": "sans-serif",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.linewidth": 0.7,
    "axes.grid": True,
    "grid.color": "#dddddd",
    "grid.linewidth": 0.5,
    "lines.linewidth": 1.3,
    "legend.frameon": False,
    "legend.fontsize": 8,
    "axes.labelcolor": BLACK,
    "path.simplify": True,
    "path.simplify_threshold": 0.3,
    "axes.formatter.use_mathtext": False,
    "axes.formatter.limits": (-4, 5),
    "axes.unicode_minus": True,
}
BINS, MOST_CYCLES = 350, 40
WIDE = (
    0.115,
    0.285,
    0.865,
    0.635,
)  # places in the figure, fixed: measuring every label twice would take as long as drawing
FOUR = {"left": 0.1, "right": 0.985, "bottom": 0.125, "top": 0.945, "wspace": 0.32, "hspace": 0.62}


def style() -> Any:
    """Context manager with the look of the report's figures."""
    return mpl.rc_context(cast(Any, STYLE))


def angle_unit(largest: float) -> tuple[str, float]:
    """Unit in which an angle at the load is shown, and its factor: arcsec up to one degree, then mrad."""
    return ("arcsec", ARCSEC) if largest * ARCSEC < 3600.0 else ("mrad", 1e3)


def speed_axis(project: Project) -> tuple[str, float]:
    """Label and factor of the speed axis: motor rpm, or rad/s where the base angle is a forcing phase."""
    return ("forcing frequency ω (rad/s)", 1.0) if project.shaft == "forcing" else ("motor speed (rpm)", RPM)


def svg(figure: Figure, label: str) -> str:
    """Return a figure as an inline SVG element, the same bytes every time."""
    for axes in figure.axes:
        axes.minorticks_off()
        if axes.get_yscale() == "linear":
            axes.locator_params(nbins=6)
    stream = io.StringIO()
    figure.savefig(stream, format="svg", metadata={"Date": None, "Creator": None})
    text = stream.getvalue()
    text = text[text.index("<svg") :]
    text = re.sub(r"<metadata>.*?</metadata>\s*", "", text, flags=re.DOTALL)
    text = re.sub(r' id="[A-Za-z.]+[0-9]?[A-Za-z.]*_[0-9]+"', "", text)
    text = re.sub(r' (width|height)="[0-9.]+pt"', "", text, count=2)
    return text.replace("<svg ", f'<svg role="img" aria-label="{label}" ', 1).strip()


def speed_range(project: Project, analysis: Analysis) -> Figure:
    """Largest error through the speed range, up and down, with the resonances and the gear's speed limit marked."""
    sweep = analysis.run_up
    good = [m.peak for m in (*sweep.up, *sweep.down) if m.status]
    unit, factor = angle_unit(max(good))
    label, scale = speed_axis(project)
    figure = Figure(figsize=(7.2, 3.4))
    axes = figure.add_axes(WIDE)
    for motions, marker, name, colour, line, size in (
        (sweep.up, "^", "run-up (integration)", BLUE, "-", 5.5),
        (sweep.down, "v", "coast-down (integration)", ORANGE, "--", 4.0),
    ):
        x = [scale * w for w, m in zip(sweep.omega, motions, strict=True) if m.status]
        y = [factor * m.peak for m in motions if m.status]
        face = colour if marker == "^" else "white"
        axes.plot(x, y, line, marker=marker, color=colour, mfc=face, ms=size, lw=1.0, label=name)
    if max(good) > 30.0 * min(good) > 0.0:
        axes.set_yscale("log")
    else:
        axes.set_ylim(bottom=0.0)
    _mark_resonances(axes, analysis, scale)
    gear = project.gear
    if gear is not None and project.shaft != "forcing" and gear.max_rpm <= 1.05 * scale * sweep.omega[-1]:
        axes.axvline(
            gear.max_rpm, color=BLACK, lw=1.2, ls=(0, (1, 1)), label=f"largest input speed, {gear.max_rpm:.0f} rpm"
        )
    axes.set_xlabel(label)
    axes.set_ylabel(f"largest |x| at the load\n({unit}, 0-to-peak)")
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.17), ncols=3)
    return figure


def _mark_resonances(axes: Any, analysis: Analysis, scale: float) -> None:
    """Thin lines at the resonances in the range, numbered as in the table."""
    inside = [(i, r) for i, r in enumerate(analysis.regimes, 1) if r.inside]
    low, high = scale * analysis.speeds[0], scale * analysis.speeds[1]
    axes.set_xlim(low - 0.02 * (high - low), high + 0.02 * (high - low))
    last, level = -np.inf, 0
    for i, regime in inside:
        at = scale * regime.omega
        level = (level + 1) % 3 if at - last < 0.03 * (high - low) else 0
        last = at
        axes.axvline(at, color=GREY, lw=0.7, ls=(0, (4, 3)), zorder=0)
        axes.annotate(
            f"{i}",
            (at, 1.0),
            xycoords=axes.get_xaxis_transform(),
            xytext=(0, 2 + 9 * level),
            textcoords="offset points",
            ha="center",
            va="bottom",
            fontsize=8,
            color=BLACK,
        )


def response(project: Project, analysis: Analysis, regime: Regime) -> Figure:
    """Response curve of one resonance: multiple scales with stability, folds and backbone, and the simulated points."""
    curve = regime.response
    if curve is None or not curve.branches:
        raise ValueError(f"the {regime.label} resonance has no response curve")
    label, scale = speed_axis(project)
    unit, factor = angle_unit(curve.peak[1])
    figure = Figure(figsize=(7.2, 3.5))
    axes = figure.add_axes(WIDE)
    for branch in curve.branches:
        for part, stable in _pieces(branch.stable):
            line: dict[str, Any] = (
                {"ls": "-", "color": BLACK, "lw": 1.6} if stable else {"ls": (0, (4, 2)), "color": ORANGE, "lw": 1.4}
            )
            axes.plot(scale * branch.omega[part], factor * branch.amplitude[part], **line)
    axes.plot([], [], color=BLACK, lw=1.6, label="multiple scales, stable")
    if not all(np.all(b.stable) for b in curve.branches):
        axes.plot([], [], color=ORANGE, ls=(0, (4, 2)), lw=1.4, label="multiple scales, unstable")
    low, high = _shown(curve)
    if regime.backbone is not None:
        axes.plot(
            scale * regime.backbone[0], factor * regime.backbone[1], color=GREY, ls="-.", lw=1.0, label="backbone"
        )
    _simulated(axes, analysis, regime, (low, high), scale, factor)
    for omega, amplitude in zip(curve.folds, curve.fold_amplitudes, strict=True):
        axes.plot([scale * omega], [factor * amplitude], "o", mfc="white", mec=BLACK, ms=6, zorder=5)
        axes.annotate(
            f"{scale * omega:.5g}",
            (scale * omega, factor * amplitude),
            xytext=(7, -2),
            textcoords="offset points",
            fontsize=8,
            va="center",
            bbox={"fc": "white", "ec": "none", "pad": 0.8, "alpha": 0.8},
            zorder=6,
        )
    if curve.folds:
        axes.plot([], [], "o", mfc="white", mec=BLACK, ms=6, label="fold (jump)")
    axes.set_xlim(scale * low, scale * high)
    axes.set_ylim(bottom=0.0)
    turning = "ω" if project.shaft == "forcing" else "motor speed"
    place = turning if regime.resonance.ratio == 1 else f"{regime.resonance.ratio} × {turning}"
    axes.set_xlabel(label)
    axes.set_ylabel(f"torsion amplitude at {place}\n({unit}, 0-to-peak)")
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.17), ncols=3)
    return figure


def _shown(curve: Any) -> tuple[float, float]:
    """Band in which the curve stands above a twelfth of its peak."""
    omega = np.concatenate([b.omega for b in curve.branches])
    amplitude = np.concatenate([b.amplitude for b in curve.branches])
    high = omega[amplitude > curve.peak[1] / 12.0]
    margin = 0.12 * float(np.ptp(high)) + 1e-5 * float(np.mean(high))
    return max(float(np.min(high)) - margin, float(np.min(omega))), min(
        float(np.max(high)) + margin, float(np.max(omega))
    )


def _pieces(stable: Any) -> list[tuple[slice, bool]]:
    """Runs of equal stability along an arc, each one point longer so that the line does not break."""
    cuts = [0, *(np.flatnonzero(np.diff(stable.astype(int))) + 1), len(stable)]
    return [(slice(a, min(b + 1, len(stable))), bool(stable[a])) for a, b in pairwise(cuts)]


def _simulated(
    axes: Any, analysis: Analysis, regime: Regime, band: tuple[float, float], scale: float, factor: float
) -> None:
    """Points of the run-up and coast-down inside the band: the component that the curve shows."""
    ratio = float(regime.resonance.ratio or 1)
    sweep = analysis.run_up
    for motions, marker, name, colour, size in (
        (sweep.up, "^", "run-up (integration)", BLUE, 6.0),
        (sweep.down, "v", "coast-down (integration)", ORANGE, 4.5),
    ):
        points = [
            (scale * w, factor * m.torsion_amplitude(ratio))
            for w, m in zip(sweep.omega, motions, strict=True)
            if m.status and band[0] <= w <= band[1] and abs(ratio * m.period % 1.0) < 1e-9
        ]
        if points:
            face = colour if marker == "^" else "white"
            axes.plot(
                *zip(*points, strict=True), marker, color=colour, mfc=face, ms=size, ls="none", label=name, zorder=4
            )


def time_figure(case: TimeCase) -> Figure:
    """One speed in time: from rest, the last periods, the phase portrait, and the transmitted torque."""
    unit, factor = angle_unit(case.peak_from_rest)
    figure = Figure(figsize=(7.2, 5.2))
    (rest, last), (portrait, torque) = figure.subplots(2, 2, gridspec_kw=FOUR)
    _from_rest(rest, case, unit, factor)
    if case.cycle is None:
        for axes in (last, portrait, torque):
            axes.set_axis_off()
        return figure
    cycle = case.cycle
    shown = 2 if case.steady.period == 1 else 1
    t = np.concatenate([cycle.t + i * cycle.t[-1] for i in range(shown)]) * 1e3
    last.plot(t, np.tile(cycle.x, shown) * factor, color=BLUE, label="integration")
    if case.steady_theory is not None:
        last.plot(t, np.tile(case.steady_theory, shown) * factor, color=ORANGE, ls=(0, (4, 2)), label="multiple scales")
    last.set(title="steady motion", xlabel="time (ms)", ylabel=f"x ({unit})")
    last.legend(loc="upper center", bbox_to_anchor=(0.5, -0.22), ncols=2)
    rate_unit, rate = ("rad/s", 1.0) if np.max(np.abs(cycle.v)) > 1.0 else ("mrad/s", 1e3)
    portrait.plot(cycle.x * factor, cycle.v * rate, color=BLUE)
    each = (len(cycle.x) - 1) // case.steady.period
    portrait.plot(
        cycle.x[:-1:each] * factor,
        cycle.v[:-1:each] * rate,
        "o",
        color=ORANGE,
        mec=BLACK,
        ms=5,
        label="once per turn of the base angle",
    )
    portrait.set(title="phase portrait of the steady motion", xlabel=f"x ({unit})", ylabel=f"x' ({rate_unit})")
    portrait.legend(loc="upper center", bbox_to_anchor=(0.5, -0.22))
    torque.plot(t, np.tile(cycle.torque, shown), color=GREEN)
    mean = cycle.mean_torque if abs(cycle.mean_torque) > 1e-6 * cycle.peak_torque else 0.0
    torque.axhline(mean, color=GREY, ls="-.", lw=0.9, label=f"mean {number(mean)} N·m")
    torque.set(
        title=f"transmitted torque, peak {number(cycle.peak_torque)} N·m",
        xlabel="time (ms)",
        ylabel="T(u) + B u' (N·m)",
    )
    torque.legend(loc="upper center", bbox_to_anchor=(0.5, -0.22))
    return figure


def _from_rest(axes: Any, case: TimeCase, unit: str, factor: float) -> None:
    """The start: both solutions as lines, or the band between their extremes where cycles would not show."""
    run = case.transient
    seconds, name = (1.0, "s") if run.t[-1] > 0.5 else (1e3, "ms")
    crossings = np.count_nonzero(np.diff(np.sign(run.y[0] - np.mean(run.y[0]))))
    theory = None if case.comparison is None else case.comparison.theory
    dashes = {"color": ORANGE, "ls": (0, (4, 2)), "lw": 1.1}
    if crossings < 2 * MOST_CYCLES:
        axes.plot(run.t * seconds, run.y[0] * factor, color=BLUE, lw=1.0, label="integration")
        if theory is not None:
            axes.plot(theory.t * seconds, theory.x * factor, label="multiple scales", **dashes)
    else:
        turns = max(12, int(run.t[-1] * case.omega / (2.0 * np.pi)))
        low, high, t = _envelope(run.t * seconds, run.y[0] * factor, turns)
        axes.fill_between(t, low, high, color=BLUE, alpha=0.45, lw=0.3, label="integration")
        if theory is not None:
            low, high, t = _envelope(theory.t * seconds, theory.x * factor, turns)
            axes.plot(t, high, label="multiple scales", **dashes)
            axes.plot(t, low, **dashes)
    title = f"from rest, largest |x| {number(case.peak_from_rest * factor)} {unit}"
    axes.set(title=title, xlabel=f"time ({name})", ylabel=f"x ({unit})")
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.22), ncols=2)


def _envelope(t: Floats, x: Floats, turns: int) -> tuple[Floats, Floats, Floats]:
    """Lowest and highest value in each of at most `BINS` equal pieces, each a turn of the base angle or longer."""
    pieces = np.array_split(np.arange(len(t)), min(BINS, turns))
    low = np.array([float(np.min(x[p])) for p in pieces])
    high = np.array([float(np.max(x[p])) for p in pieces])
    at = np.array([float(np.mean(t[p])) for p in pieces])
    at[0], at[-1] = t[0], t[-1]
    return low, high, at
