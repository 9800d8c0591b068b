"""The sliders of a project: what its file gives and what it may give, with units, ranges and help.

Names, units and signs are those of the fields of the project file and of the models' own classes.
"""

from functools import partial
from typing import Any, get_args

from pydantic import BaseModel

from ...drive.project import Project
from ...files.entries import fields_of, law_types, loop_types
from ...files.entries import number as read_number
from ...files.loop_fields import READERS
from ...files.schema import ProjectSpec
from ...files.variants.names import nominal_of, numbers_of, quantity
from ...files.variants.replaced import OF_RECORD
from ...files.yaml_text import read
from ..view import sign
from .state import State, project_of

SPAN = 10.0  # a slider goes from a tenth of the value to ten times it
HELP = {
    "load.inertia": "Inertia of the load on the output side, with all that turns with it.",
    "motor.inertia": "Inertia on the motor side: rotor, brake and wave generator.",
    "damping.ratio": "Damping ratio of the torsion at rest; 1 to 5 % is usual.",
    "damping.B": "Damping across the gear, on the output side.",
    "speed.from": "Begin of the range of speeds.",
    "speed.to": "End of the range of speeds.",
    "excitation.load_torque.mean": "Mean torque on the load; a resisting one is negative.",
    "load.drag.amplitude": "Largest torque of gravity or an imbalance over a turn of the load.",
    "load_friction": "Friction of the meshing, as a share of the transmitted torque.",
    "limit.oscillation": "Largest oscillation of the pointing error that is allowed, 0-to-peak.",
    "backlash.half_gap": "Half of the gap between the flanks, at the output.",
    "gear.K1": "Stiffness up to the torque T1.",
    "gear.K2": "Stiffness from T1 to T2.",
    "gear.K3": "Stiffness beyond T2.",
    "gear.T1": "Torque at which the stiffness goes from K1 to K2.",
    "gear.T2": "Torque at which the stiffness goes from K2 to K3.",
    "motor.loop.bandwidth": "Bandwidth of the motor's loop.",
    "amplitude": "Amplitude of this line, 0-to-peak, on the output side.",
    "phase": "Phase of this line.",
    "order": "Periods of this line in one turn of the motor.",
}
MORE = {"excitation.load_torque.mean": "0 N*m"}  # what a slider may add to a file
LABELS = {"load.drag.amplitude": "load gravity torque"}
WORDS = {"B": "damping B", "to": "to", "from": "from", "mean": "mean"}


def about(state: State) -> dict[str, Any]:
    """Title, numbers with their ranges, parts that may be added, notes and speeds of a project."""
    now, given = project_of(state), State(gear=state.gear, project=state.project)
    parts = _parts(project_of(given))
    present = [part for part in parts.values() if not state.values.keys().isdisjoint(part)]
    added = {name: value for part in present for name, value in part.items()}
    base = project_of(given.model_copy(update={"values": added}))
    low, high = (now.speeds.scale * omega for omega in now.speeds.limits)
    speed = {"low": low, "high": high, "unit": now.speeds.unit, "name": now.speeds.name}
    return {
        "title": now.title,
        "parameters": [{**one, "added": one["name"] in added} for one in parameters(base)],
        "parts": [{"name": name, "values": part, "present": part in present} for name, part in parts.items()],
        "notes": now.notes,
        "speed": speed,
    }


def _parts(project: Project) -> dict[str, dict[str, str]]:
    """What a page may add to a project that has none of it, with first values."""
    content = read(project.text).content
    torque = 0.25 * project.rated_torque if project.rated_torque else 10.0
    parts = {
        "motor loop": {"motor.loop.bandwidth": "30 Hz", "motor.loop.damping": "0.7"},
        "gravity": {
            "load.drag.type": "angle_torque",
            "load.drag.amplitude": f"{torque:.2g} N*m",
            "load.drag.order": "1",
        },
        "limit": {"limit.oscillation": "120 arcsec"},
    }
    if project.speeds.shaft == "forcing":
        del parts["motor loop"], parts["gravity"]
    elif _inside(content.get("motor"), "mode") == "free":
        del parts["motor loop"]
    places = {name: next(iter(part)).split(".")[:2] for name, part in parts.items()}
    return {
        name: part for name, part in parts.items() if _inside(content.get(places[name][0]), places[name][1]) is None
    }


def parameters(project: Project) -> list[dict[str, Any]]:
    """Describe every number of a project that may be changed, in the order of its file."""
    content = read(project.text).content
    names = [name for name in numbers_of(content) if not name.endswith((".order", ".type"))]
    if project.mean_range is None:
        names += [name for name in MORE if name not in names]
    if project.gear is not None and isinstance(content.get("gear"), str):
        names += [f"gear.{name}" for name in OF_RECORD if name in project.gear.law._fields]
    found = (_described(project, content, name) for name in names)
    return [one for one in found if one is not None]


