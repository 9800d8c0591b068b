"""Choices between numbers without a branch, so that compiled loops over lanes stay vector code."""

from typing import Any

import numpy as np

from ..compile.jit import kernel_as


def _larger_loops(a: Any, b: Any) -> Any:
    return a if a > b else b


@kernel_as(_larger_loops, inline=True)
def larger(a: Any, b: Any) -> Any:
    """The larger of two numbers, or of the items of two arrays; b where a is NaN."""
    return np.where(a > b, a, b)


def _select_loops(condition: Any, a: Any, b: Any) -> Any:
    return a if condition else b


@kernel_as(_select_loops, inline=True)
def select(condition: Any, a: Any, b: Any) -> Any:
    """The value a where the condition holds, else b."""
    return np.where(condition, a, b)


def _smaller_loops(a: Any, b: Any) -> Any:
    return a if a < b else b


@kernel_as(_smaller_loops, inline=True)
def smaller(a: Any, b: Any) -> Any:
    """The smaller of two numbers, or of the items of two arrays; b where a is NaN."""
    return np.where(a < b, a, b)
