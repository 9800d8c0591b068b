"""Warnings to read before using the numbers."""

from typing import Any

from ....base.sentences import Sentence, Speed
from ....files.notes import unsaid
from ....model.drive import HDC_40_050, HDC_40_050_WARNING
from ....model.gears.limits import gravest
from ....study.analysis.analysis import Analysis
from ...view import View
from .whole_train import train_warning


class Warnings:
    """Warnings of the analysis, exceeded limits of the gear, and doubts about the file."""

    heading = ""

    def data(self, view: View) -> dict[str, Any]:
        """All warnings in sentences."""
        return {"warnings": warnings(view)}

    def lines(self, _: View, data: dict[str, Any]) -> list[str]:
        """Their number."""
        count = len(data["warnings"])
        return [f"{count} warning(s) in the report"] if count else []


def warnings(view: View) -> list[str]:
    """Sentences to read before using the numbers, the gravest first."""
    project, analysis = view.project, view.analysis
    sentences = [*train_warning(view), *_overload(analysis)]
    article = (HDC_40_050.law, HDC_40_050.J_m, HDC_40_050.J_l)
    if (project.drive.law, project.drive.J_m, project.drive.J_l) == article:
        sentences.append(HDC_40_050_WARNING)
    sentences += analysis.warnings
    sweep = analysis.response.sweep
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
