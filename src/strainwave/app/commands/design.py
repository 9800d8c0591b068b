"""`strainwave design`: the gears and motors that meet a specification, as numbers, CSV, figure and project files."""

import csv
import io
import math
from pathlib import Path
from typing import Any

import click

from ...base.units import ARCSEC, RPM
from ...files.design import design_text, read_specification
from ...plot.svg import stacked
from ...study.design.design import design as designed
from ...study.design.result import Candidate, Design
from ..console import Progress, finished, number, percent, print_table, to_json
from ..output import slug, staged
from .options import file_type, json_option, output_option

CSV, REJECTED, SVG, JSON = "designs.csv", "rejected.csv", "designs.svg", "design.json"
SHOWN, MOST_FILES = 12, 10  # rows of the table, and project files of the front


@click.command()
@click.argument("specification", type=file_type)
@output_option(
    "Folder for designs.csv, rejected.csv, designs.svg, design.json and the best designs as project files.",
    required=True,
)
@json_option
def design(specification: Path, output: Path, as_json: bool) -> None:
    """Search the catalogue for the gears and motors that do what SPECIFICATION asks of an axis."""
    asked = read_specification(specification)
    with Progress(asked.title) as progress:
        found, stop = finished(lambda: designed(asked, progress=progress.show))
        progress.show("writing", 0.98)
        data = report(found)
        written = _write(found, data, output)
    if as_json:
        click.echo(to_json(data))
    else:
        _summary(found)
        click.echo(f"written: {', '.join(str(output / file) for file in written)}")
    if stop is not None:
        raise stop


def report(found: Design) -> dict[str, Any]:
    """Return the numbers of the command."""
    return {
        "title": found.specification.title,
        "limit_rad": found.specification.limit,
        "feasible": [_numbers(c, c in found.pareto) for c in found.feasible],
        "rejected": dict(found.rejected),
        "nearest": found.nearest or None,
        "sensitivities": [
            {"gear": s.gear, "motor_inertia_kg_m2": s.motor_inertia, "parameter": s.parameter, "slope": s.slope}
            for s in found.sensitivities
        ],
        "drives": found.drives,
        "balanced": found.balanced,
        "remarks": list(found.remarks),
    }


def _numbers(c: Candidate, best: bool) -> dict[str, Any]:
    return {
        "gear": c.gear, "ratio": c.ratio, "size": c.size, "mass_kg": c.mass, "motor_inertia_kg_m2": c.motor_inertia,
        "reflected_inertia_kg_m2": c.reflected_inertia, "load_inertia_kg_m2": c.load_inertia,
        "load_torque_N_m": c.load_torque,
        "oscillation_arcsec": c.oscillation / ARCSEC, "motor_speed_rpm": c.speed / RPM, "method": c.method,
        "relative_error": c.error, "life_h": c.life, "margin": c.margin, "binding": c.binding, "pareto": best,
    }  # fmt: skip


def _write(found: Design, data: dict[str, Any], output: Path) -> list[str]:
    """Write tables, figure, JSON and the front as project files; their names."""
    texts = {
        CSV: as_csv(
            list(data["feasible"][0]) if data["feasible"] else ["gear"], [d.values() for d in data["feasible"]]
        ),
        REJECTED: as_csv(["gear", "reason"], found.rejected.items()),
        JSON: to_json(data) + "\n",
    }
    if found.feasible:
        texts[SVG] = stacked(found.panels(), 360.0, "designs that serve, oscillation over inertia") + "\n"
    for i, c in enumerate(found.pareto[:MOST_FILES], 1):
        texts[f"{i:02d}-{slug(c.gear)}.yaml"] = design_text(found.specification, c)
    with staged(output) as folder:
        for name, text in texts.items():
            (folder / name).write_text(text, encoding="utf-8", newline="\n")
    return list(texts)


def as_csv(header: list[str], rows: Any) -> str:
    """Write a table with words as CSV."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(header)
    writer.writerows([_cell(cell) for cell in row] for row in rows)
    return text.getvalue()


def _cell(value: Any) -> Any:
    """A cell of a table: empty for a number that is not known."""
    if isinstance(value, float):
        return "" if math.isnan(value) else f"{value:.8g}"
    return value


def _summary(found: Design) -> None:
    spec, gears = found.specification, {c.gear for c in found.feasible}
    click.echo(
        f"{spec.title}: {len(found.feasible)} designs of {len(gears)} gears serve, {len(found.rejected)} gears do not; "
        f"limit {number(spec.limit / ARCSEC)} arcsec"
    )
    if found.nearest:
        click.echo(found.nearest)
    if found.pareto:
        columns = ("gear", "size", "motor kg·m²", "at the load kg·m²", "oscillation arcsec", "at rpm", "life h",
                   "margin", "binds")  # fmt: skip
        rows = [
            (c.gear, c.size, c.motor_inertia, c.reflected_inertia, c.oscillation / ARCSEC, c.speed / RPM, c.life,
             percent(c.margin, 3), c.binding.replace("_", " "))
            for c in found.pareto[:SHOWN]
        ]  # fmt: skip
        caption = "no other design is better in oscillation, size and inertia at once; by harmonic balance"
        print_table("the best designs", columns, rows, caption)
        first = found.pareto[0]
        for s in found.sensitivities:
            if (s.gear, s.motor_inertia) == (first.gear, first.motor_inertia):
                change = f"{s.slope:+.2g}".replace("-", "−")
                click.echo(f"  {s.gear}: 1 % more {s.parameter} changes the oscillation by {change} %")
    for remark in found.remarks:
        click.echo(f"note: {remark}")
