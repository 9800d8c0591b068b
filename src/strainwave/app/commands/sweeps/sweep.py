"""`strainwave sweep`: a project's drive over a grid of its parameters, kept in a store.

Over parameters of the error equation these are trajectories; over other numbers of the project file, and for a drive of
which the equation leaves something out, the response of the whole drive (`project_sweep`). What takes seconds to import
is imported when the grid is known to be right.
"""

import logging
import math
import re
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
import numpy as np

from ....base.number_text import unit_text
from ....base.protocols import state_count
from ....base.quantities import Parameter, convert, parameters, parse, shown
from ....base.results import Floats
from ....drive.project import Project
from ....files.notes import remarks
from ....files.reading import read_project
from ....files.variants.names import quantity as parted
from ....files.variants.replaced import tuning
from ...console import Progress, number, to_json
from ...console.terminal import echo
from ...curves import WHAT_X_IS
from ..options import json_option, output_option, project_argument, retune_option
from . import project_sweep

if TYPE_CHECKING:
    import xarray as xr

MEASURES = ("peak", "rms", "mean", "extremes")  # and classes of these names
MOST_VALUES, DIGITS = 10_000_000, 5
TOGETHER = " & "  # between the paths of one factor


@click.command()
@project_argument
@click.option(
    "--grid", multiple=True, required=True, metavar="PATH=VALUES",
    help='Values of a parameter: LOW:HIGH:COUNT[:log] or V1,V2,..., in SI units or their own ("9 rad/s"); repeatable. '
    "PATH is a parameter of the error equation (omega, J, B, law.K, error.lines.0.amplitude), which is integrated, or "
    "a name of the project file (loop.K_p, load.inertia, gear=CSG-40-50,SHG-40-50) for the response of the drive.",
)  # fmt: skip
@click.option(
    "--measure", "measures", multiple=True, default=("peak",),
    help="Quantity to store for every trajectory: peak, rms, mean, extremes, amplitude:K; repeatable.",
)  # fmt: skip
@click.option("--settle", type=click.IntRange(0), default=200, help="Periods simulated before the measurement.")
@click.option("--periods", type=click.IntRange(1), default=20, help="Periods of the measurement.")
@output_option("Folder for the results; the same command resumes.", required=True)
@click.option("--workers", type=click.IntRange(1), help="Threads. Default: one for every processor.")
@click.option(
    "--chunk", type=click.IntRange(1),
    help="Points computed and written in one block; a stopped run loses at most one block. Default: automatic.",
)  # fmt: skip
@click.option("--cluster", metavar="ADDRESS", help="Scheduler of a dask cluster, for example tcp://127.0.0.1:8786.")
@retune_option
@json_option
def sweep(
    project: Path, grid: tuple[str, ...], measures: tuple[str, ...], settle: int, periods: int, output: Path,
    workers: int | None, chunk: int | None, cluster: str | None, retune: bool, as_json: bool,
) -> None:  # fmt: skip
    """Compute a drive over a grid of parameter values; resumable.

    An interrupted sweep keeps its finished points; the same command continues from them.
    """
    drive = read_project(project)
    system = drive.system(reduced=True)
    free, grids = parameters(system), [in_equation(text, drive) for text in grid]
    if drive.left_out or retune or any(_of_file_alone(drive, text, free) for text in grids):
        refuse_options_of_trajectories()
        with logged(drive.title) as progress:
            project_sweep.swept(drive, grid, output, workers, chunk, retune, lambda: client(cluster), progress, as_json)
        return
    axes = dict(axis(text, free) for text in grids)
    units = dict(typed_unit(text, free) for text in grids)
    kept = tuple(map(named, measures))
    from ....sample.ensemble_measure import EnsembleMeasure
    from ....sample.sweeping import sweep as swept

    measure = EnsembleMeasure((0.0,) * state_count(system), periods, kept, settle)
    with logged(drive.title) as progress, client(cluster) as connected:
        how: dict[str, Any] = {"client": connected, "workers": workers, "chunk": chunk, "progress": progress.show}
        data = swept(measure, system, axes, store=output, **how)
    report = spans(data, units) | {"conventions": WHAT_X_IS, "title": drive.title, "store": str(output), "units": units}
    names = [path.strip() for text in grid for path in text.partition("=")[0].split("&")]
    report["tuning"] = tuning(drive, [name for name in names if project_sweep.of_file(drive, name)], False)
    speed = at_one_speed(drive, float(system.omega), list(axes))
    report["remarks"] = [*filter(None, [report["tuning"]]), *remarks(drive), *speed, *bare(grids, units)]
    counts = "not_settled", "diverged"
    echo(to_json(report) if as_json else project_sweep.summary(report, partial(placed, units), counts))


