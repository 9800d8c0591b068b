"""Figures of response curves, orbits and motions, and of ensembles."""

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..base.results import Branch, Floats, Orbit, Trajectory
from ..drive.jumps import Jumps
from ..drive.run import DriveRun
from ..numerics.attractors.basins import CHAOTIC, DIVERGED, UNSETTLED, Basins
from ..numerics.ensemble.linear_loops import LoopResponse
from ..numerics.ensemble.loops import LoopEnsemble, LoopRun
from ..study.move.run_up import DIRECTIONS, RunUps
from ..theory.slow_flow.results import SlowResponse
from .panels import BLACK, BLUE, DASHES, HERTZ, ORANGE, PALE, TIME, Axis, Cells, Panel, angle, angle_unit, panels_of

SAMPLES = 16  # of an orbit, per harmonic
LIGHT = "#9ecae1"  # of a wide line under a dark one

# of a basin: neighbours in this list differ in lightness, too, so that they are told apart in print without colour
BASIN = ("#cfe6f5", "#d9822b", "#00664b", "#e3c93b", "#9a5a86", "#1f63a8")
REST = {DIVERGED: ("#ffffff", "diverged"), CHAOTIC: ("#222222", "chaotic"), UNSETTLED: ("#888888", "not settled")}
MARKERS = "os^v"
CLEAR = 0.1  # part of neighbouring cells with different labels, beyond which a line between them would hide them


def _parameter(name: str) -> Axis:
    return Axis("speed omega", "rad/s") if name == "omega" else Axis(name)


@panels_of.register
def branch_panels(branch: Branch) -> list[Panel]:
    """The largest |first state| over the parameter, with the folds as rings; the first state counts as an angle."""
    panel = Panel("", _parameter(branch.parameter), angle("peak |x|", branch.peak))
    panel.parted(branch.values, branch.peak, branch.stable, label="peak |x|")
    panel.points([fold.value for fold in branch.folds], [fold.peak for fold in branch.folds], ORANGE, "fold")
    return [panel]


@panels_of.register
def jumps_panels(sweeps: Jumps) -> list[Panel]:
    """The largest |x| before and after every jump, over the parameter, with the bands of hysteresis."""
    runs = (("run-up", BLUE, sweeps.on_run_up), ("run-down", ORANGE, sweeps.on_run_down))
    sizes = np.array([[jump.before, jump.after] for _, _, jumps in runs for jump in jumps]).reshape(-1, 2)
    panel = Panel("", _parameter(sweeps.parameter), angle("peak |x|", sizes))
    for band in sweeps.bands:
        panel.band((band.low, band.high), -np.inf, np.inf, PALE, "hysteresis")
    for name, colour, jumps in runs:
        for jump in jumps:
            panel.line([jump.value, jump.value], [jump.before, jump.after], colour, f"{name} jumps")
        panel.points([jump.value for jump in jumps], [jump.after for jump in jumps], colour, f"after a jump, {name}")
    return [panel] if len(sizes) else []


@panels_of.register
def orbit_panels(orbit: Orbit) -> list[Panel]:
    """The first state over the base angle, for the whole period of the orbit."""
    phase = np.linspace(0.0, 2.0 * np.pi * orbit.period, max(64, SAMPLES * len(orbit.coefficients)))
    x = orbit.state(phase)[0]
    panel = Panel(f"omega = {orbit.omega:.6g} rad/s", Axis("base angle", "π rad", np.pi), angle("x", x))
    panel.line(phase, x, dash="" if orbit.stable else DASHES)
    return [panel]


def _in_time(t: Floats, x: Floats, name: str) -> list[Panel]:
    panel = Panel("", TIME, angle(name, x))
    panel.line(t, x, width=0.8)
    return [panel]


@panels_of.register
def trajectory_panels(trajectory: Trajectory) -> list[Panel]:
    """The first state over the time."""
    return _in_time(trajectory.t, trajectory.y[0], "x")


@panels_of.register
def run_panels(run: DriveRun) -> list[Panel]:
    """The error between motor and load over the time."""
    return _in_time(run.trajectory.t, run.error, "error between motor and load")


@panels_of.register
def run_ups_panels(runs: RunUps) -> list[Panel]:
    """The largest error of both ways over the rate."""
    order = np.argsort(runs.rates)
    panel = Panel("", Axis("rate", "rad/s**2"), angle(f"largest |{runs.name}|", runs.largest), xlog=True)
    for name, colour, sizes in zip(DIRECTIONS, (BLUE, ORANGE), runs.largest, strict=True):
        panel.line(runs.rates[order], sizes[order], colour)
        panel.points(runs.rates[order], sizes[order], colour, name, "o", colour)
    return [panel]


@panels_of.register
def loop_panels(run: LoopRun) -> list[Panel]:
    """The error over the time."""
    return _in_time(run.time, run.error, "error")


