"""Where a label beside a point of a figure crosses the fewest lines."""

from collections.abc import Sequence

import numpy as np

from ...results import Floats

ROW, GAP = 12.0, 9.0  # height of the text, and its distance from the point [px]
STEP = 2.0  # between the points at which a line is looked at [px]


def beside(
    u: float, v: float, width: float, lines: Sequence[tuple[Floats, Floats]], panel: float = np.inf
) -> tuple[float, float, str]:  # fmt: skip
    """Place [px] and anchor of a text of a width [px] beside the point (u, v), on the emptiest of four sides.

    Parameters
    ----------
    u, v : float
        The point, v downwards [px].
    width : float
        Of the text [px].
    lines : sequence of (x, y)
        Polylines of the panel [px].
    panel : float
        Width of the panel [px], which a text leaves only if it fits on no side.
    """
    middle = v + ROW / 3.0
    places = (
        (u + GAP, middle, "start"),
        (u - GAP, middle, "end"),
        (u, v - GAP, "middle"),
        (u, v + GAP + ROW, "middle"),
    )
    shift = {"start": 0.0, "end": -width, "middle": -width / 2.0}

    def costs(place: tuple[float, float, str]) -> tuple[bool, int]:
        left = place[0] + shift[place[2]]
        return left < 0.0 or left + width > panel, _crossed(left, place[1], width, lines)

    return min(places, key=costs)


def _crossed(left: float, base: float, width: float, lines: Sequence[tuple[Floats, Floats]]) -> int:
    """How many points of the lines lie in the box of a text."""
    return sum(
        int(np.sum((x > left) & (x < left + width) & (y > base - ROW) & (y < base + 3.0)))
        for x, y in (_dense(*line) for line in lines)
    )


def _dense(x: Floats, y: Floats) -> tuple[Floats, Floats]:
    """A polyline with points so near that none of it slips through a text."""
    far = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(x), np.diff(y)))])
    at = np.arange(0.0, far[-1] + STEP, STEP)
    return np.interp(at, far, x), np.interp(at, far, y)
