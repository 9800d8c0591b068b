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


def compiled_cos(x: float) -> float:
    """Cosine as compiled kernels compute it: inlined, because a call of libm costs more than the polynomial itself."""
    if not abs(x) < _EXACT:
        return math.cos(x)
    turns, s, c = _quarter(x)
    value = s if turns & 1 else c
    return -value if (turns + 1) & 2 else value


def compiled_sin(x: float) -> float:
    """Sine as compiled kernels compute it."""
    if not abs(x) < _EXACT:
        return math.sin(x)
    turns, s, c = _quarter(x)
    value = c if turns & 1 else s
    return -value if turns & 2 else value


# Cody & Waite's reduction by pi/2 in three parts, the first two of 33 bits, and the polynomials of fdlibm (Sun, 1993).
_EXACT = 1e6  # up to here n times the first parts is exact
_ROUND = 6755399441055744.0  # 1.5 * 2^52: adding and subtracting it rounds to a whole number
_P1, _P2, _P3 = 1.57079632673412561417, 6.07710050630396597660e-11, 2.02226624879595063154e-21
_S1, _S2, _S3 = -1.66666666666666324348e-01, 8.33333333332248946124e-03, -1.98412698298579493134e-04
_S4, _S5, _S6 = 2.75573137070700676789e-06, -2.50507602534068634195e-08, 1.58969099521155010221e-10
_C1, _C2, _C3 = 4.16666666666666019037e-02, -1.38888888888741095749e-03, 2.48015872894767294178e-05
_C4, _C5, _C6 = -2.75573143513906633035e-07, 2.08757232129817482790e-09, -1.13596475577881948265e-11


def _quarter(x: float) -> tuple[int, float, float]:
    """Quarter turns in x, and sine and cosine of the rest (at most pi/4)."""
    n = (x * 0.6366197723675814 + _ROUND) - _ROUND
    r = ((x - n * _P1) - n * _P2) - n * _P3
    z = r * r
    s = r + r * z * (_S1 + z * (_S2 + z * (_S3 + z * (_S4 + z * (_S5 + z * _S6)))))
    c = 1.0 - 0.5 * z + z * z * (_C1 + z * (_C2 + z * (_C3 + z * (_C4 + z * (_C5 + z * _C6)))))
    return int(n), s, c
