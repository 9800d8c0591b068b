"""Text of a new project file, with a comment and an example for every field."""

from collections.abc import Mapping
from itertools import groupby
from textwrap import wrap
from typing import Any

from .rows import row_at
from .schema import ProjectSpec

HEAD = """\
# A drive with a strain wave gear. Every quantity is a number with its unit; other units of the same kind do as well.
# What a line with '#' before a field shows may be written too.
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
