"""How a condensed problem is made from a system's linear part."""

from typing import Any

import numpy as np

from ....protocols import linear_part_of, omega_of, orders_of
from ....results import Floats
from ..fourier import analysis, synthesis
from ..harmonics import highest_order
from ..linear_part import STRENGTH, clean_mean
from ..piecewise import is_piecewise_linear
from .gear import Prescribed, following
from .pencil import Pencil, to_complex
from .problem import Condensed
from .springs import springs_for

LOOKED_AT, SAME = 64, 1e-9  # places of a turn, and the relative difference of torques that repeat there
MOST_LINES, ROUNDING = 64, 1e-14  # of an error, and share of the largest line that is none


def condensed(
    system: Any, leaf: int, omega_leaf: int, harmonics: int, turns: int = 1, folded: bool = True
) -> Condensed | None:
    """Build the condensed problem of a system; None where it has no linear part.

    Parameters
    ----------
    system : NamedTuple
        The system, with a method `linear_part()`.
    leaf, omega_leaf : int
        Places of the parameter that varies and of the base frequency; only the frequency and the strength may vary.
    harmonics : int
        Highest harmonic of omega/turns.
    turns : int
        Turns of the base angle that an orbit takes.
    folded : bool
        Whether an orbit may be taken to repeat as often in a turn as what drives it.
    """
    part = linear_part_of(system) if leaf in (omega_leaf, STRENGTH) else None
    lines = None if part is None else lines_of_error(part.error)
    if part is None or lines is None:
        return None
    every = repeats(part, highest_order(system)) if folded and turns == 1 else 1
    h = max(1, harmonics // every)
    samples = 8 * h + 8 if any(map(is_piecewise_linear, part.laws)) else 4 * h + 4
    angles = 2.0 * np.pi * turns / every * np.arange(samples) / samples
    table, back, double = synthesis(h, samples), analysis(h, samples), analysis(2 * h, samples)
    forces = part.forces(angles) @ back
    for row in forces:
        clean_mean(row)
    count, n = len(part.laws) + part.follows, len(part.inertia)
    pencil = Pencil(
        np.array([part.inertia, part.damping, part.stiffness]), to_complex(forces), part.per_speed, count, part.loose,
        every / turns,
    )  # fmt: skip
    gear: Any = Prescribed((part.error.value(angles) + 0.0 * angles) @ back)
    if part.follows:
        gear = following(lines, angles, back, double, count)
    buffers = np.empty((2, h + 1, n, n + 1), complex), np.empty((count, 2 * h + 1))
    springs = springs_for(part.laws, h, samples, back, double)
    omega = float(omega_of(system))
    return Condensed(
        system, leaf, omega_leaf, turns, every, omega, part, pencil, part.gear_damping, springs, gear, table, back,
        angles, *buffers,
    )  # fmt: skip


def repeats(part: Any, top: int) -> int:
    """How often in a turn, at most `top` times, everything that drives a system repeats."""
    angles = 2.0 * np.pi * (np.arange(LOOKED_AT) + 0.3) / LOOKED_AT

    def driving(angles: Floats) -> Floats:
        return np.vstack([part.forces(angles), part.error.value(angles) + 0.0 * angles])

    here = driving(angles)
    least = SAME * np.ptp(here, axis=1, keepdims=True)
    if not np.any(least):
        return 1
    return max(g for g in range(1, top + 1) if np.all(np.abs(driving(angles + 2.0 * np.pi / g) - here) <= least))


def lines_of_error(error: Any) -> Floats | None:
    """Rows (order, cosine, sine) of an error of any class, the mean first; None of one that has no end of lines."""
    top = max((1, *orders_of(error))) if orders_of(error) else 128
    samples = max(512, 4 * int(top) + 16)
    angles = 2.0 * np.pi * np.arange(samples) / samples
    waves = 2.0 / samples * np.fft.rfft(error.value(angles) + 0.0 * angles)
    size = np.abs(waves)
    found = 1 + np.flatnonzero(size[1:-1] > ROUNDING * np.max(size))
    if len(found) > MOST_LINES or np.any(found > samples // 4):
        return None
    mean = [0.0, 0.5 * waves[0].real, 0.0]
    return np.array([mean, *([float(k), waves[k].real, -waves[k].imag] for k in found)])
