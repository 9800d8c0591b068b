"""`strainwave derive` and `reproduce`: the article's error equation, and its Tables 3 and 4 on the terminal."""

import click

from ...theory.article import reproduce as reproduced
from ...theory.derivation import derive as derivation
from ..console import Progress, print_table, to_json
from .options import json_option

COLUMNS = ("case", "quantity", "unit", "printed", "computed", "verdict", "note")
TABLES = (
    ("Table 3", "derived", "derived quantities, from the article's own Table 3"),
    ("Table 4", "derived", "with mu and omega_0 derived from Table 3"),
    ("Table 4", "printed", "with the printed mu = 0.129 1/s, omega_0 = 37.2 rad/s"),
)


@click.command()
@click.option("--latex", is_flag=True, help="Print the equations as LaTeX.")
@json_option
def derive(latex: bool, as_json: bool) -> None:
    """Derive the error equation from Lagrange's, step by step."""
    with Progress("derive") as progress:
        progress.show("deriving the error equation", 0.0)
        steps = derivation()
    if as_json:
        click.echo(to_json({"latex": steps.latex(), "text": str(steps)}))
    else:
        click.echo(steps.latex() if latex else str(steps))


@click.command()
@json_option
def reproduce(as_json: bool) -> None:
    """Compute the article's tables again and compare them."""
    with Progress("reproduce") as progress:
        result = reproduced(progress=progress.show)
    if as_json:
        click.echo(to_json(result.as_dict()))
        return
    notes: list[str] = []
    for table, parameters, meaning in TABLES:
        rows, last = [], ""
        for cell in result.cells:
            if (cell.table, cell.parameters) != (table, parameters):
                continue
            if cell.why not in notes:
                notes.append(cell.why)
            case, last = ("" if cell.case == last else cell.case), cell.case
            place = f"[{notes.index(cell.why) + 1}]"
            rows.append((case, cell.quantity, cell.unit, cell.printed, cell.value, cell.verdict, place))
        print_table(f"{table}: {meaning}", COLUMNS, rows)
    for i, note in enumerate(notes, 1):
        click.echo(f"[{i}] {note}")
    click.echo(f"\nRule: {result.rule}.")
