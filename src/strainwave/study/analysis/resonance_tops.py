"""Where the resonances are on the computed curve, which small oscillations only place roughly."""

from dataclasses import replace
from typing import Any

import numpy as np

from ...theory.slow_flow.resonance import Resonance
from ..response.resonances import Regime
from ..response.response import ExactResponse

FARTHEST = 1.6  # relative distance of the maximum from the speed of small oscillations
FAINT = 1e-4  # of the largest |x|: a smaller component is no resonance to place


def with_tops(
    found: tuple[Regime, ...], system: Any, exact: ExactResponse, close: dict[Resonance, ExactResponse]
) -> tuple[Regime, ...]:
    """Add to every resonance p:1 its maximum on the computed curve, or on the one drawn for it alone.

    Looked for between the neighbouring resonances, where a slow run-up or run-down goes; an end of the range is none.
    """
    places = sorted(regime.omega for regime in found if regime.resonance.q == 1)
    out = []
    for regime in found:
        near = close.get(regime.resonance, exact)
        top = None if regime.resonance.q != 1 else _top(regime, places, system, near)
        met = top is not None and bool(regime.reason)  # the curve is in the range, and such a law is placed by it
        out.append(replace(regime, top=top, inside=regime.inside or met))
    return tuple(out)


def _top(regime: Regime, places: list[float], system: Any, near: ExactResponse) -> tuple[float, float] | None:
    i = places.index(regime.omega)
    low = max([regime.omega / FARTHEST, *((w * regime.omega) ** 0.5 for w in places[:i])])
    high = min([regime.omega * FARTHEST, *((w * regime.omega) ** 0.5 for w in places[i + 1 :])])
    visited = near.visited()
    omega = near.curve.omega[visited]
    inside = (omega >= low) & (omega <= high)
    if not np.any(inside):
        return None
    here, omega = visited[inside], omega[inside]
    amplitude = near.torsion_amplitude(system, regime.resonance.p)[here]
    at = int(np.argmax(amplitude))
    if not np.min(omega) < omega[at] < np.max(omega) or amplitude[at] < FAINT * np.max(near.curve.peak[visited]):
        return None
    return float(omega[at]), float(amplitude[at])
