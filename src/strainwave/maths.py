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
    """Cosine as compiled kernels compute it: inlined and without branches, so that a loop over lanes is vector code.

    Beyond 3.3e9 rad, where neighbouring floats differ by 5e-7 rad, it is NaN.
    """
    turn, s, c = _quarter(x)
    value = s if abs(turn) == 0.25 else c
    value = -value if turn > 0.125 else value
    return value if abs(x) < _LARGEST else math.nan


def compiled_sin(x: float) -> float:
    """Sine as compiled kernels compute it, NaN beyond 3.3e9 rad."""
    turn, s, c = _quarter(x)
    value = c if abs(turn) == 0.25 else s
    value = -value if abs(turn - 0.125) > 0.25 else value
    return value if abs(x) < _LARGEST else math.nan


# Cody & Waite's reduction by pi/2 in four parts, the first three of 22 bits, and the polynomials of fdlibm (Sun, 1993).
_LARGEST = 3.3e9  # up to here n has 31 bits, and its products with the first parts are exact
_ROUND = 6755399441055744.0  # 1.5 * 2^52: adding and subtracting it rounds to a whole number
_P1, _P2, _P3, _P4 = 1.570796012878418, 3.139164164167596e-07, 6.223369259164557e-14, 2.912732056093356e-20
_S1, _S2, _S3 = -1.66666666666666324348e-01, 8.33333333332248946124e-03, -1.98412698298579493134e-04
_S4, _S5, _S6 = 2.75573137070700676789e-06, -2.50507602534068634195e-08, 1.58969099521155010221e-10
_C1, _C2, _C3 = 4.16666666666666019037e-02, -1.38888888888741095749e-03, 2.48015872894767294178e-05
_C4, _C5, _C6 = -2.75573143513906633035e-07, 2.08757232129817482790e-09, -1.13596475577881948265e-11


def _quarter(x: float) -> tuple[float, float, float]:
    """Turn of x to a whole quarter (-0.25, 0, 0.25 or 0.5), and sine and cosine of the rest (at most pi/4)."""
    n = (x * 0.6366197723675814 + _ROUND) - _ROUND
    turn = n * 0.25 - (((n * 0.25 - 0.125) + _ROUND) - _ROUND)
    r = (((x - n * _P1) - n * _P2) - n * _P3) - n * _P4
    z = r * r
    s = r + r * z * (_S1 + z * (_S2 + z * (_S3 + z * (_S4 + z * (_S5 + z * _S6)))))
    c = 1.0 - 0.5 * z + z * z * (_C1 + z * (_C2 + z * (_C3 + z * (_C4 + z * (_C5 + z * _C6)))))
    return turn, s, c
