"""`strainwave response`: the steady motions of a drive over its speeds, as text, JSON, CSV or figure."""

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import click
import numpy as np

from ...base.facts import Fact
from ...base.number_text import number
from ...base.sentences import told
from ...base.units import ARCSEC
from ...compile.jit import light_as_python
from ...drive.drive_response import DriveResponse
from ...drive.friction.standstill import standing
from ...drive.motor_words import motor_name
from ...drive.project import Project
from ...drive.speeds import Speeds
from ...files.notes import curve_remark, load_remark, move_note, remarks, unsaid
from ...files.reading import read_project
from ...files.sources import source_facts, sources_text
from ...files.variants.sureness import how_sure
from ...plot import axes
from ...plot.drive import HEIGHT, drive_panels, reference
from ...plot.panels import named
from ...plot.svg import WIDTH, stacked
from ..console import Progress, echo, reported, staged, write_csv
from ..curves import CONVENTIONS, WHAT_X_IS, beat_facts, curve_data, drive_columns, ranged, sizes_said, torques_said
from ..view import angle_unit, writer
from .options import json_option, output_option, project_argument

FIGURES = (".svg", ".png")


@click.command()
@project_argument
@output_option("File for the curve: .csv, or .svg or .png for a figure of error and torque.", ".csv", *FIGURES)
@json_option
def response(project: Path, output: Path | None, as_json: bool) -> None:
    """Compute the error of the drive over the speed; find jumps."""
    drive = read_project(project)
    if output is not None and output.suffix == ".png":
        axes.check()
    with Progress(drive.title) as progress:
        progress.show("response curve", 0.0)
        with light_as_python():
            curve = drive.response()
        sure = None
        if output is None or as_json or output.suffix in FIGURES:  # a CSV file has no range for assumed numbers
            progress.show("range for assumed values", 0.2)
            sure = how_sure(drive, False) if output is None else drive.sureness  # many curves: machine code pays
        if output is not None:
            progress.show("writing", 0.8)
            _write(drive, curve, output)
    written = [] if output is None else [f"written: {output}"]
    echo(reported(drive.title, facts(drive, curve, sure), as_json, *written))


def _write(project: Project, curve: DriveResponse, output: Path) -> None:
    """Write the curve as CSV, or as a figure; the file appears when it is complete."""
    with staged(output.parent, output.name) as folder:
        part = folder / output.name
        if output.suffix in FIGURES:
            y = angle_unit(float(np.max(curve.peak))).axis(f"oscillation of the {curve.name}")
            panels = named(drive_panels(curve, project, y, reference(project)), project.title)
            panels[-1].caption = [f"{WHAT_X_IS}.", *_remarks(project)]
            if output.suffix == ".svg":
                text = stacked(panels, HEIGHT, "error and torque against speed", WIDTH)
                part.write_text(text + "\n", encoding="utf-8")
            else:
                axes.write(panels, part)
        else:
            write_csv(part, drive_columns(project.speeds, curve))


def facts(project: Project, motions: DriveResponse, sure: Any = None) -> tuple[Fact, ...]:
    """Every fact of a response, once, with speeds on the project's own shaft; `sure` as of `how_sure`."""
    speeds, curve, sweep, judged = project.speeds, motions.curve, motions.sweep, project.judged(motions)
    unit, motor, folds = speeds.own_unit, judged.motor, [speeds.own(fold.omega) for fold in curve.folds]
    name = project.motor if project.train is None else motor_name(project.train.motor.control, project.loop_inertia)
    resting = None if project.train is None else standing(project)
    top, size = motions.largest(), float(motions.oscillation[motions.top])
    write, peak, least = writer(project, angle_unit(size), unit, speeds.own(1.0)), None, None
    plain = told(curve_data(speeds, motions), write)
    if top is not None:
        peak = {"speed": speeds.own(float(curve.omega[top])), "peak_arcsec": float(curve.peak[top]) / ARCSEC}
    if motor is not None:
        least = {"speed": speeds.own(motor.at), "torque_N_m": motor.torque, "holding_torque_N_m": motor.holding}
    bands, beyond = sweep.bands if sweep else (), re.sub(r"^reached both ends(; )?", "", plain["message"])
    return (
        Fact("failures", tuple(told(list(judged.failures), write)), "FAIL: {}"),
        Fact("", name, "motor: {}"),
        Fact("shaft", speeds.shaft), Fact("motor", name), Fact("unit", unit), Fact("error", motions.name),
        Fact("passes", judged.passes), Fact("limit_arcsec", project.limit), Fact("load_has_a_range", ranged(project)),
        Fact("oscillation.speed", speeds.own(float(curve.omega[motions.top]))),
        Fact("oscillation.oscillation_arcsec", size), Fact("largest", peak),
        Fact("", sizes_said(project, motions, judged.covered) or project.undamped or plain["sweep"], "{}"),
        Fact("scope", curve_remark(curve.beat is None), "{}"),
        Fact("", beyond or (), "curve: {}"),
        *beat_facts(project, motions),
        Fact("gear_torque_N_m", judged.used.peak_torque), Fact("required_motor", least),
        Fact("limits", tuple(one.data() for one in judged.findings)),
        Fact("", torques_said(project, judged), "largest torque: {}"),
        Fact("fold_speeds", tuple(folds)),
        Fact("", f"{_speeds(folds)} {unit}" if folds else (), "folds (turning points of the curve): {}"),
        Fact("jump_up_speed", speeds.own(sweep.jump_up) if sweep else None),
        Fact("jump_down_speed", speeds.own(sweep.jump_down) if sweep else None),
        Fact("hysteresis_bands", tuple(_band(speeds, band) for band in bands), "{}"),
        Fact("", ("no jumps",) if judged.whole and not bands else (), "{}"),
        *(Fact(key, value) for key, value in plain.items()),
        *(() if sure is None else sure.facts(project.limit)),
        *(project.loop.facts() if project.loop else ()),
        Fact("sources", source_facts(project)), Fact("", sources_text(project), "{}"),
        *(() if resting is None else resting.facts()),
        Fact("beyond_limits", tuple(judged.remarks), "note: {}"),
        Fact("conventions", CONVENTIONS),
        Fact("remarks", tuple(unsaid(_remarks(project), judged.remarks)), "note: {}"),
    )  # fmt: skip


def _speeds(speeds: Sequence[float], between: str = ", ") -> str:
    return between.join(number(speed, 5) for speed in speeds)


def _remarks(project: Project) -> list[str]:
    """Remarks on the curve: `remarks`, and its range where the file gives none."""
    texts = [*remarks(project), *move_note(project), *load_remark(project)]
    speeds = project.speeds
    if speeds.single:
        ends = _speeds([speeds.own(omega) for omega in speeds.limits], " to ")
        curve = f"the curve covers {ends} {speeds.own_unit}, 20 % beyond these speeds"
        texts.append(f"The project file gives single speeds: {curve}.")
    return texts


def _band(speeds: Speeds, band: Any) -> tuple[Fact, ...]:
    """Facts of a band of hysteresis."""
    ends = {
        "from": ("low", f"hysteresis from [{speeds.own_unit}]"), "to": ("high", "to"),
        "jump_up": ("jump_up", "jumps up at"), "jump_down": ("jump_down", "drops at"),
    }  # fmt: skip
    rows = (Fact(f"{end}_speed", speeds.own(getattr(band, name)), words) for end, (name, words) in ends.items())
    return *rows, Fact("whole", band.whole, "in the range")
