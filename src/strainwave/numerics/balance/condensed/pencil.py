"""The dynamic stiffness of what is linear around the laws, condensed onto the coordinates that the laws see.

Harmonic k of M p'' + C p' + K p = F is (K - w^2 M + i w C) P = F, w = k omega/turns. Gauss's elimination of the last
coordinates leaves D(w) and a force on the first ones: exact, harmonic by harmonic, and with it the derivative by omega.

Krack & Gross 2019, Harmonic Balance for Nonlinear Vibration Problems, sec. 4.1 (exact condensation).
"""

from typing import Any, NamedTuple

import numpy as np

from ....base.results import Floats
from ....compile.jit import kernel_as


class Pencil(NamedTuple):
    """Matrices (3, n, n) of inertia, damping and stiffness, and forces; coordinates from `kept` on are eliminated.

    `forces` are complex (n, H+1): F_k exp(i k psi), the mean first; `per_speed` constant ones per base speed. `rate`
    is the frequency of harmonic 1 over the base speed. The mean balance of the coordinate `loose` (-1: none) is not
    asked; the mean of `zero_mean` of the coordinates is 0 instead. The `controls` coordinates behind it, states of
    its control, have no mean.
    """

    matrices: Floats
    forces: Any
    per_speed: Floats
    kept: int
    loose: int
    zero_mean: Floats
    controls: int
    rate: float


def _condense_loops(pencil: Any, omega: float, factor: float, s: Any, d: Any) -> None:
    n = pencil.matrices.shape[1]
    for k in range(s.shape[0]):
        rate = pencil.rate * k
        w = rate * omega
        for i in range(n):
            for j in range(n):
                spring = pencil.matrices[2, i, j] - w * w * pencil.matrices[0, i, j]
                s[k, i, j] = complex(spring, w * pencil.matrices[1, i, j])
                d[k, i, j] = complex(-2.0 * w * rate * pencil.matrices[0, i, j], rate * pencil.matrices[1, i, j])
            if k == 0:
                s[k, i, n] = pencil.forces[i, 0] + pencil.per_speed[i] * omega
                d[k, i, n] = pencil.per_speed[i]
            else:
                s[k, i, n] = factor * pencil.forces[i, k]
                d[k, i, n] = 0.0
        if k == 0 and pencil.loose >= 0:
            for j in range(n + 1):
                s[0, pencil.loose, j] = pencil.zero_mean[j] if j < n else 0.0
                d[0, pencil.loose, j] = 0.0
        for pivot in range(n - 1, pencil.kept - 1, -1):
            if k == 0 and pencil.loose < pivot <= pencil.loose + pencil.controls:
                continue
            inverse = 1.0 / s[k, pivot, pivot]
            for i in range(pivot):
                share = s[k, i, pivot] * inverse
                slope = (d[k, i, pivot] - share * d[k, pivot, pivot]) * inverse
                for j in range(n + 1):
                    if j < pivot or j == n:
                        d[k, i, j] -= slope * s[k, pivot, j] + share * d[k, pivot, j]
                        s[k, i, j] -= share * s[k, pivot, j]


