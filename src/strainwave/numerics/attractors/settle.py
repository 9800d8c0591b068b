"""Lanes of an ensemble marched on until each repeats itself, leaves every bound, or has had its longest time.

The largest Lyapunov exponent: the mean rate at which neighbouring motions drift apart, with a standard error.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...base.choices import select
from ...base.law import breakpoints_of, repeating, torsion
from ...base.protocols import System, has_jacobian, omega_of, prepared, with_parts
from ...base.quantities import numbers, positive_count, replace
from ...base.results import Floats, SolveError
from ...compile.maths import cos, sin
from ..balance.harmonics import whole_orders
from ..ensemble.ensemble import lanes_run
from ..ensemble.measures import Extremes, Final
from ..integration.methods import HOPELESS, MOST_STEPS, Dop8, Dopri5, Method
from ..integration.simulate import simulate

SEEN = 8  # periods that are measured: the longest period that an ensemble recognises
APART = 1e-6  # of a state's size: two trajectories that start so close tell whether a motion is chaotic
STRETCHES = 100  # turns over which that is looked at
UNCOUNTED = 10  # turns before, until the neighbour lies where motions drift apart
MOST_STRETCHED = 45_000  # steps in each of them
LEAST_STRETCHED = 1_000  # what a turn costs at least


@dataclass(frozen=True, eq=False)
class Settled:
    """What became of every lane.

    Attributes
    ----------
    state : (states, lanes) array
        State at base phase 0 at the end; nan where it diverged.
    period : (lanes,) int array
        Turns after which the motion repeats; 0 where it does not.
    diverged : (lanes,) bool array
        Whether it left every bound.
    lowest, highest : (lanes,) arrays
        Extremes of the first state over the last 8 turns.
    """

    state: Floats
    period: NDArray[np.int64]
    diverged: NDArray[np.bool_]
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
    known: Callable[[Settled], NDArray[np.bool_]] | None = None,
    most: float = math.inf,
) -> Settled:
    """March every lane from its state (states, lanes) for `settle` turns, and those not settled on to `longest`.

    With `known`, which tells the lanes that are on known motions, those that are not go on, settled or not. What takes
    more than `most` steps of all lanes, at first an eighth, is refused (SolveError) before it is marched.
    """
    lanes = y0.shape[1]
    lowest, highest = np.full((2, lanes), np.nan)
    result = Settled(np.full(y0.shape, np.nan), np.zeros(lanes, np.int64), np.zeros(lanes, bool), lowest, highest)
    places, start, turns, skipped = np.arange(lanes), y0, 0, settle
    while True:
        varied: dict[str, Any] = {path: np.broadcast_to(v, (lanes,))[places] for path, v in parameters.items()}
        run, _ = lanes_run(
            system, varied, tuple(start), periods=SEEN, settle=skipped, measures=(Extremes(), Final()), method=method,
            threads=threads, most=most if turns else most / 8.0,
        )  # fmt: skip
        turns += skipped + SEEN
        result.state[:, places] = run["final"].values
        result.period[places] = run["period"].values
        result.diverged[places] = run["status"].values != 0
        result.lowest[places], result.highest[places] = run["lowest"].values, run["highest"].values
        ended = result.diverged | (result.period > 0 if known is None else known(result))
        active = ~ended[places]
        if not active.any() or turns >= longest:
            return result
        start, places = run["final"].values[:, active], places[active]
        skipped = min(turns, longest - turns)


def stretching(
    system: System, parameters: dict[str, Any], state: Floats, stretches: int = STRETCHES
) -> tuple[Floats, Floats]:
    """Rates [1/s] (stretches, lanes) at which a neighbour of every lane moves away, turn after turn; the last states.

    Its distance is measured after every turn and brought back to its length before (Benettin, Galgani, Giorgilli &
    Strelcyn 1980, Meccanica 15, 9). Both trajectories take the same steps: with others their errors, too, grow apart.
    """
    lanes = state.shape[1]
    omega = np.broadcast_to(omega_of(replace(system, parameters)), (lanes,))
    size = np.maximum(np.max(np.abs(state), axis=0), 1e-300)
    unit = size * np.stack([np.ones(lanes), *[omega] * (len(state) - 1)])
    away = unit / np.sqrt(len(state)) * APART
    both: dict[str, Any] = {path: np.tile(np.broadcast_to(v, (lanes,)), 2) for path, v in parameters.items()}
    how: Any = {"periods": 1, "settle": 0, "measures": (Final(),), "threads": None}
    method, rates, turns = None, [], stretches + UNCOUNTED
    most = min(MOST_STRETCHED, HOPELESS * MOST_STEPS // turns - LEAST_STRETCHED)
    for _ in range(turns):
        start = np.concatenate([state, state + away], axis=1)
        ridden, _ = lanes_run(system, both, tuple(start), method=method, **how)
        if method is None:
            fixed = "steps" in ridden
            steps = int(2 * ridden["steps"].max()) if fixed else 0
            if steps > most:
                raise SolveError(
                    f"{turns} turns of {steps} steps, which tell whether a motion is chaotic, are too many: at most "
                    f"{max(most, 0):,} steps a turn; start closer to equilibrium, or take fewer turns"
                )
            method = Dop8(steps_per_period=steps) if fixed else Dopri5(rtol=1e-11, atol=1e-14)
        final = ridden["final"].values
        state, gap = final[:, :lanes], final[:, lanes:] - final[:, :lanes]
        grown = np.sqrt(np.sum((gap / unit) ** 2, axis=0)) / APART
        with np.errstate(divide="ignore"):
            rates.append(np.log(grown) * omega / (2.0 * np.pi))
        away = gap / np.maximum(grown, 1e-300)
    return np.array(rates[UNCOUNTED:]), state


BLOCKS = 20  # whose means give the standard error
METHOD = Dopri5(rtol=1e-9, atol=1e-11)


class Direction(NamedTuple):
    """A system of two states with the direction of a disturbance and the logarithm of its length.

    A small disturbance w of a motion of two states obeys w' = A(t) w, A the Jacobian along the motion. Its direction
    (cos b, sin b) and the logarithm g of its length obey b' = n . A d and g' = d . A d with d = (cos b, sin b) and n =
    (-sin b, cos b): two more states that never grow out of bounds, so that one integration does it all (Benettin,
    Galgani, Giorgilli & Strelcyn 1980, Meccanica 15, 9-30).

    The second state counts in units of `speed` times the first, so that the direction turns evenly.
    """

    system: Any
    speed: float

    @property
    def omega(self) -> float:
        """Base speed [rad/s] of the system."""
        return float(omega_of(self.system))

    def breakpoints(self) -> tuple[float, ...]:
        """Torsions where the law is not smooth."""
        return tuple(breakpoints_of(self.system))

    def torsion(self, phase: Any, y: Any) -> Any:
        """Torsion of the system."""
        return torsion(self.system, phase, (y[0], y[1]))

    def rhs(self, phase: Any, y: Any) -> Any:
        """Rates of the states, of the direction [rad] and of the logarithm of the length."""
        x, v, angle, _ = y
        first, second = self.system.rhs(phase, (x, v))
        (j00, j01), (j10, j11) = self.system.jacobian(phase, (x, v))
        c, s = cos(angle), sin(angle)
        p, q = j00 * c + self.speed * j01 * s, j10 * c / self.speed + j11 * s
        return first, second, c * q - s * p, c * p + s * q


@dataclass(frozen=True, eq=False)
class LyapunovExponent:
    """The largest Lyapunov exponent of a motion.

    Attributes
    ----------
    value, standard_error : float
        Mean of the blocks and its standard error [1/s]. Of two parts: that of independent blocks, and what the length
        of a disturbance differs by from an even course at the first and the last turn.
    blocks : (blocks,) array
        Exponent [1/s] of each block of turns.
    turns : int
        Turns of the base angle over which the mean is taken.
    state : (states,) array
        Where the motion ends, to go on from.
    """

    value: float
    standard_error: float
    blocks: Floats
    turns: int
    state: Floats

    def __str__(self) -> str:
        kind = "chaotic" if self.value > 4.0 * self.standard_error else "not shown to be chaotic"
        return (
            f"Largest Lyapunov exponent {self.value:.5g} +- {self.standard_error:.2g} 1/s over {self.turns} turns "
            f"({len(self.blocks)} blocks): {kind}"
        )


def lyapunov_exponent(system: System, y0: ArrayLike, *, turns: int = 2000, settle: int = 200) -> LyapunovExponent:
    """Integrate a motion with a small disturbance of it, and take the mean rate at which the disturbance grows.

    A system of two states with a `jacobian` takes its variational equation; any other a neighbour at a finite distance
    (1e-6 of the state), brought back every turn.

    Parameters
    ----------
    system : Oscillator, or any NamedTuple with `rhs(phase, y)`
        The system, at its own `omega` (1 where it has none).
    y0 : (states,) array_like
        State at base phase 0.
    turns : int
        Turns of the base angle over which the mean is taken, at least 20; rounded up to whole blocks.
    settle : int
        Turns before that.

    Returns
    -------
    LyapunovExponent
        `value` and `standard_error` [1/s]; positive is chaos.

    Raises
    ------
    ValueError
        If y0 is no finite state of the system or a count is out of range.
    SolveError
        If the motion leaves every bound.
    """
    system = repeating("lyapunov_exponent", with_parts("lyapunov_exponent", system, "rhs"))
    whole_orders(system)
    y = numbers("y0", y0)
    settle, turns = positive_count("settle", settle), positive_count("turns", turns)
    if turns < BLOCKS:
        raise ValueError(f"turns is {turns}; it must be at least {BLOCKS}, one for each block")
    per_block = -(-turns // BLOCKS)
    if len(y) == 2 and has_jacobian(system):
        logs, end = _variational(system, y, settle, per_block)
    else:
        logs, end = _neighbour(system, y, settle, per_block)
    turn = 2.0 * np.pi / float(omega_of(system))
    blocks = np.diff(logs[::per_block]) / (per_block * turn)
    course = np.linspace(0.0, logs[-1], len(logs))
    chance = float(np.std(blocks, ddof=1) / np.sqrt(len(blocks)))
    ends = float(np.sqrt(2.0) * np.std(logs - course) / (BLOCKS * per_block * turn))
    error = float(np.hypot(chance, ends))
    return LyapunovExponent(float(np.mean(blocks)), error, blocks, per_block * BLOCKS, end)


def _variational(system: Any, y: Floats, settle: int, per_block: int) -> tuple[Floats, Floats]:
    """Logarithms (turns + 1,) of the length of a disturbance after every turn, and the last state."""
    turn = 2.0 * np.pi / float(omega_of(system))
    before = _run(system, y, settle * turn)
    pull = abs(float(system.jacobian(0.0, tuple(before))[1][0]))
    speed = float(np.sqrt(pull)) if pull > 0.0 else 2.0 * np.pi / turn
    both = Direction(system, speed)
    state, grown = _run(both, np.array([*before, 1.0, 0.0]), settle * turn), [0.0]
    for _ in range(BLOCKS * per_block):  # turn by turn: tolerances are relative to the angle and the logarithm
        state = _run(both, np.array([*state[:2], state[2] % (2.0 * np.pi), 0.0]), turn)
        grown.append(grown[-1] + state[3])
    return np.array(grown), state[:2]


def _neighbour(system: System, y: Floats, settle: int, per_block: int) -> tuple[Floats, Floats]:
    turn = 2.0 * np.pi / float(omega_of(system))
    state = _run(system, y, settle * turn)
    rates, end = stretching(system, {}, state[:, None], stretches=BLOCKS * per_block)
    grown = np.concatenate([[0.0], np.cumsum(rates[:, 0])]) * turn
    return grown, end[:, 0]


def _run(system: System, y: Floats, duration: float) -> Floats:
    run = simulate(system, y, (0.0, 0.5 * duration, duration), method=METHOD)
    if not run.status:
        raise SolveError(f"the motion ended: {run.message}")
    return run.y[:, -1]
