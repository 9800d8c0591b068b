"""Motions on which random starts settle at given base frequencies: what coexists there and attracts."""

from dataclasses import dataclass
from itertools import islice
from typing import Any

import numpy as np

from ...base.law import breakpoints_of
from ...base.protocols import Balance
from ...base.quantities import replace
from ...base.results import Booleans, Floats
from ..balance.fourier import orders
from ..balance.linear_part import carried, drive
from ..integration.methods import Dopri5
from .attractors import Motion, motions_among
from .settle import settled

STARTS = 100  # at each frequency: what 3 % of the box lead to is missed once in twenty searches of one frequency
SEED = 20  # of the random starts
DECAY = 16.0  # transients die by exp(-16), 1e-7, in the longest time
FIRST_TURNS, LEAST_TURNS, MOST_TURNS = 30, 300, 6000  # of a start: before the first look; the longest time
MOST_MOTIONS = 20  # at one frequency
MOST_STEPS = 3.2e9  # of all starts together at a time: half a minute
LEAST_DAMPING = 1e-4  # of critical, that bounds the vibrations which are looked for
FASTEST = 2.0  # times the highest line of the forcing, or the vibration about a rest: what is faster is left out
SIZES = np.geomspace(1e-6, 1e6, 241)  # distances of torsions, over the largest forced amplitude


@dataclass(frozen=True, eq=False)
class Search:
    """Motions that random starts led to, and the choice of the starts.

    `turns` is the longest time that a start was given, `reach` the largest first state [rad] of a start; `diverged` and
    `unsettled` count starts, `loose` are the frequencies of the latter.
    """

    omegas: Floats
    starts: int
    turns: int
    reach: float
    motions: list[Motion]
    diverged: int
    unsettled: int
    loose: list[float]


def settled_motions(problem: Balance, omegas: Floats) -> Search:
    """Integrate random starts of a harmonic-balance problem's system at each frequency [rad/s] until they settle."""
    system = problem.system
    boxes = [box_at(problem, float(omega)) for omega in omegas]
    rng = np.random.default_rng(SEED)
    draws = rng.uniform(size=(4, STARTS))  # the same at every frequency: no result depends on which others there are
    y0 = np.concatenate([starts_in(box, draws) for box in boxes], axis=1)
    rate = 0.5 * system.B / system.J
    needed = DECAY * np.max(omegas) / (2.0 * np.pi * rate) if rate > 0.0 else MOST_TURNS
    longest = int(np.clip(needed, LEAST_TURNS, MOST_TURNS))
    size = max(box.size for box in boxes)
    method = Dopri5(rtol=1e-8, atol=1e-10 * size) if breakpoints_of(system.law) else None
    lanes = np.repeat(omegas, STARTS)
    ends = settled(system, {"omega": lanes}, y0, settle=FIRST_TURNS, longest=longest, method=method, budget=MOST_STEPS)
    motions: list[Motion] = []
    for omega in omegas:
        driven = replace(system, {"omega": float(omega)})
        some = islice(motions_among(driven, ends, np.flatnonzero(lanes == omega)), MOST_MOTIONS)
        motions += [motion for motion, _, _ in some]
    loose = (ends.period == 0) & ~ends.diverged
    return Search(
        omegas, STARTS, longest, float(np.max(np.abs(y0[0]))), motions, int(np.count_nonzero(ends.diverged)),
        int(np.count_nonzero(loose)), [float(w) for w in omegas if np.any(loose & (lanes == w))],
    )  # fmt: skip


@dataclass(frozen=True, eq=False)
class Box:
    """Range of x and largest speed of the starts, and the rests (n,) in it with the frequencies (n,) about them."""

    low: float
    high: float
    speed: float
    rests: Floats
    rates: Floats

    @property
    def size(self) -> float:
        """Half of its width [rad]."""
        return 0.5 * (self.high - self.low)