@kernel_as(_condense_loops)
def condense(pencil: Any, omega: Any, factor: float, s: Any, d: Any) -> None:
    """Write what is left in s[k, :kept, :kept], the forces in s[k, :kept, n], and their derivatives by omega in d.

    s and d are complex (..., H+1, n, n+1), with omega (...) as Python, which takes None for d; the rows of s from
    `kept` on tell the eliminated coordinates by those before. `factor` multiplies what alternates in the forces.
    """
    n, omega = pencil.matrices.shape[1], np.asarray(omega, float)[..., None, None, None]
    rate = (pencil.rate * np.arange(s.shape[-3]))[:, None, None]
    w = rate * omega
    inertia, damping, stiffness = pencil.matrices
    s[..., :n] = stiffness - w * w * inertia + 1j * w * damping
    s[..., n] = factor * pencil.forces.T
    s[..., 0, :, n] = pencil.forces[:, 0] + pencil.per_speed * omega[..., 0, 0]
    if pencil.loose >= 0:
        s[..., 0, pencil.loose, :] = np.append(pencil.zero_mean, 0.0)
    if d is not None:
        d[..., :n] = -2.0 * w * rate * inertia + 1j * rate * damping
        d[..., n], d[..., 0, :, n] = 0.0, pencil.per_speed
        if pencil.loose >= 0:
            d[..., 0, pencil.loose, :] = 0.0
    for pivot in range(n - 1, pencil.kept - 1, -1):
        first = 1 if pencil.loose < pivot <= pencil.loose + pencil.controls else 0
        entries = s[..., first:, :, :]
        inverse = 1.0 / entries[..., pivot, pivot][..., None]
        share, row = entries[..., :pivot, pivot] * inverse, entries[..., [pivot], :]
        if d is not None:
            slopes = d[..., first:, :, :]
            slope = (slopes[..., :pivot, pivot] - share * slopes[..., pivot, pivot][..., None]) * inverse
            slopes[..., :pivot, :] -= slope[..., None] * row + share[..., None] * slopes[..., [pivot], :]
        entries[..., :pivot, :] -= share[..., None] * row


def eliminated(pencil: Any, s: Any, kept: Any) -> Any:
    """All coordinates (..., H+1, n), complex, from the kept ones, by what `condense` left in s."""
    n = pencil.matrices.shape[1]
    p = np.zeros((*kept.shape[:-1], n), complex)
    p[..., : pencil.kept] = kept
    for out in range(pencil.kept, n):
        first = 1 if pencil.loose < out <= pencil.loose + pencil.controls else 0
        row = s[..., first:, out, :]
        coupled = np.sum(row[..., :out] * p[..., first:, :out], axis=-1)
        p[..., first:, out] = (row[..., n] - coupled) / row[..., out]
    return p


def _add_stiffness_loops(s: Any, gear: float, blocks: Floats, u: Floats, r: Floats) -> None:
    n = s.shape[1]
    size = blocks.shape[1]
    h = size // 2
    for i in range(blocks.shape[0]):
        start = i * size
        total = -s[0, i, n].real
        for j in range(blocks.shape[0]):
            total += s[0, i, j].real * blocks[j, 0]
        r[start] += total
        for k in range(1, h + 1):
            cosine, sine = -s[k, i, n].real, s[k, i, n].imag
            for j in range(blocks.shape[0]):
                a, b = s[k, i, j].real, s[k, i, j].imag
                c, e = blocks[j, k], blocks[j, h + k]
                cosine += a * c + b * e
                sine += a * e - b * c
            if i == 0:
                cosine += gear * k * u[h + k]
                sine -= gear * k * u[k]
            r[start + k] += cosine
            r[start + h + k] += sine


@kernel_as(_add_stiffness_loops)
def add_stiffness(s: Any, gear: float, blocks: Floats, u: Floats, r: Floats) -> None:
    """Add D P - F, in blocks of coefficients, to r, and to the first block the gear's damping: `gear` k u'."""
    count, size = blocks.shape
    n, h = s.shape[1], size // 2
    p = to_complex(blocks)
    out = np.einsum("kij,jk->ik", s[:, :count, :count], p) - s[:, :count, n].T
    k = np.arange(1, h + 1)
    rows = r[: count * size].reshape(count, size)
    rows[:, 0] += out[:, 0].real
    rows[:, 1 : h + 1] += out[:, 1:].real
    rows[:, h + 1 :] -= out[:, 1:].imag
    rows[0, 1 : h + 1] += gear * k * u[h + 1 : size]
    rows[0, h + 1 :] -= gear * k * u[1 : h + 1]


def _times_loops(s: Any, i: int, j: int, right: Floats, product: Floats) -> None:
    h = right.shape[0] // 2
    for m in range(right.shape[1]):
        product[0, m] += s[0, i, j].real * right[0, m]
    for k in range(1, h + 1):
        a, b = s[k, i, j].real, s[k, i, j].imag
        for m in range(right.shape[1]):
            c, e = right[k, m], right[h + k, m]
            product[k, m] += a * c + b * e
            product[h + k, m] += a * e - b * c


