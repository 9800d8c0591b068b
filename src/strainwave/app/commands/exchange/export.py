"""`strainwave export`: the drive of a project file for another program."""

from pathlib import Path
from typing import Any

import click

from ....base.quantities import parse
from ....files.export.export import export as exported
from ....files.reading import read_project
from ...console import Progress, to_json
from ..options import json_option, output_option, project_argument, written_type


@click.command()
@project_argument
@click.option(
    "--to", "form", type=click.Choice(("c", "fmu2", "fmu3", "mjcf", "urdf", "mat", "html")), required=True,
    help="C99; FMU of FMI 2.0 or 3.0; a joint for MuJoCo or in URDF; the response for MATLAB; a page that computes.",
)  # fmt: skip
@output_option("File: .c (and .h beside it), .fmu, .xml, .urdf, .mat or .html.", type=written_type, required=True)
@click.option("--step", help='Length of a step of C and FMU, as "250 us". Default: 16 in the shortest time scale.')
@json_option
def export(project: Path, form: Any, output: Path, step: str | None, as_json: bool) -> None:
    """Take motor, gear and load to another program."""
    if form in ("mat", "html") and output.suffix != f".{form}":
        raise ValueError(f"the file is {output.name!r}; give it a name that ends in .{form}")
    if form == "html" and str(project) == "catalogue":
        from ...page.catalogue import TITLE, write_catalogue

        write_catalogue(output)
        summary = {"title": TITLE, "format": form, "file": str(output), "notes": []}
        click.echo(to_json(summary) if as_json else f"{TITLE}: {form} in {output}")
        return
    drive = read_project(project)
    length = None if step is None else parse(step, "s")
    notes: tuple[str, ...] = ()
    if form == "html":
        from ...page.page import write_page

        write_page(drive, output)
    elif form == "mat":
        with Progress(drive.title) as progress:
            progress.show("response curve", 0.0)
            drive.response().save(output)
    else:
        notes = exported(drive, output, to=form, step=length).notes
    summary = {"title": drive.title, "format": form, "file": str(output), "notes": list(notes)}
    click.echo(to_json(summary) if as_json else "\n".join([f"{drive.title}: {form} in {output}", *notes]))
