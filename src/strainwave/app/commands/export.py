"""`strainwave export` and `order-table`: a drive for another program, and order tables from one format to another."""

from pathlib import Path
from typing import Any

import click

from ...base.quantities import parse, shown
from ...files.export.export import export as exported
from ...files.order_table import OrderTable, format_of
from ...files.reading import read_project
from ..console import Progress, to_json
from .options import file_type, json_option, output_option, project_argument, written_type


@click.command()
@project_argument
@click.option(
    "--to", "form", type=click.Choice(("c", "fmu2", "fmu3", "mjcf", "urdf", "mat")), required=True,
    help="C99; FMU of FMI 2.0 or 3.0; a joint for MuJoCo or in URDF; the response for MATLAB.",
)  # fmt: skip
@output_option("File: .c (and .h beside it), .fmu, .xml, .urdf or .mat.", type=written_type, required=True)
@click.option("--step", help='Length of a step of C and FMU, as "250 us". Default: 16 in the shortest time scale.')
@json_option
def export(project: Path, form: Any, output: Path, step: str | None, as_json: bool) -> None:
    """Take motor, gear and load to another program."""
    if form == "mat" and output.suffix != ".mat":
        raise ValueError(f"the file is {shown(output.name)}; give it a name that ends in .mat")
    if form == "mat" and step is not None:
        raise ValueError("--step is the length of a step of C and FMU, and mat has none; leave it out")
    title, notes = _export(project, form, output, step)
    summary = {"title": title, "format": form, "file": str(output), "notes": list(notes)}
    click.echo(to_json(summary) if as_json else "\n".join([f"{title}: {form} in {output}", *notes]))


def _export(project: Path, to: Any, output: Path, step: str | None) -> tuple[str, tuple[str, ...]]:
    """Write the file; its title and notes."""
    drive = read_project(project)
    if to != "mat":
        return drive.title, exported(drive, output, to=to, step=None if step is None else parse(step, "s")).notes
    with Progress(drive.title) as progress:
        progress.show("response curve", 0.0)
        drive.response().save(output)
    return drive.title, ()


@click.command("order-table")
@click.argument("source", metavar="IN", type=file_type)
@click.argument("target", metavar="OUT", type=written_type)
@click.option("--format", "form", help="Format of OUT: json, csv, c. Default: by its ending .json, .csv or .h.")
@click.option("--points", type=int, help="Points a turn of csv and c. Default: 32 a period of the highest order.")
@click.option("--prefix", default="order_table", help="Begin of all names in c.")
@click.option("--speed", help='Speed of the table\'s shaft at which its delay becomes phase, as "300 rpm".')
@json_option
def order_table(
    source: Path, target: Path, form: str | None, points: int | None, prefix: str, speed: str | None, as_json: bool
) -> None:
    """Write the order table IN as OUT: JSON, CSV or a C header."""
    form = format_of(target, form)
    table = OrderTable.read(source)
    if speed is not None:
        table = table.at_speed(parse(speed, "rad/s"))
    table.write(target, form, points=points, prefix=prefix)
    if as_json:
        click.echo(to_json({"file": source.name, "written": str(target), "format": form, "orders": list(table.orders)}))
        return
    click.echo(f"{source.name}: {len(table.orders)} orders per turn of the {table.turn}, {table.sign} in {table.unit}")
    click.echo(f"  written: {target}")
