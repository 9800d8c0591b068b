"""`strainwave sweep` over numbers of the project file: the response of the whole drive at every point of a grid."""

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
import numpy as np

from ....base.number_text import unit_text
from ....base.quantities import convert
from ....base.results import Floats
from ....drive.project import Project
from ....drive.speeds import Speeds
from ....drive.train_curve import refuse_free
from ....files.notes import load_remark, unsaid
from ....files.variants.names import keys_of, quantity
from ....files.variants.replaced import replaced
from ....files.yaml_text import read
from ...console import Progress, number, to_json
from ...console.terminal import echo

if TYPE_CHECKING:
    import xarray as xr

MOST_VALUES, DIGITS = 10_000, 5
DOUBT = "check|is usual"  # in a note
WHAT = {
    "peak": "largest |error|",
    "oscillation": "largest oscillation of the error",
    "smallest": "oscillation of the error in the motor turn where it is smallest",
    "torque": "largest torque in the gear",
}


def swept(
    project: Project, grid: tuple[str, ...], output: Path, workers: int | None, chunk: int | None, retune: bool,
    connect: Callable[[], AbstractContextManager[Any]], progress: Progress, as_json: bool,
) -> None:  # fmt: skip
    """Sweep the response of a project's whole drive, or go on where the last run stopped, and print the report."""
    axes = dict(axis(text) for text in grid)
    if project.train is not None:
        refuse_free(project.train)
    for name, texts in axes.items():
        try:
            replaced(project, {name: texts[0]})
        except ValueError as error:
            raise click.BadParameter(f"{name} = {texts[0]}: {error}") from None
    from ....files.variants.project_sweep import sweep_project  # xarray and zarr, seconds that a refusal need not take

    with connect() as connected:
        data = sweep_project(
            project, axes, store=output, workers=workers, chunk=chunk, client=connected, retune=retune,
            progress=progress.show,
        )  # fmt: skip
    tuned = data.attrs["tuning"]
    remarks = [*filter(None, [tuned]), *project.notes, *load_remark(project), *doubts(project, axes)]
    about = {"title": project.title, "store": str(output), "remarks": remarks, "tuning": tuned}
    report = spans(data) | about
    counts = "jumping", "truncated"
    echo(to_json(report) if as_json else summary(report, partial(_placed, project.speeds), counts))


def doubts(project: Project, axes: Mapping[str, Sequence[str]]) -> Iterator[str]:
    """Doubts about the ends of a grid, beyond the notes of the project."""
    for name, texts in axes.items():
        for text in {texts[0], texts[-1]} if name != "gear" else ():
            notes = replaced(project, {name: text}, retune=True).notes
            yield from (f"{name} = {text}: {note}" for note in unsaid(notes, project.notes) if re.search(DOUBT, note))


def of_file(project: Project, name: str) -> bool:
    """True where the project file has a field of this name."""
    try:
        return bool(keys_of(read(project.text).content, name))
    except ValueError:
        return False


def axis(text: str) -> tuple[str, list[str]]:
    """Read "load.inertia=1 kg*m^2:2 kg*m^2:5", with ":log" for even ratios, or "gear=CSG-40-50,SHG-40-50"."""
    name, equals, values = map(str.strip, text.partition("="))
    if not equals or not values:
        fault = (
            f"{text!r} is not a grid; write for example load.inertia=1 kg*m^2:2 kg*m^2:5 or gear=CSG-40-50,SHG-40-50"
        )
        raise click.BadParameter(fault)
    parts = [part.strip() for part in values.split(":")]
    if len(parts) == 1:
        return name, [part.strip() for part in values.split(",")]
    logarithmic = is_range(text, name, parts)
    (low, low_unit), (high, high_unit) = map(quantity, parts[:2])
    if low is None or high is None:
        raise click.BadParameter(f"{text!r} is no range of numbers; write the names one by one, with commas")
    unit = high_unit or low_unit
    if low_unit not in ("", unit):
        raise click.BadParameter(f"{text!r} begins in {low_unit} and ends in {high_unit}; write both ends in one unit")
    numbers = spaced(text, (low, high), parts[2], MOST_VALUES, logarithmic)
    return name, [f"{repr(value).removesuffix('.0')} {unit}".rstrip() for value in numbers.tolist()]


