"""How much of a periodic motion lies beyond its last harmonic: the limits, the estimate and the sentence.

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

from ...results import Floats, Status
from ...sentences import Sentence, Speed
from ...tree import mapped, with_leaf
from .first_order import FirstOrder, jacobians_at, panels, rates_at
from .fourier import analysis, synthesis
from .second_order import all_orders

CURVE, ORBIT, FREE, MATTERS = 1e-6, 1e-10, 1e-11, 1e-3
LOOKED_AT, FEW = 12, 4  # points of a curve where what is left out is estimated; of a general system
SMALL = 1e-3  # of the largest motion on a curve: below it rounding is all, as at no load


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
        at = Speed(self.value) if path == "omega" else Sentence(f"{self.value:.6g}, omega = {{}},", Speed(omega))
        share = f"{min(100.0, 100.0 * self.share):.2g} %"
        sentence = Sentence(
            "{}; at {} = {} the harmonics left out hold about {} of the response: take more than {} harmonics",
            message, path, at, share, self.harmonics,
        )  # fmt: skip
        return Status.TRUNCATED if status else status, sentence


def tail_along(problem: Any, points: Floats, aim: float = np.inf) -> Tail:
    """Tail of a curve of orbits (coefficients in blocks, parameter last).

    What is left out is estimated only if the last two harmonics alone hold no more than `aim`.
    """
    general = isinstance(problem, FirstOrder)
    series = points[:, :-1] if general else all_orders(problem, points[:, :-1])
    if problem.leaf != problem.omega_leaf:
        size = np.linalg.norm(series, axis=1)
        kept = size > SMALL * np.max(size, initial=0.0)
        points, series = points[kept], series[kept]
    h = (len(problem.error) if general else series.shape[1]) // 2
    if not len(points):
        return Tail(0.0, 0.0, np.nan, h)
    last = tails_of_states(problem, series) if general else tail_of(series)[:, None]
    at, worst = int(np.argmax(last[:, 0])), float(np.max(last))
    if worst > aim:
        return Tail(float(last[at, 0]), worst, float(points[at, -1]), h)
    if not general:
        few = _few(points)
        omega = points[few, -1:]
        system = problem.system
        if problem.leaf == problem.omega_leaf:
            system = system._replace(omega=omega)
        else:
            system = with_leaf(system, problem.leaf, omega)
        shares = _left_out(system, problem.turns, series[few])
        here = int(np.argmax(shares))
        return Tail(float(shares[here]), max(worst, float(shares[here])), float(omega[here, 0]), h)
    some = np.unique([*range(0, len(points), max(1, len(points) // FEW)), int(np.argmax(np.max(series, axis=1))), at])
    beyond = _left_out_general(problem, points[some])
    here = int(np.argmax(beyond[:, 0]))
    return Tail(float(beyond[here, 0]), max(worst, float(np.max(beyond))), float(points[some[here], -1]), h)


def tails_together(problems: list[Any], curves: list[Floats]) -> list[Tail]:
    """Tails of curves of oscillators of one class, with equal harmonics, by what they leave out; all at once."""
    few = [points[_few(points)] for points in curves]
    counts = [len(points) for points in few]
    first, points = problems[0], few[0] if len(few) == 1 else np.concatenate(few)
    if first.leaf == first.omega_leaf:
        system = stacked([problem.system for problem in problems], counts)._replace(omega=points[:, -1:])
    else:
        system = with_leaf(first.system, first.leaf, points[:, -1:])
    series = all_orders(first, points[:, :-1])
    shares = _left_out(system, first.turns, series)
    found, end = [], 0
    for count in counts:
        own, end = shares[end : end + count], end + count
        worst = int(np.argmax(own)) if count else 0
        share, value = (float(own[worst]), float(points[end - count + worst, -1])) if count else (0.0, np.nan)
        found.append(Tail(share, share, value, series.shape[1] // 2))
    return found


def _few(points: Floats) -> list[int]:
    """Places of some points of a curve, and of the largest."""
    places = list(range(0, len(points), max(1, len(points) // LOOKED_AT)))
    return [*places, int(np.argmax(np.abs(points[:, :-1]).max(axis=1)))] if len(places) > 1 else places


def stacked(things: list[Any], counts: list[int]) -> Any:
    """Model of the class of several, whose numbers that differ are columns: each thing's own, `counts` times."""
    if len(things) == 1:
        return things[0]
    return mapped(lambda *own: own[0] if len({*own}) == 1 else np.repeat(own, counts)[:, None], *things)


