"""The group `move` of a project file: the profile part by part, the payload, where it begins, when it has settled.

A profile in CSV: time and angle of the load, with their units in the names of the columns.
"""

import json
from pathlib import Path
from typing import Annotated, Any, NamedTuple, get_args, get_type_hints

from pydantic import BeforeValidator

from ..base.quantities import checked, convert
from ..drive.asked import Payload, Task
from ..study.move.profiles import AngleProfile, Dwell, Part, SCurve, Trapezoid
from .entries import Wrong, of_class, read_entry, refusal
from .scan_file import Column, check_signs, from_header, name_and_unit, read_numbers, read_rows
from .yaml_text import FileError, Problem, as_path, complaint, read_text, shown

PARTS = {"trapezoid": Trapezoid, "s_curve": SCurve, "dwell": Dwell}
NAMES = {cls: name for name, cls in PARTS.items()}
IN_FILE = "angle_profile"
EXAMPLE = "{type: trapezoid, angle: 90 deg, time: 0.6 s}"

LARGEST = 64 * 1024 * 1024
UNITS = {"time": "s", "angle": "rad"}
HINT = "name the columns with their units: time [s], angle [deg]"


def read_profile(path: str | Path, *, delimiter: str = ",", decimal: str = ".") -> AngleProfile:
    """Read times and angles of the load.

    Parameters
    ----------
    path : str or Path
        CSV of at most 64 MiB with the columns `time` and `angle` and their units: "time [s], angle [deg]". Other
        columns, empty lines, lines that begin with # and those above the names of the columns are left out.
    delimiter, decimal : str
        What stands between columns and before decimals, never guessed: German tables have ";" and ",".

    Returns
    -------
    AngleProfile

    Raises
    ------
    FileError
        If the file cannot be read, a column or its unit is missing, a number is wrong, or time goes back; a ValueError
        with one line per problem, `file:line:column: field: fact, value, remedy`.
    ValueError
        If delimiter and decimal sign cannot go together.
    """
    path = as_path(path)
    check_signs(delimiter, decimal)
    text = read_text(path, "profile", LARGEST)
    if isinstance(text, Problem):
        raise FileError(complaint(path, [text]))
    problems: list[Problem] = []
    rows = from_header(list(read_rows(text, delimiter, problems)), "time")
    if not problems and len(rows) < 3:
        problems.append(Problem(1, 1, "file", f"has fewer than two points; {HINT}, and give one line per point"))
    columns = [] if problems else _columns(*rows[0], delimiter, problems)
    table = None if problems else read_numbers(rows, columns, decimal, problems)
    if problems or table is None:
        raise FileError(complaint(path, problems))
    times, angles = (table * [column.factor for column in columns]).T.tolist()
    back = next((i for i in range(len(times) - 1) if not times[i] < times[i + 1]), None)
    if back is not None:
        said = (
            f"{table[back + 1, 0]:.9g} stands after {table[back, 0]:.9g}; a profile goes forward in time: correct or "
        )
        place = Problem(rows[back + 2][0], columns[0].place + 1, "time", said + "remove the line")
        raise FileError(complaint(path, [place]))
    profile: AngleProfile = checked(AngleProfile(tuple(times), tuple(angles)))
    return profile


def _columns(line: int, header: list[str], delimiter: str, problems: list[Problem]) -> list[Column]:
    """Columns of time and angle, with their factors to SI."""
    parts = [name_and_unit(cell) for cell in header]
    names = [name for name, _ in parts]
    other = next((d for d in ";,\t" if d != delimiter and d in header[0]), None)
    if len(header) == 1 and other is not None:
        problems.append(Problem(line, 1, "file", f"has one column; if {other!r} parts them, say so with --delimiter"))
        return []
    found = []
    for name, kind in UNITS.items():
        if names.count(name) != 1:
            fact = "is there twice" if name in names else f"is missing; the file has {', '.join(map(shown, names[:8]))}"
            problems.append(Problem(line, 1, name, f"column {shown(name)} {fact}; {HINT}"))
            continue
        place = names.index(name)
        unit = parts[place][1]
        try:
            if not unit:
                raise ValueError(f"column {shown(name)} has no unit; {HINT}")
            found.append(Column(name, place, float(convert(1.0, unit, kind))))
        except ValueError as wrong:
            problems.append(Problem(line, place + 1, name, str(wrong)))
    return found


