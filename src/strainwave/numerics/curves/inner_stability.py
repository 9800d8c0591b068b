"""Stability of the orbits of a drive inside a kernel: period maps through panels, as `stability.panel_map` has them."""

import math
from typing import Any, NamedTuple

import numpy as np

from ...base.results import Floats
from ...compile.jit import inside, routine
from ..addressed import kinks, stiffnesses, torques
from ..balance.fourier import LOOKED
from ..balance.linear_algebra import copy, fill, row_times
from ..balance.piecewise import MOST_CROSSINGS, crossings, sort_by_angle
from ..stability.panel_map import MOST, PHASE, PLACES, QUIET, TERMS, WAVES, C, _panels, eliminated
from .inner_balance import EXACT, MOST_KINKS, law_of, synthesis_of

SQUARES, GROWS = 44, 700.0  # squares of a matrix for its largest eigenvalue, and the largest logarithm of a multiplier
AT = tuple(C.tolist())
LAGRANGE = tuple(  # coefficients of the polynomials that are 1 at one of the places and 0 at the others
    tuple((np.poly(others) / np.prod(c - others))[::-1].tolist()) for c, others in ((c, C[c != C]) for c in C)
)


class Disturbed(NamedTuple):
    """y' = (a + b R c) y along the orbits of a drive; `mean` are the stiffnesses of its laws in a.

    `rate` [1/s] is that of the fastest disturbance; the others are what `terms_of` writes.
    """

    a: Floats
    b: Floats
    c: Floats
    mean: Floats
    rate: float
    observed: Floats
    answers: Floats
    flow: Floats
    gains: Floats


inside(Disturbed)


@routine
def product(a: Floats, b: Floats, result: Floats) -> None:
    """Write a @ b."""
    fill(0.0, result)
    for i in range(a.shape[0]):
        for k in range(a.shape[1]):
            for j in range(b.shape[1]):
                result[i, j] += a[i, k] * b[k, j]


@routine
def log_radius(matrix: Floats) -> float:
    """Logarithm of the largest modulus of an eigenvalue, from the size of a high power."""
    a, power, log, share = matrix.copy(), np.empty_like(matrix), 0.0, 1.0
    for _ in range(SQUARES):
        size = 0.0
        for i in range(a.shape[0]):
            for j in range(a.shape[1]):
                size += abs(a[i, j])
        if not 0.0 < size < math.inf:
            return -math.inf if size == 0.0 else math.nan
        log += share * math.log(size)
        for i in range(a.shape[0]):
            for j in range(a.shape[1]):
                a[i, j] *= 1.0 / size
        product(a, a, power)
        a, power, share = power, a, 0.5 * share
    return log


@routine
def first_order_of(M: Floats, C: Floats, K: Floats, loaded: int, a: Floats, b: Floats) -> int:
    """Write the matrices of `motions.first_order_of`, unit torques on the first coordinates; returns the number m.

    Positions and speeds of m coordinates with inertia come first, then those without.
    """
    n = len(M)
    heavy, light, m, z = np.empty(n, np.int64), np.empty(n, np.int64), 0, 0
    for i in range(n):
        if np.max(np.abs(M[i])) > 0.0:
            heavy[m], m = i, m + 1
        else:
            light[z], z = i, z + 1
    states = 2 * m + z
    for i in range(m):
        a[i, m + i] = 1.0
    system = np.zeros((z, z + states))
    for i in range(z):
        for j in range(z):
            system[i, j] = C[light[i], light[j]]
            system[i, z + 2 * m + j] = -K[light[i], light[j]]
        for j in range(m):
            system[i, z + j], system[i, z + m + j] = -K[light[i], heavy[j]], -C[light[i], heavy[j]]
    eliminated(system)
    for i in range(z):
        copy(system[i, z : z + states], a[2 * m + i, :states])
    full = np.zeros((m, m + states + loaded))
    for i in range(m):
        row = heavy[i]
        for j in range(m):
            full[i, j] = M[row, heavy[j]]
            full[i, m + j], full[i, 2 * m + j] = -K[row, heavy[j]], -C[row, heavy[j]]
        for j in range(z):
            full[i, 3 * m + j] = -K[row, light[j]]
            for k in range(states):
                full[i, m + k] -= C[row, light[j]] * a[2 * m + j, k]
        if row < loaded:
            full[i, m + states + row] = 1.0
    eliminated(full)
    for i in range(m):
        copy(full[i, m : m + states], a[m + i, :states])
        copy(full[i, m + states :], b[m + i])
    return m


