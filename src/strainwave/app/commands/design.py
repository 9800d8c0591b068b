"""`strainwave design`: the gears and motors that meet a specification, as numbers, CSV, figure and project files."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import click

from ...base.facts import data
from ...files.design_text import design_text
from ...files.own_gears import read_gears
from ...files.specification import read_specification
from ...files.yaml_text import text_of
from ...model.gears.catalogue import select
from ...model.gears.gear import Gear
from ...plot.svg import stacked
from ...study.design.design import design as designed
from ...study.design.result import Design
from ..console import Progress, as_csv, echo, finished, reported, slug, write_all
from .options import file_type, json_option, output_option, retune_option

CSV, REJECTED, SVG, JSON = "designs.csv", "rejected.csv", "designs.svg", "design.json"
MOST_FILES = 10  # project files of the front


@click.command()
@click.argument("specification", type=file_type)
@output_option(
    "Folder for designs.csv, rejected.csv, designs.svg, design.json and the best designs as project files.",
    required=True,
)
@click.option("--gears", type=file_type, help="YAML or CSV file with your own gears, in addition to the catalogue.")
@retune_option
@json_option
def design(specification: Path, output: Path, gears: Path | None, retune: bool, as_json: bool) -> None:
    r"""Find gears and motors for the SPECIFICATION of an axis.

    SPECIFICATION is a YAML file, at least:

    \b
    load: {inertia: 1.3 kg*m^2}
    speed: {from: 2 rpm, to: 40 rpm}  # of the load
    limit: {oscillation: 60 arcsec}
    motor: {rotor_inertias: [0.5 kg*cm^2, 2 kg*cm^2]}
    damping: {ratio: 3 %}

    Further groups: title, duty or torque, life, largest, ratios, series, excitation. Exit code 1 if no gear meets it.
    """
    request = replace(read_specification(specification), retune=retune)
    added = {} if gears is None else read_gears(gears)
    every = [*added.values(), *(record for record in select() if record.name not in added)]
    with Progress(request.title) as progress:
        result, stop = finished(lambda: designed(request, gears=every, progress=progress.show))
        progress.show("writing", 0.98)
        written = _write(result, output, added, gears)
    files = f"written: {', '.join(str(output / file) for file in written)}"
    echo(reported(request.title, result.facts(), as_json, files))
    if stop is not None:
        raise stop
    if not result.feasible:
        raise click.exceptions.Exit(1)


def _write(result: Design, output: Path, added: Mapping[str, Gear], gears: Path | None) -> list[str]:
    """Write tables, figure, JSON and the front as project files, and return their names."""
    feasible = data(result.facts())["feasible"]
    unjudged = {name: f"not judged: {reason}" for name, reason in result.not_judged.items()}
    texts = {
        CSV: as_csv(list(feasible[0]) if feasible else ["gear"], [row.values() for row in feasible]),
        REJECTED: as_csv(["gear", "reason"], (dict(result.rejected) | unjudged).items()),
        JSON: reported(result.specification.title, result.facts(), True),
    }
    if result.feasible:
        texts[SVG] = stacked(result.panels(), 360.0, "feasible designs, oscillation over inertia")
    for i, c in enumerate(result.pareto[:MOST_FILES], 1):
        file = "" if gears is None else gears.name
        texts[f"{i:02d}-{slug(c.gear)}.yaml"] = design_text(result.specification, c, own=added, file=file)
    if gears is not None and any(c.gear in added for c in result.pareto[:MOST_FILES]):
        texts[gears.name] = text_of(gears, "gear file")
    write_all(output, texts)
    return list(texts)
