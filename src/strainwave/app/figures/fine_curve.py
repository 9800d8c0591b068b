"""A response curve with more points, for figures: between those computed its harmonics follow a smooth curve."""

from dataclasses import replace

import numpy as np

from ...numerics.balance.fourier import synthesis, to_blocks
from ...results import Floats
from ...study.response.response import ExactResponse

PARTS, SAMPLES = 5, 128  # of each step, and of the period of the highest harmonic
SHORTEST = 1e-9  # step along the arc, of the curve's extent


def fine(response: ExactResponse) -> ExactResponse:
    """Draw a curve with cubics between its points.

    Speed and harmonics are smooth along the arc where the largest |x| has corners, so they are what is interpolated.
    Computed points stay what they are.
    """
    curve = response.curve
    if len(curve) < 3:
        return response
    speed, size = np.ptp(curve.omega), np.max(np.ptp(curve.coefficients, axis=0))
    if not (speed > 0.0 and size > 0.0):
        return response
    found = _between(np.column_stack([curve.omega / speed, curve.coefficients / size])) * np.array(
        [speed, *[size] * curve.coefficients.shape[1]]
    )
    found[::PARTS] = np.column_stack([curve.omega, curve.coefficients])
    series = to_blocks(found[:, 1:].T).T
    peak = np.max(np.abs(series @ synthesis(series.shape[1] // 2, SAMPLES * (series.shape[1] // 2))), axis=1)
    peak[::PARTS] = curve.peak
    own = np.arange(len(found)) // PARTS  # a step is drawn as its first point is
    drawn = replace(
        curve, values=found[:, 0], omega=found[:, 0], coefficients=found[:, 1:], peak=peak,
        multipliers=curve.multipliers[own], stable=curve.stable[own],
    )  # fmt: skip
    return replace(response, curve=drawn)


def _between(points: Floats) -> Floats:
    """Points (rows) with others between them, evenly along the chord."""
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    place = np.concatenate([[0.0], np.cumsum(np.maximum(steps, SHORTEST))])
    h, rise = np.diff(place)[:, None], np.diff(points, axis=0)
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