@routine
def weights_of(values: Floats, answers: Floats) -> None:
    """Write `panel_map._weights`: the places and the end of a panel (PLACES + 1, TERMS), and of its feedbacks."""
    for i in range(PLACES + 1):
        c = AT[i] if i < PLACES else 1.0
        term = 1.0
        for p in range(TERMS):
            values[i, p] = term
            part, total = term * c / (p + 1.0), 0.0
            for j in range(PLACES):
                total, piece = 0.0, part
                for q in range(PLACES):
                    total += LAGRANGE[j][q] * piece
                    piece *= c * (q + 1.0) / (p + q + 2.0)
                answers[i, j, p] = total
            term *= c / (p + 1.0)


@routine
def disturbed_of(problem: Any, drive: Any, points: Floats, count: int) -> Any:
    """Disturbances of the orbits of a curve."""
    blocks, size = problem.blocks.shape
    laws, n = len(drive.laws), drive.disturbed.shape[1]
    low, mean, high = np.full(laws, 1e300), np.zeros(laws), np.full(laws, -1e300)
    u, stiff = np.empty(problem.synthesis.shape[1]), np.empty(problem.synthesis.shape[1])
    for p in range(count):
        for i in range(laws):
            row_times(points[p, i * size : (i + 1) * size], problem.synthesis, u)
            stiffnesses(law_of(drive, i), u, stiff)
            low[i], high[i] = min(low[i], np.min(stiff)), max(high[i], np.max(stiff))
            mean[i] += np.sum(stiff) / (len(u) * count)
    damping, stiffness = drive.disturbed[1].copy(), drive.disturbed[2].copy()
    damping[0, 0] += drive.damping
    for i in range(laws):
        stiffness[i, i] += mean[i]
    a, b = np.zeros((2 * n, 2 * n)), np.zeros((2 * n, blocks))
    m = first_order_of(drive.disturbed[0], damping, stiffness, blocks, a, b)
    states = n + m
    c = np.zeros((blocks + (2 if drive.follows > 0 else 0), states))
    for i in range(laws):
        c[i, i] = 1.0
    if drive.follows > 0:
        c[laws, m], c[laws + 1, laws], c[laws + 2, m + laws] = 1.0, 1.0, 1.0
    a, b = a[:states, :states].copy(), b[:states].copy()
    log = log_radius(a)
    for end in (low, high):
        changed = a.copy()
        for i in range(laws):
            for j in range(states):
                changed[j, i] += b[j, i] * (mean[i] - end[i])
        log = max(log, log_radius(changed))
    rate = math.exp(log)
    return Disturbed(a, b, c, mean, rate, *terms_of(a, b, c, PHASE / rate))


