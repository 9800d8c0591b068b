"""`Identity`: text by which a function, a model or another value is recognised in a later run.

Functions count with their bytecode, their defaults, the values they close over and those of the global variables that
they read; functions and classes among these likewise. What belongs to an installed package counts with its name.
Other objects count with what they would be pickled with.

Reads of a function beside its arguments: its global variables, and which things belong to an installed package.

The bytecode says it, so that a function without source (a lambda in a line of many, `exec`) is known as well as others.
Names that are looked up by text (`globals()["K"]`, `getattr(module, name)`) are not seen.
"""

import copyreg
import enum
import functools
import hashlib
import importlib
import importlib.util
import pickle
import sys
import types
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dis import EXTENDED_ARG, hasconst, opmap
from functools import cache
from types import CodeType, FunctionType, ModuleType
from typing import Any, NamedTuple
from weakref import WeakKeyDictionary

import numpy as np

from .tree import shown

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


def code_text(code: CodeType, reads: Reads) -> bytes:
    """Instructions with constants in place of their numbers, which a docstring moves; the names read go to `reads`."""
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
    inner = [
        code_text(item, reads).hex() if isinstance(item, CodeType) else Identity().text(item) for item in constants
    ]
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


def _imported(name: str, level: int, items: tuple[str, ...] | None, scope: dict[str, Any]) -> Iterator[tuple[str, Any]]:
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


PLAIN = (type(None), bool, int, str, bytes, type(Ellipsis), type(NotImplemented))
# In classes, modules and functions: what Python writes there for itself, and what says again what is elsewhere.
UNUSED = {
    "__dict__", "__weakref__", "__module__", "__doc__", "__qualname__", "__annotations__", "__annotate__",
    "__annotate_func__", "__annotations_cache__", "__firstlineno__", "__static_attributes__", "__orig_bases__",
    "__parameters__", "__dataclass_fields__", "__dataclass_params__", "_abc_impl", "__abstractmethods__",
    "__builtins__", "__cached__", "__file__", "__loader__", "__name__", "__package__", "__spec__", "__wrapped__",
    "__slotnames__",
}  # fmt: skip
OF_EVERY_NAMEDTUPLE = {"__new__", "_make", "_replace", "__replace__", "_asdict", "__repr__", "__getnewargs__"}


