"""A response curve with more points than were computed: between those its harmonics follow a smooth curve."""

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ..base.results import Floats
from ..base.series import largest_size
from ..drive.drive_response import DriveResponse

if TYPE_CHECKING:
    pass

PARTS = 5  # of each step
SHORTEST = 1e-9  # step along the arc, of the curve's extent


def fine(response: DriveResponse) -> DriveResponse:
    """Draw a curve with cubics between its points.

    Speed and harmonics are smooth along the arc where the largest |x| has corners, so they are what is interpolated,
    and with them the sizes of motions that beat. Computed points stay what they are.
    """
    curve = response.curve
    if len(curve) < 3:
        return response
    waves, table = curve.coefficients.shape[1], curve.coefficients
    if curve.envelope is not None:
        table = np.column_stack([table, curve.envelope, curve.peak])
    speed, size = np.ptp(curve.omega), np.max(np.ptp(table, axis=0))
    if not (speed > 0.0 and size > 0.0):
        return response
    scales = np.array([speed, *[size] * table.shape[1]])
    points = _between(np.column_stack([curve.omega, table]) / scales) * scales
    points[::PARTS] = np.column_stack([curve.omega, table])
    seams = np.diff(curve.omega) == 0.0  # of two arcs, between which no line is drawn
    points[1:].reshape(-1, PARTS, points.shape[1])[seams, :-1] = np.nan
    coefficients, envelope, peak = points[:, 1 : waves + 1], points[:, waves + 1 : -1], points[:, -1]
    if curve.envelope is None:
        peak = largest_size(coefficients)
        peak[::PARTS] = curve.peak
    steps = np.arange(len(points)) // PARTS  # a step is drawn as its first point is
    drawn = replace(
        curve, values=points[:, 0], omega=points[:, 0], coefficients=coefficients, peak=peak,
        multipliers=curve.multipliers[steps], stable=curve.stable[steps],
        envelope=None if curve.envelope is None else envelope, waves=None,
    )  # fmt: skip
    return replace(response, curve=drawn)


def _between(points: Floats) -> Floats:
    """Points (rows) with others between them, evenly along the chord."""
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    arc = np.concatenate([[0.0], np.cumsum(np.maximum(steps, SHORTEST))])
    h, rise = np.diff(arc)[:, None], np.diff(points, axis=0)
    slope = rise / h
    # Tangents of the cubic spline: its curvature has no jumps; at the ends those of parabolas through three points.
    matrix, right = np.eye(len(points)), np.empty_like(points)
    i = np.arange(1, len(points) - 1)
    matrix[i, i - 1], matrix[i, i], matrix[i, i + 1] = h[1:, 0], 2.0 * (h[1:, 0] + h[:-1, 0]), h[:-1, 0]
    right[i] = 3.0 * (h[1:] * slope[:-1] + h[:-1] * slope[1:])
    right[0] = slope[0] - h[0] * (slope[1] - slope[0]) / (h[0] + h[1])
    right[-1] = slope[-1] + h[-1] * (slope[-1] - slope[-2]) / (h[-1] + h[-2])
    tangents = np.linalg.solve(matrix, right)
    s = (np.arange(PARTS) / PARTS)[:, None]
    start, end = (h * tangents[:-1] - rise)[:, None], (h * tangents[1:] - rise)[:, None]
    among = points[:-1, None] + s * (rise[:, None] + (1.0 - s) * (start * (1.0 - s) - end * s))
    return np.concatenate([among.reshape(-1, points.shape[1]), points[-1:]])
