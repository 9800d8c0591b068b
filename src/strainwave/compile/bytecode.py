"""What a function reads beside its arguments, by its bytecode: global variables, attributes, imports.

So a function without source (a lambda in a line of many, `exec`) is known as well as others. Names that are looked up
by text (`globals()["K"]`, `getattr(module, name)`) are not seen. What an installed package holds is known by its name.
"""

import importlib
import importlib.util
import sys
from collections.abc import Callable, Iterator
from contextlib import suppress
from dis import EXTENDED_ARG, hasconst, opmap
from functools import cache
from types import CodeType, ModuleType
from typing import Any, NamedTuple

PACKAGE = __name__.partition(".")[0]
CONSTANTS, LOAD_GLOBAL, IMPORT_NAME = frozenset(hasconst), opmap["LOAD_GLOBAL"], opmap["IMPORT_NAME"]
FILLERS = {opmap["CACHE"], EXTENDED_ARG}
ATTRIBUTES = {opmap[name] for name in ("LOAD_ATTR", "LOAD_METHOD") if name in opmap}
READS = {opmap[name] for name in ("LOAD_GLOBAL", "LOAD_NAME", "LOAD_FROM_DICT_OR_GLOBALS") if name in opmap}


class Missing(NamedTuple):
    """A name without a value."""


class Package(NamedTuple):
    """A module of an installed package, by its name."""

    name: str


@cache
def is_installed(module: str) -> bool:
    """True for a module of the standard library, of this package or of another one that is installed."""
    top = module.partition(".")[0]
    if top in sys.stdlib_module_names or top == PACKAGE:
        return top != "__main__"
    spec = getattr(sys.modules.get(top), "__spec__", None)
    if spec is None:
        with suppress(ImportError, ValueError):
            spec = importlib.util.find_spec(top)
    paths = [] if spec is None else [spec.origin or "", *(spec.submodule_search_locations or ())]
    return any(folder in path for path in paths for folder in ("site-packages", "dist-packages"))


def package_name(thing: Any) -> str | None:
    """Dotted name of what is found under its own name in an installed package; None for all else."""
    if isinstance(thing, Package):
        return thing.name
    if isinstance(thing, ModuleType):
        return thing.__name__ if is_installed(thing.__name__) else None
    owner = getattr(thing, "__objclass__", thing)  # of methods written in C
    module = getattr(owner, "__module__", None)
    name = getattr(thing, "__qualname__", None) or getattr(thing, "__name__", None)
    if not isinstance(module, str) or not isinstance(name, str) or not is_installed(module):
        return None
    value: Any = sys.modules.get(module)
    for part in name.split("."):
        value = getattr(value, part, None)
    return f"{module}.{name}" if getattr(value, "__func__", value) is thing else None


class Reads:
    """Names that code reads: global variables, attributes and texts, and what it imports as it runs.

    `passed` are the variables of which it takes more than an attribute.
    """

    def __init__(self) -> None:
        self.variables, self.names, self.passed = set[str](), set[str](), set[str]()
        self.imports = dict[tuple[str, int, Any], None]()


def code_text(code: CodeType, reads: Reads, text: Callable[[Any], str]) -> bytes:
    """Instructions with constants in place of their numbers, which a docstring moves; the names read go to `reads`.

    `text` gives the text of a constant.
    """
    steps, constants, wide, read = bytearray(code.co_code), list[Any](), 0, ""
    reads.names.update(code.co_names)
    for i in range(0, len(steps), 2):
        number = wide | steps[i + 1]
        if read and steps[i] not in FILLERS:
            reads.passed.update([read] if steps[i] not in ATTRIBUTES else [])
            read = ""
        if steps[i] in CONSTANTS:
            constants.append(code.co_consts[number])
            steps[i + 1] = 0
        elif steps[i] in READS:
            read = code.co_names[number >> 1 if steps[i] == LOAD_GLOBAL else number]
            reads.variables.add(read)
        elif steps[i] == IMPORT_NAME:
            reads.imports[code.co_names[number], *constants[-2:]] = None
        wide = number << 8 if steps[i] == EXTENDED_ARG else 0
    reads.names.update(item for item in constants if isinstance(item, str) and item.isidentifier())
    inner = [code_text(item, reads, text).hex() if isinstance(item, CodeType) else text(item) for item in constants]
    counts = code.co_argcount, code.co_posonlyargcount, code.co_kwonlyargcount, code.co_flags
    names = code.co_names, code.co_varnames, code.co_freevars, code.co_cellvars
    return bytes(steps) + repr((counts, names, code.co_exceptiontable, inner)).encode(errors="surrogatepass")


def taken(scope: dict[str, Any], reads: Reads, is_read: Callable[[Any], bool], above: Any = ()) -> dict[str, Any]:
    """Values of the variables in a scope; in place of a module that is read, what is taken of it.

    `above` are the scopes that this one was reached from.
    """
    names = reads.names if above else reads.variables
    values = {name: scope[name] for name in sorted(names) if name in scope}
    for name, value in [*values.items()]:
        if isinstance(value, ModuleType) and is_read(value) and name not in reads.passed:
            circular = any(vars(value) is other for other in above)
            values[name] = {} if circular else taken(vars(value), reads, is_read, (*above, scope))
    return values


def imported(name: str, level: int, items: tuple[str, ...] | None, scope: dict[str, Any]) -> Iterator[tuple[str, Any]]:
    """Names and values of what a function imports as it runs."""
    if not level and is_installed(name):
        yield name, Package(name)
        return
    module: Any = Missing()
    with suppress(ImportError):
        module = importlib.import_module("." * level + name, scope.get("__package__"))
        for item in items or ():
            if not hasattr(module, item):
                importlib.import_module(f"{module.__name__}.{item}")
    if not items:
        yield name, module
    for item in items or ():
        yield f"{name}.{item}", getattr(module, item, Missing())