def box_at(problem: Any, omega: float) -> Box:
    """Box from which starts at one frequency are drawn."""
    system, law, mean = problem.system, problem.system.law, float(problem.tau[0])
    middle = carried(law, mean)
    w = orders(len(problem.tau) // 2) * omega / problem.turns
    force = np.abs(drive(system, w, problem.tau, problem.error))
    forced = force > 1e-9 * np.max(force)
    damping = max(system.B, 2.0 * LEAST_DAMPING * system.J * omega)
    top = max(float(np.sum(force[forced] / (damping * w[forced]))) * problem.turns, 1e-300)
    x = middle + np.concatenate([-top * SIZES[::-1], [0.0], top * SIZES])
    with np.errstate(all="ignore"):
        pull = law.torque(x) + 0.0 * x - mean
        rests = _roots(x, pull)
        about = np.sqrt(np.maximum(np.append(law.stiffness(rests) + 0.0 * rests, 0.0), 0.0) / system.J)
        rate = np.sqrt(np.abs(pull / np.where(x == middle, 1.0, x - middle)) / system.J)
    fastest = FASTEST * max(float(np.max(w[forced])), float(np.max(about)))
    met = (rate <= fastest) | (np.abs(pull) <= 2.0 * np.sum(force[forced]))
    distant = np.max(np.abs([*breakpoints_of(law), *rests, 0.0] - np.array(middle)))
    reach = max(min(top, float(np.max(np.abs(x - middle)[met], initial=0.0))), 2.0 * float(distant)) or top
    low, high = _inside_rests(x, pull, rests, np.abs(x - middle) <= reach)
    calm = about[:-1] > 0.0
    if not np.any(calm):
        rests, about, calm = np.array([middle]), np.array([omega, 0.0]), np.array([True])
    speed = max(_fastest_speed(system, mean, low, high), omega * 0.5 * (high - low))
    return Box(low, high, speed, rests[calm], about[:-1][calm])


def _inside_rests(x: Floats, pull: Floats, rests: Floats, inside: Booleans) -> tuple[float, float]:
    """Ends [rad] of the torsions inside; not beyond an outermost rest from where the law pushes away."""
    low, high = float(np.min(x[inside])), float(np.max(x[inside]))
    if len(rests) and pull[inside][0] > 0.0:
        low = max(low, float(rests[0]))
    if len(rests) and pull[inside][-1] < 0.0:
        high = min(high, float(rests[-1]))
    return low, high


def _fastest_speed(system: Any, mean: float, low: float, high: float) -> float:
    """Speed [rad/s] in the deepest well between two torsions of a motion from the highest one."""
    grid = np.linspace(low, high, 513)
    with np.errstate(all="ignore"):
        energy = np.cumsum(system.law.torque(grid) + 0.0 * grid - mean) * (grid[1] - grid[0])
    return float(np.sqrt(2.0 * np.ptp(energy[np.isfinite(energy)]) / system.J))


def _roots(x: Floats, pull: Floats) -> Floats:
    """Torsions at which the torque of the law, sampled at x, balances the mean torque: by linear interpolation."""
    i = np.flatnonzero(np.isfinite(pull[1:]) & np.isfinite(pull[:-1]) & (pull[1:] * pull[:-1] <= 0.0))
    fall = pull[i] - pull[i + 1]
    share = np.divide(pull[i], fall, out=np.zeros(len(i)), where=fall != 0.0)
    return np.unique(x[i] + share * (x[i + 1] - x[i]))


def starts_in(box: Box, draws: Floats) -> Floats:
    """States (2, starts) from numbers between 0 and 1."""
    half = draws.shape[1] // 2
    even = np.stack([box.low + draws[0] * (box.high - box.low), (2.0 * draws[1] - 1.0) * box.speed])
    size, angle = box.size * 10.0 ** (-2.0 * draws[2]), 2.0 * np.pi * draws[3]
    i = (draws[0] * len(box.rests)).astype(int)
    about = np.stack([box.rests[i] + size * np.cos(angle), size * box.rates[i] * np.sin(angle)])
    return np.concatenate([even[:, :half], about[:, half:]], axis=1)
