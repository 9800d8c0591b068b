"""Choices between numbers without a branch, so that compiled loops over lanes stay vector code.

A place in a tuple is a whole number from 0 on as a float, or what stands for one and has `entry` and `with_entry`.
"""

from typing import Any

import numpy as np

from ..compile.jit import kernel, kernel_as
from ..compile.tree import with_leaf


@kernel_as(lambda condition, a, b: a if condition else b, inline=True)
def select(condition: Any, a: Any, b: Any) -> Any:
    """The value a where the condition holds, else b; of numbers, or item by item of arrays."""
    return np.where(condition, a, b)


@kernel
def larger(a: Any, b: Any) -> Any:
    """The larger of two numbers, or of the items of two arrays; b where a is NaN."""
    return select(a > b, a, b)


@kernel
def smaller(a: Any, b: Any) -> Any:
    """The smaller of two numbers, or of the items of two arrays; b where a is NaN."""
    return select(a < b, a, b)


@kernel_as(lambda items, place: items[int(place)], inline=True)
def entry(items: Any, place: Any) -> Any:
    """Number at a place in a tuple of numbers."""
    return place.entry(items) if hasattr(place, "entry") else items[int(place)]


@kernel_as(lambda items, place, value: with_leaf(items, int(place), value), inline=True)
def with_entry(items: Any, place: Any, value: object) -> Any:
    """The tuple of numbers with another one at a place."""
    return place.with_entry(items, value) if hasattr(place, "entry") else with_leaf(items, int(place), value)
