"""Functions of numbers as functions of arrays: loops over the entries in machine code, NumPy as Python."""

import inspect
from collections.abc import Callable
from typing import Any

from .jit import chosen, kernel, kernel_as


def _itself(thing: Any, i: Any) -> Any:
    return thing


def _item(thing: Any, i: Any) -> Any:
    return thing[i]


@chosen
def _entry(thing: Any, i: Any) -> Any:
    return _item if hasattr(thing, "ndim") else _itself


def elementwise(function: Callable[..., Any]) -> Callable[..., None]:
    """Make of a function of numbers one that writes its values to its last argument, an array.

    The one or two others are arrays of that length, or numbers and models, which are the same for all entries. As
    Python the function is given whole arrays, in compiled code their entries one by one.
    """

    def two(a: Any, values: Any) -> None:
        for i in range(values.shape[0]):
            values[i] = function(_entry(a, i), values[i])

    def three(a: Any, b: Any, values: Any) -> None:
        for i in range(values.shape[0]):
            values[i] = function(_entry(a, i), _entry(b, i), values[i])

    def on_arrays(*args: Any) -> None:
        args[-1][:] = function(*args)

    kernel(function)
    on_arrays.__doc__ = function.__doc__
    return kernel_as(two if len(inspect.signature(function).parameters) == 2 else three)(on_arrays)


def summed(numpy: Callable[[Any, Any], Any]) -> Callable[[Callable[[Any, Any], Any]], Callable[[Any, Any], float]]:
    """Make of a function of two numbers its sum over the entries of two vectors; as Python `numpy` gives it."""

    def mark(function: Callable[[Any, Any], Any]) -> Callable[[Any, Any], float]:
        def loops(a: Any, b: Any) -> float:
            total = 0.0
            for i in range(a.shape[0]):
                total += function(a[i], b[i])
            return total

        def on_vectors(a: Any, b: Any) -> float:
            return float(numpy(a, b))

        kernel(function)
        on_vectors.__doc__ = function.__doc__
        return kernel_as(loops)(on_vectors)

    return mark
