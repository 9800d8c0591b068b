"""Names of the numbers of a project file, as a sweep and a scatter use them, and where they stand in its content."""

import re
from contextlib import suppress
from functools import reduce
from typing import Any

from ...base.quantities import shown
from ...base.units import ARCSEC, NUMBER
from ...compile.tree import leaf_of, numbers
from ...drive.project import Project
from ...model.gears.gear import Gear
from ..fields.groups import CATALOGUE, ExcitationSpec
from ..fields.rows import inside, rows_of
from ..fields.schema import ExplicitGear, LoadSpec, MotorSpec, ProjectSpec
from ..yaml_text import read

Keys = tuple[str, ...]

WORDS = ("title", "revision", "name", "file")  # fields that are no number, whatever they begin with
GROUPS = {"motor": MotorSpec, "load": LoadSpec, "excitation": ExcitationSpec}  # whose names may be left out
LABELS = {  # of names, and of their parts
    "load.drag.amplitude": "load gravity torque", "excitation.accuracy": "accuracy, peak-to-peak",
    "damping.B": "damping B", "B": "damping B",
}  # fmt: skip


def keys_of(content: dict[str, Any], path: str) -> Keys:
    """Where a name of the file stands in its content (ValueError)."""
    keys = tuple(path.strip().split("."))
    groups = [group for group, spec in GROUPS.items() if keys[0] in rows_of(spec)]
    if keys[0] not in rows_of(ProjectSpec):
        if len(groups) > 1:
            said = " or ".join(f"{group}.{path}" for group in groups)
            raise ValueError(f"{path!r} is in several groups of the file; write {said}")
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
    found = [name for key, value in items for name in numbers_of(value, f"{before}.{key}" if before else str(key))]
    return found or ([before] if isinstance(content, str) and re.match(r"[-+.]?\d", content) else [])


def quantity(text: str) -> tuple[float | None, str]:
    """Number of a text and the unit after it; None of a word."""
    plain = " ".join(text.split())
    found = NUMBER.match(plain)
    return (float(found.group()), plain[found.end() :].strip()) if found else (None, "")


def nominal_of(content: dict[str, Any], gear: Gear | None, name: str) -> tuple[float, str]:
    """Number and unit that the content of a file has for a name (ValueError); of a catalogue gear's law in SI."""
    keys = keys_of(content, name)
    if gear is not None and keys[0] == "gear" and len(keys) == 2 and keys[1] in gear.law._fields:
        return float(getattr(gear.law, keys[1])), "N*m" if keys[1].startswith("T") else "N*m/rad"
    here = reduce(inside, keys, content)
    value, unit = quantity(here) if isinstance(here, str) else (None, "")
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


def known(content: dict[str, Any], gear: Gear | None, name: str) -> tuple[float, str] | None:
    """Number and unit of a name, of the file or of the record of its gear; None where there is none."""
    with suppress(ValueError):
        return of_record(content, gear).get(name) or nominal_of(content, gear, name)
    return None


SIGNALS = {"torsion": "x", "motor_angle": "reference", "load_torque": "load.excitation"}
OF_SIGNAL = {"gain": "", "offset": "rad", "delay": "s"}  # what may be free of a signal, with its unit
SINGLE = {"damping.B": "B", "load.inertia": "load.J", "load_friction": "friction.mu"}


class Places:
    """Names of a project's numbers, as its file, a sweep and a scatter have them, and their paths in the train."""

    def __init__(self, project: Project, train: Any) -> None:
        self.content: Any = read(project.text).content
        self.train = train
        beside = "law.first" if "hysteresis" in self.content else "law"
        gear = f"{beside}.law" if "backlash" in self.content else beside
        self.groups = {
            "gear": gear, "gear.law": gear, "hysteresis": "law.second", "backlash": beside, "load.drag": "load.drag",
            "excitation.kinematic_error": "error.lines",
        }  # fmt: skip

    def path(self, name: str) -> str:
        """Path in the train of a number of the file, or of a signal's gain, offset or delay (ValueError)."""
        signal, _, what = name.rpartition(".")
        if signal in SIGNALS and what in OF_SIGNAL:
            return f"{SIGNALS[signal]}.{what}"
        whole = ".".join(keys_of(self.content, name))
        group, _, field = whole.rpartition(".")
        while group and group not in self.groups:
            group, _, before = group.rpartition(".")
            field = f"{before}.{field}"
        path = "B" if whole.startswith("damping") else SINGLE.get(whole, f"{self.groups.get(group, '')}.{field}")
        try:
            leaf_of(self.train, path)
        except ValueError:
            raise ValueError(
                f"{shown(name)} is no number that the angles of motor and load tell; those are "
                f"{', '.join(self.names())}"
            ) from None
        return path

    def name(self, path: str) -> str:
        """Name in the file of a number of the train; empty where the file has none."""
        names = [name for name, single in SINGLE.items() if path == single]
        names += [n + path.removeprefix(group) for n, group in self.groups.items() if path.startswith(f"{group}.")]
        return next(iter(names), "").removeprefix("excitation.")  # which a name may leave out

    def names(self) -> list[str]:
        """Names of all numbers that may be free."""
        found = [self.name(path) for path, _, _, value in numbers(self.train) if isinstance(value, float)]
        return [name for name in found if name] + [f"torsion.{what}" for what in OF_SIGNAL]


def label_of(content: dict[str, Any], name: str) -> str:
    """A name as a person reads it: "kinematic error order 2 amplitude"."""
    if name in LABELS:
        return LABELS[name]
    here: Any = content
    words: list[str] = []
    for key in name.split("."):
        listed, here = isinstance(here, list), inside(here, key)
        order = here.get("order") if isinstance(here, dict) else None
        if isinstance(order, dict):  # repeats per turn of motor and output
            order = f"({order.get('wave_generator', 0)}, {order['output']})"
        plain = LABELS.get(key, key if key[:1].isupper() else key.replace("_", " "))
        words.append(plain if not listed else f"order {order}" if order else str(int(key) + 1))
    return " ".join(word for word in words if word not in ("excitation", "lines"))
