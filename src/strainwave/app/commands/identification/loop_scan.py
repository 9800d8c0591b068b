"""`strainwave loop-scan`: a measured loop of torque over torsion as a torsion law with its intervals."""

from pathlib import Path
from typing import Any

import click
import numpy as np

from ....files.scan_file import Column, check_signs, from_header, name_and_unit, read_numbers, read_rows
from ....files.yaml_text import FileError, Problem, complaint, read_text
from ....quantities import convert
from ....results import Floats
from ....study.identification.loops.loop_fit import fit_loop
from ....study.identification.loops.loop_result import LoopFit
from ...console import number, print_table, to_json
from ...figures.loop import loop_figure
from ...output import staged, write_csv
from ...units import quantity, sign

LARGEST = 64 * 1024 * 1024
UNITS = {"torsion": "rad", "torque": "N*m"}
HINT = "name the columns with their units: torsion [arcmin], torque [N*m]"


def show(
    file: Path, rated_torque: str | None, ratio: float | None, torsion: str, torque: str, delimiter: str, decimal: str,
    output: Path | None, as_json: bool,
) -> None:  # fmt: skip
    """Read a loop, fit a law, write what is asked for and print the numbers.

    Raises
    ------
    FileError
        If the file cannot be read, or its samples are no loop.
    click.BadParameter
        If an option is no quantity.
    """
    rated = None if rated_torque is None else quantity("--rated-torque", rated_torque, "N*m")
    x, t, last = read_loop_file(file, {"torsion": torsion, "torque": torque}, delimiter, decimal)
    try:
        found = fit_loop(x, t, rated_torque=rated, ratio=ratio)
    except ValueError as error:
        raise FileError(complaint(file, [Problem(last, 1, "loop", str(error))])) from None
    if output is not None:
        write(file, found, output)
    click.echo(to_json({"file": file.name} | data(found))) if as_json else _print(file, found, output)


def read_loop_file(path: Path, wanted: dict[str, str], delimiter: str, decimal: str) -> tuple[Floats, Floats, int]:
    """Torsion (n,) [rad], torque (n,) [N*m] and the line of the last sample of a CSV file; errors as `read_scan`."""
    check_signs(delimiter, decimal)
    text = read_text(path, "loop file", LARGEST)
    if isinstance(text, Problem):
        raise FileError(complaint(path, [text]))
    problems: list[Problem] = []
    rows = from_header(list(read_rows(text, delimiter, problems)), wanted["torsion"])
    if not problems and len(rows) < 2:
        problems.append(Problem(1, 1, "file", f"has no samples; {HINT}, and give one line per sample"))
    columns = [] if problems else [_column(field, name, *rows[0], problems) for field, name in wanted.items()]
    told = [column for column in columns if column is not None]
    table = np.zeros((0, 2)) if problems else read_numbers(rows, told, decimal, problems)
    if problems:
        raise FileError(complaint(path, problems))
    return told[0].factor * table[:, 0], told[1].factor * table[:, 1], rows[-1][0]


def _column(field: str, text: str, line: int, header: list[str], problems: list[Problem]) -> Column | None:
    """Column of the file that an option names, with its factor to SI."""
    parts = [name_and_unit(cell) for cell in header]
    names, (name, unit) = [name for name, _ in parts], name_and_unit(text)
    if names.count(name) != 1:
        fact = "is there twice" if name in names else f"is missing; the file has {', '.join(map(repr, names[:8]))}"
        problems.append(Problem(line, 1, field, f"column {name!r} {fact}; {HINT}, or give --{field}"))
        return None
    place = names.index(name)
    try:
        if not (unit or parts[place][1]):
            raise ValueError(f"column {name!r} has no unit; {HINT}")
        return Column(name, place, float(convert(1.0, unit or parts[place][1], UNITS[field])))
    except ValueError as wrong:
        problems.append(Problem(line, 1, field, str(wrong)))
        return None


def data(found: LoopFit) -> dict[str, Any]:
    """The numbers with their intervals, in SI."""
    numbers = {
        name: {"value": value, "low": found.interval(name).low, "high": found.interval(name).high}
        for name, value in found.values.items()
    }
    return {
        "numbers": numbers,
        "unidentified": found.unidentified,
        "comparison": [row._asdict() for row in found.comparison],
        "reason": found.reason,
        "rated_torque_N_m": found.rated_torque,
        "cycles": found.cycles,
        "energy_J": found.energy,
        "residual_rms_N_m": found.residual_rms,
        "samples": len(found.torque),
        "remarks": found.remarks,
        "project": found.yaml,
    }


def write(file: Path, found: LoopFit, folder: Path) -> None:
    """Write figure, samples, numbers and the block of a project file; they appear when they are complete."""
    with staged(folder) as part:
        (part / "loop.svg").write_text(loop_figure(found), encoding="utf-8")
        (part / "gear.yaml").write_text(found.yaml, encoding="utf-8")
        (part / "loop.json").write_text(to_json({"file": file.name} | data(found)) + "\n", encoding="utf-8")
        columns = [("torsion_rad", found.torsion), ("torque_N_m", found.torque), ("fitted_N_m", found.fitted)]
        write_csv(part / "loop.csv", columns)


def _print(file: Path, found: LoopFit, output: Path | None) -> None:
    rows = [
        (name, value, number(low, 5), number(high, 5), sign(unit)) for name, value, low, high, unit in found.table()
    ]
    print_table(
        f"{file.name}: {len(found.torque)} samples, {found.cycles:.3g} cycles",
        ("number", "value", "from", "to", "unit"), rows, "interval of 95 %",
    )  # fmt: skip
    candidates = [
        (row.name, row.unknowns, number(row.error, 4), "taken" if row.chosen else "") for row in found.comparison
    ]
    print_table("candidates, by their error in blocks of samples left out", ("law", "unknowns", "N·m", ""), candidates)
    for sentence in (*dict.fromkeys(found.unidentified.values()), found.reason, *found.remarks):
        click.echo(f"{sentence[:1].upper()}{sentence[1:]}.")
    click.echo(f"The cycles dissipate {number(found.energy)} J; the residual is {number(found.residual_rms)} N·m rms.")
    click.echo(f"for a project file:\n{found.yaml}".rstrip())
    if output is not None:
        click.echo(f"written: {output}/loop.svg, loop.csv, loop.json, gear.yaml")
