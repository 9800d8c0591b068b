"""`Torus`: the balance of a system that is linear around its laws, in waves of two turns.

The motor turns by psi_1 = omega t, the output by psi_2 = psi_1/N. A motion is a sum of waves of pairs (j, k), with the
angle j psi_1 + k psi_2 and the frequency (j + k/N) omega: D(j omega + k omega/N) P_jk + T_jk = F_jk, with the dynamic
stiffness D of all that is linear. The torques T are sampled on a grid of both angles: of the gear, of the couplings,
what a kinematic error gives back to the motor, and what follows the load's own angle psi_2 + a P, as gravity does.

Krack & Gross 2019, Harmonic Balance for Nonlinear Vibration Problems, secs. 2.4 (AFT), 4.1 (condensation) and 5.3
(several base frequencies).
"""

from typing import Any, NamedTuple

import numpy as np

from ...base.results import Floats
from ..balance.condensed.pencil import add_entries, add_stiffness, to_complex, to_real

SMOOTH = np.unique([2**a * 3**b * 5**c for a in range(14) for b in range(9) for c in range(6)])  # fast transforms
OVERSAMPLED = 4  # samples of an angle in a period of its highest wave: a cube of these waves is exact


class Motion(NamedTuple):
    """What a motion (coordinates, samples) does: torques, and their derivatives by it, its rates and the speed."""

    torque: Floats
    by_place: dict[tuple[int, int], Any]
    by_rate: dict[tuple[int, int], Any]
    by_speed: Floats


