"""When a speed is forbidden: a limit on the oscillation, on its amplification, or a margin from the resonances.

Intervals are arrays (n, 2) of speeds [rad/s], ascending and apart.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...quantities import number
from ...results import Floats
from ..analysis.avoid import AMPLIFIED, merged
from ..analysis.load_range import hulls_between
from .motions import MOTOR, OMEGA, OSCILLATION, UnderLoad

MARGIN = 0.1  # separation margin of torsional trains: 10 % (API 617 after Wang, Feese & Pettinato 2012)

SHARP = 1e-3  # relative width within which a motion at a fold may be found stable or not

Span = tuple[float, float]


@dataclass(frozen=True)
class Rules:
    """What forbids a speed; None is no rule.

    Attributes
    ----------
    limit : float or None
        Largest oscillation of the error [rad] that is allowed.
    amplification : float or None
        Largest oscillation that is allowed, relative to that of quasi-static rotation.
    margin : float or None
        Separation margin: no speed is nearer than this share to a resonance, from where its backbone begins to where
        its peak lies.
    speed, motor_torque : float or None
        Largest speed of the motor [rad/s], of its gear or its own, where the map goes beyond it, and largest torque of
        the motor [N*m].
    """

    limit: float | None = None
    amplification: float | None = None
    margin: float | None = None
    speed: float | None = None
    motor_torque: float | None = None

    def level(self, quasi_static: float) -> float:
        """Oscillation [rad] from which on a speed is forbidden."""
        amplified = np.inf if self.amplification is None else self.amplification * quasi_static
        return min(np.inf if self.limit is None else self.limit, amplified)


def rules_of(limit: float | None, amplification: float | None, margin: float | None, own: float | None) -> Rules:
    """Rules from the arguments of the verb, or the project's own limit; by themselves twice the quasi-static error."""
    limit = None if limit is None else number("limit [rad]", limit, positive=True)
    amplification = None if amplification is None else number("amplification", amplification, positive=True)
    margin = None if margin is None else number("margin", margin, positive=True)
    if margin is not None and not margin < 1.0:
        raise ValueError(f"margin is {margin:g}; it is a share of the speed and must be less than 1, as 0.1 for 10 %")
    if limit is None and amplification is None and margin is None:
        return Rules(limit=own) if own is not None else Rules(amplification=AMPLIFIED)
    return Rules(limit, amplification, margin)


class Bands(NamedTuple):
    """Forbidden and allowed speeds under one load."""

    forbidden: Floats
    allowed: Floats


def bands_of(under: UnderLoad, rules: Rules, span: Span, resonances: list[Span], apart: float) -> Bands:
    """Apply the rules to all stable motions under a load.

    Parameters
    ----------
    under : UnderLoad
        The motions.
    rules : Rules
        What is forbidden.
    span : (float, float)
        Range of speeds [rad/s].
    resonances : list of (float, float)
        Speeds [rad/s] over which each resonance bends, for the margin.
    apart : float
        Distance of the speeds that were searched, relative to each: how far a motion that no curve has may reach.
    """
    level = rules.level(under.quasi_static)
    found: list[Span] = [band for run, _ in under.runs for band in above(run, level)]
    found += gaps([(run[0, OMEGA], run[-1, OMEGA]) for run, _ in under.runs], span)
    found += [(w / (1.0 + apart), w * (1.0 + apart)) for w, size, _, _ in under.loose if size > level]
    if rules.motor_torque is not None:
        found += [band for run, _ in under.runs for band in above(run, rules.motor_torque, MOTOR)]
    if rules.speed is not None:
        found.append((rules.speed, span[1]))
    if rules.margin is not None:
        found += [((1.0 - rules.margin) * low, (1.0 + rules.margin) * high) for low, high in resonances]
    forbidden = clipped(found, span)
    return Bands(forbidden, complement(forbidden, span))


def above(run: Floats, level: float, what: int = OSCILLATION) -> list[Span]:
    """Bands of a run in which the oscillation, or another column, is above a level; ends by linear interpolation."""
    omega, over = run[:, OMEGA], run[:, what] - level
    edges = np.flatnonzero(np.diff(np.concatenate([[False], over > 0.0, [False]])))
    found = []
    for first, after in edges.reshape(-1, 2):
        low, high = omega[first], omega[after - 1]
        if first > 0:
            low += (omega[first - 1] - low) * over[first] / (over[first] - over[first - 1])
        if after < len(omega):
            high += (omega[after] - high) * over[after - 1] / (over[after - 1] - over[after])
        found.append((float(low), float(high)))
    return found


def swept(first: Floats, second: Floats) -> list[Span]:
    """Bands of two loads, and what those that belong together pass between the loads."""
    one, other = (tuple((float(low), float(high)) for low, high in bands) for bands in (first, second))
    return [*one, *other, *hulls_between(one, other)]


def gaps(spans: list[Span], within: Span) -> list[Span]:
    """What of a range no span covers; narrower gaps than a fold is sharp are none."""
    return [(low, high) for low, high in complement(clipped(spans, within), within) if high > (1.0 + SHARP) * low]


def clipped(spans: list[Span], within: Span) -> Floats:
    """Intervals inside a range, merged."""
    inside = [(max(low, within[0]), min(high, within[1])) for low, high in spans]
    return as_intervals(merged([span for span in inside if span[0] < span[1]]))


def complement(intervals: Floats, within: Span) -> Floats:
    """Intervals of a range that are not among these."""
    ends = np.concatenate([[within[0]], np.ravel(intervals), [within[1]]]).reshape(-1, 2)
    return np.asarray(ends[ends[:, 0] < ends[:, 1]])


def common(first: Floats, second: Floats) -> Floats:
    """What two sets of intervals share."""
    pairs = [(max(a, c), min(b, d)) for a, b in first for c, d in second]
    return as_intervals(merged([pair for pair in pairs if pair[0] < pair[1]]))


def as_intervals(spans: object) -> Floats:
    """Array (n, 2) of spans."""
    return np.array(spans, float).reshape(-1, 2)


def holds(intervals: Floats, omega: Floats) -> NDArray[np.bool_]:
    """Whether speeds (n,) lie in the intervals, (n,) bool."""
    inside = (omega[:, None] >= intervals[:, 0]) & (omega[:, None] <= intervals[:, 1])
    return np.asarray(np.any(inside, axis=1))
