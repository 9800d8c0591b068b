"""What a motion of two turns is: its beat in every turn of the motor, its states, and how its disturbances grow."""

import math
from fractions import Fraction
from typing import Any

import numpy as np

from ...base.results import Floats
from ..balance.condensed.motions import first_order_of
from ..balance.condensed.pencil import to_complex
from .problem import Torus

PER_WAVE, LEAST, REFINED = 16, 64, 4  # samples in a period of the highest wave, at least; steps of Newton's method
NEARLY = 0.9  # of the largest sample of a turn: a crest beside it may be higher between samples
STARTS, RESOLVED = 16, 1e-6  # output angles at first, and the share of the highest waves of a map in the end
LEAST_STEPS, PER_ORDER, PHASE, FINEST = 24, 12, 0.8, 2048  # steps a turn: per order, and [rad] of what is fastest
HARDLY = 1e-2  # of the largest wave: those below it do not count for the steps
LARGEST = 1000  # output turns after which motor and output stand as before, at most


def turns_of(ratio: float) -> int:
    """Motor turns after which motor and output stand as before; those of an output turn where they never do."""
    exact = Fraction(ratio).limit_denominator(LARGEST)
    return exact.numerator if abs(float(exact) - ratio) <= 1e-12 * ratio else math.ceil(ratio)


def oscillations(waves: Any, pairs: Any, ratio: float) -> Floats:
    """Largest distance (turns,) of a motion from its mean over each turn of the motor, from angle 0 on.

    The motion has the complex amplitudes `waves` (P + 1,) of `pairs` (P + 1, 2), the first of them (0, 0).
    """
    waves, order, slow = waves[1:], (pairs @ np.array([1.0, 1.0 / ratio]))[1:], pairs[1:, 1]
    count = turns_of(ratio)
    starts = 2.0 * np.pi * np.arange(count)
    places = max(LEAST, PER_WAVE * math.ceil(float(np.max(np.abs(order)))))
    theta = np.linspace(0.0, 2.0 * np.pi, places + 1)
    ks, group = np.unique(slow, return_inverse=True)
    along = np.zeros((len(ks), places + 1), complex)
    np.add.at(along, group, waves[:, None] * np.exp(1j * np.outer(order, theta)))
    turned = np.exp(1j * np.outer(starts / ratio, ks))
    mean = np.ones(len(order), complex)
    np.divide(np.exp(2j * np.pi * order) - 1.0, 2j * np.pi * order, out=mean, where=order != 0.0)
    means = (
        turned @ np.bincount(group, (waves * mean).real) + 1j * turned @ np.bincount(group, (waves * mean).imag)
    ).real
    values = (turned @ along).real - means[:, None]
    sizes = np.abs(np.pad(values, ((0, 0), (1, 1)), constant_values=0.0))
    tops = (sizes[:, 1:-1] >= sizes[:, :-2]) & (sizes[:, 1:-1] >= sizes[:, 2:])
    turn, place = np.nonzero(tops & (sizes[:, 1:-1] >= NEARLY * sizes.max(axis=1, keepdims=True)))
    angle, offset = theta[place], waves * turned[:, group][turn]
    low, high = np.maximum(angle - theta[1], 0.0), np.minimum(angle + theta[1], 2.0 * np.pi)
    for _ in range(REFINED):
        terms = offset * np.exp(1j * np.outer(angle, order))
        slope, bend = -(order * terms.imag).sum(axis=1), -(order * order * terms.real).sum(axis=1)
        angle = np.clip(angle - np.divide(slope, bend, out=np.zeros(len(turn)), where=bend != 0.0), low, high)
    between = np.abs((offset * np.exp(1j * np.outer(angle, order))).real.sum(axis=1) - means[turn])
    largest = sizes.max(axis=1)
    np.maximum.at(largest, turn, between)
    return np.asarray(largest)


def states_at(problem: Torus, z: Floats, phase: Floats) -> Floats:
    """States (states, n) of the system at base angles (n,) [rad]."""
    waves, part = problem.coordinates(z), problem.part
    turned = np.exp(1j * np.outer(problem.orders, phase))
    rates = waves * (1j * problem.orders * z[-1])[:, None]
    return np.asarray((part.values @ waves.T @ turned + part.rates @ rates.T @ turned).real)


