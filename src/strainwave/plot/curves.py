"""Response curves, orbits and motions on axes of matplotlib; stable parts are solid, unstable ones dashed."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..results import Branch, Orbit, Trajectory
from ..study.analysis.drive_response import DriveResponse
from ..study.move.result import Move
from ..study.response.response import ExactResponse
from ..study.train.bode import Bode
from ..study.train.run import DriveRun
from ..theory.slow_flow.results import SlowResponse
from ..units import RPM
from .ensembles import STRONG, angle_unit

SAMPLES = 16  # of an orbit, per harmonic


def draw_branch(axes: Any, found: Branch) -> None:
    """Draw the largest |first state| over the parameter, with the folds as rings.

    Parameters
    ----------
    axes : matplotlib Axes
        Where to draw; matplotlib is in the extra `plot`.
    found : Branch
        Its first state counts as an angle: small ones are in mrad or arcsec.
    """
    size, unit = angle_unit(found.peak)
    _draw_stability(axes, found.values, found.peak / size, found.stable, "peak |x|")
    if found.folds:
        values, peaks = [o.value for o in found.folds], [o.peak / size for o in found.folds]
        axes.plot(values, peaks, "o", mfc="none", color=STRONG[1], label="fold")
    axes.set(xlabel=_speed(found.parameter), ylabel=f"peak |x| ({unit})")
    axes.legend(fontsize=8, frameon=False)


def draw_orbit(axes: Any, found: Orbit) -> None:
    """Draw the first state over the base angle, for the whole period of the orbit."""
    phase = np.linspace(0.0, 2.0 * np.pi * found.period, max(64, SAMPLES * len(found.coefficients)))
    x = found.state(phase)[0]
    size, unit = angle_unit(x)
    axes.plot(phase / np.pi, x / size, color=STRONG[0], ls="-" if found.stable else "--")
    axes.set(xlabel="base angle (π rad)", ylabel=f"x ({unit})", title=f"omega = {found.omega:.6g} rad/s")


def draw_trajectory(axes: Any, found: Trajectory) -> None:
    """Draw the first state over the time."""
    _draw_in_time(axes, found.t, found.y[0], "x")


def draw_run(axes: Any, found: DriveRun) -> None:
    """Draw the error between motor and load over the time."""
    _draw_in_time(axes, found.trajectory.t, found.error, "error between motor and load")


def draw_move(axes: Any, found: Move) -> None:
    """Draw the pointing error of the load over the time, with the window of a settled load after the profile."""
    size, _ = angle_unit(found.pointing_error)
    window = ((found.rest_error + side * found.window) / size for side in (-1.0, 1.0))
    axes.fill_between([found.duration, found.time[-1]], *window, color="#cccccc", lw=0.0, label="window")
    _draw_in_time(axes, found.time, found.pointing_error, "pointing error")
    axes.legend(fontsize=8, frameon=False)


def draw_response(axes: Any, found: ExactResponse) -> None:
    """Draw a response curve, and the jumps of a slow run-up and run-down on it."""
    draw_branch(axes, found.curve)
    size, _ = angle_unit(found.curve.peak)
    for jump in () if found.sweep is None else (*found.sweep.on_run_up, *found.sweep.on_run_down):
        ends = {"xy": (jump.value, jump.after / size), "xytext": (jump.value, jump.before / size)}
        axes.annotate("", **ends, arrowprops={"arrowstyle": "->", "color": STRONG[1]})


def draw_drive(axes: Any, found: DriveResponse) -> None:
    """Draw the oscillation of the error of a drive over its speed, and below it the torque in the gear.

    The torque is on axes of its own, at the lower end of those given, which become as much shorter.
    """
    size, unit = angle_unit(found.oscillation)
    rpm = found.omega / RPM
    _draw_stability(axes, rpm, found.oscillation / size, found.stable, found.name)
    axes.set(xlabel="speed of the base angle (rpm)", ylabel=f"oscillation ({unit})")
    axes.legend(fontsize=8, frameon=False)
    left, bottom, width, height = axes.get_position().bounds
    axes.set_position((left, bottom + 0.42 * height, width, 0.58 * height))
    below = axes.figure.add_axes((left, bottom, width, 0.38 * height), sharex=axes)
    _draw_stability(below, rpm, found.torque, found.stable, "torque")
    below.set(xlabel=axes.get_xlabel(), ylabel="torque in\nthe gear (N m)", ylim=(0.0, None))
    axes.tick_params(labelbottom=False)
    axes.xaxis.label.set_visible(False)


def draw_slow_response(axes: Any, found: SlowResponse) -> None:
    """Draw the amplitude of the slow flow over the speed, each branch of it."""
    size, unit = angle_unit(np.concatenate([branch.amplitude for branch in found.branches] or [np.zeros(1)]))
    for branch in found.branches:
        _draw_stability(axes, branch.omega, branch.amplitude / size, branch.stable, "amplitude of the slow flow")
    axes.set(xlabel=_speed("omega"), ylabel=f"amplitude a ({unit})")
    if found.branches:
        axes.legend(fontsize=8, frameon=False)


def draw_bode(axes: Any, found: Bode) -> None:
    """Draw the magnitudes of the speeds of motor and load over the torque; a held motor has none."""
    for shaft, colour in (("motor", STRONG[0]), ("load", STRONG[1])):
        size = found.decibels(shaft)  # type: ignore[arg-type]
        if np.any(np.isfinite(size)):
            axes.plot(found.omega, size, color=colour, label=f"speed of the {shaft}")
    axes.set(xscale="log", xlabel="frequency (rad/s)", ylabel=f"speed over torque on the {found.source} (dB)")
    axes.legend(fontsize=8, frameon=False)


def _draw_in_time(axes: Any, t: NDArray[np.float64], x: NDArray[np.float64], name: str) -> None:
    size, unit = angle_unit(x)
    axes.plot(t, x / size, color=STRONG[0], lw=0.8)
    axes.set(xlabel="t (s)", ylabel=f"{name} ({unit})")


def _draw_stability(axes: Any, across: Any, up: Any, stable: Any, label: str) -> None:
    """A curve whose unstable stretches are dashed; a stretch ends at the first point of the next."""
    edges = np.flatnonzero(stable[1:] != stable[:-1])
    named: set[bool] = set()
    for begin, end in zip([0, *(edges + 1)], [*(edges + 1), len(across) - 1], strict=True):
        solid = bool(stable[begin]) if len(stable) else True
        name = "" if solid in named else label if solid else f"{label}, unstable"
        named.add(solid)
        axes.plot(across[begin : end + 1], up[begin : end + 1], "-" if solid else "--", color=STRONG[0], label=name)


def _speed(parameter: str) -> str:
    return "speed omega (rad/s)" if parameter == "omega" else parameter
