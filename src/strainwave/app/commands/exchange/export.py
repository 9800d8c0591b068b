"""`strainwave export`: the drive of a project file for another program."""

from pathlib import Path
from typing import Any

import click

from ....files.export.export import export
from ....files.reading import read_project
from ....quantities import parse
from ...console import Progress, to_json


def show(path: Path, to: Any, output: Path, step: str | None, as_json: bool) -> None:
    """Export the drive of a project file, or its computed response as a MAT-file, and say what was written.

    Raises
    ------
    FileError
        If the project file is invalid.
    ValueError
        If the drive, the step or the name of the file does not fit the format.
    """
    project = read_project(path)
    length = None if step is None else parse(step, "s")
    if to == "mat":
        if output.suffix != ".mat":
            raise ValueError(f"the file is {output.name!r}; give it a name that ends in .mat")
        with Progress(project.title) as progress:
            progress.show("response curve", 0.0)
            project.response().save(output)
        notes: tuple[str, ...] = ()
    else:
        notes = export(project, output, to=to, step=length).notes
    said = {"title": project.title, "format": to, "file": str(output), "notes": list(notes)}
    click.echo(to_json(said) if as_json else "\n".join([f"{project.title}: {to} in {output}", *notes]))
