"""JSON Schema (draft 2020-12) of the project file, from the models that read it."""

from functools import partial
from types import UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from pydantic import BeforeValidator
from pydantic.fields import FieldInfo

from ...model.gears import catalogue
from .. import entries as readers
from .. import loop_fields, schema
from ..controller.fields import read_controller
from ..move.fields import read_part, read_payload
from ..schema import (
    CATALOGUE,
    DampingSpec,
    ExplicitGear,
    LoadSpec,
    NamedGear,
    ProjectSpec,
    Spec,
    SpeedSpec,
)
from .descriptions import FIELDS
from .entries import PLAIN_FILE, controller, definitions, described, written
from .values import Schema, array, group, quantity, whole

DIALECT = "https://json-schema.org/draft/2020-12/schema"
NAME = "strainwave.schema.json"

WORD: Schema = {"const": CATALOGUE}
READERS: dict[Any, Schema] = {  # of fields that a function reads
    schema._ratio: quantity("", "positive", minimum=1),
    schema._order: whole(1, 1000),
    schema._file_name: {"type": "string", "pattern": PLAIN_FILE},
    schema.read_title: {"type": "string", "maxLength": 200},
    schema._load_friction: {"anyOf": [WORD, quantity("", "not negative")], "x-unit": "1", "x-range": "from 0"},
    schema.read_accuracy: {"anyOf": [WORD, quantity("rad", "positive")], "x-unit": "rad", "x-range": "above 0"},
    readers.deviation: {"anyOf": [quantity("", "positive", maximum=readers.MOST_SCATTER), quantity("rad", "positive")]},
    schema._correlation: array(array(quantity(""))),
    readers.phase: quantity("rad"),
    readers.read_ripples: array({"$ref": "#/$defs/ripple"}, 1),
    loop_fields.read_loop: {"$ref": "#/$defs/loop"},
    read_part: {"$ref": "#/$defs/part"},
    read_payload: {"$ref": "#/$defs/payload"},
}


def _one_of(*ways: tuple[str, ...]) -> Schema:
    return {"oneOf": [{"required": list(way)} for way in ways]}


CONDITIONS: dict[type, Schema] = {  # between the fields of a group
    DampingSpec: _one_of(("B",), ("ratio",), ("quality",)),
    SpeedSpec: _one_of(("from", "to", "shaft"), ("at", "shaft")),
    LoadSpec: {"not": {"required": ["coupling", "couplings"]}},
    NamedGear: {"anyOf": [{"required": ["file"]}, {"required": ["law"]}]},
    ExplicitGear: {},
}


def project_schema() -> Schema:
    """JSON Schema (draft 2020-12) of a project file, with a description, the unit and the range of every field.

    Returns
    -------
    dict
        As `json.dumps` takes it. `x-unit` has the unit of a field in SI and `x-range` the range of its number.
    """
    return {
        "$schema": DIALECT,
        "$id": NAME,
        "title": "strainwave project file",
        "description": "A drive with a strain wave gear, its speeds and what excites it.",
        **_group(ProjectSpec, ""),
        "$defs": definitions(),
    }


def _group(cls: type[Spec], place: str) -> Schema:
    properties, required = {}, []
    for name, info in cls.model_fields.items():
        field = _alias(info) or name
        path = f"{place}.{field}".removeprefix(".")
        found = described(_value(info.annotation, info.metadata, path), FIELDS[path])
        if isinstance(info.default, str | float) and info.default != "":
            found["default"] = written(info.default, found)
        properties[field] = found
        if info.is_required():
            required.append(field)
    return group(properties, required, **CONDITIONS.get(cls, {}))


def _alias(info: FieldInfo) -> str | None:
    return info.alias or next((m.alias for m in info.metadata if isinstance(m, FieldInfo)), None)


def _value(hint: Any, metadata: Any, place: str) -> Schema:
    """Schema of a field by its annotation and by the function that reads it."""
    for one in metadata:
        if isinstance(one, BeforeValidator) and (read := _reader(one.func)) is not None:
            return read
    if get_origin(hint) is Annotated:
        return _value(get_args(hint)[0], [*get_args(hint)[1:], *metadata], place)
    if get_origin(hint) in (Union, UnionType):
        ways = [_value(way, [], place) for way in get_args(hint) if way is not type(None)]
        return ways[0] if len(ways) == 1 else _either(ways)
    if get_origin(hint) is Literal:
        return {"enum": list(get_args(hint))}
    if get_origin(hint) is list:
        return array(_value(get_args(hint)[0], [], place), *_lengths(metadata))
    if get_origin(hint) is dict:
        least, most = _lengths(metadata)
        items = _value(get_args(hint)[1], [], place)
        return {"type": "object", "additionalProperties": items, "minProperties": least, "maxProperties": most}
    return {"type": "string"} if hint is str else _group(hint, place)


def _either(ways: list[Schema]) -> Schema:
    kept: Schema = {key: way[key] for way in ways for key in ("x-unit", "x-range") if key in way}
    return {"anyOf": ways, **kept}


def _reader(function: Any) -> Schema | None:
    if isinstance(function, partial) and function.func is readers.number:
        return quantity(function.keywords["unit"], function.keywords["sign"])
    if isinstance(function, partial) and function.func is readers.read_entry:
        return {"$ref": "#/$defs/law"}
    if function is schema._known_gear:
        return {"enum": catalogue.names()}
    if function is read_controller:
        return controller()
    found = READERS.get(function)
    return None if found is None else dict(found)


def _lengths(metadata: Any) -> tuple[int | None, int | None]:
    inside = [one for m in metadata for one in (m.metadata if isinstance(m, FieldInfo) else [m])]
    least = next((m.min_length for m in inside if hasattr(m, "min_length")), None)
    return least, next((m.max_length for m in inside if hasattr(m, "max_length")), None)
