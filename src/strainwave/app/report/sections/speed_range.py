"""The error through the speed range: the computed curve with its jumps, and the simulated run-up and run-down.

Single speeds in time: from rest to the steady motion, its torque and energies, multiple scales beside it.
"""

import cmath
import math
from typing import Any

import numpy as np

from ....base.results import Branch, Status
from ....base.sentences import Angle, Sentence, Speed
from ....base.units import Speeds
from ....drive.drive_response import DriveResponse
from ....drive.two_turns import A_TURN, beat_said
from ....plot import drive
from ....plot.panels import BLACK, BLUE, Axis, Panel
from ....plot.svg import figure, stacked
from ....study.analysis.in_time import DriveMotion
from ....study.analysis.time_case import TimeCase
from ....study.analysis.words import under_load
from ...console import number, percent
from ...view import View, place, sizes
from .resonances import time_figure


class SpeedRange:
    """The response curve, of the whole drive train where there is one, and its jumps on a slow run-up and run-down."""

    heading = "Torque through the speed range"

    def data(self, view: View) -> dict[str, Any]:
        """Key numbers of the curve of the error equation, and its simulated check."""
        return {"exact_response": curve_data(view.speeds, view.analysis.exact), "run_up": _run_up(view)}

    def figures(self, view: View) -> list[str]:
        """Torques in the gear and of the motor against speed; the first page has the oscillation."""
        _, *more = drive_figure(view)
        return [stacked([panel], drive.HEIGHT, f"{panel.y.name} against speed") for panel in more]

    def sentences(self, view: View) -> list[str]:
        """Jumps of a slow run-up and run-down, and what was looked for beside the curve."""
        message = view.analysis.drive.curve.message
        others = "The curve " + message + "." if message.startswith("reached both ends;") else ""
        return [*_sweeps(view), others]

    def open_ends(self, view: View) -> list[str]:
        """What assumed numbers leave open, each and together."""
        return [said[:1].upper() + said[1:] for said in view.project.sureness.sentences(view.project.limit)]

    def lines(self, view: View, _: dict[str, Any]) -> list[str]:
        """Jumps of a slow run-up and run-down."""
        return [said for said in _sweeps(view) if not said.endswith("does not jump.")]


def _sweeps(view: View) -> list[str]:
    return [] if view.project.undamped else sweep_sentences(view.analysis.drive)


def figure_said(view: View) -> list[str]:
    """What the figure of the oscillation shows."""
    return [_lines(view), _marks(view)]


def drive_figure(view: View) -> list[Panel]:
    """Oscillation of the error, and torques of gear and motor, against speed, with what an analysis adds."""
    analysis = view.analysis
    y = view.angle.axis(f"oscillation of the {analysis.drive.name}")
    extras = drive.of_analysis(analysis)._replace(sure=view.project.sureness)
    return drive.drive_panels(analysis.drive, view.project, y, extras)


def curve_data(speeds: Speeds, exact: DriveResponse) -> dict[str, Any]:
    """Key numbers of a response curve: folds, jumps, accuracy."""
    curve, sweep = exact.curve, exact.sweep

    def jump(omega: float) -> dict[str, Any] | None:
        return place(speeds, omega) if math.isfinite(omega) else None

    return {
        "method": exact.method,
        "harmonics": curve.coefficients.shape[1] // 2 if curve.waves is None else waves_data(curve, exact.top),
        "left_out_relative": curve.tail,
        "complete": curve.status.found,
        "rough": curve.status is Status.TRUNCATED,
        "message": exact.message,
        "folds": [place(speeds, fold.omega) | sizes(fold.peak) for fold in curve.folds],
        "jump_up": jump(sweep.jump_up if sweep else math.nan),
        "jump_down": jump(sweep.jump_down if sweep else math.nan),
        "bands": [
            {end: jump(getattr(band, end)) for end in ("low", "high", "jump_up", "jump_down")} | {"whole": band.whole}
            for band in (sweep.bands if sweep else ())
        ],
        "hysteresis_rad_per_s": sweep.width if sweep else None,
        "sweep": sweep.sentence if sweep else "no motion on the curve is stable",
    }


def waves_data(curve: Branch, at: int) -> list[dict[str, Any]]:
    """Waves of a motion that beats, the largest first: repeats per turn of motor and output, amplitude and phase."""
    assert curve.waves is not None
    sizes_of, pairs = curve.waves.amplitudes[at], curve.waves.pairs.tolist()
    rows = [
        {"wave_generator": j, "output": k, **sizes(abs(size), "amplitude"), "phase_rad": cmath.phase(size)}
        for (j, k), size in zip(pairs[1:], sizes_of[1:].tolist(), strict=True)
    ]
    return sorted(rows, key=lambda row: -row["amplitude_rad"])


