"""Doubts about a log: channels that contradict each other, saturate, or do not move; with the likely reason."""

from math import isclose, pi

import numpy as np

from ...base.results import Floats
from ...study.identification.log import Log
from ...study.identification.run import saturated

SPEED_TOLERANCE = 0.2  # relative: angle and integral of the speed
FACTOR_TOLERANCE = 0.03  # relative: to a factor between units
SLOW_STEP_S = 3600.0  # a sample of a log of a drive is shorter
MOTION_RAD = 1e-5  # rad: less is no motion
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
    """Sentences on implausible channels."""
    sentences = []
    if log.step > SLOW_STEP_S:
        sentences.append(f"time goes on by {log.step:.4g} s a sample: is it in ms, us or ns? units={{'time': 'ms'}}")
    for shaft in ("motor", "load"):
        if (angle := log.channels.get(f"{shaft}_angle")) is not None:
            sentences += [*_motion(log, shaft, angle), *_jumps(log, f"{shaft}_angle", angle)]
    for name in log.channels:
        sentences += _saturation(log, name)
    return tuple(sentences)


def _motion(log: Log, shaft: str, angle: Floats) -> list[str]:
    """Sentence on an angle that stands still, or that does not grow as its speed says."""
    if float(np.ptp(angle)) < MOTION_RAD:
        return [f"{shaft}_angle stays within {np.ptp(angle):.2g} rad: nothing moves"]
    speed = log.channels.get(f"{shaft}_speed")
    return [] if speed is None else _growth(log, shaft, angle, speed)


def _saturation(log: Log, name: str) -> list[str]:
    """Sentences on a channel, none of an angle or a speed, that stays at its largest or its least value."""
    unit = log.units[name]
    levels = [] if unit in ("rad", "rad/s") else saturated(log.channels[name])
    return [
        f"{name} has its {extreme} value, {level:.6g} {unit}, in {100.0 * share:.2g} % of the samples: saturated?"
        for level, extreme, share in levels
    ]


def _growth(log: Log, shaft: str, angle: Floats, speed: Floats) -> list[str]:
    """Sentence on an angle that does not grow as its speed says."""
    steps = np.diff(log.time)
    integral = np.append(0.0, np.cumsum(0.5 * (speed[1:] + speed[:-1]) * steps))
    far = integral - np.mean(integral)
    if np.dot(far, far) == 0.0:
        return [f"{shaft}_speed is 0 throughout and {shaft}_angle moves; is it the right column?"]
    factor = float(np.dot(far, angle) / np.dot(far, far))
    if abs(factor - 1.0) <= SPEED_TOLERANCE:
        return []
    fact = f"{shaft}_angle grows {factor:.4g} times as fast as {shaft}_speed says"
    for ratio, kind, unit in FACTORS:
        if isclose(abs(factor), ratio, rel_tol=FACTOR_TOLERANCE):
            name = "time" if kind == "time" else f"{shaft}_{kind}"
            return [f"{fact}: {name} is probably in {unit}, units={{{name!r}: {unit!r}}}"]
    if isclose(factor, -1.0, rel_tol=FACTOR_TOLERANCE):
        return [f"{fact}: their directions differ"]
    large = max(abs(factor), 1.0 / abs(factor)) if factor else 0.0
    if 20.0 < large < 400.0 and abs(large - round(large)) < 0.02 * large:
        return [f"{fact}: they may be on both sides of a gear of ratio {round(large)}"]
    return [f"{fact}: check their units and columns"]


def _jumps(log: Log, name: str, angle: Floats) -> list[str]:
    """Sentence on an angle that jumps by more than half a turn from sample to sample."""
    steps = np.abs(np.diff(angle))
    steps = steps[(np.diff(log.time) < 1.5 * log.step) & (steps > pi)]
    if not len(steps):
        return []
    size = float(np.median(steps))
    if isclose(size, 360.0, rel_tol=0.05):
        return [f"{name} jumps by {size:.4g} rad: it is probably in deg, units={{{name!r}: 'deg'}}"]
    return [f"{name} jumps by more than half a turn {len(steps)} times: check its unit, or sample faster"]
