"""Single speeds in time: from rest to the steady motion, its torque and energies; multiple scales beside."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ....base.results import Floats
from ....base.sentences import Sentence, Speed
from ....plot.panels import BLACK, BLUE, DASHES, DOT_DASH, ORANGE, TIME, Axis, Panel
from ....plot.svg import figure
from ....study.analysis.time_domain.drive_motion import DriveMotion
from ....study.analysis.time_domain.time_case import Cycle, TimeCase
from ...console import number
from ...view import AngleUnit, View, sizes
from ..section import Part, Table

Motion = tuple[Floats, Floats]  # times [s] and x [rad]

BINS, MOST_CYCLES = 350, 40  # pieces of a band, and cycles up to which a motion is drawn as a line
MILLISECONDS = Axis("time", "ms", 1e-3)
ALONE = (
    "These are motions of the error equation, which closed forms describe: {}. This equation neglects {}. Dash-dotted "
    "curves: the whole drive at the same speeds, also integrated from rest."
)
STEADY = (
    "All values are for steady motion, except those “from rest”: a start at the static equilibrium, over the time 5/μ "
    "(50 turns without damping). A turn is one turn of the base angle. Dissipated energy and work are computed "
    "independently and agree in a steady motion. RMS difference: multiple scales minus integration, relative to the "
    "RMS of the integrated solution, over the time 0 to 5/μ."
)
BEATS = (
    "Beating motions do not repeat with every turn. The report shows the largest one turn by turn; strainwave move "
    "computes others over time."
)
OF_DRIVE = (
    "name omega_rad_per_s drive.oscillation_rad drive.oscillation_of_the_error_equation_rad "
    "drive.error_equation_relative_to_drive drive.peak_torque_Nm drive.remark"
)
OF_EQUATION = (
    "name omega_rad_per_s peak_rad peak_to_peak_rad peak_torque_Nm dissipated_J_per_turn work_J_per_turn loss_W"
)
OF_CYCLE = {  # keys of a steady motion, and its fields
    "peak_torque_Nm": "peak_torque", "mean_torque_Nm": "mean_torque", "dissipated_J_per_turn": "dissipated",
    "work_J_per_turn": "work", "loss_W": "power",
}  # fmt: skip
OF_THEORY = (
    "name peak_from_rest_rad peak_multiple_scales_rad rms_difference component_integration_rad "
    "component_multiple_scales_rad reason"
)


def single_speeds(view: View) -> Part:
    """The speeds that the project names, or the main resonances and a speed away from them, with the drive's motion."""
    cases, study, remarks = view.analysis.cases, view.analysis.train, list(view.analysis.remarks)
    motions = [None] * len(cases) if study is None else study.motions
    pairs = list(zip(cases, motions, strict=True))
    rows = [_case(view, case) | {"drive": _drive(case, motion)} for case, motion in pairs]
    of_drive = [row for row in rows if row["drive"]]
    scope = "" if rows else BEATS
    if of_drive:
        motor = "a motor driven by torque" if view.project.motor == "free" else "an ideally held motor, a rigid load"
        scope = ALONE.format(motor, ", ".join(view.project.left_out))
    tables = [
        Table(of_drive, OF_DRIVE, "The whole drive"),
        Table(rows, OF_EQUATION, "The error equation"),
        Table(rows, OF_THEORY, "Multiple scales against integration"),
    ]
    drawn = [(time_figure(case, view.angle, motion), _caption(case)) for case, motion in pairs]
    return Part(
        "Single speeds in time", {"cases": rows, "remarks": remarks}, [scope], tables,
        [STEADY * bool(rows), *remarks], drawn, appendix=True,
    )  # fmt: skip


def _caption(case: TimeCase) -> Sentence:
    """Name and speed of a case, and whether its motion repeats."""
    status = case.transient.message if not case.transient.status else case.steady.message
    ends = f"; the motion does not repeat with every turn: {status}." if status and not case.steady.closed else "."
    return Sentence("{}, {}", case.name, Speed(case.omega, digits=5)) + ends


def _drive(case: TimeCase, motion: DriveMotion | None) -> dict[str, Any] | None:
    """The drive at the speed of a case, and the error equation relative to it."""
    if motion is None:
        return None
    reduced = None if case.cycle is None else case.cycle.oscillation
    return {
        "error": motion.name,
        "load_torque_Nm": motion.load_torque,
        **sizes(motion.oscillation, "oscillation"),
        **sizes(motion.peak),
        **sizes(reduced, "oscillation_of_the_error_equation"),
        "error_equation_relative_to_drive": reduced and reduced / motion.oscillation,
        "peak_torque_Nm": motion.peak_torque,
        "remark": motion.remark,
    }


def _case(view: View, case: TimeCase) -> dict[str, Any]:
    """The error equation at the speed of a case, by integration and by multiple scales."""
    cycle, compared = case.cycle, case.comparison
    theory, simulated = case.amplitudes
    return {
        "name": case.name,
        **view.speed_data(case.omega),
        "regime": str(case.resonance),
        **sizes(case.peak_from_rest if case.transient.status else None, "peak_from_rest"),
        "peak_multiple_scales_rad": compared.peak_theory if compared else None,
        "rms_difference": compared.rms_difference if compared else None,
        "window_s": list(compared.window) if compared else None,
        "component_multiple_scales_rad": theory,
        "component_integration_rad": simulated,
        "steady_periodic": case.steady.closed,
        "status": case.transient.message if not case.transient.status else case.steady.message,
        "reason": case.reason,
        **sizes(None if cycle is None else cycle.peak),
        **sizes(None if cycle is None else cycle.peak_to_peak, "peak_to_peak"),
        **{key: cycle and getattr(cycle, name) for key, name in OF_CYCLE.items()},
    }


