"""Maps as curves of a panel: cells in shades of grey, and lines of equal height."""

from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from ...results import Floats
from ..figures.svg import Curve

STEPS = 12  # shades
LIGHTEST, DARKEST = 0xFA, 0x50


def shades(x: Floats, y: Floats, values: Floats, ends: Sequence[Any]) -> list[Curve]:
    """Bands of cells with one shade; values (rows, columns) between edges x (columns+1,) and y (rows+1,)."""
    low = np.nanmin(values) if ends[0] is None else ends[0]
    high = np.nanmax(values) if ends[1] is None else ends[1]
    share = (values - low) / ((high - low) or 1.0)
    level = np.where(np.isfinite(share), np.clip(share, 0.0, 1.0) * (STEPS - 1), -1.0).round().astype(int)
    out = []
    for row, (bottom, top) in zip(level, pairwise(y), strict=True):
        cuts = [0, *(np.flatnonzero(np.diff(row)) + 1).tolist(), len(row)]
        for a, b in pairwise(cuts):
            if row[a] >= 0:
                grey = round(LIGHTEST + (DARKEST - LIGHTEST) * int(row[a]) / (STEPS - 1))
                band = np.array([x[a], x[b]]), np.full(2, bottom), f"#{3 * f'{grey:02x}'}"
                out.append(Curve(*band, upper=np.full(2, top)))
    return out


def contours(x: Floats, y: Floats, height: Floats, levels: Sequence[float]) -> Iterator[tuple[Floats, Floats]]:
    """Lines on which a height (rows, columns) over x (columns,) and y (rows,) has a level, cell by cell.

    Each line crosses one triangle of half a cell, in which the height is linear.
    """
    for level in levels:
        for i in range(len(y) - 1):
            for j in range(len(x) - 1):
                corners = [(x[j + a], y[i + b], height[i + b, j + a] - level) for b in (0, 1) for a in (0, 1)]
                for three in ((0, 1, 3), (0, 2, 3)):
                    ends = list(_crossings([corners[k] for k in three]))
                    if len(ends) == 2:
                        yield np.array([ends[0][0], ends[1][0]]), np.array([ends[0][1], ends[1][1]])


def _crossings(corners: list[tuple[float, float, float]]) -> Iterator[tuple[float, float]]:
    """Places on the sides of a triangle where the third number changes its sign."""
    for (x0, y0, h0), (x1, y1, h1) in zip(corners, corners[1:] + corners[:1], strict=True):
        if (h0 < 0.0) != (h1 < 0.0):
            share = h0 / (h0 - h1)
            yield x0 + share * (x1 - x0), y0 + share * (y1 - y0)
