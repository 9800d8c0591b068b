"""`strainwave variability`: how probable it is that a drive exceeds its limit, from the scatter in its project file."""

from pathlib import Path
from typing import Any

import click

from ...base.quantities import convert
from ...drive.project import Project
from ...files.reading import read_project
from ...files.variants.scatter import Exceedance, exceedance
from ..console import Progress, finished, number, percent, to_json
from ..view import quantity, sign
from .options import json_option, limit_option, project_argument, retune_option

MOST_ERRORS = 3


@click.command()
@project_argument
@click.option("--count", type=click.IntRange(32, 5000), default=200, help="Drives, each a curve.")
@click.option("--seed", type=click.IntRange(0), default=0, help="The same seed gives the same drives.")
@limit_option
@retune_option
@json_option
def variability(project: Path, count: int, seed: int, limit: str | None, retune: bool, as_json: bool) -> None:
    """Say how probable it is that a drive exceeds its limit in its speeds, from the scatter of its numbers."""
    drive = read_project(project)
    allowed = None if limit is None else quantity("--limit", limit, "rad")
    with Progress(drive.title) as progress:
        told = f"{count} drives"
        progress.show(told, 0.0)
        how: dict[str, Any] = {"count": count, "seed": seed, "limit": allowed, "retune": retune}
        found, stop = finished(
            lambda: exceedance(drive, **how, progress=lambda done, all_: progress.show(told, done / all_))
        )
    click.echo(to_json(report(drive.title, found)) if as_json else summary(drive, found))
    if stop is not None:
        raise stop


def report(title: str, found: Exceedance) -> dict[str, object]:
    """Return the numbers of the command."""
    low, high = found.interval
    rows = () if found.ranking is None else found.ranking.rows
    return {
        "title": title, "drives": found.count, "seed": found.seed, "limit_rad": found.limit,
        "exceeding": found.exceeding, "failed": found.failed, "probability": found.probability, "interval": [low, high],
        "confidence": 0.95, "method": "Clopper-Pearson", "oscillation_rad": found.oscillation, "at_rad_per_s": found.at,
        "avoid_low_rad_per_s": found.low, "avoid_high_rad_per_s": found.high, "factors": found.factors,
        "first_order_index": {row.path: row.index for row in rows}, "errors": found.errors, "tuning": found.tuning,
        "load_torques_N_m": found.loads,
    }  # fmt: skip


def summary(drive: Project, found: Exceedance) -> str:
    """Return the numbers as text."""
    low, high = (percent(share, 3) for share in found.interval)
    allowed = f"{number(convert(found.limit, 'rad', 'arcsec'))} {sign('arcsec')}"
    lines = [
        f"{drive.title}: {found.exceeding} of {found.count} drives exceed an oscillation of {allowed} somewhere in the "
        "range",
        f"  probability {percent(found.probability, 3)}, 95 % confidence (Clopper-Pearson) {low} to {high}",
    ]
    if (ends := found.ends()) is not None:
        own = drive.speeds.own
        low, high = (f"{number(own(end.low), 6)} to {number(own(end.high), 6)}" for end in ends)
        unit = f"{drive.speeds.own_unit} (95 % of the drives that exceed it)"
        lines.append(f"  speeds to avoid begin at {low} and end at {high} {unit}")
    rows = () if found.ranking is None else found.ranking.rows
    lines += [f"  {row.path}: first-order index {row.index:.2f} ± {row.index_error:.2f}" for row in rows]
    if found.failed:
        lines.append(f"  {found.failed} of the drives have no response curve: {'; '.join(found.errors[:MOST_ERRORS])}")
    lines += [f"  {said}" for said in (found.under, found.tuning) if said]
    return "\n".join([*lines, f"  seed {found.seed}"])
