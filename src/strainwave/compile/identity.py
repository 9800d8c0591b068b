"""`Identity`: text by which a function, a model or another value is recognised in a later run.

Functions count with their bytecode, their defaults, the values they close over and those of the global variables that
they read (`bytecode`); functions and classes among these likewise. What belongs to an installed package counts with its
name. Other objects count with what they would be pickled with.
"""

import copyreg
import enum
import functools
import hashlib
import pickle
import sys
import types
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from types import CodeType, FunctionType
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np

from .bytecode import Missing, Reads, code_text, imported, is_installed, package_name, taken
from .tree import shown

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
        return hashlib.sha256(code_text(code, reads, text_of)).hexdigest()

    def _function(self, function: FunctionType) -> str:
        reads, scope = Reads(), function.__globals__
        text = self._code(function.__code__, reads)
        held = taken(scope, reads, lambda module: not is_installed(module.__name__))
        modules = dict(item for each in reads.imports for item in imported(*each, scope))
        code, defaults = function.__code__, function.__defaults__ or ()
        last = code.co_varnames[: code.co_argcount][code.co_argcount - len(defaults) :]
        given = dict(zip(last, defaults, strict=True)) | (function.__kwdefaults__ or {})
        closed = dict(zip(code.co_freevars, map(_content, function.__closure__ or ()), strict=True))
        parts = [
            ("default of", given), ("closed-over variable", closed), ("attribute", _used(vars(function))),
            ("global variable", held), ("import", modules),
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


def text_of(thing: Any) -> str:
    """Text of a thing by itself, as `Identity.text` gives it."""
    return Identity().text(thing)


FIRST = WeakKeyDictionary[type, str]()  # text of each user's class at its first use


def refuse_changed(cls: type) -> None:
    """Refuse a user's class that reads other values than at its first use, which its machine code has (ValueError)."""
    with suppress(TypeError):
        text = text_of(cls)
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
