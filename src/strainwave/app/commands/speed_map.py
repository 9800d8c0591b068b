"""`strainwave speed-map`: allowed and forbidden motor speeds of a project under its loads, as tables and a figure."""

from pathlib import Path
from typing import Any

import click
import numpy as np

from ...files.reading import read_project
from ...files.variants.scatter import scattered
from ...plot.panels import named
from ...plot.svg import stacked
from ...study.speed_map.result import SpeedMap
from ...study.speed_map.speed_map import speed_map as mapped
from ..console import Progress, echo, ending, finished, reported, write_all
from ..curves import WHAT_X_IS
from .options import json_option, limit_option, output_option, project_argument, quantity, span

MOST_LOADS = 1000  # of a range
NAMES = {  # of columns of cells.csv, where they are not those of the map
    "torque": "gear_torque", "smallest": "smallest_oscillation", "motions": "stable_motions",
    "worst": "oscillation_worst_unit", "forbidden_share": "share_of_units_forbidden",
}  # fmt: skip


@click.command("speed-map")
@project_argument
@output_option("Folder for cells.csv, bands.csv, campbell.csv and speed-map.svg. Default: nothing is written.")
@click.option("--loads", help='Mean torques on the load, "LOW:HIGH:COUNT" or "V1,V2": "-60 N*m:0 N*m:9".')
@click.option("--load-inertias", "inertias", help='Inertias of the load instead of torques: "1 kg*m^2:3 kg*m^2:9".')
@click.option("--speeds", help='Range of the motor speed, "LOW:HIGH": "500 rpm:4000 rpm". Default: the project\'s.')
@limit_option
@click.option("--amplification", type=float, help="Limit of the oscillation, as a multiple of that at very low speed.")
@click.option("--margin", type=float, help="Smallest relative distance of a speed from every resonance: 0.1 for 10 %.")
@click.option("--units", type=click.IntRange(0, 5000), default=0, help="Number of drives drawn from the scatter.")
@click.option("--seed", type=click.IntRange(0), default=0, help="Seed of the random drives.")
@json_option
def speed_map(
    project: Path, output: Path | None, loads: str | None, inertias: str | None, speeds: str | None, limit: str | None,
    amplification: float | None, margin: float | None, units: int, seed: int, as_json: bool,
) -> None:  # fmt: skip
    """Say which motor speeds are allowed under every load."""
    drive = read_project(project)
    options = {
        "loads": _range("--loads", loads, "N*m"),
        "load_inertias": _range("--load-inertias", inertias, "kg*m**2", "positive"),
        "limit": None if limit is None else quantity("--limit", limit, "rad", "positive"),
    }
    example = 'for example "500 rpm:4000 rpm"'
    ends = None if speeds is None else span("--speeds", speeds.split(":"), "rad/s", example, "positive")
    with Progress(drive.title) as progress:
        drives = scattered(drive, units, seed) if units else ()
        options |= {"speeds": ends, "amplification": amplification, "margin": margin, "units": drives}
        progress.show("motions", 0.0)
        result, stop = finished(lambda: mapped(drive, **options, progress=progress.show))
        if output is not None:
            progress.show("writing", 1.0)
            write(result, output, drive.title)
    written = () if output is None else (f"written: {output}",)
    loop = drive.loop.facts() if drive.loop else ()
    echo(reported(drive.title, (*result.facts(), *loop), as_json, *written))
    if stop is not None:
        raise stop


def write(result: SpeedMap, folder: Path, name: str = "") -> None:
    """Write cells, bands, lines and the figure; the files appear when they are complete."""
    load, speed = np.meshgrid(result.loads, result.speeds, indexing="ij")
    of_load = {"load torque": "load_N_m", "load inertia": "load_kg_m2"}.get(result.load_name, result.load_name)
    axis, unit = result.axis, result.axis.unit.replace("/", "_per_")
    of_speed = "motor_speed_rpm" if axis.by_motor else f"forcing_{unit}"
    cells = [(of_load, load.ravel()), (of_speed, speed.ravel() * axis.scale)]
    for variable, (dims, values, unit_of_values) in result.variables().items():
        if dims[-2:] == ("load", "speed"):
            heads = [NAMES.get(variable, variable)]
            if result.scatter is not None and dims[0] == "share":
                heads = [f"oscillation_{100.0 * share:.0f}_percent_of_units" for share in result.scatter.shares]
            rows = values.reshape(len(heads), -1)
            cells += [(f"{name}{ending(unit_of_values)}", row) for name, row in zip(heads, rows, strict=True)]
    bands = np.array(
        [(result.loads[i], kind, low * axis.scale, high * axis.scale)
         for kind, kinds in enumerate((result.forbidden, result.allowed)) for i, load_bands in enumerate(kinds)
         for low, high in load_bands]
    ).reshape(-1, 4)  # fmt: skip
    lines = [
        (line.load, line.order, line.mode, a, w * axis.scale)
        for line in result.lines
        for a, w in zip(line.amplitude, line.speed, strict=True)
    ]
    table = np.array(lines).reshape(-1, 5)
    names = (of_load, "order", "resonance", "torsion_amplitude_rad", of_speed)
    panels = named(result.panels(), name)
    texts = (result.rule, WHAT_X_IS, *result.remarks)
    panels[-1].caption = [f"{text[0].upper()}{text[1:].removesuffix('.')}." for text in texts]
    write_all(folder, {
        "cells.csv": cells,
        "bands.csv": list(zip((of_load, "allowed", f"from_{unit}", f"to_{unit}"), bands.T, strict=True)),
        "campbell.csv": list(zip(names, table.T, strict=True)),
        "speed-map.svg": stacked(panels, 260.0, "forbidden speeds, oscillation, Campbell diagram"),
    })  # fmt: skip


def _range(option: str, text: str | None, unit: str, sign: str = "any") -> Any:
    """Values of LOW:HIGH:COUNT or V1,V2,..., with their unit; None of none."""
    if text is None:
        return None
    if ":" not in text:
        return [quantity(option, part, unit, sign) for part in text.split(",")]
    low, _, after = text.partition(":")
    high, _, count = after.partition(":")
    if not count.strip().isdecimal() or not 1 <= int(count) <= MOST_LOADS:
        reason = f"{text!r} does not end in a number of values from 1 to {MOST_LOADS}"
        raise click.BadParameter(f'{option}: {reason}; write for example "-60 N*m:0 N*m:9"')
    return np.linspace(quantity(option, low, unit, sign), quantity(option, high, unit, sign), int(count))
