"""Computed first harmonics at measured frequencies, on the branch of each measurement, with their sensitivities.

At a measured point the harmonic balance R(z, omega; p) = 0 is solved from the measured motion, so that the solution is
the one on its branch; the implicit function theorem gives dz/dp = -R_z^-1 R_p and dz/domega. At a fold there is a left
vector w with w R_z = 0: the fold moves by domega/dp = -(w R_p)/(w R_omega).

Krack & Gross 2019, Harmonic Balance for Nonlinear Vibration Problems, secs. 2.3, 4.2; Govaerts 2000, Numerical Methods
for Bifurcations of Dynamical Equilibria, sec. 3.3 (folds).
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ....base.results import Floats
from ....compile.tree import leaf_of, with_leaf
from ....numerics.balance.first_order import linearised, newton
from ....numerics.balance.second_order import second_order
from ....numerics.curves.fold_curve import FoldSystem
from ..fitted import with_values

Complexes = NDArray[np.complex128]
STEP = 1e-6  # of a parameter's size, for derivatives of the residual


class Points:
    """Measured frequencies (n,) [rad/s] and first harmonics (n,), and a system with free parameters.

    Parameters of `at` are in units of `sizes`. Solutions are continued from the last parameters that were kept.
    """

    def __init__(
        self, system: Any, leaves: Sequence[int], sizes: Floats, omega: Floats, measured: Complexes, harmonics: int
    ) -> None:
        self.system, self.leaves, self.sizes, self.omega, self.h = system, leaves, sizes, omega, harmonics
        self.leaf, self.measured = leaf_of(system, "omega"), measured
        self.kept: Floats | None = None
        self.solved_at: Floats | None = None
        self.computed: Complexes = measured
        self.found: list[Floats | None] = []
        self.solutions: list[Floats | None] = [None] * len(omega)
        self.slopes: list[Floats] = [np.zeros((2 * harmonics + 1, len(leaves) + 1))] * len(omega)

    def at(self, p: Floats) -> Any:
        """The system with parameters p."""
        return with_values(self.system, self.leaves, p * self.sizes)

    def problem(self, system: Any, omega: float) -> Any:
        """Balance problem of a system at a frequency."""
        return second_order(with_leaf(system, self.leaf, omega), self.leaf, self.leaf, self.h)

    def start(self, i: int) -> Floats:
        """Measured motion as coefficients (2H+1, 1): its first harmonic."""
        table = np.zeros((2 * self.h + 1, 1))
        table[1:3, 0] = self.measured[i].real, -self.measured[i].imag
        return table

    def pull(self, p: Floats) -> tuple[Complexes, Complexes]:
        """Force (n,) that the measured motion takes at the first harmonic, and the force that there is [N*m]."""
        needed, applied, system = np.empty(len(self.omega), complex), np.empty(len(self.omega), complex), self.at(p)
        for i, omega in enumerate(self.omega):
            problem = self.problem(system, float(omega))
            r, tau, h = _residual(problem, problem.point(self.start(i), float(omega))), problem.tau, self.h
            needed[i] = complex(r[1] + tau[1], -r[h + 1] - tau[h + 1])
            applied[i] = complex(tau[1], -tau[h + 1])
        return needed, applied

    def solve(self, p: Floats) -> Complexes:
        """Computed first harmonics (n,); where there is no solution they are continued in a straight line."""
        if self.solved_at is not None and np.array_equal(p, self.solved_at):
            return self.computed
        amplitudes: Complexes = np.empty(len(self.omega), complex)
        system = self.at(p)
        self.found = []
        for i, omega in enumerate(self.omega):
            problem, before = self.problem(system, float(omega)), self.solutions[i]
            guess = problem.point(self.start(i), float(omega))[:-1] if before is None else before
            if before is not None and self.kept is not None:
                guess = before + self.slopes[i][:, :-1] @ (p - self.kept)
            z = _solved(problem, guess, float(omega))
            self.found.append(z)
            amplitudes[i] = complex(*problem.harmonic(guess if z is None else z, 1)).conjugate()
        self.solved_at, self.computed = p.copy(), amplitudes
        return amplitudes

    def again(self, chosen: Any) -> None:
        """Forget the solutions of chosen points (n,): they are solved from the measured motion again."""
        for i in np.flatnonzero(chosen):
            self.solutions[i] = self.solved_at = None

    def keep(self, p: Floats) -> tuple[Complexes, Complexes]:
        """Derivatives (n, p) of the first harmonics by the parameters over their sizes, and (n,) by the frequency.

        The solutions at p become those from which others are continued.
        """
        self.solve(p)
        slopes, along = np.zeros((len(self.omega), len(p)), complex), np.zeros(len(self.omega), complex)
        self.kept, variants = p.copy(), self.stepped(p)
        for i, z in enumerate(self.found):
            if z is None:
                slopes[i], along[i] = self._of(self.slopes[i])
                continue
            by_p, matrix, by_omega = self.by_parameters(variants, np.append(z, self.omega[i]))
            self.slopes[i] = np.asarray(np.linalg.solve(matrix, -np.column_stack([by_p, by_omega])))
            self.solutions[i] = z
            slopes[i], along[i] = self._of(self.slopes[i])
        return slopes, along

    def _of(self, slope: Floats) -> tuple[Any, Any]:
        both = slope[1] - 1j * slope[self.h + 1]
        return both[:-1], both[-1]

    def stepped(self, p: Floats) -> list[tuple[Any, Any, float]]:
        """The system at p, then with each parameter a step above and a step below, and twice the step."""
        steps = np.diag(STEP * np.maximum(np.abs(p), 0.1))
        return [(self.at(p), None, 0.0), *((self.at(p + d), self.at(p - d), 2.0 * float(np.sum(d))) for d in steps)]

    def by_parameters(self, variants: list[tuple[Any, Any, float]], point: Floats) -> tuple[Floats, Floats, Floats]:
        """Derivatives of the residual at a point (z, omega): by p (2H+1, p), z and omega; `variants`: `stepped(p)`."""
        omega = float(point[-1])
        columns = [
            (_residual(self.problem(above, omega), point) - _residual(self.problem(below, omega), point)) / twice
            for above, below, twice in variants[1:]
        ]
        _, matrix, along = linearised(self.problem(variants[0][0], omega), point)
        return np.array(columns).T, matrix, along

    def fold(self, p: Floats, z: Floats) -> tuple[float, Floats, Floats] | None:
        """Fold near a point (z, omega): its frequency, its derivatives (p,) and its point; None where there is none."""
        problem = self.problem(self.at(p), float(z[-1]))
        extended = FoldSystem(problem, "J", float(problem.system.J))
        with np.errstate(all="ignore"):
            found = extended.corrected(np.append(z, problem.system.J), None)
        if found is None:
            return None
        by_p, _, along = self.by_parameters(self.stepped(p), found[:-1])
        return float(found[-2]), -(extended.left @ by_p) / float(extended.left @ along), found[:-1]


def _residual(problem: Any, point: Floats) -> Floats:
    """Residual (2H+1,) of the balance at a point, as an array of its own."""
    r = np.empty(problem.size())
    problem.residual(point, r)
    return r


def _solved(problem: Any, guess: Floats, omega: float) -> Floats | None:
    """Solution at a frequency, or None."""

    def equations(z: Floats) -> tuple[Floats, Floats]:
        return linearised(problem, np.append(z, omega))[:2]

    scale = np.full(len(guess), float(np.linalg.norm(guess)) or 1.0)
    with np.errstate(all="ignore"):
        return newton(equations, guess, scale, 1e-10, far=3.0)
