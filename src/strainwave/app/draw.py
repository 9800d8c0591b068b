"""Results of ensembles on axes of matplotlib: basins, orbit diagrams, quantiles of the variability.

Colours are those of Okabe & Ito (colour-blind safe); what colour tells apart, the legend tells in words.
"""

from typing import Any

import numpy as np

from ..numerics.basins import CHAOTIC, DIVERGED, UNSETTLED, Basins
from ..numerics.poincare import OrbitDiagram
from ..study.variability_result import Variability

PALE = ("#9ecae1", "#f5c48a", "#a3d9c3", "#e3b9d3", "#f2eb9b", "#c7c7c7")
STRONG = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#A08A00", "#555555")
REST = {DIVERGED: ("#ffffff", "diverged"), CHAOTIC: ("#222222", "chaotic"), UNSETTLED: ("#888888", "not settled")}
MARKERS = "osD^vP"


def draw_basins(axes: Any, found: Basins) -> None:
    """Draw the plane of initial states, coloured by where they lead, with the attractors' stroboscopic points.

    Parameters
    ----------
    axes : matplotlib Axes
        Where to draw; matplotlib is in the extra `plot`.
    found : Basins
        Beyond six attractors the smallest basins share a colour.
    """
    (x0, x1), (v0, v1) = found.spans
    rgb = np.empty((len(found.label), 3))
    for label in np.unique(found.label):
        rgb[found.label == label] = _rgb(REST[label][0] if label < 0 else PALE[min(label, len(PALE) - 1)])
    if found.shape is None:
        axes.scatter(found.x, found.v, s=4.0, c=rgb, linewidths=0.0)
    else:
        axes.imshow(rgb.reshape(*found.shape, 3), extent=(x0, x1, v0, v1), origin="lower", aspect="auto")
    for i, attractor in enumerate(found.attractors):
        look = min(i, len(STRONG) - 1)
        p, error = found.share(i)
        axes.plot(
            *attractor.points[:, :2].T, MARKERS[look], ms=7.0, mfc=STRONG[look], mec="white", ls="none",
            label=f"period {attractor.period}, amplitude {attractor.amplitude:.3g} rad: {p:.3f} ± {error:.3f}",
        )  # fmt: skip
    for label, (colour, name) in REST.items():
        p, error = found.share(label)
        if p > 0.0:
            axes.plot([], [], "s", mfc=colour, mec="#222222", ls="none", label=f"{name}: {p:.3f} ± {error:.3f}")
    axes.set(xlabel="initial x (rad)", ylabel="initial x' (rad/s)", xlim=(x0, x1), ylim=(v0, v1))
    axes.locator_params(axis="x", nbins=7)
    axes.legend(fontsize=8, loc="upper center", bbox_to_anchor=(0.5, -0.14), frameon=False)


def draw_orbit_diagram(axes: Any, found: OrbitDiagram) -> None:
    """Draw the stroboscopic points over the parameter: the sweep up as dots, the sweep down as rings.

    Parameters
    ----------
    axes : matplotlib Axes
        Where to draw.
    found : OrbitDiagram
        All its starts in the same two colours.
    """
    each = found.up.shape[1] * found.up.shape[2]
    values = np.repeat(found.values, each)
    down = {"ms": 2.6, "mfc": "none", "mec": STRONG[1], "mew": 0.5, "ls": "none", "label": "sweep down"}
    axes.plot(values, found.down.ravel(), "o", **down)
    axes.plot(values, found.up.ravel(), ".", ms=1.4, color=STRONG[0], label="sweep up")
    axes.set(xlabel=found.parameter, ylabel="x once per turn (rad)")
    axes.legend(fontsize=8, markerscale=4.0, frameon=False)


def draw_variability(axes: Any, found: Variability) -> None:
    """Draw the quantiles of the peak error: over the speed, or of one speed over the number of drives.

    Parameters
    ----------
    axes : matplotlib Axes
        Where to draw.
    found : Variability
        With two speeds or more the first form is taken; bands are two standard errors wide to each side.
    """
    by_speed = len(found.speeds) > 1
    if by_speed:
        across = np.array([s.omega for s in found.speeds])
        values, errors = np.array([s.quantiles for s in found.speeds]), np.array([s.errors for s in found.speeds])
    else:
        running = found.speeds[0].running
        across, values, errors = running.counts, running.values, running.errors
    for i, share in enumerate(found.speeds[0].shares):
        look = i % len(STRONG)
        low, high = values[:, i] - 2.0 * errors[:, i], values[:, i] + 2.0 * errors[:, i]
        axes.fill_between(across, low, high, color=STRONG[look], alpha=0.25, lw=0.0)
        axes.plot(across, values[:, i], MARKERS[look] + "-", ms=4.0, color=STRONG[look], label=f"{share:.0%} of drives")
    axes.set(xlabel="speed (rad/s)" if by_speed else "drives", ylabel="peak |x| (rad)")
    axes.set_xscale("linear" if by_speed else "log")
    axes.legend(fontsize=8, frameon=False)


def _rgb(colour: str) -> list[float]:
    return [int(colour[i : i + 2], 16) / 255.0 for i in (1, 3, 5)]
