"""`backbone`: free undamped periodic motion, the curve along which resonance peaks lie (phase resonance).

J u'' + T(u) = mean torque, with the amplitude of the first harmonic prescribed: the unknowns are the mean, the cosines
from the second on and the frequency. Free motion of one degree of freedom is symmetric in time, so there are no sines.

Krack & Gross 2019, Harmonic Balance for Nonlinear Vibration Problems, sec. 4.1 (nonlinear modes).
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ...base.law import springs_only
from ...base.protocols import Balance, with_parts
from ...base.quantities import numbers, shown
from ...base.results import Floats, Status
from ...base.series import largest_size
from ...compile.tree import leaf_of
from ..balance.first_order import linearised, newton
from ..balance.fourier import from_blocks
from ..balance.harmonics import MOST_HARMONICS, grown, starting_harmonics
from ..balance.linear_part import one_harmonic
from ..balance.rates import SAME
from ..balance.second_order import second_order
from ..balance.truncation import FREE, Tail

FIRST_AMPLITUDE, LEAST_STEP = 0.1, 1e-4  # of an amplitude: where steps to it begin, and the least of them
NEAR_FREQUENCY = 0.1  # relative: frequencies further from where a step leads are those of another motion


@dataclass(frozen=True, eq=False)
class Backbone:
    """Free undamped vibration against amplitude.

    Attributes
    ----------
    amplitude : (n,) array
        Amplitude of the first harmonic of the torsion u, 0-to-peak [rad].
    omega : (n,) array
        Frequency of the free vibration [rad/s].
    peak : (n,) array
        Largest |u| [rad].
    coefficients : (n, 2H+1) array
        Fourier coefficients of u: mean, cos 1, sin 1 (0), cos 2, ...
    tail : float
        Largest size of the last two harmonics relative to the first.
    status : Status
        `Status.OK`; `Status.TRUNCATED` where `tail` is above 1e-3; or why amplitudes are missing.
    message : str
        One sentence.
    """

    amplitude: Floats
    omega: Floats
    peak: Floats
    coefficients: Floats
    tail: float
    status: Status
    message: str

    def __str__(self) -> str:
        if not len(self.omega):
            return f"Backbone: no point; {self.message}"
        return (
            f"Backbone: {len(self.omega)} points, amplitude(1) {self.amplitude[0]:.6g} .. {self.amplitude[-1]:.6g}, "
            f"omega {self.omega[0]:.9g} .. {self.omega[-1]:.9g} rad/s\n"
            f"  {self.coefficients.shape[1] // 2} harmonics, tail {self.tail:.1e}; {self.message}"
        )

    __repr__ = __str__


def backbone(system: Any, amplitudes: ArrayLike, *, harmonics: int | None = None) -> Backbone:
    """Find the free undamped vibrations of given amplitudes about the operating point of the mean torque.

    Parameters
    ----------
    system : Oscillator
        Its damping, kinematic error and the alternating part of its excitation are left out.
    amplitudes : array_like
        Amplitudes (n,) of the first harmonic of u, 0-to-peak [rad], positive.
    harmonics : int, optional
        Highest harmonic. Default: grown until the last two are negligible (1e-11), at most 127; with too few for 1e-3
        of the amplitude the status is `Status.TRUNCATED`.

    Returns
    -------
    Backbone
        `amplitude` [rad] and `omega` [rad/s], (n,) arrays: one point for each amplitude that has a free vibration.

    Raises
    ------
    ValueError
        If an amplitude is not positive and finite.

    References
    ----------
    Krack & Gross 2019, Harmonic Balance for Nonlinear Vibration Problems, sec. 4.1.
    """
    system = with_parts("backbone", system, *SAME)
    springs_only("backbone", system)
    sizes = numbers("amplitudes [rad]", amplitudes)
    if not np.all(sizes > 0.0):
        raise ValueError(f"amplitudes [rad] are {shown(amplitudes)}; they must be positive")
    h = starting_harmonics(system, harmonics, 1)
    leaf = leaf_of(system, "omega")

    def freed(h: int, _: float) -> tuple[tuple[int, Any, Floats, Floats], float]:
        problem = second_order(system._replace(B=0.0), leaf, leaf, h)
        mean = np.zeros(2 * h + 1)
        mean[0] = problem.tau[0]
        problem = problem._replace(tau=mean, error=0.0 * mean)
        solutions = _along(problem, sizes)
        solved = np.array([z is not None for z in solutions])
        points = np.array([z for z in solutions if z is not None]).reshape(-1, 2 * h + 2)
        last = points[:, max(1, h - 1) : h + 1]
        tails = np.linalg.norm(last, axis=1) / sizes[solved]
        worst = float(np.max(tails, initial=0.0)) if solved.all() else np.inf  # near a separatrix many are needed
        return (h, solved, points, tails), worst

    h, solved, points, tails = grown(freed, h, MOST_HARMONICS if harmonics is None else h, FREE)
    tail = float(np.max(tails, initial=0.0))
    coefficients = from_blocks(points[:, :-1].T).T
    status, message = Status.OK, "finished"
    if not np.all(solved):
        missing = ", ".join(f"{a:.4g}" for a in sizes[~solved][:4])
        status = Status.NO_CONVERGENCE
        message = (
            f"Newton's method found no free vibration of amplitude(1) {missing} rad; take smaller amplitudes or more "
            "harmonics"
        )
    if len(points):
        speed = float(points[np.argmax(tails), -1])
        status, message = Tail(tail, tail, speed, h).verdict(status, message, "omega", speed)
    return Backbone(sizes[solved], points[:, -1], largest_size(coefficients), coefficients, tail, status, message)


def _along(problem: Balance, amplitudes: Floats) -> list[Floats | None]:
    """Solution (coefficients in blocks, omega) for every amplitude, each from the next smaller.

    Those left, as about a gap, are from the next larger or from one harmonic.
    """
    solutions: list[Floats | None] = [None] * len(amplitudes)
    upwards = np.argsort(amplitudes, kind="stable")
    before: Floats | None = None
    for i in upwards:
        a = float(amplitudes[i])
        start = _free(problem, _one_harmonic(problem, FIRST_AMPLITUDE * a)) if before is None else before
        solutions[i] = None if start is None else _climbed(problem, start, a)
        before = before if solutions[i] is None else solutions[i]
    top, before = before, None
    for i in upwards[::-1]:
        a = float(amplitudes[i])
        if solutions[i] is None and (top is None or a < top[1]):
            point = None
            if before is not None:
                guess = before.copy()
                guess[1:-1] *= a / before[1]
                point = _free(problem, guess)
            solutions[i] = _free(problem, _one_harmonic(problem, a)) if point is None else point
        before = before if solutions[i] is None else solutions[i]
    return solutions


def _climbed(problem: Balance, point: Floats, a: float) -> Floats | None:
    """Solution of an amplitude from that of a smaller one, by steps along the line through the last two."""
    before, step = None, a - point[1]
    while point[1] < a:
        step = min(step, a - point[1])
        slope = np.append(0.0, point[1:] / point[1]) if before is None else (point - before) / (point[1] - before[1])
        slope[-1] *= before is not None
        guess = point + step * slope
        guess[1] = min(a, point[1] + step)
        solution = _free(problem, guess)
        if solution is None or abs(solution[-1] - guess[-1]) > NEAR_FREQUENCY * point[-1]:
            step *= 0.5
            if step < LEAST_STEP * a:
                return None
            continue
        before, point, step = point, solution, 1.5 * step
    return point


def _one_harmonic(problem: Any, a: float) -> Floats:
    """Guess by the describing function: one harmonic about the operating point."""
    system, h = problem.system, problem.harmonics()
    z = np.zeros(2 * h + 2)
    mean, stiffness = one_harmonic(system.law, float(problem.tau[0]), np.array([a]))
    z[0], z[1], z[-1] = mean[0], a, np.sqrt(max(float(stiffness[0]), 0.0) / system.J)
    return z


def _free(problem: Balance, z: Floats) -> Floats | None:
    """Newton's method for the mean, the cosines but the first, and omega; None where it fails."""
    if not z[-1] > 0.0:
        return None
    n = len(z) - 1
    cosines = np.arange(n // 2 + 1)  # mean and cosines
    unknown = np.delete(np.append(cosines, n), 1)
    scale = np.append(np.full(len(cosines) - 1, abs(z[1])), z[-1])

    def filled(x: Floats) -> Floats:
        full = z.copy()
        full[unknown] = x
        return full

    def equations(x: Floats) -> tuple[Floats, Floats]:
        r, matrix, column = linearised(problem, filled(x))
        return r[cosines], np.column_stack([matrix, column])[np.ix_(cosines, unknown)]

    free = newton(equations, z[unknown], scale, 1e-13, max_steps=40)
    if free is None or not free[-1] > 0.0 or problem.floating(filled(free)[None])[0]:  # inside a gap nothing vibrates
        return None
    return filled(free)
