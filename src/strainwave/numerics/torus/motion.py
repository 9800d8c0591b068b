"""What a motion of two turns is: its beat in every turn of the motor, its states, and how its disturbances grow."""

import math
from fractions import Fraction
from typing import Any

import numpy as np

from ...base.results import Floats
from ..balance.condensed.motions import first_order_of
from ..balance.condensed.pencil import to_complex
from .problem import Torus, at_angles

PER_WAVE, LEAST, BESIDE = 24, 96, 3  # samples in a period of the highest wave, at least; beside one for a polynomial
STARTING, STARTED = 384, 192  # angles at least where the smallest turn may begin, and the largest
SCREENED = 64  # samples that tell whether a turn may be the largest
REFINED = 4  # steps of Newton's method
STARTS, RESOLVED = 16, 1e-6  # slow angles at first, and the share of the highest waves of a map in the end
LEAST_STEPS, PER_ORDER, PHASE, FINEST = 12, 8, 0.8, 2048  # steps a turn: per order, and [rad] of what is fastest
FINER = {"none": 1.0, "shift": 4.0, "mean": 8.0}  # steps by the disturbance left out; those beside it hardly grow
STEPS = np.unique([2**a * b for a in range(1, 12) for b in (4, 5, 6, 7)])  # of a turn: curves take few of these
HARDLY = 1e-2  # of the largest wave: those below it do not count for the steps
ENTRIES, SAMPLES = 4_000_000, 250_000  # of all matrices at a time, and of motions: these stay in the cache
LARGEST = 1000  # turns of the motor after which motor and output stand as before, at most, or of one output turn


def turns_of(ratio: float) -> int:
    """Motor turns after which motor and output stand as before, or most nearly so where these are too many."""
    return Fraction(ratio).limit_denominator(max(1, int(LARGEST / ratio))).numerator


def largest_in_turns(waves: Any, pairs: Any, ratio: float) -> Floats:
    """Largest oscillation (n, turns) of motions over a turn of the motor that begins in each turn.

    The oscillation is the largest |x - mean| from the angle where the turn begins, any angle, to a turn later. The
    motions have the complex amplitudes `waves` (n, P + 1) of `pairs` (P + 1, 2), the first of them (0, 0). Crests are
    those of polynomials through seven samples, right to 1e-6 of the largest wave; one within a sample of an end of a
    turn may count to either side of it.
    """
    return _sizes(largest_of_turns, waves, pairs, ratio, STARTED)


def smallest_in_turns(waves: Any, pairs: Any, ratio: float) -> Floats:
    """Smallest oscillation (n, turns), as `largest_in_turns`."""
    return _sizes(smallest_of_turns, waves, pairs, ratio, STARTING)


