"""`strainwave design`: the gears and motors that meet a specification, as numbers, CSV, figure and project files."""

from dataclasses import replace
from pathlib import Path

import click

from ...base.facts import data
from ...files.design import design_text, read_specification
from ...plot.svg import stacked
from ...study.design.design import design as designed
from ...study.design.result import Design
from ..console import Progress, as_csv, finished, reported, slug, write_all
from .options import file_type, json_option, output_option, retune_option

CSV, REJECTED, SVG, JSON = "designs.csv", "rejected.csv", "designs.svg", "design.json"
MOST_FILES = 10  # project files of the front


@click.command()
@click.argument("specification", type=file_type)
@output_option(
    "Folder for designs.csv, rejected.csv, designs.svg, design.json and the best designs as project files.",
    required=True,
)
@retune_option
@json_option
def design(specification: Path, output: Path, retune: bool, as_json: bool) -> None:
    """Find gears and motors for the SPECIFICATION of an axis."""
    request = replace(read_specification(specification), retune=retune)
    with Progress(request.title) as progress:
        result, stop = finished(lambda: designed(request, progress=progress.show))
        progress.show("writing", 0.98)
        written = _write(result, output)
    files = f"written: {', '.join(str(output / file) for file in written)}"
    click.echo(reported(request.title, result.facts(), as_json, files))
    if stop is not None:
        raise stop


def _write(result: Design, output: Path) -> list[str]:
    """Write tables, figure, JSON and the front as project files, and return their names."""
    feasible = data(result.facts())["feasible"]
    texts = {
        CSV: as_csv(list(feasible[0]) if feasible else ["gear"], [row.values() for row in feasible]),
        REJECTED: as_csv(["gear", "reason"], result.rejected.items()),
        JSON: reported(result.specification.title, result.facts(), True),
    }
    if result.feasible:
        texts[SVG] = stacked(result.panels(), 360.0, "feasible designs, oscillation over inertia")
    for i, c in enumerate(result.pareto[:MOST_FILES], 1):
        texts[f"{i:02d}-{slug(c.gear)}.yaml"] = design_text(result.specification, c)
    write_all(output, texts)
    return list(texts)
