"""Elementary functions that a law or an excitation may call on floats, arrays and symbols alike.

Each function asks the library its argument comes from (math, NumPy, SymPy); compiled kernels get the libm
version (see `_jit`). Like compiled code, a float outside the domain gives NaN and one too large gives infinity.
`abs` of the language works everywhere and needs no entry here.
"""

import math
import sys
from types import ModuleType
from typing import Any


def _library(x: Any) -> ModuleType:
    if isinstance(x, float | int):
        return math
    return sys.modules[type(x).__module__.partition(".")[0]]


def _apply(name: str, x: Any) -> Any:
    library = _library(x)
    try:
        return getattr(library, name)(x)
    except OverflowError:
        return math.inf
    except ValueError:
        if library is math:
            return math.nan
        raise


def cos(x: Any) -> Any:
    """Cosine of a float, an array or a symbol."""
    return _apply("cos", x)


def sin(x: Any) -> Any:
    """Sine of a float, an array or a symbol."""
    return _apply("sin", x)


def exp(x: Any) -> Any:
    """Exponential of a float, an array or a symbol."""
    return _apply("exp", x)


def sqrt(x: Any) -> Any:
    """Square root of a float, an array or a symbol."""
    return _apply("sqrt", x)


def sign(x: Any) -> Any:
    """Sign (-1, 0 or 1) of a float, an array or a symbol."""
    if isinstance(x, float | int):
        return float(x > 0) - float(x < 0)
    return _library(x).sign(x)
