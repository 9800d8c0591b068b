"""Starts of a search for motions: random ones, free vibrations, and what goes on where a known motion ends."""

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from ...base.law import breakpoints_of, depends, is_spring, spring_stiffness, states_of, torque_of
from ...base.quantities import leaf_of
from ...base.results import Floats
from ...model.oscillator import Oscillator
from ...numerics.attractors.attractors import box_at, starts_in
from ...numerics.balance.fourier import with_velocity
from ...numerics.balance.harmonics import highest_order
from ...numerics.balance.linear_part import one_harmonic
from ...numerics.balance.rates import number_of_states
from ...numerics.balance.second_order import second_order
from ..analysis.resonances import active_orders
from .motions import Motions, stable_runs

RANDOM, SEED = 4, 14  # random starts at every speed
PHASES, CLOSE = 4, 24  # of a free vibration; of a driven one with memory, where few lead to the large motion
TURNS, FREE = (1, 2, 3), 49  # periods of a line that a free vibration may take, and amplitudes of the backbone
ASIDE, NEXT = (0.01, 0.02), 0.06  # of its speed: beside a motion that is not followed, up to the next one
BEYOND = 2e-4, 6e-4, 2e-3  # relative distances from the end of a stable run at which others are looked for


class Settling(NamedTuple):
    """A motion to start from: speed [rad/s], state at base angle 0, and its turns."""

    omega: float
    state: tuple[float, ...]
    turns: int


def beyond_ends(system: Any, curve: Motions, span: tuple[float, float]) -> Iterator[Settling]:
    """Starts beyond the ends of the stable runs of a curve, from its state there.

    Where a motion doubles its period or begins to beat, others go on from it, which attract few states.
    """
    branch, states = curve.branch, number_of_states(system)
    for run in stable_runs(branch):
        for end, side in ((run[0], -1.0), (run[-1], 1.0)):
            omega = float(branch.omega[end])
            series = with_velocity(branch.coefficients[end], omega / curve.turns)
            state = (series[0] + np.sum(series[1::2], axis=0)).tolist()
            for share in BEYOND:
                if span[0] < (there := omega * (1.0 + side * share)) < span[1]:
                    yield Settling(there, (*state, *(0.0,) * (states - 2)), curve.turns)


def beside(seeds: tuple[Settling, ...], span: tuple[float, float]) -> tuple[Settling, ...]:
    """The same states beside their speeds, where the motions that no curve has go on, but towards the next seed."""
    at, moved = np.array([seed.omega for seed in seeds]), list[Settling]()
    for seed in seeds:
        for side in (-1.0, 1.0):
            away = side * (at / seed.omega - 1.0)
            if not np.any((away > 0.0) & (away < NEXT)):
                moved += [seed._replace(omega=seed.omega * (1.0 + side * share)) for share in ASIDE]
    return tuple(seed for seed in moved if span[0] < seed.omega < span[1])


def starts_at(case: Any, speeds: Floats) -> tuple[Floats, Floats]:
    """Speeds (lanes,) and states (states, lanes): free vibrations that an order may keep up, and random starts."""
    problem, system = _problem(case), case.system
    equation = problem.system
    draws = np.random.default_rng(SEED).random((4, RANDOM))
    free = _free(equation, case.point.mean_torque, start_reach(case, speeds))
    orders, spring = active_orders(equation), is_spring(case.equation)
    lanes, blocks = [], []
    for omega in speeds.tolist():
        two = [starts_in(box_at(problem, omega), draws)]
        driven = set() if spring else {k * omega for k in orders}
        for nu in sorted({k * omega / q for k in orders for q in TURNS}):
            count = CLOSE if nu in driven else PHASES
            phases = 2.0 * np.pi * (np.arange(count) + 0.3) / count
            for a in _crossings(free, nu):
                two.append(np.array([case.point.x + a * np.cos(phases), -a * nu * np.sin(phases)]))
        both = np.concatenate(two, axis=1)
        blocks.append(both)
        lanes.append(np.full(both.shape[1], omega))
    states = number_of_states(system)
    start = np.concatenate([np.empty((2, 0)), *blocks], axis=1)
    start = np.concatenate([start, np.zeros((states - 2, start.shape[1]))])
    return np.concatenate([np.empty(0), *lanes]), start


def start_reach(case: Any, speeds: Floats) -> float:
    """Largest distance [rad] of a start from the operating point, at ascending speeds (n,)."""
    problem = _problem(case)
    return max(box_at(problem, float(w)).size for w in speeds[[0, -1]])


def _problem(case: Any) -> Any:
    """The error equation of a case with the springs of its law, from whose balance boxes of starts come."""
    equation = case.equation._replace(law=springs_of(case.equation.law))
    leaf = leaf_of(equation, "omega")
    return second_order(equation, leaf, leaf, highest_order(equation))


class Springs(NamedTuple):
    """What is left of a law while nothing slips: its springs, without friction and memory."""

    law: Any

    def torque(self, x: Any) -> Any:
        """Torque [N*m] at torsion x [rad]."""
        return torque_of(self.law, x, 0.0, (0.0,) * states_of(self.law))

    def stiffness(self, x: Any) -> Any:
        """Slope [N*m/rad] at torsion x [rad]."""
        return spring_stiffness(self.law, x)

    def breakpoints(self) -> tuple[float, ...]:
        """Torsions [rad] where a spring has a kink."""
        return tuple(breakpoints_of(self.law))


def springs_of(law: Any) -> Any:
    """The springs of a law: itself where it is one."""
    return law if depends(law) == 1 else Springs(law)


def _free(equation: Oscillator, mean: float, reach: float) -> tuple[Floats, Floats]:
    """Amplitudes [rad] and frequencies [rad/s] of the free vibration by one harmonic, up to the largest of a start."""
    amplitude = reach * np.geomspace(1e-3, 1.0, FREE)
    stiffness = one_harmonic(equation.law, mean, amplitude)[1]
    return amplitude, np.sqrt(np.maximum(stiffness, 0.0) / equation.J)


def _crossings(free: tuple[Floats, Floats], nu: float) -> list[float]:
    """Amplitudes [rad] of the free vibration at a frequency [rad/s]."""
    amplitude, side = free[0], free[1] - nu
    at = np.flatnonzero(side[1:] * side[:-1] < 0.0)
    share = side[at] / (side[at] - side[at + 1])
    return list((amplitude[at] + share * (amplitude[at + 1] - amplitude[at])).tolist())
