"""`strainwave export` and `order-table`: a drive for another program, and order tables from one format to another."""

from pathlib import Path
from typing import Any

import click

from ...base.quantities import parse
from ...files.export.export import export as exported
from ...files.order_table import OrderTable, format_of
from ...files.reading import read_project
from ..console import echo, to_json
from .options import file_type, json_option, output_option, project_argument, written_type


@click.command()
@project_argument
@click.option(
    "--to", "form", type=click.Choice(("c", "fmu2", "fmu3", "mjcf")), required=True,
    help="C99; FMU of FMI 2.0 or 3.0; a joint for MuJoCo.",
)  # fmt: skip
@output_option("File: .c (and .h beside it), .fmu or .xml.", type=written_type, required=True)
@click.option("--step", help='Length of a step of C and FMU, as "250 us". Default: 16 in the shortest time scale.')
@json_option
def export(project: Path, form: Any, output: Path, step: str | None, as_json: bool) -> None:
    """Take the drive to Simulink (FMU), a controller (C) or MuJoCo."""
    drive = read_project(project)
    notes = exported(drive, output, to=form, step=None if step is None else parse(step, "s")).notes
    summary = {"title": drive.title, "format": form, "file": str(output), "notes": list(notes)}
    echo(to_json(summary) if as_json else "\n".join([f"{drive.title}: {form} in {output}", *notes]))


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
    about = {"file": source.name, "written": str(target), "format": form, "orders": list(table.orders)}
    text = f"{source.name}: {len(table.orders)} orders per turn of the {table.turn}, {table.sign} in {table.unit}"
    echo(to_json(about) if as_json else f"{text}\n  written: {target}")
