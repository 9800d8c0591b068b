"""Sliders of a project: numbers that its file has or may have, with units, ranges and help.

Names, units and signs are those of the fields of the project file and of the models' own classes.
"""

from functools import reduce
from typing import Any

from ...base.number_text import unit_text
from ...drive.project import Project
from ...files.fields.kinds import Entry, Row
from ...files.fields.kinds import read as read_kind
from ...files.fields.rows import inside, row_at
from ...files.fields.schema import ProjectSpec
from ...files.variants.names import keys_of, label_of, number_of, numbers_of, of_record, quantity
from ...files.variants.replaced import OF_RECORD, slopes
from ...files.yaml_text import read
from .first_project import parts_of
from .requests import State
from .state import project_of

SMALL = 1e-3  # in any unit a number that a field takes which is zero now
SPAN = 10.0  # a slider goes from a tenth of the value to ten times it
POSITIVE = ("N*m/rad", "kg*m**2")  # units of numbers that a slider keeps above zero
UNSIGNED = ("hysteresis.", "motor.loop.")  # groups of numbers of any sign in the file that are hardly below zero
MORE = {"excitation.load_torque.mean": "0 N*m"}  # what a slider may add to a file


def about(state: State) -> dict[str, Any]:
    """Title, numbers with their ranges, parts that may be added, notes and speeds of a project.

    Refused values of a number are given with it, and the rest is that of the project without them.
    """
    original = State(gear=state.gear, project=state.project)
    parts = parts_of(project_of(original))
    present = [part for part in parts.values() if not state.values.keys().isdisjoint(part)]
    added = {name: value for part in present for name, value in part.items()}
    base = project_of(original.model_copy(update={"values": added}))
    content = read(base.text).content
    wrong = {name: sentence for name, text in state.values.items() if (sentence := _refusal(content, name, text))}
    values = {name: text for name, text in state.values.items() if name not in wrong}
    try:
        project = project_of(state.model_copy(update={"values": values}))
    except ValueError:  # values that do not go together: the view of them says why
        project = base
    scale, (low, high) = project.speeds.scale, project.speeds.limits
    speed = {"low": scale * low, "high": scale * high, "unit": project.speeds.unit, "name": project.speeds.name}
    rows = parameters(base)
    for row in rows:
        name = row["name"]
        shown = _in_unit(content, name, values[name], row["value"], row["unit"]) if name in values else row["value"]
        row |= {"added": name in added, "now": None if name in wrong else shown, "wrong": wrong.pop(name, "")}
    return {
        "title": project.title,
        "parameters": rows,
        "sources": {one.name: one.word for one in base.sources},
        "parts": [{"name": name, "values": part, "present": part in present} for name, part in parts.items()],
        "notes": project.notes,
        "digits": project.digits(),
        "speed": speed,
        "unknown": wrong,
    }


def _refusal(content: dict[str, Any], name: str, text: str) -> str:
    """Reason why a number of a file may not have this text; empty where it may. Sources are read with the numbers."""
    if name.startswith("sources."):
        return ""
    entry = Entry((), [])
    try:
        keys = keys_of(content, name)
    except ValueError as error:
        return str(error)
    row = row_of(content, ".".join(keys))
    if row is None:
        return "" if reduce(inside, keys, content) else f"the project has no {name!r}"
    read_kind(row.kind, text, entry)
    return entry.faults[0].sentence if entry.faults else ""


def _in_unit(content: dict[str, Any], name: str, text: str, before: float, unit: str) -> float | None:
    """Number of a text in the unit of the number that the file has; a field takes both."""
    value, typed = quantity(text)
    row = row_of(content, name)
    if typed == unit or row is None or value is None:
        return value
    size = before or SMALL
    return size * float(row.kind.read(text, Entry((), [])) / row.kind.read(f"{size!r} {unit}".strip(), Entry((), [])))


def parameters(project: Project) -> list[dict[str, Any]]:
    """Describe every number of a project that may be changed, those of the load first."""
    content = read(project.text).content
    names = [name for name in numbers_of(content) if not name.endswith((".order", ".type")) and ".order." not in name]
    if project.mean_range is None:
        names += [name for name in MORE if name not in names]
    if project.gear is not None and isinstance(content.get("gear"), str):
        names += [f"gear.{name}" for name in OF_RECORD if name in project.gear.law._fields]
    names += of_record(content, project.gear)
    rows = (_described(project, content, name) for name in names)
    return sorted((one for one in rows if one is not None), key=lambda one: str(one["group"]) != "load")


def _described(project: Project, content: dict[str, Any], name: str) -> dict[str, Any] | None:
    """One number with its unit, as the file writes it, and its range; None where it is no plain quantity."""
    value, unit = number_of(content, project.gear, name) or quantity(MORE.get(name, ""))
    if value is None:
        return None
    if name.startswith("gear.") and project.gear is not None and name[5:] in OF_RECORD:
        value = float(getattr(slopes(project), name[5:], value))
    elif name == "excitation.accuracy":
        value = float(f"{value:.3g}")  # catalogues print no more digits of it
    si, sign_of = unit_of(content, name)
    low, high, log = _range(value, unit, sign_of)
    row = row_of(content, name)
    return {
        "name": name,
        "label": label_of(content, name),
        "group": name.partition(".")[0],
        "value": value,
        "unit": unit,
        "shown_unit": unit_text(unit.replace("^", "**")),
        "si_unit": si,
        "sign": sign_of,
        "low": low,
        "high": high,
        "log": log,
        "help": row.description if row else "",
    }


def _range(value: float, unit: str, sign_of: str) -> tuple[float, float, bool]:
    if sign_of == "any" and (unit or value <= 0.0):
        reach = 2.0 * abs(value) or (100.0 if "N" in unit else 360.0 if unit == "deg" else 1.0)
        return -reach, reach, False
    if value <= 0.0:
        return 0.0, 1.0, False
    return value / SPAN, value * SPAN, True


def unit_of(content: dict[str, Any], name: str) -> tuple[str, str]:
    """Unit in SI of a number of the file, and its sign: "any", "positive" or "not negative"."""
    row = row_of(content, name)
    if row is None:
        return "", "any"
    return row.kind.unit, "positive" if row.kind.unit in POSITIVE or name.startswith(UNSIGNED) else row.kind.sign


def row_of(content: dict[str, Any], name: str) -> Row | None:
    """Row of a number of the file, or of the record of its gear."""
    last = name.rpartition(".")[2]
    if name.startswith("gear.") and last in OF_RECORD and not isinstance(content.get("gear"), dict):
        return OF_RECORD[last]
    return row_at(ProjectSpec, content, name.split("."))
