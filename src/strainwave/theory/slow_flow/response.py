"""Response curves of the slow flow: every branch of steady states over a range of speeds, ordered along its arc.

They are seeded by all steady states on a grid of speeds, so that closed loops are met too.
"""

import itertools
import math
from dataclasses import replace
from typing import Any

import numpy as np

from ...base.blas import one_thread
from ...base.results import Complexes, Floats
from .arcs import Arc, Curve, new_part, passes, special, trace
from .fixed_points import Flow, are_stable
from .results import SlowBranch, SlowResponse
from .states import states

SEEDS = 33  # speeds of the grid
SAME_CREST = 1e-9  # relative difference of amplitudes at one crest
PER_CYCLE = 64  # samples of the fastest component: a peak between them is right to 1e-3


@one_thread
def response(flow: Flow, lo: float, hi: float) -> SlowResponse:
    """Trace every branch of nontrivial steady states between two speeds [rad/s]."""
    speeds = np.array([omega for omega in np.linspace(lo, hi, SEEDS) if not flow.setting.sits_on(float(omega))])
    table = states(flow, speeds)
    i, row = np.nonzero(np.isfinite(table.z.T))
    listed = list(zip(table.z[row, i].tolist(), speeds[i].tolist(), table.stable[row, i].tolist(), strict=True))
    seeds = [(z, omega) for z, omega, _ in listed if z != 0.0]
    trivial = [(omega, stable) for z, omega, stable in listed if z == 0.0]
    curve = Curve(flow, max((abs(z) for z, _ in seeds), default=1.0), hi - lo)
    arcs: list[Arc] = []
    for z, omega in seeds:
        if not any(passes(curve, arc.points, z, omega) for arc in arcs):
            start = curve.join(z, omega)
            arc = new_part(curve, trace(curve, start, lo / curve.width, hi / curve.width), arcs, start)
            arcs += [arc] if len(arc.points) > 1 else []
    if not arcs:
        message = f"no steady state with a > 0 was found between {lo:.6g} and {hi:.6g} rad/s ({SEEDS} speeds searched)"
        return SlowResponse((), (), (), (0.5 * (lo + hi), 0.0), tuple(trivial), message)
    return _assembled(curve, arcs, tuple(trivial))


def _assembled(curve: Curve, arcs: list[Arc], trivial: tuple[tuple[float, bool], ...]) -> SlowResponse:
    """The response of traced arcs: branches from the largest on, folds by their speeds, the peak and the sentence."""
    branches, crests = [], []
    for arc in arcs:
        points, on_arc = _with_crests(curve, arc.points)
        branches.append(_branch(curve, points, arc.closed))
        crests += on_arc
    branches.sort(key=lambda branch: float(np.max(branch.amplitude)), reverse=True)
    peak = max((*crests, *map(_largest, branches)), key=_amplitude)
    folds = sorted(_speed_and_amplitude(curve, point) for arc in arcs for point in arc.folds)
    speeds, amplitudes = tuple(omega for omega, _ in folds), tuple(map(_amplitude, folds))
    return SlowResponse(tuple(branches), speeds, amplitudes, peak, trivial, _message(curve, arcs, crests, peak))


def _with_crests(curve: Curve, points: Floats) -> tuple[Floats, list[tuple[float, float]]]:
    """Points of an arc and, between them, those where the amplitude stands still; their speeds and amplitudes."""
    ahead = np.diff(points, axis=0)
    tangents = [curve.tangent(p, d) for p, d in zip(points, np.vstack([ahead, ahead[-1:]]), strict=True)]
    every, crests = [points[0]], []
    for i, (a, b) in enumerate(itertools.pairwise(points)):
        turns = _growth(a, tangents[i]) * _growth(b, tangents[i + 1]) < 0.0
        crest = special(curve, a, b, _growth) if turns else None
        if crest is not None:
            every.append(crest)
            crests.append(_speed_and_amplitude(curve, crest))
        every.append(b)
    return np.array(every), crests


def _growth(point: Floats, tangent: Floats) -> float:
    """Half the growth of the squared amplitude along the arc."""
    return float(point[:2] @ tangent[:2])


def _speed_and_amplitude(curve: Curve, point: Floats) -> tuple[float, float]:
    z, omega = curve.split(point)
    return omega, abs(z)


def _amplitude(pair: tuple[float, float]) -> float:
    return pair[1]


def _largest(branch: SlowBranch) -> tuple[float, float]:
    """Speed and amplitude of the largest point of a branch."""
    i = int(np.argmax(branch.amplitude))
    return float(branch.omega[i]), float(branch.amplitude[i])


def _message(curve: Curve, arcs: list[Arc], crests: list[tuple[float, float]], peak: tuple[float, float]) -> str:
    """Sentence on a response: its counts, its peak, and where branches begin or stop."""
    counts = f"{len(arcs)} branch(es), {sum(len(arc.folds) for arc in arcs)} fold(s)"
    message = f"{counts}, largest amplitude {peak[1]:.6g} rad at omega = {peak[0]:.6g} rad/s"
    if all(abs(size - peak[1]) > SAME_CREST * peak[1] for _, size in crests):
        message += ", an end of a branch and no peak: it may rise further outside the range"
    born = ", ".join(f"{curve.split(point)[1]:.6g}" for arc in arcs for point in arc.born)
    stops = ", ".join(f"{curve.split(point)[1]:.6g}" for arc in arcs for point in arc.stops)
    message += f"; begins at a = 0 at omega = {born} rad/s" if born else ""
    if stops:
        message += f"; a branch stops inside the range at omega = {stops} rad/s: take a smaller range or more damping"
    return message


def _branch(curve: Curve, points: Floats, closed: bool) -> SlowBranch:
    z: Any = curve.size * (points[:, 0] + 1j * points[:, 1])
    omega = curve.width * points[:, 2]
    stable = np.asarray(are_stable(curve.flow, omega, z))
    return SlowBranch(omega, np.abs(z), -np.angle(z), _envelope(curve.flow, omega, z), stable, closed)


def _envelope(flow: Flow, omega: Floats, z: Complexes) -> Floats:
    """Largest |x| [rad] over the base angle of slow states z [rad] at speeds omega [rad/s], both (n,)."""
    s = flow.setting.at(omega)
    ratio = s.resonance.ratio
    p, q = (1, 1) if ratio is None else (ratio.numerator, ratio.denominator)
    samples = PER_CYCLE * q * max(math.ceil(p / q), *s.orders, 1)
    theta = 2.0 * np.pi * q * np.arange(samples) / samples
    small = replace(flow, setting=s).small(z)
    parts = [(p / q, z), *((float(np.ravel(w)[0] / omega[0]), c) for w, c in small)]
    parts += [(float(k), s.hard[:, i]) for i, k in enumerate(s.orders)]
    amplitudes = np.stack([np.broadcast_to(c, z.shape) for _, c in parts], axis=1)
    waves = np.exp(1j * np.outer([k for k, _ in parts], theta))
    x = (amplitudes @ waves).real + s.u0 + s.system.error.value(theta)
    return np.asarray(np.max(np.abs(x), axis=1))
