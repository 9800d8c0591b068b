"""`Condensed`: the balance of a system that is linear around its laws, in the twists that these see.

D(k omega) P_k + T_k = F_k with the torques T of the laws, exact where they are linear between breakpoints, and the
dynamic stiffness D of all that is linear around them. Where a kinematic error follows the motor, its deviation is one
more block of unknowns. What repeats g times a turn has unknowns at every g-th harmonic alone.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ....compile.jit import run
from ....results import Floats
from ....tree import leaf_of, with_leaf
from ..first_order import FirstOrder
from ..fourier import analysis, from_blocks, synthesis, to_blocks
from ..linear_algebra import copy, fill
from ..linear_part import QUIET, STRENGTH
from ..one_harmonic import STRONG, carried
from ..panels import distances
from ..rates import base_speed
from ..truncation import few_of, share_of
from .others import several_at
from .pencil import Pencil, add_entries, add_stiffness, condense, eliminated, to_complex, to_real

LIGHT = 33  # unknowns up to which NumPy follows a curve in a fraction of a second
BUDGET, STEP = 600, 0.2  # points of a search for other orbits, and its steps in units of the orbit and the parameter


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
        return self.blocks.shape[0] * self.blocks.shape[1]

    def harmonics(self) -> int:
        return self.blocks.shape[1] // 2

    def harmonic(self, z: Any, k: int) -> Any:
        """Cosine and sine coefficients, in the unknowns' k-th harmonic, of x but for the motor's deviation in e."""
        h = self.blocks.shape[1] // 2
        return z[k] + self.gear.error[k], z[h + k] + self.gear.error[h + k]

    def speed(self, z: Any) -> float:
        """Base speed [rad/s] at z."""
        return float(z[self.size()] if self.leaf == self.omega_leaf else self.omega)

    def factor(self, z: Any) -> float:
        """Factor of all that alternates in forces and error."""
        return float(np.exp(z[self.size()]) if self.leaf == STRENGTH else 1.0)

    def residual(self, z: Any, work: Any, r: Any) -> None:
        """Residual [N*m] of every coefficient at z = (coefficients of the blocks, parameter)."""
        count, size = self.blocks.shape
        n, omega, factor = self.pencil.matrices.shape[1], self.speed(z), self.factor(z)
        condense(self.pencil, omega, factor, self.stiff[0], self.stiff[1])
        for i in range(1, count):
            copy(z[i * size : (i + 1) * size], self.blocks[i])
        self.gear.positions(self, factor, z, self.blocks[0])
        fill(0.0, r)
        self.springs.torques(size, z, self.synthesis, r)
        w = self.pencil.rate * omega
        add_stiffness(self.stiff[0], self.gear_damping * w, self.blocks, z, r)
        self.gear.react(self, self.blocks, r)
        if self.stiff[0, 0, 0, n] == 0.0:
            r[0] += self.pencil.matrices[0, 0, 0] * w * w * self.springs.slack()
        loose = self.pencil.loose
        if 0 <= loose < count:
            r[loose * size] = self.pencil.matrices[0, loose, loose] * w * w * z[loose * size]

    def linearise(self, z: Any, work: Any, jacobian: Any, slope: Any) -> None:
        """Derivatives of the residual by the coefficients and by the parameter; follows `residual` at the same z."""
        count, size = self.blocks.shape
        w = self.pencil.rate * self.speed(z)
        for i in range(count * size):
            fill(0.0, jacobian[i, : count * size])
        self.springs.stiffnesses(size, jacobian)
        inertia = self.pencil.matrices[0, 0, 0] * w * w
        if abs(jacobian[0, 0]) < 1e-9 * inertia:  # nothing holds the mean in the play of a gear
            low, high = self.springs.ends()
            for j in range(size):
                jacobian[0, j] = 0.5 * inertia * (self.synthesis[j, low] + self.synthesis[j, high])
        add_entries(self.stiff[0], self.gear_damping * w, size, count, jacobian)
        fill(0.0, slope)
        self.gear.linearise(self, self.blocks, jacobian)
        if self.leaf == self.omega_leaf:
            add_stiffness(self.stiff[1], self.gear_damping * self.pencil.rate, self.blocks, z, slope)
            self.gear.by_speed(self, self.blocks, slope)
        else:
            self.gear.by_strength(self, self.factor(z), self.blocks, slope)
        loose = self.pencil.loose
        if 0 <= loose < count:
            fill(0.0, jacobian[loose * size, : count * size])
            jacobian[loose * size, loose * size] = self.pencil.matrices[0, loose, loose] * w * w
            slope[loose * size] = 0.0

    def run(self, kernel: Any, *arguments: Any) -> Any:
        bare = self._replace(system=QUIET, part=QUIET)
        return run(kernel, bare, *arguments, light=self.size() <= LIGHT)

    def hill(self) -> bool:
        return False

    def state_count(self) -> int:
        return len(self.part.values)

    def highest(self) -> int:
        return self.every * self.harmonics()

    def series(self, points: Floats) -> Floats:
        """Coefficients (points, blocks, 2h+1) of the unknowns, at every `every`-th harmonic."""
        return np.asarray(points[:, :-1].reshape(len(points), *self.blocks.shape))

    def errors(self, series: Floats) -> Floats:
        """Coefficients (points, 2h+1) of the kinematic error, from those of the blocks."""
        if not self.part.follows:
            return np.broadcast_to(self.gear.error, series[:, 0].shape)
        angles = self.angles + series[:, -1] @ self.synthesis
        return np.asarray((self.part.error.value(angles) + 0.0 * angles) @ self.analysis)

    def coordinates(self, points: Floats) -> Any:
        """All coordinates (points, h+1, n), complex, the first of them x."""
        blocks = self.series(points).copy()
        blocks[:, 0] += self.errors(blocks)
        s = np.empty((len(points), *self.stiff[0].shape), complex)
        condense(self.pencil, base_speed(self, points[:, -1]), 1.0, s, np.empty_like(s))
        return eliminated(self.pencil, s, np.moveaxis(to_complex(blocks), 1, 2))

    def states(self, points: Floats) -> Floats:
        """Coefficients (points, states, 2h+1) of all states, in blocks, at every `every`-th harmonic."""
        p, part = self.coordinates(points), self.part
        w = self.pencil.rate * base_speed(self, points[:, -1])[:, None] * np.arange(p.shape[1])
        waves = p @ part.values.T + 1j * w[..., None] * (p @ part.rates.T)
        return to_real(np.moveaxis(waves, 2, 1))

    def displacements(self, points: Floats) -> Floats:
        """Coefficients (points, 2H+1) of the first state in blocks."""
        p = self.coordinates(points)
        return spread(to_real(p @ self.part.values[0]), self.every)

    def table(self, point: Floats) -> Floats:
        return from_blocks(spread(self.series(point[None])[0], self.every).T)

    def whole(self, table: Floats) -> Floats:
        """Table of the states at the system's own base frequency."""
        point = self.fitted(table, self.omega)
        return from_blocks(spread(self.states(point[None])[0], self.every).T)

    def motion(self, point: Floats, x: Floats) -> Floats:
        """Table (2H+1, states) of a point."""
        return from_blocks(spread(self.states(point[None])[0], self.every).T)

    def point(self, table: Floats, value: float) -> Floats:
        """Point of a table (2H+1, states), cut or filled up."""
        own = gathered(to_blocks(table).T, self.every, self.harmonics())
        p = np.linalg.pinv(self.part.values) @ own
        blocks = p[: len(self.blocks)].copy()
        blocks[0] -= self.errors(blocks[None])[0]
        return np.append(blocks.ravel(), value)

    def fitted(self, table: Floats, value: float) -> Floats:
        """Point of a table of the blocks, cut or filled up."""
        return np.append(gathered(to_blocks(table).T, self.every, self.harmonics()).ravel(), value)

    def sampled(self, y: Floats, value: float) -> Floats:
        """Point of a motion with the states y (states, samples) at the problem's angles."""
        return self.point(from_blocks(spread(y @ self.analysis, self.every).T), value)

    def linear_response(self, value: float) -> Floats:
        """Guess (coefficients, parameter): the response of the laws' tangents where they carry the mean torques."""
        count, size = self.blocks.shape
        omega = float(base_speed(self, np.asarray(value)))
        s = np.empty(self.stiff[0].shape, complex)
        condense(self.pencil, omega, 1.0, s, np.empty_like(s))
        n, laws = self.pencil.matrices.shape[1], self.part.laws
        means = [carried(law, float(s[0, i, n].real)) for i, law in enumerate(laws)]
        matrix = s[:, :count, :count].copy()
        force = s[:, :count, n] - matrix[:, :, 0] * to_complex(self.gear.error)[:, None]
        for i, law in enumerate(laws):
            matrix[:, i, i] += float(law.stiffness(means[i]))
        matrix[:, 0, 0] += 1j * self.gear_damping * self.pencil.rate * omega * np.arange(size // 2 + 1)
        p = np.zeros((size // 2 + 1, count), complex)
        for k in range(1, len(p)):
            p[k] = np.linalg.lstsq(matrix[k], force[k], rcond=1e-14)[0]
        p[0, : len(laws)] = means
        if count > len(laws) and self.pencil.loose < 0:
            rest = s[0, -1 + count, n] - s[0, count - 1, : len(laws)] @ p[0, : len(laws)]
            p[0, -1] = rest / s[0, count - 1, count - 1]
        return np.append(to_real(p.T).ravel(), value)

    def left_out(self, points: Floats, _: int) -> tuple[Floats, Floats]:
        """Parameter at some points of a curve, and the shares (values, 1 + blocks) left out there, of x and blocks."""
        few = points[few_of(points)]
        blocks, h = self.series(few), self.harmonics()
        most, count = 3 * h + 8, len(self.blocks)
        samples = 3 * most
        n, k = self.pencil.matrices.shape[1], np.arange(h + 1, most + 1)
        s = np.empty((len(few), most + 1, n, n + 1), complex)
        omega = base_speed(self, few[:, -1])
        quiet = self.pencil._replace(forces=np.zeros((n, most + 1), complex), per_speed=np.zeros(n))
        with np.errstate(all="ignore"):
            condense(quiet, omega, 1.0, s, np.empty_like(s))
            matrix, force = s[:, :, :count, :count].copy(), np.zeros((len(few), most + 1, count), complex)
            for i, law in enumerate(self.part.laws):
                u = blocks[:, i] @ synthesis(h, samples)
                force[..., i] = -to_complex((law.torque(u) + 0.0 * u) @ analysis(most, samples))
                matrix[..., i, i] += np.mean(law.stiffness(u) + 0.0 * u, axis=1)[:, None]
            matrix[..., 0, 0] += 1j * self.gear_damping * self.pencil.rate * omega[:, None] * np.arange(most + 1)
            p = np.zeros_like(force)
            p[:, k] = np.linalg.solve(matrix[:, k], force[:, k, :, None])[..., 0]
            x = eliminated(quiet, s, p) @ self.part.values[0]
        known = np.linalg.norm(blocks, axis=2)
        known = np.maximum(known, 1e-6 * np.max(known, axis=0))
        own = np.linalg.norm(self.displacements(few), axis=1)
        return few[:, -1], np.column_stack(
            [share_of(np.linalg.norm(x, axis=1), own), share_of(np.linalg.norm(p, axis=1), known)]
        )

    def disturbed(self, points: Floats) -> tuple[FirstOrder, Floats, int]:
        """Orbits in all states over one of the parts in which they repeat; and how many of them there are."""
        system, h = self.part.disturbed, self.harmonics()
        series, samples = self.states(points), len(self.angles)
        sizes = np.max(np.linalg.norm(series, axis=2), axis=0, initial=0.0)
        sizes = np.where(sizes > 0.0, sizes, 1.0)
        kinked = len(distances(system, np.zeros(1), np.zeros((len(sizes), 1)))) > 0
        leaf = leaf_of(system, "omega")
        problem = FirstOrder(
            system, leaf, leaf, self.turns / self.every, sizes, self.synthesis, self.analysis,
            analysis(2 * h, samples), self.angles, kinked,
        )  # fmt: skip
        omega = base_speed(self, points[:, -1])
        return problem, np.column_stack([(series / sizes[:, None]).reshape(len(points), -1), omega]), self.every

    def damping_leaf(self) -> None:
        return None

    def odd(self) -> None:
        return None

    def biased(self) -> None:
        return None

    def floating(self, points: Floats) -> NDArray[np.bool_]:
        """Whether the gear's law gives no torque anywhere on an orbit that moves, for every point."""
        law = self.part.laws[0]
        if law.torque(0.0) != 0.0 or law.stiffness(0.0) != 0.0:
            return np.zeros(len(points), bool)
        u = self.series(points)[:, 0] @ self.synthesis
        idle: NDArray[np.bool_] = np.all(law.torque(u) + np.zeros_like(u) == 0.0, axis=1) & (np.ptp(u, axis=1) > 0.0)
        return idle

    def several_at(self, points: Floats) -> NDArray[np.bool_]:
        return several_at(self, points)

    def to_search(self, value: float) -> "Condensed":
        """The problem at a base frequency; with all its harmonics, which are few."""
        return self._replace(system=with_leaf(self.system, self.omega_leaf, value), omega=value)

    def strongest(self) -> float:
        return STRONG

    def ways(self) -> list[int]:
        return [self.omega_leaf, STRENGTH]

    def budget(self) -> tuple[int, float]:
        return BUDGET, STEP


def spread(series: Floats, every: int) -> Floats:
    """Series (..., 2h+1) in blocks with harmonics `every`, 2 `every`, ..., as one with all (..., 2 every h + 1)."""
    if every == 1:
        return series
    h = series.shape[-1] // 2
    out = np.zeros((*series.shape[:-1], 2 * every * h + 1))
    out[..., 0] = series[..., 0]
    out[..., every : every * h + 1 : every] = series[..., 1 : h + 1]
    out[..., every * h + every :: every] = series[..., h + 1 :]
    return out


def gathered(series: Floats, every: int, h: int) -> Floats:
    """The first h of the harmonics `every`, 2 `every`, ... of series (..., 2H+1) in blocks, cut or filled up."""
    top = series.shape[-1] // 2
    out, n = np.zeros((*series.shape[:-1], 2 * h + 1)), min(h, top // every)
    out[..., 0] = series[..., 0]
    out[..., 1 : n + 1] = series[..., every : every * n + 1 : every]
    out[..., h + 1 : h + n + 1] = series[..., top + every : top + every * n + 1 : every]
    return out


