"""Lack of fit: whether a law misses the means of repeated runs by more than these runs differ.

The residual of runs at one speed and load splits into what they differ by (pure error) and the distance of their mean
from the law. Where the standard errors of the runs were given these stand for the pure error; those that follow from a
run's own samples are too rough for it.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.special import fdtrc, gammaincc

from ..lack_of_fit import LackOfFit
from .friction_model import FrictionSolution, Runs

FEWEST = 3  # degrees of freedom of the pure error
APART = 1e-3  # of the largest: speeds or loads that differ by less are one


def lack_of_fit(fit: FrictionSolution, runs: Runs, known: bool) -> LackOfFit | None:
    """Test a candidate against repeated runs, or runs of known standard errors; None where runs are too few."""
    rest, unit = fit.residual, 1.0 / float(np.median(runs.weight))
    if known:
        freedom = len(rest) - len(fit.p)
        square = float(rest @ rest)
        ratio = square / freedom
        return LackOfFit(unit, unit * ratio**0.5, ratio, float(gammaincc(0.5 * freedom, 0.5 * square)))
    group = _groups(runs)
    count = np.bincount(group)
    means = np.bincount(group, rest) / count
    pure, missed = float(np.sum((rest - means[group]) ** 2)), float(np.sum(count * means**2))
    own, other = len(rest) - len(count), len(count) - len(fit.p)
    if own < FEWEST or other < 1 or not pure > 0.0:
        return None
    ratio = missed / other / (pure / own)
    return LackOfFit(unit * (pure / own) ** 0.5, unit * (missed / other) ** 0.5, ratio, float(fdtrc(other, own, ratio)))


def _groups(runs: Runs) -> NDArray[np.int64]:
    """Number (n,) of the group of runs at one speed and load that every run belongs to."""
    columns = []
    for values in (runs.speed, runs.load, runs.side):
        order = np.argsort(values)
        steps = np.diff(values[order], prepend=values[order][0]) > APART * float(np.max(np.abs(values), initial=0.0))
        place = np.empty(len(values), int)
        place[order] = np.cumsum(steps)
        columns.append(place)
    return np.asarray(np.unique(np.column_stack(columns), axis=0, return_inverse=True)[1], np.int64).ravel()