def tail_of(points: Floats) -> Floats:
    """Size of the last two harmonics relative to the whole, at every point (coefficients in blocks)."""
    h = points.shape[1] // 2
    squares = points * points
    last = squares[:, max(1, h - 1) : h + 1].sum(axis=1) + squares[:, max(1, 2 * h - 1) :].sum(axis=1)
    return np.asarray(np.sqrt(last) / np.maximum(np.sqrt(squares.sum(axis=1)), 1e-300))


def tails_of_states(problem: FirstOrder, series: Floats) -> Floats:
    """Size (points, states) of the last two harmonics of every state relative to that state's whole."""
    h = len(problem.error) // 2
    series = series.reshape(len(series), len(problem.sizes), -1)
    last = [k for k in (h - 1, h, 2 * h - 1, 2 * h) if k > 0]
    size = np.linalg.norm(series, axis=2)
    floor = 1e-6 * np.max(size, axis=0, initial=1e-300)
    return np.asarray(np.linalg.norm(series[:, :, last], axis=2) / np.maximum(size, floor))


def _left_out(system: Any, turns: int, series: Floats) -> Floats:
    """Share (points,) of the motion in the harmonics H+1 .. 3H+8, estimated from the torque."""
    h = series.shape[1] // 2
    most = 3 * h + 8
    samples = 3 * most
    u = series @ synthesis(h, samples)
    with np.errstate(all="ignore"):
        torque = (system.law.torque(u) + np.zeros_like(u)) @ analysis(most, samples)
        stiffness = np.mean(system.law.stiffness(u) + np.zeros_like(u), axis=1, keepdims=True)
        w = system.omega / turns * np.arange(h + 1, most + 1)
        beyond = np.hypot(torque[:, h + 1 : most + 1], torque[:, most + h + 1 :])
        response = beyond / np.hypot(stiffness - system.J * w * w, system.B * w)
    return _share(np.linalg.norm(response, axis=1), np.linalg.norm(series, axis=1))


def _left_out_general(problem: FirstOrder, points: Floats) -> Floats:
    """Share (points, states) of each state in the harmonics H+1 .. 3H+8, estimated from the rates."""
    h, states = len(problem.error) // 2, len(problem.sizes)
    most = 3 * h + 8
    motion, share = np.zeros((states, 2 * most + 1)), np.zeros((len(points), states))
    k = np.arange(h + 1, most + 1)
    sizes = np.linalg.norm(points[:, :-1].reshape(len(points), states, -1), axis=2)
    floor = 1e-6 * np.max(sizes, axis=0)
    for i, point in enumerate(points):
        y = problem.states(point)
        motion[:, : h + 1], motion[:, most + 1 : most + h + 1] = y[:, : h + 1], y[:, h + 1 :]
        system = with_leaf(problem.system, problem.leaf, float(point[-1]))
        if problem.kinked:
            angles, table, back = panels(system, motion, problem.turns, 1)
        else:
            angles, table, back = _uniform(most, problem.turns)
        with np.errstate(all="ignore"):
            there = motion @ table
            rates = rates_at(system, angles, there) @ back
            mean = jacobians_at(system, angles, there, problem.sizes, problem.difference()) @ back[:, 0]
            force = rates[:, k] - 1j * rates[:, most + k]
            w = problem.base(point) / problem.turns * k
            response = np.linalg.solve(1j * w[:, None, None] * np.eye(states) - mean, force.T[:, :, None])[:, :, 0]
        share[i] = _share(np.linalg.norm(response, axis=0), np.maximum(sizes[i], floor) * problem.sizes)
    return share


def _share(part: Floats, whole: Floats) -> Floats:
    """Part of a whole: none of nothing, and all of it where the part is unknown."""
    share = np.divide(part, whole, out=np.zeros_like(whole), where=whole > 0.0)
    return np.where(np.isfinite(share), np.minimum(share, 1.0), 1.0)


def _uniform(harmonics: int, turns: float) -> tuple[Floats, Floats, Floats]:
    """Base angles of equal steps over a period, synthesis and analysis there."""
    samples = 4 * harmonics
    angles = 2.0 * np.pi * turns * np.arange(samples) / samples
    return angles, synthesis(harmonics, samples), analysis(harmonics, samples)
