"""`strainwave derive` and `reproduce`: the article's error equation, and its Tables 3 and 4."""

from pathlib import Path

import click

from ...base.facts import data, lines
from ...files.reading import read_project
from ...theory.article import FORMS
from ...theory.article import reproduce as reproduced
from ...theory.derivation.error_equation import derive as derivation
from ..console import Progress, echo, print_table, to_json, write_all
from ..report.article import FORM_HEADS, files, header, reasons, shown, tables
from ..report.derivation import derivation_page, reduction
from .options import file_type, json_option, output_option


@click.command()
@click.argument("project", type=file_type, required=False)
@click.option("--latex", is_flag=True, help="Print the equations as LaTeX.")
@output_option("File: .html for a page with MathML, .tex for LaTeX, .txt for text.", ".html", ".tex", ".txt")
@json_option
def derive(project: Path | None, latex: bool, output: Path | None, as_json: bool) -> None:
    """Derive the error equation and its four cases of multiple scales.

    With a project file, also its error equation in numbers, and the effects of the drive that it neglects.
    """
    drive = None if project is None else read_project(project)
    with Progress("derive") as progress:
        progress.show("deriving the error equation", 0.0)
        steps = derivation()
        progress.show("deriving the four cases of multiple scales", 0.2)
        title, facts = (steps.title, ()) if drive is None else (drive.title, reduction(drive))
        heading = [title, *(f"  {line}" for line in lines(facts)), ""] if facts else []
        text, tex = "\n".join([*heading, str(steps)]), "\n".join([*(f"% {line}" for line in heading), steps.latex()])
        if output is not None:
            content = tex if output.suffix == ".tex" else text
            page = derivation_page(steps, title, facts) if output.suffix == ".html" else content
            write_all(output.parent, {output.name: page})
    if as_json:
        click.echo(to_json({"latex": tex, "text": text} | data(facts)))
    elif output is not None:
        click.echo(f"written: {output}")
    else:
        click.echo(tex if latex else text)


@click.command()
@output_option("Folder for article.html, its figures as SVG, and CSV files. Default: nothing is written.")
@click.option("--second-order", is_flag=True, help="Also derive multiple scales of second order (not in the article).")
@json_option
def reproduce(output: Path | None, second_order: bool, as_json: bool) -> None:
    """Compute the article's tables again and compare them."""
    with Progress("reproduce") as progress:
        result = reproduced(progress=progress.show)
        compared = tables(result)
        if output is not None:
            progress.show("writing", 1.0)
            write_all(output, files(result, second_order))
    if as_json:
        click.echo(to_json(result.as_dict() | {"header": header(), "tables": compared}))
        return
    echo("\n".join(header()) + f"\nRule: {result.rule}.\n")
    for title, rows in compared.items():
        heads, *body = shown(rows, second_order)
        print_table(title, heads, body)
    print_table("Formulas", FORM_HEADS, FORMS)
    echo("\n".join(f"- {why}" for why in reasons(compared)))
    if output is not None:
        click.echo(f"written: {output}")