def growth(problem: Torus, flow: Any, z: Floats) -> float:
    """Rate [1/s] at which the disturbances that grow fastest, or decay slowest, do so over all turns of a motion.

    `flow` is the part whose disturbances are meant: that of the problem, but for a mean that nothing holds. A turn of
    the motor maps them by a matrix that is periodic in the output's angle at its begin: it is found at some of these
    angles and interpolated at those that the motion has, whose product tells the rate.
    """
    count, places = turns_of(problem.ratio), STARTS
    while True:
        starts = 2.0 * np.pi * np.arange(min(places, count)) / min(places, count)
        maps = turn_maps(problem, flow, z, starts)
        waves = np.fft.fft(maps, axis=0) / len(maps)
        size, k = np.abs(waves).max(axis=(1, 2)), np.abs(np.fft.fftfreq(len(maps), 1.0 / len(maps)))
        if len(maps) == count or size[k >= len(maps) // 3].max() <= RESOLVED * size.max():
            break
        places *= 2
    order, size = np.fft.fftfreq(len(maps), 1.0 / len(maps)), 0.0
    whole = np.eye(maps.shape[1])
    here = 2.0 * np.pi * np.arange(count) / problem.ratio
    for turn in np.einsum("tk,kij->tij", np.exp(1j * np.outer(here, order)), waves).real:
        whole = turn @ whole
        largest = float(np.max(np.abs(whole)))
        whole, size = whole / largest, size + math.log(largest)
    top = float(np.max(np.abs(np.linalg.eigvals(whole))))
    return (size + math.log(max(top, 1e-300))) * float(z[-1]) / (2.0 * np.pi * count)


def turn_maps(problem: Torus, flow: Any, z: Floats, starts: Floats) -> Floats:
    """Maps (n, states, states) of disturbances over a turn of the motor from output angles (n,) [rad] on.

    Magnus's method of order 4 with a Pade form of the exponential function: Blanes et al. 2009, The Magnus expansion
    and some of its applications, Physics Reports 470, sec. 5.
    """
    w, heavy = float(z[-1]), np.flatnonzero(np.any(flow.inertia != 0.0, axis=1))
    massless, loaded = np.setdiff1d(np.arange(len(flow.inertia)), heavy), problem.retained
    damping = flow.damping.copy()
    damping[0, 0] += flow.gear_damping
    a, b = first_order_of(flow.inertia, damping, flow.stiffness, heavy, massless, loaded)
    place = np.searchsorted(heavy, loaded)
    fastest = float(np.max(np.abs(np.linalg.eigvals(_with_springs(problem, z, a, b, place, len(heavy))))))
    steps = int(min(FINEST, max(LEAST_STEPS, PER_ORDER * _highest(problem, z), 2.0 * np.pi * fastest / w / PHASE)))
    h = 2.0 * np.pi / steps
    theta = (np.arange(steps)[:, None] + 0.5 + np.array([-1.0, 1.0]) * math.sqrt(3.0) / 6.0).ravel() * h
    fast, slow = np.tile(theta, len(starts)), (starts[:, None] + theta / problem.ratio).ravel()
    motion = at_angles(problem, fast, slow).moved(z)
    matrices = np.tile(a, (len(fast), 1, 1))
    for (i, j), samples in motion.by_place.items():
        matrices[:, :, place[j]] -= samples[:, None] * b[:, i]
    for (i, j), samples in motion.by_rate.items():
        matrices[:, :, len(heavy) + place[j]] -= samples[:, None] / w * b[:, i]
    first, second = (h / w) * matrices[::2], (h / w) * matrices[1::2]
    omega = 0.5 * (first + second) + math.sqrt(3.0) / 12.0 * (second @ first - first @ second)
    mean = np.trace(omega, axis1=1, axis2=2) / len(a)  # what it makes of volumes is exact
    omega -= mean[:, None, None] * np.eye(len(a))
    even, odd = np.eye(len(a)) + omega @ omega / 12.0, 0.5 * omega
    maps = np.linalg.solve(even - odd, even + odd).reshape(len(starts), steps, len(a), len(a))
    while maps.shape[1] > 1:
        left = maps[:, 1::2] @ maps[:, : maps.shape[1] - 1 : 2]
        maps = left if maps.shape[1] % 2 == 0 else np.concatenate([left, maps[:, -1:]], axis=1)
    return np.asarray(maps[:, 0] * np.exp(mean.reshape(len(starts), steps).sum(axis=1))[:, None, None])


def _highest(problem: Torus, z: Floats) -> float:
    """Highest order of the waves that count."""
    sizes = np.max(np.abs(to_complex(problem.blocks(z))), axis=0)[1:]
    return float(np.max(np.abs(problem.orders[1:][sizes > HARDLY * np.max(sizes)]), initial=1.0))


def _with_springs(problem: Torus, z: Floats, a: Floats, b: Floats, place: Any, count: int) -> Floats:
    """Matrix of the disturbances with the mean stiffness and damping of all torques."""
    motion, mean = problem.moved(z), a.copy()
    for (i, j), samples in motion.by_place.items():
        mean[:, place[j]] -= np.mean(samples) * b[:, i]
    for (i, j), samples in motion.by_rate.items():
        mean[:, count + place[j]] -= np.mean(samples) / z[-1] * b[:, i]
    return mean


def at_angles(problem: Torus, fast: Floats, slow: Floats) -> Torus:
    """The problem with samples at other angles (n,) of motor and output [rad]."""
    angles = np.array([fast, slow])
    there = problem._replace(
        table=np.exp(1j * (problem.pairs @ angles)), turned=problem.line_pairs @ angles, slow=slow, memory={}
    )
    return there._replace(still_error=there.error(0.0))
