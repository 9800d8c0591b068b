"""Response curves, orbits and motions on axes of matplotlib; stable parts are solid, unstable ones dashed.

Results of ensembles on axes of matplotlib: basins, orbit diagrams, quantiles of the variability.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..base.results import Branch, Orbit, Trajectory
from ..base.units import ARCSEC, RPM
from ..drive.drive_response import DriveResponse
from ..drive.loop_margin import Bode
from ..drive.response import ExactResponse
from ..drive.run import DriveRun
from ..numerics.attractors.basins import CHAOTIC, DIVERGED, UNSETTLED, Basins
from ..numerics.attractors.poincare import OrbitDiagram
from ..study.move.result import Move
from ..study.variability.result import Variability
from ..theory.slow_flow.results import SlowResponse

SAMPLES = 16  # of an orbit, per harmonic

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
