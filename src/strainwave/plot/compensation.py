"""Compensations and sampled loops on axes of matplotlib: orders before and after, controllers over the speed, units."""

from typing import Any

import numpy as np

from ..numerics.sampled.linear import LoopResponse
from ..numerics.sampled.result import LoopEnsemble, LoopRun
from ..results import Floats
from ..study.compensation.result import Compensation, CompensationBench, Units
from ..units import RPM
from .ensembles import MARKERS, STRONG, angle_unit

DASHES = ("-", "--", "-.", ":")


def draw_compensation(axes: Any, found: Compensation) -> None:
    """Draw the amplitudes of the pointing error by order, under the plain loop and under the controller.

    Parameters
    ----------
    axes : matplotlib Axes
        Where to draw; matplotlib is in the extra `plot`.
    found : Compensation
        Its amplitudes are drawn on a logarithmic axis.
    """
    size, unit = angle_unit(found.amplitude_before)
    for amplitude, name, marker, aside in (
        (found.amplitude_before, "plain loop", "s", -0.05),
        (found.amplitude_after, found.name, "o", 0.05),
    ):
        colour = STRONG[0] if marker == "o" else STRONG[1]
        axes.plot(found.orders + aside, amplitude / size, marker, color=colour, label=name)
        axes.vlines(found.orders + aside, 0.0, amplitude / size, color=colour)
    axes.set(xlabel="order of the motor's angle", ylabel=f"amplitude of the error ({unit})", yscale="log")
    axes.set(xlim=(0.0, float(np.max(found.orders)) + 1.0), xticks=found.orders, title=f"{found.speed / RPM:.4g} rpm")
    axes.legend(fontsize=8, frameon=False)


def draw_compensation_bench(axes: Any, found: CompensationBench) -> None:
    """Draw the rms of the residual of every controller over the speed, with that of the plain loop."""
    before = np.array([one.before.rms for one in found.results[0]])
    size, unit = angle_unit(before)
    rpm = found.speeds / RPM
    axes.plot(rpm, before / size, "k-", lw=2.4, label="plain loop")
    for i, (name, row) in enumerate(zip(found.names, found.results, strict=True)):
        if name != "loop":
            look = {"color": STRONG[i % len(STRONG)], "ls": DASHES[i // len(STRONG) % len(DASHES)]}
            rms = np.array([one.after.rms for one in row]) / size
            axes.plot(rpm, rms, marker=MARKERS[i % len(MARKERS)], ms=4.0, lw=1.2, label=name, **look)
    axes.set(xlabel="motor speed (rpm)", ylabel=f"rms of the error ({unit})", yscale="log")
    if np.all(rpm > 0.0):  # what is negative has no logarithm: backward motion
        axes.set_xscale("log")
    axes.legend(fontsize=7, frameon=False, ncols=2)


def draw_units(axes: Any, found: Units) -> None:
    """Draw the share of the units whose rms is below a value, under the plain loop and under the controller."""
    _, size, unit = _shares(axes, found.before.rms, STRONG[1], "--", "plain loop", None)
    _shares(axes, found.after.rms, STRONG[0], "-", "controller", size)
    axes.set(xlabel=f"rms of the error ({unit})", ylabel="share of the units (%)", xscale="log")
    axes.legend(fontsize=8, frameon=False)


def draw_loops(axes: Any, found: LoopEnsemble) -> None:
    """Draw the share of the loops whose rms is below a value."""
    _, _, unit = _shares(axes, found.rms, STRONG[0], "-", "", None)
    axes.set(xlabel=f"rms of the error ({unit})", ylabel="share of the loops (%)")


def draw_loop(axes: Any, found: LoopRun) -> None:
    """Draw the error over the time."""
    size, unit = angle_unit(found.error)
    axes.plot(found.time, found.error / size, color=STRONG[0], lw=0.8)
    axes.set(xlabel="t (s)", ylabel=f"error ({unit})")


def draw_loop_response(axes: Any, found: LoopResponse) -> None:
    """Draw the size of the error that a torque of 1 N*m gives, over its frequency."""
    size, unit = angle_unit(np.abs(found.error_of_torque))
    hertz = found.omega / (2.0 * np.pi)
    axes.plot(hertz, np.abs(found.error_of_torque) / size, color=STRONG[0])
    axes.set(xlabel="frequency (Hz)", ylabel=f"error over torque ({unit}/(N m))", yscale="log")


def _shares(axes: Any, rms: Floats, colour: str, dash: str, label: str, size: float | None) -> tuple[Any, float, str]:
    """Draw shares below a value; sizes in the unit given, or in one that suits them."""
    good = np.sort(rms[np.isfinite(rms)])
    own, unit = angle_unit(good)
    size = own if size is None else size
    share = 100.0 * np.arange(1, len(good) + 1) / len(rms)
    return axes.step(good / size, share, where="post", color=colour, ls=dash, label=label), size, unit