@routine
def terms_of(a: Floats, b: Floats, c: Floats, longest: float) -> Any:
    """Terms (TERMS, ...) of the series in the length of a panel, over the `longest` [s], of the `panel_map.Tables`."""
    n, r, q = len(a), b.shape[1], len(c)
    own, answer = np.empty((PLACES + 1, TERMS)), np.empty((PLACES + 1, PLACES, TERMS))
    weights_of(own, answer)
    observed, answers = np.empty((TERMS, PLACES, q, n)), np.empty((TERMS, PLACES, q, PLACES * r))
    flow, gains = np.empty((TERMS, n, n)), np.empty((TERMS, n, PLACES * r))
    power, after = np.zeros((n, n)), np.empty((n, n))
    inputs, outputs, through = np.empty((n, r)), np.empty((q, n)), np.empty((q, r))
    for i in range(n):
        power[i, i] = 1.0
    for p in range(TERMS):
        product(power, b, inputs)
        product(c, power, outputs)
        product(c, inputs, through)
        for i in range(PLACES):
            for o in range(q):
                for j in range(n):
                    observed[p, i, o, j] = own[i, p] * outputs[o, j]
                for j in range(PLACES * r):
                    answers[p, i, o, j] = longest * answer[i, j // r, p] * through[o, j % r]
        for i in range(n):
            for j in range(n):
                flow[p, i, j] = own[PLACES, p] * power[i, j]
            for j in range(PLACES * r):
                gains[p, i, j] = longest * answer[PLACES, j // r, p] * inputs[i, j % r]
        product(power, a, after)
        for i in range(n):
            for j in range(n):
                power[i, j] = longest * after[i, j]
    return observed, answers, flow, gains


@routine
def summed_series(terms: Any, share: float, reach: float, begin: float, result: Any) -> None:
    """Write the sum of terms (TERMS, n) for a share of a length, in which the fastest disturbance turns by `reach`."""
    weight, size = begin, 1.0
    fill(0.0, result)
    for p in range(0, TERMS, 2):
        after = weight * share
        for i in range(len(result)):
            result[i] += weight * terms[p, i] + after * terms[p + 1, i]
        weight, size = after * share, size * reach * reach / ((p + 1.0) * (p + 2.0))
        if size < 1e-16:
            break


@routine
def tables_of(disturbed: Any, lengths: Floats, number: int) -> Any:
    """The `panel_map.Tables` of some lengths [s]."""
    n, r, q = len(disturbed.a), disturbed.b.shape[1], len(disturbed.c)
    observed, answers = np.empty((number, PLACES, q, n)), np.empty((number, PLACES, q, PLACES * r))
    flow, gains = np.empty((number, n, n)), np.empty((number, n, PLACES * r))
    for k in range(number):
        reach = disturbed.rate * lengths[k]
        share = reach / PHASE
        summed_series(disturbed.observed.reshape(TERMS, -1), share, reach, 1.0, observed[k].reshape(-1))
        summed_series(disturbed.answers.reshape(TERMS, -1), share, reach, share, answers[k].reshape(-1))
        summed_series(disturbed.flow.reshape(TERMS, -1), share, reach, 1.0, flow[k].reshape(-1))
        summed_series(disturbed.gains.reshape(TERMS, -1), share, reach, share, gains[k].reshape(-1))
    return observed, answers, flow, gains


@routine
def longest_in(point: Floats, blocks: int) -> float:
    """Longest panel [rad] that resolves an orbit: a harmonic of a small share of its block may turn farther in it.

    The error of Gauss's places is the share times the turn to the power 2 PLACES; stiffnesses have products of two
    harmonics, at up to twice the order.
    """
    size, longest, most = (len(point) - 1) // blocks, WAVES, 1
    h = size // 2
    for b in range(blocks):
        x, total, beyond = point[b * size : (b + 1) * size], 0.0, 0.0
        for k in range(1, h + 1):
            total += abs(x[k]) + abs(x[h + k])
        for k in range(h, 0, -1):
            beyond += abs(x[k]) + abs(x[h + k])
            if beyond > QUIET * total:
                most, longest = max(most, k), min(longest, 0.5 * WAVES * (beyond / total) ** (-0.5 / PLACES) / k)
    return max(longest, WAVES / most)


@routine
def panels_of(
    drive: Any, point: Floats, size: int, table: Floats, longest: float, first: Floats, width: Floats, kinds: Any
) -> Any:  # fmt: skip
    """Write starts and lengths [rad] of the panels of an orbit and what lengths they have; returns the numbers of both.

    They end at the kinks of the laws, which are looked for at the places of a synthesis table.
    """
    laws, number, u = len(drive.laws), 0, np.empty(table.shape[1])
    places, corners = np.empty(laws * MOST_CROSSINGS), np.empty(MOST_KINKS)
    angles, jumps, torsions = np.empty(MOST_CROSSINGS), np.empty(MOST_CROSSINGS), np.empty(MOST_CROSSINGS)
    for i in range(laws):
        m = kinks(law_of(drive, i), corners)
        if m > 0:
            row_times(point[i * size : (i + 1) * size], table, u)
            series = point[i * size : (i + 1) * size + 1]
            for j in range(crossings(corners[:m], np.zeros(2 * m + 1), series, u, angles, jumps, torsions)):
                places[number], number = angles[j], number + 1
    sort_by_angle(places, places.copy(), number)
    if number == 0:
        panels = math.ceil(2.0 * math.pi / longest)
        if panels > len(first):
            return 0, 0
        for j in range(panels):
            first[j], width[j], kinds[j] = 2.0 * math.pi * j / panels, 2.0 * math.pi / panels, 0
        return panels, 1
    panels = 0
    for i in range(number):
        length = (places[i + 1] if i + 1 < number else places[0] + 2.0 * math.pi) - places[i]
        parts = max(1, math.ceil(length / longest))
        if panels + parts > len(first):
            return 0, 0
        for j in range(parts):
            first[panels], width[panels], kinds[panels] = places[i] + length * j / parts, length / parts, i
            panels += 1
    return panels, number


@routine
def twists_at(point: Floats, w: float, psi: float, twists: Floats) -> None:
    """Write the values (blocks,) of the blocks of an orbit at a place [rad], and behind them their rates."""
    count = len(twists) // 2
    size = (len(point) - 1) // count
    h, c, s, ck, sk = size // 2, math.cos(psi), math.sin(psi), 1.0, 0.0
    for i in range(count):
        twists[i], twists[count + i] = point[i * size], 0.0
    for k in range(1, h + 1):
        ck, sk = ck * c - sk * s, ck * s + sk * c
        for i in range(count):
            even, odd = point[i * size + k], point[i * size + h + k]
            twists[i] += even * ck + odd * sk
            twists[count + i] += k * w * (odd * ck - even * sk)


@routine
def feedbacks(
    drive: Any, disturbed: Any, point: Floats, first: Floats, width: Floats, panels: int, work: Floats, gains: Floats
) -> None:  # fmt: skip
    """Write R (panels, PLACES, feedbacks, seen) along an orbit, as `motions.Disturbances`; work is a buffer."""
    laws, B, w = len(drive.laws), drive.damping, drive.every * point[-1]
    count, places = laws + drive.follows, panels * PLACES
    torque, twists = work[2 * count], np.empty(2 * count)
    for j in range(places):
        twists_at(point, w, first[j // PLACES] + width[j // PLACES] * AT[j % PLACES], twists)
        for i in range(2 * count):
            work[i, j] = twists[i]
    gains[:panels] = 0.0
    for i in range(laws):
        stiff = work[2 * count + 1 + i]
        stiffnesses(law_of(drive, i), work[i, :places], stiff[:places])
        for j in range(places):
            gains[j // PLACES, j % PLACES, i, i] = disturbed.mean[i] - stiff[j]
    if drive.follows == 0:
        return
    torques(law_of(drive, 0), work[0, :places], torque[:places])
    for j in range(places):
        psi = first[j // PLACES] + width[j // PLACES] * AT[j % PLACES]
        angle, slope, bend, stiff = psi / drive.every + work[laws, j], 0.0, 0.0, work[2 * count + 1, j]
        for i in range(1, len(drive.lines)):
            order, even, odd = drive.lines[i, 0], drive.lines[i, 1], drive.lines[i, 2]
            c, s = math.cos(order * angle), math.sin(order * angle)
            slope += order * (odd * c - even * s)
            bend -= order * order * (even * c + odd * s)
        pull = stiff * slope + B * bend * (point[-1] + work[count + laws, j])
        gain = gains[j // PLACES, j % PLACES]
        gain[0, laws + 1], gain[0, laws + 2] = pull, B * slope
        gain[laws, 0], gain[laws, laws], gain[laws, laws + 2] = slope * stiff, slope * B, -slope * slope * B
        gain[laws, laws + 1] = bend * (torque[j] + B * work[count, j]) - slope * pull


@routine
def growths(problem: Any, drive: Any, points: Floats, count: int, growth: Floats) -> bool:
    """Write the largest modulus of the multipliers of every point; whether all are known."""
    blocks, size = problem.blocks.shape
    disturbed = disturbed_of(problem, drive, points, count)
    r, q, n = disturbed.b.shape[1], len(disturbed.c), len(disturbed.a)
    first, width, kinds = np.empty(MOST), np.empty(MOST), np.empty(MOST, np.int64)
    gains, lengths = np.empty((MOST, PLACES, r, q)), np.empty(MOST)
    work, ends, flow = np.empty((3 * blocks + 1, MOST * PLACES)), np.zeros(2, np.int64), np.empty((1, n, n))
    table = synthesis_of(size // 2, LOOKED * (size // 2 + 1))
    steady = drive.follows == 0 and np.min(drive.laws[:, EXACT]) > 0  # between two kinks
    for p in range(count):
        w = drive.every * points[p, -1]
        longest = PHASE * w / disturbed.rate
        if not steady:
            longest = min(longest, longest_in(points[p], blocks))
        ends[1], number = panels_of(drive, points[p], size, table, longest, first, width, kinds)
        if number == 0:
            return False
        for j in range(ends[1]):
            lengths[kinds[j]] = width[j] / w
        feedbacks(drive, disturbed, points[p], first, width, ends[1], work, gains)
        _panels(tables_of(disturbed, lengths, number), kinds[: ends[1]], gains[: ends[1]], ends, flow)
        log = drive.every * log_radius(flow[0])
        if math.isnan(log):
            return False
        growth[p] = math.exp(min(log, GROWS))
    return True
