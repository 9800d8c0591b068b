"""Sentences on what a response curve should not be trusted in, with the frequency and the remedy."""

import numpy as np

from ...protocols import Balance
from ...results import Branch
from ...sentences import Sentence, Speed
from ..continuation.trace import Trace

NEVER_STABLE = "no point of it is stable"


def remarks(problem: Balance, found: Trace, branch: Branch) -> list[str]:
    """List what to know about a response curve."""
    said: list[str] = []
    if len(branch) and not branch.stable.any():
        said.append(NEVER_STABLE)
    loose = found.points[problem.floating(found.points), -1]
    if len(loose):
        said.append(
            Sentence(
                "at omega = {} the law gives no torque and any mean is in balance (the middle is shown): a mean torque "
                "would place it",
                Speed(np.min(loose), np.max(loose), between=" .. "),
            )
        )
    return said
