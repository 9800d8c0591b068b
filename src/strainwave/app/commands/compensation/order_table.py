"""`strainwave order-table`: an order table from one format to another."""

from pathlib import Path

import click

from ....base.quantities import parse
from ....files.order_table import OrderTable, format_of
from ...console import to_json
from ...console.terminal import echo
from ..options import file_type, json_option, written_type


@click.command("order-table")
@click.argument("source", metavar="IN", type=file_type)
@click.argument("target", metavar="OUT", type=written_type)
@click.option("--format", "form", help="Format of OUT: json, csv, c. Default: by the extension .json, .csv or .h.")
@click.option("--points", type=int, help="Points per turn of csv and c. Default: 32 per period of the highest order.")
@click.option("--prefix", default="order_table", help="Prefix of all names in c.")
@click.option("--speed", help='Speed of the table\'s shaft at which the delay is converted to a phase, as "300 rpm".')
@json_option
def order_table(
    source: Path, target: Path, form: str | None, points: int | None, prefix: str, speed: str | None, as_json: bool
) -> None:
    """Convert the order table IN to OUT: JSON, CSV or a C header."""
    form = format_of(target, form)
    table = OrderTable.read(source)
    if speed is not None:
        table = table.at_speed(parse(speed, "rad/s"))
    table.write(target, form, points=points, prefix=prefix)
    about = {"file": source.name, "written": str(target), "format": form, "orders": list(table.orders)}
    text = f"{source.name}: {len(table.orders)} orders per turn of the {table.turn}, {table.sign} in {table.unit}"
    echo(to_json(about) if as_json else f"{text}\n  written: {target}")
