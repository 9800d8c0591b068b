"""Rules that forbid a speed: a limit on the oscillation, on its amplification, a margin from the resonances."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import product
from math import inf
from typing import NamedTuple

import numpy as np

from ...base.quantities import number
from ...base.results import Floats
from ...drive.demands.motor_limits import PEAK, RMS, MotorLimits, Need
from .error_equation import PEAK_AMPLIFICATION
from .intervals import Span, clipped, complement, gaps
from .motions import MEAN, MOTOR, OMEGA, OSCILLATION, TORQUE, LoadMotions
from .motions import RMS as RMS_TORQUE
from .size_curve import SizeCurve

ROUNDING_FACTOR = 1.0 + 1e-9  # times a bound: beyond it, and not by rounding


@dataclass(frozen=True)
class Rules:
    """Rules that forbid a speed; None is no rule.

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
    sheet : MotorLimits or None
        Limits of the motor's peak and rms torque, which may depend on its speed.
    gear_torque, mean_torque : float or None
        Largest torque in the gear [N*m], and its largest cubic mean over a turn.
    """

    limit: float | None = None
    amplification: float | None = None
    margin: float | None = None
    speed: float | None = None
    motor_torque: float | None = None
    sheet: MotorLimits | None = None
    gear_torque: float | None = None
    mean_torque: float | None = None

    def level(self, quasi_static: float) -> float:
        """Oscillation [rad] from which on a speed is forbidden."""
        amplified = np.inf if self.amplification is None else self.amplification * quasi_static
        return min(np.inf if self.limit is None else self.limit, amplified)


def rules_of(
    limit: float | None, amplification: float | None, margin: float | None, limit_of_project: float | None
) -> Rules:
    """Rules from the arguments of `speed_map`; by default the limit of the project, or twice the quasi-static error."""
    limit = None if limit is None else number("limit [rad]", limit, positive=True)
    amplification = None if amplification is None else number("amplification", amplification, positive=True)
    margin = None if margin is None else number("margin", margin, positive=True)
    if margin is not None and not margin < 1.0:
        raise ValueError(f"margin is {margin:g}; it is a share of the speed and must be less than 1, as 0.1 for 10 %")
    if limit is not None or amplification is not None or margin is not None:
        return Rules(limit, amplification, margin)
    if limit_of_project is not None:
        return Rules(limit=limit_of_project)
    return Rules(amplification=PEAK_AMPLIFICATION)


class Bands(NamedTuple):
    """Forbidden and allowed speeds under one load."""

    forbidden: Floats
    allowed: Floats


def bands_of(loaded: LoadMotions, rules: Rules, span: Span, resonances: Iterable[Span], apart: float) -> Bands:
    """Apply the rules to all stable motions under a load.

    Parameters
    ----------
    loaded : UnderLoad
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
    level = rules.level(loaded.quasi_static)
    most_torque = inf if rules.gear_torque is None else rules.gear_torque
    bounds = [(OSCILLATION, level), (TORQUE, most_torque * ROUNDING_FACTOR)]
    if rules.mean_torque is not None:
        bounds.append((MEAN, rules.mean_torque * ROUNDING_FACTOR))
    bands: list[Span] = [*loaded.jumping]
    for run, _ in loaded.runs:
        for column, bound in bounds:
            bands += above(run, bound, column)
    for flip in loaded.flips:  # what follows repeats after more turns: its own motions decide where they are known
        bands += gaps([(run[0, OMEGA], run[-1, OMEGA]) for run, subharmonic in loaded.runs if subharmonic], flip)
    bands += gaps([(run[0, OMEGA], run[-1, OMEGA]) for run, _ in loaded.runs], span)
    for one in loaded.loose:
        if one.oscillation > level or one.torque > most_torque:
            bands.append((one.omega / (1.0 + apart), one.omega * (1.0 + apart)))
    bands += beyond_sheet(needs_of(loaded), rules.sheet)
    if rules.speed is not None:
        bands.append((rules.speed, span[1]))
    if rules.margin is not None:
        bands += [((1.0 - rules.margin) * low, (1.0 + rules.margin) * high) for low, high in resonances]
    forbidden = clipped(bands, span)
    if loaded.loose:  # between two forbidden speeds no nearer one was searched: a motion that no curve has may go on
        narrow = [(low, high) for low, high in complement(forbidden, span) if high < low * (1.0 + apart)]
        inside = [(low, high) for low, high in narrow if low > span[0] and high < span[1]]
        forbidden = clipped([*map(tuple, forbidden), *inside], span)
    return Bands(forbidden, complement(forbidden, span))


def above(run: Floats, level: float, column: int = OSCILLATION) -> list[Span]:
    """Bands of a run in which the oscillation, or another column, is above a level; ends by linear interpolation."""
    return SizeCurve(run[:, OMEGA], run[:, column], np.ones(len(run), bool)).above(level)


def needs_of(loaded: LoadMotions) -> list[Need]:
    """Demands of the runs under a load on the motor."""
    return [
        Need(run[:, OMEGA], run[:, MOTOR], run[:, RMS_TORQUE], np.ones(len(run) - 1, bool)) for run, _ in loaded.runs
    ]


def beyond_sheet(needs: Iterable[Need], sheet: MotorLimits | None) -> Iterator[Span]:
    """Bands in which motions ask for more than the motor's peak or rms torque."""
    for need, limit in product(needs, (PEAK, RMS) if sheet else ()):
        omega, torque, available, joined = need.against(sheet or MotorLimits(), limit)
        yield from SizeCurve(omega, torque - available, joined).above(0.0)
