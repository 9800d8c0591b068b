"""`strainwave export` and `order-table`: a drive for another program, and order tables from one format to another."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import click

from ...base.quantities import number, parse, shown
from ...base.units import ARCSEC
from ...files.export.export import export as exported
from ...files.order_tables.order_table import OrderTable, named
from ...files.reading import read_project
from ..console import Progress, to_json
from ..console import number as written
from .options import file_type, json_option, output_option, pairs_option, project_argument, written_type


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
@click.option(
    "--format", "form", required=True,
    help="Format of OUT: json, csv, points, grid, c, st, beckhoff, moteus, linuxcnc, hal, twincat, sinumerik, onstepx.",
)  # fmt: skip
@click.option("--from", "origin", help="Format of IN. Default: recognised by its content.")
@pairs_option("--option", "options", "KEY=VALUE", "Option of OUT, as points=360; repeatable.")
@pairs_option("--from-option", "known", "KEY=VALUE", "Option of IN; repeatable.")
@click.option("--ratio", type=float, help="Ratio of the gear, in place of the table's.")
@click.option("--speed", help='Speed of the table\'s shaft at which its delay becomes phase, as "300 rpm".')
@click.option(
    "--one-way", type=click.Choice(("forward", "backward", "mean")),
    help="One set of lines for both directions of motion.",
)  # fmt: skip
@click.option("--drop", is_flag=True, help="Leave out orders that OUT cannot hold, the weakest first.")
@json_option
def order_table(
    source: Path, target: Path, form: str, origin: str | None, options: dict[str, str],
    known: dict[str, str],
    ratio: float | None, speed: str | None, one_way: Any, drop: bool, as_json: bool,
) -> None:  # fmt: skip
    """Write the order table IN in a format of controls, as OUT."""
    kind = named(form)
    table = OrderTable.read(source, origin, **known)
    if ratio is not None:
        table = replace(table, ratio=number("--ratio", ratio, positive=True))
    if speed is not None:
        table = table.at_speed(parse(speed, "rad/s"))
    if one_way is not None:
        table = table.one_way(one_way)
    residual = table.write(target, kind.name, drop=drop, **options)
    if as_json:
        data = {"file": source.name, "written": str(target), "format": kind.name, "orders": list(table.orders)}
        click.echo(to_json(data | {"residual": residual._asdict()}))
        return
    rows = residual.sentences()
    if residual.unit == "rad":
        rms, peak = written(residual.rms / ARCSEC, 3), written(residual.peak / ARCSEC, 3)
        rows.insert(1, f"that is {rms} arcsec rms, {peak} arcsec peak")
    click.echo(f"{source.name}: {len(table.orders)} orders per turn of the {table.turn}, {table.sign} in {table.unit}")
    click.echo("\n".join(f"  {line}" for line in [*rows, f"written: {target} ({kind.title})"]))
