"""Elementary functions that a law or an excitation may call on floats, arrays and symbols alike.

Each function asks the library its argument comes from (math, NumPy, SymPy), NumPy also for what its functions take;
compiled kernels get vector code (see `maths_kernels`). Like compiled code, a float outside the domain gives NaN and one
too large gives infinity. `abs` of the language works everywhere and needs no entry here.
"""

import math
import sys
from types import ModuleType
from typing import Any


def _library(x: Any) -> ModuleType:
    if isinstance(x, float | int):
        return math
    name = "numpy" if hasattr(type(x), "__array_ufunc__") else type(x).__module__.partition(".")[0]
    return sys.modules[name]


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


def log(x: Any) -> Any:
    """Natural logarithm of a float, an array or a symbol; -inf at zero."""
    return -math.inf if isinstance(x, float | int) and x == 0 else _apply("log", x)


def tanh(x: Any) -> Any:
    """Hyperbolic tangent of a float, an array or a symbol: a smooth sign."""
    return _apply("tanh", x)


def power(x: Any, y: Any) -> Any:
    """Return x to the power y; for floats NaN where x is negative and y is not an integer, infinity for 0 to y < 0.

    Write small whole powers as products: they are exact to rounding and cost a twentieth.
    """
    if not (isinstance(x, float | int) and isinstance(y, float | int)):
        return x**y
    try:
        return math.pow(x, y)
    except OverflowError:
        return -math.inf if x < 0.0 and y % 2.0 == 1.0 else math.inf
    except ValueError:
        return math.inf if x == 0.0 else math.nan


def sqrt(x: Any) -> Any:
    """Square root of a float, an array or a symbol."""
    return _apply("sqrt", x)


def sign(x: Any) -> Any:
    """Sign (-1, 0 or 1) of a float, an array or a symbol."""
    if isinstance(x, float | int):
        return float(x > 0) - float(x < 0)
    return _library(x).sign(x)