def _sizes(measure: Any, waves: Any, pairs: Any, ratio: float, starting: int) -> Floats:
    order = pairs @ np.array([1.0, 1.0 / ratio])
    means, places = _of_means(order), _places(waves, order, starting)
    parts = _parts(waves, pairs, ratio, places)
    sizes = [measure(*(_in_turns(w, pairs, ratio, places) for w in (part, means * part))) for part in parts]
    return np.tile(np.concatenate(sizes), (1, turns_of(ratio) // sizes[0].shape[1]))


def largest_oscillations(waves: Any, pairs: Any, ratio: float) -> Floats:
    """Largest oscillation (n,) of motions, as `largest_in_turns`, from those turns that may have it.

    Few samples of a turn leave bounds of its oscillation: between them a wave bends by its order squared at most.
    """
    order, sizes = pairs @ np.array([1.0, 1.0 / ratio]), []
    means, places = _of_means(order), _places(waves, order, STARTED)
    for part in _parts(waves, pairs, ratio, places):
        x, mean = (_in_turns(w, pairs, ratio, SCREENED) for w in (part, means * part))
        missed = np.square(np.pi / SCREENED) * (np.abs(part) @ np.square(order))[:, None]
        high, low, mean = x.max(axis=2), x.min(axis=2), mean[:, :-1]
        above = np.maximum(high[:, :-1], high[:, 1:]) - mean.min(axis=2)
        below = mean.max(axis=2) - np.minimum(low[:, :-1], low[:, 1:])
        sure = np.maximum(high[:, :-1] - mean[..., BESIDE], mean[..., BESIDE] - low[:, :-1]).max(axis=1, keepdims=True)
        number, turn = np.nonzero(np.maximum(above, below) + missed >= sure)
        rows = (_in_turns(w, pairs, ratio, places, (number, turn)) for w in (part, means * part))
        sizes.append(np.maximum.reduceat(largest_of_turns(*rows)[:, 0], np.searchsorted(number, np.arange(len(part)))))
    return np.concatenate(sizes)


def _of_means(order: Floats) -> Any:
    """Factors (P + 1,) that make of waves those of the mean over the turn that begins at each angle."""
    means = np.ones(len(order), complex)
    np.divide(np.exp(2j * np.pi * order) - 1.0, 2j * np.pi * order, out=means, where=order != 0.0)
    return means


def largest_sizes(waves: Any, pairs: Any, ratio: float) -> Floats:
    """Largest |x| (n,) of motions, as `largest_in_turns`."""
    places = _places(waves, pairs @ np.array([1.0, 1.0 / ratio]), LEAST)
    parts = (_in_turns(part, pairs, ratio, places) for part in _parts(waves, pairs, ratio, places))
    return np.concatenate([np.abs(with_extremes(x)).max(axis=(1, 2)) for x in parts])


def largest_of_turns(x: Floats, mean: Floats) -> Floats:
    """Largest oscillation (n, turns) from samples (n, turns + 1, samples + 1 + 2 `BESIDE`).

    `mean` is that of the turn that begins at each sample. A turn from any sample is the end of one and the beginning of
    the next. Where the oscillation is largest, a crest of x - mean is at an end of the turn, or the mean is an extreme.
    """
    tops, bottoms = _extremes_of_turns(x)
    extreme, rise = with_extremes(mean)[:, :-1], np.diff(mean[:, :-1, BESIDE - 1 : 1 - BESIDE])
    inside = np.maximum(np.maximum(*tops) - extreme, extreme - np.minimum(*bottoms))
    inside[..., 1:-1] *= rise[..., 1:-2] * rise[..., 2:-1] <= 0.0
    inside = inside.max(axis=2)
    ends = [np.abs(with_extremes(part - mean[:, :-1])).max(axis=2) for part in (x[:, :-1], x[:, 1:])]
    return np.asarray(np.maximum(inside, np.maximum(*ends)))


def smallest_of_turns(x: Floats, mean: Floats) -> Floats:
    """Smallest oscillation (n, turns), as `largest_of_turns`."""
    drift = mean[:, :-1, BESIDE:-BESIDE]
    tops, bottoms = map(np.array, _extremes_of_turns(x))
    falling, rising = np.maximum(tops - drift, drift - bottoms)
    apart = falling - rising  # the smaller the turn, the nearer are what leaves it and what comes in
    step, crosses = np.diff(apart), (apart[..., :-1] > 0.0) & (apart[..., 1:] < 0.0)
    between = falling[..., :-1] - np.diff(falling) * apart[..., :-1] / np.where(crosses, step, 1.0)
    smallest = np.where(crosses, between, np.inf).min(axis=2)
    return np.asarray(np.minimum(smallest, np.maximum(falling, rising).min(axis=2)))


def _extremes_of_turns(x: Floats) -> tuple[tuple[Floats, Floats], tuple[Floats, Floats]]:
    """Highest and lowest values from each sample to the end of its turn, and from there to a turn after it."""
    inner = with_extremes(x)
    before, after = inner[:, :-1, ::-1], inner[:, 1:]
    tops = np.maximum.accumulate(before, axis=2)[..., ::-1], np.maximum.accumulate(after, axis=2)
    return tops, (np.minimum.accumulate(before, axis=2)[..., ::-1], np.minimum.accumulate(after, axis=2))


def _places(waves: Any, order: Floats, least: int) -> int:
    """Samples of a turn: of each wave so many that a polynomial through seven misses 1e-6 of the largest wave."""
    sizes = np.abs(waves[:, 1:])
    share = np.max(sizes / (np.max(sizes, axis=1, keepdims=True) + 1e-300), axis=0, initial=0.0)
    return max(least, math.ceil(PER_WAVE * float(np.max(np.abs(order[1:]) * share ** (1.0 / 7.0), initial=0.0))))


def _repeats(pairs: Any, ratio: float) -> int:
    """Turns of the motor after which motions of these pairs repeat."""
    return turns_of(ratio) // math.gcd(turns_of(ratio), *pairs[:, 1].tolist())


def _parts(waves: Any, pairs: Any, ratio: float, places: int) -> list[Any]:
    """Motions so many at a time that their samples fit."""
    most = max(1, SAMPLES // ((_repeats(pairs, ratio) + 1) * places))
    return np.array_split(waves, math.ceil(len(waves) / most))


def _in_turns(waves: Any, pairs: Any, ratio: float, places: int, only: Any = None) -> Floats:
    """Samples (n, turns + 1, samples) of motions until they repeat, `BESIDE` of them before and after each turn.

    `only` those motions (m,) in those turns (m,), with the turn after each: (m, 2, samples).
    """
    order, (ks, group) = pairs @ np.array([1.0, 1.0 / ratio]), np.unique(pairs[:, 1], return_inverse=True)
    theta = 2.0 * np.pi / places * np.arange(-BESIDE, places + BESIDE + 1)
    table = np.exp(1j * np.outer(order, theta))
    turned = np.exp(2j * np.pi / ratio * np.outer(np.arange(_repeats(pairs, ratio) + 1), ks))
    turned = np.concatenate([turned.real, -turned.imag], axis=1)
    along = np.stack([waves[:, group == i] @ table[group == i] for i in range(len(ks))], axis=1)
    along = np.concatenate([along.real, along.imag], axis=1)
    if only is None:
        return np.asarray(turned @ along)
    chosen = [turned[only[1][only[0] == i][:, None] + np.arange(2)] @ along[i] for i in range(len(waves))]
    return np.concatenate(chosen)


def with_extremes(values: Floats) -> Floats:
    """Samples (n, turns, samples) without those beside a turn; those at crests are as high as these."""
    inner = values[..., BESIDE:-BESIDE].copy()
    after, before = values[..., BESIDE + 1 : 1 - BESIDE], values[..., BESIDE - 1 : -BESIDE - 1]
    crests = np.nonzero((after - inner) * (inner - before) <= 0.0)
    s = np.arange(-BESIDE, BESIDE + 1)
    c = np.linalg.inv(np.vander(s, increasing=True)) @ values[crests[0], crests[1], crests[2] + BESIDE + s[:, None]]
    slope, x = np.arange(1, len(c))[:, None] * c[1:], np.zeros(len(crests[0]))
    bend = np.arange(1, len(slope))[:, None] * slope[1:]
    for _ in range(REFINED):
        step = np.divide(polyval(x, slope), polyval(x, bend), out=np.zeros_like(x), where=c[2] != 0.0)
        x = np.clip(x - step, -1.0, 1.0)
    inner[crests] = polyval(x, c)
    return np.asarray(inner)


def polyval(x: Floats, c: Floats) -> Floats:
    """Values (n,) of polynomials with coefficients c (degree + 1, n), the constant ones first."""
    value = np.zeros_like(x)
    for row in c[::-1]:
        value = value * x + row
    return value


def pointing(problem: Torus, points: Floats) -> Any:
    """Complex amplitudes (n, P + 1) of the pointing error in motions."""
    return np.array([problem.coordinates(z) @ problem.part.values[0] for z in points])


def states_at(problem: Torus, points: Floats, phase: Floats) -> list[Floats]:
    """States (states, n) of the system in each of some motions at base angles (n,) [rad]."""
    turned = np.outer(problem.orders, phase)
    part, even, odd, result = problem.part, np.cos(turned), np.sin(turned), []
    for z in points:
        waves = problem.coordinates(z)
        rates = waves * (1j * problem.orders * z[-1])[:, None]
        state = part.values @ waves.T + part.rates @ rates.T
        result.append(state.real @ even - state.imag @ odd)
    return result


def along_turns(problem: Torus, points: Floats, beats: int) -> tuple[Floats, list[Floats]]:
    """Angles (n,) [rad] of the motor until motions repeat, and the states (states, n) of each at them."""
    count = turns_of(problem.ratio)
    count //= math.gcd(count, beats)
    places = max(LEAST, PER_WAVE * math.ceil(float(np.max(_highest(problem, points)))))
    angles: Floats = 2.0 * np.pi / places * np.arange(float(count * places))
    return angles, states_at(problem, points, angles)


def _highest(problem: Torus, points: Floats) -> Floats:
    """Highest orders (n,) of the waves that count in motions."""
    sizes = np.abs(to_complex(problem.blocks(points))).max(axis=0)[:, 1:]
    counted = sizes > HARDLY * sizes.max(axis=1, keepdims=True)
    return np.asarray(np.max(np.abs(problem.orders[1:]) * counted, axis=1))


def growth(problem: Torus, flow: Any, points: Floats) -> Floats:
    """Rates (n,) [1/s] at which the disturbances of motions that last longest grow; negative of stable ones.

    `flow` is the part whose disturbances are meant: that of the problem, but for a mean that a control holds in its
    own states. The angle of a motor that nothing holds may be any: this disturbance is left out, which neither grows
    nor decays. Its speed is not: it grows where the torque that the motor needs falls with the speed.

    A turn of the first angle of the basis maps them by a matrix that is periodic in the second angle: it is found at
    some of these angles and interpolated at those that the motion has, whose product over all turns tells the rate.
    """
    (j, k), (_, q) = problem.basis.tolist()
    first, starts = j + k / problem.ratio, STARTS if problem.shape[1] > 1 else 1
    exact = Fraction(problem.ratio).limit_denominator(LARGEST)
    count = Fraction(q * exact.denominator, j * exact.numerator + k * exact.denominator).denominator
    if abs(float(exact) - problem.ratio) > 1e-12 * problem.ratio:
        count = math.ceil(problem.ratio * first / q)
    flows, steps = _first_order(problem, flow, points)
    result = np.empty(len(points))
    for number in np.unique(steps).tolist():
        most = max(1, ENTRIES // (2 * starts * number * flows[0].shape[0] ** 2))
        at = np.flatnonzero(steps == number)
        for part in np.array_split(at, math.ceil(len(at) / most)):
            some = starts if 2 * starts < count else count
            result[part] = _rates(problem, flows, points[part], number, some, count)
    return np.asarray(result * first * points[:, -1] / (2.0 * np.pi * count))


def _rates(problem: Torus, flows: Any, points: Floats, steps: int, starts: int, count: int) -> Floats:
    """Logarithms (n,) of the largest multipliers over `count` turns of the first angle, but for that of a mean."""
    while True:
        maps = turn_maps(problem, flows, points, steps, 2.0 * np.pi * np.arange(starts) / starts)
        waves = np.fft.fft(maps, axis=1) / starts
        order = np.fft.fftfreq(starts, 1.0 / starts)
        size = np.abs(waves).max(axis=(0, 2, 3))
        if starts == count or size[np.abs(order) >= max(1, starts // 3)].max(initial=0.0) <= RESOLVED * size.max():
            break
        starts = min(2 * starts, count)
    (j, k), (_, q) = problem.basis.tolist()
    advance = 2.0 * np.pi * q / (problem.ratio * j + k)
    logarithm, whole = np.zeros(len(points)), np.eye(maps.shape[2])
    for turn in range(count):
        phases = np.exp(1j * order * (turn * advance))
        whole = np.tensordot(waves, phases, (1, 0)).real @ whole
        largest = np.abs(whole).max(axis=(1, 2))
        whole, logarithm = whole / largest[:, None, None], logarithm + np.log(largest)
    values = np.linalg.eigvals(whole)
    if flows[-1] == "mean":
        apart = np.abs(values * np.exp(np.minimum(logarithm, 700.0))[:, None] - 1.0)
        values[np.arange(len(values)), apart.argmin(axis=1)] = 0.0
    return np.asarray(logarithm + np.log(np.maximum(np.abs(values).max(axis=1), 1e-300)))


def _first_order(problem: Torus, flow: Any, points: Floats) -> tuple[Any, Any]:
    """Matrix of the disturbances, that of the torques, the place of each of these, and that left out; steps of a turn.

    Where nothing but the motor's own angle drives it, a motion may begin at any time: the disturbance "shift".
    """
    heavy = np.flatnonzero(np.any(flow.inertia != 0.0, axis=1))
    massless, loaded = np.setdiff1d(np.arange(len(flow.inertia)), heavy), problem.linear.retained
    damping = flow.damping.copy()
    damping[0, 0] += flow.gear_damping
    a, b = first_order_of(flow.inertia, damping, flow.stiffness, heavy, massless, loaded)
    any_mean = flow.loose >= 0 and not np.any(flow.integral)
    forced = not flow.follows or np.any(problem.linear.matrices[0, 1:, :, -1])
    left_out = "none" if not any_mean else "mean" if forced else "shift"
    flows = a, b, np.searchsorted(heavy, loaded), heavy, massless, left_out
    mean = disturbed(flows, problem.moved(points), points[:, -1:], lambda samples: samples.mean(axis=-1, keepdims=True))
    fastest = np.abs(np.linalg.eigvals(np.moveaxis(mean[..., 0], 2, 0))).max(axis=1)
    first = float(problem.basis[0] @ np.array([1.0, 1.0 / problem.ratio]))
    steps = np.maximum(PER_ORDER * _highest(problem, points), 2.0 * np.pi * fastest / points[:, -1] / PHASE) / first
    steps *= FINER[left_out]
    return flows, STEPS[np.searchsorted(STEPS, np.clip(steps, LEAST_STEPS, FINEST))]


def disturbed(flows: Any, motion: Any, w: Floats, measure: Any) -> Floats:
    """Matrices (states, states, points, samples) of disturbances along motions, of a measure of their samples."""
    a, b, place, heavy = flows[:4]
    matrices = np.empty((*a.shape, *measure(motion.by_place[0, 0]).shape))
    matrices[:] = a[..., None, None]
    for some, first, factor in ((motion.by_place, 0, 1.0), (motion.by_rate, len(heavy), 1.0 / w)):
        for (i, j), samples in some.items():
            matrices[:, first + place[j]] -= b[:, i, None, None] * measure(factor * samples)
    return matrices


def at_equal_angles(problem: Torus, flows: Any, points: Floats, angles: Floats, matrices: Floats) -> Floats:
    """Matrices of the disturbances z that are compared at equal angles theta of the motor, without its row and column.

    z' = A z - y' z_w / theta', with the rates y' of the states and the disturbance z_w of the motor's.
    """
    heavy, massless = flows[3:5]
    place, turned, rates = int(np.searchsorted(heavy, problem.part.loose)), problem.pairs @ angles, []
    even, odd = np.cos(turned), np.sin(turned)
    for z in points:
        turning = 1j * (problem.orders * z[-1])[:, None]
        waves = turning * problem.coordinates(z)
        states = np.concatenate([waves[:, heavy], turning * waves[:, heavy], waves[:, massless]], axis=1).T
        rates.append(states.real @ even - states.imag @ odd)
    along = np.stack(rates, axis=1)
    matrices[:, len(heavy) + place] -= along / (along[place] + points[:, -1:])
    return np.delete(np.delete(matrices, place, axis=0), place, axis=1)


def product(a: Floats, b: Floats) -> Floats:
    """Products of matrices (n, n, ...): sums over long rows while they are small, which is quicker than one by one."""
    return np.asarray(np.einsum("ij...,jk...->ik...", a, b))


def turn_maps(problem: Torus, flows: Any, points: Floats, steps: int, starts: Floats) -> Floats:
    """Maps (points, starts, states, states) of disturbances over a turn of the first angle from second ones on.

    Magnus's method of order 4: Blanes et al. 2009, The Magnus expansion and some of its applications, Physics Reports
    470, sec. 5; the exponential function to order 8, and what it makes of volumes exactly.
    """
    (j, k), (_, q) = problem.basis.tolist()
    nodes = np.arange(steps)[:, None] + 0.5 + np.array([-1.0, 1.0]) * math.sqrt(3.0) / 6.0
    first = nodes.ravel() * 2.0 * np.pi / steps
    slow = (starts[:, None] / q + first / (problem.ratio * j + k)).ravel()
    angles = np.array([(np.tile(first, len(starts)) - k * slow) / j, slow])
    w = points[:, -1:]
    matrices = disturbed(flows, at_angles(problem, angles).moved(points), w, lambda samples: samples)
    if flows[-1] == "shift":
        matrices = at_equal_angles(problem, flows, points, angles, matrices)
    matrices *= 2.0 * np.pi / steps / (w * (j + k / problem.ratio))
    one, two = matrices[..., ::2], matrices[..., 1::2]
    x = 0.5 * (one + two) + math.sqrt(3.0) / 12.0 * (product(two, one) - product(one, two))
    n = len(x)
    unit, mean = np.eye(n)[..., None, None], np.trace(x) / n
    x -= mean * unit
    square = product(x, x)
    cube = product(square, x)
    high = product(cube, unit / 720.0 + x / 5040.0 + square / 40320.0)
    maps = unit + x + 0.5 * square + product(cube, unit / 6.0 + x / 24.0 + square / 120.0 + high)
    maps = maps.reshape(n, n, len(points), len(starts), steps)
    while maps.shape[-1] > 1:
        left = product(maps[..., 1::2], maps[..., : maps.shape[-1] - 1 : 2])
        maps = left if maps.shape[-1] % 2 == 0 else np.concatenate([left, maps[..., -1:]], axis=-1)
    volumes = np.exp(mean.reshape(len(points), len(starts), steps).sum(axis=2))
    return np.moveaxis(maps[..., 0] * volumes, (0, 1), (2, 3))
