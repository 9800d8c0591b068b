"""The response through a speed range of laws with friction or memory: steady motions by integration, a sweep up.

Harmonic balance (`frequency_response`) takes these laws too, but their corners make its steps many and small; closed
orbits of the integrated equation are as exact and come in a fraction of the time. Where a sweep down finds other
motions, the run-up and coast-down of the report show both.
"""

import math
from typing import Any

import numpy as np

from .._dispatch import is_spring
from ..results import Branch, Floats, Status
from .exact import POINTS, ExactResponse, exact_response
from .gear_forces import settling_time
from .jumps import jumps
from .regimes import operating_point
from .steady import SteadyMotion, settle

FIRST, ROUNDS = 41, 3  # speeds, and how often more are put where the peak changes by a large
ROUGH = 0.03  # share of the largest
HARMONICS = 31
LONGER = 2


def response_through(system: Any, speeds: tuple[float, float], points: int = POINTS) -> ExactResponse:
    """Response through a range of base-angle speeds [rad/s]: by harmonic balance for springs, else by integration.

    Parameters
    ----------
    system : Oscillator or VaryingOscillator
        The error equation; its omega is replaced.
    speeds : (float, float)
        Ends of the range [rad/s].
    points : int
        About so many, of a spring.
    """
    if is_spring(system):
        return exact_response(system, speeds, points)
    start = operating_point(system).start
    found: list[SteadyMotion] = []
    for omega in np.linspace(*speeds, FIRST):
        start = found[-1].end if found and found[-1].status else start
        found.append(_settled(system._replace(omega=float(omega)), start))
    for _ in range(ROUNDS):
        found += _between(system, found)
        found.sort(key=lambda motion: motion.omega)
    curve = _branch([motion for motion in found if motion.closed], len(found), speeds)
    try:
        return ExactResponse(curve, jumps(curve), "integration")
    except ValueError:  # nothing stable to follow
        return ExactResponse(curve, None, "integration")


def _settled(system: Any, start: tuple[float, ...]) -> SteadyMotion:
    motion = settle(system, start, time=settling_time(system))
    for _ in range(LONGER):
        if motion.closed or not motion.status:
            break
        motion = settle(system, motion.end, time=settling_time(system))
    return motion


def _between(system: Any, found: list[SteadyMotion]) -> list[SteadyMotion]:
    """Motions midway between neighbours whose peaks differ much."""
    peaks = np.array([motion.peak if motion.status else math.nan for motion in found])
    steps = np.abs(np.diff(peaks))
    rough = np.flatnonzero(steps > ROUGH * np.nanmax(peaks))
    middle = [0.5 * (found[i].omega + found[i + 1].omega) for i in rough]
    return [_settled(system._replace(omega=w), found[i].end) for i, w in zip(rough, middle, strict=True)]


def _branch(found: list[SteadyMotion], tried: int, speeds: tuple[float, float]) -> Branch:
    """The motions as a branch in omega."""
    omega = np.array([motion.omega for motion in found])
    table = np.array([_series(motion.x) for motion in found]).reshape(len(found), 2 * HARMONICS + 1)
    size = np.linalg.norm(table, axis=1)
    last = np.linalg.norm(table[:, -4:], axis=1)
    lost = tried - len(found)
    message = f"{len(found)} steady motions by integration"
    if lost:
        message += f"; at {lost} of {tried} speeds the motion does not repeat with every turn of the base angle"
    stable = np.array([bool(motion.stable) for motion in found], bool)
    whole = len(found) > 1 and lost == 0
    return Branch(
        "omega", omega, omega, table, np.array([motion.peak for motion in found]),
        np.zeros((len(found), 0), complex), stable, [], [], 1, False,
        float(np.max(last / np.maximum(size, 1e-300), initial=0.0)), f"a sweep up from {speeds[0]:.6g} rad/s",
        Status.OK if whole else Status.NO_CONVERGENCE, message,
    )  # fmt: skip


def _series(x: Floats) -> Floats:
    """Fourier coefficients (2H+1,) of samples over one period, the last one the first again."""
    spectrum = np.fft.rfft(x[:-1])[: HARMONICS + 1] / (len(x) - 1)
    out = np.zeros(2 * HARMONICS + 1)
    out[0], out[1::2], out[2::2] = spectrum[0].real, 2.0 * spectrum[1:].real, -2.0 * spectrum[1:].imag
    return out
