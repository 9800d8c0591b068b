"""Choices between numbers without a branch, so that compiled loops over lanes stay vector code."""

from typing import Any

import numpy as np

from .compile.jit import kernel, kernel_as


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
