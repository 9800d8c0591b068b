"""Choices between numbers without a branch, so that compiled loops over lanes stay vector code.

An index in a tuple is a whole number from 0 on, as a float, or an object that stands for one in recorded code and has
`entry` and `with_entry`.
"""

from typing import Any

import numpy as np

from .jit import kernel, kernel_as
from .tree import with_leaf


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


@kernel_as(lambda items, index: items[int(index)], inline=True)
def entry(items: Any, index: Any) -> Any:
    """Number at an index in a tuple of numbers."""
    return index.entry(items) if hasattr(index, "entry") else items[int(index)]


@kernel_as(lambda items, index, value: with_leaf(items, int(index), value), inline=True)
def with_entry(items: Any, index: Any, value: object) -> Any:
    """The tuple of numbers with another one at an index."""
    return index.with_entry(items, value) if hasattr(index, "entry") else with_leaf(items, int(index), value)
