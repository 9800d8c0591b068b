"""Attractors recognised among settled lanes: periodic orbits by `find_orbit`, and which lanes ended on which.

Motions on which random starts settle at given base frequencies: what coexists there and attracts.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import islice
from typing import Any

import numpy as np

from ...base.law import breakpoints_of
from ...base.protocols import Balance, System, omega_of
from ...base.quantities import replace
from ...base.results import Floats, Integers, Orbit, SolveError
from ..balance.fourier import orders
from ..balance.linear_part import carried, drive
from ..integration.methods import Dopri5
from ..integration.simulate import simulate
from ..shooting import find_orbit
from .settle import Settled, settled

STARTS = (
    100  # at each frequency: a motion that 3 % of the box lead to is missed once in twenty searches of one frequency
)
SEED = 20
DECAY = 16.0  # transients die by exp(-16), 1e-7, in the longest time
FIRST_TURNS, LEAST_TURNS, MOST_TURNS = 30, 300, 6000
MOST_MOTIONS = 20  # at one frequency
MOST_STEPS = 3.2e9  # of all starts together at a time: half a minute
LEAST_DAMPING = 1e-4  # of critical, that bounds the vibrations which are looked for
FASTEST = (
    2.0  # times the highest line of the forcing, or the free vibration about a rest: what vibrates faster is left out
)
SIZES = np.geomspace(1e-6, 1e6, 241)

END_GAP = 1e-3  # of a state's size: lanes as near as this to an attractor's point have ended on it
SAME_TURN = 1e-6  # of a state's size: two turns that agree so well are one
MOST_SETTLED = 200  # settled motions that are looked at one by one
PER_TURN = 64  # samples of the motion from which an orbit's coefficients are guessed
NOT_RECOGNISED = -3


@dataclass(frozen=True, eq=False)
class Attractor:
    """A periodic motion on which initial states end.

    Attributes
    ----------
    period : int
        Turns of the base angle after which it repeats.
    lowest, highest : float
        Extremes of the first state [rad].
    points : (period, states) array
        States at base phase 0, turn after turn.
    multiplier : float
        Largest modulus of its Floquet multipliers; nan where `find_orbit` did not find it.
    stable : bool
        True if that is below 1.
    """

    period: int
    lowest: float
    highest: float
    points: Floats
    multiplier: float
    stable: bool

    @property
    def peak(self) -> float:
        """Largest absolute value of the first state [rad]."""
        return max(abs(self.lowest), abs(self.highest))

    @property
    def amplitude(self) -> float:
        """Half the distance between its extremes [rad]."""
        return 0.5 * (self.highest - self.lowest)

    def __str__(self) -> str:
        exact = np.isfinite(self.multiplier)
        kind = (
            f"{'stable' if self.stable else 'unstable'}, multiplier {self.multiplier:.4f}" if exact else "by eye only"
        )
        x, v = self.points[0, :2]
        return f"period {self.period}, amplitude {self.amplitude:.5g}, {kind}, through ({x:.5g}, {v:.5g})"


def recognised(system: System, ends: Settled) -> tuple[Integers, tuple[Attractor, ...]]:
    """Label (lanes,) of the attractor on which every lane ended (-3: on none), and the attractors, largest first."""
    label = np.full(len(ends.period), NOT_RECOGNISED, np.int64)
    motions: list[Attractor] = []
    for motion, scale, lanes in islice(motions_among(system, ends, np.arange(len(label))), MOST_SETTLED):
        attractor = _attractor(system, ends, int(lanes[0]), motion, scale)
        index = next((i for i, former in enumerate(motions) if _same(former, attractor, scale)), len(motions))
        if index == len(motions):
            motions.append(attractor)
        label[lanes] = index
    order = np.argsort([-np.count_nonzero(label == i) for i in range(len(motions))], kind="stable")
    rank = np.empty(len(motions) + 1, np.int64)
    rank[order], rank[-1] = np.arange(len(motions)), NOT_RECOGNISED
    return rank[np.maximum(label, -1)], tuple(motions[i] for i in order)


def distance(points: Floats, states: Floats, scale: Floats) -> Floats:
    """Distance (lanes,) of states (states, lanes) to the nearest of the points (period, states), in state sizes."""
    gaps = np.abs(points[:, :, None] - states[None]) / scale[None, :, None]
    return np.asarray(np.min(np.max(gaps, axis=1), axis=0))


def _same(old: Attractor, seen: Attractor, scale: Floats) -> bool:
    return old.period == seen.period and bool(distance(old.points, seen.points[:1].T, scale)[0] < 10.0 * END_GAP)


def _attractor(system: Any, ends: Settled, lane: int, motion: "Motion", scale: Floats) -> Attractor:
    """Attractor on which a settled lane is, with its motion and the sizes (states,) of its states."""
    turns, y = motion.turns, motion.samples
    orbit = _orbit(system, y, turns, scale)
    if orbit is None:
        low, high = float(ends.lowest[lane]), float(ends.highest[lane])
        return Attractor(turns, low, high, y[:, ::PER_TURN].T, np.nan, False)
    points = orbit.state(np.asarray(2.0 * np.pi * np.arange(turns + 1), float))
    fewer = fewest(points, turns, scale, SAME_TURN)
    if fewer < turns:
        orbit = _orbit(system, y[:, : fewer * PER_TURN], fewer, scale) or orbit
    x = orbit.state(np.asarray(np.linspace(0.0, 2.0 * np.pi * fewer, 4096 * fewer), float))[0]
    low, high, size = float(np.min(x)), float(np.max(x)), float(np.max(np.abs(orbit.multipliers)))
    return Attractor(fewer, low, high, points[:, :fewer].T, size, orbit.stable)


def fewest(points: Floats, turns: int, scale: Floats, tolerance: float) -> int:
    """Smallest divisor of the turns after which the first of the points (states, turns + 1) comes back."""
    for n in range(1, turns):
        if turns % n == 0 and np.all(np.abs(points[:, n] - points[:, 0]) < tolerance * scale):
            return n
    return turns


def _orbit(system: System, y: Floats, turns: int, scale: Floats) -> Orbit | None:
    """Periodic orbit near the samples (states, samples) of one period; None where it is not found there."""
    samples = y.shape[1]
    spectrum = np.fft.rfft(y, axis=1).T * (2.0 / samples)
    h = min(len(spectrum) - 1, 31 * turns)
    series = np.empty((2 * h + 1, len(y)))
    series[0], series[1::2], series[2::2] = spectrum[0].real / 2.0, spectrum[1 : h + 1].real, -spectrum[1 : h + 1].imag
    try:
        orbit = find_orbit(system, guess=series, period=turns)
    except (ValueError, TypeError, SolveError):  # a system without periodic orbits that `find_orbit` can look for
        return None
    gap = np.abs(orbit.state(0.0) - y[:, 0]) / scale if orbit.status.found else np.array([np.inf])
    return orbit if float(np.max(gap)) < 20.0 * END_GAP else None


@dataclass(frozen=True, eq=False)
class Motion:
    """A settled motion: its shortest period in turns and samples (states, 64 turns) over it, from base phase 0 on."""

    omega: float
    turns: int
    samples: Floats


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


def motions_among(system: System, ends: Settled, lanes: Integers) -> Iterator[tuple[Motion, Floats, Integers]]:
    """The different motions on which lanes of one frequency have settled, the shortest periods first.

    With each the sizes (states,) of its states, and the lanes that are on it.
    """
    waiting = lanes[ends.period[lanes] > 0]
    waiting = waiting[np.argsort(ends.period[waiting], kind="stable")]
    omega = float(omega_of(system))
    while len(waiting):
        turns, state = int(ends.period[waiting[0]]), ends.state[:, waiting[0]]
        times = 2.0 * np.pi / omega * np.arange(turns * PER_TURN + 1) / PER_TURN
        method = Dopri5(rtol=1e-10, atol=1e-14 * float(np.max(np.abs(state)) + 1e-12))
        run = simulate(system, state, times, method=method)
        scale = np.maximum(np.max(np.abs(run.y), axis=1), 1e-300)
        turns = fewest(run.y[:, ::PER_TURN], turns, scale, END_GAP)
        motion = Motion(omega, turns, run.y[:, : turns * PER_TURN])
        reached = distance(motion.samples[:, ::PER_TURN].T, ends.state[:, waiting], scale) < END_GAP
        reached[0] = True
        yield motion, scale, waiting[reached]
        waiting = waiting[~reached]


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
