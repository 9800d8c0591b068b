"""Where motions of a slow flow at constant speed end.

Many slow states in time at once, by a stiff Rosenbrock method in
which every lane has its own step and its own end.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ....base.results import Floats, SolveError
from ..fixed_points import Flow, is_stable, is_trivial
from ..setting import Complexes
from ..states import CLEAR, fixed_points

ROUND, ROUNDS = 6.0, 20  # of 1/mu, after which it is asked who has arrived
UNSETTLED = -1

RTOL, ABSOLUTE = 3e-5, 0.03  # of |z| and of the amplitude that matters
MOST_STEPS = 20_000
MOST_TURNED = 6000.0  # rad that a state turns by until it decays: more take about all of these steps
STEP = 1e-4  # of the amplitude and of the step in time: central differences of the rates
INSIDE = np.array([0.25, 0.5, 0.75, 1.0])  # of a step: where the largest amplitude is looked for
Rates = Callable[[Floats, Complexes, Any], Complexes]  # z' [rad/s] of (t [s], z [rad], lanes)

GAMMA = 0.25
ALPHA = (0.0, 0.386, 0.21, 0.63, 1.0, 1.0)
IN_TIME = (0.25, -0.1043, 0.1035, -0.0362, 0.0, 0.0)
A = (
    (),
    (1.544,),
    (0.9466785280815826, 0.2557011698983284),
    (3.314825187068521, 2.896124015972201, 0.9986419139977817),
    (1.221224509226641, 6.019134481288629, 12.53708332932087, -0.687886036105895),
    (1.221224509226641, 6.019134481288629, 12.53708332932087, -0.687886036105895, 1.0),
)
C = (
    (),
    (-5.6688,),
    (-2.430093356833875, -0.2063599157091915),
    (-0.1073529058151375, -9.594562251023355, -20.47028614809616),
    (7.496443313967647, -10.24680431464352, -33.99990352819905, 11.7089089320616),
    (8.083246795921522, -7.981132988064893, -31.52159432874371, 16.31930543123136, -6.058818238834054),
)


@dataclass(frozen=True, eq=False)
class March:
    """Where lanes came through.

    Attributes
    ----------
    t : (lanes, samples) array
        Times [s], equally spaced in each lane.
    z : (lanes, samples) complex array
        Slow states [rad] there.
    at_largest, largest : (lanes,) arrays
        Time [s] of the largest |z|, between the samples too, and z [rad, complex] there.
    """

    t: Floats
    z: Complexes
    at_largest: Floats
    largest: Complexes

    def of(self, lanes: Any) -> "March":
        """The same of some lanes."""
        return March(self.t[lanes], self.z[lanes], self.at_largest[lanes], self.largest[lanes])


def refuse_turned(most: float) -> None:
    """Refuse states that turn by more than so many of these angles [rad] until they decay (SolveError)."""
    if most > MOST_TURNED:
        raise SolveError(
            f"far from the resonance the slow state turns by {most:.3g} rad before it settles, more than "
            f"{MOST_TURNED:g} rad; take a higher rate, a narrower band or more damping"
        )


def march(rates: Rates, z0: Complexes, end: Floats, samples: int, size: float) -> March:
    """Integrate z' = rates(t, z, lane) from time 0 to the lanes' own ends.

    Parameters
    ----------
    rates : callable
        Rates [rad/s] of many lanes at their own times.
    z0, end : (lanes,) arrays
        Starts [rad] and end times [s].
    samples : int
        Samples of each lane, 2 or more.
    size : float
        Amplitude [rad] that matters: the local error is held at 3e-5 (|z| + 0.03 size).

    Raises
    ------
    SolveError
        If a lane takes more than 20 000 steps.
    """
    z0 = np.asarray(z0, complex)
    n, spacing = len(z0), end / (samples - 1)
    motions = March(spacing[:, None] * np.arange(samples), np.repeat(z0[:, None], samples, 1), np.zeros(n), z0.copy())
    lanes, t, filled, z = np.arange(n), np.zeros(n), np.ones(n, int), z0.copy()
    rate = rates(t, z, lanes)
    h = np.minimum(end, 0.01 * (np.abs(z0) + ABSOLUTE * size) / np.maximum(np.abs(rate), 1e-300))
    for _ in range(MOST_STEPS):
        h = np.minimum(h, end[lanes] - t)
        with np.errstate(all="ignore"):
            ahead, error = _step(rates, t, z, h, rate, lanes, size)
            miss = np.abs(error) / (RTOL * (ABSOLUTE * size + np.maximum(np.abs(z), np.abs(ahead))))
        good = miss <= 1.0
        ahead = np.where(good, ahead, z)
        end_rate = rates(t + h, ahead, lanes)
        arrived = good & (t + h >= end[lanes] * (1.0 - 1e-12))
        piece = _Piece(t, h, z, rate, ahead, end_rate)
        _store(motions, spacing, lanes, filled, good, arrived, piece)
        _keep_largest(motions, lanes, good, piece)
        t, z, rate = np.where(good, t + h, t), ahead, np.where(good, end_rate, rate)
        factor = np.where(np.isfinite(miss), 0.9 * np.maximum(miss, 1e-10) ** -0.25, 0.1)
        h = h * np.clip(factor, 0.2, 5.0)
        if np.any(arrived):
            left = ~arrived
            lanes, filled, t, h = lanes[left], filled[left], t[left], h[left]
            z, rate = z[left], rate[left]
        if not len(lanes):
            return motions
    raise SolveError(
        f"the slow flow took {MOST_STEPS} steps to t = {float(np.min(t)):.6g} of {float(np.max(end)):.6g} s; take a "
        "higher rate or a narrower band"
    )


def _step(
    rates: Rates, t: Floats, z: Complexes, h: Floats, rate: Complexes, lanes: Any, size: float
) -> tuple[Complexes, Complexes]:
    """One step of RODAS: the state at its end, and the error."""
    n, d, dt = len(z), STEP * (np.abs(z) + ABSOLUTE * size), STEP * h
    z7 = np.concatenate([z + d, z - d, z + 1j * d, z - 1j * d, z, z])
    around = rates(np.concatenate([t, t, t, t, t + dt, t - dt]), z7, np.tile(lanes, 6)).reshape(6, n)
    by_re, by_im = (around[0] - around[1]) / (2.0 * d), (around[2] - around[3]) / (2.0 * d)
    by_t = (around[4] - around[5]) / (2.0 * dt)
    factor, mirrored = 1.0 / (GAMMA * h) - 0.5 * (by_re - 1j * by_im), 0.5 * (by_re + 1j * by_im)
    denominator = np.abs(factor) ** 2 - np.abs(mirrored) ** 2
    stages: list[Complexes] = []
    place = z
    for i in range(6):
        place = z + sum(a * u for a, u in zip(A[i], stages, strict=True))
        slope = rate if i == 0 else rates(t + ALPHA[i] * h, place, lanes)
        right = slope + sum(c * u for c, u in zip(C[i], stages, strict=True)) / h + IN_TIME[i] * h * by_t
        stages.append((factor.conj() * right + mirrored * right.conj()) / denominator)
    return place + stages[-1], stages[-1]


@dataclass(frozen=True, eq=False)
class _Piece:
    """One step of every lane, with the cubic through both ends and their rates."""

    t: Floats
    h: Floats
    z: Complexes
    rate: Complexes
    ahead: Complexes
    end_rate: Complexes

    def inside(self, rows: Any, s: Any) -> Complexes:
        """States [rad] of some lanes at shares s of their steps (Hermite)."""
        h, z0, z1 = self.h[rows], self.z[rows], self.ahead[rows]
        r = 1.0 - s
        bend = r * h * self.rate[rows] - s * h * self.end_rate[rows] + (1.0 - 2.0 * s) * (z0 - z1)
        return np.asarray(r * z0 + s * z1 + s * r * bend)


def _store(motions: March, spacing: Floats, lanes: Any, filled: Any, good: Any, arrived: Any, piece: _Piece) -> None:
    """Fill in the samples inside the accepted steps; `filled` counts them."""
    last = motions.z.shape[1]
    until = np.floor((piece.t + piece.h) / spacing[lanes]).astype(int) + 1
    until = np.where(arrived, last, np.minimum(until, last - 1))
    count = np.where(good, np.maximum(until - filled, 0), 0)
    rows = np.repeat(np.arange(len(lanes)), count)
    if len(rows):
        index = np.arange(len(rows)) - np.repeat(np.cumsum(count) - count, count) + filled[rows]
        share = np.minimum((spacing[lanes[rows]] * index - piece.t[rows]) / piece.h[rows], 1.0)
        motions.z[lanes[rows], index] = piece.inside(rows, share)
        filled += count


def _keep_largest(motions: March, lanes: Any, good: Any, piece: _Piece) -> None:
    rows = np.flatnonzero(good)
    for share in INSIDE:
        z = piece.inside(rows, share)
        larger = np.abs(z) > np.abs(motions.largest[lanes[rows]])
        motions.largest[lanes[rows[larger]]] = z[larger]
        motions.at_largest[lanes[rows[larger]]] = (piece.t + share * piece.h)[rows[larger]]


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
