"""C code as two files, what every one of them says at its top, and the numbers of a model as fields of a struct.

A user of the code changes these without exporting again.
The floats of a model are recorded by name. One that decides a branch (a comparison in `if`, a function of the module
math) is fixed: it stands in the code as it is. So do integers. What the code does not use is no field.
"""

import os
import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from itertools import zip_longest
from pathlib import Path
from typing import Any, TypeVar

from ...base.archive import atomic, version
from ...base.quantities import parameters, shown
from ...compile.tree import mapped, numbers
from .traced import Decided, Recording, literal

T = TypeVar("T")

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


def c_name(path: str | os.PathLike[str], ending: str) -> tuple[Path, str]:
    """Path of a file with this ending, and its stem as a name in C.

    Raises
    ------
    ValueError
        If it ends in something else, or its stem is no name in C.
    """
    path = Path(path)
    if path.suffix != ending:
        raise ValueError(f"the file is {shown(path.name)}; give it a name that ends in {ending}")
    return path, as_name(path.stem)


def as_name(text: str) -> str:
    """Return a text that is a name in C (ValueError)."""
    if not re.fullmatch(r"[A-Za-z][A-Za-z0-9_]*", text) or text in RESERVED:
        raise ValueError(f"{text!r} is not a name in C; use letters, digits and _, beginning with a letter")
    return text


def opening(name: str, first: str, facts: list[str], model: Any) -> list[str]:
    """Comment at the top of a file of this name: its subject, facts about it, and the numbers of the model."""
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
    members = zip_longest(fields, [f" /* {comment} */" for comment in comments], fillvalue="")
    return ["typedef struct {", *(f"    double {field};{comment}" for field, comment in members), f"}} {name};"]


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


@dataclass(frozen=True)
class Parameters:
    """The floats of a model by their names in C.

    Attributes
    ----------
    model : NamedTuple
        Holds the exported values.
    fixed : frozenset of str
        Names of those that stay numbers.
    """

    model: Any
    fixed: frozenset[str] = frozenset()

    def recorded(self, recording: Recording) -> Any:
        """Return the model with recorded parameters in the place of its floats."""
        names = iter(_names(self.model))

        def of(value: Any) -> Any:
            if not isinstance(value, float):
                return value
            name = next(names)
            return value if name in self.fixed else recording.parameter(name)

        return mapped(of, self.model)

    def struct(self, name: str, bodies: list[str]) -> tuple[list[str], list[str]]:
        """Type of the struct and its instance with the exported values, of those that bodies of functions use."""
        used = set(re.findall(r"p->(\w+)", "\n".join(bodies)))
        floats = [(path, value, unit) for path, value, unit in parameters(self.model) if isinstance(value, float)]
        kept = [(field, *about) for field, about in zip(_names(self.model), floats, strict=True) if field in used]
        kept = kept or [("none", "no number can change", 0.0, "")]
        texts = [f"{path} [{unit or '-'}]" for _, path, _, unit in kept]
        declared = struct(f"{name}_parameters", [field for field, *_ in kept], texts)
        values = [f"    .{field} = {literal(value)}," for field, _, value, _ in kept]
        return declared, [f"const {name}_parameters {name}_default = {{", *values, "};"]


def with_parameters(model: Any, record: Callable[[Parameters], T]) -> T:
    """Record a model by a function of its parameters, with those fixed that decide a branch."""
    floats = Parameters(model)
    while True:
        try:
            return record(floats)
        except Decided as decided:
            floats = Parameters(model, floats.fixed | decided.names)


def _names(model: Any) -> list[str]:
    """Names in C of the floats of a model: their paths with underscores, made different where these are equal."""
    names: dict[str, None] = {}
    for i, (path, value, _) in enumerate(parameters(model)):
        if isinstance(value, float):
            name = path.replace(".", "_")
            usable = re.fullmatch(r"[A-Za-z][A-Za-z0-9_]*", name) and name not in RESERVED and name not in names
            names[name if usable else f"parameter_{i}"] = None
    return list(names)
