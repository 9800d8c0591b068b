"""`strainwave compensate`: controllers that cancel a project's error, in closed loop beside the plain loop."""

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import click
import numpy as np

from ....base.quantities import parse
from ....base.results import Floats
from ....drive.project import Project
from ....files.reading import read_project
from ....model.train.drive_train import DriveTrain
from ....plot import compensation as figures
from ....plot.panels import Panel, named
from ....plot.svg import stacked
from ....study.compensation.bench import Bench, bench_of, steady_bench_of
from ....study.compensation.compensate import PLAIN, benches_of, compensation_bench, resonance_speed
from ....study.compensation.compensate import compensate as compensated
from ....study.compensation.designs import COMPENSATORS
from ....study.compensation.result import CompensationBench
from ...console import Progress, as_csv, echo, in_options, to_json, write_all
from ..options import file_type, json_option, output_option, project_argument, quantity
from . import tables
from .order_tables import TableAlone, written_tables
from .tables import Run, best_at, worst

ALL = "all"
SHARES = (0.3, 0.9, 1.0, 1.1, 3.0)  # of the speed at which the largest order meets the resonance of the held motor


@click.command()
@project_argument
@click.option("--controller", "controllers", multiple=True, help="Controller, as inverse; repeatable. Default: all.")
@click.option("--speed", "speeds", multiple=True, help='Motor or forcing speed, as "450 rpm"; repeatable.')
@click.option(
    "--load-angle", "load_angles", multiple=True,
    help='Angle of the load at which gravity is evaluated, as "90 deg"; repeatable: the worst counts. Default: 0 deg.',
)  # fmt: skip
@click.option("--units", type=click.IntRange(0, 100_000), default=0, help="Number of units drawn at random.")
@click.option("--seed", type=click.IntRange(0), default=1, help="Seed of the random units.")
@click.option("--plant", type=file_type, help="Project file of the simulated drive, if it differs from the model.")
@click.option("--softer", help='Simulate a gear that is softer than in the project file, as "20 %".')
@output_option("Folder for tables, figures and order tables.")
@json_option
def compensate(
    project: Path, controllers: tuple[str, ...], speeds: tuple[str, ...], load_angles: tuple[str, ...], units: int,
    seed: int, plant: Path | None, softer: str | None, output: Path | None, as_json: bool,
) -> None:  # fmt: skip
    """Simulate controllers that cancel the error, in closed loop.

    Without --speed, five speeds about the resonance are simulated. Ctrl-C keeps the finished results.
    """
    drive = read_project(project)
    train = plant_of(drive, plant, softer)
    angles = tuple(quantity("--load-angle", text, "rad") for text in load_angles) or None
    benches = benches_of(drive, plant=train, load_angles=angles)
    grid = speeds_of(drive, speeds)
    names, left_out = names_of(next(iter(benches.values())), controllers or (ALL,))
    with Progress(drive.title) as progress:
        setup = {"plant": train, "load_angles": angles}
        run, stop = _run(
            drive, benches, setup=setup, names=names, speeds=grid, left_out=left_out, units=units, seed=seed,
            progress=progress.show,
        )  # fmt: skip
        if run is not None and output is not None:
            progress.show("writing", 0.97)
            run = run if stop else run._replace(tables=_tables(run))
            _write(drive.title, run, output, figured=not stop)
    if run is not None:
        echo(to_json(tables.data(run)) if as_json else in_options(tables.summary(run)))
        if output is not None and not as_json:
            echo(f"  written: {output}")
    if stop:
        kept = "nothing was finished" if run is None else f"kept: {', '.join(run.results.names)}"
        raise KeyboardInterrupt(f"interrupted; {kept}; the same command computes all again")


def speeds_of(project: Project, texts: Sequence[str] = ()) -> Floats:
    """Speeds of the motor [rad/s]: those given as text, or five about that of `compensate` within its range."""
    if texts:
        return np.unique([parse(text, "rad/s") for text in texts])
    resonance = resonance_speed(steady_bench_of(project))
    if not resonance:
        raise ValueError("this drive has no resonance from which to choose speeds; add --speed '450 rpm'")
    return np.unique(np.clip(np.multiply(SHARES, resonance), *project.speeds.limits))


def names_of(bench: Bench, controllers: Sequence[str]) -> tuple[list[str], tuple[str, ...]]:
    """Names of the controllers, the plain loop first; and a sentence about those that need a missing load encoder."""
    for name in controllers:
        if name != ALL and name not in COMPENSATORS:
            raise ValueError(f"there is no controller {name!r}; there are {', '.join(COMPENSATORS)}, and {ALL}")
    names = list(COMPENSATORS if ALL in controllers else dict.fromkeys([PLAIN, *controllers]))
    blind = [name for name in names if COMPENSATORS[name].load_encoder] if not bench.sampling.load_encoder else []
    if blind and ALL not in controllers:
        raise ValueError(
            f"{', '.join(blind)} requires an encoder on the load, and the project has none; write "
            "'load_encoder: 24 bit' into the group 'controller'"
        )
    sentences = (f"Omitted, because the load has no encoder: {', '.join(blind)}.",) if blind else ()
    return [name for name in names if name not in blind], sentences


