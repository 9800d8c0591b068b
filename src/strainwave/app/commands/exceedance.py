"""`strainwave exceedance`: how probable it is that a drive of a project's scatter exceeds its limit."""

from pathlib import Path
from typing import Any

import click

from ...base.facts import Fact
from ...files.reading import read_project
from ..console import Progress, echo, finished, reported
from .options import json_option, limit_option, project_argument, quantity, retune_option


@click.command()
@project_argument
@click.option("--count", type=click.IntRange(32, 5000), default=200, help="Number of random drives.")
@click.option("--seed", type=click.IntRange(0), default=0, help="Seed of the random drives.")
@limit_option
@retune_option
@json_option
def exceedance(project: Path, count: int, seed: int, limit: str | None, retune: bool, as_json: bool) -> None:
    """Compute the probability that a drive exceeds its limit. The scatter is that of the project file."""
    from ...files.variants.scatter import exceedance as exceeded

    drive = read_project(project)
    allowed = None if limit is None else quantity("--limit", limit, "rad", "positive")
    with Progress(drive.title) as progress:
        stage = f"{count} drives"
        progress.show(stage, 0.0)
        how: dict[str, Any] = {"count": count, "seed": seed, "limit": allowed, "retune": retune}
        result, stop = finished(
            lambda: exceeded(drive, **how, progress=lambda done, all_: progress.show(stage, done / all_))
        )
    fault = Fact("failures", (drive.loop_fault,) if drive.loop_fault else (), "FAIL: {}")
    echo(reported(drive.title, (fault, *result.facts()), as_json))
    if stop is not None:
        raise stop