def _run_up(view: View) -> list[dict[str, Any]]:
    run = view.analysis.run_up
    sides = (("up", run.up, run.curve_up), ("down", run.down, run.curve_down))
    return [
        {"direction": direction}
        | view.place(motion.omega)
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
    """What a slow run-up and run-down do, a sentence for each."""
    sweep, sentences = exact.sweep, list[str]()
    if sweep is None:
        return ["No motion on the curve is stable."]
    if sweep.finished_up and sweep.finished_down and not (sweep.on_run_up or sweep.on_run_down):
        return ["On a slow run-up or run-down the largest |error|, its mean included, does not jump."]
    up, down = (sweep.on_run_up, sweep.finished_up), (sweep.on_run_down, sweep.finished_down)
    for name, (jumps, whole) in {"run-up": up, "run-down": down}.items():
        steps = [Sentence("from {} to {} at {}", Angle(j.before), Angle(j.after), Speed(j.value)) for j in jumps]
        does = "jumps " + Sentence(" and ").join(steps) if jumps else "does not jump"
        end = "." if whole else "; the curve has no stable motion all the way, so the drive leaves it."
        sentences.append(f"On a slow {name} the largest |error|, its mean included, " + does + end)
    return sentences


def _lines(view: View) -> str:
    """The lines of the figure; where a curve is rough or not complete, a warning says so."""
    analysis, response = view.analysis, view.analysis.drive
    first, last = (analysis.load_cases[i].torque for i in (0, -1)) if analysis.load_cases else (0.0, 0.0)
    cases = f" Orange, thin: the same with other torques of the load, {number(first)} to {number(last)} N·m."
    shaded = analysis.avoid is not None and bool(analysis.avoid.bands)
    after = cases * bool(analysis.load_cases) + " Grey: speeds to avoid." * shaded
    whole = "" if analysis.train_curve is None else " of the whole drive train"
    whole += under_load(view.project.mean_load_torque if analysis.load_cases else None)
    text = f"Blue, thick: the motions{whole} that repeat with the {view.speeds.base_angle}, by harmonic balance "
    text += f"({response.curve.coefficients.shape[1] // 2} harmonics)"
    if (waves := response.curve.waves) is not None:
        text = f"Blue, thick: the motions{whole}, which beat, in their largest turn, thin: in their smallest, by "
        text += f"harmonic balance in two turns ({len(waves.pairs) - 1} waves)"
        if analysis.train_curve is None:
            return f"{text}.{after}"
    if analysis.train is None or analysis.train_curve is None:
        return f"{text}; triangles: integration, as a check.{after}"
    without = "; without the torque that follows the load's own angle" if analysis.train_curve.without_angle else ""
    reduced = f" Dash-dotted, thin, up to the top: {drive.HELD}."
    return f"{text}{without}.{reduced}{after}"


def _marks(view: View) -> str:
    if view.analysis.train_curve is not None or not view.analysis.regimes:
        return ""
    place = "where the curve is largest" if view.project.has_memory else "of small oscillations"
    return f"Dashed grey lines: resonances, numbered as in the appendix, {place}; base angle: {view.speeds.base_angle}."


class SingleSpeeds:
    """The speeds that the project names, or the main resonances and a place away from them."""

    heading = "Single speeds in time"
    template = "single_speeds.html.j2"
    appendix = True

    def data(self, view: View) -> dict[str, Any]:
        """A row for each, with the drive's own motion where it has more, and why a part of the analysis is missing."""
        rows = [_case(view, case) | {"drive": _drive(case, drive)} for case, drive in _cases(view)]
        return {"cases": rows, "remarks": list(view.analysis.remarks)}

    def figures(self, view: View) -> list[str]:
        """A figure for each."""
        return [time_figure(case, view.angle, drive) for case, drive in _cases(view)]


class BeatOfTurns:
    """The largest motion turn by turn, where motions beat."""

    heading = "The beat"
    template = "beat.html.j2"

    def data(self, view: View) -> dict[str, Any]:
        """Turns and period of the beat, and the sizes of its turns; None without one."""
        beat = view.analysis.beat
        if beat is None:
            return {"beat": None}
        known = {"turns": beat.turns, "period_s": beat.period, "difference_to_integration": beat.difference}
        return {"beat": view.place(beat.omega) | known | {"oscillation_of_each_turn_rad": beat.balanced.tolist()}}

    def sentences(self, view: View) -> list[Any]:
        """The beat in words."""
        beat = view.analysis.beat
        if beat is None:
            return []
        smallest = view.analysis.largest_oscillation().smallest or 0.0
        sizes_of = [Angle(size) for size in (float(np.max(beat.balanced)), smallest)]
        text = "The error {}, {} s at {}: it oscillates with {} in the largest turn and "
        every, text = beat_said(view.project.whole)[1], f"{text}with {{}} in the smallest; {A_TURN}."
        said = Sentence(text, every, number(beat.period, 3), Speed(beat.omega), *sizes_of)
        if beat.difference is not None:
            said += f" Integration gives the same within {percent(beat.difference, 2)} of the largest turn."
        return [said]

    def figures(self, view: View) -> list[str]:
        """Oscillation of each turn of the motor, by the balance and by integration."""
        beat = view.analysis.beat
        if beat is None:
            return []
        number_of = np.arange(1, len(beat.balanced) + 1)
        panel = Panel("", Axis("turn of the motor"), view.angle.axis("oscillation of the turn"), ylim=(0.0, None))
        panel.line(number_of, beat.balanced, BLUE, "harmonic balance")
        if len(beat.integrated):
            panel.points(number_of, beat.integrated, BLACK, "integration")
        return [figure([[panel]], 240.0, "oscillation of each turn of the motor")]

    def waves(self, view: View) -> list[dict[str, Any]]:
        """Waves of that motion."""
        drive = view.analysis.drive
        return waves_data(drive.curve, drive.top)

    def lines(self, _: View, __: dict[str, Any]) -> list[str]:
        """Nothing beside the verdict."""
        return []


def _cases(view: View) -> list[tuple[TimeCase, DriveMotion | None]]:
    """Single speeds of the error equation, and of the drive where that leaves something of it out."""
    study, cases = view.analysis.train, view.analysis.cases
    return list(zip(cases, [None] * len(cases) if study is None else study.motions, strict=True))


def _drive(case: TimeCase, motion: DriveMotion | None) -> dict[str, Any] | None:
    """The whole drive at the speed of a case, and how far the error equation is from it."""
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
        **view.place(case.omega),
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
