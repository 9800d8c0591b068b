"""What `strainwave analyze` takes and prints."""

from pathlib import Path

import click


@click.command()
@click.argument("projects", metavar="PROJECT...", nargs=-1, required=True, type=click.Path(path_type=Path))
@click.option(
    "-o", "--output", type=click.Path(file_okay=False, path_type=Path),
    help="Folder for report.html, results.json and CSV files; several projects have a folder in it each.",
)  # fmt: skip
@click.option("--compare", is_flag=True, help="Write comparison.html too: pass or fail of every project side by side.")
@click.option("--check", is_flag=True, help="Read the files only, and say whether they are valid.")
@click.option("--json", "as_json", is_flag=True, help="Print the result as JSON.")
def analyze(projects: tuple[Path, ...], output: Path | None, compare: bool, check: bool, as_json: bool) -> None:
    """Analyse the drives of project files and write a report of each."""
    from .analyze import check as checked
    from .analyze import run

    if check:
        click.echo(checked(projects, as_json))
        return
    if output is None:
        raise click.UsageError("give a folder for the report with -o, or --check to read the files only")
    click.echo(run(projects, output, compare, as_json))
