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
    "Resonances, single speeds, speeds to avoid and the proof of stability are about the error equation with an "
    "ideally held motor and a rigid load: the whole drive train has a run-up alone."
)


def cautions(view: View) -> Part:
    """Warnings of the analysis, exceeded limits of the gear, and doubts about the file."""
    sentences = warnings(view)
    more = f" ({len(sentences) - 1} more in the report)" * (len(sentences) > 1)
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
            "Run-up and run-down differ between {}: two stable motions exist there, and which one the drive is on "
            "depends on its history; pass through that band quickly or keep out of it."
        )
        remark = "" if band.whole else " A jump between them lies outside the speed range; take a wider one to see it."
        sentences.append(Sentence(text, Speed(band.low, band.high, digits=5)) + remark)
    for jump in () if sweep is None else sweep.alone:
        text = (
            "The response jumps at {}, and in the other direction its stable motions end before that speed: the curve "
            "does not show what follows there; integrate to see it."
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
