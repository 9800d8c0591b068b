"""Doubts about a log: channels that contradict each other, saturate, or do not move; with the likely reason."""

from itertools import groupby
from math import isclose, pi

import numpy as np

from ...results import Floats
from ...study.identification.logs.log import Log

AGREES = 0.2  # relative: angle and integral of the speed
CLOSE = 0.03  # relative: to a factor between units
STILL = 1e-5  # rad: less is no motion
CLIPPED, LONGEST = 0.005, 3  # share of the samples at an extreme value, samples in a row there
# What an angle grows relative to the integral of the speed when one of them is in another unit than was read.
FACTORS = (
    (180.0 / pi, "angle", "deg"),
    (pi / 180.0, "speed", "deg/s"),
    (pi / 30.0, "speed", "rpm"),
    (30.0 / pi, "speed", "rad/s"),
    (1.0 / (2.0 * pi), "angle", "rev"),
    (2.0 * pi, "speed", "rev/s"),
    (6.0, "angle", "deg"),  # and the speed in rpm
    (1e-3, "time", "ms"),
    (1e-6, "time", "us"),
    (1e3, "time", "s"),
)


def doubts(log: Log) -> tuple[str, ...]:
    """What is not plausible, a sentence each."""
    found = []
    for shaft in ("motor", "load"):
        angle, speed = (log.channels.get(f"{shaft}_{kind}") for kind in ("angle", "speed"))
        if angle is not None and float(np.ptp(angle)) < STILL:
            found.append(f"{shaft}_angle stays within {np.ptp(angle):.2g} rad: nothing moves")
        elif angle is not None and speed is not None:
            found += _grows(log, shaft, angle, speed)
        if angle is not None:
            found += _jumps(log, f"{shaft}_angle", angle)
    for name, values in log.channels.items():
        found += _saturated(name, values, log.units[name])
    return tuple(found)


def _grows(log: Log, shaft: str, angle: Floats, speed: Floats) -> list[str]:
    """Whether an angle grows as its speed says."""
    steps = np.diff(log.time)
    integral = np.append(0.0, np.cumsum(0.5 * (speed[1:] + speed[:-1]) * steps))
    far = integral - np.mean(integral)
    if np.dot(far, far) == 0.0:
        return [f"{shaft}_speed is 0 throughout and {shaft}_angle moves; is it the right column?"]
    factor = float(np.dot(far, angle) / np.dot(far, far))
    if abs(factor - 1.0) <= AGREES:
        return []
    said = f"{shaft}_angle grows {factor:.4g} times as fast as {shaft}_speed says"
    for known, kind, unit in FACTORS:
        if isclose(abs(factor), known, rel_tol=CLOSE):
            name = "time" if kind == "time" else f"{shaft}_{kind}"
            return [f"{said}: {name} is probably in {unit}, units={{{name!r}: {unit!r}}}"]
    if isclose(factor, -1.0, rel_tol=CLOSE):
        return [f"{said}: their directions differ"]
    large = max(abs(factor), 1.0 / abs(factor)) if factor else 0.0
    if 20.0 < large < 400.0 and abs(large - round(large)) < 0.02 * large:
        return [f"{said}: they may be on the two sides of a gear of ratio {round(large)}"]
    return [f"{said}: check their units and columns"]


def _jumps(log: Log, name: str, angle: Floats) -> list[str]:
    steps = np.abs(np.diff(angle))
    steps = steps[(np.diff(log.time) < 1.5 * log.step) & (steps > pi)]
    if not len(steps):
        return []
    size = float(np.median(steps))
    if isclose(size, 360.0, rel_tol=0.05):
        return [f"{name} jumps by {size:.4g} rad: it is probably in deg, units={{{name!r}: 'deg'}}"]
    return [f"{name} jumps by more than half a turn {len(steps)} times: check its unit, or sample faster"]


def _saturated(name: str, values: Floats, unit: str) -> list[str]:
    """Whether many samples in a row have exactly the largest or the smallest value of a torque, a current, a signal."""
    if unit in ("rad", "rad/s"):
        return []
    said = []
    levels, counts = np.unique(values, return_counts=True)
    if len(levels) < 10:  # a switch, or a channel that is constant
        return []
    for place, beside, which in ((0, 1, "smallest"), (-1, -2, "largest")):
        level, count = float(levels[place]), int(counts[place])
        if level == 0.0 or count < CLIPPED * len(values) or count < 5 * counts[beside]:
            continue
        longest = max(sum(1 for _ in run) for at, run in groupby(values == level) if at)
        if longest >= LONGEST:
            share = 100.0 * count / len(values)
            said.append(
                f"{name} has its {which} value, {level:.6g} {unit}, in {share:.2g} % of the samples: saturated?"
            )
    return said
