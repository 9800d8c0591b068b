"""`strainwave derive` and `reproduce`: the article's error equation, and its Tables 3 and 4 on the terminal."""

from pathlib import Path

import click

from ...base.facts import data, lines
from ...files.reading import read_project
from ...theory.article import reproduce as reproduced
from ...theory.derivation.error_equation import derive as derivation
from ..console import Progress, print_table, to_json, write_all
from ..report.derivation import derivation_page, reduction
from .options import file_type, json_option, output_option, written_type

COLUMNS = ("case", "quantity", "unit", "printed", "computed", "verdict", "note")
TABLES = (
    ("Table 3", "derived", "derived quantities, from the article's own Table 3"),
    ("Table 4", "derived", "with mu and omega_0 derived from Table 3"),
    ("Table 4", "printed", "with the printed mu = 0.129 1/s, omega_0 = 37.2 rad/s"),
)


@click.command()
@click.argument("project", type=file_type, required=False)
@click.option("--latex", is_flag=True, help="Print the equations as LaTeX.")
@output_option("File: .html for a page with MathML, .tex for LaTeX, else text.", type=written_type)
@json_option
def derive(project: Path | None, latex: bool, output: Path | None, as_json: bool) -> None:
    """Derive the error equation and its four cases of multiple scales, step by step.

    With a project also its own error equation in numbers, and what that leaves out of its drive.
    """
    drive = None if project is None else read_project(project)
    with Progress("derive") as progress:
        progress.show("deriving the error equation", 0.0)
        steps = derivation()
        progress.show("deriving the four cases of multiple scales", 0.2)
        title, facts = (steps.title, ()) if drive is None else (drive.title, reduction(drive))
        own = [title, *(f"  {line}" for line in lines(facts)), ""] if facts else []
        text, tex = "\n".join([*own, str(steps)]), "\n".join([*(f"% {line}" for line in own), steps.latex()])
        if output is not None:
            page = derivation_page(steps, title, facts) if output.suffix == ".html" else ""
            write_all(output.parent, {output.name: page or (tex if output.suffix == ".tex" else text)})
    if as_json:
        click.echo(to_json({"latex": tex, "text": text} | data(facts)))
    else:
        click.echo(f"written: {output}" if output is not None else tex if latex else text)


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
