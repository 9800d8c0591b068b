"""`strainwave reproduce`: the article's Tables 3 and 4 on the terminal."""

import click

from ..study.article import reproduce
from .console import Progress, print_table, to_json

COLUMNS = ("case", "quantity", "unit", "printed", "computed", "verdict", "why")


def show(as_json: bool) -> None:
    """Print every cell with its verdict, or all of it as JSON."""
    with Progress("reproduce") as progress:
        progress.show("integrating both parameter sets", 0.0)
        result = reproduce()
    if as_json:
        click.echo(to_json(result.as_dict()))
        return
    for table, parameters, meaning in (
        ("Table 3", "derived", "derived quantities, from the article's own Table 3"),
        ("Table 4", "derived", "with mu and omega_0 derived from Table 3"),
        ("Table 4", "printed", "with the printed mu = 0.129 1/s, omega_0 = 37.2 rad/s"),
    ):
        cells = [c for c in result.cells if (c.table, c.parameters) == (table, parameters)]
        rows = [(c.case, c.quantity, c.unit, c.printed, c.value, c.verdict, c.why) for c in cells]
        print_table(f"{table}: {meaning}", COLUMNS, rows)
    click.echo(result.rule)
