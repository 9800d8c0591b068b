"""The error through the speed range: the computed curve with its jumps, and the simulated run-up and run-down."""

import cmath
import math
from typing import Any

from ....base.results import Branch, Status
from ....base.sentences import Angle, Sentence, Speed
from ....base.units import Speeds
from ....drive.drive_response import DriveResponse
from ....plot import drive
from ....plot.panels import Panel
from ....plot.svg import stacked
from ...console import number
from ...view import View, place, sizes, under_load


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
        return [*sweep_sentences(view.analysis.response), _others(view)]

    def open_ends(self, view: View) -> list[str]:
        """What assumed numbers leave open, each and together."""
        return [said[:1].upper() + said[1:] for said in view.project.sureness.sentences(view.project.limit)]

    def lines(self, view: View, _: dict[str, Any]) -> list[str]:
        """Jumps of a slow run-up and run-down."""
        return [said for said in sweep_sentences(view.analysis.response) if not said.endswith("does not jump.")]


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
            {
                "low": place(speeds, band.low),
                "high": place(speeds, band.high),
                "jump_up": jump(band.jump_up),
                "jump_down": jump(band.jump_down),
                "whole": band.whole,
            }
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
    sweep, said = exact.sweep, list[str]()
    if sweep is None:
        return ["No motion on the curve is stable."]
    if sweep.finished_up and sweep.finished_down and not (sweep.on_run_up or sweep.on_run_down):
        return ["On a slow run-up or run-down the largest |error|, its mean included, does not jump."]
    for name, jumps, whole in (
        ("run-up", sweep.on_run_up, sweep.finished_up),
        ("run-down", sweep.on_run_down, sweep.finished_down),
    ):
        steps = Sentence(" and ").join(
            Sentence("from {} to {} at {}", Angle(j.before), Angle(j.after), Speed(j.value)) for j in jumps
        )
        does = "jumps " + steps if jumps else "does not jump"
        end = "." if whole else "; the curve has no stable motion all the way, so the drive leaves it."
        said.append(f"On a slow {name} the largest |error|, its mean included, " + does + end)
    return said


def _lines(view: View) -> str:
    """The lines of the figure; where a curve is rough or not complete, a warning says so."""
    analysis, response = view.analysis, view.analysis.response
    first, last = (analysis.load_cases[i].torque for i in (0, -1)) if analysis.load_cases else (0.0, 0.0)
    cases = f" Orange, thin: the same with other torques of the load, {number(first)} to {number(last)} N·m."
    after = cases * bool(analysis.load_cases) + " Grey: speeds to avoid." * bool(
        analysis.avoid and analysis.avoid.bands
    )
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


def _others(view: View) -> str:
    """Facts about motions beside the curve."""
    message = view.analysis.response.curve.message
    return "The curve " + message + "." if message.startswith("reached both ends;") else ""


def _marks(view: View) -> str:
    if view.analysis.train_curve is not None or not view.analysis.regimes:
        return ""
    place = "where the curve is largest" if view.project.has_memory else "of small oscillations"
    return f"Dashed grey lines: resonances, numbered as in the appendix, {place}; base angle: {view.speeds.base_angle}."
