"""Where `isolas` looks for orbits: guesses for harmonic balance, at speeds that do not depend on the requested range.

The speeds are the powers of 2^(1/8) rad/s inside the range (of 2^(1/16), 2^(1/32), ... where that makes fewer than
eight), both ends, and the system's own. A wider range looks at them all, and at others.
"""

from collections.abc import Iterator
from typing import Any

import numpy as np

from ...base.quantities import replace
from ...base.results import Floats, SolveError
from ...numerics.attractors.attractors import Motion
from ...numerics.balance.harmonics import highest_order
from ...numerics.continuation.connected import connected
from ...numerics.curves.backbone import backbone
from ...theory.slow_flow.flow import slow_flow
from ...theory.slow_flow.setting import Resonance
from ..speed_map.search import crossings

PER_OCTAVE, FEWEST, FINEST = 8, 8, 4096
PHASES = 8


def speeds(speed: float, lo: float, hi: float) -> Floats:
    """Speeds [rad/s] in a range at which orbits are looked for, rising."""
    per_octave = PER_OCTAVE
    while True:
        first, last = np.ceil(per_octave * np.log2(lo)), np.floor(per_octave * np.log2(hi))
        if last - first + 1 >= FEWEST or per_octave >= FINEST:
            break
        per_octave *= 2
    grid = 2.0 ** (np.arange(first, last + 1) / per_octave)
    inside = [speed] if lo <= speed <= hi else []
    return np.unique(np.concatenate([[lo, hi], inside, grid[(grid > lo) & (grid < hi)]]))


def slow_seeds(problem: Any, resonance: Resonance, grid: Floats) -> Iterator[tuple[Floats, str]]:
    """Orbits at the ends of the range; steady states of the slow flow, stable and unstable."""
    if resonance.q == 1:
        for omega in (float(grid[0]), float(grid[-1])):
            for table in connected(problem, omega, []).tables:
                guess = problem.fitted(table, omega)
                if guess is not None:
                    yield guess, f"seeded by an orbit of the excitation at other strengths, omega = {omega:.6g} rad/s"
    for omega in grid.tolist():
        try:
            states = slow_flow(replace(problem.system, {"omega": omega}), resonance).steady_states()
        except (ValueError, SolveError):
            continue
        for s in states:
            if s.amplitude > 0.0:
                origin = (
                    f"seeded by the slow flow of the {resonance.p}:{resonance.q} resonance at omega = {omega:.6g} "
                    f"rad/s, a = {s.amplitude:.6g} ({'stable' if s.stable else 'unstable'})"
                )
                yield _with_component(problem, omega, resonance.p, s.amplitude, s.phase), origin


def free_seeds(problem: Any, resonance: Resonance, grid: Floats) -> Iterator[tuple[Floats, str]]:
    """Free vibrations of the frequency p omega/q, with phases all around."""
    size = float(np.linalg.norm(problem.linear_response(np.sqrt(grid[0] * grid[-1]))[:-1])) or 1.0
    curve = backbone(
        problem.system, size * np.geomspace(1e-2, 1e2, 41), harmonics=max(7, highest_order(problem.system))
    )
    for omega in grid.tolist():
        for a in crossings((curve.amplitude, curve.omega), resonance.p * omega / resonance.q):
            for phase in 2.0 * np.pi * np.arange(PHASES) / PHASES:
                origin = (
                    f"seeded by the free vibration of {resonance.p}/{resonance.q} of omega = {omega:.6g} rad/s, "
                    f"amplitude {a:.6g}, phase {phase:.3g}"
                )
                yield _with_component(problem, omega, resonance.p, a, float(phase)), origin


def _with_component(problem: Any, omega: float, p: int, amplitude: float, phase: float) -> Floats:
    """Linear response plus amplitude cos(p angle - phase), in coefficients of the orbit's own angle."""
    z: Floats = problem.linear_response(omega)
    z[p], z[problem.harmonics() + p] = amplitude * np.cos(phase), amplitude * np.sin(phase)
    return z


def table_of(motion: Motion) -> Floats:
    """Table (2H+1, 1) of the first state of a settled motion: mean, cos 1, sin 1, ..."""
    spectrum = np.fft.rfft(motion.samples[0]) * (2.0 / motion.samples.shape[1])
    series = np.empty(2 * len(spectrum) - 3)  # the last of the spectrum belongs to a harmonic with no room for its sine
    series[0], series[1::2], series[2::2] = 0.5 * spectrum[0].real, spectrum[1:-1].real, -spectrum[1:-1].imag
    return series[:, None]
