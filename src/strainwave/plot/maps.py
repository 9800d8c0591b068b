"""Maps over two parameters on axes of matplotlib: where multiple scales hold.

An order has its own colour (Okabe & Ito) and its own kind of line, and every line says its percent: nothing is told
apart by colour alone.
"""

from typing import Any

import numpy as np

from ..study.response.validity_results import LEVELS, ORDERS, GeneralValidity, ValidityMap
from .ensembles import STRONG

LINES = ("-", "--")
WIDTHS = (0.9, 1.6, 2.4)  # of the levels, from small to large errors
FLOOR = 1e-6  # of an error on the logarithmic scale on which contours are drawn
NAMES = ("first", "second")


def draw_validity(axes: Any, found: ValidityMap) -> None:
    """Draw the contours of 1, 5 and 20 % error of both orders over speed and strength of the excitation.

    Parameters
    ----------
    axes : matplotlib Axes
        Where to draw; matplotlib is in the extra `plot`.
    found : ValidityMap
        An order without a contour holds, or fails, in the whole map; the legend says so.
    """
    _contours(axes, found.speeds, found.amplitudes, found.error)
    axes.set(xlabel="speed omega (rad/s)", ylabel="excitation over that of the system (1)")
    if found.amplitudes[-1] > 5.0 * found.amplitudes[0]:
        axes.set_yscale("log")


def draw_general_validity(axes: Any, found: GeneralValidity) -> None:
    """Draw the contours of 1, 5 and 20 % error of both orders over alpha a^2 and the damping ratio."""
    _contours(axes, found.bend, found.damping_ratio, found.error)
    axes.set(xscale="log", yscale="log", xlabel="alpha a² at the peak (1)", ylabel="damping ratio zeta (1)")


def _contours(axes: Any, across: Any, up: Any, error: Any) -> None:
    for i, order in enumerate(ORDERS):
        style = {"colors": STRONG[i], "linestyles": LINES[i]}
        height = np.log(np.maximum(error[i].T, FLOOR))
        name, there = f"{NAMES[order - 1]} order", []
        for level, width in zip(LEVELS, WIDTHS, strict=True):
            inside = error[i] <= 0.01 * level
            if np.all(inside) or not np.any(inside):
                there.append(f"{'within' if np.all(inside) else 'beyond'} {level:g} % everywhere")
                continue
            lines = axes.contour(across, up, height, levels=[np.log(0.01 * level)], linewidths=width, **style)
            axes.clabel(lines, fmt=lambda _, level=level: f"{level:g} %", fontsize=8, inline_spacing=1)
        # the strictest level within which, and the widest beyond which
        said = [part for part in (*there[:1],) if part.startswith("within")] or there[-1:]
        axes.plot([], [], color=STRONG[i], ls=LINES[i], label=", ".join([name, *said]))
    axes.legend(fontsize=8, loc="upper center", bbox_to_anchor=(0.5, -0.14), frameon=False, ncols=2)
