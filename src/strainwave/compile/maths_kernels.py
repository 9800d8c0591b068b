"""Elementary functions as compiled kernels compute them: inlined arithmetic and selects, no call and no branch.

A loop over lanes that uses them becomes vector code, and what does not depend on the lane leaves the loop. Errors are
below one unit in the last place for exp, log and power, below 2.5 for cos, sin (one of the last place of 1) and tanh;
infinities, NaN and subnormal numbers behave as in libm (zero has no sign here).

The reductions are those of Cody & Waite, Software Manual for the Elementary Functions, 1980; the polynomials Chebyshev
interpolants of the remainders. As Python, the same functions run on floats, which is how their accuracy is tested
without a compiler.
"""

import math
import struct
from fractions import Fraction
from typing import Any

from . import maths

_ROUND = 6755399441055744.0  # 1.5 * 2^52: adding and subtracting it rounds to a whole number

# pi/2 in four parts, the first three of 22 bits
_LARGEST = 3.3e9  # up to here a whole number of quarter turns has 31 bits, and its products with three parts are exact
_P1, _P2, _P3, _P4 = 1.570796012878418, 3.139164164167596e-07, 6.223369259164557e-14, 2.912732056093356e-20
_S1, _S2, _S3, _S4 = -0.16666666666666666, 0.008333333333333316, -0.00019841269841254974, 2.755731921916323e-06
_S5, _S6, _S7 = -2.5052107616995878e-08, 1.6058977312444268e-10, -7.643970296165793e-13
_S8 = 2.73144475909634e-15

# ln 2 in two parts, the first of 41 bits: times an exponent it is exact
_LN2, _LN2_REST = 0.693147180559663, 2.8235290563031577e-13
_HIGHEST, _LOWEST = 710.0, -746.0  # exp overflows above, vanishes below
_E1, _E2, _E3, _E4 = 0.1666666666666667, 0.04166666666666667, 0.008333333333326112, 0.001388888888888373
_E5, _E6, _E7 = 0.0001984126987490126, 2.4801587325605324e-05, 2.7557255297969643e-06
_E8, _E9, _E10 = 2.755727357010214e-07, 2.5105259538448494e-08, 2.0914717341716378e-09

# atanh: 2/3 in two parts, and what follows
_THIRDS, _THIRDS_REST = 0.6666666666666666, 3.700743415417188e-17
_L1, _L2, _L3, _L4 = 0.2857142857142937, 0.222222222216545, 0.1818181833570672, 0.1538459492898411
_L5, _L6, _L7 = 0.133348065173055, 0.11706187518979793, 0.11723689023649227


def bits_of(x: float) -> int:
    """Return the bits of a double as a 64-bit integer."""
    return int(struct.unpack("<q", struct.pack("<d", x))[0])


def float_of(bits: int) -> float:
    """Return the double with these bits."""
    return float(struct.unpack("<d", struct.pack("<Q", bits % 2**64))[0])


def fma(a: float, b: float, c: float) -> float:
    """Return a b + c, rounded once."""
    if not math.isfinite(a * b + c):
        return a * b + c
    return float(Fraction(a) * Fraction(b) + Fraction(c))


def cos(x: float) -> float:
    """Cosine; NaN beyond 3.3e9 rad, where neighbouring floats differ by 5e-7 rad."""
    halves = (x * 0.3183098861837907 - 0.5) + _ROUND
    return -_signed_sine(x, halves, 2.0 * (halves - _ROUND) + 1.0)


def sin(x: float) -> float:
    """Sine; NaN beyond 3.3e9 rad."""
    halves = x * 0.3183098861837907 + _ROUND
    return _signed_sine(x, halves, 2.0 * (halves - _ROUND))


def exp(x: float) -> float:
    """Exponential."""
    return _exp(x, 0.0)


def log(x: float) -> float:
    """Logarithm: -inf at zero, NaN below."""
    k, m = _split(x)
    f = m - 1.0
    s = f / (2.0 + f)
    z = s * s
    half = 0.5 * f * f
    value = k * _LN2 - ((half - (s * (half + z * (_THIRDS + z * _atanh_rest(z))) + k * _LN2_REST)) - f)
    value = value if x > 0.0 else math.nan
    value = -math.inf if x == 0.0 else value
    return x if x == math.inf else value


def tanh(x: float) -> float:
    """Hyperbolic tangent."""
    a = abs(x)
    e = _expm1(2.0 * (20.0 if a > 20.0 else a))  # 1 - tanh 20 is below the last place of 1
    value = e / (e + 2.0)
    return -value if x < 0.0 else value


def sqrt(x: float) -> float:
    """Square root, which is an instruction."""
    return math.sqrt(x)


def sign(x: float) -> float:
    """Sign: -1, 0 or 1."""
    return (1.0 if x > 0 else 0.0) - (1.0 if x < 0 else 0.0)


def power(x: float, y: float) -> float:
    """Return x to the power y: NaN for a negative x and a y that is no whole number."""
    a = abs(x)
    high, low = _log(a)
    product = y * high
    value = _exp(product, fma(y, high, -product) + y * low)
    value = 1.0 if (x == 1.0) | (y == 0.0) else value
    negative = value if _is_integer(0.5 * y) else -value
    negative = negative if _is_integer(y) else math.nan
    return negative if x < 0.0 else value


