"""The balance problem of a drive made inside a kernel, with its first guess and what it leaves out.

A drive is what is linear around its laws, as matrices, and the laws by their addresses; the error equation of a gear is
one with a single coordinate. All is at addresses, which the kernel writes itself.
"""

import math
from typing import Any, NamedTuple

import numpy as np

from ...base.results import Floats
from ...base.series import PER_HARMONIC
from ...compile.address import write_words
from ...compile.jit import inside, routine
from ..addressed import EquationsAt, LawAt, kinks, stiffnesses, torques
from ..balance.condensed.gear import BEND, SLOPE, TORQUE, VALUE, Gear, sample_error
from ..balance.condensed.pencil import Pencil, condense
from ..balance.condensed.problem import Condensed
from ..balance.linear_algebra import copy, row_times
from ..balance.piecewise import MOST_CROSSINGS, Crossings
from ..balance.springs import Sampling, Spring, SpringsAt
from ..balance.truncation import LOOKED_AT
from ..stability.panel_map import eliminated

MOST_KINKS = 64  # breakpoints of a law
EXACT = 9  # column of `Drive.laws`: whether the torque is exact, 1, or sampled, 0


class Drive(NamedTuple):
    """What is linear around the laws of a drive with n coordinates, and the laws.

    `matrices` (3, n, n) are inertia, damping and stiffness, `disturbed` (3, m, m) those of disturbances; `forces`
    (n, 2K+1) are coefficients in blocks, at every `every`-th harmonic, `pointing` (n,) tells the error that the answer
    is about, `lines` are rows order, cosine, sine of the kinematic error, the mean first. `laws` (laws, 10) are
    whole numbers: words, torques, stiffnesses, breakpoints and their number, the functions of a `Spring`, EXACT. The
    others are as in a `Pencil` and a `Gear`; `alone` is 1 of an error equation, whose harmonics grow by what its
    torsion leaves out, else 0.
    """

    matrices: Floats
    disturbed: Floats
    forces: Floats
    per_speed: Floats
    zero_mean: Floats
    pointing: Floats
    lines: Floats
    damping: float
    laws: Any
    follows: int
    loose: int
    controls: int
    every: int
    alone: int


class Functions(NamedTuple):
    """Addresses of the functions of a balance."""

    equations_at: int
    jacobian_at: int
    slope_at: int


inside(EquationsAt, SpringsAt, Gear, Pencil, Condensed, LawAt)


@routine
def law_of(drive: Any, i: int) -> Any:
    """A law of a drive by its addresses."""
    return LawAt(drive.laws[i, 0], drive.laws[i, 1], drive.laws[i, 2], drive.laws[i, 3], drive.laws[i, 4])


@routine
def synthesis_of(h: int, samples: int) -> Floats:
    """Table of `fourier.synthesis`."""
    table, cosine, sine = np.ones((2 * h + 1, samples)), np.empty(samples), np.empty(samples)
    for j in range(samples):
        cosine[j], sine[j] = math.cos(2.0 * math.pi * j / samples), math.sin(2.0 * math.pi * j / samples)
    for k in range(1, h + 1):
        for j in range(samples):
            table[k, j], table[h + k, j] = cosine[k * j % samples], sine[k * j % samples]
    return table


@routine
def waves_of(h: int) -> Floats:
    """Table (2H, samples) of cos 1, sin 1, cos 2, ... as `base.series` has it."""
    table = synthesis_of(h, PER_HARMONIC * h)
    waves = np.empty((2 * h, PER_HARMONIC * h))
    for k in range(h):
        copy(table[1 + k], waves[2 * k])
        copy(table[1 + h + k], waves[2 * k + 1])
    return waves


@routine
def analysis_of(h: int, samples: int) -> Floats:
    """Table of `fourier.analysis`, padded."""
    waves, n = synthesis_of(h, samples), 2 * h + 1
    table = np.zeros((samples, n + (8 - n % 8) % 8))
    for j in range(samples):
        for k in range(n):
            table[j, k] = waves[k, j] * (2.0 if k > 0 else 1.0) / samples
    return table