class Torus(NamedTuple):
    """Balance in the waves `pairs` (P + 1, 2), (0, 0) first, of the coordinates `retained`, block by block.

    A block has the mean, the cosines and the sines of x or another coordinate; a point ends with the speed omega.
    `lines` (order, cosine, sine) are those of the kinematic error, of the pairs `line_pairs`, `turned` (lines, samples)
    their angles, `pulls` laws of the load's angle; `plus` and `minus` (P + 1, P + 1) are places of sums and differences
    of pairs in a spectrum. The samples are those of a grid of `shape`, or those of a `table` of waves. `memory` has the
    latest point with what it does.
    """

    part: Any
    ratio: float
    pulls: tuple[Any, ...]
    pairs: Any
    orders: Floats
    retained: Any
    forces: Any
    lines: Floats
    line_pairs: Floats
    turned: Floats
    slow: Floats
    shape: tuple[int, ...]
    table: Any
    plus: Any
    minus: Any
    still_error: Any
    memory: dict[str, Any]

    def size(self) -> int:
        """Number of coefficients."""
        return len(self.retained) * (2 * len(self.pairs) - 1)

    def harmonics(self) -> int:
        """Number of waves beside the mean."""
        return len(self.pairs) - 1

    def harmonic(self, z: Floats, k: int) -> Any:
        """Cosine and sine coefficient of the k-th wave of x."""
        return z[k], z[len(self.pairs) - 1 + k]

    def blocks(self, z: Floats) -> Floats:
        """Coefficients (coordinates, 2 P + 1) of a point."""
        return z[:-1].reshape(len(self.retained), -1)

    def run(self, kernel: Any, *arguments: Any) -> Any:
        """Execute a kernel with the problem: as Python, where each step is a few calls of LAPACK."""
        return kernel(self, *arguments)

    def samples(self, waves: Any) -> Floats:
        """Samples (rows, samples) of complex amplitudes (rows, P + 1)."""
        if self.table is not None:
            return np.asarray((waves @ self.table).real)
        spectrum = np.zeros((len(waves), *self.shape), complex)
        spectrum[:, self.pairs[:, 0], self.pairs[:, 1]] = waves
        return np.fft.ifft2(spectrum, norm="forward").real.reshape(len(waves), -1)

    def series(self, samples: Floats) -> Floats:
        """Coefficients (rows, 2 P + 1) of samples on the grid."""
        spectrum = np.fft.fft2(samples.reshape(-1, *self.shape), norm="forward")
        waves = 2.0 * spectrum[:, self.pairs[:, 0], self.pairs[:, 1]]
        waves[:, 0] *= 0.5
        return to_real(waves)

    def error(self, deviation: Any) -> tuple[Any, Any, Any]:
        """Kinematic error, its first and second derivative, at the samples and a deviation of the motor."""
        order, even, odd = self.lines.T[:, :, None]
        a = self.turned + order * deviation
        c, s = np.cos(a), np.sin(a)
        wave, turned = even * c + odd * s, odd * c - even * s
        return wave.sum(axis=0), (order * turned).sum(axis=0), -(order * order * wave).sum(axis=0)

    def moved(self, z: Floats) -> Motion:
        """Torques at a point, without what the gear's damping makes of the rate of x alone."""
        waves, w, part, m = to_complex(self.blocks(z)), z[-1], self.part, len(self.part.laws)
        q, B = self.samples(waves), part.gear_damping
        torque, by_speed, by_rate = np.zeros_like(q), np.zeros_like(q), {}
        e, slope, bend = self.error(q[m]) if part.follows else self.still_error
        u = q[0] - e
        stiff = part.laws[0].stiffness(u) + 0.0 * u
        torque[0], by_place = part.laws[0].torque(u), {(0, 0): stiff}
        if part.follows:
            rate, turning = self.samples(1j * self.orders * waves[[0, m]])
            turning += 1.0
            gear, pull = torque[0] + B * w * (rate - slope * turning), stiff * slope + B * w * bend * turning
            by_speed[0], by_speed[m] = -B * slope * turning, -B * slope * (rate - slope * turning)
            torque[m] = -slope * gear
            by_place |= {(0, m): -pull, (m, 0): -slope * stiff, (m, m): slope * pull - bend * gear}
            by_rate = {(0, m): -B * w * slope, (m, 0): -B * w * slope, (m, m): B * w * slope * slope}
        else:
            by_speed[0] = -B * slope
        torque[0] += w * by_speed[0]
        for i, law in enumerate(part.laws[1:], 1):
            torque[i], by_place[i, i] = law.torque(q[i]), law.stiffness(q[i]) + 0.0 * u
        if self.pulls:
            a = part.load[self.retained]
            angle = self.slow + a @ q
            torque += np.outer(a, sum(law.torque(angle) for law in self.pulls))
            stiff = sum(law.stiffness(angle) for law in self.pulls)
            for i, j in np.argwhere(np.outer(a, a)).tolist():
                by_place[i, j] = by_place.get((i, j), 0.0) + a[i] * a[j] * stiff
        return Motion(torque, by_place, by_rate, by_speed)

    def latest(self, z: Floats) -> tuple[Motion, Any, Any]:
        """What a point does, the dynamic stiffness and its derivative: once for each point."""
        if self.memory.get("point") is None or not np.array_equal(self.memory["point"], z):
            stiff = condensed(self.part, self.retained, self.orders, self.forces, z[-1])[:2]
            self.memory.update(point=z.copy(), found=(self.moved(z), *stiff))
        found: tuple[Motion, Any, Any] = self.memory["found"]
        return found

    def residual(self, z: Floats, r: Floats) -> None:
        """Write what the equations lack [N*m] at z."""
        (motion, stiff, _), blocks = self.latest(z), self.blocks(z)
        r[:] = self.series(motion.torque).ravel()
        add_stiffness(stiff, 0.0, blocks, blocks[0], r)
        if (loose := self.loose()) >= 0:
            r[loose] = self.inertia(z) * z[loose]

    def linearise(self, z: Floats, jacobian: Floats, slope: Floats) -> None:
        """Write the derivatives by the coefficients and by the speed."""
        (motion, stiff, by_speed), blocks = self.latest(z), self.blocks(z)
        a, size, h = jacobian[: self.size(), : self.size()], blocks.shape[1], len(self.orders) - 1
        a[:] = 0.0
        for (i, j), samples in motion.by_place.items():
            a[i * size : (i + 1) * size, j * size : (j + 1) * size] = self.product(samples)
        for (i, j), samples in motion.by_rate.items():
            block, w = self.product(samples), self.orders[1:]
            out = a[i * size : (i + 1) * size, j * size : (j + 1) * size]
            out[:, 1 : h + 1] -= w * block[:, h + 1 :]
            out[:, h + 1 :] += w * block[:, 1 : h + 1]
        add_entries(stiff, 0.0, size, len(self.retained), a)
        slope[:] = self.series(motion.by_speed).ravel()
        add_stiffness(by_speed, 0.0, blocks, blocks[0], slope)
        if (loose := self.loose()) >= 0:
            a[loose], slope[loose] = 0.0, 0.0
            a[loose, loose] = self.inertia(z)

    def loose(self) -> int:
        """Place of the mean that nothing holds among the unknowns; -1 where it is none of them."""
        at = np.flatnonzero(self.retained == self.part.loose)
        return int(at[0]) * (2 * len(self.pairs) - 1) if len(at) else -1

    def inertia(self, z: Floats) -> float:
        """Inertia of that coordinate times the square of the speed [N*m/rad]."""
        return float(self.part.inertia[self.part.loose, self.part.loose] * z[-1] ** 2)

    def product(self, samples: Floats) -> Floats:
        """Matrix that multiplies a series by what has these samples."""
        spectrum = np.fft.fft2(samples.reshape(self.shape)).ravel() / samples.size
        a, b, h = spectrum[self.minus], spectrum[self.plus], len(self.orders)
        out = np.empty((2 * h - 1, 2 * h - 1))
        both, apart = a + b, a - b
        out[:h, :h], out[:h, h:] = both.real, apart.imag[:, 1:]
        out[h:, :h], out[h:, h:] = -both.imag[1:], apart.real[1:, 1:]
        out[0] *= 0.5
        return out

    def coordinates(self, z: Floats) -> Any:
        """Complex amplitudes (P + 1, n) of all coordinates at a point, with the means of a control that integrates."""
        q = to_complex(self.blocks(z)).T
        p = np.zeros((len(q), len(self.part.inertia)), complex)
        p[:, self.retained] = q
        for rows, columns, answer, force in condensed(self.part, self.retained, self.orders, self.forces, z[-1])[2]:
            p[np.ix_(rows, columns)] = force - np.einsum("pij,pj->pi", answer, q[rows])
        part, i = self.part, self.part.loose
        if np.any(part.integral):
            held = self.forces[0, i].real + part.per_speed[i] * z[-1] - part.stiffness[i] @ p[0].real
            if self.loose() >= 0:
                held -= np.mean(self.latest(z)[0].torque[np.flatnonzero(self.retained == i)[0]])
            p[0] += held * part.integral
        return p


