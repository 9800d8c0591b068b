"""The response of a drive as one kernel: from its numbers to curve, stability, torque and speeds above a limit.

All that is between the kernels of a curve (first guess, number of harmonics, crests, bands) is inside, so that the same
code answers in Python and, compiled for a browser, in a page. It follows the one curve that joins both ends of a range.

Krack & Gross 2019, Harmonic Balance for Nonlinear Vibration Problems, secs. 2-4.
"""

import math
from typing import Any

import numpy as np

from ...base.results import Floats
from ...base.series import PER_HARMONIC, highest_in, interpolate, largest_in, largest_sample
from ...compile.jit import kernel, routine
from ..addressed import torques
from ..balance.condensed.gear import sample_error
from ..balance.linear_algebra import copy, dot, fill, row_times
from ..balance.truncation import MATTERS
from ..continuation.arc_length import ROWS, SCALE, Z1, follow
from ..continuation.trace import AIM, LEAST, MEAN, OFF, ONE, REACH, ROUNDS, SAME, SETTLED, apart, put_in_order
from ..labels import DECAYS, END, START, TOP
from .inner_balance import displaced, law_of, linear_guess, problem_of, synthesis_of, tail_of, waves_of
from .inner_stability import growths

FEWEST = 8  # harmonics of which a torque has the samples, at least
MOST_FOLLOWED, MOST_POINTS, MOST_TRIES = 1500, 3000, 20  # a crest of both measures lies beside every other point
OMEGA, OSCILLATION, PEAK, GROWTH, TORQUE, LABEL = range(6)  # columns of a curve
HARMONICS, TAIL, BANDS, TOP_ROW, OTHERS = range(5)  # entries of `about`
LOST, TURNED, UNKNOWN = -1, -2, -3  # in the place of the number of points: no curve, not to the end, no stability


@routine
def traced_from(
    equations: Any, guess: Floats, direction: float, low: float, high: float, step: float, points: Floats, labels: Any
) -> Any:  # fmt: skip
    """Follow a branch from a guess; returns the number of its points and how it ends."""
    n = len(guess) - 1
    state, buffers = np.zeros((ROWS, n + 1)), (np.empty((n + 1, n + 1)), np.empty(n + 1, np.int64), np.zeros(7))
    copy(guess, state[Z1])
    fill(1.0 / max(dot(guess[:n], guess[:n]) ** 0.5, 1e-12), state[SCALE])
    state[SCALE, n] = 1.0 / (high - low if high > low else abs(guess[n]) + 1e-12)
    first = 0.1 * step if high > low else 1.0
    count, outcome, _ = follow(
        equations, state, direction, START, low, high, first, max(step, first), AIM, buffers, points, labels
    )
    put_in_order(points, labels, count)
    return count, outcome


@routine
def solved_at(equations: Any, guess: Floats, point: Floats) -> bool:
    """Write the solution at the speed of a guess; whether there is one."""
    points, labels = np.empty((5, len(guess))), np.empty(5, np.int64)
    count, _ = traced_from(equations, guess, 1.0, guess[-1], guess[-1], 1.0, points, labels)
    copy(points[0], point)
    return bool(count > 0)


