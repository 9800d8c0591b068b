"""Results of ensembles on axes of matplotlib: basins, orbit diagrams, quantiles of the variability.

Colours are those of Okabe & Ito (colour-blind safe); what colour tells apart, the legend tells in words.
"""

from typing import Any

import numpy as np

from ..numerics.attractors.basins import CHAOTIC, DIVERGED, UNSETTLED, Basins
from ..numerics.attractors.poincare import OrbitDiagram
from ..study.variability.result import Variability
from ..units import ARCSEC

# of a basin: neighbours in this list differ in lightness, too, so that they are told apart in print without colour
BASIN = ("#cfe6f5", "#d9822b", "#00664b", "#e3c93b", "#9a5a86", "#1f63a8")
STRONG = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#A08A00", "#555555")
REST = {DIVERGED: ("#ffffff", "diverged"), CHAOTIC: ("#222222", "chaotic"), UNSETTLED: ("#888888", "not settled")}
MARKERS = "osD^vP"
CLEAR = 0.1  # part of neighbouring cells with different labels, beyond which a line between them would hide them


def draw_basins(axes: Any, found: Basins) -> None:
    """Draw the plane of initial states, coloured by where they lead, with the attractors' stroboscopic points.

    Parameters
    ----------
    axes : matplotlib Axes
        Where to draw; matplotlib is in the extra `plot`.
    found : Basins
        Beyond six attractors the smallest basins share a colour. Small angles are in mrad or arcsec.
    """
    (across, x_unit), (up, v_unit) = (angle_unit(found.spans[0]), angle_unit(found.spans[1]))
    (x0, x1), (v0, v1) = (np.array(span) / size for span, size in zip(found.spans, (across, up), strict=True))
    rgb = np.empty((len(found.label), 3))
    for label in np.unique(found.label):
        rgb[found.label == label] = _rgb(REST[label][0] if label < 0 else BASIN[min(label, len(BASIN) - 1)])
    if found.shape is None:
        axes.scatter(found.x / across, found.v / up, s=4.0, c=rgb, linewidths=0.0)
    else:
        axes.imshow(rgb.reshape(*found.shape, 3), extent=(x0, x1, v0, v1), origin="lower", aspect="auto")
        _draw_edges(axes, found, across, up)
    size, unit = angle_unit([attractor.amplitude for attractor in found.attractors])
    for i, attractor in enumerate(found.attractors):
        look = min(i, len(BASIN) - 1)
        p, error = found.share(i)
        amplitude = f"{attractor.amplitude / size:.3g} {unit}"
        axes.plot(
            attractor.points[:, 0] / across, attractor.points[:, 1] / up, MARKERS[look], ms=8.0, mfc=BASIN[look],
            mec="black" if _lightness(BASIN[look]) > 0.4 else "white", mew=1.2, ls="none",
            label=f"period {attractor.period}, amplitude {amplitude}: {p:.3f} ± {error:.3f}",
        )  # fmt: skip
    for label, (colour, name) in REST.items():
        p, error = found.share(label)
        if p > 0.0:
            axes.plot([], [], "s", mfc=colour, mec="#222222", ls="none", label=f"{name}: {p:.3f} ± {error:.3f}")
    axes.set(xlabel=f"initial x ({x_unit})", ylabel=f"initial x' ({v_unit}/s)", xlim=(x0, x1), ylim=(v0, v1))
    axes.locator_params(axis="x", nbins=7)
    axes.legend(fontsize=8, loc="upper center", bbox_to_anchor=(0.5, -0.14), frameon=False)


def _draw_edges(axes: Any, found: Basins, across: float, up: float) -> None:
    """Draw a thin line between basins, where these are no dust."""
    label = found.label.reshape(found.shape)
    edges = [label[1:] != label[:-1], label[:, 1:] != label[:, :-1]]
    if min(label.shape) < 2 or np.mean(np.concatenate([edge.ravel() for edge in edges])) > CLEAR:
        return
    x, v = found.x.reshape(found.shape)[0] / across, found.v.reshape(found.shape)[:, 0] / up
    for name in np.unique(label)[1:]:
        axes.contour(x, v, label >= name, levels=[0.5], colors="black", linewidths=0.5)


def draw_orbit_diagram(axes: Any, found: OrbitDiagram) -> None:
    """Draw the stroboscopic points over the parameter: the sweep up as dots, the sweep down as rings.

    Parameters
    ----------
    axes : matplotlib Axes
        Where to draw.
    found : OrbitDiagram
        All its starts in the same two colours. Small angles are in mrad or arcsec.
    """
    size, unit = angle_unit([found.up, found.down])
    each = found.up.shape[1] * found.up.shape[2]
    values = np.repeat(found.values, each)
    down = {"ms": 5.5, "mfc": "none", "mec": STRONG[1], "mew": 0.8, "ls": "none", "label": "sweep down"}
    axes.plot(values, found.down.ravel() / size, "o", **down)
    axes.plot(values, found.up.ravel() / size, "o", ms=3.0, mew=0.0, color=STRONG[0], label="sweep up")
    name = "speed omega" if found.parameter == "omega" else found.parameter
    axes.set(xlabel=f"{name} ({found.unit})" if found.unit else name, ylabel=f"x once per turn ({unit})")
    axes.legend(fontsize=8, frameon=False)


def draw_variability(axes: Any, found: Variability) -> None:
    """Draw the quantiles of the peak error: over the speed, or of one speed over the number of drives.

    Parameters
    ----------
    axes : matplotlib Axes
        Where to draw.
    found : Variability
        With two speeds or more the first form is taken. Bars are two standard errors long to each side; the dashed
        lines only lead the eye. Small angles are in mrad or arcsec.
    """
    by_speed = len(found.speeds) > 1
    if by_speed:
        across = np.array([s.omega for s in found.speeds])
        values, errors = np.array([s.quantiles for s in found.speeds]), np.array([s.errors for s in found.speeds])
    else:
        running = found.speeds[0].running
        across, values, errors = running.counts, running.values, running.errors
    size, unit = angle_unit(values)
    for i, share in enumerate(found.speeds[0].shares):
        look = i % len(STRONG)
        axes.errorbar(
            across, values[:, i] / size, 2.0 * errors[:, i] / size, fmt=MARKERS[look], ms=4.5, color=STRONG[look],
            capsize=2.5, elinewidth=1.0, ls="--", lw=0.6, label=f"{share:.0%} of drives",
        )  # fmt: skip
    axes.set(xlabel="speed (rad/s)" if by_speed else "drives", ylabel=f"peak |x| ({unit})")
    if not by_speed:
        ticks = [2**k for k in range(int(np.log2(across[0])), int(np.log2(across[-1])) + 1)]
        ticks += [int(across[-1])] if across[-1] > 1.3 * ticks[-1] else []
        axes.set_xscale("log", base=2)
        axes.set_xticks(ticks, [str(count) for count in ticks])
    axes.legend(fontsize=8, frameon=False)


def angle_unit(values: Any) -> tuple[float, str]:
    """Size [rad] and name of the unit that suits angles whose largest is that of `values`."""
    finite = np.abs(np.asarray(values, float))[np.isfinite(values)]
    largest = np.max(finite, initial=0.0)
    if largest == 0.0 or largest >= 0.1:
        return 1.0, "rad"
    return (1e-3, "mrad") if largest >= 2e-3 else (ARCSEC, "arcsec")


def _lightness(colour: str) -> float:
    return float(np.dot(_rgb(colour), (0.299, 0.587, 0.114)))


def _rgb(colour: str) -> list[float]:
    return [int(colour[i : i + 2], 16) / 255.0 for i in (1, 3, 5)]
