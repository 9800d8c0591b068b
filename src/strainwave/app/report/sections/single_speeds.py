"""Single speeds in time: from rest to the steady motion, its torque and energies, multiple scales beside it."""

from typing import Any

import numpy as np

from ....base.sentences import Angle, Sentence, Speed
from ....drive.two_turns import A_TURN, beat_said
from ....plot.colours import BLACK, BLUE
from ....plot.panels import Axis, Panel
from ....plot.svg import figure
from ....study.analysis.in_time import DriveMotion
from ....study.analysis.time_case import TimeCase
from ...console import number, percent
from ...resonance_figures import time_figure
from ...view import View, sizes
from .speed_range import waves_data


class SingleSpeeds:
    """The speeds that the project names, or the main resonances and a place away from them."""

    heading = "Single speeds in time"
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
