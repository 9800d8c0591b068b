"""Harmonic balance of any system with `rhs(phase, y)`: internal states, laws with memory and the like.

omega/turns dY/dpsi = f(turns psi, Y) with one block of coefficients (mean, cosines, sines) a state, each in units of
the state's size in the linear response, by alternating frequency/time. It runs in NumPy on whole arrays of samples:
`rhs` and `jacobian` must take arrays, as all arithmetic without branches does. Of a system whose laws have breakpoints
the samples end at the kinks of the motion (see `fourier`).

Newton's method and the linearised problem stand here too.

Krack & Gross 2019, Harmonic Balance for Nonlinear Vibration Problems, secs. 2.2-2.4.
"""

import itertools
import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ...base.protocols import Balance, System, lacking, omega_of, orders_of
from ...base.results import Booleans, Floats
from ...compile.address import ByAddress
from ...compile.jit import kernel, run
from ...compile.tree import leaf_of, leaves, with_leaf
from ..addressed import EquationsAt, difference
from . import fourier
from .first_order_at import FirstOrderAt, equations_of, native
from .harmonics import SEARCH_PER_TURN, highest_order
from .linear_part import STRENGTH, STRONG
from .rates import DIFFERENCE, SAME, base_speed, jacobians_at, number_of_states, of_strength, rates_at
from .truncation import shares_left_out

AT_ONCE = -1  # compiled from the first run on, and in NumPy where that fails
FEW_POINTS = 4  # points of a curve where what is left out is estimated
MOST_SMOOTH, MOST_KINKED = 600, 150  # points of a search for other orbits; with breakpoints
MOST_BEYOND = 100  # points beyond a range
WORK, STEP = 2e7, 0.2  # points times the square of the unknowns; steps in units of the orbit and the parameter
LOST_STEP = 1e3  # units of the unknowns: the length of a step that leads nowhere
NEAR_KINKS = 1e-7  # of a state's size, for differences of laws with breakpoints, which must not reach across one


def linearised(problem: Balance, z: Floats) -> tuple[Floats, Floats, Floats]:
    """Residual of any balance problem at z, and its derivatives by the coefficients and by the parameter."""
    n = problem.size()
    r, matrix, column = np.empty(n), np.empty((n, n)), np.empty(n)
    problem.run(_linearise, z, r, matrix, column)
    return r, matrix, column


@kernel
def _linearise(problem: Balance, z: Floats, r: Floats, matrix: Floats, column: Floats) -> None:
    problem.residual(z, r)
    problem.linearise(z, matrix, column)


def least_step(matrix: Floats, residual: Floats) -> Floats | None:
    """Newton's step, the shortest where the matrix is singular; None where it is not finite."""
    if not (np.all(np.isfinite(matrix)) and np.all(np.isfinite(residual))):  # LAPACK would print and give up
        return None
    step = np.linalg.lstsq(matrix, residual, rcond=None)[0]
    return np.asarray(step) if np.all(np.isfinite(step)) else None


def newton(
    equations: Callable[[Floats], tuple[Floats, Floats]], x: Floats, scale: Floats, tiny: float,
    *, max_steps: int = 20, solve: Callable[..., Any] = np.linalg.solve,
) -> Floats | None:  # fmt: skip
    """Root of equations, which give values and derivatives at x, or None; steps count in units `scale` of the unknowns.

    It ends at a step below `tiny`, at one after which the next would be far below it, or at one below a thousand times
    that where rounding keeps them from shrinking.
    """
    last = np.inf
    for _ in range(max_steps):
        values, derivatives = equations(x)
        try:
            step = solve(derivatives * scale, values)
        except np.linalg.LinAlgError:
            return None
        x = x - step * scale
        size = float(np.linalg.norm(step))
        if not size < LOST_STEP:
            return None
        following = size * (size / last) ** 2 if last < np.inf else np.inf  # where the steps shrink quadratically
        if size < tiny or (size < 1e3 * tiny and size > 0.3 * last) or following < 0.01 * tiny:
            return x
        last = size
    return None


