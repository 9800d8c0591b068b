"""`Condensed`: the balance of a system that is linear around its laws, in the twists that these see.

D(k omega) P_k + T_k = F_k with the torques T of the laws, exact where they are linear between breakpoints, and the
dynamic stiffness D of all that is linear around them. Where a kinematic error follows the motor, its deviation is one
more block of unknowns. What repeats g times a turn has unknowns at every g-th harmonic alone.

The orbits that may exist beside those of a condensed problem, from what one harmonic allows.
"""

from typing import Any, NamedTuple

import numpy as np

from ....base.protocols import System, linear_part_of, omega_of
from ....base.results import Booleans, Floats
from ....compile.address import ByAddress
from ....compile.calls import at
from ....compile.jit import run
from ....compile.tree import with_leaf
from ...addressed import EquationsAt, equations_at
from ..first_order import FirstOrder
from ..fourier import analysis, from_blocks, gathered, orders, spread, synthesis, to_blocks
from ..harmonics import SEARCH_PER_TURN, highest_order
from ..linear_algebra import copy, extremes, fill, padded
from ..linear_part import STRENGTH, Around, clean_mean, floating, several_at, strongest
from ..piecewise import is_piecewise_linear
from ..springs import springs_for
from . import motions
from .disturbances import Disturbances, disturbances
from .gear import gear_of
from .pencil import Pencil, add_entries, add_stiffness, condense, to_complex, to_real

LIGHT = 130  # unknowns up to which NumPy follows some curves sooner than machine code (30 s) is made
BUDGET, STEP = 2500, 0.1  # points of a search for other orbits, and its steps in units of the orbit and the parameter


