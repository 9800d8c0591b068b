"""What makes a sweep that sweep and no other: a text of its system, points and measure, and the hash of it.

Functions count with the text of their source, their defaults and the values they close over; what they read from
global variables is not seen.
"""

import dataclasses
import enum
import functools
import hashlib
import inspect
import textwrap
import types
from collections.abc import Mapping
from typing import Any

import numpy as np

from ..quantities import is_model, shown

PLAIN = (type(None), bool, int, str, bytes)


def identity(thing: Any) -> str:
    """Text that is equal for equal things in every process, and different for different ones.

    Raises
    ------
    TypeError
        If `thing` is or holds something that has no such text.
    """
    if isinstance(thing, np.generic):
        thing = thing.item()
    if isinstance(thing, enum.Enum):
        return str(thing)
    if isinstance(thing, PLAIN):
        return repr(thing)
    if isinstance(thing, float):
        return thing.hex()
    if isinstance(thing, complex):
        return f"complex({thing.real.hex()}, {thing.imag.hex()})"
    if isinstance(thing, np.ndarray) and thing.dtype != object:
        return f"array({thing.dtype.str}, {thing.shape}, {hashlib.sha256(thing.tobytes()).hexdigest()})"
    if isinstance(thing, type):
        return f"{_name(thing)}{_source(thing)}"
    if isinstance(thing, Mapping):
        return f"{{{', '.join(f'{identity(key)}: {identity(value)}' for key, value in thing.items())}}}"
    if is_model(thing) or isinstance(thing, list | tuple):
        return f"{identity(type(thing))}({', '.join(map(identity, thing))})"
    if callable(thing) and not dataclasses.is_dataclass(thing):
        return _callable(thing)
    if dataclasses.is_dataclass(thing):
        fields = ((f.name, getattr(thing, f.name)) for f in dataclasses.fields(thing))
        return f"{identity(type(thing))}({', '.join(f'{name}={identity(value)}' for name, value in fields)})"
    raise TypeError(
        f"{shown(thing)} cannot be told from another in the next run, so a sweep that uses it cannot be resumed; use "
        "numbers, arrays, model objects, functions, functools.partial or frozen dataclasses"
    )


def digest(*things: Any) -> str:
    """Hash of the identity of things."""
    return hashlib.sha256(identity(things).encode()).hexdigest()


def readable(measure: Any) -> str:
    """Name of a measure for people."""
    if isinstance(measure, functools.partial):
        return readable(measure.func)
    return getattr(measure, "__qualname__", None) or type(measure).__qualname__


def _callable(thing: Any) -> str:
    if isinstance(thing, functools.partial):
        return f"partial({identity(thing.func)}, {identity(thing.args)}, {identity(thing.keywords)})"
    if isinstance(thing, types.MethodType):
        return f"method({identity(thing.__self__)}, {identity(thing.__func__)})"
    if isinstance(thing, types.FunctionType):
        closed = [cell.cell_contents for cell in thing.__closure__ or ()]
        held = identity([*(thing.__defaults__ or ()), *(thing.__kwdefaults__ or {}).items(), *closed])
        return f"{_name(thing)}{_source(thing)}{held}"
    if hasattr(thing, "__qualname__"):  # a function written in C, a NumPy function
        return _name(thing)
    raise TypeError(
        f"the measure {shown(thing)} cannot be told from another in the next run; make it a function, a "
        "functools.partial or a frozen dataclass with __call__"
    )


def _name(thing: Any) -> str:
    return f"{getattr(thing, '__module__', None)}.{thing.__qualname__}"


@functools.cache
def _source(thing: Any) -> str:
    """Hash of the source of a user's function or class; that of the package is known by its version."""
    if str(getattr(thing, "__module__", "")).partition(".")[0] in ("builtins", "numpy", "scipy", "strainwave"):
        return ""
    try:
        text = textwrap.dedent(inspect.getsource(thing))
    except (OSError, TypeError):
        code = getattr(thing, "__code__", None)
        text = repr((code.co_code, code.co_names, [c for c in code.co_consts if isinstance(c, PLAIN)])) if code else ""
    return "#" + hashlib.sha256(text.encode()).hexdigest()[:16]
