"""The reference of the project file as Markdown, from its JSON Schema."""

import re
from collections.abc import Iterator
from typing import Any

from .json_schema import Schema, project_schema

HEAD = """# Fields of the project file

`strainwave schema --markdown` writes this page from the models that read a project file; [](project-file.md) explains
them. A unit stands for every unit of its kind, a unit of 1 for a plain number or %.
"""
COLUMNS = "| field | what | unit or values | range | without it |\n|---|---|---|---|---|\n"
PLACES = {"ripple": "Of `damping.ripples` and `stiffness.ripples`.", "payload": "Of `move.payload`."}


def reference() -> str:
    """The page with every table and field: unit, values, range, and what holds without it."""
    whole = project_schema()
    defs, fields = whole["$defs"], whole["properties"]
    top = [_row(name, item, whole["required"]) for name, item in fields.items()]
    parts = [HEAD, f"## Top level\n\n{COLUMNS}" + "".join(top)]
    for name, item in fields.items():
        for i, group in enumerate(_groups(item)):
            by = ("", " by its law", " by its record")[i + 1 if name == "gear" else 0]
            parts.append(_table(f"`{name}`{by}", item["description"], group, name))
    parts += [_table(f"`{name}`", place, defs[name]) for name, place in PLACES.items()]
    for place, ways in (("motor.loop", defs["loop"]["anyOf"]), ("move.profile", defs["part"]["oneOf"])):
        for way in ways:
            kind = way["properties"]["type"]
            word = kind.get("const") or ("bandwidth" if "bandwidth" in way["properties"] else kind["enum"][0])
            parts.append(_table(f"`{place}`: {word.replace('_', ' ')}", way["description"], way))
    laws = {name.removeprefix("law_"): law for name, law in defs.items() if name.startswith("law_")}
    parts += [_table(f"Law `{name}`", law["description"], law) for name, law in laws.items()]
    return "\n".join(parts)


def _table(title: str, text: str, group: Schema, place: str = "") -> str:
    said = f"{text if text.startswith('Of `') else _plain(text)}\n\n" if text else ""
    return f"## {title}\n\n{said}{COLUMNS}" + "".join(_rows(group, place))


def _groups(item: Schema) -> list[Schema]:
    """Groups of fields that a value may be."""
    ways = item.get("anyOf", [item])
    return [way for way in ways if "properties" in way]


def _rows(group: Schema, place: str) -> Iterator[str]:
    for name, item in group["properties"].items():
        path = f"{place}.{name}".removeprefix(".")
        yield _row(path, item, [f"{place}.{field}".removeprefix(".") for field in group.get("required", [])])
        for inner in (*_groups(item), *_groups(item.get("items", {}))):
            yield from _rows(inner, path)


def _row(path: str, item: Schema, required: list[str]) -> str:
    without = "refused" if path in required else str(item.get("default", ""))
    cells = (f"`{path}`", _plain(_what(item)), _kind(item), _extent(item), without)
    return "| " + " | ".join(cells) + " |\n"


def _what(item: Schema) -> str:
    """The description without the unit and the range, which have columns."""
    text = item["description"].removesuffix(".")
    if item.get("x-range"):
        text = text.removesuffix(f", {item['x-range']}")
    return re.sub(r" \[[^\]]*\]$", "", text) + "."


def _kind(item: Schema) -> str:
    if "x-unit" in item:
        word = ", `catalogue`" if {"const": "catalogue"} in item.get("anyOf", []) else ""
        return f"{item['x-unit']}{word}"
    if "const" in item:
        return f"`{item['const']}`"
    if "enum" in item:
        return ", ".join(f"`{word}`" for word in item["enum"])
    if "$ref" in item:
        return str(item["$ref"]).rsplit("/", 1)[1]
    if item.get("type") == "array":
        if "prefixItems" in item:
            return f"pair of {' and '.join(map(_kind, item['prefixItems']))}"
        return f"list of {_kind(item['items'])}"
    if "anyOf" in item and "properties" not in item:
        return ", ".join(
            sorted({"name" if "enum" in way and len(way["enum"]) > 9 else _kind(way) for way in item["anyOf"]})
        )
    return {"object": "group", "string": "text"}.get(item.get("type", ""), "")


def _extent(item: Schema) -> str:
    lengths = [item.get(f"{end}{what}") for what in ("Items", "Properties") for end in ("min", "max")]
    least, most = (lengths[0] or lengths[2], lengths[1] or lengths[3])
    if most:
        return f"{least or 0} to {most} items"
    if least:
        return f"{least} or more items"
    return f"{item['maxLength']} letters" if "maxLength" in item else str(item.get("x-range", ""))


def _plain(text: Any) -> str:
    return str(text).replace("|", "\\|").replace("*", "\\*").replace("_", "\\_").replace("<", "\\<")
