"""Whether a sample of peaks falls into two groups, as where a low- and a high-amplitude motion coexist."""

from dataclasses import dataclass

import numpy as np

from ...results import Floats

FEWEST, PART = 5, 100  # numbers of a group, and which part of all: fewer may be the tail of the other
LOUDER = 1.1  # least ratio across the gap: closer groups are two sides of nothing that matters
WIDER = 2.0  # times the standard deviation of the wider group, of which the gap must be


@dataclass(frozen=True)
class TwoGroups:
    """A low- and a high-amplitude group of peaks.

    Attributes
    ----------
    quiet, loud : float
        The largest peak of the low-amplitude group and the smallest of the high-amplitude one [rad].
    share, error : float
        Share of the drives that are in the high-amplitude group, and its binomial standard error.
    """

    quiet: float
    loud: float
    share: float
    error: float


def two_groups(sample: Floats) -> TwoGroups | None:
    """Cut a sample of positive numbers at its widest gap, where that parts two groups; None where it is one.

    In the logarithms of the sorted sample the widest gap that leaves at least 5 numbers, and a hundredth of them, on
    each side must be twice as wide as the standard deviation of the wider of the groups beside it, and the numbers
    across it must have at least the ratio 1.1. In random samples of one group (normal, uniform, lognormal,
    exponential) it is so at most once in 1000 for 64 numbers and more, and once in 500 for 32.
    """
    logs = np.sort(np.log(sample[sample > 0.0]))
    n, least = len(logs), max(FEWEST, -(-len(logs) // PART))
    if n < max(2 * least, len(sample)):
        return None
    at = least + int(np.argmax(np.diff(logs)[least - 1 : n - least]))
    gap, width = logs[at] - logs[at - 1], max(np.std(logs[:at], ddof=1), np.std(logs[at:], ddof=1))
    if gap < np.log(LOUDER) or gap < WIDER * width:
        return None
    share = 1.0 - at / n
    return TwoGroups(
        float(np.exp(logs[at - 1])), float(np.exp(logs[at])), share, float(np.sqrt(share * (1 - share) / n))
    )