@panels_of.register
def slow_response_panels(response: SlowResponse, abscissa: Callable[[ArrayLike], Floats] = np.asarray) -> list[Panel]:
    """The amplitude of the slow flow, each branch of it, with the folds, over the `abscissa` of a speed.

    Dark dashes of what is unstable lie on the wide light line of what is stable.
    """
    panel, trivial = Panel("", _parameter("omega"), angle("amplitude a", response.peak[1])), np.array(response.trivial)
    states = [(branch.omega, branch.amplitude, branch.stable) for branch in response.branches]
    states += [(trivial[:, 0], 0.0 * trivial[:, 0], trivial[:, 1] > 0.0)] if len(trivial) else []
    for omega, amplitude, stable in states:
        for keep, colour, width in ((stable, LIGHT, 4.0), (~stable, BLACK, 1.3)):
            names = ", stable", ", unstable"
            panel.parted(abscissa(omega), amplitude, stable, colour, "a", names, (width, width), keep=keep)
    panel.points(abscissa(response.folds), response.fold_amplitudes, ORANGE, "fold (two motions merge)")
    return [panel]


@panels_of.register
def loop_response_panels(response: LoopResponse) -> list[Panel]:
    """The size of the error that a torque of 1 N*m gives, over its frequency."""
    size = np.abs(response.error_of_torque)
    panel = Panel("", HERTZ, angle("error per torque", size, "/(N*m)"), log=True)
    panel.line(response.omega, size)
    return [panel]


@panels_of.register
def loops_panels(loops: LoopEnsemble) -> list[Panel]:
    """The share of the loops whose rms is below a value."""
    panel = Panel("", angle("rms of the error", loops.rms), Axis("share of the loops", "%"))
    panel.share(loops.rms, BLUE)
    return [panel]


@panels_of.register
def basins_panels(basins: Basins) -> list[Panel]:
    """The plane of initial states, coloured by the attractor that they reach, with its stroboscopic points.

    Beyond six attractors the smallest basins share a colour.
    """
    (left, right), (low, high) = basins.spans
    panel = Panel(
        "", angle("initial x", basins.spans[0]), angle("initial x'", basins.spans[1], "/s"),
        xlim=(left, right), ylim=(low, high),
    )  # fmt: skip
    colours = [*BASIN, *(colour for colour, _ in REST.values())]
    numbers = {label: len(BASIN) + i for i, label in enumerate(REST)}
    shade = np.array([numbers.get(label, min(label, len(BASIN) - 1)) for label in basins.label.tolist()])
    if basins.shape is None:
        for i in np.unique(shade):
            panel.points(basins.x[shade == i], basins.v[shade == i], colours[i], "", ".", colours[i])
    else:
        rows, columns = basins.shape
        edges = np.linspace(left, right, columns + 1), np.linspace(low, high, rows + 1)
        panel.cells = Cells(*edges, shade.reshape(basins.shape), colours)
        panel.line(*_borders(basins.label.reshape(basins.shape), *edges), BLACK, width=0.5)
    unit, size = angle_unit([attractor.amplitude for attractor in basins.attractors])
    for i, attractor in enumerate(basins.attractors):
        look, (share, error) = min(i, len(BASIN) - 1), basins.share(i)
        name = f"period {attractor.period}, amplitude {attractor.amplitude / size:.3g} {unit}"
        x, v = attractor.points[:, 0], attractor.points[:, 1]
        panel.points(x, v, BLACK, f"{name}: {share:.3f} ± {error:.3f}", MARKERS[look % len(MARKERS)], BASIN[look])
    for label, (colour, name) in REST.items():
        share, error = basins.share(label)
        if share > 0.0:
            panel.points([np.nan], [np.nan], BLACK, f"{name}: {share:.3f} ± {error:.3f}", "s", colour)
    return [panel]


def _borders(label: NDArray[np.int64], x: Floats, y: Floats) -> tuple[Floats, Floats]:
    """Lines between cells with different labels, separated by nan; none where most cells differ from neighbours."""
    upright, level = np.nonzero(label[:, 1:] != label[:, :-1]), np.nonzero(label[1:] != label[:-1])
    if min(label.shape) < 2 or len(upright[0]) + len(level[0]) > CLEAR * 2.0 * label.size:
        return np.empty(0), np.empty(0)
    (i, j), (k, m) = upright, level
    gaps = np.full(len(i), np.nan), np.full(len(k), np.nan)
    across = np.vstack([np.r_[x[j + 1], x[m]], np.r_[x[j + 1], x[m + 1]], np.r_[gaps]])
    up = np.vstack([np.r_[y[i], y[k + 1]], np.r_[y[i + 1], y[k + 1]], np.r_[gaps]])
    return across.T.ravel(), up.T.ravel()
