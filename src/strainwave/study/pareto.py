"""Pareto front: what no other beats in all of several numbers at once."""

from collections.abc import Iterable


def unbeaten(marks: Iterable[tuple[float, ...]]) -> list[tuple[float, ...]]:
    """Marks, rising, than which no other is as small in every number; equal ones once."""
    best: list[tuple[float, ...]] = []
    for mark in sorted(marks):  # whatever beats another comes before it
        if not any(all(a <= b for a, b in zip(other, mark, strict=True)) for other in best):
            best.append(mark)
    return best
