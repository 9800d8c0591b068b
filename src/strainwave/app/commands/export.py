"""`strainwave export`: a drive for Simulink, a controller or MuJoCo."""

from pathlib import Path
from typing import Any

import click

from ...base.quantities import parse
from ...files.export.export import export as exported
from ...files.reading import read_project
from ..console import to_json
from ..console.terminal import echo
from .options import json_option, output_option, project_argument, written_type


@click.command()
@project_argument
@click.option(
    "--to", "form", type=click.Choice(("c", "fmu2", "fmu3", "mjcf")), required=True,
    help="C99 code; an FMU of FMI 2.0 or 3.0; a joint for MuJoCo.",
)  # fmt: skip
@output_option("Output file: .c (with .h), .fmu or .xml.", type=written_type, required=True)
@click.option("--step", help='Step size of C code and FMU, as "250 us". Default: 1/16 of the shortest time scale.')
@json_option
def export(project: Path, form: Any, output: Path, step: str | None, as_json: bool) -> None:
    """Export a drive to Simulink (FMU), a controller (C) or MuJoCo."""
    drive = read_project(project)
    notes = exported(drive, output, to=form, step=None if step is None else parse(step, "s")).notes
    summary = {"title": drive.title, "format": form, "file": str(output), "notes": list(notes)}
    echo(to_json(summary) if as_json else "\n".join([f"{drive.title}: {form} in {output}", *notes]))
