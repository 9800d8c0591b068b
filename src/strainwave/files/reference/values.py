"""JSON Schema of single values of a project file: quantities with units, plain numbers, words.

A schema knows the kind of a unit and the sign of a number. What takes arithmetic is checked when the file is read.
"""

from typing import Any

from ...units import example

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
