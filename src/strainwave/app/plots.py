"""Look of the figures, SVG text with reproducible bytes, and the figure of one speed in time.

Colours are those of Okabe & Ito (colour-blind safe); every curve also differs by line style or marker. Amplitudes are
0-to-peak; the speed axis names its shaft.
"""

import io
import re
from typing import Any, cast

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from ..results import Floats
from ..study.time_case import TimeCase
from .console import number
from .facts import ARCSEC

BLUE, ORANGE, GREEN, BLACK, GREY = "#0072B2", "#D55E00", "#009E73", "#222222", "#8a8a8a"
STYLE: dict[str, Any] = {
    "svg.fonttype": "none",
    "svg.hashsalt": "strainwave",
    "font.size": 9,
    "axes.titlesize": 9.5,
    "axes.titlelocation": "left",
    "axes.titley": 1.0,  # fixed: looking for free space draws every axis twice
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
FOUR = {"left": 0.1, "right": 0.985, "bottom": 0.125, "top": 0.945, "wspace": 0.32, "hspace": 0.62}


def style() -> Any:
    """Context manager with the look of the report's figures."""
    return mpl.rc_context(cast(Any, STYLE))


def angle_unit(largest: float) -> tuple[str, float]:
    """Unit in which an angle at the load is shown, and its factor: arcsec up to one degree, then mrad."""
    return ("arcsec", ARCSEC) if largest * ARCSEC < 3600.0 else ("mrad", 1e3)


def svg(figure: Figure, label: str) -> str:
    """Return a figure as an inline SVG element, the same bytes every time."""
    for axes in figure.axes:
        axes.minorticks_off()
        width, height = axes.bbox.width / figure.dpi, axes.bbox.height / figure.dpi
        # fixed: beside the tick labels, whose size matplotlib would otherwise measure for every axis once more
        axes.xaxis.set_label_coords(0.5, -0.25 / height)
        axes.yaxis.set_label_coords(-0.45 / width, 0.5)
        if axes.get_yscale() == "linear":
            axes.locator_params(nbins=6 if len(figure.axes) == 1 else 4)
    stream = io.StringIO()
    figure.savefig(stream, format="svg", metadata={"Date": None, "Creator": None})
    text = stream.getvalue()
    text = text[text.index("<svg") :]
    text = re.sub(r"<metadata>.*?</metadata>\s*", "", text, flags=re.DOTALL)
    text = re.sub(r' id="[A-Za-z.]+[0-9]?[A-Za-z.]*_[0-9]+"', "", text)
    text = re.sub(r' (width|height)="[0-9.]+pt"', "", text, count=2)
    return text.replace("<svg ", f'<svg role="img" aria-label="{label}" ', 1).strip()


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