def time_figure(case: TimeCase, angle: AngleUnit, drive: DriveMotion | None = None) -> str:
    """One speed in time as SVG: from rest, the steady motion, its phase portrait, and the transmitted torque.

    Beside those of the error equation the steady motion and the torque of the whole drive, where it is given.
    """
    start = _from_rest(case, angle)
    label = f"time response, {case.name}"
    if case.cycle is None:
        return figure([[start]], 260.0, label)
    times = 2 if case.steady.period == 1 else 1
    steady, orbit = _steady(case, case.cycle, times, angle), _orbit(case, case.cycle, times, angle)
    if drive is not None:
        count = 1 + times * case.steady.period * drive.per_turn
        name = f"whole drive, {drive.name}"
        steady.line(drive.t[:count], drive.error[:count], BLACK, name, DOT_DASH)
        orbit[-1].line(drive.t[:count], drive.torque[:count], BLACK, "whole drive", DOT_DASH)
    return figure([[start, steady], orbit], 228.0, label)


def _from_rest(case: TimeCase, angle: AngleUnit) -> Panel:
    """The start: both solutions as lines, or the band between their extremes where cycles would not show."""
    run = case.transient
    title = f"from rest, largest |x| {angle.text(case.peak_from_rest)}"
    panel = Panel(title, TIME if run.t[-1] > 0.5 else MILLISECONDS, angle.axis("x"))
    theory = None if case.comparison is None else case.comparison.theory
    turns = max(12, int(run.t[-1] * case.omega / (2.0 * np.pi)))
    overlaid(panel, (run.t, run.y[0]), None if theory is None else (theory.t, theory.x), turns)
    return panel


def overlaid(panel: Panel, exact: Motion, theory: Motion | None, turns: int) -> None:
    """Add a motion (t [s], x [rad]) by integration and by multiple scales: as lines.

    Where cycles would not show, the band between the extremes of so many turns, and the lines of both.
    """
    crossings = np.count_nonzero(np.diff(np.sign(exact[1] - np.mean(exact[1]))))
    if crossings < 2 * MOST_CYCLES:
        panel.line(*exact, BLUE, "integration", width=1.2)
        if theory is not None:
            panel.line(*theory, ORANGE, "multiple scales", DASHES, 1.3)
        return
    low, high, t = envelope(*exact, _even(len(exact[0]), turns))
    panel.band(t, low, high, BLUE, "integration (range within each cycle)")
    if theory is not None:
        low, high, t = envelope(*theory, _even(len(theory[0]), turns))
        panel.line(t, high, ORANGE, "multiple scales", DASHES, 1.3)
        panel.line(t, low, ORANGE, "multiple scales", DASHES, 1.3)


def _even(count: int, pieces: int) -> NDArray[np.int64]:
    """First numbers of equal pieces of a row, at most `BINS`, none of them empty."""
    return np.linspace(0, count, min(BINS, pieces, count), endpoint=False).astype(np.int64)


def _steady(case: TimeCase, cycle: Cycle, times: int, angle: AngleUnit) -> Panel:
    panel = Panel("steady motion", MILLISECONDS, angle.axis("x"))
    t = _repeated_time(cycle, times)
    panel.line(t, np.tile(cycle.x, times), BLUE, "integration")
    if case.steady_theory is not None:
        panel.line(t, np.tile(case.steady_theory, times), ORANGE, "multiple scales", DASHES, 1.3)
    return panel


def _orbit(case: TimeCase, cycle: Cycle, times: int, angle: AngleUnit) -> list[Panel]:
    """Phase portrait and transmitted torque."""
    rate = Axis("x'", "rad/s") if np.max(np.abs(cycle.v)) > 1.0 else Axis("x'", "mrad/s", 1e-3)
    portrait = Panel("phase portrait of the steady motion", angle.axis("x"), rate)
    portrait.line(cycle.x, cycle.v, BLUE, "integration")
    samples = (len(cycle.x) - 1) // case.steady.period
    portrait.points(cycle.x[:-1:samples], cycle.v[:-1:samples], BLACK, "once per turn of the base angle", "o", ORANGE)
    title = f"steady torque through the gear, largest {number(cycle.peak_torque)} N·m"
    torque = Panel(title, MILLISECONDS, Axis("torque", "N*m"))
    torque.line(_repeated_time(cycle, times), np.tile(cycle.torque, times), BLUE, "integration")
    mean = cycle.mean_torque if abs(cycle.mean_torque) > 1e-6 * cycle.peak_torque else 0.0
    torque.level(mean, BLACK, f"mean torque {number(mean)} N·m", DOT_DASH, 1.0)
    return [portrait, torque]


def _repeated_time(cycle: Cycle, times: int) -> Floats:
    """Times of the cycle shown several times."""
    return np.concatenate([cycle.t + i * cycle.t[-1] for i in range(times)])


def envelope(t: Floats, x: Floats, starts: NDArray[np.int64]) -> tuple[Floats, Floats, Floats]:
    """Lowest and highest value and middle of each piece that begins with a sample of `starts`; of both ends the end.

    Of more than `BINS` pieces neighbours are taken together.
    """
    starts = starts[:: -(-len(starts) // BINS)]
    low, high = np.minimum.reduceat(x, starts), np.maximum.reduceat(x, starts)
    middles = np.add.reduceat(t, starts) / np.diff([*starts, len(t)])
    middles[0], middles[-1] = t[0], t[-1]
    return low, high, middles
