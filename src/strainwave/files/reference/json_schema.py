"""JSON Schema (draft 2020-12) of the project file, from the models that read it.

JSON Schema of the entries whose fields are those of a class of the model: laws, loops, parts of a profile. JSON Schema
of single values of a project file: quantities with units, plain numbers, words.
"""

from functools import partial
from types import UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from pydantic import BeforeValidator
from pydantic.fields import FieldInfo

from ...base.units import example
from ...drive.asked import Payload
from ...model.gears import catalogue
from ...model.varying import Ripple
from .. import entries as readers
from .. import loop_fields, schema
from ..controller import MOST_BITS, read_controller
from ..entries import NOT_NEGATIVE, POSITIVE, SPRINGS, fields_of, law_types, loop_types
from ..move_fields import IN_FILE, PARTS, read_part, read_payload
from ..python_law import NAMED
from ..schema import CATALOGUE, DampingSpec, ExplicitGear, LoadSpec, NamedGear, ProjectSpec, Spec, SpeedSpec
from .descriptions import ENTRIES, FIELDS

BITS = {"type": "string", "pattern": "^\\s*[0-9]{1,2}[ -]?bits?\\s*$", "examples": ["16 bit"]}
PLAIN_FILE = "^[^/\\\\:.][^/\\\\:]*$"

Schema = dict[str, Any]

ANGLE = "(rad|deg|°|arc|rev|turn|[\"'′″])"
HINTS = {  # what the spelling of a unit holds
    "rad": ANGLE + "[^/]*$",
    "rad/s": f"({ANGLE}|rpm)",
    "N*m": "(N|lb|oz|gf)",
    "kg*m**2": "(g|lb|oz)",
    "s": "(s|min|h)",
    "Hz": "(Hz|rad)",
    "K": "K",
}
SIGNS = {"any": "[+\\-−]?", "positive": "\\+?(?=[^A-Za-z]*[1-9])", "not negative": "\\+?"}
LOW: dict[str, Schema] = {"any": {}, "positive": {"exclusiveMinimum": 0}, "not negative": {"minimum": 0}}


def quantity(unit: str, sign: str = "any", **more: Any) -> Schema:
    """Text of a number and its unit, or a plain number where the unit is "".

    Parameters
    ----------
    unit : str
        Unit in the package's spelling.
    sign : str
        "any", "positive" or "not negative".
    """
    start = f"^\\s*{SIGNS[sign]}[0-9.]"
    if not unit:
        plain = {"type": "number", **LOW[sign], **more}
        text = {"type": "string", "pattern": start + "[^A-Za-z]*([eE]|%|percent)?[^A-Za-z]*$"}
        return {"anyOf": [plain, text], "x-unit": "1", "x-range": _range(sign, more)}
    ending = HINTS.get(unit, "[A-Za-z°/]")
    return {
        "type": "string",
        "pattern": f"{start}.*{ending}",
        "examples": [example(unit).removeprefix("for example ").split(" or ")[0]],
        "x-unit": unit.replace("**", "^"),
        "x-range": _range(sign, more),
    }


def whole(low: int | None = None, high: int | None = None) -> Schema:
    """A whole number between two ends."""
    ends = {"minimum": low, "maximum": high}
    given = {name: end for name, end in ends.items() if end is not None}
    return {"type": "integer", **given, "x-unit": "1", "x-range": _range("any", given)}


def array(items: Schema, least: int | None = None, most: int | None = None) -> Schema:
    """A list."""
    ends = {"minItems": least, "maxItems": most}
    return {"type": "array", "items": items, **{name: end for name, end in ends.items() if end is not None}}


def group(properties: dict[str, Schema], required: list[str], **more: Any) -> Schema:
    """A group of named fields; others are refused."""
    fields = {"type": "object", "properties": properties, "additionalProperties": False}
    return fields | ({"required": required} if required else {}) | more


def _range(sign: str, ends: dict[str, Any]) -> str:
    low = ends.get("minimum", {"positive": "above 0", "not negative": "from 0"}.get(sign, ""))
    low = f"from {low}" if isinstance(low, int | float) else low
    return f"{low} to {ends['maximum']}".strip() if "maximum" in ends else low


def described(schema: Schema, sentence: str) -> Schema:
    """The schema with a description, which names the unit and the range."""
    said = [schema.get("x-unit", ""), schema.get("x-range", "")]
    unit = f" [{said[0]}]" if said[0] not in ("", "1") else ""
    return {"description": f"{sentence.removesuffix('.')}{unit}{', ' + said[1] if said[1] else ''}.", **schema}


