"""Tuples of numbers of any length: states, rates of states, and what is made of them.

Compiled code has them number by number: a loop or a recursion over a tuple, which comes to the same, would take the
compiler many times as long.
"""

from collections.abc import Callable
from typing import Any


def axpy(y: Any, h: Any, k: Any) -> Any:
    """Return y + h k for tuples y and k of equal length and a number h."""
    if len(y) == 2:  # the usual case, four times faster than the general one
        return y[0] + h * k[0], y[1] + h * k[1]
    return tuple(a + h * b for a, b in zip(y, k, strict=True))


def times(h: Any, k: Any) -> Any:
    """Tuple of h times the numbers of a tuple."""
    return tuple([h * b for b in k])


def alike(y: Any, value: Any) -> Any:
    """Tuple as long as y of equal values."""
    return (value,) * len(y)


def bodies(types: Any, extending: Any) -> dict[Any, Any]:
    """What compiled code runs instead of the functions above, by these modules of a compiler."""
    real = types.float64

    def made(values: Callable[..., list[Any]]) -> Any:
        """Function of compiled code that makes the tuple of `values` of a tuple, a number and a tuple."""

        def build(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            def floats(kind: Any, thing: Any) -> Any:
                if isinstance(kind, types.BaseTuple):
                    return [floats(k, builder.extract_value(thing, i)) for i, k in enumerate(kind)]
                return context.cast(builder, thing, kind, real)

            numbers = values(builder, *map(floats, signature.args, arguments))
            return context.make_tuple(builder, signature.return_type, numbers)

        def typed(context: Any, y: Any, h: Any, k: Any) -> Any:
            return types.BaseTuple.from_types([real] * len(y))(y, h, k), build

        return extending.intrinsic(typed)

    sums = made(lambda builder, y, h, k: [builder.fadd(a, builder.fmul(h, b)) for a, b in zip(y, k, strict=True)])
    products = made(lambda builder, y, h, k: [builder.fmul(h, b) for b in k])
    copies = made(lambda builder, y, h, k: [h] * len(y))
    return {
        axpy: lambda y, h, k: sums(y, h, k),
        times: lambda h, k: products(k, h, k),
        alike: lambda y, value: copies(y, value, y),
    }
