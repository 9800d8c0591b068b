"""The error through the speed range: the computed curve with its jumps, and the simulated run-up and run-down.

Single speeds in time: from rest to the steady motion, its torque and energies, multiple scales beside it.
"""

from typing import Any

import numpy as np

from ....base.sentences import Angle, Sentence, Speed
from ....drive.drive_response import DriveResponse
from ....drive.two_turns import A_TURN, beat_said
from ....plot import drive
from ....plot.panels import BLACK, BLUE, Axis, Panel
from ....plot.svg import figure, stacked
from ....study.analysis.in_time import DriveMotion
from ....study.analysis.time_case import TimeCase
from ...console import number, percent
from ...curves import curve_data, waves_data
from ...view import View, sizes
from ..section import Part, Table
from .resonances import time_figure


def speed_range(view: View) -> Part:
    """Torques in the gear and of the motor against speed; jumps, and what assumed numbers leave open.

    Key numbers are those of the curve of the error equation, and its simulated check.
    """
    data = {"exact_response": curve_data(view.speeds, view.analysis.exact), "run_up": _run_up(view)}
    sure = [f"{one[:1].upper()}{one[1:]}." for one in view.project.sureness.sentences(view.project.limit)]
    message = view.analysis.drive.curve.message
    others = "The curve " + message + "." if message.startswith("reached both ends;") else ""
    notes = [*([] if view.project.undamped else sweep_sentences(view.analysis.drive)), others]
    drawn = [stacked([panel], 190.0, f"{panel.y.name} against speed") for panel in drive_figure(view)[1:]]
    tables = [Table(sure, title="How sure")]
    return Part("Torque through the speed range", data, (), tables, notes, drawn, kind="pair")


def drive_figure(view: View) -> list[Panel]:
    """Oscillation of the error, and torques of gear and motor, against speed, with what an analysis adds."""
    analysis = view.analysis
    y = view.angle.axis(f"oscillation of the {analysis.drive.name}")
    extras = drive.of_analysis(analysis)._replace(sure=view.project.sureness)
    return drive.drive_panels(analysis.drive, view.project, y, extras)


def _run_up(view: View) -> list[dict[str, Any]]:
    run = view.analysis.run_up
    sides = (("up", run.up, run.curve_up), ("down", run.down, run.curve_down))
    return [
        {"direction": direction}
        | view.speed_data(motion.omega)
        | sizes(motion.peak if motion.status else None)
        | {
            "exact_peak_rad": float(curve),
            "amplitude_at_omega_rad": motion.amplitude(1) if motion.status else None,
            "periodic": motion.closed,
            "period_in_turns": motion.period,
            "message": "" if motion.status else motion.message,
        }
        for direction, motions, exact in sides
        for motion, curve in zip(motions, exact, strict=True)
    ]


def sweep_sentences(exact: DriveResponse) -> list[str]:
    """Sentences on a slow run-up and a slow run-down."""
    sweep, sentences = exact.sweep, list[str]()
    if sweep is None:
        return ["No motion on the curve is stable."]
    if sweep.finished_up and sweep.finished_down and not (sweep.on_run_up or sweep.on_run_down):
        return ["On a slow run-up or run-down the largest |error|, its mean included, does not jump."]
    up, down = (sweep.on_run_up, sweep.finished_up), (sweep.on_run_down, sweep.finished_down)
    for name, (jumps, complete) in {"run-up": up, "run-down": down}.items():
        steps = [Sentence("from {} to {} at {}", Angle(j.before), Angle(j.after), Speed(j.value)) for j in jumps]
        does = "jumps " + Sentence(" and ").join(steps) if jumps else "does not jump"
        end = "." if complete else "; the curve has no stable motion all the way, so the drive leaves it."
        sentences.append(f"On a slow {name} the largest |error|, its mean included, " + does + end)
    return sentences


ALONE = (
    "These are motions of the error equation, which closed forms describe: {}. It leaves out {}. The whole drive at "
    "the same speeds, integrated from rest too, is drawn with dots and dashes."
)
STEADY = (
    "All values are steady but those “from rest”: a start at the static equilibrium, for the time 5/μ (50 turns "
    "without damping). A turn is one turn of the base angle; dissipated energy and work are computed apart from each "
    "other and agree in a steady motion. RMS difference: of multiple scales and integration, over the RMS of the "
    "integrated solution, in the window 0 to 5/μ."
)
BEATS = (
    "Motions that beat do not repeat with every turn: the largest stands turn by turn in the report, and strainwave "
    "move has others in time."
)
OF_DRIVE = (
    "name omega_rad_per_s drive.oscillation_rad drive.oscillation_of_the_error_equation_rad "
    "drive.error_equation_relative_to_drive drive.peak_torque_Nm drive.remark"
)
OF_EQUATION = (
    "name omega_rad_per_s peak_rad peak_to_peak_rad peak_torque_Nm dissipated_J_per_turn work_J_per_turn loss_W"
)
OF_THEORY = (
    "name peak_from_rest_rad peak_multiple_scales_rad rms_difference component_integration_rad "
    "component_multiple_scales_rad reason"
)


