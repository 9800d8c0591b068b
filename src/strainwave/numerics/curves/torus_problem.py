"""`Torus`: the balance of a system that is linear around its laws, in waves of two turns.

The motor turns by psi_1 = omega t, the output by psi_2 = psi_1/N. A motion is a sum of waves of pairs (j, k), with the
angle j psi_1 + k psi_2 and the frequency (j + k/N) omega: D(j omega + k omega/N) P_jk + T_jk = F_jk, with the dynamic
stiffness D of all that is linear. The torques T are sampled on a grid of two angles: of the gear, of the couplings,
what a kinematic error gives back to the motor, and what follows the load's own angle psi_2 + a P, as gravity does.
All pairs are whole combinations of two, the `basis`; the grid is one of the angles of these, so that motions that
repeat twice in both turns take a quarter of the samples.

Krack & Gross 2019, Harmonic Balance for Nonlinear Vibration Problems, secs. 2.4 (AFT), 4.1 (condensation) and 5.3
(several base frequencies).
"""

import math
from typing import Any, NamedTuple

import numpy as np

from ...base.protocols import lacking
from ...base.results import Floats
from ..balance.condensed.pencil import add_entries, to_complex, to_real

SMOOTH = np.sort([2**a * 3**b * 5**c for a in range(14) for b in range(9) for c in range(6)])  # fast transforms
OVERSAMPLED = 4  # samples of an angle in a period of its highest wave: a cube of these waves is exact
CORNERED, SAMPLES = 16, 8192  # the same at most beside rounded corners, and samples wanted: fewer make false folds
LARGEST_TABLE = 120_000  # entries of a table that is quicker than a fast transform


class LinearWaves(NamedTuple):
    """Dynamic stiffness and forces of waves on retained coordinates.

    `matrices` (3, P, n, n + 1) are those of the powers of the speed, the forces in the last column. In `ordered` the
    retained coordinates are first, the forces behind their columns, and those that are `gone` last; of these, what has
    no mean is 0 there.
    """

    matrices: Any
    retained: Any
    gone: Any
    ordered: Any

    def stiffness(self, omega: Any) -> tuple[Any, Any, Any]:
        """Both (..., P, c, c + 1) at speeds [rad/s], their derivatives by it, and what eliminates the others."""
        (still, damped, heavy), w = self.ordered, np.asarray(omega)[..., None, None, None]
        a, da, c = still + w * (damped - w * heavy), damped - (2.0 * w) * heavy, len(self.retained)
        stiff, by_speed, answer = a[..., :c, : c + 1], da[..., :c, : c + 1], a[..., c:, : c + 1]
        if len(self.gone):
            inverse, back = np.linalg.inv(a[..., c:, c + 1 :]), a[..., :c, c + 1 :]
            answer = inverse @ answer
            change = da[..., c:, : c + 1] - da[..., c:, c + 1 :] @ answer
            stiff, by_speed = stiff - back @ answer, by_speed - da[..., :c, c + 1 :] @ answer - back @ inverse @ change
        return stiff, by_speed, answer


def linear_waves(part: Any, retained: Any, orders: Floats, forces: Any) -> LinearWaves:
    """The waves of some orders (P,) of a part, driven by forces (P, n), the mean first where it is among them.

    A coordinate `loose` has no mean, nor have the states of its control behind it.
    """
    n, each = len(part.inertia), orders[:, None, None]
    matrices, damping = np.zeros((3, len(orders), n, n + 1), complex), part.damping.copy()
    damping[0, 0] += part.gear_damping
    matrices[..., :n] = part.stiffness + 0.0 * each, 1j * each * damping, each * each * part.inertia
    matrices[0, ..., n] = forces
    at_rest = orders == 0.0
    if at_rest[0]:
        matrices[1, 0, :, n] = part.per_speed
    gone, solved = np.setdiff1d(np.arange(n), retained), matrices.copy()
    massless = int(np.sum(~np.any(part.inertia, axis=1)))
    if part.loose >= 0:
        still = np.ix_(np.flatnonzero(at_rest), np.intersect1d(gone, part.loose + np.arange(massless + 1)))
        solved[:, still[0], still[1]] = 0.0
        solved[0, still[0], still[1], still[1]] = 1.0
    rows, columns = np.concatenate([retained, gone]), np.concatenate([retained, [n], gone])
    return LinearWaves(matrices, retained, gone, np.ascontiguousarray(solved[:, :, rows][..., columns]))