def refuse_options_of_trajectories() -> None:
    """Refuse options that the response of the whole drive has no use for, where they were given (click.UsageError)."""
    context = click.get_current_context()
    options = {"measures": "--measure", "settle": "--settle", "periods": "--periods"}
    default = click.core.ParameterSource.DEFAULT
    if given := [option for name, option in options.items() if context.get_parameter_source(name) is not default]:
        raise click.UsageError(
            "this sweep computes the response of the whole drive: peak, oscillation and torque; remove "
            f"{' and '.join(given)}, valid for the error equation only"
        )


def at_one_speed(project: Project, omega: float, paths: list[str]) -> list[str]:
    """Say the base-angle speed [rad/s] of a sweep over other parameters, where the file gives several."""
    if any("omega" in path.split(TOGETHER) for path in paths) or len(project.speeds.given) == 1:
        return []
    rpm = project.speeds.rpm(omega)
    speed = f"{omega:.6g} rad/s" + ("" if rpm is None else f" ({rpm:.5g} rpm) at the motor")
    return [f"All points are computed at {speed}, the middle of the speed range; a grid of omega sets other speeds."]


def bare(grids: list[str], units: dict[str, tuple[str, str]]) -> list[str]:
    """Say in which unit values were taken that were given without one."""
    sentences = []
    for text in grids:
        path, _, values = map(str.strip, text.partition("="))
        unit = units[path][0]
        if unit and not any(map(_unit_of, re.split("[:,]", values))):
            sentences.append(f"{path} has no unit in {text!r}: its values are read in {unit}.")
    return sentences


def _of_file_alone(project: Project, text: str, free: list[Parameter]) -> bool:
    """True for a grid over a name of the project file that is no parameter of the equation."""
    path = text.partition("=")[0].strip()
    paths = {parameter.path for parameter in free}
    return TOGETHER not in path and path not in paths and project_sweep.of_file(project, path)


def in_equation(text: str, project: Project) -> str:
    """Write a grid with the path that the error equation has for a name of the project file."""
    paths, equals, values = text.partition("=")
    same = {"damping.B": "B"} | ({"load.inertia": "J"} if project.motor == "held" else {})
    renamed = []
    for path in map(str.strip, paths.split("&")):
        for name, short in (("gear.law.", "law."), ("excitation.kinematic_error.", "error.lines.")):
            if path.startswith(name):
                path = short + path.removeprefix(name)
        renamed.append(same.get(path, path))
    return TOGETHER.join(renamed) + equals + values


def axis(text: str, free: list[Parameter]) -> tuple[str, Floats]:
    """Read "law.alpha=1e4:1e5:20", with ":log" at the end for even ratios, or "omega=10 rad/s, 200 rpm".

    A factor of several parameters is "law.K1 & law.K2=0.9:1.1:5".
    """
    path, equals, values = map(str.strip, text.partition("="))
    units = {parameter.path: parameter.unit for parameter in free}
    if not equals or not values:
        raise click.BadParameter(f"{text!r} is not a grid; write for example law.alpha=1e4:1e5:20 or omega=10,20,50")
    paths = path.split(TOGETHER)
    if unknown := [name for name in paths if name not in units]:
        raise click.BadParameter(f"{unknown[0]!r} is not a parameter of this drive; it has {_listed(free)}")
    if fixed := [p.path for p in free if p.path in paths and isinstance(p.value, int)]:
        raise click.BadParameter(
            f"{fixed[0]!r} is a whole number, the same in all trajectories; write a project file for each, or "
            f"sweep {_listed(free)}"
        )
    unit = "" if len(paths) > 1 else units[path]
    parts = [part.strip() for part in values.split(":")]
    if len(parts) == 1:
        return path, np.array([quantity(part, unit) for part in values.split(",")])
    logarithmic = project_sweep.is_range(text, path, parts)
    ends = quantity(parts[0], unit), quantity(parts[1], unit)
    return path, project_sweep.spaced(text, ends, parts[2], MOST_VALUES, logarithmic)


def _listed(free: list[Parameter]) -> str:
    return ", ".join(parameter.path for parameter in free if not isinstance(parameter.value, int))


def typed_unit(text: str, free: list[Parameter]) -> tuple[str, tuple[str, str]]:
    """Path of a grid, with its unit in SI and the one that its values were given in."""
    path, _, values = map(str.strip, text.partition("="))
    unit = next((parameter.unit for parameter in free if parameter.path == path), "")
    return path, (unit, next(filter(None, map(_unit_of, re.split("[:,]", values))), unit))


def _unit_of(text: str) -> str:
    """Unit of a quantity; "" without one."""
    value, unit = parted(text)
    return "" if value is None else unit


def quantity(text: str, unit: str) -> float:
    """Read a plain number in SI units, or a number with a unit of its own."""
    try:
        value = float(text)
    except ValueError:
        try:
            return parse(text.strip(), unit)
        except ValueError as error:
            raise click.BadParameter(str(error)) from None
    if not math.isfinite(value):
        raise click.BadParameter(f"{text.strip()!r} is not finite; give a number in {unit or 'plain units'}")
    return value


