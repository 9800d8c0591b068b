"""The response through a speed range of laws with friction or memory: steady motions by integration, up and down.

Harmonic balance (`frequency_response`) takes these laws too; closed orbits of the integrated equation have no harmonics
left out.
"""

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from ...law import is_spring
from ...results import Branch, Floats, Status
from .hysteresis_bands import HysteresisBand, Jump
from .jumps import Jumps, jumps_of
from .resonances import operating_point
from .response import POINTS, ExactResponse, exact_response
from .steady import SteadyMotion, settled

FIRST, ROUNDS = 41, 8  # speeds, and how often more are put where the peak changes by a large
ROUGH, JUMP = 0.03, 0.15  # share of the largest; so much of it at once is a jump
TOP = 0.005  # relative distance of the speeds next to the largest peak, at most
SAME = 0.03  # relative difference of peaks of one motion
HARMONICS = 31


def response_through(
    system: Any, speeds: tuple[float, float], points: int = POINTS, harmonics: int | None = None,
    coexisting: bool = True,
) -> ExactResponse:  # fmt: skip
    """Response through a range of base-angle speeds [rad/s]: by harmonic balance for springs, else by integration.

    Parameters
    ----------
    system : Oscillator or VaryingOscillator
        The error equation; its omega is replaced.
    speeds : (float, float)
        Ends of the range [rad/s].
    points : int
        About so many, of a spring.
    harmonics : int, optional
        Highest harmonic, of a spring. Default: grown until those left out do not show.
    coexisting : bool
        Whether motions of a spring that do not join the curve are looked for at the ends of the range.

    Returns
    -------
    ExactResponse
        By integration the curve holds the motions of a slow run-up, and `back` those of a run-down where they differ.
    """
    if is_spring(system):
        return exact_response(system, speeds, points, harmonics, coexisting)
    start = operating_point(system).start
    up = _sweep(system, np.linspace(*speeds, FIRST), start)
    last = up[-1].end if up[-1].status else start
    down = _sweep(system, np.linspace(*speeds[::-1], FIRST), last)[::-1]
    curve, back = (_branch([m for m in motions if m.closed], len(motions), speeds) for motions in (up, down))
    if not len(curve):
        return ExactResponse(curve, None, "integration")
    other = np.abs(np.interp(curve.omega, back.omega, back.peak) / curve.peak - 1.0) > SAME if len(back) else None
    differs = other is not None and int(np.sum(other)) > 1
    return ExactResponse(curve, _jumps(curve, back, other), "integration", back if differs else None)


def _sweep(system: Any, omega: Floats, start: tuple[float, ...]) -> list[SteadyMotion]:
    """Steady motions in the order of the sweep, each from the one before, with more of them where the peak changes."""
    found: list[SteadyMotion] = []
    for w in omega:
        start = found[-1].end if found and found[-1].status else start
        found.append(settled(system._replace(omega=float(w)), start))
    upwards = 1.0 if omega[-1] > omega[0] else -1.0
    for _ in range(ROUNDS):
        found += _between(system, found)
        found.sort(key=lambda motion: upwards * motion.omega)
    return found


def _jumps(curve: Branch, back: Branch, other: Any) -> Jumps:
    """Jumps of both sweeps, as `jumps` tells them of a branch."""
    on_up, on_down = _steps(curve.omega, curve.peak), _steps(back.omega[::-1], back.peak[::-1])
    places = np.arange(len(curve))
    down = places[::-1] if other is None else places[~other][::-1]
    bands = () if other is None else tuple(_bands(curve.omega, other, on_up, on_down))
    every = sorted((*on_up, *on_down), key=lambda j: -abs(j.after - j.before))
    said = "; ".join(f"|x| jumps from {j.before:.6g} to {j.after:.6g} rad at {j.value:.6g} rad/s" for j in every)
    return jumps_of("omega", places, down, on_up, on_down, True, True, said or "no jump by integration", bands)


def _bands(omega: Floats, other: Any, on_up: tuple[Jump, ...], on_down: tuple[Jump, ...]) -> Iterator[HysteresisBand]:
    """Runs of speeds at which both sweeps are on different motions, with a jump in them or at an end."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], other, [False]])))
    for first, last in edges.reshape(-1, 2):  # speeds number first ... last - 1
        low, high = omega[max(first - 1, 0)], omega[min(last, len(omega) - 1)]
        forth, back = (tuple(j for j in some if low <= j.value <= high) for some in (on_up, on_down))
        if forth or back:
            ends = min((j.value for j in back), default=low), max((j.value for j in forth), default=high)
            yield HysteresisBand(float(min(ends)), float(max(ends)), forth, back)


def _steps(omega: Floats, peak: Floats) -> tuple[Jump, ...]:
    large = np.flatnonzero(np.abs(np.diff(peak)) > JUMP * np.max(peak, initial=0.0))
    return tuple(
        Jump(float(0.5 * (omega[i] + omega[i + 1])), float(peak[i]), float(peak[i + 1]), "integration", 1)
        for i in large
    )


def _between(system: Any, found: list[SteadyMotion]) -> list[SteadyMotion]:
    """Motions midway between neighbours whose peaks differ much."""
    peaks = np.array([motion.peak if motion.status else math.nan for motion in found])
    steps = np.abs(np.diff(peaks))
    rough = np.flatnonzero(steps > ROUGH * np.nanmax(peaks))
    if len(found) > 2 and np.any(np.isfinite(peaks)):  # the top itself, which is flat
        top = int(np.nanargmax(peaks))
        wide = [i for i in (top - 1, top) if 0 <= i < len(steps)]
        wide = [i for i in wide if abs(found[i + 1].omega - found[i].omega) > TOP * found[i].omega]
        rough = np.union1d(rough, np.array(wide, int))
    middle = [0.5 * (found[i].omega + found[i + 1].omega) for i in rough]
    return [settled(system._replace(omega=w), found[i].end) for i, w in zip(rough, middle, strict=True)]


def _branch(found: list[SteadyMotion], tried: int, speeds: tuple[float, float]) -> Branch:
    """The motions as a branch in omega."""
    omega = np.array([motion.omega for motion in found])
    table = np.array([_series(motion.x) for motion in found]).reshape(len(found), 2 * HARMONICS + 1)
    size = np.linalg.norm(table, axis=1)
    last = np.linalg.norm(table[:, -4:], axis=1)
    lost = tried - len(found)
    message = f"{len(found)} steady motions by integration"
    if lost:
        message += f"; at {lost} of {tried} speeds no motion was reached that repeats with every turn of the base angle"
    stable = np.array([bool(motion.stable) for motion in found], bool)
    whole = len(found) > 1 and lost == 0
    return Branch(
        "omega", omega, omega, table, np.array([motion.peak for motion in found]),
        np.zeros((len(found), 0), complex), stable, [], [], 1, False,
        float(np.max(last / np.maximum(size, 1e-300), initial=0.0)),
        f"a sweep between {speeds[0]:.6g} and {speeds[1]:.6g} rad/s",
        Status.OK if whole else Status.NO_CONVERGENCE, message, span=speeds,
    )  # fmt: skip


def _series(x: Floats) -> Floats:
    """Fourier coefficients (2H+1,) of samples over one period, the last one the first again."""
    spectrum = np.fft.rfft(x[:-1])[: HARMONICS + 1] / (len(x) - 1)
    out = np.zeros(2 * HARMONICS + 1)
    out[0], out[1::2], out[2::2] = spectrum[0].real, 2.0 * spectrum[1:].real, -2.0 * spectrum[1:].imag
    return out
