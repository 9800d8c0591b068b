"""The largest oscillation of a drive in a range of speeds, in a fraction of the time of its response curve."""

from math import ceil, log
from typing import Any

import numpy as np

from ....law import is_spring
from ....numerics.balance.choice import balance_of
from ....numerics.balance.truncation import MATTERS
from ....numerics.continuation.coexisting import Coexisting
from ....numerics.curves.response import traced
from ....numerics.stability.second_order import displacement_peaks
from ....results import Floats
from ....tree import leaf_of
from ...response.gear_forces import settling_time
from ...response.resonances import operating_point
from ...response.steady import settle
from ..train_curve import largest_oscillation
from .subject import Subject

POINTS = 12  # of a curve by harmonic balance, and more where it bends
APART, AROUND, ROUNDS = 0.06, 5, 2  # by integration: relative distance of speeds, and how many more about the largest

Top = tuple[float, float]


def largest(subject: Subject, harmonics: int, coexisting: bool) -> Top | None:
    """Speed [rad/s] and size [rad] of the largest |error - mean| in the speeds of a drive; None where none is found.

    Parameters
    ----------
    subject : Subject
        The drive.
    harmonics : int
        Of the base angle, where the balance is harmonic.
    coexisting : bool
        Whether motions that do not join the curve from the ends of the range are looked for.
    """
    if subject.train is not None:
        return largest_oscillation(subject.train, subject.speeds, harmonics, coexisting)
    if not is_spring(subject.system):
        return _simulated(subject.system, subject.speeds)
    return _balanced(subject.system, subject.speeds, harmonics, coexisting)


def _balanced(system: Any, speeds: tuple[float, float], harmonics: int, coexisting: bool) -> Top | None:
    leaf = leaf_of(system, "omega")
    middle = system._replace(omega=(speeds[0] * speeds[1]) ** 0.5)
    problem, found, _, _ = traced(
        lambda h: balance_of(middle, leaf, leaf, h), *speeds, (harmonics, harmonics), MATTERS, POINTS,
        Coexisting() if coexisting else None,
    )  # fmt: skip
    if not len(found.points):
        return None
    series = problem.displacements(found.points)
    series[:, 0] = 0.0
    return crest(found.points[:, -1], displacement_peaks(series), speeds)


def crest(omega: Floats, sizes: Floats, speeds: tuple[float, float]) -> Top:
    """The highest place of a curve within a range, by the parabola through its highest point and those beside it."""
    inside = (omega >= speeds[0] * (1.0 - 1e-9)) & (omega <= speeds[1] * (1.0 + 1e-9))
    i = int(np.argmax(np.where(inside, sizes, -np.inf)))
    best = float(omega[i]), float(sizes[i])
    if not 0 < i < len(omega) - 1 or not inside[i - 1 : i + 2].all() or not best[1] > 0.0:
        return best
    w, a = omega[i - 1 : i + 2] / best[0], sizes[i - 1 : i + 2] / best[1]
    s = np.cumsum([0.0, *np.hypot(np.diff(w), np.diff(a))])
    if not np.all(np.diff(s) > 0.0):
        return best
    parabola, where = np.polyfit(s, a, 2), np.polyfit(s, w, 2)
    if not parabola[0] < 0.0:
        return best
    top = float(np.clip(-0.5 * parabola[1] / parabola[0], s[0], s[2]))
    return best[0] * float(np.polyval(where, top)), best[1] * float(np.polyval(parabola, top))


def _simulated(system: Any, speeds: tuple[float, float]) -> Top | None:
    """The same by integration, upwards, with more speeds about the largest; those without a steady motion are left."""
    found: dict[float, float] = {}
    grid = np.geomspace(*speeds, ceil(log(speeds[1] / speeds[0]) / APART) + 1)
    start = operating_point(system).start
    for _ in range(1 + ROUNDS):
        for omega in map(float, grid):
            if omega not in found:
                moving = system._replace(omega=omega)
                motion = settle(moving, start, time=settling_time(moving))
                start = motion.end if motion.status else start
                found[omega] = float(np.max(np.abs(motion.x - np.mean(motion.x[:-1])))) if motion.closed else -1.0
        rows = sorted(omega for omega in found if found[omega] >= 0.0)
        if len(rows) < 3:
            return None
        i = max(range(len(rows)), key=lambda at: found[rows[at]])
        grid = np.linspace(rows[max(i - 1, 0)], rows[min(i + 1, len(rows) - 1)], AROUND)
    return crest(np.array(rows), np.array([found[omega] for omega in rows]), speeds)
