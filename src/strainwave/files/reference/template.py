"""A project file with a comment for every field: what it is, its unit and its values."""

from collections.abc import Mapping
from itertools import groupby
from textwrap import wrap

from ..complaints import EXAMPLES
from .json_schema import Schema, project_schema

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
    fields = project_schema()["properties"]
    lines = [f"# yaml-language-server: $schema={schema_file}"] if schema_file else []
    lines += [HEAD]
    for name, paths in groupby(values, key=lambda path: path.split(".")[0]):
        inside = list(paths)
        lines += _comment(fields[name], "")
        if inside == [name]:
            lines.append(_line(name, name, values[name], ""))
        else:
            used = any(values[path] for path in inside)
            lines.append(f"{name}:" if used else f"# {name}:")
            for path in inside:
                field = path.split(".")[1]
                lines += _comment(fields[name]["properties"][field], "  ")
                lines.append(_line(field, path, values[path], "  "))
        lines.append("")
    return "\n".join(lines)


def _line(field: str, path: str, value: str, indent: str) -> str:
    return f"{indent}{field}: {value}" if value else f"#{indent or ' '}{field}: {EXAMPLES[path]}"


def _comment(item: Schema, indent: str) -> list[str]:
    """The description, with the words that a field may have."""
    words = f" One of: {', '.join(item['enum'])}." if "enum" in item and len(item["enum"]) < 9 else ""
    return [f"{indent}# {line}" for line in wrap(item["description"] + words, WIDTH - len(indent))]
