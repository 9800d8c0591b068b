"""The balance problem of an oscillator made inside a kernel, with its first guess and what it leaves out.

To machine code all of it is at addresses, which the kernel writes itself; as Python it is a `SecondOrder`.
"""

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ...base.results import Floats
from ...compile.address import write_words
from ...compile.jit import inside, kernel_as, routine
from ..addressed import EquationsAt, error_values, excitation_torques, kinks, stiffnesses, torques
from ..balance.linear_algebra import dot, row_times
from ..balance.linear_part import clean_mean
from ..balance.piecewise import MOST_CROSSINGS, Crossings
from ..balance.second_order import SecondOrder, Work, second_order
from ..balance.springs import Sampling, Spring, SpringsAt
from ..stability.second_order import MOST_STEPS, PER_VIBRATION

LOOKED_AT = 12  # points of a curve where what is left out is estimated
MOST_KINKS = 64  # breakpoints of a law


class Functions(NamedTuple):
    """Addresses of the functions of a spring and of its balance, and whether the torque is exact: 1, or sampled: 0."""

    torques_at: int
    stiffness_at: int
    slack_at: int
    hill_at: int
    equations_at: int
    jacobian_at: int
    slope_at: int
    exact: int


inside(EquationsAt, SpringsAt)


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


def _problem_loops(system: Any, leaf: int, law: Any, functions: Any, h: int) -> Any:
    samples, n, turns = 8 * h + 8 if functions.exact > 0 else 4 * h + 4, 2 * h + 1, (2 * h + 1) // (2 * h + 1)
    back, double = analysis_of(h, samples), analysis_of(2 * h, samples)
    angles, work = np.empty(samples), np.empty(samples)
    for j in range(samples):
        angles[j] = 2.0 * math.pi * j / samples
    tau, error = np.empty(n), np.empty(n)
    excitation_torques(system.excitation, angles, work)
    row_times(work, back, tau)
    clean_mean(tau)
    error_values(system.error, angles, work)
    row_times(work, back, error)
    arena, product = np.zeros(40 * n + 4 * MOST_CROSSINGS + 8 * MOST_KINKS), np.empty((n, n))
    words, block = np.zeros(64, np.int64), np.zeros(64, np.int64)
    spring_words(law, h, functions.exact, back, double, product, arena, words)
    places = np.empty((1, 5), np.int64)
    places[0, 0], places[0, 1], places[0, 2] = words.ctypes.data, functions.torques_at, functions.stiffness_at
    places[0, 3], places[0, 4] = functions.slack_at, functions.hill_at
    springs, spare = SpringsAt(places, arena[:samples]), Work(work, np.empty(n), np.empty(n), np.zeros(n))
    problem = SecondOrder(
        system, leaf, leaf, turns, turns, synthesis_of(h, samples), back, angles, tau, error, springs, spare
    )
    write_words(problem, block)
    place: Any = np.int64(block.ctypes.data)
    equations = EquationsAt(
        place, 0 * turns, functions.equations_at, functions.jacobian_at, functions.slope_at, error,
        np.empty(n),
    )  # fmt: skip
    return problem, equations, (double, product, arena, words, block)


@kernel_as(_problem_loops)
def problem_of(system: Any, leaf: int, law: Any, functions: Any, h: int) -> Any:
    """Balance of an oscillator with so many harmonics whose parameter is the speed, its equations, and their memory."""
    problem = second_order(system, leaf, leaf, h)
    return problem, problem, ()


@routine
def grid_steps(problem: Any, law: Any, exact: int, points: Floats, count: int) -> int:
    """Steps of a period for the stability of all points, as `stability.second_order.steps_for`."""
    n, slowest = len(problem.tau), 0
    J, B, u, stiff = problem.system.J, problem.system.B, np.empty(32), np.empty(32)
    for i in range(count):
        if points[i, n] < points[slowest, n]:
            slowest = i
    if exact > 0:
        return max(128, 8 * n)
    row_times(points[slowest], synthesis_of(n // 2, 32), u)
    stiffnesses(law, u, stiff)
    rate = 0.0
    for value in stiff:
        rate = max(rate, abs(value / J - 0.25 * (B / J) ** 2))
    wanted = min(PER_VIBRATION * math.sqrt(rate) / points[slowest, n], 1.0 * MOST_STEPS)
    return int(max(128, 8 * n, math.ceil(wanted)))


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
def linear_guess(problem: Any, law: Any, omega: float) -> Floats:
    """Coefficients and speed of the response of the law's tangent at the operating point."""
    n, J, B = len(problem.tau), problem.system.J, problem.system.B
    h, guess, place, slope = n // 2, np.zeros(n + 1), np.zeros(1), np.zeros(1)
    tau, error = problem.tau, problem.error
    if tau[0] != 0.0:
        place[0] = carrying(law, tau[0])
    stiffnesses(law, place, slope)
    guess[0], guess[n] = place[0], omega
    for k in range(1, h + 1):
        inertia, loss = J * (k * omega) ** 2, B * k * omega
        a, b = tau[k] + inertia * error[k], tau[h + k] + inertia * error[h + k]
        real, size = slope[0] - inertia, 1e-18 * (abs(slope[0]) + inertia) ** 2
        bottom = max(real * real + loss * loss, size)
        guess[k], guess[h + k] = (a * real - b * loss) / bottom, (b * real + a * loss) / bottom
    return guess


@routine
def left_out(problem: Any, law: Any, point: Floats) -> float:
    """Share of a motion in the harmonics H+1 .. 3H+8, as `truncation.share_left_out`."""
    n, J, B = len(problem.tau), problem.system.J, problem.system.B
    h, w = n // 2, point[n]
    most = 3 * h + 8
    samples = 3 * most
    u, work, series = np.empty(samples), np.empty(samples), np.empty(2 * most + 1)
    row_times(point, synthesis_of(h, samples), u)
    stiffnesses(law, u, work)
    stiff = np.sum(work) / samples
    torques(law, u, work)
    row_times(work, analysis_of(most, samples), series)
    beyond = 0.0
    for k in range(h + 1, most + 1):
        size = series[k] ** 2 + series[most + k] ** 2
        beyond += size / ((stiff - J * (k * w) ** 2) ** 2 + (B * k * w) ** 2)
    return float(min(1.0, (beyond / max(dot(point[:n], point[:n]), 1e-300)) ** 0.5))


@routine
def tail_of(problem: Any, law: Any, points: Floats, count: int) -> float:
    """Largest share left out at some points of a curve."""
    worst, largest, place, n = 0.0, 0.0, 0, points.shape[1] - 1
    for i in range(count):
        for k in range(n):
            if abs(points[i, k]) > largest:
                largest, place = abs(points[i, k]), i
    for i in range(0, count, max(1, count // LOOKED_AT)):
        worst = max(worst, left_out(problem, law, points[i]))
    return float(max(worst, left_out(problem, law, points[place])))


def functions_of(system: Any, leaf: int, words: Callable[[Any], int]) -> Functions:
    """The functions of an oscillator's spring and balance in this process."""
    problem = second_order(system, leaf, leaf, 1)
    native, equations = problem.native(words), problem.addressed(words)
    torque, stiffness, slack, hill = native.springs.places[0, 1:].tolist()
    exact = 0 if problem.springs.is_sampled() else 1
    return Functions(
        torque, stiffness, slack, hill, equations.equations_at, equations.stiffness_at, equations.slope_at, exact
    )