class Identity:
    """One pass through a thing: functions, classes and modules have a number, from the second time on instead of text.

    Attributes
    ----------
    packages : set of str
        Names of what installed packages hold that was met.
    has_code : bool
        True if there is bytecode in the text.
    """

    def __init__(self) -> None:
        self.packages: set[str] = set()
        self.has_code = False
        self._met: dict[int, tuple[int, Any]] = {}
        self._inside: list[int] = []  # objects whose text is being made
        self._trail: list[str] = []  # where they are, for people

    def text(self, thing: Any) -> str:
        """Text of a thing; TypeError if it has none."""
        kind = type(thing)
        if kind in PLAIN:
            return repr(thing)
        if kind in (float, np.float64):
            return float(thing).hex()
        if kind in (complex, np.complex128):
            return f"complex({thing.real.hex()}, {thing.imag.hex()})"
        if (name := package_name(thing)) is not None:
            self.packages.add(name)
            return name
        if isinstance(thing, type | types.FunctionType | types.ModuleType | types.CodeType):
            if id(thing) in self._met:
                return f"#{self._met[id(thing)][0]}"
            self._met[id(thing)] = len(self._met), thing
            return self._first(thing)
        if id(thing) in self._inside:
            return f"^{len(self._inside) - self._inside.index(id(thing))}"
        self._inside.append(id(thing))
        try:
            return self._value(thing)
        finally:
            self._inside.pop()

    def _value(self, thing: Any) -> str:
        kind = type(thing)
        if isinstance(thing, np.generic) or kind is np.ndarray:
            return self._array(np.asarray(thing), kind)
        if isinstance(thing, enum.Enum):
            return f"{self.text(kind)}.{thing.name}({self.text(thing.value)})"
        if kind in (dict, types.MappingProxyType):
            return f"{{{self._pairs(thing)}}}"
        if kind in (set, frozenset):
            return f"{kind.__name__}({self._unordered(thing)})"
        if kind in (list, tuple):
            return f"{kind.__name__}({self._listed(thing)})"
        parts = parts_of(thing)
        return self._pickled(thing) if parts is None else f"{kind.__name__}({self._listed(parts)})"

    def _array(self, array: Any, kind: type) -> str:
        described = array.dtype.str if array.dtype.names is None else array.dtype.descr
        if array.dtype.hasobject:
            return f"{kind.__name__}({described}, {array.shape}, {self._listed(array.ravel().tolist())})"
        return f"{kind.__name__}({described}, {array.shape}, {hashlib.sha256(array.tobytes()).hexdigest()})"

    def _first(self, thing: Any) -> str:
        """A function, a class, a module or code that is met for the first time."""
        if isinstance(thing, CodeType):
            return self._code(thing, Reads())
        with self._at(thing.__name__ if isinstance(thing, types.ModuleType) else thing.__qualname__):
            if isinstance(thing, types.FunctionType):
                return self._function(thing)
            return self._class(thing) if isinstance(thing, type) else f"module({self._pairs(_used(vars(thing)))})"

    def _code(self, code: CodeType, reads: Reads) -> str:
        self.has_code = True
        return hashlib.sha256(code_text(code, reads)).hexdigest()

    def _function(self, function: FunctionType) -> str:
        reads, scope = Reads(), function.__globals__
        text = self._code(function.__code__, reads)
        held = taken(scope, reads, lambda module: not is_installed(module.__name__))
        imported = dict(item for each in reads.imports for item in _imported(*each, scope))
        code, defaults = function.__code__, function.__defaults__ or ()
        last = code.co_varnames[: code.co_argcount][code.co_argcount - len(defaults) :]
        given = dict(zip(last, defaults, strict=True)) | (function.__kwdefaults__ or {})
        closed = dict(zip(code.co_freevars, map(_content, function.__closure__ or ()), strict=True))
        parts = [
            ("default of", given), ("closed-over variable", closed), ("attribute", _used(vars(function))),
            ("global variable", held), ("import", imported),
        ]  # fmt: skip
        return f"function({text}; {'; '.join(self._pairs(some, kind) for kind, some in parts)})"

    def _class(self, cls: type) -> str:
        held = _used(vars(cls))
        if issubclass(cls, enum.Enum):
            functions = {k: v for k, v in held.items() if isinstance(v, types.FunctionType) and not k.startswith("_")}
            held = functions | {name: member.value for name, member in cls.__members__.items()}
        elif tuple in cls.__bases__ and "_fields" in held:
            held = {k: v for k, v in held.items() if k not in OF_EVERY_NAMEDTUPLE}
        bases = self._listed((type(cls), *cls.__bases__))
        return f"class({cls.__qualname__}, {bases}; {self._pairs(dict(sorted(held.items())), 'attribute')})"

    def _pickled(self, thing: Any) -> str:
        """Any other object: its class, and the state that it would be pickled with."""
        if type(thing) is object or hasattr(thing, "__next__"):  # a mark without content, and what is used up
            raise self._unknown(thing)
        try:
            registered = copyreg.dispatch_table.get(type(thing))
            made = thing.__reduce_ex__(4) if registered is None else registered(thing)
        except (TypeError, ValueError, AttributeError, RuntimeError, pickle.PicklingError):
            raise self._unknown(thing) from None
        if isinstance(made, str):  # a name that no installed package has
            raise self._unknown(thing)
        make, given, state, items, pairs = (*made, None, None, None)[:5]
        with self._at(type(thing).__qualname__):
            # The items of a set come in the order of their hashes, which differs between processes.
            with self._at("an argument"):
                first = self._unordered(thing) if isinstance(thing, set | frozenset) else self._listed(given)
            fields = isinstance(state, dict) and all(isinstance(key, str) for key in state)
            content = self._pairs(dict(sorted(state.items())), "field") if fields else self.text(state)
            more = f"{self._listed(items or ())}; {self._listed(pairs or ())}"
            return f"object({self.text(type(thing))}, {self.text(make)}, {first}; {content}; {more})"

    def _listed(self, things: Iterable[Any]) -> str:
        return ", ".join(map(self.text, things))

    def _unordered(self, things: Iterable[Any]) -> str:
        texts, met = [], self._met
        for thing in things:
            self._met = dict(met)  # numbers do not depend on what came before
            texts.append(self.text(thing))
        self._met = met
        return ", ".join(sorted(texts))

    def _pairs(self, pairs: Mapping[Any, Any], kind: str = "item") -> str:
        out = []
        for key, value in pairs.items():
            with self._at(f"{kind} {shown(key)}"):
                out.append(f"{self.text(key)}: {self.text(value)}")
        return ", ".join(out)

    @contextmanager
    def _at(self, part: str) -> Iterator[None]:
        self._trail.append(part)
        yield
        self._trail.pop()

    def _unknown(self, thing: Any) -> TypeError:
        trail = " of ".join(reversed(self._trail[-2:]))
        return TypeError(
            f"{f'{trail} holds {shown(thing)}; that' if trail else shown(thing)} cannot be recognised in the next run, "
            "so a sweep that uses it cannot be resumed; use numbers, arrays, model objects, functions, "
            "functools.partial or frozen dataclasses, or leave the store out"
        )


FIRST = WeakKeyDictionary[type, str]()  # text of each user's class at its first use


def refuse_changed(cls: type) -> None:
    """Refuse a user's class that reads other values than at its first use, which its machine code has (ValueError)."""
    with suppress(TypeError):
        text = Identity().text(cls)
        if FIRST.setdefault(cls, text) != text:
            raise ValueError(
                f"{cls.__name__} or a value that it reads has changed since its first use, whose machine code has the "
                "values of then; run its class statement again, or start a new process"
            )


def _used(held: Mapping[str, Any]) -> dict[str, Any]:
    return {name: value for name, value in held.items() if name not in UNUSED}


def _content(cell: Any) -> Any:
    try:
        return cell.cell_contents
    except ValueError:  # it is assigned later
        return Missing()


def parts_of(thing: Any) -> tuple[Any, ...] | None:
    """Parts of a thing around functions; None for all others."""
    if isinstance(thing, Missing):
        return ()
    if isinstance(thing, types.MethodType):
        return thing.__self__, thing.__func__
    if isinstance(thing, staticmethod | classmethod):
        return (thing.__func__,)
    if isinstance(thing, property):
        return thing.fget, thing.fset, thing.fdel
    if isinstance(thing, functools.cached_property):  # some versions of Python keep a lock in it
        return (thing.func,)
    if isinstance(thing, types.MemberDescriptorType | types.GetSetDescriptorType):
        return (thing.__name__,)
    if isinstance(thing, np.ufunc):
        homes = (np, sys.modules.get("scipy.special"))
        named = any(getattr(home, thing.__name__, None) is thing for home in homes)
        return (thing.__name__,) if named else None
    if isinstance(thing, types.BuiltinFunctionType | types.MethodWrapperType):
        return None if isinstance(thing.__self__, types.ModuleType | None) else (thing.__self__, thing.__name__)
    for inner in ("py_func", "__wrapped__"):  # of `numba.njit` and `functools.cache`
        if isinstance(function := getattr(thing, inner, None), types.FunctionType):
            return function, getattr(thing, "targetoptions", None)
    return None