@routine
def across(
    problem: Any, equations: Any, drive: Any, low: float, high: float, step: float, points: Floats, labels: Any
) -> Any:  # fmt: skip
    """Follow the curve from one end of a range to the other; returns the number of its points, by ascending speed.

    Also whether the linear response at the far end leads to another motion there.
    """
    n, reason, end = points.shape[1] - 1, LOST, np.empty(points.shape[1])
    for turn in range(2):
        begin, far, direction = (low, high, 1.0) if turn == 0 else (high, low, -1.0)
        guess = linear_guess(problem, drive, begin)
        count, outcome = traced_from(equations, guess, direction, low, high, step, points, labels)
        if count > 0:
            reason = TURNED
        if outcome != END or points[count - 1, n] != far:
            continue
        known = solved_at(equations, linear_guess(problem, drive, far), end)
        second = known and apart(end, points[count - 1]) > ONE
        if turn == 1:
            for i in range(count // 2):
                copy(points[i], end)
                copy(points[count - 1 - i], points[i])
                copy(end, points[count - 1 - i])
                labels[i], labels[count - 1 - i] = labels[count - 1 - i], labels[i]
        return count, second
    return reason, False


@routine
def sizes_of(errors: Floats, from_mean: bool, waves: Floats, sizes: Floats) -> None:
    """Write the largest |x|, or |x - mean|, of series (n, 2H+1) over the period."""
    series = errors.copy()
    if from_mean:
        series[:, 0] = 0.0
    largest_in(series, waves, sizes)


@routine
def crest_at(
    problem: Any, drive: Any, equations: Any, points: Floats, count: int, errors: Floats, i: int, size: float,
    from_mean: bool, waves: Floats, crest: Floats,
) -> float:  # fmt: skip
    """Write the crest next to point i, as `continuation.trace` finds it; returns on which side it is, 0 without one."""
    n, m, side, peak = points.shape[1], 0, 0.0, np.empty(2)
    scale, first = np.full(n, 1.0 / max(dot(points[i, : n - 1], points[i, : n - 1]) ** 0.5, 1e-300)), max(i - REACH, 0)
    scale[n - 1] = 1.0 / max(abs(points[i, n - 1]), 1e-300)
    most = 2 * REACH + 1 + ROUNDS
    window, series, arc = np.empty((most, n)), np.empty((most, errors.shape[1])), np.zeros(most)
    for j in range(first, min(i + REACH + 1, count)):
        copy(points[j], window[m])
        copy(errors[j], series[m])
        if m > 0:
            arc[m] = arc[m - 1] + np.sum(((window[m] - window[m - 1]) * scale) ** 2) ** 0.5
        m += 1
    mid = i - first
    low, centre, high, least, share = arc[mid - 1], arc[mid], arc[mid + 1], SAME * arc[m - 1], 1.0
    before, after, best, last, first, m = centre - low, high - centre, centre, arc[0], m, 1
    if min(before, after) <= least:
        return 0.0
    for j in range(1, first):  # what is nearer to the one before is left out
        if arc[j] - last > least:
            copy(window[j], window[m])
            copy(series[j], series[m])
            arc[m], m = arc[j], m + 1
        last = arc[j]
    row, value, point, guess = np.empty((1, errors.shape[1])), np.empty(1), np.empty(n), np.empty(n)
    for _ in range(ROUNDS):
        highest_in(arc[:m], series[:m], waves, low, high, from_mean, peak)
        near, top = arc[np.argmin(np.abs(arc[:m] - peak[0]))], peak[1]
        s = near + share * (peak[0] - near)
        if abs(top - size) <= SETTLED * top or not low < s < high or abs(s - near) <= least:
            break
        interpolate(arc[:m], s, window[:m], guess)
        reach = OFF * (after if s > centre else before)
        if not solved_at(equations, guess, point) or np.sum(((point - guess) * scale) ** 2) ** 0.5 > reach:
            share *= 0.5
            continue
        displaced(problem, drive, point, row[0])
        sizes_of(row, from_mean, waves, value)
        rise, share = value[0] - size, 1.0
        if (s > best) == (rise >= 0.0):
            low = min(s, best)
        else:
            high = max(s, best)
        if rise >= 0.0:
            best, size, side = s, value[0], s - centre
            copy(point, crest)
        if abs(rise) <= SETTLED * size:  # the polynomial's own rise is rounding from here on
            break
        arc[m] = s
        copy(point, window[m])
        copy(row[0], series[m])
        m += 1
    return float(side)


@routine
def measure_points(
    problem: Any, drive: Any, points: Floats, first: int, last: int, waves: Floats, errors: Floats, sizes: Floats
) -> None:  # fmt: skip
    """Write the series of the pointing error of points from `first` to `last`, and to two rows max |x|, |x - mean|."""
    for i in range(first, last):
        displaced(problem, drive, points[i], errors[i])
    sizes_of(errors[first:last], False, waves, sizes[0, first:last])
    sizes_of(errors[first:last], True, waves, sizes[1, first:last])


@routine
def with_crests(
    problem: Any, drive: Any, equations: Any, points: Floats, labels: Any, count: int, waves: Floats, errors: Floats,
    sizes: Floats) -> int:  # fmt: skip
    """Insert the crests of both sizes, which `measure_points` writes, among points; returns how many there are then."""
    n, number = points.shape[1], 0
    crests, after, crest = np.empty((count, n)), np.empty(count, np.int64), np.empty(n)
    measure_points(problem, drive, points, 0, count, waves, errors, sizes)
    measures = 1
    for i in range(count):
        if abs(errors[i, 0]) > MEAN * sizes[0, i]:
            measures = 2
    for measure in range(measures):
        size = sizes[measure]
        least = LEAST * np.max(size[:count])
        for i in range(1, count - 1):
            if not (size[i] >= size[i - 1] and size[i] > size[i + 1] and size[i] > least):
                continue
            side = crest_at(problem, drive, equations, points, count, errors, i, size[i], measure > 0, waves, crest)
            place = i if side > 0.0 else i - 1
            near = side == 0.0 or apart(crest, points[place]) <= ONE or apart(crest, points[place + 1]) <= ONE
            for j in range(number):
                near = near or (after[j] == place and apart(crest, crests[j]) <= ONE)
            if not near:
                copy(crest, crests[number])
                after[number] = place
                number += 1
    for _ in range(number):  # the last first; of two in one place the farther from the point before
        last = 0
        for j in range(1, number):
            here = max(after[j], 0)
            farther = after[j] == after[last] and apart(crests[j], points[here]) > apart(crests[last], points[here])
            last = j if after[j] > after[last] or farther else last
        place = after[last] + 1
        for i in range(count, place, -1):
            copy(points[i - 1], points[i])
            copy(errors[i - 1], errors[i])
            labels[i], sizes[0, i], sizes[1, i] = labels[i - 1], sizes[0, i - 1], sizes[1, i - 1]
        copy(crests[last], points[place])
        measure_points(problem, drive, points, place, place + 1, waves, errors, sizes)
        labels[place], after[last], count = TOP, -1, count + 1
    return count


@routine
def sampled(series: Floats, cosines: Floats, sines: Floats, even: Floats, odd: Floats, values: Floats) -> None:
    """Write the values (samples,) over a period of a series in blocks, from tables of half a period; two buffers."""
    h = len(sines)
    row_times(series[: h + 1], cosines, even)
    row_times(series[h + 1 :], sines, odd)
    for j in range(len(even)):
        values[-j], values[j] = even[j] - odd[j], even[j] + odd[j]


@routine
def largest_torque(
    problem: Any, drive: Any, cosines: Floats, sines: Floats, angles: Floats, point: Floats, work: Floats
) -> float:  # fmt: skip
    """Largest |T(u) + B u'| [N*m] over the period, u = x - e with all of e; `work` (7, samples) is a buffer.

    It follows the `positions` of the gear. The tables are those of `sampled`, and `angles` are those of the base.
    """
    size, w, x = problem.blocks.shape[1], drive.every * point[-1], problem.blocks[0]
    samples, h, at, rate = len(angles), size // 2, len(drive.laws) * size, np.zeros(size)
    even, odd = work[4, : cosines.shape[1]], work[5, : cosines.shape[1]]
    for i in range(1 + drive.follows):  # x, and the motor's deviation
        series = x if i == 0 else point[at : at + size]
        for k in range(1, h + 1):
            rate[k], rate[h + k] = k * w * series[h + k], -k * w * series[k]
        sampled(series, cosines, sines, even, odd, work[2 * i])
        sampled(rate, cosines, sines, even, odd, work[2 * i + 1])
    sample_error(drive.lines, 1.0, angles, work[2], work[4], work[5], work[6])
    for j in range(samples):
        work[0, j] -= work[4, j]
        work[1, j] -= work[5, j] * (point[-1] + work[3, j])
    torques(law_of(drive, 0), work[0], work[4])
    for j in range(samples):
        work[6, j] = abs(work[4, j] + drive.damping * work[1, j])
    return float(largest_sample(work[6]))


@routine
def described(
    problem: Any, drive: Any, points: Floats, labels: Any, count: int, sizes: Floats, curve: Floats
) -> bool:  # fmt: skip
    """Write the rows of a curve with the `sizes` of `measure_points`; whether the stability of all points is known."""
    size, growth = problem.blocks.shape[1], np.empty(count)
    table = synthesis_of(size // 2, PER_HARMONIC * max(FEWEST, size // 2))
    work, half = np.zeros((7, table.shape[1])), table.shape[1] // 2 + 1
    angles = 2.0 * math.pi / (drive.every * table.shape[1]) * np.arange(table.shape[1])
    cosines, sines = table[: size // 2 + 1, :half].copy(), table[size // 2 + 1 :, :half].copy()
    for i in range(count):
        problem.gear.positions((problem.synthesis, problem.analysis, problem.angles), 1.0, points[i], problem.blocks[0])
        curve[i, TORQUE] = largest_torque(problem, drive, cosines, sines, angles, points[i], work)
    complete = growths(problem, drive, points, count, growth)
    for i in range(count):
        curve[i, OMEGA], curve[i, OSCILLATION], curve[i, PEAK] = points[i, -1], sizes[1, i], sizes[0, i]
        curve[i, GROWTH], curve[i, LABEL] = growth[i], labels[i]
    return complete


@routine
def passing(
    problem: Any, drive: Any, equations: Any, points: Floats, count: int, i: int, curve: Floats, limit: float,
    waves: Floats,
) -> float:  # fmt: skip
    """Speed at which the curve passes a limit of the oscillation between points i and i + 1; by false position."""
    n, first, last = points.shape[1], max(i - 1, 0), min(i + 3, count)
    arc, row, value, point = np.zeros(last - first), np.empty((1, len(waves) + 1)), np.empty(1), np.empty(n)
    guess = np.empty(n)
    for j in range(first + 1, last):
        arc[j - first] = arc[j - first - 1] + apart(points[j], points[j - 1])
    low, high, side = arc[i - first], arc[i - first + 1], 0
    reach = high - low
    before, after = curve[i, OSCILLATION] - limit, curve[i + 1, OSCILLATION] - limit
    speed = curve[i, OMEGA] + before / (before - after) * (curve[i + 1, OMEGA] - curve[i, OMEGA])
    for _ in range(MOST_TRIES):
        s = (low * after - high * before) / (after - before)
        interpolate(arc, s, points[first:last], guess)
        if not solved_at(equations, guess, point) or apart(guess, point) > reach:
            break
        displaced(problem, drive, point, row[0])
        sizes_of(row, True, waves, value)
        speed, lack = point[n - 1], value[0] - limit
        if abs(lack) <= SETTLED * limit:
            break
        if (lack > 0.0) == (before > 0.0):
            low, before, after, side = s, lack, 0.5 * after if side < 0 else after, -1
        else:
            high, after, before, side = s, lack, 0.5 * before if side > 0 else before, 1
    return float(speed)


@routine
def bands_above(
    problem: Any, drive: Any, equations: Any, points: Floats, count: int, curve: Floats, limit: float, waves: Floats,
    bands: Floats,
) -> int:  # fmt: skip
    """Write the speeds (n, 2) at which stable motions of a curve are above a limit, ascending and apart; returns n."""
    number = 0
    for i in range(count - 1):
        a, b = curve[i, OSCILLATION], curve[i + 1, OSCILLATION]
        first, last = curve[i, OMEGA], curve[i + 1, OMEGA]
        if min(curve[i, GROWTH], curve[i + 1, GROWTH]) >= DECAYS or max(a, b) <= limit:
            continue
        if min(a, b) <= limit:
            crossing = passing(problem, drive, equations, points, count, i, curve, limit, waves)
            first, last = (crossing, last) if a <= limit else (first, crossing)
        low, high, j = min(first, last), max(first, last), 0
        while j < number:  # with all that it touches
            if bands[j, 0] <= high and low <= bands[j, 1]:
                low, high, number = min(low, bands[j, 0]), max(high, bands[j, 1]), number - 1
                bands[j, 0], bands[j, 1] = bands[number, 0], bands[number, 1]
                j = 0
            else:
                j += 1
        bands[number, 0], bands[number, 1] = low, high
        number += 1
    for i in range(number):
        for j in range(i + 1, number):
            if bands[j, 0] < bands[i, 0]:
                for k in range(2):
                    bands[i, k], bands[j, k] = bands[j, k], bands[i, k]
    return number


@kernel
def answer(
    drive: Any, functions: Any, low: float, high: float, limit: float, number: int, harmonics: int, most: int,
    per: int, curve: Floats, bands: Floats, about: Floats,
) -> int:  # fmt: skip
    """Steady motions of a drive through a range of speeds, with stability, torque and speeds above a limit.

    Parameters
    ----------
    drive : Drive
        What is linear around the laws, and their addresses.
    functions : Functions
        What machine code calls.
    low, high, limit : float
        The range [rad/s], and the largest oscillation |x - mean| [rad] that is allowed.
    number : int
        About how many points to place.
    harmonics, most, per : int
        Harmonics to begin with, and at most; `per` of them are one harmonic of the drive.
    curve : (MOST_POINTS, 6) array
        Gets the points: OMEGA [rad/s], OSCILLATION and PEAK, the largest |x - mean| and |x| of the pointing error
        [rad], GROWTH, the largest modulus of a Floquet multiplier, TORQUE, the largest torque in the gear [N*m], and
        LABEL.
    bands : (MOST_POINTS, 2) array
        Gets the speeds above the limit.
    about : (5,) array
        Gets HARMONICS, the TAIL beyond them, the number of BANDS, the TOP_ROW, where a stable motion oscillates most,
        and whether there are OTHERS, motions at an end of the range which the curve does not pass.

    Returns
    -------
    int
        The number of points; LOST, TURNED or UNKNOWN without them.
    """
    sought = harmonics
    while True:
        h = max(1, sought // per)
        problem, equations, memory = problem_of(drive, functions, h)
        n = problem.blocks.size + 1
        points, labels = np.empty((MOST_POINTS, n)), np.empty(MOST_POINTS, np.int64)
        count, second = across(problem, equations, drive, low, high, 4.0 / number, points[:MOST_FOLLOWED], labels)
        if count < 0:
            return int(count)
        tail, worst = tail_of(problem, drive, points, count)
        if (tail if drive.alone > 0 else worst) <= MATTERS or sought >= most:
            break
        sought = min(2 * sought + 1, most)
    waves = waves_of(h)
    errors, sizes = np.empty((MOST_POINTS, len(waves) + 1)), np.empty((2, MOST_POINTS))
    count = with_crests(problem, drive, equations, points, labels, count, waves, errors, sizes)
    if not described(problem, drive, points, labels, count, sizes, curve):
        return UNKNOWN
    top = -1
    for i in range(count):
        if curve[i, GROWTH] < DECAYS and (top < 0 or curve[i, OSCILLATION] > curve[top, OSCILLATION]):
            top = i
    about[HARMONICS], about[TAIL], about[TOP_ROW], about[OTHERS] = h * drive.every, tail, top, 1.0 if second else 0.0
    about[BANDS] = bands_above(problem, drive, equations, points, count, curve, limit, waves, bands)
    return int(count) + 0 * len(memory)  # which lives as long as the equations, that know it by its address
