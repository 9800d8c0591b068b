"""C code as two files, and what every one of them says at its top."""

import re
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import zip_longest
from pathlib import Path
from typing import Any

from ...archive import as_file, atomic, version
from ...quantities import parameters
from ...tree import numbers

RESERVED = {
    "auto", "break", "case", "char", "const", "continue", "default", "do", "double", "else", "enum", "extern",
    "float", "for", "goto", "if", "inline", "int", "long", "register", "restrict", "return", "short",
    "signed", "sizeof", "static", "struct", "switch", "typedef", "union", "unsigned", "void", "volatile",
    "while", "main",
}  # fmt: skip


@dataclass(frozen=True)
class CCode:
    """Dependency-free C99: only math.h and string.h, no allocation, no state of its own.

    Attributes
    ----------
    name : str
        Beginning of every name in it, and the stem of its files.
    header, source : str
        Contents of name.h and name.c.
    """

    name: str
    header: str
    source: str

    def write(self, path: Path) -> Path:
        """Write the source to a path that ends in .c, and the header beside it; both appear when they are complete."""
        with atomic(path.with_suffix(".h")) as header, atomic(path) as source:
            Path(header).write_text(self.header, encoding="utf-8", newline="\n")
            Path(source).write_text(self.source, encoding="utf-8", newline="\n")
        return path


def c_name(path: Any, ending: str) -> tuple[Path, str]:
    """Path of a file with this ending, and its stem as a name in C.

    Raises
    ------
    TypeError
        If the path is none.
    ValueError
        If it ends in something else, or its stem is no name in C.
    """
    path = as_file(path)
    if path.suffix != ending:
        raise ValueError(f"the file is {path.name!r}; give it a name that ends in {ending}")
    return path, as_name(path.stem)


def as_name(text: str) -> str:
    """Return a text that is a name in C (ValueError)."""
    if not re.fullmatch(r"[A-Za-z][A-Za-z0-9_]*", text) or text in RESERVED:
        raise ValueError(f"{text!r} is not a name in C; use letters, digits and _, beginning with a letter")
    return text


def opening(name: str, first: str, facts: list[str], model: Any) -> list[str]:
    """Comment at the top of a file of this name: what it is, facts about it, and the numbers of the model."""
    lines = [
        f"{name}: {first}",
        *facts,
        "",
        f"Written by strainwave {version()} from the model below.",
        f"{name}_default holds its numbers; for others pass a changed copy. What is no field of it is fixed.",
    ]
    owners = [type(owner).__name__ for _, owner, _, _ in numbers(model)]
    for (path, value, unit), owner in zip(parameters(model), owners, strict=True):
        lines.append(f"  {path} = {value!r}{' ' * bool(unit)}{unit} ({owner})")
    return ["/*", *(f" * {line}".rstrip().replace("*/", "* /") for line in lines), " */"]


def struct(name: str, fields: Iterable[str], comments: Iterable[str] = ()) -> list[str]:
    """Type of a struct of doubles, with comments on them; a field may have a length, as y[3]."""
    said = zip_longest(fields, [f" /* {comment} */" for comment in comments], fillvalue="")
    return ["typedef struct {", *(f"    double {field};{comment}" for field, comment in said), f"}} {name};"]


def function(signature: str, body: list[str]) -> list[str]:
    """Definition of a function."""
    return [f"{signature}", "{", *(f"    {line}" for line in body), "}"]


def text_of(*parts: list[str]) -> str:
    """Text of a file: parts with an empty line between them."""
    return "\n\n".join("\n".join(part) for part in parts) + "\n"


def guarded(name: str, *parts: list[str]) -> str:
    """Text of a header."""
    guard = f"{name.upper()}_H"
    first, *others = parts
    opened = ["#ifdef __cplusplus", 'extern "C" {', "#endif"]
    closed = ["#ifdef __cplusplus", "}", "#endif"]
    return text_of(first, [f"#ifndef {guard}", f"#define {guard}"], opened, *others, closed, [f"#endif /* {guard} */"])
