"""`strainwave compare`: the responses of several drives side by side, as table, figure and page."""

from pathlib import Path

import click

from ...base.facts import data, lines
from ...files.reading import read_project
from ..console import Progress, as_csv, echo, finished, to_json, write_all
from .options import file_type, json_option, output_option

CSV, SVG, HTML = "comparison.csv", "comparison.svg", "comparison.html"


@click.command()
@click.argument("projects", type=file_type, nargs=-1, required=True)
@output_option("Folder for comparison.html, .csv and .svg.", required=True)
@json_option
def compare(projects: tuple[Path, ...], output: Path, as_json: bool) -> None:
    """Compare the responses of projects in a table and a figure."""
    from ...files.variants.comparison import compare as compare_projects
    from ..report.comparison import comparison_figure, comparison_page

    drives = [read_project(path) for path in projects]
    if len({drive.speeds.by_motor for drive in drives}) > 1:
        raise ValueError("some projects give forcing frequencies, others shaft speeds; compare one kind at a time")
    with Progress("comparison") as progress:
        result, stop = finished(lambda: compare_projects(drives, progress=lambda t, s: progress.show(t, 0.95 * s)))
        progress.show("writing", 0.95)
        rows = data(result.facts())["drives"]
        figure = comparison_figure(result, drives[0].speeds)
        table = as_csv(list(rows[0]), [row.values() for row in rows])
        write_all(output, {CSV: table, SVG: figure, HTML: comparison_page(result, figure)})
    written = f"written: {', '.join(str(output / name) for name in (HTML, CSV, SVG))}"
    text = "\n".join([*lines(result.facts()), written])
    echo(to_json({"drives": rows, "remarks": result.remarks}) if as_json else text)
    if stop is not None:
        raise stop
