"""A speed map on axes of matplotlib: the largest oscillation over speed and load, and what is forbidden."""

from typing import Any

import numpy as np

from ..study.speed_map.result import SpeedMap
from ..units import ARCSEC, RPM

LIGHT = 2.0  # of the range of sizes: where the darkest shade would be
INK = "#8c2d04"  # of what is forbidden


def draw_speed_map(axes: Any, found: SpeedMap) -> None:
    """Draw the largest oscillation in shades of grey, forbidden speeds hatched, and the vendors' resonance speed.

    Parameters
    ----------
    axes : matplotlib Axes
        Where to draw; matplotlib is in the extra `plot`.
    found : SpeedMap
        With one load it is drawn as a bar.
    """
    step = float(np.min(np.diff(found.loads))) if len(found.loads) > 1 else 1.0
    edges = np.concatenate([found.loads - 0.5 * step, [found.loads[-1] + 0.5 * step]])
    across = found.speeds / RPM
    middle = np.concatenate([across[:1], 0.5 * (across[1:] + across[:-1]), across[-1:]])
    size = np.log10(np.where(np.isfinite(found.oscillation), found.oscillation, np.nan) / ARCSEC)
    low, high = float(np.nanmin(size)), float(np.nanmax(size))
    shades = {"cmap": "Greys", "vmin": low, "vmax": low + LIGHT * (high - low)}  # the hatching stands out from all
    drawn = axes.pcolormesh(middle, edges, size, shading="flat", rasterized=True, **shades)
    axes.figure.colorbar(drawn, ax=axes, label="largest oscillation (log10 of arcsec)")
    for load, bands in zip(found.loads.tolist(), found.forbidden, strict=True):
        for low, high in bands / RPM:
            axes.broken_barh(
                [(low, high - low)],
                (load - 0.5 * step, step),
                facecolor="none",
                edgecolor="#D55E00",
                hatch="///",
                lw=0.8,
            )
    axes.broken_barh([], (0, 0), facecolor="none", edgecolor=INK, hatch="///", label="forbidden")
    if found.vendor:
        speeds = [rule.speed / RPM for rule in found.vendor]
        axes.plot(speeds, [rule.load for rule in found.vendor], "k--", lw=1.5, label="vendors' rule, 30 f_n")
    unit = "N·m" if found.load_name == "load torque" else "kg·m²"
    axes.set(xlabel="motor speed (rpm)", ylabel=f"{found.load_name} ({unit})", xlim=(across[0], across[-1]))
    axes.legend(fontsize=8, loc="upper center", bbox_to_anchor=(0.5, -0.14), frameon=False, ncols=2)
