"""Warnings to read before using the numbers."""

from ....base.sentences import Sentence, Speed
from ....files.notes import unsaid
from ....model.drive import HDC_40_050, HDC_40_050_WARNING
from ....model.gears.limits import gravest
from ....study.analysis.analysis import Analysis
from ...view import View
from ..section import Part
from .whole_train import reduction

RUN_UP_ALONE = (
    "Resonances, single speeds, speeds to avoid and the stability proof are from the error equation, with an ideally "
    "held motor and a rigid load. Of the whole drive train only the run-up is computed."
)


def cautions(view: View) -> Part:
    """Warnings of the analysis, exceeded limits of the gear, and doubts about the file."""
    sentences = warnings(view)
    more = f" ({len(sentences) - 1} more warnings in the report)" * (len(sentences) > 1)
    lines = ["warning: " + sentences[0] + more] if sentences else []
    return Part(data={"warnings": sentences}, sentences=sentences, lines=lines, kind="warn")


def warnings(view: View) -> list[str]:
    """Sentences to read before using the numbers, the gravest first."""
    project, analysis = view.project, view.analysis
    without_curve = analysis.train is not None and analysis.train.left_out is None and reduction(view) is None
    sentences = [*([RUN_UP_ALONE] if without_curve else []), *_overload(analysis)]
    article = (HDC_40_050.law, HDC_40_050.J_m, HDC_40_050.J_l)
    if (project.drive.law, project.drive.J_m, project.drive.J_l) == article:
        sentences.append(HDC_40_050_WARNING)
    sentences += [project.loop.weak] if project.loop and project.loop.weak else []
    sentences += analysis.warnings
    sweep = analysis.drive.sweep
    for band in () if sweep is None else sweep.bands:
        text = (
            "Two stable motions exist between {}: a run-up and a run-down differ there, as the motion depends on the "
            "earlier speeds. Avoid this speed band or pass through it quickly."
        )
        remark = "" if band.whole else " One of the jumps lies outside the speed range; widen the range to compute it."
        sentences.append(Sentence(text, Speed(band.low, band.high, digits=5)) + remark)
    for jump in () if sweep is None else sweep.alone:
        text = (
            "The response jumps at {}. With the speed changing in the other direction, the stable motions end before "
            "that speed; only a time integration shows the motion there."
        )
        sentences.append(Sentence(text, Speed(jump.value, digits=5)))
    return [*sentences, *unsaid(project.notes, sentences)]


def _overload(analysis: Analysis) -> list[str]:
    """Sentences on exceeded limits of the gear's datasheet."""
    used, sentences = analysis.usage, list[str]()
    for finding in sorted(gravest(analysis.limits), key=lambda f: f.value != used.peak_torque):  # that one breaks gears
        speed = {used.peak_torque: used.at_peak, used.average_torque: used.at_average}.get(finding.value)
        begin = "" if speed is None else "At " + Speed(speed, digits=5) + ": "
        sentences.append(begin + finding.sentence.replace("N*m", "N·m"))
    return sentences
