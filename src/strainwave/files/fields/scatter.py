"""The groups `scatter` and `scatter_correlation` of a project file: numbers that vary from drive to drive."""

import re
from dataclasses import dataclass
from typing import Any

import numpy as np

from .kinds import Items, Kind, NotA, Place, Quantity, Schema, number, read

MOST_SCATTER = 0.3  # beyond it a normal distribution has values near zero
MOST_OF_PHASE = 1.0  # rad
SAME, NO_VARIANCE = 1e-9, 1e-5  # of correlations: equal, and what their rounding may do to a variance


class Radians(float):
    """Standard deviation of a phase [rad], which has no size of its own; those of other numbers are relative."""


@dataclass(frozen=True)
class Deviation(Kind):
    """A standard deviation: relative to the number itself, or the angle of a phase."""

    def read(self, value: Any, place: Place) -> Any:
        try:
            share = number(value, "", "positive")
        except ValueError:
            if not (isinstance(value, str) and re.search(r"[A-Za-z°]\s*$", value)):
                raise
            angle = number(value, "rad", "positive")
            if angle > MOST_OF_PHASE:
                said = f"{value!r} is more than {MOST_OF_PHASE:g} rad; write one standard deviation"
                raise ValueError(said) from None
            return Radians(angle)
        if share > MOST_SCATTER:
            raise ValueError(f"{value!r} is more than {100 * MOST_SCATTER:g} %; write one standard deviation, as 5 %")
        return share

    def schema(self) -> Schema:
        share = Quantity("", "positive", ends=(("maximum", MOST_SCATTER),))
        return {"anyOf": [share.schema(), Quantity("rad", "positive").schema()]}

    def text(self, value: Any) -> str:
        return f"{float(value)!r} rad" if isinstance(value, Radians) else repr(value)


@dataclass(frozen=True)
class Scatter(Kind):
    """Standard deviations by names."""

    def read(self, value: Any, place: Place) -> Any:
        if not isinstance(value, dict):
            raise NotA("a group of fields")
        if not 1 <= len(value) <= 32:
            raise ValueError(f"has {len(value)} items; write at {'most 32' if value else 'least 1'}")
        return {key: read(Deviation(), item, place.at(key)) for key, item in value.items()}

    def schema(self) -> Schema:
        return {"type": "object", "additionalProperties": Deviation().schema(), "minProperties": 1, "maxProperties": 32}

    def text(self, value: Any) -> str:
        return "{" + ", ".join(f"{key}: {Deviation().text(item)}" for key, item in value.items()) + "}"


@dataclass(frozen=True)
class Correlation(Kind):
    """A correlation matrix: equal on both sides of its diagonal of ones, and no variance below zero."""

    def read(self, rows: Any, place: Place) -> tuple[tuple[float, ...], ...]:
        if not isinstance(rows, list) or not all(isinstance(row, list) for row in rows):
            raise ValueError("is no list of rows; write for example [[1, -0.5], [-0.5, 1]]")
        given = tuple(tuple(number(value, "") for value in row) for row in rows)
        if any(len(row) != len(given) for row in given):
            raise ValueError(
                f"has {len(given)} rows, not all with {len(given)} numbers; write one for each of 'scatter'"
            )
        matrix = np.array(given)
        if np.any(np.abs(matrix - matrix.T) > SAME) or np.any(np.abs(np.diag(matrix) - 1.0) > SAME):
            raise ValueError(
                "is not the same on both sides of a diagonal of ones; write for example [[1, -0.5], [-0.5, 1]]"
            )
        if len(given) and (least := float(np.linalg.eigvalsh(matrix)[0])) < -NO_VARIANCE:
            raise ValueError(
                f"gives a sum of the numbers a variance of {least:.2g}, below zero; write smaller correlations"
            )
        return given

    def schema(self) -> Schema:
        return Items(Items(Quantity())).schema()

    def text(self, value: Any) -> str:
        return repr([list(row) for row in value])
