"""Response curves of the slow flow: every branch of steady states over a range of speeds, ordered along its arc.

They are seeded by all steady states on a grid of speeds: closed loops are met too.
"""

import itertools
import math
from fractions import Fraction

import numpy as np

from ...base.results import Floats
from ...compile.blas import one_thread
from .curve import Arc, Curve, new_part, passes, special, trace
from .fixed_points import Flow, is_stable
from .results import SlowBranch, SlowResponse
from .states import states
from .transient import motion

SEEDS = 33
CLOSE = 1e-9  # relative difference of amplitudes at one crest
PER_CYCLE = 64  # samples of the fastest component: a peak between them is right to 1e-3


@one_thread
def response(flow: Flow, lo: float, hi: float) -> SlowResponse:
    """Trace every branch of nontrivial steady states between two speeds [rad/s]."""
    speeds = np.array([omega for omega in np.linspace(lo, hi, SEEDS) if not flow.setting.sits_on(float(omega))])
    found = states(flow, speeds)
    at, row = np.nonzero(np.isfinite(found.z.T))
    listed = list(zip(found.z[row, at].tolist(), speeds[at].tolist(), found.stable[row, at].tolist(), strict=True))
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


def _height(top: tuple[float, float]) -> float:
    return top[1]


def _top(point: Floats, tangent: Floats) -> float:
    return float(point[:2] @ tangent[:2])


def _assembled(curve: Curve, arcs: list[Arc], trivial: tuple[tuple[float, bool], ...]) -> SlowResponse:
    folds: list[tuple[float, float]] = []
    tops: list[tuple[float, float]] = []
    branches = []
    for arc in arcs:
        folds += [(omega, abs(z)) for z, omega in map(curve.split, arc.folds)]
        ahead = np.diff(arc.points, axis=0)
        tangents = [curve.tangent(p, d) for p, d in zip(arc.points, np.vstack([ahead, ahead[-1:]]), strict=True)]
        kept = [arc.points[0]]
        for i, (a, b) in enumerate(itertools.pairwise(arc.points)):
            if _top(a, tangents[i]) * _top(b, tangents[i + 1]) < 0.0:
                point = special(curve, a, b, _top)
                if point is not None:
                    z, omega = curve.split(point)
                    tops.append((omega, abs(z)))
                    kept.append(point)
            kept.append(b)
        branches.append(_branch(curve, np.array(kept), arc.closed))
    branches.sort(key=lambda branch: float(np.max(branch.amplitude)), reverse=True)
    crests = tuple(tops)
    for branch in branches:
        i = int(np.argmax(branch.amplitude))
        tops.append((float(branch.omega[i]), float(branch.amplitude[i])))
    peak = max(tops, key=_height)
    folds.sort()
    counts = f"{len(branches)} branch(es), {len(folds)} fold(s)"
    message = f"{counts}, largest amplitude {peak[1]:.6g} rad at omega = {peak[0]:.6g} rad/s"
    if all(abs(size - peak[1]) > CLOSE * peak[1] for _, size in crests):
        message += ", an end of a branch and no peak: it may rise further outside the range"
    born = ", ".join(f"{curve.split(point)[1]:.6g}" for arc in arcs for point in arc.born)
    stops = ", ".join(f"{curve.split(point)[1]:.6g}" for arc in arcs for point in arc.stops)
    message += f"; begins at a = 0 at omega = {born} rad/s" if born else ""
    if stops:
        message += f"; a branch stops inside the range at omega = {stops} rad/s: take a smaller range or more damping"
    return SlowResponse(tuple(branches), tuple(f[0] for f in folds), tuple(f[1] for f in folds), peak, trivial, message)


def _branch(curve: Curve, points: Floats, closed: bool) -> SlowBranch:
    z = curve.size * (points[:, 0] + 1j * points[:, 1])
    omega = curve.width * points[:, 2]
    flows = [curve.flow.at(float(w)) for w in omega]
    stable = np.array([is_stable(flow, complex(point)) for flow, point in zip(flows, z, strict=True)])
    peak = np.array([_peak(flow, complex(point)) for flow, point in zip(flows, z, strict=True)])
    return SlowBranch(omega, np.abs(z), -np.angle(z), peak, stable, closed)


def _peak(flow: Flow, z: complex) -> float:
    """Largest |x| [rad] of the whole motion on samples."""
    s = flow.setting
    ratio = s.resonance.ratio or Fraction(1)
    samples = PER_CYCLE * ratio.denominator * max(math.ceil(ratio), *s.orders, 1)
    theta = 2.0 * np.pi * ratio.denominator * np.arange(samples) / samples
    return float(np.max(np.abs(motion(flow, z, theta / s.omega))))
