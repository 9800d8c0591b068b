"""`strainwave exceedance`: how probable it is that a drive exceeds its limit, from the scatter in its project file."""

from pathlib import Path
from typing import Any

import click

from ...files.reading import read_project
from ...files.variants.scatter import exceedance as exceeded
from ..console import Progress, finished, reported
from ..view import quantity
from .options import json_option, limit_option, project_argument, retune_option


@click.command()
@project_argument
@click.option("--count", type=click.IntRange(32, 5000), default=200, help="Drives, each a curve.")
@click.option("--seed", type=click.IntRange(0), default=0, help="The same seed gives the same drives.")
@limit_option
@retune_option
@json_option
def exceedance(project: Path, count: int, seed: int, limit: str | None, retune: bool, as_json: bool) -> None:
    """Say how probable it is that a drive exceeds its limit. The scatter of its numbers is that of the file."""
    drive = read_project(project)
    allowed = None if limit is None else quantity("--limit", limit, "rad")
    with Progress(drive.title) as progress:
        told = f"{count} drives"
        progress.show(told, 0.0)
        how: dict[str, Any] = {"count": count, "seed": seed, "limit": allowed, "retune": retune}
        found, stop = finished(
            lambda: exceeded(drive, **how, progress=lambda done, all_: progress.show(told, done / all_))
        )
    click.echo(reported(drive.title, found.facts(), as_json))
    if stop is not None:
        raise stop