def _signed_sine(x: float, halves: float, quarters: float) -> float:
    """Sine of x less a number of quarter turns (at most pi/2), negated where the last bit of `halves` is set."""
    r = (((x - quarters * _P1) - quarters * _P2) - quarters * _P3) - quarters * _P4
    z = r * r
    high = _S5 + z * (_S6 + z * (_S7 + z * _S8))
    s = r + r * z * (_S1 + z * (_S2 + z * (_S3 + z * (_S4 + z * high))))
    value = float_of(bits_of(s) ^ (bits_of(halves) << 63))
    return value if abs(x) < _LARGEST else math.nan


def _exp(x: float, tail: float) -> float:
    """Exponential of x + tail, with the tail below the last places of x."""
    n = (x * 1.4426950408889634 + _ROUND) - _ROUND
    r = (x - n * _LN2) + (tail - n * _LN2_REST)
    half = (0.5 * n + _ROUND) - _ROUND  # 2^n in two factors, as it may be subnormal or beyond the largest
    value = (1.0 + (r + r * r * _exp_rest(r))) * _power_of_two(half) * _power_of_two(n - half)
    value = math.inf if x > _HIGHEST else value
    return 0.0 if x < _LOWEST else value


def _expm1(x: float) -> float:
    """Return exp(x) - 1 for x up to 50 in magnitude."""
    n = (x * 1.4426950408889634 + _ROUND) - _ROUND
    high, low = x - n * _LN2, n * _LN2_REST
    r = high - low
    tail = (high - r) - low
    p = r + (r * r * _exp_rest(r) + tail)
    scale = _power_of_two(n)
    return scale * p + (scale - 1.0)


def _exp_rest(r: float) -> float:
    """Return (exp(r) - 1 - r)/r^2 for r up to ln(2)/2 in magnitude."""
    high = _E6 + r * (_E7 + r * (_E8 + r * (_E9 + r * _E10)))
    return 0.5 + r * (_E1 + r * (_E2 + r * (_E3 + r * (_E4 + r * (_E5 + r * high)))))


def _power_of_two(n: float) -> float:
    """Return 2^n for a whole n from -1022 to 1023."""
    return float_of((bits_of(n + _ROUND) + 1023) << 52)


def _split(x: float) -> tuple[float, float]:
    """Exponent k and fraction m, from sqrt(1/2) to sqrt(2), of a positive number x = 2^k m."""
    small = x < 2.2250738585072014e-308
    bits = bits_of(x * 18014398509481984.0 if small else x)
    # The exponent becomes the last bits of a float: vectors of integers have no conversion before AVX-512.
    k = float_of(((bits & 0x7FF0000000000000) >> 52) | 0x4330000000000000) - 4503599627370496.0
    k = k - (1077.0 if small else 1023.0)
    m = float_of((bits & 0x000FFFFFFFFFFFFF) | 0x3FF0000000000000)
    large = m > 1.4142135623730951
    return (k + 1.0 if large else k), (0.5 * m if large else m)


def _atanh_rest(z: float) -> float:
    """Return ((log(m) - 2 s)/s^3 - 2/3)/z where s = (m - 1)/(m + 1), z = s^2, for m from sqrt(1/2) to sqrt(2)."""
    return 0.4 + z * (_L1 + z * (_L2 + z * (_L3 + z * (_L4 + z * (_L5 + z * (_L6 + z * _L7))))))


def _log(x: float) -> tuple[float, float]:
    """Logarithm of a number that is not negative, as a sum of two: relative error 2^-65."""
    k, m = _split(x)
    f = m - 1.0
    d = m + 1.0
    s = f / d
    s_rest = (fma(-s, d, f) - s * (m - (d - 1.0))) / d
    z = s * s
    z_rest = fma(s, s, -z) + 2.0 * s * s_rest
    tail = z * _atanh_rest(z)
    p = _THIRDS + tail
    p_rest = ((_THIRDS - p) + tail) + _THIRDS_REST
    w = z * s
    w_rest = fma(z, s, -w) + (z * s_rest + z_rest * s)
    v = w * p
    v_rest = fma(w, p, -v) + (w * p_rest + w_rest * p)
    a = k * _LN2
    b = a + 2.0 * s
    high = b + v
    low = (((a - b) + 2.0 * s) + ((b - high) + v)) + ((2.0 * s_rest + v_rest) + k * _LN2_REST)
    high = high if x < math.inf else x
    return (-math.inf if x == 0.0 else high), low


def _is_integer(y: float) -> bool:
    """True for a whole number y."""
    a = abs(y)
    return (a >= 4503599627370496.0) | ((a + 4503599627370496.0) - 4503599627370496.0 == a)


def functions() -> dict[Any, Any]:
    """Functions of `maths` and those inside them, with the functions above that compiled code runs in their place."""
    faces = (cos, sin, exp, log, tanh, sqrt, sign, power)
    inner = (_signed_sine, _exp, _expm1, _exp_rest, _power_of_two, _split, _atanh_rest, _log, _is_integer)
    return {function: function for function in inner} | {getattr(maths, face.__name__): face for face in faces}


def bodies(types: Any) -> dict[Any, Any]:
    """Bodies in compiled code of the three primitives above."""

    def cast(to: Any, given: Any) -> Any:
        def build(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            return builder.bitcast(arguments[0], context.get_value_type(to))

        return to(given), build

    def typed_bits(context: Any, x: Any) -> Any:
        return cast(types.int64, types.float64)

    def typed_float(context: Any, bits: Any) -> Any:
        return cast(types.float64, types.int64)

    def typed_fma(context: Any, a: Any, b: Any, c: Any) -> Any:
        def build(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            return builder.fma(*arguments)

        return types.float64(types.float64, types.float64, types.float64), build

    return {bits_of: typed_bits, float_of: typed_float, fma: typed_fma}