class Condensed(NamedTuple):
    """Balance in the coordinates that the laws see, block by block; `part` tells the system's matrices.

    An orbit takes `turns` turns; its unknowns are the harmonics `every`, 2 `every`, ... of omega/turns. `stiff`
    and `blocks` are buffers: dynamic stiffness with its derivative, and the coordinates with x in the place of u.
    """

    system: Any
    leaf: int
    omega_leaf: int
    turns: int
    every: int
    omega: float
    part: Any
    pencil: Pencil
    gear_damping: float
    springs: Any
    gear: Any
    synthesis: Floats
    analysis: Floats
    angles: Floats
    stiff: Any
    blocks: Floats

    def size(self) -> int:
        return int(self.blocks.shape[0] * self.blocks.shape[1])

    def harmonics(self) -> int:
        return int(self.blocks.shape[1] // 2)

    def harmonic(self, z: Floats, k: int) -> Any:
        """Cosine and sine coefficients, in the unknowns' k-th harmonic, of x but for the motor's deviation in e."""
        h = self.blocks.shape[1] // 2
        return z[k] + self.gear.error[k], z[h + k] + self.gear.error[h + k]

    def equations(self, z: Floats, r: Floats) -> None:
        """Write the residual [N*m] of every coefficient at z = (coefficients of the blocks, parameter)."""
        self = at(self)
        count, size = self.blocks.shape
        value, n = z[count * size], self.pencil.matrices.shape[1]
        omega = value if self.leaf == self.omega_leaf else self.omega
        factor = np.exp(value) if self.leaf == STRENGTH else 1.0
        tables = self.synthesis, self.analysis, self.angles
        condense(self.pencil, omega, factor, self.stiff[0], self.stiff[1])
        for i in range(1, count):
            copy(z[i * size : (i + 1) * size], self.blocks[i])
        self.gear.positions(tables, factor, z, self.blocks[0])
        fill(0.0, r)
        self.springs.torques(size, z, self.synthesis, r)
        w = self.pencil.rate * omega
        add_stiffness(self.stiff[0], self.gear_damping * w, self.blocks, z, r)
        loose = self.pencil.loose
        mean = r[loose * size] if 0 <= loose < count else 0.0
        self.gear.react(tables, self.stiff[0], self.blocks, r)
        if self.stiff[0, 0, 0, n] == 0.0:
            r[0] += self.pencil.matrices[0, 0, 0] * w * w * self.springs.slack()
        if 0 <= loose < count:
            r[loose * size] = mean

    def stiffness(self, z: Floats, jacobian: Floats) -> None:
        """Derivatives of the residual by the coefficients; follows `residual` at the same z."""
        self = at(self)
        count, size = self.blocks.shape
        w = self.pencil.rate * (z[count * size] if self.leaf == self.omega_leaf else self.omega)
        for i in range(count * size):
            fill(0.0, jacobian[i, : count * size])
        self.springs.stiffnesses(size, jacobian)
        inertia = self.pencil.matrices[0, 0, 0] * w * w
        if abs(jacobian[0, 0]) < 1e-9 * inertia:  # nothing holds the mean in the play of a gear
            low, high = extremes(self.springs.samples)
            for j in range(size):
                jacobian[0, j] = 0.5 * inertia * (self.synthesis[j, low] + self.synthesis[j, high])
        add_entries(self.stiff[0], self.gear_damping * w, size, count, jacobian)
        self.gear.linearise((self.synthesis, self.analysis, self.angles), self.stiff[0], self.blocks, jacobian)
        loose = self.pencil.loose
        if 0 <= loose < count:
            row = jacobian[loose * size, : count * size]
            fill(0.0, row)
            for j in range(count):
                row[j * size] = self.stiff[0, 0, loose, j].real
            self.gear.of_mean(self.stiff[0, 0, loose, 0].real, row[loose * size :])

    def by_parameter(self, z: Floats, slope: Floats) -> None:
        """Derivative of the residual by the parameter; follows `stiffness` at the same z."""
        self = at(self)
        count, size = self.blocks.shape
        fill(0.0, slope)
        loose = self.pencil.loose
        mean, of_motor = 0.0, 0 <= loose < count
        if self.leaf == self.omega_leaf:
            add_stiffness(self.stiff[1], self.gear_damping * self.pencil.rate, self.blocks, z, slope)
            mean = slope[loose * size] if of_motor else 0.0
            self.gear.by_speed(self.stiff[1], self.blocks, slope)
        else:
            tables, factor = (self.synthesis, self.analysis, self.angles), np.exp(z[count * size])
            self.gear.by_strength(tables, self.stiff[0], factor, self.blocks, slope)
            mean = self.stiff[0, 0, loose, 0].real * self.blocks[0, 0] if of_motor else 0.0
        if of_motor:
            slope[loose * size] = mean

    def residual(self, z: Floats, r: Floats) -> None:
        """Residual [N*m] of every coefficient."""
        self.equations(z, r)

    def linearise(self, z: Floats, jacobian: Floats, slope: Floats) -> None:
        """Derivatives of the residual by the coefficients and by the parameter; follows `residual` at the same z."""
        self.stiffness(z, jacobian)
        self.by_parameter(z, slope)

    def run(self, kernel: Any, *arguments: Any) -> Any:
        return run(kernel, ByAddress(self, self.addressed, "equations"), *arguments, light=self.size() <= LIGHT)

    def addressed(self, words: Any) -> EquationsAt:
        """The equations for machine code."""
        native = self._replace(system=(), part=(), springs=self.springs.addressed(words))
        return equations_at(native, words, None, Condensed.by_parameter, self.gear.error)

    def hill(self) -> bool:
        return False

    def state_count(self) -> int:
        return len(self.part.values)

    def highest(self) -> int:
        return self.every * self.harmonics()

    def series(self, points: Floats) -> Floats:
        """Coefficients (points, blocks, 2h+1) of the unknowns, at every `every`-th harmonic."""
        return np.asarray(points[:, :-1].reshape(len(points), *self.blocks.shape))

    def states(self, points: Floats) -> Floats:
        """Coefficients (points, states, 2h+1) of all states, in blocks, at every `every`-th harmonic."""
        return motions.states(self, points)

    def displacements(self, points: Floats) -> Floats:
        """Coefficients (points, 2H+1) of the first state in blocks."""
        p, _ = motions.coordinates(self, points)
        return spread(to_real(p @ self.part.values[0]), self.every)

    def table(self, point: Floats) -> Floats:
        return from_blocks(spread(self.series(point[None])[0], self.every).T)

    def state_table(self, table: Floats) -> Floats:
        """Table of the states at the system's own base frequency."""
        point = self.fitted(table, self.omega)
        return from_blocks(spread(self.states(point[None])[0], self.every).T)

    def motion(self, point: Floats, x: Floats) -> Floats:
        """Table (2H+1, states) of a point."""
        return from_blocks(spread(self.states(point[None])[0], self.every).T)

    def point(self, table: Floats, value: float) -> Floats:
        """Point of a table (2H+1, states), cut or filled up."""
        states = gathered(to_blocks(table).T, self.every, self.harmonics())
        p = np.linalg.pinv(self.part.values) @ states
        blocks = p[: len(self.blocks)].copy()
        blocks[0] -= motions.errors(self, blocks[None])[0]
        return np.append(blocks.ravel(), value)

    def fitted(self, table: Floats, value: float) -> Floats:
        """Point of a table of the blocks, cut or filled up."""
        return np.append(gathered(to_blocks(table).T, self.every, self.harmonics()).ravel(), value)

    def sampled(self, y: Floats, value: float) -> Floats:
        """Point of a motion with the states y (states, samples) at the problem's angles."""
        return self.point(from_blocks(spread(y @ self.analysis, self.every).T), value)

    def linear_response(self, value: float) -> Floats:
        """Guess (coefficients, parameter): the response of the laws' tangents where they carry the mean torques."""
        return motions.linear_response(self, value)

    def left_out(self, points: Floats, _: int) -> tuple[Floats, Floats]:
        """Parameter at some points of a curve, and the shares (values, 1 + blocks) left out there, of x and blocks."""
        return motions.left_out(self, points)

    def disturbed(self, points: Floats) -> tuple[FirstOrder, Floats, int]:
        """Orbits in all states over one of the parts in which they repeat; and how many of them there are."""
        return motions.disturbed(self, points)

    def disturbances(self, points: Floats) -> Disturbances | None:
        """Disturbances of orbits over one of the parts in which they repeat; None where these are not known."""
        return disturbances(self, points)

    def damping_leaf(self) -> None:
        return None

    def odd(self) -> None:
        return None

    def biased(self) -> None:
        return None

    def floating(self, points: Floats) -> Booleans:
        """True for a point whose orbit moves without any torque of the gear's law."""
        return floating(self.part.laws[0], self.series(points)[:, 0], self.synthesis)

    def around(self, omega: Floats) -> Around | None:
        """Linear part around the gear at base frequencies [rad/s]; None where there are more laws."""
        law, *more = self.part.laws
        if more:
            return None
        n, k = len(self.part.inertia), orders(self.harmonics())
        s = np.empty((len(omega), *self.stiff[0].shape), complex)
        with np.errstate(all="ignore"):
            condense(self.pencil._replace(kept=1), omega, 1.0, s, None)
        damping = s[:, 1:, 0, 0].imag + self.gear_damping * self.pencil.rate * omega[:, None] * k
        driven = np.abs(s[:, 1:, 0, n] - s[:, 1:, 0, 0] * to_complex(self.gear.error)[1:])
        return Around(law, float(np.mean(s[:, 0, 0, n].real)), -s[:, 1:, 0, 0].real, damping, driven, 2 * k)

    def several_at(self, points: Floats) -> Booleans:
        return several_at(self, points)

    def to_search(self, value: float) -> "Condensed":
        """The problem at a base frequency, with as many harmonics as the search for other orbits takes."""
        system = with_leaf(self.system, self.omega_leaf, value)
        wanted = max(SEARCH_PER_TURN, 3 * highest_order(system)) * self.turns // self.every
        changed = self._replace(system=system, leaf=self.omega_leaf)
        return changed.with_harmonics(min(self.harmonics(), wanted))

    def with_harmonics(self, h: int) -> "Condensed":
        """The same problem with h of its harmonics."""
        return assembled(self.system, self.part, self.gear.lines, self.leaf, self.omega_leaf, h, self.turns, self.every)

    def of(self, system: System) -> "Condensed":
        """The problem of another system of the same classes, with the same excitation."""
        return self._replace(system=system, part=linear_part_of(system)).with_harmonics(self.harmonics())

    def strongest(self) -> float:
        return strongest(self)

    def ways(self) -> list[int]:
        return [self.omega_leaf, STRENGTH]

    def budget(self) -> tuple[int, float]:
        return BUDGET, STEP

    def patience(self) -> None:
        return None


def assembled(
    system: System, part: Any, lines: Any, leaf: int, omega_leaf: int, h: int, turns: int, step: int
) -> Condensed:  # fmt: skip
    """The problem with h of the harmonics `step`, 2 `step`, ...; `lines` are those of the error."""
    samples = 8 * h + 8 if any(map(is_piecewise_linear, part.laws)) else 4 * h + 4
    angles = 2.0 * np.pi * turns / step * np.arange(samples) / samples
    table, back, double = synthesis(h, samples), analysis(h, samples), analysis(2 * h, samples)
    forces = part.forces(angles) @ back
    for row in forces:
        clean_mean(row)
    count, n = len(part.laws) + part.follows, len(part.inertia)
    omega, size = float(omega_of(system)), part.inertia[part.loose, part.loose]  # of the mean: as of a vibration
    pencil = Pencil(
        np.array([part.inertia, part.damping, part.stiffness]), to_complex(forces), part.per_speed, count, part.loose,
        size * (step / turns * omega) ** 2 * part.zero_mean,
        int(np.sum(~np.any(part.inertia, axis=1))) if part.loose >= 0 else 0, step / turns,
    )  # fmt: skip
    error = (part.error.value(angles) + 0.0 * angles) @ back
    gear = gear_of(part.follows, lines, error, angles, double, count)
    buffers = np.empty((2, h + 1, n, n + 1), complex), np.empty((count, 2 * h + 1))
    springs = springs_for(part.laws, h, samples, padded(back), padded(double))
    return Condensed(
        system, leaf, omega_leaf, turns, step, omega, part, pencil, part.gear_damping, springs, gear,
        table, back, angles, *buffers,
    )  # fmt: skip
