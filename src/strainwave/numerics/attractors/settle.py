"""Settling of lanes: they march on until each repeats itself, leaves every bound, or has had its longest time.

The rate at which neighbouring motions drift apart tells chaotic ones.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from ...base.law import torsion
from ...base.protocols import System, omega_of, prepared
from ...base.results import Booleans, Floats, Integers, SolveError
from ...compile.elementwise import select
from ..ensemble.ensemble import run_lanes
from ..ensemble.measures import Extremes, Final
from ..integration.methods import Dop8, Dopri5, Method

SEEN = 8  # periods that are measured: the longest period that an ensemble recognises
NEIGHBOUR_DISTANCE = 1e-6  # of a state's size: two trajectories that start so close tell whether a motion is chaotic
STRETCHES = 100  # turns over which that is looked at
UNCOUNTED_TURNS = 10  # turns before, until the neighbour lies where motions drift apart
MOST_STRETCHED = 45_000  # steps in each of them


@dataclass(frozen=True, eq=False)
class Settled:
    """End of every lane.

    Attributes
    ----------
    state : (states, lanes) array
        State at base phase 0 at the end; nan where it diverged.
    period : (lanes,) int array
        Turns after which the motion repeats; 0 where it does not, -1 where it takes too many steps.
    diverged : (lanes,) bool array
        True where it left every bound, or takes too many steps.
    lowest, highest : (lanes,) arrays
        Extremes of the first state over the last 8 turns.
    """

    state: Floats
    period: Integers
    diverged: Booleans
    lowest: Floats
    highest: Floats


class Bounded(NamedTuple):
    """A system without an acceleration where its torsion is beyond a bound [rad]: a trajectory ends there.

    A law with memory yields over a constant twist: steps that follow it far away are as short as that twist.
    """

    system: Any
    bound: float

    @property
    def omega(self) -> Any:
        """Base speed [rad/s] of the system."""
        return omega_of(self.system)

    def prepared(self) -> "Bounded":
        """The same with the system in its form for many steps."""
        return self._replace(system=prepared(self.system))

    def rhs(self, phase: Any, y: Any) -> Any:
        """Rates of the states."""
        rates, twist = self.system.rhs(phase, y), torsion(self.system, phase, y)
        return (rates[0], rates[1] + select(abs(twist) > self.bound, math.nan, 0.0), *rates[2:])


def settled(
    system: System,
    parameters: dict[str, Any],
    y0: Floats,
    *,
    settle: int,
    longest: int,
    method: Method | None = None,
    threads: int | None = None,
    recognised: Callable[[Settled], Booleans] | None = None,
    budget: float = math.inf,
) -> Settled:
    """March every lane from its state (states, lanes) for `settle` turns, and those not settled on to `longest`.

    `recognised` tells the lanes on known motions; with it all others go on, settled or not. What takes more than
    `budget` steps of all lanes, at first an eighth, is refused (SolveError) before it is marched.
    """
    lanes = y0.shape[1]
    lowest, highest = np.full((2, lanes), np.nan)
    result = Settled(np.full(y0.shape, np.nan), np.zeros(lanes, np.int64), np.zeros(lanes, bool), lowest, highest)
    places, start, turns, skipped = np.arange(lanes), y0, 0, settle
    while True:
        varied: dict[str, Any] = {path: np.broadcast_to(v, (lanes,))[places] for path, v in parameters.items()}
        run = run_lanes(
            system, varied, tuple(start), periods=SEEN, settle=skipped, measures=(Extremes(), Final()), method=method,
            threads=threads, budget=budget if turns else budget / 8.0,
        ).variables  # fmt: skip
        turns += skipped + SEEN
        result.state[:, places] = run["final"].values
        result.period[places] = np.where(run["status"].values == 2, -1, run["period"].values)
        result.diverged[places] = run["status"].values != 0
        result.lowest[places], result.highest[places] = run["lowest"].values, run["highest"].values
        ended = result.diverged | (result.period > 0 if recognised is None else recognised(result))
        active = ~ended[places]
        if not active.any() or turns >= longest:
            return result
        start, places = run["final"].values[:, active], places[active]
        skipped = min(turns, longest - turns)


def stretching(system: System, state: Floats) -> Floats:
    """Rates [1/s] (100, lanes) at which a neighbour of every lane (states, lanes) moves away, turn after turn.

    Its distance is measured after every turn and brought back to its length before (Benettin, Galgani, Giorgilli &
    Strelcyn 1980, Meccanica 15, 9). Both trajectories take the same steps: with others their errors, too, grow apart.
    """
    lanes = state.shape[1]
    omega = float(omega_of(system))
    size = np.maximum(np.max(np.abs(state), axis=0), 1e-300)
    unit = size * np.array([1.0, *[omega] * (len(state) - 1)])[:, None]
    away = unit / np.sqrt(len(state)) * NEIGHBOUR_DISTANCE
    request: Any = {"periods": 1, "settle": 0, "measures": (Final(),), "threads": None}
    method, rates, turns = None, [], STRETCHES + UNCOUNTED_TURNS
    for _ in range(turns):
        start = np.concatenate([state, state + away], axis=1)
        ridden = run_lanes(system, {}, tuple(start), method=method, **request).variables
        if method is None:
            fixed = "steps" in ridden
            steps = int(2 * ridden["steps"].values.max()) if fixed else 0
            if steps > MOST_STRETCHED:
                raise SolveError(
                    f"{turns} turns of {steps} steps, which tell whether a motion is chaotic, are too many: at most "
                    f"{MOST_STRETCHED:,} steps a turn; start closer to equilibrium"
                )
            method = Dop8(steps_per_period=steps) if fixed else Dopri5(rtol=1e-11, atol=1e-14)
        final = ridden["final"].values
        state, gap = final[:, :lanes], final[:, lanes:] - final[:, :lanes]
        grown = np.sqrt(np.sum((gap / unit) ** 2, axis=0)) / NEIGHBOUR_DISTANCE
        with np.errstate(divide="ignore"):
            rates.append(np.log(grown) * omega / (2.0 * np.pi))
        away = gap / np.maximum(grown, 1e-300)
    return np.array(rates[UNCOUNTED_TURNS:])
