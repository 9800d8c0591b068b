"""Which single speeds a report shows in time."""

import numpy as np

from ..response.resonances import Regime
from .runup import RunUp

CASES = 4  # resonances shown in time, besides a speed away from all of them
PRIORITY = ("primary", "superharmonic 3:1", "superharmonic 2:1", "subharmonic 1:3", "subharmonic 1:2")


def speeds_in_time(
    found: tuple[Regime, ...], sweep: RunUp, limits: tuple[float, float], asked: tuple[float, ...]
) -> list[tuple[str, float, Regime | None]]:
    """Speeds to show in time: those requested, or the main resonances in the range and one place far from them."""
    if asked:
        return [_nearest(omega, found) for omega in asked]
    inside = [regime for regime in found if regime.inside]
    inside.sort(key=lambda regime: (PRIORITY.index(regime.name), regime.order))
    away = _away(inside, limits)
    chosen: list[tuple[str, float, Regime | None]] = [("away from resonance", away, None)]
    chosen += [(regime.label, regime.place, regime) for regime in inside[:CASES]]
    if not inside:
        chosen.append(("largest error of the run-up", sweep.worst().omega, None))
    return chosen


def _nearest(omega: float, found: tuple[Regime, ...]) -> tuple[str, float, Regime | None]:
    """Name a speed that was requested by the resonance it sits on (within 5 %), if any."""
    near = [regime for regime in found if abs(regime.place / omega - 1.0) < 0.05]
    if not near:
        return "away from resonance", omega, None
    regime = min(near, key=lambda r: abs(r.place / omega - 1.0))
    return f"near {regime.label}", omega, regime


def _away(inside: list[Regime], limits: tuple[float, float]) -> float:
    """Speed [rad/s] in the range that is relatively farthest from every resonance in it."""
    grid = np.linspace(*limits, 201)[1:-1]
    if not inside:
        return float(grid[len(grid) // 2])
    nearest = np.min([np.abs(np.log(grid / regime.place)) for regime in inside], axis=0)
    return float(grid[int(np.argmax(nearest))])
