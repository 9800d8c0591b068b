"""The error through the speed range: the computed curve with its jumps, and the simulated run-up and run-down."""

from typing import Any

import numpy as np

from ....base.number_text import percent
from ....base.sentences import Angle, Sentence, Speed
from ....drive.drive_response import DriveResponse
from ....drive.two_turns import A_TURN, beat_said
from ....plot import drive
from ....plot.panels import BLACK, BLUE, Axis, Panel
from ....plot.svg import figure, stacked
from ...console import number
from ...curves import curve_data, waves_data
from ...view import View, sizes
from ..section import Part, Table


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
    """The simulated motions of the error equation, up and down, beside the largest |x| of its curve there."""
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
        return ["No steady motion on the response curve is stable."]
    if sweep.finished_up and sweep.finished_down and not (sweep.on_run_up or sweep.on_run_down):
        return ["In a slow run-up or run-down the largest |error|, mean included, does not jump."]
    up, down = (sweep.on_run_up, sweep.finished_up), (sweep.on_run_down, sweep.finished_down)
    for name, (jumps, complete) in {"run-up": up, "run-down": down}.items():
        steps = [Sentence("from {} to {} at {}", Angle(j.before), Angle(j.after), Speed(j.value)) for j in jumps]
        does = "jumps " + Sentence(" and ").join(steps) if jumps else "does not jump"
        end = "." if complete else "; the stable motions of the curve end within the speed range."
        sentences.append(f"In a slow {name} the largest |error|, mean included, " + does + end)
    return sentences


def beat_of_turns(view: View) -> Part:
    """The largest motion turn by turn, where motions beat: turns and period of the beat; None without one."""
    beat, motions = view.analysis.beat, view.analysis.drive
    if beat is None:
        return Part(data={"beat": None})
    period = {"turns": beat.turns, "period_s": beat.period, "difference_to_integration": beat.difference}
    data = view.speed_data(beat.omega) | period | {"oscillation_of_each_turn_rad": beat.balanced.tolist()}
    smallest = view.analysis.largest_oscillation().smallest or 0.0
    sizes_of = [Angle(size) for size in (float(np.max(beat.balanced)), smallest)]
    text = "The error {}, {} s at {}. Its oscillation is {} in the largest turn and "
    every, text = beat_said(view.project.whole)[1], f"{text}{{}} in the smallest; {A_TURN}."
    sentence = Sentence(text, every, number(beat.period, 3), Speed(beat.omega), *sizes_of)
    if beat.difference is not None:
        sentence += f" Time integration agrees within {percent(beat.difference, 2)} of the largest value."
    number_of = np.arange(1, len(beat.balanced) + 1)
    panel = Panel("", Axis("turn of the motor"), view.angle.axis("oscillation of the turn"), ylim=(0.0, None))
    panel.line(number_of, beat.balanced, BLUE, "harmonic balance")
    if len(beat.integrated):
        panel.points(number_of, beat.integrated, BLACK, "integration")
    drawn = figure([[panel]], 240.0, "oscillation of each turn of the motor")
    waves = waves_data(motions.curve, motions.top)
    table = Table(waves[:8], title=f"The largest of {len(waves)} waves, with periods per turn of motor and output")
    return Part("The beat", {"beat": data}, [sentence], [table], figures=[drawn])
