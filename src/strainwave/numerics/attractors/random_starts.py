"""Motions on which random starts settle at given base frequencies: what coexists there and attracts.

The starts are drawn from a box that holds the rests of the law under the mean torque and the largest vibration that the
forcing can keep up against the damping: a harmonic of amplitude a at w asks at least B w a of the force. One half of
them is spread evenly, the other about the rests with sizes from 1 % of the box on, evenly in their logarithm.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from ...law import breakpoints_of
from ...quantities import replace
from ...results import Floats
from ..balance.fourier import orders
from ..balance.one_harmonic import carried, drive
from ..integration.methods import Dopri5
from ..integration.simulate import simulate
from .attractors import NEAR, PER_TURN, distance, fewest
from .settle import Settled, settled

STARTS = (
    100  # at each frequency: a motion that 3 % of the box lead to is missed once in twenty searches of one frequency
)
SEED = 20
DECAY = 16.0  # transients die by exp(-16), 1e-7, in the longest time
FIRST_TURNS, LEAST_TURNS, MOST_TURNS = 30, 300, 6000
MOST_MOTIONS = 20  # at one frequency
LEAST_DAMPING = 1e-4  # of critical, that bounds the vibrations which are looked for
FASTEST = (
    2.0  # times the highest line of the forcing, or the free vibration about a rest: what vibrates faster is left out
)
SIZES = np.geomspace(1e-6, 1e6, 241)


@dataclass(frozen=True, eq=False)
class Motion:
    """A settled motion: its shortest period in turns and samples (states, 64 turns) over it, from base phase 0 on."""

    omega: float
    turns: int
    samples: Floats


@dataclass(frozen=True, eq=False)
class Search:
    """What random starts led to, and how they were chosen.

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


def settled_motions(problem: Any, omegas: Floats) -> Search:
    """Integrate random starts of a harmonic-balance problem's system at each frequency [rad/s] until they settle."""
    system = problem.system
    boxes = [box_at(problem, float(omega)) for omega in omegas]
    rng = np.random.default_rng(SEED)
    draws = rng.uniform(size=(4, STARTS))  # the same at every frequency: no result depends on which others there are
    start = np.concatenate([starts_in(box, draws) for box in boxes], axis=1)
    rate = 0.5 * system.B / system.J
    needed = DECAY * np.max(omegas) / (2.0 * np.pi * rate) if rate > 0.0 else MOST_TURNS
    longest = int(np.clip(needed, LEAST_TURNS, MOST_TURNS))
    size = max(box.size for box in boxes)
    method = Dopri5(rtol=1e-8, atol=1e-10 * size) if breakpoints_of(system.law) else None
    lanes = np.repeat(omegas, STARTS)
    ends = settled(system, {"omega": lanes}, start, settle=FIRST_TURNS, longest=longest, method=method)
    motions: list[Motion] = []
    for omega in omegas:
        motions += _apart(replace(system, {"omega": float(omega)}), ends, np.flatnonzero(lanes == omega))
    loose = (ends.period == 0) & ~ends.diverged
    return Search(
        omegas, STARTS, longest, float(np.max(np.abs(start[0]))), motions, int(np.count_nonzero(ends.diverged)),
        int(np.count_nonzero(loose)), [float(w) for w in omegas if np.any(loose & (lanes == w))],
    )  # fmt: skip


def _apart(system: Any, ends: Settled, lanes: Any) -> list[Motion]:
    """The different motions on which the lanes of one frequency have settled, the shortest periods first."""
    waiting = lanes[ends.period[lanes] > 0]
    waiting = waiting[np.argsort(ends.period[waiting], kind="stable")]
    found: list[Motion] = []
    while len(waiting) and len(found) < MOST_MOTIONS:
        turns, state = int(ends.period[waiting[0]]), ends.state[:, waiting[0]]
        times = 2.0 * np.pi / system.omega * np.arange(turns * PER_TURN + 1) / PER_TURN
        run = simulate(system, state, times, method=Dopri5(rtol=1e-9, atol=1e-13 * float(np.max(np.abs(state)))))
        scale = np.maximum(np.max(np.abs(run.y), axis=1), 1e-300)
        turns = fewest(run.y[:, ::PER_TURN], turns, scale, NEAR)
        found.append(Motion(system.omega, turns, run.y[:, : turns * PER_TURN]))
        points = run.y[:, : turns * PER_TURN : PER_TURN].T
        waiting = waiting[1:][distance(points, ends.state[:, waiting[1:]], scale) >= NEAR]
    return found


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
    """Where starts at one frequency are drawn from."""
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
    reach = max(min(top, float(np.max(np.abs(x - middle)[met], initial=0.0))), 2.0 * float(distant))
    reach = reach if reach > 0.0 else top
    inside = np.abs(x - middle) <= reach
    low, high = float(np.min(x[inside])), float(np.max(x[inside]))
    if len(rests) and pull[inside][0] > 0.0:  # beyond the outermost rest the law pushes away
        low = max(low, float(rests[0]))
    if len(rests) and pull[inside][-1] < 0.0:
        high = min(high, float(rests[-1]))
    grid = np.linspace(low, high, 513)
    with np.errstate(all="ignore"):
        energy = np.cumsum(law.torque(grid) + 0.0 * grid - mean) * (grid[1] - grid[0])
    speed = float(np.sqrt(2.0 * np.ptp(energy[np.isfinite(energy)]) / system.J))
    calm = about[:-1] > 0.0
    if not np.any(calm):
        rests, about, calm = np.array([middle]), np.array([omega, 0.0]), np.array([True])
    return Box(low, high, max(speed, omega * 0.5 * (high - low)), rests[calm], about[:-1][calm])


def _roots(x: Floats, pull: Floats) -> Floats:
    """Where the torque of the law, sampled at x, balances the mean torque: by linear interpolation."""
    at = np.flatnonzero(np.isfinite(pull[1:]) & np.isfinite(pull[:-1]) & (pull[1:] * pull[:-1] <= 0.0))
    fall = pull[at] - pull[at + 1]
    share = np.divide(pull[at], fall, out=np.zeros(len(at)), where=fall != 0.0)
    return np.unique(x[at] + share * (x[at + 1] - x[at]))


def starts_in(box: Box, draws: Floats) -> Floats:
    """States (2, starts) from numbers between 0 and 1."""
    half = draws.shape[1] // 2
    even = np.stack([box.low + draws[0] * (box.high - box.low), (2.0 * draws[1] - 1.0) * box.speed])
    size, angle = box.size * 10.0 ** (-2.0 * draws[2]), 2.0 * np.pi * draws[3]
    which = (draws[0] * len(box.rests)).astype(int)
    about = np.stack([box.rests[which] + size * np.cos(angle), size * box.rates[which] * np.sin(angle)])
    return np.concatenate([even[:, :half], about[:, half:]], axis=1)