def condensed(part: Any, retained: Any, orders: Floats, forces: Any, omega: float) -> tuple[Any, Any, list[Any]]:
    """Dynamic stiffness and forces (P + 1, n) of a part on retained coordinates, both by the speed, and the solutions.

    A coordinate `loose` has no mean, nor have the states of its control behind it.
    """
    n, c = len(part.inertia), len(retained)
    w, damping = (orders * omega)[:, None, None], part.damping.copy()
    damping[0, 0] += part.gear_damping
    a = np.empty((len(orders), n, n + 1), complex)
    da = np.zeros_like(a)
    a[..., :n] = part.stiffness - w * w * part.inertia + 1j * w * damping
    da[..., :n] = orders[:, None, None] * (1j * damping - 2.0 * w * part.inertia)
    a[..., n] = forces
    at_rest = orders == 0.0
    steady = at_rest & (np.arange(len(orders)) == 0)
    a[steady, :, n] += part.per_speed * omega
    da[steady, :, n] = part.per_speed
    columns = np.append(retained, n)
    if c == n:
        return a, da, []
    stiff, by_speed, solutions = a[:, retained][..., columns], da[:, retained][..., columns], []
    eliminated = np.setdiff1d(np.arange(n), retained)
    massless = int(np.sum(~np.any(part.inertia, axis=1)))
    moving = (
        np.setdiff1d(eliminated, np.arange(part.loose, part.loose + massless + 1)) if part.loose >= 0 else eliminated
    )
    for rows, gone in ((np.flatnonzero(~at_rest), eliminated), (np.flatnonzero(at_rest), moving)):
        if len(gone) and len(rows):
            inside, across = np.ix_(rows, gone, gone), np.ix_(rows, gone, columns)
            answer = np.linalg.solve(a[inside], a[across])
            back, change = a[np.ix_(rows, retained, gone)], da[np.ix_(rows, retained, gone)]
            left = np.swapaxes(np.linalg.solve(np.swapaxes(a[inside], 1, 2), np.swapaxes(back, 1, 2)), 1, 2)
            stiff[rows] -= back @ answer
            by_speed[rows] -= change @ answer + left @ (da[across] - da[inside] @ answer)
            solutions.append((rows, gone, answer[..., :c], answer[..., c]))
    return stiff, by_speed, solutions


def torus(part: Any, ratio: float, lines: Floats, pairs: Any, pulls: tuple[Any, ...] = ()) -> Torus:
    """The problem of a part in some pairs (P, 2) beside the mean.

    Parameters
    ----------
    part : LinearPart
        What is linear around its laws; with `pulls` its `load` (n,) is the load's angle without psi_2 [rad].
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
    highest = np.maximum(np.max(np.abs(pairs), axis=0), 1)
    shape = tuple(SMOOTH[np.searchsorted(SMOOTH, OVERSAMPLED * highest + OVERSAMPLED)].tolist())
    angles = np.indices(shape).reshape(2, -1) * (2.0 * np.pi / np.array(shape)[:, None])
    coordinates = np.arange(len(part.laws) + part.follows)
    if pulls:
        coordinates = np.union1d(coordinates, np.flatnonzero(part.load))
    lines = np.asarray(lines, float).reshape(-1, 4)
    turns, of_lines, strides = np.array([1.0, 1.0 / ratio]), lines[:, :2], np.array([shape[1], 1])
    plus = ((pairs[:, None] + pairs[None]) % shape) @ strides
    minus = ((pairs[:, None] - pairs[None]) % shape) @ strides
    problem = Torus(
        part, ratio, pulls, pairs, pairs @ turns, coordinates, np.zeros((len(pairs), len(part.inertia))),
        np.column_stack([of_lines @ turns, lines[:, 2:]]), of_lines, of_lines @ angles, angles[1], shape, None, plus,
        minus, (), {},
    )  # fmt: skip
    forces = to_complex(problem.series(part.forces(angles[0]))).T
    return problem._replace(forces=forces, still_error=problem.error(0.0))
