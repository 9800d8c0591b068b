"""The table of a project file's fields as reference page, as JSON Schema for editors and as commented template."""

import re
from collections.abc import Iterator, Mapping
from itertools import groupby
from textwrap import wrap
from typing import Any

from ..drive.demands.payload import Payload
from ..model.oscillator import Ripple
from .fields.entries import Loop, filter_types
from .fields.kinds import Schema
from .fields.python_law import NAMED
from .fields.rows import law_types, row_at, schema_of
from .fields.schema import PARTS, ProjectSpec

NAME = "strainwave.schema.json"  # of the file that editors read


def _definitions() -> dict[str, Schema]:
    """Entries that more than one field takes, by name."""
    laws = {name: schema_of(cls, name) for name, cls in law_types().items()}
    python = {"python": {"type": "string", "pattern": f"^{NAMED.pattern}$", "description": "Law of a Python file."}}
    forms = [
        *({"$ref": f"#/$defs/law_{name}"} for name in laws),
        {"type": "object", "properties": python, "required": ["python"]},
        {"type": "string", "pattern": f"^{NAMED.pattern}$"},
    ]
    return {
        **{f"law_{name}": law for name, law in laws.items()},
        "law": {"anyOf": forms},
        "ripple": schema_of(Ripple),
        "payload": schema_of(Payload),
        "loop": {"anyOf": Loop().schemas()},
        "filter": {"oneOf": [schema_of(cls, name) for name, cls in filter_types().items()]},
        "part": {"oneOf": [schema_of(cls, name) for name, cls in PARTS.items()]},
    }


def project_schema() -> Schema:
    """JSON Schema (draft 2020-12) of a project file, with a description, the unit and the range of every field.

    Returns
    -------
    dict
        As `json.dumps` takes it. `x-unit` has the unit of a field in SI and `x-range` the range of its number.
    """
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "$id": "urn:strainwave:project-file",
        "title": "strainwave project file",
        "description": "A drive with a strain wave gear, its speeds and what excites it.",
        **schema_of(ProjectSpec),
        "$defs": _definitions(),
    }


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


HEAD = """\
# A drive with a strain wave gear. Every quantity is a number with its unit; other units of the same kind do as well.
# Lines with '#' before a field show further fields that may be written.
"""
WIDTH = 110


def template(values: Mapping[str, str], schema_file: str = "") -> str:
    """Text of a project file with comments.

    Parameters
    ----------
    values : dict
        Text of every field by its path, "speed.from", in the order of the file; "" for one that is left as an example.
    schema_file : str
        Name of the JSON Schema that lies beside the file, for editors; "" for none.
    """
    lines = [f"# yaml-language-server: $schema={schema_file}"] if schema_file else []
    lines += [HEAD]
    for name, paths in groupby(values, key=lambda path: path.split(".")[0]):
        inside = list(paths)
        if inside != [name]:
            lines += [*_comment(name), f"{name}:" if any(values[path] for path in inside) else f"# {name}:"]
        for path in inside:
            indent, key = "  " * path.count("."), path.split(".")[-1]
            example = f"#{indent or ' '}{key}: {_row_at(path).example}"
            lines += [*_comment(path), f"{indent}{key}: {values[path]}" if values[path] else example]
        lines.append("")
    return "\n".join(lines)


def _row_at(path: str) -> Any:
    return row_at(ProjectSpec, None, path.split("."))


def _comment(path: str) -> list[str]:
    """The description, with the words that a field may have."""
    item, indent = _row_at(path).schema(), "  " * path.count(".")
    words = f" One of: {', '.join(item['enum'])}." if "enum" in item and len(item["enum"]) < 9 else ""
    return [f"{indent}# {line}" for line in wrap(item["description"] + words, WIDTH - len(indent))]