def _described(project: Project, content: dict[str, Any], name: str) -> dict[str, Any] | None:
    """One number with its unit, as the file writes it, and its range; None of what is no plain quantity."""
    value: float | None
    try:
        value, unit = nominal_of(content, project.gear, name)
    except ValueError:
        value, unit = quantity(MORE[name]) if name in MORE else (None, "")
    if value is None:
        return None
    if name.startswith("gear.") and project.gear is not None and name[5:] in OF_RECORD:
        value = float(getattr(_law_numbers(project), name[5:], value))
    si, sign_of = unit_of(content, name)
    low, high, log = _range(value, unit, sign_of)
    last = name.rpartition(".")[2]
    return {
        "name": name,
        "label": LABELS.get(name) or _label(content, name),
        "group": name.partition(".")[0],
        "value": value,
        "unit": unit,
        "shown_unit": sign(unit.replace("^", "**")),
        "si_unit": si,
        "sign": sign_of,
        "low": low,
        "high": high,
        "log": log,
        "help": HELP.get(name, HELP.get(last, "")),
    }


def _law_numbers(project: Project) -> Any:
    """The three slopes that the drive has now: those of the record, or changed ones."""
    found = [project.drive.law]
    while found:
        law = found.pop()
        if hasattr(law, "K1"):
            return law
        found += [part for part in law if isinstance(part, tuple) and hasattr(part, "_fields")]
    return None if project.gear is None else project.gear.law


def _range(value: float, unit: str, sign_of: str) -> tuple[float, float, bool]:
    if sign_of == "any" and (unit or value <= 0.0):
        reach = 2.0 * abs(value) or (100.0 if "N" in unit else 360.0 if unit == "deg" else 1.0)
        return -reach, reach, False
    if value <= 0.0:
        return 0.0, 1.0, False
    return value / SPAN, value * SPAN, True


def _label(content: dict[str, Any], name: str) -> str:
    """A name as a person reads it: "kinematic error, order 2: amplitude"."""
    here: Any = content
    words: list[str] = []
    for key in name.split("."):
        if isinstance(here, list):
            here = here[int(key)] if key.isdecimal() and int(key) < len(here) else None
            order = here.get("order") if isinstance(here, dict) else None
            words.append(f"order {order}" if order else str(int(key) + 1))
            continue
        here = here.get(key) if isinstance(here, dict) else None
        words.append(WORDS.get(key, key if key[:1].isupper() else key.replace("_", " ")))
    return " ".join(word for word in words if word not in ("excitation", "lines"))


def unit_of(content: dict[str, Any], name: str) -> tuple[str, str]:
    """Unit in SI of a number of the file, and its sign: "any", "positive" or "not negative"."""
    keys = name.split(".")
    if keys[0] == "gear" and keys[-1] in OF_RECORD and not isinstance(content.get("gear"), dict):
        return OF_RECORD[keys[-1]], "positive"
    spec: Any = ProjectSpec
    for key in keys:
        if isinstance(spec, type) and issubclass(spec, BaseModel) and not key.isdecimal():
            info = _field(spec, key)
            if info is None:
                return "", "any"
            found = _reader(info.metadata) or _reader(get_args(info.annotation))
            if found is not None:
                return found
            spec = _spec_in(info.annotation)
    return _of_class(content, keys)


def _inside(here: Any, key: str) -> Any:
    if isinstance(here, list):
        return here[int(key)] if key.isdecimal() and int(key) < len(here) else None
    return here.get(key) if isinstance(here, dict) else None


def _field(spec: type[BaseModel], key: str) -> Any:
    by_alias = {info.alias: info for info in spec.model_fields.values() if info.alias}
    return spec.model_fields.get(key) or by_alias.get(key)


def _reader(metadata: Any) -> tuple[str, str] | None:
    """Unit and sign of what reads a field, at any depth of its annotation."""
    for item in metadata or ():
        function = getattr(item, "func", None)
        if isinstance(function, partial) and function.func is read_number:
            return str(function.keywords["unit"]), str(function.keywords["sign"])
        if not isinstance(item, type) and (found := _reader([*getattr(item, "__metadata__", ()), *get_args(item)])):
            return found
    return None


def _spec_in(annotation: Any) -> Any:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return annotation
    return next((spec for part in get_args(annotation) if (spec := _spec_in(part)) is not None), None)


def _of_class(content: dict[str, Any], keys: list[str]) -> tuple[str, str]:
    """Unit of a field of a model's class that the file gives by its `type`."""
    here: Any = content
    cls: type | None = None
    for key in keys[:-1]:
        here = _inside(here, key)
        kind = here.get("type") if isinstance(here, dict) else None
        cls = (law_types() | loop_types()).get(str(kind), cls)
    hint = None if cls is None else fields_of(cls).get(keys[-1])
    unit = next((part for part in get_args(hint) if isinstance(part, str)), "")
    tuning = keys[:2] == ["motor", "loop"] and keys[-1] in READERS
    return unit, "positive" if tuning or unit in ("N*m/rad", "kg*m**2") else "any"
