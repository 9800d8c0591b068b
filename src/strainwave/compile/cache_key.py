"""Cache key of a compiled kernel: a hash of all that Numba reads of it and of the model classes in its arguments.

Numba compiles bytecode. The key holds that of the kernel, of each function and method that it may call, of those that
these call, and the values of constants, defaults and closed-over variables among them. Comments, docstrings and lines
do not count. A method counts where one of the functions has its name. What is in this folder counts by the bytes of its
files, another installed package by its name.
"""

import hashlib
from functools import cache
from pathlib import Path
from types import FunctionType, ModuleType
from typing import Any, NamedTuple

from .bytecode import PACKAGE, Reads, code_text, is_installed, taken
from .identity import parts_of, text_of

ROOM = __package__


class Text(NamedTuple):
    """Text of a function or a class, the names in it, and the functions and classes that it reads, in their order."""

    text: bytes
    names: frozenset[str]
    read: tuple[Any, ...]


def key(function: Any, classes: tuple[type, ...]) -> str:
    """Hash that differs where the code of a kernel for models of these classes may.

    Raises
    ------
    TypeError
        If one of the values that are read has no text that another process would recognise.
    """
    queue = list(dict.fromkeys((function, *classes)))
    numbers = {thing: i for i, thing in enumerate(queue)}
    digest, names, methods = hashlib.sha256(), set[str](), set[tuple[type, str]]()

    def add(text: Text) -> None:
        for thing in text.read:
            if thing not in numbers:
                numbers[thing] = len(queue)
                queue.append(thing)
        names.update(text.names)
        digest.update(text.text + repr([numbers[thing] for thing in text.read]).encode())

    for thing in queue:  # which grows
        add(_text(thing))
        if thing is queue[-1]:
            for cls in [other for other in queue if isinstance(other, type)]:
                for name in sorted(names.intersection(_attributes(cls))):
                    if (cls, name) not in methods:
                        methods.add((cls, name))
                        add(_value((numbers[cls], name, _attributes(cls)[name])))
    return digest.hexdigest()


@cache
def folder_hash() -> str:
    """Hash of the files of this folder."""
    digest = hashlib.sha256()
    for path in sorted(Path(__file__).parent.glob("*.py")):
        digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


def _is_read(thing: Any) -> bool:
    """True for a function, a class or a module that counts with its content, not by its name or its folder."""
    module = thing.__name__ if isinstance(thing, ModuleType) else thing.__module__ or ""
    if module == PACKAGE or module.startswith(f"{PACKAGE}."):
        return not module.startswith(ROOM)
    return not is_installed(module)


@cache
def _text(thing: Any) -> Text:
    return _class(thing) if isinstance(thing, type) else _function(thing)


def _class(cls: type) -> Text:
    """A class as the compiler knows it: fields of a model and their defaults, members of an enumeration."""
    members = {name: member.value for name, member in getattr(cls, "__members__", {}).items()}
    held = getattr(cls, "_fields", ()), getattr(cls, "_field_defaults", {}), members
    text, _, read = _value(held)
    return Text(f"class {cls.__module__}.{cls.__qualname__}".encode() + text, frozenset(), read)


@cache
def _attributes(cls: type) -> dict[str, Any]:
    """Attributes of a model class that a function may read by name."""
    if not hasattr(cls, "_fields"):
        return {}
    held = {name: thing for base in reversed(cls.__mro__[:-2]) for name, thing in vars(base).items()}
    return {name: thing for name, thing in held.items() if name[:2] != "__" and name not in cls._fields}


def _function(function: FunctionType) -> Text:
    if hasattr(function, "loops"):  # which compiled code runs in its place (`jit.kernel_as`)
        return _function(function.loops)
    reads = Reads()
    text = code_text(function.__code__, reads, text_of)
    values = taken(function.__globals__, reads, _is_read)
    closed = [cell.cell_contents for cell in function.__closure__ or ()]
    more, _, read = _value((values, closed, function.__defaults__, function.__kwdefaults__))
    return Text(f"{function.__module__}.{function.__qualname__}".encode() + text + more, frozenset(reads.names), read)


def _value(thing: Any) -> Text:
    """Text of a value with a mark in the place of each function and class, which are given beside it."""
    read: list[Any] = []

    def text(item: Any) -> str:
        if isinstance(item, FunctionType | type):
            if _is_read(item):
                read.append(item)
                return "@"
            return f"{item.__module__}.{item.__qualname__}"
        if isinstance(item, ModuleType):
            return item.__name__
        if isinstance(item, dict):
            return f"{{{', '.join(f'{text(k)}: {text(v)}' for k, v in item.items())}}}"
        if isinstance(item, tuple | list):
            return f"{text(type(item))}({', '.join(map(text, item))})"
        parts = parts_of(item)
        return text_of(item) if parts is None else text(parts)

    return Text(text(thing).encode(errors="surrogatepass"), frozenset(), tuple(read))