@routine
def spring_words(
    law: Any, h: int, exact: int, back: Floats, double: Floats, product: Floats, arena: Floats, words: Any
) -> None:  # fmt: skip
    """Write the words of a `Spring`, whose buffers are in the arena, the samples of its twist first."""
    samples, n, wide, place = len(back), 2 * h + 1, 4 * h + 1, len(back)
    if exact > 0:
        most, corners = MOST_CROSSINGS, np.empty(MOST_KINKS)
        m = kinks(law, corners)
        lengths = most, most, most, n, n, wide, wide, 0, m, 2 * m + 1, 2 * m + 1, 1, 1
        places = np.zeros(14, np.int64)
        for i, length in enumerate(lengths):
            places[i], place = place, place + length
        places[13] = place
        nonlinear = Crossings(
            arena[places[0] : places[1]], arena[places[1] : places[2]], arena[places[2] : places[3]],
            arena[places[3] : places[4]], arena[places[4] : places[5]], arena[places[5] : places[6]],
            arena[places[6] : places[7]], product, arena[places[8] : places[9]], arena[places[9] : places[10]],
            arena[places[10] : places[11]], arena[places[11] : places[12]], arena[places[12] : places[13]],
        )  # fmt: skip
        write_words(Spring(law, nonlinear, arena[:samples]), words)
    else:
        torque, g = arena[place : place + samples], place + samples
        gc, gs = arena[g + wide : g + 2 * wide], arena[g + 2 * wide : g + 3 * wide]
        sampled = Sampling(back, double, torque, arena[g : g + wide], gc, gs, n // n)
        write_words(Spring(law, sampled, arena[:samples]), words)


@routine
def problem_of(drive: Any, functions: Any, h: int) -> Any:
    """The balance with h of the harmonics that a drive has, whose parameter is the speed, its equations, its memory."""
    laws, n, size, K = len(drive.laws), drive.matrices.shape[1], 2 * h + 1, drive.forces.shape[1] // 2
    count, samples, unit = laws + drive.follows, 4 * h + 4, size // size
    if np.max(drive.laws[:, EXACT]) > 0:
        samples = 8 * h + 8
    back, double = analysis_of(h, samples), analysis_of(2 * h, samples)
    angles, forces = np.empty(samples), np.zeros((n, h + 1), np.complex128)
    for j in range(samples):
        angles[j] = 2.0 * math.pi * j / (drive.every * samples)
    for i in range(n):
        forces[i, 0] = drive.forces[i, 0]
        for k in range(1, min(h, K) + 1):
            forces[i, k] = complex(drive.forces[i, k], -drive.forces[i, K + k])
    pencil = Pencil(
        drive.matrices, forces, drive.per_speed, count, drive.loose, drive.zero_mean, drive.controls, 1.0 * drive.every
    )
    rows, error = np.zeros((5, samples)), np.empty(size)
    sample_error(drive.lines, 1.0, angles, rows[TORQUE], rows[VALUE], rows[SLOPE], rows[BEND])
    row_times(rows[VALUE], back, error)
    gear = Gear(
        drive.follows, error, drive.lines, double, rows, np.empty((3, 2 * size - 1)), np.empty((2, size, size)),
        np.empty(size), np.empty(count * size),
    )  # fmt: skip
    arena = np.zeros((laws, 2 * samples + 20 * size + 4 * MOST_CROSSINGS + 8 * MOST_KINKS))
    product, words, places = np.empty((laws, size, size)), np.zeros((laws, 64), np.int64), np.empty((laws, 5), np.int64)
    for i in range(laws):
        spring_words(law_of(drive, i), h, drive.laws[i, EXACT], back, double, product[i], arena[i], words[i])
        places[i, 0] = words[i].ctypes.data
        for j in range(1, 5):
            places[i, j] = drive.laws[i, 4 + j]
    stiff, blocks = np.zeros((2, h + 1, n, n + 1), np.complex128), np.zeros((count, size))
    problem = Condensed(
        (), unit - 1, unit - 1, unit, drive.every, 1.0, (), pencil, drive.damping,
        SpringsAt(places, arena[0, :samples]), gear, synthesis_of(h, samples), back, angles, stiff, blocks,
    )  # fmt: skip
    block = np.zeros(128, np.int64)
    write_words(problem, block)
    place: Any = np.int64(block.ctypes.data)
    equations = EquationsAt(
        place, unit - 1, functions.equations_at, functions.jacobian_at, functions.slope_at, error,
        np.empty(count * size),
    )  # fmt: skip
    return problem, equations, (product, arena, words, block)


@routine
def carrying(law: Any, mean: float) -> float:
    """Torsion [rad] nearest to 0 where a law carries a mean torque [N*m]; 0 where none does."""
    places, values, spot, torque = np.zeros(2402), np.empty(2402), np.zeros(1), np.zeros(1)
    for i in range(1, 2402):
        places[i] = math.copysign(1e-9 * 1e10 ** ((i - 1) / 2400.0), mean)
    torques(law, places, values)
    for i in range(1, 2402):
        if (values[i - 1] - mean) * (values[i] - mean) <= 0.0:
            low, high, rises = places[i - 1], places[i], values[i] > values[i - 1]
            for _ in range(60):
                spot[0] = 0.5 * (low + high)
                torques(law, spot, torque)
                if (torque[0] < mean) == rises:
                    low = spot[0]
                else:
                    high = spot[0]
            return float(0.5 * (low + high))
    return 0.0


@routine
def response(s: Any, k: int, stiff: Floats, gear: float, force: Any, result: Any) -> None:
    """Write the complex amplitudes (blocks,) of harmonic k under forces on the laws' tangents; 0 where there are none.

    `gear` is the damping times the speed of harmonic 1; s is what `condense` left.
    """
    count = len(stiff)
    m = np.empty((2 * count, 2 * count + 1))
    for i in range(count):
        for j in range(count):
            a, b = s[k, i, j].real, s[k, i, j].imag
            if i == j:
                a += stiff[i]
                b += gear * k if i == 0 else 0.0
            m[i, j], m[i, count + j], m[count + i, j], m[count + i, count + j] = a, -b, b, a
        m[i, 2 * count], m[count + i, 2 * count] = force[i].real, force[i].imag
    eliminated(m)
    for i in range(count):
        x, y = m[i, 2 * count], m[count + i, 2 * count]
        result[i] = complex(x, y) if math.isfinite(x) and math.isfinite(y) else complex(0.0, 0.0)


@routine
def linear_guess(problem: Any, drive: Any, omega: float) -> Floats:
    """Coefficients and speed of the response of the laws' tangents at the operating point."""
    count, size = problem.blocks.shape
    h, n, laws, e = size // 2, drive.matrices.shape[1], len(drive.laws), problem.gear.error
    guess, means, stiff = np.zeros(count * size + 1), np.zeros(count), np.zeros(count)
    spot, slope = np.zeros(1), np.zeros(1)
    force, result = np.zeros(count, np.complex128), np.zeros(count, np.complex128)
    condense(problem.pencil, omega, 1.0, problem.stiff[0], problem.stiff[1])
    s = problem.stiff[0]
    for i in range(laws):
        mean = s[0, i, n].real
        spot[0] = means[i] = carrying(law_of(drive, i), mean) if mean != 0.0 else 0.0
        stiffnesses(law_of(drive, i), spot, slope)
        stiff[i] = slope[0]
    for k in range(1, h + 1):
        for i in range(count):
            force[i] = s[k, i, n] - s[k, i, 0] * complex(e[k], -e[h + k])
        response(s, k, stiff, problem.gear_damping * drive.every * omega, force, result)
        for i in range(count):
            guess[i * size + k], guess[i * size + h + k] = result[i].real, -result[i].imag
    if count > laws and s[0, laws, laws].real != 0.0:
        lacking = s[0, laws, n].real
        for i in range(laws):
            lacking -= s[0, laws, i].real * means[i]
        means[laws] = lacking / s[0, laws, laws].real
    for i in range(count):
        guess[i * size] = means[i]
    guess[count * size] = omega
    return guess


@routine
def seen_by(drive: Any, s: Any, k: int, p: Any) -> Any:
    """Complex amplitude of harmonic k of the pointing error; p has the kept coordinates first, and gets the others."""
    n, kept = len(drive.pointing), len(drive.laws) + drive.follows
    for coordinate in range(kept, n):
        p[coordinate] = 0.0
        if k == 0 and drive.loose < coordinate <= drive.loose + drive.controls and drive.loose >= 0:
            continue
        total = s[k, coordinate, n]
        for j in range(coordinate):
            total -= s[k, coordinate, j] * p[j]
        p[coordinate] = total / s[k, coordinate, coordinate]
    value = 0.0 * p[0]
    for j in range(n):
        value += drive.pointing[j] * p[j]
    return value


@routine
def displaced(problem: Any, drive: Any, point: Floats, result: Floats) -> None:
    """Write the coefficients mean, cos 1, sin 1, ... of the pointing error."""
    count, size = problem.blocks.shape
    h, p = size // 2, np.zeros(len(drive.pointing), np.complex128)
    condense(problem.pencil, point[count * size], 1.0, problem.stiff[0], problem.stiff[1])
    problem.gear.positions((problem.synthesis, problem.analysis, problem.angles), 1.0, point, problem.blocks[0])
    for i in range(1, count):
        copy(point[i * size : (i + 1) * size], problem.blocks[i])
    for k in range(h + 1):
        for i in range(count):
            p[i] = complex(problem.blocks[i, k], -problem.blocks[i, h + k] if k > 0 else 0.0)
        value = seen_by(drive, problem.stiff[0], k, p)
        if k == 0:
            result[0] = value.real
        else:
            result[2 * k - 1], result[2 * k] = value.real, -value.imag


@routine
def left_out(problem: Any, drive: Any, point: Floats, share: Floats) -> None:
    """Write the sizes in the harmonics H+1 .. 3H+8, of the pointing error and the blocks; see `truncation`."""
    count, size = problem.blocks.shape
    h, n, laws, w = size // 2, drive.matrices.shape[1], len(drive.laws), point[count * size]
    most = 3 * h + 8
    samples = 3 * most
    table, back, u, work = synthesis_of(h, samples), analysis_of(most, samples), np.empty(samples), np.empty(samples)
    series, stiff = np.zeros((count, 2 * most + 1)), np.zeros(count)
    for i in range(laws):
        row_times(point[i * size : (i + 1) * size], table, u)
        stiffnesses(law_of(drive, i), u, work)
        stiff[i] = np.sum(work) / samples
        torques(law_of(drive, i), u, work)
        row_times(work, back, series[i])
    s, d = np.zeros((most + 1, n, n + 1), np.complex128), np.zeros((most + 1, n, n + 1), np.complex128)
    pencil = problem.pencil
    quiet = Pencil(
        pencil.matrices, np.zeros((n, most + 1), np.complex128), np.zeros(n), pencil.kept, pencil.loose,
        pencil.zero_mean, pencil.controls, pencil.rate,
    )  # fmt: skip
    condense(quiet, w, 1.0, s, d)
    p, force = np.zeros(n, np.complex128), np.zeros(count, np.complex128)
    share[:] = 0.0
    for k in range(h + 1, most + 1):
        for i in range(count):
            force[i] = complex(-series[i, k], series[i, most + k])
        response(s, k, stiff, problem.gear_damping * drive.every * w, force, p)
        for i in range(count):
            share[1 + i] += abs(p[i]) ** 2
        share[0] += abs(seen_by(drive, s, k, p)) ** 2
    for i in range(count + 1):
        share[i] = share[i] ** 0.5


@routine
def norm_of(series: Floats) -> float:
    """Euclidean norm."""
    return float(np.sum(series * series) ** 0.5)


@routine
def tail_of(problem: Any, drive: Any, points: Floats, count: int) -> Any:
    """Share left out of the error, and the largest of it and the blocks; as `truncation.tail_along`.

    Of an error equation the first is that of the torsion.
    """
    blocks, size = problem.blocks.shape
    h, n = size // 2, blocks * size
    largest, floor, place, worst, of_error = 0.0, np.zeros(blocks), 0, 0.0, 0.0
    for i in range(count):
        for b in range(blocks):
            floor[b] = max(floor[b], 1e-6 * norm_of(points[i, b * size : (b + 1) * size]))
        for k in range(n):
            if abs(points[i, k]) > largest:
                largest, place = abs(points[i, k]), i
    for i in range(count):
        for b in range(blocks):
            series = points[i, b * size : (b + 1) * size]
            last = np.sum(series[max(1, h - 1) : h + 1] ** 2) + np.sum(series[max(1, 2 * h - 1) :] ** 2)
            worst = max(worst, last**0.5 / max(norm_of(series), floor[b], 1e-300))
    step, share, error = max(1, count // LOOKED_AT), np.empty(blocks + 1), np.empty(size)
    few = (count + step - 1) // step
    for j in range(few + 1):
        point = points[place if j == few else j * step]
        left_out(problem, drive, point, share)
        displaced(problem, drive, point, error)
        for b in range(blocks):
            part = min(1.0, share[1 + b] / max(norm_of(point[b * size : (b + 1) * size]), floor[b], 1e-300))
            worst, of_error = max(worst, part), max(of_error, part) if drive.alone > 0 else of_error
        if drive.alone == 0:
            of_error = max(of_error, min(1.0, share[0] / max(norm_of(error), 1e-300)))
    return of_error, max(worst, of_error)
