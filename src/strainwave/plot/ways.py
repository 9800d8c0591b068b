"""Moves and run-ups in closed loop, monitored records and predictions on axes of matplotlib."""

from typing import Any

import numpy as np

from ..study.compensation.monitoring import Monitored
from ..study.compensation.moves import CompensatedMove
from ..study.compensation.prediction import PredictionTable
from ..study.compensation.runup import CompensatedRunup
from ..units import RPM
from .compensation import DASHES
from .ensembles import STRONG, angle_unit


def _look(i: int) -> dict[str, Any]:
    return {"color": STRONG[i % len(STRONG)], "ls": DASHES[i % len(DASHES)], "lw": 1.1}


def draw_compensated_move(axes: Any, found: CompensatedMove) -> None:
    """Draw the distance of the load from the profile over the time, for every controller."""
    size, unit = angle_unit(found.error)
    for i, (score, error) in enumerate(zip(found.scores, found.error, strict=True)):
        axes.plot(found.time, error / size, label=score.name, **_look(i))
    axes.axvline(found.duration, color="0.5", lw=0.8, ls=":")
    axes.set(xlabel="t (s)", ylabel=f"error of the load ({unit})")
    axes.legend(fontsize=7, frameon=False)


def draw_compensated_runup(axes: Any, found: CompensatedRunup) -> None:
    """Draw the error over the speed, full on the way up and dotted on the way down."""
    size, unit = angle_unit(found.up)
    for i, name in enumerate(found.names):
        colour = STRONG[i % len(STRONG)]
        axes.plot(found.speed / RPM, found.up[i] / size, "-", color=colour, lw=1.2, label=f"{name}, up")
        axes.plot(found.speed / RPM, found.down[i] / size, ":", color=colour, lw=1.6, label=f"{name}, down")
    axes.set(xlabel="motor speed (rpm)", ylabel=f"largest error ({unit})", yscale="log")
    axes.legend(fontsize=7, frameon=False)


def draw_monitored(axes: Any, found: Monitored) -> None:
    """Draw the amplitudes of the orders over the time, from where they have settled on."""
    late = found.time >= found.settled_from
    shown = late if np.any(late) else slice(None)
    for i, (order, row) in enumerate(zip(found.orders, found.amplitude, strict=True)):
        axes.plot(found.time[shown], row[shown], label=f"order {order:g}", **_look(i))
    axes.set(xlabel="t (s)", ylabel="amplitude (units of the signal)")
    axes.legend(fontsize=8, frameon=False)


def draw_predictions(axes: Any, found: PredictionTable) -> None:
    """Draw the amplitudes of the orders over the speed, full where the motion is stable and dotted where not.

    Valid closed forms are dots.
    """
    size, unit = angle_unit(np.abs(found.amplitudes))
    for i, (order, row) in enumerate(zip(found.orders, np.abs(found.amplitudes) / size, strict=True)):
        colour = STRONG[i % len(STRONG)]
        axes.plot(found.omega / RPM, row, ":", color=colour, lw=1.0)
        for a, b in found.runs():
            label = f"order {order}" if a == found.runs()[0][0] else None
            axes.plot(found.omega[a:b] / RPM, row[a:b], "-", color=colour, lw=1.4, label=label)
        if found.closed is not None and found.valid is not None:
            at = found.valid
            axes.plot(found.omega[at] / RPM, np.abs(found.closed[i, at]) / size, ".", color=colour, ms=3.0)
    axes.set(xlabel="motor speed (rpm)", ylabel=f"amplitude of the error ({unit})", yscale="log")
    axes.legend(fontsize=8, frameon=False)