def named(text: str) -> Any:
    """Return the measure of a name: peak, rms, mean, extremes or amplitude:K."""
    from ....numerics.ensemble import measures

    name, _, order = text.partition(":")
    if name == "amplitude" and order.isdecimal() and int(order) > 0:
        return measures.Amplitude(int(order))
    if text not in MEASURES:
        names = ", ".join(MEASURES)
        raise click.BadParameter(f"{text!r} is not a measure; measures: {names}, amplitude:1, amplitude:2, ...")
    return getattr(measures, text.capitalize())()


@contextmanager
def logged(title: str) -> Iterator[Progress]:
    """Show on stderr the progress, and what the library logs."""
    with Progress(title) as progress:
        log, handler = logging.getLogger("strainwave.sample"), logging.StreamHandler(sys.stderr)
        handler.setFormatter(logging.Formatter("{}: %(message)s".format(title.replace("%", "%%"))))
        log.addHandler(handler)
        level = log.level
        log.setLevel(logging.INFO)
        try:
            yield progress
        finally:
            log.setLevel(level)
            log.removeHandler(handler)


@contextmanager
def client(address: str | None) -> Iterator[Any]:
    """Connect to a cluster's scheduler, where one is given."""
    if address is None:
        yield None
        return
    try:
        from distributed import Client
    except ModuleNotFoundError:
        raise ModuleNotFoundError("a cluster needs the extra `cluster`: pip install 'strainwave[cluster]'") from None
    try:
        connected: Any = Client(address)  # type: ignore[no-untyped-call]
    except (OSError, ValueError) as error:
        why = str(error)[:200]
        raise RuntimeError(f"no scheduler answers at {shown(address)} ({why}); see the page on sweeps") from None
    with connected:
        yield connected


def spans(data: "xr.Dataset", units: dict[str, tuple[str, str]]) -> dict[str, Any]:
    """Range of every variable, with the point of the largest value; read a slice of the first dimension at a time.

    `units` of the axes are those in SI, and those in which the points of errors are written.
    """
    sizes = {str(dim): int(n) for dim, n in data["point_status"].sizes.items()}
    ranges: dict[str, Any] = {}
    unsettled, diverged = 0, 0
    errors = [_as_typed(error, units) for error in data.attrs["errors"].splitlines()]
    if "status" not in data:
        raise RuntimeError(f"none of {math.prod(sizes.values())} points could be computed: {errors[0]}")
    dim = next(iter(sizes))
    step = max(1, 1_000_000 * sizes[dim] // math.prod(sizes.values()))
    for start in range(0, sizes[dim], step):
        part = data.isel({dim: slice(start, start + step)}).load()
        diverged += int((part["status"] == 1).sum())
        unsettled += int((part["period"] == 0).sum())
        for name in part:
            if part[name].dtype.kind == "f" and name != "ended" and bool(part[name].notnull().any()):
                _widen(ranges.setdefault(str(name), {"unit": part[name].attrs.get("units", "")}), part[name])
    return {
        "points": math.prod(sizes.values()), "over": sizes, "variables": ranges, "not_settled": unsettled - diverged,
        "diverged": diverged, "failed": data.attrs["failed_points"], "errors": errors,
    }  # fmt: skip


def _widen(extremes: dict[str, Any], values: "xr.DataArray") -> None:
    top = values.isel(values.argmax(...))
    extremes["smallest"] = min(extremes.get("smallest", math.inf), float(values.min()))
    if float(top) > extremes.get("largest", -math.inf):
        extremes["largest"] = float(top)
        extremes["largest_at"] = {str(path): float(value) for path, value in top.coords.items()}


def placed(units: dict[str, tuple[str, str]], extremes: dict[str, Any]) -> str:
    """Point of the largest value, in the units that were given."""
    return ", ".join(f"{path} = {_in_unit(value, *units[path])}" for path, value in extremes["largest_at"].items())


def _in_unit(value: float, unit: str, given: str) -> str:
    """A value of an axis in the unit that it was given in."""
    return f"{number(convert(value, unit, given), DIGITS)} {unit_text(given)}".rstrip()


def _as_typed(error: str, units: dict[str, tuple[str, str]]) -> str:
    """Error at a point, whose coordinates are in the units that were given."""
    parts = re.match(r"(points? [^(]*\((?:from )?)([^)]*)(\): .*)", error)
    values = [value.partition(" = ") for value in parts[2].split(", ")] if parts else []
    if parts is None or any(path not in units for path, _, _ in values):
        return error
    typed = ", ".join(f"{path} = {_in_unit(float(value), *units[path])}" for path, _, value in values)
    return parts[1] + typed + parts[3]
