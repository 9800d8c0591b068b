"""Where motions of a slow flow at constant speed end."""

import numpy as np
from numpy.typing import NDArray

from ...results import SolveError
from ..slow_flow.fixed_points import CLEAR, Flow, fixed_points, is_stable, is_trivial
from ..slow_flow.setting import Complexes
from .march import march

ROUND, ROUNDS = 6.0, 20  # of 1/mu, after which it is asked who has arrived
UNSETTLED = -1


def stable_states(flow: Flow) -> list[complex]:
    """Stable steady states [rad] by descending amplitude; copies by whole forcing periods count once."""
    found = [z for z in fixed_points(flow) if is_stable(flow, z)]
    return found + ([0j] if is_trivial(flow) and is_stable(flow, 0j) else [])


def destinations(flow: Flow, starts: Complexes) -> tuple[list[complex], NDArray[np.int64]]:
    """Stable states [rad], and for each start [rad] the place of its end among them; -1 where it did not settle.

    Raises
    ------
    SolveError
        If the flow has no stable state.
    """
    states = stable_states(flow)
    if not states:
        raise SolveError("the slow flow has no stable steady state at this speed; give the drive damping")
    s = flow.setting
    copies = np.exp(2j * np.pi * np.arange(s.copies) / s.copies)
    everything = [z * c for z in fixed_points(flow) for c in copies] + ([0j] if is_trivial(flow) else [])
    ends = np.array([z * c for z in states for c in (copies if z != 0.0 else [1.0])])
    owner = np.array([i for i, z in enumerate(states) for _ in (copies if z != 0.0 else [1.0])])
    others = np.array(everything)
    apart = np.abs(ends[:, None] - others[None])
    clear = CLEAR * np.min(np.where(apart > 1e-9 * (np.abs(ends[:, None]) + 1e-300), apart, np.inf), axis=1)
    label = np.full(len(starts), UNSETTLED)
    z, going = np.array(starts, complex), np.arange(len(starts))
    size = max((abs(x) for x in states), default=0.0) or max(s.scales())
    for _ in range(ROUNDS):
        end = np.full(len(going), ROUND / s.mu)
        z = march(lambda _t, at, _lanes: np.asarray(flow.rates(at)), z, end, 2, size).z[:, -1]
        distance = np.abs(z[:, None] - ends)
        near = np.argmin(distance, axis=1)
        arrived = distance[np.arange(len(z)), near] <= clear[near]
        label[going[arrived]] = owner[near[arrived]]
        going, z = going[~arrived], z[~arrived]
        if not len(going):
            break
    return states, label