def definitions() -> dict[str, Schema]:
    """Entries that stand in more than one place, by name."""
    laws = {name: entry(cls, name) for name, cls in law_types().items()}
    own = {"python": {"type": "string", "pattern": f"^{NAMED.pattern}$", "description": "Law of a Python file."}}
    return {
        **{f"law_{name}": schema for name, schema in laws.items()},
        "law": {
            "anyOf": [
                *({"$ref": f"#/$defs/law_{name}"} for name in laws),
                {"type": "object", "properties": own, "required": ["python"]},
                {"type": "string", "pattern": f"^{NAMED.pattern}$"},
            ]
        },
        "ripple": entry(Ripple),
        "payload": entry(Payload),
        "loop": loop(),
        "part": {"oneOf": [*(entry(cls, name) for name, cls in PARTS.items()), _in_file()]},
    }


def entry(cls: Any, name: str = "", also: Schema | None = None) -> Schema:
    """Group of the fields of a class, with its `type` where it has a name."""
    properties: dict[str, Schema] = {"type": {"const": name, "description": ENTRIES["type"]}} if name else {}
    for field, hint in fields_of(cls).items():
        sentence = ENTRIES.get(f"{cls.__name__}.{field}") or ENTRIES[field]
        properties[field] = described(_of_hint(hint, cls, field), sentence)
        if field in cls._field_defaults:
            properties[field]["default"] = written(cls._field_defaults[field], properties[field])
    needed = [field for field in fields_of(cls) if field not in cls._field_defaults]
    said = " ".join((cls.__doc__ or "").split("\n")[0].split())
    return group({**properties, **(also or {})}, ["type"] * bool(name) + needed, description=said)


def written(value: Any, schema: Schema) -> Any:
    """A default as the file would hold it."""
    unit = schema.get("x-unit", "1")
    return value if unit == "1" else f"{value:g} {unit}"


def _of_hint(hint: Any, cls: Any, field: str) -> Schema:
    if hint is Any:
        return {"$ref": "#/$defs/law"}
    if hint == "points":
        pair = {"type": "array", "prefixItems": [quantity("rad"), quantity("N*m")], "minItems": 2, "maxItems": 2}
        return array(pair, 2)
    if get_origin(hint) is tuple:
        return array({"type": "string", "pattern": "^\\s*[+\\-−]?[0-9.].*[Nl]"}, 2, 16)
    if hint is int:
        return whole(1) if field in ("n", "order") else whole()
    unit, spring = get_args(hint)[1], cls.__module__ in SPRINGS
    sign = "positive" if unit in POSITIVE else "not negative" if unit in NOT_NEGATIVE else "any"
    return quantity(unit, sign if spring else "any")


def loop() -> Schema:
    """A loop of the motor, by bandwidth or by gains."""
    field = partial(_field, "motor.loop")
    lag = {"lag": field("lag", quantity("s", "positive"))}
    tuned = {
        "type": {"enum": ["position", "speed"], "default": "position", "description": ENTRIES["type"]},
        "bandwidth": field("bandwidth", quantity("Hz", "positive")),
        "damping": field("damping", quantity("", "positive")) | {"default": 0.7},
        **lag,
    }
    by_gains = [entry(cls, name, lag) for name, cls in loop_types().items()]
    for fields, name in zip(by_gains, loop_types(), strict=True):
        fields["properties"]["type"] = {
            "enum": [name, name.removesuffix("_loop")], "description": ENTRIES["type"]
        }  # fmt: skip
    return {"anyOf": [group(tuned, ["bandwidth"], description="A loop by its bandwidth."), *by_gains]}


def controller() -> Schema:
    """Samples and encoders of the drive's own controller."""
    field = partial(_field, "controller")

    def encoder(place: str) -> Schema:
        steps = _field(f"controller.{place}", "steps", whole(2, 2**MOST_BITS))
        noise = _field(f"controller.{place}", "noise", quantity("rad", "not negative"))
        return {"anyOf": [BITS, group({"steps": steps, "noise": noise}, [], minProperties=1)]}

    of_load = encoder("load_encoder")
    of_load["anyOf"].append({"const": "none"})
    properties = {
        "period": field("period", quantity("s", "positive")) | {"default": "250 us"},
        "delay": field("delay", quantity("s", "not negative")),
        "motor_encoder": field("motor_encoder", encoder("motor_encoder")) | {"default": "16 bit"},
        "load_encoder": field("load_encoder", of_load) | {"default": "none"},
        "loss": field("loss", quantity("", "not negative")) | {"default": 0},
    }
    return group(properties, [])


def _field(place: str, name: str, schema: Schema) -> Schema:
    return described(schema, FIELDS[f"{place}.{name}"])


def _in_file() -> Schema:
    file = described({"type": "string", "pattern": PLAIN_FILE}, ENTRIES["file"])
    kind = {"const": IN_FILE, "description": ENTRIES["type"]}
    return group({"type": kind, "file": file}, ["type", "file"], description="Angles over the time from a file.")


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
