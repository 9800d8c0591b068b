"""Names of the numbers of a project file, as a sweep and a scatter use them, and their keys in its content."""

import re
from contextlib import suppress
from functools import reduce
from typing import Any

from ...base.quantities import shown
from ...base.units import ARCSEC, NUMBER
from ...model.gears.gear import Gear
from ..fields.groups import CATALOGUE, ExcitationSpec
from ..fields.rows import inside, rows_of
from ..fields.schema import ExplicitGear, LoadSpec, MotorSpec, ProjectSpec

Keys = tuple[str, ...]

WORDS = ("title", "revision", "name", "file")  # fields that are no number, whatever they begin with
GROUPS = {"motor": MotorSpec, "load": LoadSpec, "excitation": ExcitationSpec}  # whose names may be left out
LABELS = {  # of names, and of their parts
    "load.drag.amplitude": "load gravity torque", "excitation.accuracy": "accuracy, peak-to-peak",
    "damping.B": "damping B", "B": "damping B",
}  # fmt: skip


def keys_of(content: dict[str, Any], path: str) -> Keys:
    """Keys of a name of the file in its content (ValueError)."""
    keys = tuple(path.strip().split("."))
    groups = [group for group, spec in GROUPS.items() if keys[0] in rows_of(spec)]
    if keys[0] not in rows_of(ProjectSpec):
        if len(groups) > 1:
            choices = " or ".join(f"{group}.{path}" for group in groups)
            raise ValueError(f"{path!r} is in several groups of the file; write {choices}")
        if not groups:
            raise ValueError(f"the project file has no {shown(path)}; its numbers are {', '.join(numbers_of(content))}")
        keys = (groups[0], *keys)
    gear = content.get("gear")
    if keys[0] == "gear" and len(keys) == 2 and isinstance(gear, dict) and keys[1] not in rows_of(ExplicitGear):
        keys = ("gear", "law", keys[1]) if "law" in gear else keys
    return ("speed", "at") if keys == ("speed",) else keys


def numbers_of(content: object, before: str = "") -> list[str]:
    """Names of the numbers that a file gives, by their paths."""
    if before.rpartition(".")[2] in WORDS:
        return []
    items = content.items() if isinstance(content, dict) else enumerate(content) if isinstance(content, list) else ()
    names = [name for key, value in items for name in numbers_of(value, f"{before}.{key}" if before else str(key))]
    return names or ([before] if isinstance(content, str) and re.match(r"[-+.]?\d", content) else [])


def quantity(text: str) -> tuple[float | None, str]:
    """Number of a text and the unit after it; None of a word."""
    plain = " ".join(text.split())
    match = NUMBER.match(plain)
    return (float(match.group()), plain[match.end() :].strip()) if match else (None, "")


def nominal_of(content: dict[str, Any], gear: Gear | None, name: str) -> tuple[float, str]:
    """Number and unit that the content of a file has for a name (ValueError); of a catalogue gear's law in SI."""
    keys = keys_of(content, name)
    if gear is not None and keys[0] == "gear" and len(keys) == 2 and keys[1] in gear.law._fields:
        return float(getattr(gear.law, keys[1])), "N*m" if keys[1].startswith("T") else "N*m/rad"
    entry = reduce(inside, keys, content)
    value, unit = quantity(entry) if isinstance(entry, str) else (None, "")
    if value is None:
        beside = numbers_of(reduce(inside, keys[:-1], content), ".".join(keys[:-1])) if len(keys) > 1 else []
        remedy = "; write the number it scatters about, too"
        if beside:
            remedy = f", which gives {', '.join(beside)}; let that scatter, or write {name} in the file"
        raise ValueError(f"{name} is no number of this file{remedy}")
    return value, unit


def of_record(content: dict[str, Any], gear: Gear | None) -> dict[str, tuple[float, str]]:
    """Numbers with their units that a file leaves to the record of its gear."""
    inertia, accuracy = (None, None) if gear is None else (gear.input_inertia, gear.accuracy)
    record = {}
    if inertia and inside(content.get("motor"), "inertia") is None:
        record["motor.inertia"] = 1e4 * inertia, "kg*cm^2"
    if accuracy and inside(content.get("excitation"), "accuracy") == CATALOGUE:
        record["excitation.accuracy"] = accuracy / ARCSEC, "arcsec"
    return record


def number_of(content: dict[str, Any], gear: Gear | None, name: str) -> tuple[float, str] | None:
    """Number and unit of a name, of the file or of the record of its gear; None where there is none."""
    with suppress(ValueError):
        return of_record(content, gear).get(name) or nominal_of(content, gear, name)
    return None


def label_of(content: dict[str, Any], name: str) -> str:
    """A name as a person reads it: "kinematic error order 2 amplitude"."""
    if name in LABELS:
        return LABELS[name]
    entry: Any = content
    words: list[str] = []
    for key in name.split("."):
        listed, entry = isinstance(entry, list), inside(entry, key)
        order = entry.get("order") if isinstance(entry, dict) else None
        if isinstance(order, dict):  # repeats per turn of motor and output
            order = f"({order.get('wave_generator', 0)}, {order['output']})"
        plain = LABELS.get(key, key if key[:1].isupper() else key.replace("_", " "))
        words.append(plain if not listed else f"order {order}" if order else str(int(key) + 1))
    return " ".join(word for word in words if word not in ("excitation", "lines"))