class Motion(NamedTuple):
    """Torques of a motion (coordinates, samples), and their derivatives by it, its rates and the speed."""

    torque: Floats
    by_place: dict[tuple[int, int], Any]
    by_rate: dict[tuple[int, int], Any]
    by_speed: Floats


class Torus(NamedTuple):
    """Balance in the waves `pairs` (P + 1, 2), (0, 0) first, of the coordinates `linear.retained`, block by block.

    A block has the mean, the cosines and the sines of x or another coordinate; a point ends with the speed omega.

    Attributes
    ----------
    part, ratio : LinearPart, float
        Linear part around its laws, and turns of the motor in one of the output.
    pulls : tuple of laws
        Torques against the load of its own angle.
    pairs, orders : (P + 1, 2) and (P + 1,) arrays
        Waves, and their frequencies over the speed.
    basis, cells : (2, 2) and (P + 1, 2) arrays
        Pairs ((j, k), (0, q)) whose angles make the grid, and how often each wave has them.
    linear : LinearWaves
        Dynamic stiffness and forces.
    lines, line_pairs, turned : (lines, 3), (lines, 2) and (lines, samples) arrays
        Order, cosine and sine [rad] of the kinematic error's lines, their pairs, and their angles [rad].
    slow, shape : (samples,) array and tuple of int
        Angle of the output [rad], and samples of each angle of the grid.
    synthesis : (2 P + 1, samples) array
        From coefficients to samples; empty where fast transforms are quicker.
    plus, minus : (P + 1, P + 1) arrays
        Places of sums and differences of pairs in a spectrum.
    still_error : tuple
        Kinematic error with its derivatives at the samples of a motor that does not deviate.
    loose : int
        Place of a mean that nothing holds among the unknowns, or -1.
    memory : dict
        The latest point with what it does.
    angles, crossing : array and tuple
        Angles and tables of a problem of `at_crossings`, in place of those of a grid.
    """

    part: Any
    ratio: float
    pulls: tuple[Any, ...]
    pairs: Any
    orders: Floats
    basis: Any
    cells: Any
    linear: LinearWaves
    lines: Floats
    line_pairs: Floats
    turned: Floats
    slow: Floats
    shape: tuple[int, ...]
    synthesis: Floats
    plus: Any
    minus: Any
    still_error: Any
    loose: int
    memory: dict[str, Any]
    angles: Any = None
    crossing: tuple[Any, ...] = ()

    def size(self) -> int:
        """Number of coefficients."""
        return len(self.linear.retained) * (2 * len(self.pairs) - 1)

    def harmonics(self) -> int:
        """Number of waves beside the mean."""
        return len(self.pairs) - 1

    def harmonic(self, z: Floats, k: int) -> Any:
        """Cosine and sine coefficient of the k-th wave of x."""
        return z[k], z[len(self.pairs) - 1 + k]

    def blocks(self, z: Floats) -> Floats:
        """Coefficients (coordinates, ..., 2 P + 1) of points (..., coefficients and speed)."""
        blocks = z[..., :-1].reshape(*z.shape[:-1], len(self.linear.retained), -1)
        return blocks if z.ndim == 1 else np.moveaxis(blocks, -2, 0)

    def run(self, kernel: Any, *arguments: Any) -> Any:
        """Execute a kernel with the problem: as Python, where each step is a few calls of LAPACK."""
        return kernel(self, *arguments)

    def sampled(self, blocks: Floats) -> Floats:
        """Samples (..., n) of coefficients (..., 2 P + 1)."""
        if self.crossing:
            ways, along, groups = self.crossing
            waves = to_complex(blocks)
            sums = np.stack([waves[..., some] @ along[some] for some in groups], axis=-2)
            grid = ways @ np.concatenate([sums.real, sums.imag], axis=-2)
            return np.asarray(grid.reshape(*blocks.shape[:-1], -1))
        if self.synthesis.size:
            return blocks @ self.synthesis
        spectrum = np.zeros((*blocks.shape[:-1], len(self.slow)), complex)
        spectrum[..., self.plus[0]] = to_complex(blocks)
        grid = np.fft.ifft2(spectrum.reshape(*blocks.shape[:-1], *self.shape), norm="forward")
        return np.asarray(grid.real.reshape(spectrum.shape))

    def analysed(self, samples: Floats) -> Floats:
        """Coefficients (..., 2 P + 1) of samples (..., n) on the grid."""
        if self.synthesis.size:
            coefficients = samples @ self.synthesis.T * (2.0 / samples.shape[-1])
            coefficients[..., 0] *= 0.5
            return np.asarray(coefficients)
        return to_real(waves_of(samples, self.shape, self.plus[0]))

    def turning(self, blocks: Floats) -> Floats:
        """Derivatives of coefficients (..., 2 P + 1) by the motor's angle."""
        h, orders = len(self.pairs), self.orders[1:]
        return np.concatenate(
            [0.0 * blocks[..., :1], orders * blocks[..., h:], -orders * blocks[..., 1:h]], axis=-1
        )  # fmt: skip

    def error(self, deviation: Any) -> tuple[Any, Any, Any]:
        """Kinematic error, its first and second derivative, at the samples and a deviation (..., samples)."""
        order, even, odd = self.lines.T.reshape(3, -1, *(1,) * max(1, np.ndim(deviation)))
        turned = self.turned.reshape(len(self.lines), *(1,) * (np.ndim(deviation) - 1), self.turned.shape[1])
        a = turned + order * deviation
        c, s = np.cos(a), np.sin(a)
        wave, turned = even * c + odd * s, odd * c - even * s
        return wave.sum(axis=0), (order * turned).sum(axis=0), -(order * order * wave).sum(axis=0)

    def moved(self, z: Floats) -> Motion:
        """Torques at points (..., coefficients and speed), without what damping makes of the rate of x alone.

        The first coordinate is x; m, the one after those of the laws, is the motor's where the error follows it.
        """
        blocks, w, part, m = self.blocks(z), z[..., -1:], self.part, len(self.part.laws)
        q, B = self.sampled(blocks), part.gear_damping
        torque, by_speed, by_rate = np.zeros_like(q), np.zeros_like(q), {}
        e, slope, bend = self.error(q[m]) if part.follows else self.still_error
        u = q[0] - e
        stiff = part.laws[0].stiffness(u) + 0.0 * u
        torque[0], by_place = part.laws[0].torque(u), {(0, 0): stiff}
        if part.follows:
            rate, turning = self.sampled(self.turning(blocks[[0, m]]))
            turning += 1.0
            gear, pull = torque[0] + B * w * (rate - slope * turning), stiff * slope + B * w * bend * turning
            by_speed[0], by_speed[m] = -B * slope * turning, -B * slope * (rate - slope * turning)
            torque[m] = -slope * gear
            by_place |= {(0, m): -pull, (m, 0): -slope * stiff, (m, m): slope * pull - bend * gear}
            by_rate = {(0, m): (given := -B * w * slope), (m, 0): given, (m, m): -given * slope}
        else:
            by_speed[0] = -B * slope
        torque[0] += w * by_speed[0]
        for i, law in enumerate(part.laws[1:], 1):
            torque[i], by_place[i, i] = law.torque(q[i]), law.stiffness(q[i]) + 0.0 * u
        if self.pulls:
            self.pull(q, torque, by_place)
        return Motion(torque, by_place, by_rate, by_speed)

    def pull(self, q: Floats, torque: Floats, by_place: dict[tuple[int, int], Any]) -> None:
        """Add the torques that follow the load's own angle at samples q (coordinates, ..., n), and derivatives."""
        a = self.part.load[self.linear.retained]
        angle, coordinates = self.slow + np.tensordot(a, q, 1), np.flatnonzero(a).tolist()
        pull = sum(law.torque(angle) for law in self.pulls)
        stiff = sum(law.stiffness(angle) for law in self.pulls)
        for i in coordinates:
            torque[i] += a[i] * pull
            for j in coordinates:
                by_place[i, j] = by_place.get((i, j), 0.0) + a[i] * a[j] * stiff

    def latest(self, z: Floats) -> tuple[Motion, Any, Any]:
        """Torques of a point, the dynamic stiffness and its derivative: once for each point."""
        if self.memory.get("point") is None or not np.array_equal(self.memory["point"], z):
            stiff = self.linear.stiffness(float(z[-1]))[:2]
            self.memory.update(point=z.copy(), found=(self.moved(z), *stiff))
        values: tuple[Motion, Any, Any] = self.memory["found"]
        return values

    def residual(self, z: Floats, r: Floats) -> None:
        """Write what the equations lack [N*m] at z."""
        motion, stiff, _ = self.latest(z)
        r[:] = (self.analysed(motion.torque) + unbalanced(stiff, self.blocks(z))).ravel()
        if self.loose >= 0:
            r[self.loose] = self.inertia(z) * z[self.loose]

    def linearise(self, z: Floats, jacobian: Floats, slope: Floats) -> None:
        """Write the derivatives by the coefficients and by the speed."""
        (motion, stiff, by_speed), blocks = self.latest(z), self.blocks(z)
        a, size, h = jacobian[: self.size(), : self.size()], blocks.shape[1], len(self.orders) - 1
        a[:] = 0.0
        every = {id(samples): samples for samples in (*motion.by_place.values(), *motion.by_rate.values())}
        products, w = dict(zip(every, self.products(np.array(list(every.values()))), strict=True)), self.orders[1:]
        for (i, j), samples in motion.by_place.items():
            a[i * size : (i + 1) * size, j * size : (j + 1) * size] = products[id(samples)]
        for (i, j), samples in motion.by_rate.items():
            block, out = products[id(samples)], a[i * size : (i + 1) * size, j * size : (j + 1) * size]
            out[:, 1 : h + 1] -= w * block[:, h + 1 :]
            out[:, h + 1 :] += w * block[:, 1 : h + 1]
        add_entries(stiff, 0.0, size, len(blocks), a)
        slope[:] = (self.analysed(motion.by_speed) + unbalanced(by_speed, blocks)).ravel()
        if self.loose >= 0:
            a[self.loose], slope[self.loose] = 0.0, 0.0
            a[self.loose, self.loose] = self.inertia(z)

    def inertia(self, z: Floats) -> float:
        """Inertia of that coordinate times the square of the speed [N*m/rad]."""
        return float(self.part.inertia[self.part.loose, self.part.loose] * z[-1] ** 2)

    def products(self, samples: Floats) -> Floats:
        """Matrices (m, 2 P + 1, 2 P + 1) that multiply a series by what has these samples (m, n)."""
        spectrum = np.fft.fft2(samples.reshape(-1, *self.shape), norm="forward").reshape(samples.shape)
        h, real, imag = len(self.orders), spectrum.real.copy(), spectrum.imag.copy()
        matrix = np.empty((len(samples), 2 * h - 1, 2 * h - 1))
        a, b = real.take(self.minus, axis=1), real.take(self.plus, axis=1)
        np.add(a, b, out=matrix[:, :h, :h])
        np.subtract(a[:, 1:, 1:], b[:, 1:, 1:], out=matrix[:, h:, h:])
        a, b = imag.take(self.minus, axis=1), imag.take(self.plus, axis=1)
        np.subtract(a[..., 1:], b[..., 1:], out=matrix[:, :h, h:])
        np.add(a[:, 1:], b[:, 1:], out=matrix[:, h:, :h])
        np.negative(matrix[:, h:, :h], out=matrix[:, h:, :h])
        matrix[:, 0] *= 0.5
        return matrix

    def coordinates(self, points: Floats) -> Any:
        """Complex amplitudes (..., P + 1, n) of all coordinates at points, with means of a control that integrates."""
        q, part, i = np.moveaxis(to_complex(self.blocks(points)), 0, -1), self.part, self.part.loose
        p = np.zeros((*q.shape[:-1], len(part.inertia)), complex)
        p[..., self.linear.retained] = q
        answer = self.linear.stiffness(points[..., -1])[2]
        p[..., self.linear.gone] = answer[..., -1] - (answer[..., :-1] @ q[..., None])[..., 0]
        if np.any(part.integral):
            w, means = points[..., -1], p[..., 0, :].real
            held = self.linear.matrices[0, 0, i, -1].real + part.per_speed[i] * w - means @ part.stiffness[i]
            if self.loose >= 0:
                row = np.flatnonzero(self.linear.retained == i)[0]
                held -= np.array([self.moved(z)[0][row].mean() for z in points.reshape(-1, points.shape[-1])]).reshape(
                    w.shape
                )
            p[..., 0, :] += held[..., None] * part.integral
        return p