@kernel_as(_times_loops)
def add_times(s: Any, i: int, j: int, right: Floats, product: Floats) -> None:
    """Add the entry (i, j) of all D, as a matrix on coefficients in blocks, times `right`, to `product`."""
    h = len(right) // 2
    a, b = s[1 : h + 1, i, j].real[:, None], s[1 : h + 1, i, j].imag[:, None]
    c, e = right[1 : h + 1], right[h + 1 :]
    product[0] += s[0, i, j].real * right[0]
    product[1 : h + 1] += a * c + b * e
    product[h + 1 :] += a * e - b * c


def _on_the_left_loops(left: Floats, s: Any, i: int, j: int, product: Floats) -> None:
    h = left.shape[0] // 2
    for m in range(left.shape[0]):
        product[m, 0] += left[m, 0] * s[0, i, j].real
        for k in range(1, h + 1):
            a, b = s[k, i, j].real, s[k, i, j].imag
            c, e = left[m, k], left[m, h + k]
            product[m, k] += c * a - e * b
            product[m, h + k] += c * b + e * a


@kernel_as(_on_the_left_loops)
def add_on_the_left(left: Floats, s: Any, i: int, j: int, product: Floats) -> None:
    """Add `left` times the matrix by which entry (i, j) of the dynamic stiffness acts on blocks of coefficients.

    `s` is the dynamic stiffness (harmonics, n, n); blocks are mean, cosines, sines.
    """
    h = len(left) // 2
    a, b = s[1 : h + 1, i, j].real, s[1 : h + 1, i, j].imag
    c, e = left[:, 1 : h + 1], left[:, h + 1 :]
    product[:, 0] += left[:, 0] * s[0, i, j].real
    product[:, 1 : h + 1] += c * a - e * b
    product[:, h + 1 :] += c * b + e * a


def _add_entries_loops(s: Any, gear: float, size: int, count: int, jacobian: Floats) -> None:
    h = size // 2
    for i in range(count):
        for j in range(count):
            row, column = i * size, j * size
            jacobian[row, column] += s[0, i, j].real
            for k in range(1, h + 1):
                a, b = s[k, i, j].real, s[k, i, j].imag
                if i == 0 and j == 0:
                    b += gear * k
                jacobian[row + k, column + k] += a
                jacobian[row + k, column + h + k] += b
                jacobian[row + h + k, column + k] -= b
                jacobian[row + h + k, column + h + k] += a


@kernel_as(_add_entries_loops)
def add_entries(s: Any, gear: float, size: int, count: int, jacobian: Floats) -> None:
    """Add D and the gear's damping `gear` k to a Jacobian of `count` blocks of coefficients."""
    h = size // 2
    k = np.arange(1, h + 1)
    for i in range(count):
        for j in range(count):
            block = jacobian[i * size : (i + 1) * size, j * size : (j + 1) * size]
            a, b = s[1 : h + 1, i, j].real, s[1 : h + 1, i, j].imag + (gear * k if i == j == 0 else 0.0)
            block[0, 0] += s[0, i, j].real
            block[k, k] += a
            block[k, h + k] += b
            block[h + k, k] -= b
            block[h + k, h + k] += a


def to_complex(blocks: Floats) -> Any:
    """Coefficients (..., H+1), complex, of c cos + s sin as Re (c - i s) exp(i k psi), from blocks (..., 2H+1)."""
    h = blocks.shape[-1] // 2
    out = np.zeros((*blocks.shape[:-1], h + 1), complex)
    out[..., 0] = blocks[..., 0]
    out[..., 1:] = blocks[..., 1 : h + 1] - 1j * blocks[..., h + 1 :]
    return out


def to_real(waves: Any) -> Floats:
    """Blocks (..., 2H+1) from complex coefficients (..., H+1)."""
    return np.concatenate([waves.real, -waves.imag[..., 1:]], axis=-1)
