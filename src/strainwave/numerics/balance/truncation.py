"""Share of a periodic motion beyond its last harmonic: the limits, the estimate and the sentence.

The tail of a result is the share of its first state that the harmonics left out hold: estimated as the linear response
to what the torque has beyond the last harmonic. Harmonics grow until neither it nor the share of the last two harmonics
of any state is above a limit. Neither is enough alone: a line of order 6 on an odd law moves orders 6, 18, 30, ... and
nothing at 7 and 8; and what the torque has beyond the last harmonic is itself computed without what is left out.

| limit | of | what it is for |
|---|---|---|
| `CURVE` | 1e-6 | the verbs that follow curves take more harmonics until both are below it |
| `ORBIT` | 1e-10 | the same for `find_orbit` |
| `FREE` | 1e-11 | the same for `backbone` |
| `MATTERS` | 1e-3 | above it the status is `Status.TRUNCATED`; the figures of a report take harmonics until it is met |
"""

from typing import Any, NamedTuple

import numpy as np

from ...base.protocols import Balance
from ...base.results import Floats, Status
from ...base.sentences import Sentence, Speed
from ...compile.tree import with_leaf
from .fourier import analysis, orders, panels, synthesis
from .rates import base_speed, jacobians_at, rates_at

CURVE, ORBIT, FREE, MATTERS = 1e-6, 1e-10, 1e-11, 1e-3
LOOKED_AT = 12  # points of a curve where what is left out is estimated
SMALL_MOTION = 1e-3  # of the largest motion on a curve: below it rounding is all, as at no load


class Tail(NamedTuple):
    """Share of the first state beyond the last harmonic, where it is largest, and what the harmonics grow by.

    `worst` is the largest share that the last two harmonics hold of a state, or those left out, if that is more.
    """

    share: float
    worst: float
    value: float
    harmonics: int

    def verdict(self, status: Status, message: str, path: str, omega: float) -> tuple[Status, str]:
        """Status and sentence of a result that has this tail; `omega` is its base frequency [rad/s]."""
        if not self.share > MATTERS:
            return status, message
        parameter = Speed(self.value) if path == "omega" else Sentence(f"{self.value:.6g}, omega = {{}},", Speed(omega))
        share = f"{min(100.0, 100.0 * self.share):.2g} %"
        sentence = Sentence(
            "{}; at {} = {} the harmonics left out hold about {} of the response: take more than {} harmonics",
            message, path, parameter, share, self.harmonics,
        )  # fmt: skip
        return Status.TRUNCATED if status else status, sentence


def tail_along(problem: Balance, points: Floats, aim: float | None = None) -> Tail:
    """Tail of a curve of orbits (coefficients in blocks, parameter last).

    What is left out is estimated only if the last two harmonics alone hold no more than `aim`. Without one these count
    for nothing in `worst` of an oscillator, where one asks for the share alone.
    """
    if problem.leaf != problem.omega_leaf:
        size = np.linalg.norm(points[:, :-1], axis=1)
        points = points[size > SMALL_MOTION * np.max(size, initial=0.0)]
    h = problem.highest()
    if not len(points):
        return Tail(0.0, 0.0, np.nan, h)
    largest, worst = 0, 0.0
    if aim is not None or not problem.hill():
        last = tails_of(problem.series(points))
        largest, worst = int(np.argmax(last[:, 0])), float(np.max(last))
        if aim is not None and worst > aim:
            return Tail(float(last[largest, 0]), worst, float(points[largest, -1]), h)
    values, shares = problem.left_out(points, largest)
    index = int(np.argmax(shares[:, 0]))
    return Tail(float(shares[index, 0]), max(worst, float(np.max(shares))), float(values[index]), h)


def few_of(points: Floats) -> list[int]:
    """Places of some points of a curve, and of the largest."""
    places = list(range(0, len(points), max(1, len(points) // LOOKED_AT)))
    if len(places) > 1:
        places.append(int(np.argmax(np.abs(points[:, :-1]))) // (points.shape[1] - 1))
    return places


def tails_of(series: Floats) -> Floats:
    """Size (points, states) of the last two harmonics of series (points, states, 2H+1) relative to each one's whole."""
    h = series.shape[2] // 2
    squares = series * series
    last = squares[:, :, max(1, h - 1) : h + 1].sum(axis=2) + squares[:, :, max(1, 2 * h - 1) :].sum(axis=2)
    size = np.sqrt(squares.sum(axis=2))
    return np.asarray(np.sqrt(last) / np.maximum(size, 1e-6 * np.max(size, axis=0, initial=1e-300)))


def share_left_out(system: Any, turns: int, series: Floats, stride: int) -> Floats:
    """Share (points,) of the motion in the harmonics H+1 .. 3H+8, with stride 2 the odd ones, from the torque."""
    h = series.shape[1] // 2
    top = 3 * h + (8 if stride == 1 else 3)
    samples = 3 * top
    u = series @ synthesis(h, samples, stride)
    with np.errstate(all="ignore"):
        torque = (system.law.torque(u) + np.zeros_like(u)) @ analysis(top, samples, stride)
        stiffness = np.mean(system.law.stiffness(u) + np.zeros_like(u), axis=1, keepdims=True)
        w = system.omega / turns * orders(top, stride)[h:]
        beyond = np.hypot(torque[:, h + 1 : top + 1], torque[:, top + h + 1 :])
        response = beyond / np.hypot(stiffness - system.J * w * w, system.B * w)
    return share_of(np.linalg.norm(response, axis=1), np.linalg.norm(series, axis=1))


def shares_left_out(problem: Any, points: Floats) -> Floats:
    """Share (points, states) of each state in the harmonics H+1 .. 3H+8, estimated from the rates."""
    h, states = problem.harmonics(), len(problem.sizes)
    top = 3 * h + 8
    motion, share = np.zeros((states, 2 * top + 1)), np.zeros((len(points), states))
    k = np.arange(h + 1, top + 1)
    sizes = np.linalg.norm(points[:, :-1].reshape(len(points), states, -1), axis=2)
    floor = 1e-6 * np.max(sizes, axis=0)
    for i, (point, y) in enumerate(zip(points, problem.series(points), strict=True)):
        motion[:, : h + 1], motion[:, top + 1 : top + h + 1] = y[:, : h + 1], y[:, h + 1 :]
        system = with_leaf(problem.system, problem.leaf, float(point[-1]))
        if problem.kinked:
            angles, table, back = panels(system, motion, problem.turns, 1)
        else:
            samples = 4 * top
            angles = 2.0 * np.pi * problem.turns * np.arange(samples) / samples
            table, back = synthesis(top, samples), analysis(top, samples)
        with np.errstate(all="ignore"):
            sampled = motion @ table
            rates = rates_at(system, angles, sampled) @ back
            mean = jacobians_at(system, angles, sampled, problem.sizes, problem.difference()) @ back[:, 0]
            force = rates[:, k] - 1j * rates[:, top + k]
            w = base_speed(problem, float(point[-1])) / problem.turns * k
            response = np.linalg.solve(1j * w[:, None, None] * np.eye(states) - mean, force.T[:, :, None])[:, :, 0]
        share[i] = share_of(np.linalg.norm(response, axis=0), np.maximum(sizes[i], floor) * problem.sizes)
    return share


def share_of(part: Floats, total: Floats) -> Floats:
    """Share of a part in a total: none of nothing, and all of it where the part is unknown."""
    share = np.divide(part, total, out=np.zeros_like(total), where=total > 0.0)
    return np.where(np.isfinite(share), np.minimum(share, 1.0), 1.0)