def waves_of(samples: Floats, shape: tuple[int, ...], places: Any) -> Any:
    """Complex amplitudes (..., P + 1) of samples (..., n) on a grid, from their places in its spectrum."""
    grid = samples.reshape(*samples.shape[:-1], *shape)
    waves = 2.0 * np.fft.fft2(grid, norm="forward").reshape(samples.shape)[..., places]
    waves[..., 0] *= 0.5
    return waves


def unbalanced(stiff: Any, blocks: Floats) -> Floats:
    """Blocks of D P - F, from D and F side by side."""
    waves, c = to_complex(blocks), len(blocks)
    return to_real((stiff[..., :c] @ waves.T[..., None])[..., 0].T - stiff[..., c].T)


def basis_of(pairs: Any) -> Any:
    """Pairs ((j, k), (0, q)), of which all of some pairs are whole combinations, with the largest j and q.

    Cohen 1993, A Course in Computational Algebraic Number Theory, sec. 2.4 (Hermite normal form).
    """
    first, slow = (0, 0), 0
    for pair in pairs:
        second = tuple(pair)
        while second[0]:
            times = first[0] // second[0]
            first, second = second, (first[0] - times * second[0], first[1] - times * second[1])
        slow = math.gcd(slow, second[1])
    j, k = first if first[0] > 0 else (-first[0] or 1, -first[1])
    return np.array([[j, k - slow * round(k / slow) if slow else k], [0, slow or 1]])