class FirstOrder(NamedTuple):
    """Balance of omega/turns dY/dpsi = f(turns psi, Y); an orbit takes `turns` turns of the base angle, or a part 1/g.

    `sizes` are the units of the states.
    """

    system: Any
    leaf: int
    omega_leaf: int
    turns: float
    sizes: Floats
    synthesis: Floats
    analysis: Floats
    analysis_double: Floats
    angles: Floats
    kinked: bool = False

    def size(self) -> int:
        return len(self.sizes) * len(self.synthesis)

    def harmonics(self) -> int:
        return len(self.synthesis) // 2

    def harmonic(self, z: Floats, k: int) -> Any:
        """Cosine and sine coefficients of harmonic k of the first state, in units of its size."""
        return z[k], z[self.harmonics() + k]

    def run(self, kernel: Callable[..., Any], *arguments: Any) -> Any:
        return self.run_as(self.addressed, "equations", kernel, *arguments)

    def run_as(self, addressed: Any, again: str, kernel: Callable[..., Any], *arguments: Any) -> Any:
        """Run a kernel with the problem as NumPy or as what `addressed` makes of it, kept under the name `again`."""
        if lacking(self.system, "_fields") or (self.kinked and lacking(self.system, "kinks")):
            return kernel(self, *arguments)  # no model: compiled code does not know its class
        return run(kernel, ByAddress(self, addressed, again), *arguments, after=AT_ONCE)

    def native(self, words: Callable[[Any], int]) -> FirstOrderAt:
        """The problem for machine code."""
        kinks = len(fourier.distances(self.system, np.zeros(1), np.zeros((len(self.sizes), 1)))) if self.kinked else 0
        return native(self, kinks, words)

    def addressed(self, words: Callable[[Any], int]) -> EquationsAt:
        """The equations for machine code."""
        return equations_of(self.native(words), words)

    def hill(self) -> bool:
        return False

    def state_count(self) -> int:
        return len(self.sizes)

    def highest(self) -> int:
        return self.harmonics()

    def series(self, points: Floats) -> Floats:
        """Coefficients (points, states, 2H+1), in blocks and in the states' own units."""
        width = (points.shape[1] - 1) // len(self.sizes)
        return np.asarray(points[:, :-1].reshape(len(points), len(self.sizes), width) * self.sizes[:, None])

    def displacements(self, points: Floats) -> Floats:
        """Coefficients (points, 2H+1) of the first state in blocks."""
        return np.asarray(self.series(points)[:, 0])

    def table(self, point: Floats) -> Floats:
        return fourier.from_blocks(self.series(point[None])[0].T)

    def state_table(self, table: Floats) -> Floats:
        """Table of the states that `find_orbit` takes: the same."""
        return table

    def motion(self, point: Floats, _: Floats) -> Floats:
        """Table (2H+1, states) of a point."""
        return self.table(point)

    def point(self, table: Floats, value: float) -> Floats:
        """Point (coefficients, parameter) of a table (2H+1, states): mean, cos 1, sin 1, ...; cut or filled up."""
        series = fourier.gathered(fourier.to_blocks(table).T, 1, self.harmonics())
        return np.append((series / self.sizes[:, None]).ravel(), value)

    def fitted(self, table: Floats, value: float) -> Floats | None:
        """Point of a table, cut or filled up."""
        return self.point(table, value)

    def sampled(self, y: Floats, value: float) -> Floats:
        """Point of a motion with the states y (states, samples) at the problem's angles."""
        return np.append(y @ self.analysis / self.sizes[:, None], value)

    def difference(self) -> float:
        """Half of the central differences for the Jacobian, in units of the states' sizes."""
        return NEAR_KINKS if self.kinked else DIFFERENCE

    def steps(self) -> Floats:
        """The same (states,), in the states' own units."""
        return self.difference() * self.sizes

    def places(self, system: System, y: Floats, wide: int = 1) -> tuple[Floats, Floats, Floats]:
        """Base angles [rad] of the samples, synthesis of the states there, and analysis up to harmonic `wide` H."""
        if not self.kinked:
            return self.angles, self.synthesis, self.analysis if wide == 1 else self.analysis_double
        return fourier.panels(system, y, self.turns, wide)

    def along(self, function: Any, value: float, angles: Floats, y: Floats) -> Floats:
        """Values of a function of the system in the states y (states, samples) at base angles [rad] and a parameter.

        With STRENGTH what varies with the angle at a fixed state is multiplied, and its mean over a turn is not.
        """
        system = with_leaf(self.system, self.leaf, value)
        if self.leaf != STRENGTH:
            return np.asarray(function(system, angles, y))
        return of_strength(function, system, angles, y, self.angles_of_mean(), float(np.exp(value)))

    def slopes(self, system: System, angles: Floats, y: Floats) -> Floats:
        """Derivatives (states, states, samples) of the rates by the states."""
        return jacobians_at(system, angles, y, self.sizes, self.difference())

    def angles_of_mean(self) -> Floats:
        """Base angles [rad] of a mean over the period: all samples, or the fewest that know the orders of the system.

        The mean is only where the curves along the strength begin: at the strength 1 it cancels.
        """
        orders = {round(times * order * self.turns) for order in orders_of(self.system) for times in (1, 2, 3)} - {0}
        if not orders:
            return self.angles
        enough = next(n for n in itertools.count(5) if all(order % n for order in orders))
        return 2.0 * np.pi * self.turns * np.arange(enough) / enough

    def residual(self, z: Floats, r: Floats) -> None:
        """Residual of every coefficient, in units of the state's size a second."""
        y = self.series(z[None])[0]
        angles, synthesis, analysis = self.places(with_leaf(self.system, self.leaf, float(z[-1])), y)
        states = y @ synthesis
        rates = self.along(rates_at, float(z[-1]), angles, states)
        balance = base_speed(self, float(z[-1])) / self.turns * fourier.derivative(y) - rates @ analysis
        r[:] = (balance / self.sizes[:, None]).ravel()

    def linearise(self, z: Floats, jacobian: Floats, slope: Floats) -> None:
        """Derivatives of the residual by the coefficients and by the parameter."""
        n, states, value, y = len(self.synthesis), len(self.sizes), float(z[-1]), self.series(z[None])[0]
        h = n // 2
        angles, synthesis, analysis = self.places(with_leaf(self.system, self.leaf, value), y, 2)
        matrices = self.along(self.slopes, value, angles, y @ synthesis)
        blocks = np.empty((states, states, n, n))
        fourier.multiply_rows(*fourier.extended(matrices @ analysis, h), h, 1, blocks)
        blocks *= (-self.sizes / self.sizes[:, None])[:, :, None, None]
        k = np.arange(1, h + 1)
        kw = base_speed(self, value) / self.turns * k
        for i in range(states):
            blocks[i, i, k, h + k] += kw
            blocks[i, i, h + k, k] -= kw
        jacobian[: self.size(), : self.size()] = blocks.transpose(0, 2, 1, 3).reshape(self.size(), self.size())
        difference(self, z, slope, np.empty(self.size()))

    def of(self, system: System) -> "FirstOrder":
        """The problem of another system of the same classes, with the same excitation."""
        return self._replace(system=system)

    def linear_response(self, value: float) -> Floats:
        """Guess (coefficients, parameter): the response of the system linearised where its mean rate vanishes."""
        z = np.append(np.zeros(self.size()), value)
        means = np.arange(len(self.sizes)) * len(self.synthesis)
        with np.errstate(all="ignore"):
            for _ in range(20):
                r, a, _ = linearised(self, z)
                step = least_step(a[np.ix_(means, means)], r[means])
                if step is None:
                    return np.append(np.zeros(self.size()), value)
                z[means] -= step
                if np.linalg.norm(step) < 1e-10:
                    break
            r, a, _ = linearised(self, z)
            step = least_step(a, r)
        if step is None:
            return np.append(np.zeros(self.size()), value)
        z[:-1] -= step
        return z

    def left_out(self, points: Floats, index: int) -> tuple[Floats, Floats]:
        """Parameter at some points of a curve, one at `index`, and the shares (values, states) left out there."""
        largest = int(np.argmax(np.max(points[:, :-1], axis=1)))
        few = points[np.unique([*range(0, len(points), max(1, len(points) // FEW_POINTS)), largest, index])]
        return few[:, -1], shares_left_out(self, few)

    def disturbed(self, points: Floats) -> tuple["FirstOrder", Floats, int]:
        """The problem and its points: all states, over the whole orbit."""
        return self, points, 1

    def disturbances(self, _: Floats) -> None:
        """No part of its disturbances is known to be constant."""

    def damping_leaf(self) -> int | None:
        return None if lacking(self.system, *SAME) else leaf_of(self.system, "B")

    def odd(self) -> None:
        return None

    def biased(self) -> None:
        return None

    def floating(self, points: Floats) -> Booleans:
        """False for every point: a law without torque on an orbit is not looked for."""
        return np.zeros(len(points), bool)

    def several_at(self, points: Floats) -> Booleans:
        may = np.empty(len(points), bool)
        for i, point in enumerate(points):
            a = linearised(self, point)[1]
            b = linearised(self, np.append(3.0 * point[:-1], point[-1]))[1]
            may[i] = np.max(np.abs(a - b)) > 1e-6 * np.max(np.abs(a))
        return may

    def to_search(self, value: float) -> "FirstOrder":
        """The problem at a base frequency, with as many harmonics as the search for other orbits takes."""
        system, leaf = with_leaf(self.system, self.omega_leaf, value), self.omega_leaf
        few = max(SEARCH_PER_TURN, math.ceil(3 * highest_order(system) * self.turns))
        if few >= self.highest():
            return self._replace(system=system)
        return first_order(system, leaf, leaf, few, self.turns, self.sizes)

    def strongest(self) -> float:
        return STRONG

    def ways(self) -> list[int]:
        return [self.omega_leaf, STRENGTH]

    def budget(self) -> tuple[int, float]:
        return MOST_KINKED if self.kinked else min(MOST_SMOOTH, int(WORK / self.size() ** 2)), STEP

    def patience(self) -> int:
        return MOST_BEYOND


def first_order(
    system: Any, leaf: int, omega_leaf: int, harmonics: int, turns: float = 1, sizes: Floats | None = None
) -> FirstOrder:  # fmt: skip
    """Build the general balance problem of a system for a number of harmonics of omega/turns.

    Default of the `sizes`: those of its linear response.
    """
    samples = 4 * harmonics + 4
    states = number_of_states(system)
    kinked = len(fourier.distances(system, np.zeros(1), np.zeros((states, 1)))) > 0
    problem = FirstOrder(
        system, leaf, omega_leaf, turns, np.ones(states) if sizes is None else sizes,
        fourier.synthesis(harmonics, samples), fourier.analysis(harmonics, samples),
        fourier.analysis(2 * harmonics, samples),
        2.0 * np.pi * turns * np.arange(samples) / samples, kinked,
    )  # fmt: skip
    if sizes is not None:
        return problem
    value = omega_of(system) if leaf == omega_leaf else leaves(system)[leaf]
    with np.errstate(all="ignore"):
        sizes = np.linalg.norm(problem.series(problem.linear_response(float(value))[None])[0], axis=1)
    if not lacking(system, "sizes"):  # a state that vanishes in the linear response
        sizes = np.maximum(np.nan_to_num(sizes), system.sizes())
    return problem._replace(sizes=np.where(np.isfinite(sizes) & (sizes > 0.0), sizes, 1.0))
