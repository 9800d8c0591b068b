"""`strainwave order-table`: an order table from one format to another, and the residual of the conversion."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import click

from ....base.quantities import number, parse
from ....base.units import ARCSEC
from ....files.order_tables.format import TableResidual
from ....files.order_tables.order_table import OrderTable, named
from ...console import number as written
from ...console import to_json
from ..options import file_type, json_option, pairs, written_type


@click.command("order-table")
@click.argument("source", metavar="IN", type=file_type)
@click.argument("target", metavar="OUT", type=written_type)
@click.option(
    "--format", "form", required=True,
    help="Format of OUT: json, csv, points, c, st, beckhoff, moteus, linuxcnc, hal, twincat, sinumerik, onstepx.",
)  # fmt: skip
@click.option("--from", "origin", help="Format of IN. Default: recognised by its content.")
@click.option(
    "--option",
    "options",
    multiple=True,
    callback=pairs,
    metavar="KEY=VALUE",
    help="Option of OUT, as points=360; repeatable.",
)
@click.option(
    "--from-option", "known", multiple=True, callback=pairs, metavar="KEY=VALUE", help="Option of IN; repeatable."
)
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
    click.echo(f"{source.name}: {len(table.orders)} orders per turn of the {table.turn}, {table.sign} in {table.unit}")
    click.echo("\n".join(f"  {line}" for line in _said(residual)))
    click.echo(f"  written: {target} ({kind.title})")


def _said(residual: TableResidual) -> list[str]:
    rows = residual.sentences()
    if residual.unit == "rad":
        rms, peak = written(residual.rms / ARCSEC, 3), written(residual.peak / ARCSEC, 3)
        rows.insert(1, f"that is {rms} arcsec rms, {peak} arcsec peak")
    return rows
