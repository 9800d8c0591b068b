"""One verb that draws whatever is drawn: what `result.plot()` calls.

Figures of identification: a fitted loop, fitted friction. Moves and run-ups in closed loop, monitored records and
predictions on axes of matplotlib.
"""

from typing import Any

import numpy as np

from ..base.quantities import shown
from ..base.results import Branch, Floats, Orbit, Trajectory
from ..base.units import ARCSEC, RPM
from ..drive.drive_response import DriveResponse
from ..drive.loop_margin import Bode
from ..drive.response import ExactResponse
from ..drive.run import DriveRun
from ..numerics.attractors.basins import Basins
from ..numerics.attractors.poincare import OrbitDiagram
from ..numerics.sampled.linear import LoopResponse
from ..numerics.sampled.loops import LoopEnsemble, LoopRun
from ..study.analysis.validity import LEVELS, ORDERS, GeneralValidity, ValidityMap
from ..study.compensation.monitoring import Monitored
from ..study.compensation.moves import CompensatedMove
from ..study.compensation.prediction import PredictionTable
from ..study.compensation.result import Compensation, CompensationBench, Units
from ..study.compensation.runup import CompensatedRunup
from ..study.design.result import Design
from ..study.identification.free_decay.decay import DecayFit
from ..study.identification.friction.friction_model import FrictionFit
from ..study.identification.identified import Identified
from ..study.identification.log import Log
from ..study.identification.loops.loop_result import LoopFit
from ..study.identification.orders.order_result import OrderScan
from ..study.identification.response_curve.response_fit import ResponseFit
from ..study.move.result import Move
from ..study.speed_map.result import SpeedMap
from ..study.variability.result import Variability
from ..theory.slow_flow.results import SlowResponse
from .curves import (
    MARKERS,
    STRONG,
    angle_unit,
    draw_basins,
    draw_bode,
    draw_branch,
    draw_drive,
    draw_move,
    draw_orbit,
    draw_orbit_diagram,
    draw_response,
    draw_run,
    draw_slow_response,
    draw_trajectory,
    draw_variability,
)
from .fits import draw_decay, draw_design, draw_identified, draw_order_scan, draw_response_fit

BLUE, ORANGE, PALE = "#0072B2", "#D55E00", "#c0c0c0"

DASHES = ("-", "--", "-.", ":")

# Constant speed, of which there is most, is left white.
SHADES = {"still": "0.93", "run-up": "#c5e0ef", "run-down": "#fdd7b5", "other": "0.75"}

LINES = ("-", "--")
WIDTHS = (0.9, 1.6, 2.4)  # of the levels, from small to large errors
FLOOR = 1e-6  # of an error on the logarithmic scale on which contours are drawn
NAMES = ("first", "second")

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


def draw_log(axes: Any, found: Log) -> None:
    """Draw a log, its channels one below the other.

    Parameters
    ----------
    axes : matplotlib Axes
        Where to draw; all channels share its place.
    found : Log
        Its segments are shaded, where it has an angle or a speed.
    """
    figure, (left, bottom, width, height) = axes.figure, axes.get_position().bounds
    each = height / len(found.channels)
    parts = found.segments() if found.moving else ()
    for i, (name, values) in enumerate(found.channels.items()):
        place = (left, bottom + height - (i + 1) * each, width, 0.74 * each)
        below = axes if i == 0 else figure.add_axes(place, sharex=axes)
        if i == 0:
            figure.set_layout_engine("none")
            axes.set_position(place)
        for part in parts:
            if part.kind in SHADES:
                below.axvspan(part.start, part.stop, color=SHADES[part.kind], lw=0.0)
        for rows in found.unbroken():
            below.plot(found.time[rows], values[rows], color=STRONG[0], lw=0.8)
        below.set_title(name.replace("_", " "), loc="left", fontsize=8, pad=2.0)
        below.set(xlabel="t (s)", ylabel=found.units[name].replace("*", "·") or "–", xlim=found.time[[0, -1]])
        last = i + 1 == len(found.channels)
        below.tick_params(labelbottom=last, labelsize=8)
        below.xaxis.label.set_visible(last)
    named: set[str] = set()
    for part in parts:
        if part.kind in SHADES and part.kind not in named:
            named.add(part.kind)
            axes.fill_between([], [], color=SHADES[part.kind], label=part.kind)
    if named:
        axes.legend(fontsize=7, frameon=False, ncols=len(named), loc="lower right", bbox_to_anchor=(1.0, 1.0))


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


