"""Largest Lyapunov exponent: the mean rate at which neighbouring motions drift apart, with a standard error.

A small disturbance w of a motion of two states obeys w' = A(t) w, A the Jacobian along the motion. Its direction
(cos b, sin b) and the logarithm g of its length obey b' = n . A d and g' = d . A d with d = (cos b, sin b) and n =
(-sin b, cos b): two more states that never grow out of bounds, so that one integration does it all.

Benettin, Galgani, Giorgilli & Strelcyn 1980, Meccanica 15, 9-30.
"""

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ...base.law import breakpoints_of, torsion
from ...base.protocols import has_jacobian, omega_of, with_parts
from ...base.quantities import numbers, positive_count
from ...base.results import Floats, SolveError
from ...maths import cos, sin
from ..balance.harmonics import whole_orders
from ..integration.corners import repeating
from ..integration.methods import Dopri5
from ..integration.simulate import simulate
from .settle import stretching

BLOCKS = 20  # whose means give the standard error
METHOD = Dopri5(rtol=1e-9, atol=1e-11)


class Direction(NamedTuple):
    """A system of two states with the direction of a disturbance and the logarithm of its length.

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


def lyapunov_exponent(system: Any, y0: ArrayLike, *, turns: int = 2000, settle: int = 200) -> LyapunovExponent:
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
    positive_count("settle", settle)
    if positive_count("turns", turns) < BLOCKS:
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


def _neighbour(system: Any, y: Floats, settle: int, per_block: int) -> tuple[Floats, Floats]:
    turn = 2.0 * np.pi / float(omega_of(system))
    state = _run(system, y, settle * turn)
    rates, end = stretching(system, {}, state[:, None], stretches=BLOCKS * per_block)
    grown = np.concatenate([[0.0], np.cumsum(rates[:, 0])]) * turn
    return grown, end[:, 0]


def _run(system: Any, y: Floats, duration: float) -> Floats:
    run = simulate(system, y, (0.0, 0.5 * duration, duration), method=METHOD)
    if not run.status:
        raise SolveError(f"the motion ended: {run.message}")
    return run.y[:, -1]
