"""Averages along settled loops: laws with friction or memory in the slow flow, at first and at second order.

The motion w = Re(z E) + F, at second order with its small harmonics, is prescribed over the common period. The internal
states follow it until their loop closes, and the Fourier coefficients of the torque on that loop stand for the law: on
E they are the equivalent stiffness and the equivalent damping (Caughey 1960, J. Appl. Mech. 27(4), 640-643, for the
bilinear hysteresis). N is the torque beyond the stiffness at rest, before anything yields or slips, about the torsion
to which the mean torque loads the law slowly from rest. The mean torsion is the one at which the closed loop carries
the mean torque: hysteresis that was loaded once relaxes under a vibration.

The internal states take exponential steps z + h phi(h J) z_rate with the torsion's rate Du/h, J = d z_rate/dz: exact
where a rate-independent law is linear in z, of second order elsewhere, and stable however small the yield torsion is
(Hochbruck & Ostermann 2010, Acta Numerica 19, 209-286, sec. 2.4). The closed loop is the fixed point of one period,
found by secants in each state. Without a hard line z is turned to the real axis: the reversals are then sample points.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ....base.law import depends, spring_stiffness, states_of, torque_of, z_rate_of
from ....base.results import Complexes, Floats
from ....compile.jit import kernel, kernel_as, run
from ....compile.tree import with_leaf
from ..setting import Setting
from .law_samples import means, samples

ROUNDS, CLOSED = 16, 1e-9  # periods at most, and how near to the closed loop suffices
OPEN_GAP = 1e-6  # a loop whose gap stays larger has no average
MEANS, BALANCED, ADRIFT = 12, 1e-9, 1e-3  # mean torsions tried; off the mean torque, of the loop's: sought, refused
FEWEST, MOST_SAMPLES, TARGET = 64, 1024, 1e-4  # samples per turn of the fastest component, and the accuracy sought
REACH = {1: 1, 2: 7}  # harmonics up to this multiple of the fastest component, by the order of the expansion
STEP = 1e-5  # of the amplitude: central differences
CHUNK = 1_000_000  # samples at once
TINY = 1e-200
STATE_OFFSET = 1e-3  # of a state: its rate there gives the slope, exactly where the law is linear in it
STEEPEST = 1.0 - 1e-4  # slope of the map of one period: secants leap over as many as 10,000 of them


def remembers(law: Any) -> bool:
    """True for a law with friction or memory."""
    return depends(law) > 1


@kernel
def _stepped(law: Any, x: float, v: float, z: Any, h: float) -> Any:
    """Internal states a time h later, with the torsion x and its rate v of the middle."""
    rate, beside, after = z_rate_of(law, x, v, z), z, z
    for j in range(len(z)):
        beside = with_leaf(beside, j, z[j] + STATE_OFFSET * (abs(z[j]) + abs(h * rate[j])) + TINY)
    other = z_rate_of(law, x, v, beside)
    for j in range(len(z)):
        power = min(h * (other[j] - rate[j]) / (beside[j] - z[j]), 50.0)
        growth = math.expm1(power) / power if power != 0.0 else 1.0
        after = with_leaf(after, j, z[j] + growth * h * rate[j])
    return after


def _closed_loops(law: Any, u: Floats, v: Floats, h: Floats, zeros: Floats, torque: Floats, gap: Floats) -> None:
    n, m = u.shape[1], len(zeros)
    start, start_before, end_before = np.empty(m), np.empty(m), np.empty(m)
    size, middle = np.empty(m), np.empty(m)
    for i in range(len(u)):
        start[:] = 0.0
        for period in range(ROUNDS):
            z = zeros
            size[:], middle[:] = TINY, 0.0
            for j in range(m):
                z = with_leaf(z, j, start[j])
            for k in range(n):
                left, right = u[i, k], u[i, k + 1 if k + 1 < n else 0]
                torque[i, k] = torque_of(law, left, v[i, k], z)
                z = _stepped(law, 0.5 * (left + right), (right - left) / h[i], z, h[i])
                for j in range(m):
                    size[j], middle[j] = max(size[j], abs(z[j])), middle[j] + z[j] / n
            gap[i] = away = 0.0
            for j in range(m):
                change = start[j] - start_before[j]
                slope = (z[j] - end_before[j]) / change if period > 0 and change != 0.0 else 0.0
                missing = (z[j] - start[j]) / (1.0 - min(max(slope, -1.0), STEEPEST))
                away, gap[i] = max(away, abs(missing) / size[j]), max(gap[i], abs(z[j] - start[j]) / size[j])
                start_before[j], end_before[j] = start[j], z[j]
                start[j] += missing if period > 0 else -middle[j]
            if gap[i] == 0.0 or (period > 0 and not away > CLOSED):
                break


@kernel_as(_closed_loops)
def closed(law: Any, u: Floats, v: Floats, h: Floats, zeros: Floats, torque: Floats, gap: Floats) -> None:
    """Write the torque on the closed loop of every motion, and the relative gap left in its internal states.

    `u` [rad] and `v` [rad/s] are (motions, samples), `h` [s] (motions,) the time between samples, `zeros` as many zeros
    as the law has internal states; `torque` [N*m] (motions, samples) and `gap` (motions,) are written.
    """
    n, (x, rate) = u.shape[1], (0.5 * (u + np.roll(u, -1, axis=1)), (np.roll(u, -1, axis=1) - u) / h[:, None])
    start = np.zeros((len(zeros), len(u)))
    start_before = end_before = np.full_like(start, np.nan)
    states = np.empty((len(zeros), n, len(u)))
    with np.errstate(all="ignore"):
        for period in range(ROUNDS):
            z = start
            for k in range(n):
                states[:, k] = z
                z = _stepped_all(law, x[:, k], rate[:, k], z, h)
            slope = (z - end_before) / (start - start_before)
            missing = (z - start) / (1.0 - np.where(np.isfinite(slope), np.clip(slope, -1.0, STEEPEST), 0.0))
            size = np.max(np.abs(states), axis=1) + TINY
            gap[:] = np.max(np.abs(z - start) / size, axis=0)
            if not np.any(gap > 0.0) or (period > 0 and not np.any(np.abs(missing) > CLOSED * size)):
                break
            start_before, end_before = start, z
            start = start + (missing if period > 0 else -np.mean(states, axis=1))
    torque[:] = torque_of(law, u, v, tuple(np.ascontiguousarray(state.T) for state in states))


def _stepped_all(law: Any, x: Floats, v: Floats, z: Floats, h: Floats) -> Floats:
    """As `_stepped`, for many motions: z is (states, motions)."""
    rate = np.array(np.broadcast_arrays(*z_rate_of(law, x, v, tuple(z)), x)[:-1])
    beside = z + STATE_OFFSET * (np.abs(z) + np.abs(h * rate)) + TINY
    other = np.array(np.broadcast_arrays(*z_rate_of(law, x, v, tuple(beside)), x)[:-1])
    power = np.minimum(h * (other - rate) / (beside - z), 50.0)
    growth = np.divide(np.expm1(power), power, out=np.ones_like(power), where=power != 0.0)
    return np.asarray(z + growth * h * rate)


def on_loop(law: Any, u: Floats, v: Floats, h: Floats) -> Floats:
    """Torque [N*m] on the closed loops of motions u [rad], v [rad/s] (motions, samples); nan where one does not close.

    `h` (motions,) is the time between samples [s].
    """
    if states_of(law) == 0:
        return np.asarray(torque_of(law, u, v, ()) + 0.0 * u)
    torque, gap = np.empty_like(u), np.empty(len(u))
    run(closed, law, u, v, h, (0.0,) * states_of(law), torque, gap)
    torque[~(gap <= OPEN_GAP)] = np.nan
    return torque


@dataclass(frozen=True, eq=False)
class Loops:
    """Closed loops of a law along motions given by their harmonics over a common period.

    Attributes
    ----------
    law : NamedTuple
        Any law.
    harmonics, points : int
        H, and the samples n of the common period, a multiple of 4.
    """

    law: Any
    harmonics: int
    points: int

    def torque(self, c: Complexes, speed: Any) -> Floats:
        """Torque [N*m] (motions, n) along motions of coefficients c [rad] (motions, H+1), chi' = speed [rad/s]."""
        numbers, n = np.arange(self.harmonics + 1), self.points
        speed = np.broadcast_to(np.asarray(speed, float), len(c))
        out = np.empty((len(c), n))
        for some in np.array_split(np.arange(len(c)), max(1, math.ceil(len(c) * n / CHUNK))):
            turning = 1j * np.multiply.outer(speed[some], numbers) * c[some]
            u, v = samples(c[some], (numbers,), (n,)), samples(turning, (numbers,), (n,))
            out[some] = on_loop(self.law, u, v, 2.0 * np.pi / n / speed[some])
        return out

    def coefficients(self, torque: Floats) -> Complexes:
        """Harmonics 0..H [N*m] of torques (motions, n), by Simpson's rule: reversals may be at every other point."""
        weights = np.where(np.arange(self.points) % 2, 8.0, 4.0) / 3.0
        values = means(torque * weights, (np.arange(self.harmonics + 1),))
        values[:, 0] *= 0.5
        return values

    def carrying(self, mean: float, c: Complexes, speed: Any) -> tuple[Complexes, Complexes]:
        """Motions with the mean torsion at which their loops carry the mean torque [N*m], and the torque's harmonics.

        The mean torsion in `c` is where the search starts.
        """
        c, speed = c.copy(), np.broadcast_to(np.asarray(speed, float), len(c))
        harmonics, size = np.empty_like(c), np.zeros(len(c))
        guess = np.maximum(spring_stiffness(self.law, c[:, 0].real), 0.0) + 0.0 * size
        guess = np.where(guess > 0.0, guess, self.law.stiffness(c[:, 0].real))
        open_, before, slope = np.arange(len(c)), np.zeros(len(c)), guess.copy()
        step = np.zeros(len(c))
        for trial in range(MEANS):
            torque = self.torque(c[open_], speed[open_])
            harmonics[open_], size[open_] = self.coefficients(torque), np.max(np.abs(torque - mean), axis=1)
            excess = harmonics[open_, 0].real - mean
            if trial:
                with np.errstate(all="ignore"):
                    secant = (excess - before[open_]) / step[open_]
                ok = np.isfinite(secant)
                slope[open_] = np.where(ok, np.clip(secant, 0.02 * guess[open_], 50.0 * guess[open_]), slope[open_])
            before[open_] = excess
            left = np.abs(excess) > BALANCED * size[open_]
            open_ = open_[left]
            if not len(open_):
                return c, harmonics
            step[open_] = -before[open_] / slope[open_]
            c[open_, 0] += step[open_]
        harmonics[np.abs(before) > ADRIFT * size] = np.nan  # a very small motion hardly moves what the law remembers
        return c, harmonics


