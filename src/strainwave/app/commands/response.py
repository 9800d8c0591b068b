"""`strainwave response`: the computed response of a project's drive as numbers, CSV or figure."""

import math
from pathlib import Path
from typing import Any

import click
import numpy as np

from ...files.project import Project, read_project
from ...results import SolveError
from ...study.response.by_integration import response_through
from ...study.response.resonances import operating_point, regimes
from ...study.response.response import ExactResponse
from ...units import ARCSEC
from ..console import BETWEEN, WHAT_X_IS, Progress, number, to_json
from ..figures import curves, png
from ..output import staged, write_csv
from ..report.curve_files import exact_columns
from ..report.sections.opening import CONVENTIONS
from ..report.sections.speed_range import curve_data
from ..units import angle_unit
from .equation import refuse_reduced, remarks

FIGURES = (".svg", ".png")
JUMPS = {"up": "jump_up_speed", "down": "jump_down_speed"}


def show(path: Path, output: Path | None, as_json: bool) -> None:
    """Compute the response of a project file, write it where `output` says, and print its key numbers.

    Raises
    ------
    ProjectError
        If the project file is invalid.
    ValueError
        If the error equation leaves out something of the drive.
    SolveError
        If no periodic motion is found.
    """
    project = read_project(path)
    refuse_reduced(project, "response")
    if output is not None and output.suffix == ".png":
        png.check()
    speeds = project.speeds.limits
    with Progress(project.title) as progress:
        progress.show("response curve", 0.0)
        system = project.system(0.5 * (speeds[0] + speeds[1]))
        exact = response_through(system, speeds)
        if not len(exact.curve):
            raise SolveError(exact.curve.message)
        if output is not None:
            progress.show("writing", 0.8)
            _write(project, system, exact, speeds, output)
    data = {"title": project.title, "shaft": project.speeds.shaft, "motor": project.motor} | _in_shaft(project, exact)
    data |= curve_data(project.speeds, exact) | {"conventions": CONVENTIONS, "remarks": _remarks(project)}
    click.echo(to_json(data) if as_json else _summary(project, data, output))


def _write(project: Project, system: Any, exact: ExactResponse, speeds: tuple[float, float], output: Path) -> None:
    """Write the curve as CSV, or with multiple scales over it as a figure; the file appears when it is complete."""
    with staged(output.parent) as folder:
        part = folder / output.name
        if output.suffix in FIGURES:
            found = regimes(system, operating_point(system), speeds)
            panel = curves.range_panel(project, angle_unit(float(np.max(exact.curve.peak))), exact, found)
            panel.caption = [f"{WHAT_X_IS}.", *_remarks(project)]
            if output.suffix == ".svg":
                part.write_text(curves.speed_range(panel) + "\n", encoding="utf-8")
            else:
                png.write(panel, part)
        else:
            write_csv(part, exact_columns(project.speeds, exact.curve))


def _remarks(project: Project) -> list[str]:
    """What a reader must know about the curve: `remarks`, and its range where the file gives none."""
    said, speeds = list(remarks(project)), project.speeds
    if speeds.single:
        low, high = (number(speeds.own(omega), 5) for omega in speeds.limits)
        said.append(
            f"The file gives single speeds: the curve goes from {low} to {high} {speeds.own_unit}, a fifth beyond them."
        )
    return said


def _in_shaft(project: Project, exact: ExactResponse) -> dict[str, Any]:
    """Fold and jump speeds on the project's own shaft."""
    curve, sweep = exact.curve, exact.sweep
    top = exact.largest()

    def own(omega: float | None) -> float | None:
        return None if omega is None else project.speeds.own(omega)

    return {
        "unit": project.speeds.own_unit,
        "fold_speeds": [own(fold.omega) for fold in curve.folds],
        "jump_up_speed": own(sweep.jump_up) if sweep else None,
        "jump_down_speed": own(sweep.jump_down) if sweep else None,
        "hysteresis_bands": [
            {
                "from_speed": own(band.low),
                "to_speed": own(band.high),
                "jump_up_speed": own(band.jump_up),
                "jump_down_speed": own(band.jump_down),
                "whole": band.whole,
            }
            for band in (sweep.bands if sweep else ())
        ],
        "largest": None
        if top is None
        else {"speed": own(float(curve.omega[top])), "peak_arcsec": float(curve.peak[top]) / ARCSEC},
    }


def _summary(project: Project, data: dict[str, Any], output: Path | None) -> str:
    unit = data["unit"]
    lines = [f"{project.title}: response, motor {project.motor}, {data['message']}"]
    if data["largest"]:
        peak, at = data["largest"]["peak_arcsec"] * ARCSEC, data["largest"]["speed"]
        lines.append(f"  largest steady |x| {BETWEEN}: {angle_unit(peak).text(peak)} at {number(at, 5)} {unit}")
    else:
        lines.append(f"  {data['sweep']}")
    folds = ", ".join(number(speed, 5) for speed in data["fold_speeds"])
    lines.append(f"  folds: {f'{folds} {unit}' if folds else 'none'}")
    for band in data["hysteresis_bands"]:
        ends = f"{number(band['from_speed'], 5)} to {number(band['to_speed'], 5)} {unit}"
        ways = [f"jump {way} at {number(band[key], 5)}" for way, key in JUMPS.items() if math.isfinite(band[key])]
        beyond = "" if band["whole"] else "; a jump lies outside the range"
        lines.append(f"  hysteresis: {ends}{', ' if ways else ''}{' and '.join(ways)}{beyond}")
    if not data["hysteresis_bands"]:
        lines.append("  hysteresis: none")
    lines.append(f"  {data['harmonics']} harmonics; those left out hold {number(data['left_out_relative'], 2)}")
    lines += [f"  {WHAT_X_IS}"]
    lines += [f"  note: {remark}" for remark in data["remarks"]]
    return "\n".join(lines if output is None else [*lines, f"  written: {output}"])
