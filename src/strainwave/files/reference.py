"""The reference page of a project file: every field with its unit, its values, its range and its default."""

import re
from collections.abc import Iterator

from .fields.json_schema import project_schema
from .fields.kinds import Schema

PAGE = """# Fields of the project file

`strainwave schema --markdown` writes this page from the table that reads a project file;
[](../project-file.md) explains them. A unit stands for every unit of its kind, a unit of 1 for a plain number or %.
"""
COLUMNS = "| field | what | unit or values | range | without it |\n|---|---|---|---|---|\n"
SHARED = {"ripple": "Of `damping.ripples` and `stiffness.ripples`.", "payload": "Of `move.payload`."}
MOST_WORDS = 9  # of a field, that are listed
FORMS = {"motor.loop": "loop", "motor.loop.filters": "filter", "move.profile": "part"}  # each of several forms


def reference() -> str:
    """The page with every table and field: unit, values, range, and what holds without it."""
    schema = project_schema()
    defs, fields = schema["$defs"], schema["properties"]
    top = [_row(name, item, schema["required"]) for name, item in fields.items()]
    parts = [PAGE, f"## Top level\n\n{COLUMNS}" + "".join(top)]
    for name, item in fields.items():
        for i, group in enumerate(_groups(item)):
            by = ("", " by its law", " by its record")[i + 1 if name == "gear" else 0]
            parts.append(_table(f"`{name}`{by}", item["description"], group, name))
    parts += [_table(f"`{name}`", text, defs[name]) for name, text in SHARED.items()]
    for field, forms in FORMS.items():
        for form in next(iter(defs[forms].values())):
            kind = form["properties"]["type"]
            word = kind.get("const") or ("bandwidth" if "bandwidth" in form["properties"] else kind["enum"][0])
            parts.append(_table(f"`{field}`: {word.replace('_', ' ')}", form["description"], form))
    laws = {name.removeprefix("law_"): law for name, law in defs.items() if name.startswith("law_")}
    parts += [_table(f"Law `{name}`", law["description"], law) for name, law in laws.items()]
    return "\n".join(parts)


def _table(title: str, text: str, group: Schema, path: str = "") -> str:
    """Section of a group, with a table of its fields."""
    intro = f"{text if text.startswith('Of `') else _plain(text)}\n\n" if text else ""
    return f"## {title}\n\n{intro}{COLUMNS}" + "".join(_rows(group, path))


def _groups(item: Schema) -> list[Schema]:
    """Groups of fields that a value may be."""
    forms = item.get("anyOf", [item])
    return [form for form in forms if "properties" in form]


def _rows(group: Schema, parent: str) -> Iterator[str]:
    """Rows of the fields of a group, and of the groups inside it."""
    for name, item in group["properties"].items():
        path = f"{parent}.{name}".removeprefix(".")
        yield _row(path, item, [f"{parent}.{field}".removeprefix(".") for field in group.get("required", [])])
        for inner in (*_groups(item), *_groups(item.get("items", {}))):
            yield from _rows(inner, path)


def _row(path: str, item: Schema, required: list[str]) -> str:
    """Row of a field in a table of the page."""
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
    """Unit or values of a field."""
    if "x-unit" in item:
        word = ", `catalogue`" if {"const": "catalogue"} in item.get("anyOf", []) else ""
        return f"{item['x-unit']}{word}"
    if "const" in item or "enum" in item:
        return ", ".join(f"`{word}`" for word in item.get("enum") or [item["const"]])
    if "$ref" in item:
        return str(item["$ref"]).rsplit("/", 1)[1]
    if item.get("type") == "array":
        pair = item.get("prefixItems")
        return f"pair of {' and '.join(map(_kind, pair))}" if pair else f"list of {_kind(item['items'])}"
    if "anyOf" in item and "properties" not in item:
        return ", ".join(sorted(set(map(_form, item["anyOf"]))))
    return {"object": "group", "string": "text"}.get(item.get("type", ""), "")


def _form(item: Schema) -> str:
    """One of several kinds of a field; many words are a name."""
    return "name" if len(item.get("enum", ())) > MOST_WORDS else _kind(item)


def _extent(item: Schema) -> str:
    """Number of items, of letters, or the range of the number of a field."""
    lengths = [item.get(f"{end}{what}") for what in ("Items", "Properties") for end in ("min", "max")]
    least, largest = (lengths[0] or lengths[2], lengths[1] or lengths[3])
    if largest:
        return f"{least or 0} to {largest} items"
    if least:
        return f"{least} or more items"
    return f"{item['maxLength']} letters" if "maxLength" in item else str(item.get("x-range", ""))


def _plain(text: object) -> str:
    """A text without what Markdown would take for signs of its own."""
    return str(text).replace("|", "\\|").replace("*", "\\*").replace("_", "\\_").replace("<", "\\<")
