"""Harmonic balance of J u'' + B u' + T(u) = tau - J e'': the equations of the Fourier coefficients, and their Jacobian.

`SecondOrder` is the `Balance` of an oscillator: it works on the torsion u alone (velocity eliminated).

Krack & Gross 2019, Harmonic Balance for Nonlinear Vibration Problems, secs. 2.2-2.4 (AFT) and 3.2 (Jacobian).
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ...base.results import Booleans, Floats
from ...base.series import remembered
from ...compile.address import ByAddress
from ...compile.calls import at
from ...compile.jit import run
from ...compile.tree import leaf_of, with_leaf
from ..addressed import EquationsAt, difference, equations_at, error_values, excitation_torques, oscillator_at, varied
from . import linear_part
from .fourier import all_orders, analysis, from_blocks, gathered, orders, synthesis, to_blocks, with_velocity
from .harmonics import SEARCH_PER_TURN, seems_odd
from .linear_algebra import copy, extremes, fill, padded, row_times
from .linear_part import STRENGTH, Around, add_linear, add_linear_jacobian, clean_mean, drive, forced, vary
from .piecewise import is_piecewise_linear
from .rates import base_speed
from .springs import of_law, springs_for
from .truncation import few_of, share_left_out

FIELDS = frozenset({"J", "B", "omega", "law", "excitation", "error"})
LIGHT = 33  # unknowns of a sampled law up to which NumPy follows a curve in a fraction of a second
ROUNDING = 1e-9  # of the largest line: less is none
BIAS = 0.02  # constant torque that breaks a symmetry, of the largest drive
BUDGET, STEP = 2500, 0.1  # points of a search for other orbits, and its steps in units of the orbit and the parameter


class Work(NamedTuple):
    """Buffers, so that nothing is allocated where equations are solved."""

    f: Floats
    tau: Floats
    error: Floats
    nothing: Floats


class SecondOrder(NamedTuple):
    """Balance of J u'' + B u' + T(u) = tau - J e'' in the torsion u = x - e; an orbit takes `turns` turns.

    With stride 2 the unknowns are odd harmonics alone (and a mean of zero): u(phase + pi) = -u(phase).
    """

    system: Any
    leaf: int
    omega_leaf: int
    turns: int
    stride: int
    synthesis: Floats
    analysis: Floats
    angles: Floats
    tau: Floats
    error: Floats
    springs: Any
    work: Work

    def size(self) -> int:
        return len(self.tau)

    def harmonics(self) -> int:
        return len(self.tau) // 2

    def harmonic(self, z: Floats, k: int) -> Any:
        """Cosine and sine coefficients of x in the unknowns' k-th harmonic."""
        h = len(self.error) // 2
        return z[k] + self.error[k], z[h + k] + self.error[h + k]

    def prepare(self, z: Floats) -> None:
        """Coefficients of torque and kinematic error at z into `work`; of a frequency alone they are the problem's."""
        self = at(self)
        work, value = self.work, z[len(self.tau)]
        if self.leaf <= STRENGTH:
            copy(self.tau, work.tau)
            copy(self.error, work.error)
            vary(self.leaf, value, work.tau, work.error, False)
        else:
            system = varied(self.system, self.leaf, value)
            excitation_torques(system.excitation, self.angles, work.f)
            row_times(work.f, self.analysis, work.tau)
            clean_mean(work.tau)
            error_values(system.error, self.angles, work.f)
            row_times(work.f, self.analysis, work.error)

    def equations(self, z: Floats, r: Floats) -> None:
        """Residual [N*m] of every coefficient at z = (coefficients of u, parameter), with what `prepare` has left."""
        self = at(self)
        work, system = self.work, varied(self.system, self.leaf, z[len(self.tau)])
        springs = of_law(self.springs, system.law)
        springs.torques(len(self.tau), z, self.synthesis, r)
        w, alone = system.omega / self.turns, self.leaf == self.omega_leaf
        tau, error = (self.tau, self.error) if alone else (work.tau, work.error)
        add_linear(system.J, system.B, w, self.stride, z, tau, error, r)
        if tau[0] == 0.0:
            r[0] += system.J * w * w * springs.slack()

    def stiffness(self, z: Floats, jacobian: Floats) -> None:
        """Derivatives of the residual by the coefficients; follows `equations` at the same z."""
        self = at(self)
        n = len(self.tau)
        system = varied(self.system, self.leaf, z[n])
        of_law(self.springs, system.law).stiffnesses(n, jacobian)
        w = system.omega / self.turns
        inertia = system.J * w * w
        if self.stride > 1:
            jacobian[0, 0] = inertia
        elif abs(jacobian[0, 0]) < 1e-9 * inertia:  # nothing holds the mean in the play of a gear
            low, high = extremes(self.springs.samples)
            for j in range(n):
                jacobian[0, j] = 0.5 * inertia * (self.synthesis[j, low] + self.synthesis[j, high])
        add_linear_jacobian(system.J, system.B, w, self.stride, n // 2, jacobian)

    def by_speed(self, z: Floats, slope: Floats) -> None:
        """Derivative of the residual by the base frequency."""
        self = at(self)
        system = varied(self.system, self.leaf, z[len(self.tau)])
        w, per_turn = system.omega / self.turns, 1.0 / system.omega
        fill(0.0, slope)
        add_linear(2.0 * system.J * per_turn, system.B * per_turn, w, self.stride, z, slope, self.error, slope)

    def by_strength(self, z: Floats, slope: Floats) -> None:
        """Derivative of the residual by a virtual leaf; `prepare` must come before the next residual."""
        self = at(self)
        work, value = self.work, z[len(self.tau)]
        system = varied(self.system, self.leaf, value)
        copy(self.tau, work.tau)
        copy(self.error, work.error)
        vary(self.leaf, value, work.tau, work.error, True)
        fill(0.0, slope)
        add_linear(system.J, 0.0, system.omega / self.turns, self.stride, work.nothing, work.tau, work.error, slope)

    def residual(self, z: Floats, r: Floats) -> None:
        """Residual [N*m] of every coefficient at z = (coefficients of u, parameter)."""
        if self.leaf != self.omega_leaf:
            self.prepare(z)
        self.equations(z, r)

    def linearise(self, z: Floats, jacobian: Floats, slope: Floats) -> None:
        """Derivatives of the residual by the coefficients and by the parameter; follows `residual` at the same z."""
        self.stiffness(z, jacobian)
        if self.leaf == self.omega_leaf:
            self.by_speed(z, slope)
        elif self.leaf <= STRENGTH:
            self.by_strength(z, slope)
        else:
            difference(self, z, slope, np.empty(self.size()))

    def run(self, kernel: Callable[..., Any], *arguments: Any) -> Any:
        if not FIELDS.issubset(self.system._fields):  # a system like an oscillator whose numbers are none of these
            return kernel(self, *arguments)
        return run(kernel, ByAddress(self, self.addressed, "equations"), *arguments, light=self.light())

    def light(self) -> bool:
        """True if a few of its kernels take NumPy less time than Numba takes to load."""
        return self.springs.is_sampled() and self.size() <= LIGHT

    def addressed(self, words: Callable[[Any], Any]) -> EquationsAt:
        """The equations for machine code."""
        by_omega, virtual = self.leaf == self.omega_leaf, self.leaf <= STRENGTH
        slope = SecondOrder.by_speed if by_omega else SecondOrder.by_strength if virtual else None
        native = words(ByAddress(self, self.native, "words"))
        return equations_at(native, words, None if by_omega else SecondOrder.prepare, slope, self.error)

    def native(self, words: Callable[[Any], int]) -> "SecondOrder":
        """The problem with its oscillator and law by address: of one type for all."""
        system, leaf, law_words = oscillator_at(self.system, self.leaf, words)
        return self._replace(
            system=system, leaf=leaf, omega_leaf=system._fields.index("omega"),
            springs=self.springs.addressed(words, law_words),
        )  # fmt: skip

    def hill(self) -> bool:
        return True

    def state_count(self) -> int:
        return 2

    def highest(self) -> int:
        return int(self.stride * (self.harmonics() - 1) + 1)

    def series(self, points: Floats) -> Floats:
        """Coefficients (points, 1, 2H+1) of u in blocks, with those of all orders."""
        return all_orders(points[:, :-1], self.stride)[:, None]

    def displacements(self, points: Floats) -> Floats:
        """Coefficients (points, 2H+1) of x in blocks, with those of all orders."""
        errors = self.error
        # it may vary along the branch
        if self.leaf != self.omega_leaf and with_leaf(self.system, self.leaf, 0.0).error is not self.system.error:
            systems = [with_leaf(self.system, self.leaf, value) for value in points[:, -1].tolist()]
            errors = np.array([forced(system, self.angles, self.analysis)[1] for system in systems])
        return all_orders(points[:, :-1] + errors, self.stride)

    def table(self, point: Floats) -> Floats:
        return from_blocks(self.series(point[None])[0].T)

    def state_table(self, table: Floats) -> Floats:
        """Table of x = u + e, which `find_orbit` takes."""
        error = from_blocks(all_orders(self.error[None, :], self.stride)[0])[: len(table), None]
        out = table.copy()
        out[: len(error)] += error
        return out

    def motion(self, point: Floats, x: Floats) -> Floats:
        """Table (2H+1, 2) of x and its rate, from the series of x: mean, cos 1, sin 1, ..."""
        return with_velocity(x, base_speed(self, float(point[-1])) / self.turns)

    def point(self, table: Floats, value: float) -> Floats:
        """Point (coefficients, parameter) of a table of x, cut or filled up; not of odd harmonics alone."""
        return np.append(gathered(to_blocks(table[:, 0]), 1, self.harmonics()) - self.error, value)

    def sampled(self, y: Floats, value: float) -> Floats:
        """Point of a motion with the states y (2, samples) at the problem's angles."""
        return np.append(y[0] @ self.analysis - self.error, value)

    def fitted(self, table: Floats, value: float) -> Floats | None:
        """Point of a table of u, cut or filled up; None where the symmetry of the problem has no such orbit."""
        highest = self.highest()
        blocks = gathered(to_blocks(table[:, 0]), 1, highest)
        if self.stride > 1:
            even = np.r_[0, 2 : highest + 1 : 2, highest + 2 : 2 * highest + 1 : 2]
            if np.linalg.norm(blocks[even]) > 1e-6 * np.linalg.norm(blocks):
                return None
            blocks[0] = 0.0
            blocks = np.delete(blocks, even[1:])
        return np.append(blocks, value)

    def linear_response(self, value: float) -> Floats:
        """Guess (coefficients, parameter): the steady response of the law's tangent at the operating point."""
        system, tau, error = with_leaf(self.system, self.leaf, float(value)), self.tau, self.error
        if self.leaf != self.omega_leaf:
            tau, error = forced(system, self.angles, self.analysis)
        mean = linear_part.carried(system.law, float(tau[0]))
        stiffness = float(system.law.stiffness(mean))
        w = orders(self.harmonics(), self.stride) * system.omega / self.turns
        bottom = stiffness - system.J * w * w + 1j * system.B * w
        least = 1e-9 * (abs(stiffness) + system.J * w * w)  # exactly at a resonance without damping there is none
        response = drive(system, w, tau, error) / np.where(np.abs(bottom) < least, least, bottom)
        return np.concatenate([[mean], response.real, -response.imag, [value]])

    def left_out(self, points: Floats, _: int) -> tuple[Floats, Floats]:
        """Parameter at some points of a curve, and the shares (values, 1) of u in the harmonics left out there."""
        few = points[few_of(points)]
        system = with_leaf(self.system, self.leaf, few[:, -1:])
        return few[:, -1], share_left_out(system, self.turns, few[:, :-1], self.stride)[:, None]

    def damping_leaf(self) -> int | None:
        return leaf_of(self.system, "B")

    def odd(self) -> "SecondOrder | None":
        if not (self.springs.is_sampled() and self._half_wave()):
            return None
        return second_order(self.system, self.leaf, self.omega_leaf, self.harmonics(), 1, 2)

    def biased(self) -> "SecondOrder | None":
        if not self._half_wave():
            return None
        tau = self.tau.copy()
        tau[0] = BIAS * float(linear_part.driven_lines(self)[2].max())
        return self._replace(tau=tau)

    def _half_wave(self) -> bool:
        return self.turns == 1 and seems_odd(self.system.law, self.tau, self.error)

    def floating(self, points: Floats) -> Booleans:
        """True for a point whose orbit moves without any torque of the law."""
        return linear_part.floating(self.system.law, points[:, :-1], self.synthesis)

    def around(self, omega: Floats) -> Around:
        """Linear part around the law at base frequencies [rad/s]."""
        system, k = self.system, orders(self.size() // 2, self.stride)
        w = omega[:, None] / self.turns * k
        driven = np.abs(drive(system, w, self.tau, self.error))
        return Around(system.law, float(self.tau[0]), system.J * w * w, system.B * w, driven, 2 * k // self.stride)

    def several_at(self, points: Floats) -> Booleans:
        return linear_part.several_at(self, points)

    def to_search(self, value: float) -> "SecondOrder":
        """The problem at a base frequency, with all harmonics and as many as the search for other orbits takes."""
        size = linear_part.driven_lines(self)[2]
        highest = 1 + self.stride * int(np.max(np.flatnonzero(size > ROUNDING * size.max()), initial=0))
        system, leaf = with_leaf(self.system, self.omega_leaf, value), self.omega_leaf
        return second_order(system, leaf, leaf, max(SEARCH_PER_TURN * self.turns, 3 * highest), self.turns)

    def strongest(self) -> float:
        return linear_part.strongest(self)

    def ways(self) -> list[int]:
        return linear_part.ways(self)

    def budget(self) -> tuple[int, float]:
        return BUDGET, STEP

    def patience(self) -> None:
        return None


@remembered
def _tables(h: int, samples: int, turns: int, stride: int) -> tuple[Floats, ...]:
    """Angles, synthesis, analysis, analysis padded, and that of twice the harmonics: equal problems share them."""
    angles = 2.0 * np.pi / stride * turns * np.arange(samples) / samples
    table = analysis(h, samples, stride)
    double = padded(analysis(2 * h, samples))
    return angles, synthesis(h, samples, stride), table, padded(table), double


def second_order(
    system: Any, leaf: int, omega_leaf: int, harmonics: int, turns: int = 1, stride: int = 1
) -> SecondOrder:
    """Build the balance problem of an oscillator for a number of harmonics of omega/turns.

    With stride 2 only the odd ones of them are unknowns: for a smooth odd law under odd orders (see `harmonics`).
    """
    piecewise = is_piecewise_linear(system.law)
    samples = (8 * harmonics + 8 if piecewise else 4 * harmonics + 4) // stride
    h = (harmonics + 1) // stride if stride > 1 else harmonics
    angles, waves, table, synthesis, double = _tables(h, samples, turns, stride)
    springs = springs_for((system.law,), h, samples, synthesis, double, stride)
    both = forced(system, angles, table)
    n = table.shape[1]
    work = Work(np.empty(samples), np.empty(n), np.empty(n), np.zeros(n))
    return SecondOrder(system, leaf, omega_leaf, turns, stride, waves, table, angles, *both, springs, work)