def is_range(text: str, name: str, parts: list[str]) -> bool:
    """True for LOW:HIGH:COUNT:log, which has even ratios (click.BadParameter if it is no range)."""
    logarithmic = len(parts) == 4 and parts[3] == "log"
    if len(parts) != 3 and not logarithmic:
        form = f"{name}=LOW:HIGH:COUNT"
        raise click.BadParameter(f"{text!r} is no range; write it as {form} or {form}:log")
    return logarithmic


def spaced(text: str, ends: tuple[float, float], count: str, largest: int, logarithmic: bool) -> Floats:
    """`count` values from end to end (click.BadParameter if there are too many, or none)."""
    if not count.isdecimal() or not 1 <= int(count) <= largest:
        raise click.BadParameter(f"{count!r} in {text!r} is no count; give a whole number from 1 to {largest}")
    if logarithmic and not min(ends) > 0.0:
        raise click.BadParameter(f"{text!r} includes 0; logarithmic steps need two positive numbers")
    return (np.geomspace if logarithmic else np.linspace)(*ends, int(count))


def spans(data: "xr.Dataset") -> dict[str, Any]:
    """Ranges of the largest error, oscillation and torque, with the points of their ends; counts of points."""
    cells, errors = data.load(), list(map(str, data.attrs["errors"].splitlines()))
    if "peak" not in cells or not bool(cells["peak"].notnull().any()):
        raise RuntimeError(f"none of {cells['point_status'].size} points could be computed: {errors[0]}")
    ranges: dict[str, Any] = {}
    for name in filter(cells.__contains__, WHAT):
        values = cells[name]
        ranges[name] = {"unit": values.attrs.get("units", "")}
        for end, index in (("smallest", values.argmin(...)), ("largest", values.argmax(...))):
            point = cells.isel(index)
            location = {str(path): _at(value) for path, value in point[name].coords.items()}
            ranges[name] |= {end: float(point[name]), f"{end}_at": location, f"{end}_speed": float(point[f"{name}_at"])}
    return {
        "points": cells["point_status"].size,
        "over": {str(dim): int(n) for dim, n in cells["point_status"].sizes.items()},
        "variables": ranges,
        "jumping": int((cells["jumps"] > 0.0).sum()),
        "truncated": int((cells["truncated"] > 0.0).sum()),
        "failed": cells.attrs["failed_points"],
        "errors": errors,
    }


def _at(value: "xr.DataArray") -> str:
    """A coordinate of a point in the unit that was typed."""
    content = value.item()
    text = content if isinstance(content, str) else number(float(content), DIGITS)
    return f"{text} {unit_text(value.attrs.get('units', ''))}".rstrip()


def summary(report: dict[str, Any], location_of: Callable[[dict[str, Any]], str], counts: Sequence[str]) -> str:
    """Return the report of a sweep as text; `location_of` writes the point of the largest value of a variable."""
    over = ", ".join(f"{path} ({n})" for path, n in report["over"].items())
    lines = [f"{report['points']} points over {over}"]
    for name, span_of in report["variables"].items():
        unit = "arcsec" if span_of["unit"] == "rad" else span_of["unit"]
        ends = [number(convert(span_of[end], span_of["unit"], unit), DIGITS) for end in ("smallest", "largest")]
        span = f"{' to '.join(ends)} {unit_text(unit)}".rstrip()
        lines.append(f"  {WHAT.get(name, name)}: {span}, the largest at {location_of(span_of)}")
    lines.append("  " + ", ".join(f"{name.replace('_', ' ')}: {report[name]}" for name in (*counts, "failed")))
    lines += [f"  {line}" for line in (*report["errors"], *(f"note: {remark}" for remark in report["remarks"]))]
    lines.append(f"  store: {report['store']} (zarr; the same command continues it)")
    return f"{report['title']}: " + "\n".join(lines)


def _placed(speeds: Speeds, extremes: dict[str, Any]) -> str:
    """Point of the largest value, with the speed of the motor, as the ratio may vary, or of the forcing phase."""
    shaft = "rpm at the motor" if speeds.by_motor else "rad/s of the forcing phase"
    point = ", ".join(f"{path} = {value}" for path, value in extremes["largest_at"].items())
    return f"{point} (at {number(speeds.scale * extremes['largest_speed'], DIGITS)} {shaft})"
