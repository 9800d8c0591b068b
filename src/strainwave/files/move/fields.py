"""The group `move` of a project file: the profile part by part, the payload, where it begins, when it has settled."""

import json
from pathlib import Path
from typing import Annotated, Any, NamedTuple, get_args, get_type_hints

from pydantic import BeforeValidator

from ...study.move.mover import Task
from ...study.move.payload import Payload
from ...study.move.profiles import AngleProfile, Dwell, Part, SCurve, Trapezoid
from ..entries import Wrong, of_class, read_entry, refusal
from ..yaml_text import shown
from .profile_file import read_profile

PARTS = {"trapezoid": Trapezoid, "s_curve": SCurve, "dwell": Dwell}
NAMES = {cls: name for name, cls in PARTS.items()}
IN_FILE = "angle_profile"
EXAMPLE = "{type: trapezoid, angle: 90 deg, time: 0.6 s}"


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