class ProfileFile(NamedTuple):
    """A part of a profile that is in a CSV file beside the project file."""

    file: str


def read_part(value: Any) -> Part | ProfileFile:
    """Read one part of a profile (PydanticCustomError with all that is wrong)."""
    if isinstance(value, dict) and str(value.get("type", "")).replace("-", "_") == IN_FILE:
        return _in_file(value)
    known: dict[str, Any] = {**PARTS, IN_FILE: ProfileFile}
    part: Part = read_entry(value, known, EXAMPLE)
    return part


def _in_file(value: dict[str, Any]) -> ProfileFile:
    wrong = [Wrong((key,), "unknown field; known: type, file", True) for key in value if key not in ("type", "file")]
    file = value.get("file")
    if "file" not in value:
        wrong.append(
            Wrong(("file",), "is missing; write the name of a CSV file with the columns time [s], angle [deg]")
        )
    elif not isinstance(file, str) or "/" in file or "\\" in file or ":" in file or file.startswith("."):
        said = f"{shown(file)} is not a plain file name; put the file beside the project file"
        wrong.append(Wrong(("file",), "" if file is None else said))
    if wrong:
        raise refusal(*wrong)
    return ProfileFile(str(file))


def read_payload(value: Any) -> Payload:
    """Read a payload (PydanticCustomError with all that is wrong)."""
    wrong: list[Wrong] = []
    payload: Payload = of_class(value, Payload, (), wrong)
    if wrong:
        raise refusal(*wrong)
    return payload


def task_of(spec: Any, folder: Path) -> Task | None:
    """What the group `move` asks, its files read from a folder (FileError); None where there is no such group."""
    if spec is None:
        return None
    parts = tuple(read_profile(folder / part.file) if isinstance(part, ProfileFile) else part for part in spec.profile)
    files = tuple(part.file if isinstance(part, ProfileFile) else "" for part in spec.profile)
    return Task(parts, spec.start, spec.payload, spec.window, files)


def task_text(task: Task) -> str:
    """Write a task as the group of a project file.

    Raises
    ------
    ValueError
        If a part is an `AngleProfile` of no file, which a project file does not hold.
    """
    parts = [_in_file_text(file) if file else _group(part) for part, file in zip(task.profile, task.files, strict=True)]
    fields = [f"profile: [{', '.join(parts)}]"]
    if task.start is not None:
        fields.append(f"start: {task.start!r} rad")
    if task.payload is not None:
        fields.append(f"payload: {_group(task.payload, typed=False)}")
    if task.window is not None:
        fields.append(f"window: {task.window!r} rad")
    return "{" + ", ".join(fields) + "}"


def _in_file_text(file: str) -> str:
    return f"{{type: {IN_FILE}, file: {json.dumps(file, ensure_ascii=False)}}}"


def _group(model: Any, typed: bool = True) -> str:
    """Fields of a part or a payload that differ from their defaults."""
    if isinstance(model, AngleProfile):
        raise ValueError("a project file holds an AngleProfile as a CSV file beside it; write one and name it there")
    fields = [f"type: {NAMES[type(model)]}"] if typed else []
    for field, hint in get_type_hints(type(model), include_extras=True).items():
        value = getattr(model, field)
        if field not in model._field_defaults or value != model._field_defaults[field]:
            fields.append(f"{field}: {value!r} {get_args(hint)[1]}".rstrip().replace("**", "^"))
    return "{" + ", ".join(fields) + "}"


ReadPart = Annotated[Any, BeforeValidator(read_part)]
ReadPayload = Annotated[Any, BeforeValidator(read_payload)]
