"""The largest oscillation of a drive in a range of speeds, in a fraction of the time of its response curve."""

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
from ..train_curve import largest_on_turns, largest_oscillation
from .subject import Subject

POINTS = 12  # of a curve by harmonic balance, and more where it bends

Top = tuple[float, float]


def largest(subject: Subject, harmonics: int, coexisting: bool) -> Top | None:
    """Speed [rad/s] and size [rad] of the largest |error - mean| in the speeds of a drive; None where none is found.

    Parameters
    ----------
    subject : Subject
        The drive.
    harmonics : int
        Of the base angle.
    coexisting : bool
        Whether motions that do not join the curve from the ends of the range are looked for.
    """
    if subject.train is not None:
        return largest_oscillation(subject.train, subject.speeds, harmonics, coexisting)
    if not is_spring(subject.system):
        return largest_on_turns(subject.system, subject.speeds, harmonics, coexisting)
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