def torus(part: Any, ratio: float, lines: Floats, pairs: Any, pulls: tuple[Any, ...] = ()) -> Torus:
    """The problem of a part in some pairs (P, 2) beside the mean.

    Parameters
    ----------
    part : LinearPart
        Linear part around its laws; with `pulls` its `load` (n,) is the load's angle without psi_2 [rad].
    ratio : float
        Turns of the motor in one of the output.
    lines : (lines, 4) array
        Pair, cosine and sine amplitude [rad] of every line of the kinematic error.
    pairs : (P, 2) array of int
        The waves.
    pulls : tuple of laws
        Torques against the load of its own angle.
    """
    pairs = np.vstack([np.zeros((1, 2), int), np.asarray(pairs, int).reshape(-1, 2)])
    (j, k), (_, q) = basis = basis_of(pairs)
    cells = np.column_stack([pairs[:, 0] // j, (pairs[:, 1] - k * (pairs[:, 0] // j)) // q])
    highest = np.max(np.abs(cells), axis=0)
    over = OVERSAMPLED
    if not lacking(part.laws[0], "width"):
        over = int(np.clip(math.sqrt(SAMPLES / np.prod(np.maximum(highest, 1))), OVERSAMPLED, CORNERED))
    least = np.where(highest > 0, over * highest + over, 1)
    shape = tuple(SMOOTH[np.searchsorted(SMOOTH, least)].tolist())
    grid = np.indices(shape).reshape(2, -1) * (2.0 * np.pi / np.array(shape)[:, None])
    slow = grid[1] / q
    angles = np.array([(grid[0] - k * slow) / j, slow])
    coordinates = np.arange(len(part.laws) + part.follows)
    if pulls:
        coordinates = np.union1d(coordinates, np.flatnonzero(part.load))
    lines = np.asarray(lines, float).reshape(-1, 4)
    turns, of_lines, strides = np.array([1.0, 1.0 / ratio]), lines[:, :2], np.array([shape[1], 1])
    plus = ((cells[:, None] + cells[None]) % shape) @ strides
    minus = ((cells[:, None] - cells[None]) % shape) @ strides
    small = (2 * len(pairs) - 1) * len(slow) <= LARGEST_TABLE
    table = synthesis_at(pairs, angles) if small else np.empty((0, 0))
    loose = np.flatnonzero(coordinates == part.loose)
    orders, forces = pairs @ turns, waves_of(part.forces(angles[0]), shape, plus[0]).T
    problem = Torus(
        part=part, ratio=ratio, pulls=pulls, pairs=pairs, orders=orders, basis=basis, cells=cells,
        linear=linear_waves(part, coordinates, orders, forces), lines=np.column_stack([of_lines @ turns, lines[:, 2:]]),
        line_pairs=of_lines, turned=of_lines @ angles, slow=slow, shape=shape, synthesis=table, plus=plus, minus=minus,
        still_error=(), loose=int(loose[0]) * (2 * len(pairs) - 1) if len(loose) else -1, memory={},
    )  # fmt: skip
    return problem._replace(still_error=problem.error(0.0))


def synthesis_at(pairs: Any, angles: Floats) -> Floats:
    """Samples (2 P + 1, n) of the mean, the cosines and the sines of waves at angles (2, n) of motor and output."""
    a = pairs[1:] @ angles
    return np.concatenate([np.ones((1, angles.shape[1])), np.cos(a), np.sin(a)])