def draw_loop_fit(axes: Any, found: LoopFit) -> None:
    """Draw measured and fitted torque over the torsion."""
    x = found.torsion / (60.0 * ARCSEC)
    axes.plot(x, found.torque, color=PALE, linewidth=4.0, label="measured")
    axes.plot(x, found.fitted, color=BLUE, linewidth=1.0, label="fitted")
    axes.set(xlabel="torsion (arcmin)", ylabel="torque (N m)")
    axes.legend(frameon=False)


def draw_friction_fit(axes: Any, found: FrictionFit) -> None:
    """Draw measured and fitted torque over the speed."""
    order = np.argsort(found.speed)
    axes.plot(found.speed, found.torque, "o", color=ORANGE, markerfacecolor="none", label="measured")
    axes.plot(found.speed[order], found.fitted[order], "x", color=BLUE, markersize=4.0, label="fitted")
    axes.set(xlabel="speed (rad/s)", ylabel="torque (N m)")
    axes.legend(frameon=False)


DRAWN: dict[type, Any] = {
    Branch: draw_branch, Orbit: draw_orbit, Trajectory: draw_trajectory, ExactResponse: draw_response,
    DriveResponse: draw_drive, DriveRun: draw_run, Move: draw_move, SlowResponse: draw_slow_response, Bode: draw_bode,
    Basins: draw_basins, OrbitDiagram: draw_orbit_diagram, Variability: draw_variability,
    ValidityMap: draw_validity, GeneralValidity: draw_general_validity,
    SpeedMap: draw_speed_map, Design: draw_design, DecayFit: draw_decay, ResponseFit: draw_response_fit,
    Identified: draw_identified, OrderScan: draw_order_scan,
    Compensation: draw_compensation, CompensationBench: draw_compensation_bench, Units: draw_units,
    CompensatedMove: draw_compensated_move, CompensatedRunup: draw_compensated_runup,
    Monitored: draw_monitored, PredictionTable: draw_predictions,
    Log: draw_log, LoopFit: draw_loop_fit, FrictionFit: draw_friction_fit,
    LoopRun: draw_loop, LoopEnsemble: draw_loops, LoopResponse: draw_loop_response,
}  # fmt: skip


def draw(result: Any, axes: Any = None) -> Any:
    """Draw a result on axes of matplotlib.

    Parameters
    ----------
    result : Branch, Orbit, Trajectory, DriveRun, ...
        What to draw.
    axes : matplotlib Axes, optional
        Where. Default: those of a new figure.

    Returns
    -------
    matplotlib Axes
        The axes, for titles and for `axes.figure.savefig(...)`.

    Raises
    ------
    TypeError
        If nothing is drawn of such a thing.
    ModuleNotFoundError
        If axes are to be made and matplotlib is missing.
    """
    if type(result) not in DRAWN:
        known = ", ".join(cls.__name__ for cls in DRAWN)
        raise TypeError(f"there is no figure of {shown(result)}; there is one of each of {known}")
    if axes is None:
        try:
            from matplotlib import pyplot
        except ModuleNotFoundError:
            raise ModuleNotFoundError("figures need the extra `plot`: pip install 'strainwave[plot]'") from None
        axes = pyplot.subplots(layout="constrained")[1]
    DRAWN[type(result)](axes, result)
    return axes
