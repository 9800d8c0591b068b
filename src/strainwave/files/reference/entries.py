"""JSON Schema of the entries whose fields are those of a class of the model: laws, loops, parts of a profile."""

from functools import partial
from typing import Any, get_args, get_origin

from ...model.varying import Ripple
from ...study.move.payload import Payload
from ..controller.fields import MOST_BITS
from ..entries import NOT_NEGATIVE, POSITIVE, SPRINGS, fields_of, law_types, loop_types
from ..move.fields import IN_FILE, PARTS
from ..python_law import NAMED
from .descriptions import ENTRIES, FIELDS
from .values import Schema, array, group, quantity, whole

BITS = {"type": "string", "pattern": "^\\s*[0-9]{1,2}[ -]?bits?\\s*$", "examples": ["16 bit"]}
PLAIN_FILE = "^[^/\\\\:.][^/\\\\:]*$"


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
    for schema, name in zip(by_gains, loop_types(), strict=True):
        schema["properties"]["type"] = {
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
