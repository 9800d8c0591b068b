"""What a function reads beside its arguments: its global variables, and which things belong to an installed package.

The bytecode says it, so that a function without source (a lambda in a line of many, `exec`) is known as well as others.
Names that are looked up by text (`globals()["K"]`, `getattr(module, name)`) are not seen.
"""

import builtins
import dis
import importlib
import importlib.util
import sys
from collections.abc import Iterator
from contextlib import suppress
from functools import cache
from types import CodeType, FunctionType, ModuleType
from typing import Any, NamedTuple

OWN = __name__.partition(".")[0]
READS = ("LOAD_GLOBAL", "LOAD_NAME", "LOAD_FROM_DICT_OR_GLOBALS")
ATTRIBUTES = ("LOAD_ATTR", "LOAD_METHOD")
PASSED = ("EXTENDED_ARG", "CACHE")


class Missing(NamedTuple):
    """A name without a value."""


class Package(NamedTuple):
    """A module of an installed package, by its name."""

    name: str


@cache
def is_installed(module: str) -> bool:
    """Whether a module belongs to the standard library, to this package or to another one that is installed."""
    top = module.partition(".")[0]
    if top in sys.stdlib_module_names or top == OWN:
        return top != "__main__"
    spec = getattr(sys.modules.get(top), "__spec__", None)
    if spec is None:
        with suppress(ImportError, ValueError):
            spec = importlib.util.find_spec(top)
    places = [] if spec is None else [spec.origin or "", *(spec.submodule_search_locations or ())]
    return any(folder in place for place in places for folder in ("site-packages", "dist-packages"))


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
    found: Any = sys.modules.get(module)
    for part in name.split("."):
        found = getattr(found, part, None)
    return f"{module}.{name}" if getattr(found, "__func__", found) is thing else None


def codes(code: CodeType) -> Iterator[CodeType]:
    """A code object and all those inside it."""
    yield code
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield from codes(constant)


def reads(function: FunctionType) -> Iterator[tuple[str, Any]]:
    """Name and value of each global variable that a function reads; of a module, of the item that it takes from it."""
    known = function.__globals__
    seen = set()
    for code in codes(function.__code__):
        steps = [step for step in dis.get_instructions(code) if step.opname not in PASSED]
        for i, step in enumerate(steps):
            if step.opname in READS:
                value = known.get(step.argval, getattr(builtins, step.argval, Missing()))
                found = [_item(step.argval, value, steps[i + 1 :])]
            elif step.opname == "IMPORT_NAME":
                found = list(_imported(step.argval, steps[i - 2].argval, steps[i - 1].argval, known))
            else:
                continue
            for name, value in found:
                if name not in seen:
                    seen.add(name)
                    yield name, value


def _item(name: str, value: Any, following: list[dis.Instruction]) -> tuple[str, Any]:
    """Name and value after the attributes that are taken of a module of the user's."""
    for step in following:
        if not isinstance(value, ModuleType) or is_installed(value.__name__) or step.opname not in ATTRIBUTES:
            break
        name, value = f"{name}.{step.argval}", getattr(value, step.argval, Missing())
    return name, value


def _imported(name: str, level: int, items: tuple[str, ...] | None, known: dict[str, Any]) -> Iterator[tuple[str, Any]]:
    """Names and values of what a function imports as it runs."""
    if not level and is_installed(name):
        yield name, Package(name)
        return
    module: Any = Missing()
    with suppress(ImportError):
        module = importlib.import_module("." * level + name, known.get("__package__"))
        for item in items or ():
            if not hasattr(module, item):
                importlib.import_module(f"{module.__name__}.{item}")
    if not items:
        yield name, module
    for item in items or ():
        yield f"{name}.{item}", getattr(module, item, Missing())