@dataclass(frozen=True, eq=False)
class LoopAverages:
    """Averages of a law with friction or memory, for both orders of the slow flow.

    Attributes
    ----------
    loops : Loops
        The law along the motion.
    fast : int
        Harmonic of E.
    places : tuple of int
        Harmonics of the forcing lines.
    """

    loops: Loops
    fast: int
    places: tuple[int, ...]

    def at(self, _: Setting) -> "LoopAverages":
        """Return the same for another speed: nothing here depends on it."""
        return self

    def coarse(self) -> "LoopAverages":
        """The same on a quarter of the samples, for a search."""
        points = max(self.loops.points // 4, 4 * (self.loops.harmonics + 1)) // 4 * 4
        return replace(self, loops=replace(self.loops, points=points))

    def force(self, s: Setting, z: Complexes) -> Complexes:
        """<N conj(E)> [N*m] for a vector of z."""
        c, torque, turn = self._first(s, z)
        return np.asarray(0.5 * self._beyond(s, c, torque)[:, self.fast] * turn)

    def linear(self, s: Setting, z: Complexes) -> tuple[Complexes, Complexes, Complexes]:
        """`force`, and its derivatives [N*m/rad] to Re z and Im z by central differences."""
        d = STEP * (np.abs(z) + 1e-3 * max(s.scales()))
        middle, *ends = self.force(s, np.concatenate([z, z + d, z - d, z + 1j * d, z - 1j * d])).reshape(5, -1)
        return middle, (ends[0] - ends[1]) / (2.0 * d), (ends[2] - ends[3]) / (2.0 * d)

    def small(self, s: Setting, z: Any) -> list[tuple[Any, Any]]:
        """Waveform beyond w at first order: the mean torsion [rad] about u0, of speed 0."""
        c, _, _ = self._first(s, np.ravel(np.asarray(z, complex)))
        return [(0.0, (c[:, 0] - s.u0).reshape(np.shape(z)))]

    def values(self, s: Setting, z: Any) -> tuple[list[tuple[Any, Any]], Any]:
        """Small harmonics, and 2 <n conj(E)> [rad/s^2]: see `second_order`."""
        shape, each = np.shape(z), np.ravel(np.asarray(z, complex))
        c, torque, turn = self._first(s, each)
        n = self._beyond(s, c, torque) / s.system.J
        numbers, base = np.arange(c.shape[1]), s.fast / self.fast
        speed = np.multiply.outer(base, numbers)
        n[:, self.places] += (1j * s.mu * speed * self._hard(s, c))[:, self.places]
        small = -n / (s.omega_0**2 - speed**2 + 1j * s.mu * speed)
        small[:, [0, self.fast]] = 0.0
        c, torque = self.loops.carrying(s.mean, c + small, base)
        back = self._beyond(s, c, torque)[:, self.fast] * turn / s.system.J
        small[:, 0] = c[:, 0] - s.u0
        # without a hard line the motion was turned: harmonic m of chi goes back by m/fast of the phase of z
        small = small * np.exp(1j * np.multiply.outer(np.angle(turn), numbers / self.fast))
        kept = [k for k in numbers if k != self.fast]
        return [(speed[..., k], small[:, k].reshape(shape)) for k in kept], back.reshape(shape)

    def _first(self, s: Setting, z: Complexes) -> tuple[Complexes, Complexes, Any]:
        """Motion u0 + Re(z E) + F about its mean torsion, the torque's harmonics, and what turns them back."""
        plain = not np.any(s.hard)
        turn = np.exp(1j * np.angle(z)) if plain else np.ones(len(z))
        c = np.zeros((len(z), self.loops.harmonics + 1), complex)
        c[:, 0] = s.u0
        c += self._hard(s, c)
        c[:, self.fast] += np.abs(z) if plain else z
        return *self.loops.carrying(s.mean, c, s.fast / self.fast), turn

    def _hard(self, s: Setting, c: Complexes) -> Complexes:
        """Coefficients [rad] of the forced motion."""
        forced = np.zeros_like(c)
        for line, harmonic in enumerate(self.places):
            forced[:, harmonic] += s.hard[..., line]
        return forced

    @staticmethod
    def _beyond(s: Setting, c: Complexes, torque: Complexes) -> Complexes:
        """Harmonics [N*m] of the torque beyond the stiffness at rest."""
        return np.asarray(torque - s.system.J * s.omega_0**2 * c)


def loop_averages(s: Setting, order: int, probes: Complexes) -> tuple[LoopAverages, float]:
    """Averages on points that are doubled until those at the states `probes` [rad] stand still, and their error.

    Raises
    ------
    ValueError
        Without resonance under a forcing, whose two free angles have no common period.
    """
    if s.resonance.ratio is None and s.orders:
        raise ValueError(
            f"{type(s.system.law).__name__} has friction or memory, and without resonance the free and the forced "
            "motion have no common period over which its loop could close; name a resonance, or integrate"
        )

    def with_points(points: int) -> LoopAverages:
        loops = Loops(s.system.law, REACH[order] * s.top, s.points(points * s.top))
        return LoopAverages(loops, max(s.fast_place, 1), s.places)

    ask: Callable[[LoopAverages], Any] = (
        (lambda a: a.force(s, probes)) if order == 1 else (lambda a: a.values(s, probes)[1])
    )
    points = FEWEST
    coarse = ask(with_points(points))
    while True:
        points *= 2
        averages = with_points(points)
        fine = ask(averages)
        size = np.nanmax(np.abs(fine), initial=0.0)
        change = float(np.nanmax(np.abs(fine - coarse), initial=0.0) / size) if size > 0.0 else 0.0
        if change <= TARGET or points >= MOST_SAMPLES:
            return averages, change
        coarse = fine