def single_speeds(view: View) -> Part:
    """The speeds that the project names, or the main resonances and a speed away from them, with the drive's motion."""
    cases, remarks = _cases(view), list(view.analysis.remarks)
    rows = [_case(view, case) | {"drive": _drive(case, motion)} for case, motion in cases]
    of_drive = [row for row in rows if row["drive"]]
    motor = "a motor driven by torque" if view.project.motor == "free" else "an ideally held motor, a rigid load"
    alone = ALONE.format(motor, ", ".join(view.project.left_out)) if of_drive else ""
    tables = [
        Table(of_drive, OF_DRIVE, "The whole drive"),
        Table(rows, OF_EQUATION, "The error equation"),
        Table(rows, OF_THEORY, "Multiple scales against integration"),
    ]
    drawn = [(time_figure(case, view.angle, motion), _caption(case)) for case, motion in cases]
    return Part(
        "Single speeds in time", {"cases": rows, "remarks": remarks}, [alone if rows else BEATS], tables,
        [STEADY * bool(rows), *remarks], drawn, appendix=True,
    )  # fmt: skip


def _caption(case: TimeCase) -> Sentence:
    """Name and speed of a case, and whether its motion repeats."""
    status = case.transient.message if not case.transient.status else case.steady.message
    ends = f"; the motion does not repeat after one turn: {status}." if status and not case.steady.closed else "."
    return Sentence("{}, {}", case.name, Speed(case.omega, digits=5)) + ends


def beat_of_turns(view: View) -> Part:
    """The largest motion turn by turn, where motions beat: turns and period of the beat; None without one."""
    beat, motions = view.analysis.beat, view.analysis.drive
    if beat is None:
        return Part(data={"beat": None})
    period = {"turns": beat.turns, "period_s": beat.period, "difference_to_integration": beat.difference}
    data = view.speed_data(beat.omega) | period | {"oscillation_of_each_turn_rad": beat.balanced.tolist()}
    smallest = view.analysis.largest_oscillation().smallest or 0.0
    sizes_of = [Angle(size) for size in (float(np.max(beat.balanced)), smallest)]
    text = "The error {}, {} s at {}: it oscillates with {} in the largest turn and "
    every, text = beat_said(view.project.whole)[1], f"{text}with {{}} in the smallest; {A_TURN}."
    sentence = Sentence(text, every, number(beat.period, 3), Speed(beat.omega), *sizes_of)
    if beat.difference is not None:
        sentence += f" Integration gives the same within {percent(beat.difference, 2)} of the largest turn."
    number_of = np.arange(1, len(beat.balanced) + 1)
    panel = Panel("", Axis("turn of the motor"), view.angle.axis("oscillation of the turn"), ylim=(0.0, None))
    panel.line(number_of, beat.balanced, BLUE, "harmonic balance")
    if len(beat.integrated):
        panel.points(number_of, beat.integrated, BLACK, "integration")
    drawn = figure([[panel]], 240.0, "oscillation of each turn of the motor")
    waves = waves_data(motions.curve, motions.top)
    table = Table(waves[:8], title=f"The largest of {len(waves)} waves, repeats per turn of motor and output")
    return Part("The beat", {"beat": data}, [sentence], [table], figures=[drawn])


def _cases(view: View) -> list[tuple[TimeCase, DriveMotion | None]]:
    """Single speeds of the error equation, and of the drive where that leaves something of it out."""
    study, cases = view.analysis.train, view.analysis.cases
    return list(zip(cases, [None] * len(cases) if study is None else study.motions, strict=True))


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
        "peak_torque_Nm": cycle and cycle.peak_torque,
        "mean_torque_Nm": cycle and cycle.mean_torque,
        "dissipated_J_per_turn": cycle and cycle.dissipated,
        "work_J_per_turn": cycle and cycle.work,
        "loss_W": cycle and cycle.power,
    }
