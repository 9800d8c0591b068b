"""Corners: base angles [rad; s where omega is 1] at which a function of the base angle jumps or changes its slope.

A part of a system that does not repeat, a profile of torque or of speed, lists them: `corners()`, a tuple. The
integration takes the stretches between them one by one: a step ends just before a corner, where the function still is
what it was, and the next begins just after it.
"""

from typing import Any

import numpy as np

from ...base.protocols import lacking
from ...base.quantities import shown

NEXT = 16.0  # distance to a corner on either side, in units of the rounding of times


def corners_of(model: Any) -> tuple[float, ...]:
    """Corners of a model and of the models in its fields; a model that lists its own speaks for its fields too."""
    if not lacking(model, "corners"):
        return _listed(model)
    return tuple(corner for item in model if isinstance(item, tuple) for corner in corners_of(item))


def repeating(verb: str, system: Any) -> Any:
    """Return the system, or refuse one that does not repeat with every turn of the base angle (ValueError)."""
    if found := corners_of(system):
        raise ValueError(
            f"{type(system).__name__} has a profile with corners at {shown(found)} s and does not repeat; {verb} takes "
            "what repeats with every turn of the base angle: use simulate or drive_run"
        )
    return system


def _listed(model: Any) -> tuple[float, ...]:
    corners = model.corners()
    try:
        listed = tuple(float(corner) for corner in corners)
    except (TypeError, ValueError):
        listed = (np.nan,)
    if not np.all(np.isfinite(listed)):
        name = type(model).__name__
        raise ValueError(f"{name}.corners() gives {shown(corners)}; it must give a tuple of finite base angles")
    return listed


def stretches(system: Any, omega: float, start: float, end: float) -> list[tuple[float, float]]:
    """Spans of time [s] from start to end in which the system has no corner, each just inside its corners."""
    corners = np.array(corners_of(system), float)
    if omega == 0.0 or not len(corners):
        return [(start, end)]
    margin = NEXT * float(np.spacing(max(abs(start), abs(end))))
    times = np.sort(corners / omega)
    times = times[(times > start - margin) & (times < end + margin)]
    spans: list[tuple[float, float]] = []
    begin = start
    for time in times.tolist():
        if time - margin > begin + 2.0 * margin:
            spans.append((begin, time - margin))
        begin = max(begin, time + margin)
    if end > begin + 2.0 * margin:
        spans.append((begin, end))
    return spans


def across(system: Any, omega: float, t: float, y: Any, begin: float) -> tuple[float, Any, Any]:
    """Time, state and rates just after a corner, from the state y just before it, at t."""
    rate = system.rhs(omega * begin, y)
    y = tuple(float(value + (begin - t) * change) for value, change in zip(y, rate, strict=True))
    return begin, y, tuple(float(change) for change in rate)