def plant_of(project: Project, plant: Path | None, softer: str | None) -> DriveTrain | None:
    """The drive that is run; None for the drive on which the controllers are designed."""
    if plant is not None:
        if softer is not None:
            raise click.UsageError("--plant and --softer both set the simulated drive; use one of them")
        return bench_of(read_project(plant)).plant
    if softer is None:
        return None
    share = parse(softer, "")
    if not -1.0 < share < 1.0:
        raise click.BadParameter(f"{softer!r} is not between -100 % and 100 %", param_hint="--softer")
    return bench_of(project).with_stiffness(-share).plant


def _run(
    project: Project, benches: dict[float, Bench], *, setup: dict[str, Any], names: Sequence[str], speeds: Floats,
    left_out: tuple[str, ...], units: int, seed: int, progress: Callable[[str, float], None],
) -> tuple[Run | None, bool]:  # fmt: skip
    """The run and whether the user stopped it; no run where no controller was finished."""
    rows: list[CompensationBench] = []
    remarks = list(left_out)
    run = None
    try:
        for row in _of_controllers(project, names, speeds, setup, remarks, progress):
            rows.append(row)
        run = _joined(project, benches, rows, remarks)
        same = setup["plant"] is None
        for case in run.best if units or same else ():
            progress(f"{case.name} on other gears", 0.85)
            detail = compensated(project, case.name, speed=case.speed, robust=same, units=units, seed=seed, **setup)
            run = run._replace(details=(*run.details, detail))
    except KeyboardInterrupt:
        return run or (_joined(project, benches, rows, remarks) if rows else None), True
    return run, False


def _of_controllers(
    project: Project, names: Sequence[str], speeds: Floats, setup: dict[str, Any], remarks: list[str],
    progress: Callable[[str, float], None],
) -> Iterator[CompensationBench]:  # fmt: skip
    """Each controller at all speeds; one beside the plain loop that refuses the drive becomes a remark."""
    for i, name in enumerate(names):
        progress(name, 0.8 * i / len(names))
        try:
            yield compensation_bench(project, [name], speeds=speeds, **setup)
        except ValueError as error:
            if i == 0:
                raise
            remarks.append(f"Omitted: {name}, because {error}.")


def _joined(
    project: Project, benches: dict[float, Bench], rows: Sequence[CompensationBench], remarks: Sequence[str]
) -> Run:
    """One bench of all controllers, and the best of them with and without an encoder on the load."""
    results = tuple(row for case in rows for row in case.results)
    bench = CompensationBench(rows[0].speeds, tuple(row[0].name for row in results), results)
    best = (best_at(bench, worst(bench), load_encoder=seeing) for seeing in (True, False))
    return Run(project, benches, bench, tuple(remarks), tuple(case for case in best if case is not None))


def _tables(run: Run) -> tuple[tuple[str, TableAlone], ...]:
    """Tables of the best controller that can be written as tables, where the plain loop has the largest error."""
    i = worst(run.results)
    for case in sorted((row[i] for row in run.results.results), key=lambda case: case.after.rms):
        if case.stable and not case.excluded and (tables_of := written_tables(run.benches[case.load_angle], case)):
            return tables_of
    return ()


def _write(title: str, run: Run, output: Path, *, figured: bool) -> None:
    rows = tables.rows(run)
    drawn = _figures(title, run) if figured else {}
    orders = {f"order-table-{name}.json": alone.table for name, alone in run.tables}
    table = as_csv(list(rows[0]), [row.values() for row in rows])
    texts = {"compensation.csv": table, "compensation.json": to_json(tables.data(run))}
    write_all(output, texts | {f"{name}.svg": text for name, text in drawn.items()} | orders)


def _figures(title: str, run: Run) -> dict[str, str]:
    """Figures as SVG by the names of their files; one that shows nothing is left out."""
    drawn = dict[str, str]()

    def draw(name: str, panels: list[Panel], height: float, label: str) -> None:
        if panels and (svg := stacked(named(panels, title), height, label)):
            drawn[name] = svg

    for name, seeing in (("speeds", False), ("speeds-load-encoder", True)):
        draw(name, figures.speed_panels(run.results, load_encoder=seeing), 300.0, "residual error over the speed")
    if run.best:
        speed, bench = run.best[0].speed, run.benches[run.best[0].load_angle]
        before = figures.motion(bench, PLAIN, speed, f"plain loop, {bench.speeds.said(speed)}")
        after = [figures.motion(bench, case.name, speed, case.name) for case in run.best]
        draw("error", figures.error_panels(before, after), 240.0, "pointing error before and after")
        draw("orders", figures.order_panels(run.best), 240.0, "amplitudes by order before and after")
    if units := {case.name: case.units for case in run.details if case.units is not None}:
        draw("units", figures.units_panels(units), 240.0, "residual errors of many units")
    return drawn
