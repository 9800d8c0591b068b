"""`strainwave compare`: several project files side by side, in one table and one figure."""

from pathlib import Path

import click

from ...base.facts import data, lines
from ...files.reading import read_project
from ...files.variants.comparison import compare as compare_projects
from ...plot.drive import comparison_panels
from ...plot.svg import stacked
from ..console import Progress, finished, to_json
from ..output import staged
from ..report.report import comparison_page
from .design import as_csv
from .options import file_type, json_option, output_option

CSV, SVG, HTML = "comparison.csv", "comparison.svg", "comparison.html"


@click.command()
@click.argument("projects", type=file_type, nargs=-1, required=True)
@output_option("Folder for comparison.html, .csv and .svg.", required=True)
@json_option
def compare(projects: tuple[Path, ...], output: Path, as_json: bool) -> None:
    """Put responses of projects side by side: table, figure."""
    drives = [read_project(path) for path in projects]
    if len({drive.speeds.by_motor for drive in drives}) > 1:
        raise ValueError("some projects have speeds of a forcing, others of a shaft; compare one kind at a time")
    with Progress("comparison") as progress:
        found, stop = finished(lambda: compare_projects(drives, progress=lambda t, s: progress.show(t, 0.95 * s)))
        progress.show("writing", 0.95)
        rows = data(found.facts())["drives"]
        with staged(output) as folder:
            text = as_csv(list(rows[0]), [row.values() for row in rows])
            (folder / CSV).write_text(text, encoding="utf-8", newline="\n")
            limits = [drive.limit for drive in drives]
            panels = comparison_panels(found.titles, found.responses, limits, drives[0].speeds)
            figure = stacked(panels, 360.0, "oscillation of several drives over the speed")
            (folder / SVG).write_text(figure + "\n", encoding="utf-8")
            (folder / HTML).write_text(comparison_page(rows, figure), encoding="utf-8", newline="\n")
    written = f"written: {', '.join(str(output / name) for name in (HTML, CSV, SVG))}"
    click.echo(to_json({"drives": rows}) if as_json else "\n".join([*lines(found.facts()), written]))
    if stop is not None:
        raise stop
