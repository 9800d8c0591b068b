"""Harmonic balance of laws that are linear between breakpoints, without sampling error.

Where the torsion u(psi) crosses breakpoints, stiffness g and intercept c of T = g u + c jump. The Fourier
coefficients of these two step functions are sums over the crossings, and T's are the product of g with the series of
u, plus those of c: exact for the truncated u, and the same product matrix is the exact Jacobian, because T is
continuous. Sampling T instead leaves kinks in the equations that show as false folds. Between crossings Hill's
equation has constant coefficients, so the multipliers are exact too.
"""

import math
from typing import Any, NamedTuple

import numpy as np

from ...base.law import breakpoints_of
from ...base.results import Floats
from ...compile.jit import kernel_as, routine
from ..addressed import kinks, stiffnesses, torques
from .fourier import extend, multiply_rows
from .linear_algebra import copy, extremes

MOST_CROSSINGS = 256


def _crossings_loops(
    breaks: Any, sides: Any, z: Floats, u: Floats, angles: Floats, jumps: Floats, places: Any
) -> int:  # fmt: skip
    h = (len(z) - 2) // 2
    spacing = 2.0 * math.pi / len(u)
    count = 0
    for i in range(len(u)):
        after = u[i + 1] if i + 1 < len(u) else u[0]
        for j in range(len(breaks)):
            b = breaks[j]
            if (u[i] < b) != (after < b) and count < MOST_CROSSINGS:
                low, high = spacing * i, spacing * (i + 1)
                psi = low + spacing * (b - u[i]) / (after - u[i])
                for _ in range(8):
                    value, slope = series(z, h, psi)
                    if (value - b) * (after - u[i]) < 0.0:
                        low = psi
                    else:
                        high = psi
                    step = (value - b) / slope if slope != 0.0 else 0.0
                    psi -= step
                    if not low <= psi <= high:
                        psi = 0.5 * (low + high)
                    if abs(step) < 1e-15:
                        break
                rise = sides[2 * j + 1] - sides[2 * j]
                angles[count], places[count] = psi, b
                jumps[count] = rise if after > u[i] else -rise
                count += 1
    return count


@kernel_as(_crossings_loops)
def crossings(
    breaks: Any, sides: Any, z: Floats, u: Floats, angles: Floats, jumps: Floats, places: Any
) -> int:  # fmt: skip
    """Angles psi in [0, 2 pi) at which the series z, sampled in u, crosses a breakpoint; jumps of stiffness there.

    `sides` are the stiffnesses before and after each breakpoint; `places` gets the breakpoint's torsion. Returns their
    number.
    """
    h, spacing = (len(z) - 2) // 2, 2.0 * math.pi / len(u)
    below = u[:, None] < breaks
    i, j = np.nonzero(below != np.roll(below, -1, axis=0))
    i, j = i[:MOST_CROSSINGS], j[:MOST_CROSSINGS]
    b, first, rise = breaks[j], u[i], np.roll(u, -1)[i] - u[i]
    low, high = spacing * i, spacing * (i + 1)
    psi = low + spacing * (b - first) / rise
    k = np.arange(1, h + 1)
    for _ in range(8):
        c, s = np.cos(np.outer(psi, k)), np.sin(np.outer(psi, k))
        short = z[0] + c @ z[1 : h + 1] + s @ z[h + 1 : 2 * h + 1] - b
        slope = c @ (k * z[h + 1 : 2 * h + 1]) - s @ (k * z[1 : h + 1])
        low, high = np.where(short * rise < 0.0, psi, low), np.where(short * rise < 0.0, high, psi)
        step = np.divide(short, slope, out=np.zeros_like(slope), where=slope != 0.0)
        moved = psi - step
        psi = np.where((low <= moved) & (moved <= high), moved, 0.5 * (low + high))
        if np.all(np.abs(step) < 1e-8):  # the next would be 1e-16
            break
    count = len(i)
    angles[:count], places[:count] = psi, b
    jumps[:count] = np.sign(rise) * (sides[2 * j + 1] - sides[2 * j])
    return count


def _series_loops(z: Floats, h: int, psi: float) -> Any:
    c, s = math.cos(psi), math.sin(psi)
    ck, sk = 1.0, 0.0
    value, slope = z[0], 0.0
    for k in range(1, h + 1):
        ck, sk = ck * c - sk * s, ck * s + sk * c
        value += z[k] * ck + z[h + k] * sk
        slope += k * (z[h + k] * ck - z[k] * sk)
    return value, slope


@kernel_as(_series_loops)
def series(z: Floats, h: int, psi: float) -> Any:
    """Value and derivative of a series (blocks) at psi."""
    k = np.arange(1, h + 1)
    c, s = np.cos(k * psi), np.sin(k * psi)
    a, b = z[1 : h + 1], z[h + 1 : 2 * h + 1]
    return float(z[0] + a @ c + b @ s), float(k @ (b * c - a * s))


def _steps_loops(
    base: float, angles: Floats, jumps: Floats, count: int, h: int, cosines: Floats, sines: Floats
) -> None:
    cosines[0] = 2.0 * base
    sines[0] = 0.0
    for k in range(1, h + 1):
        cosines[k] = 0.0
        sines[k] = 0.0
    for j in range(count):
        jump = jumps[j] / math.pi
        c, s = math.cos(angles[j]), math.sin(angles[j])
        ck, sk = 1.0, 0.0
        cosines[0] += jump * (2.0 * math.pi - angles[j])
        for k in range(1, h + 1):
            ck, sk = ck * c - sk * s, ck * s + sk * c
            cosines[k] -= jump * sk / k
            sines[k] += jump * ck / k


@kernel_as(_steps_loops)
def steps(base: float, angles: Floats, jumps: Floats, count: int, h: int, even: Floats, odd: Floats) -> None:
    """Cosine (even; entry 0 is twice the mean) and sine coefficients of a step function that starts at `base`."""
    k = np.arange(1, h + 1)
    jump, psi = jumps[:count] / math.pi, angles[:count]
    even[0], odd[0] = 2.0 * base + float(jump @ (2.0 * math.pi - psi)), 0.0
    even[1 : h + 1] = -(jump @ np.sin(np.outer(psi, k))) / k
    odd[1 : h + 1] = jump @ np.cos(np.outer(psi, k)) / k


class Crossings(NamedTuple):
    """Fourier coefficients of T(u) for a law that is linear between breakpoints; the arrays are buffers.

    `beside` are torsions before and after each breakpoint and, last, the first sample, `sides` the stiffnesses there;
    `first` is the first sample and `start` its torque.
    """

    angles: Floats
    jumps: Floats
    places: Floats
    even: Floats
    odd: Floats
    gc: Floats
    gs: Floats
    product: Floats
    breaks: Floats
    beside: Floats
    sides: Floats
    first: Floats
    start: Floats

    def is_sampled(self) -> bool:
        """False: the torque is exact, not sampled."""
        return False

    def crossed(self, law: Any, z: Floats, u: Floats) -> int:
        """Find the crossings of a motion, with what the law is at its start; returns their number."""
        count = kinks(law, self.breaks)
        for j in range(count):
            gap = 1e-7 * abs(self.breaks[j]) + 1e-300
            self.beside[2 * j], self.beside[2 * j + 1] = self.breaks[j] - gap, self.breaks[j] + gap
        self.beside[2 * count] = self.first[0] = u[0]
        stiffnesses(law, self.beside, self.sides)
        return crossings(self.breaks, self.sides, z, u, self.angles, self.jumps, self.places)

    def torque_series(self, law: Any, z: Floats, u: Floats, r: Floats) -> None:
        """Coefficients of T(u) from those of u (z) and its samples."""
        n = len(r)
        h = n // 2
        count = self.crossed(law, z, u)
        torques(law, self.first, self.start)
        stiffness = self.sides[2 * len(self.breaks)]
        steps(stiffness, self.angles, self.jumps, count, 2 * h, self.even, self.odd)
        extend(self.even, self.odd, 2 * h, self.gc, self.gs)
        multiply_rows(self.gc, self.gs, h, 1, self.product)
        for j in range(count):
            self.jumps[j] *= -self.places[j]
        steps(self.start[0] - stiffness * u[0], self.angles, self.jumps, count, h, self.even, self.odd)
        r[0] = 0.5 * self.even[0]
        for k in range(1, h + 1):
            r[k] = self.even[k]
            r[h + k] = self.odd[k]
        add_product(self.product, z, r)

    def stiffness_product(self, law: Any, u: Floats, jacobian: Floats) -> None:
        """Matrix that multiplies a series by T'(u); follows `torque_series` at the same u."""
        for i in range(self.product.shape[0]):
            copy(self.product[i], jacobian[i, : self.product.shape[0]])

    def slack(self, u: Floats) -> float:
        """Distance [rad] between the middles of an orbit and of the play in which it floats; 0 in contact.

        Any mean is in balance there; the middle is the one that contact starts from. It follows `torque_series`.
        """
        low, high = extremes(u)
        if self.sides[2 * len(self.breaks)] != 0.0 or self.start[0] != 0.0:
            return 0.0
        lower, upper = -1e300, 1e300
        for b in self.breaks:
            if u[low] < b < u[high]:
                return 0.0
            if b <= u[low]:
                lower = max(lower, b)
            else:
                upper = min(upper, b)
        return 0.5 * (u[low] + u[high] - lower - upper) if lower > -1e300 and upper < 1e300 else 0.0

    def hill_trace(self, law: Any, J: float, B: float, w: float, z: Floats, u: Floats, q: Floats) -> float:
        """Trace of the period map of z'' + (T'(u)/J - (B/2J)^2) z = 0, exact between crossings."""
        count = self.crossed(law, z, u)
        sort_by_angle(self.angles, self.jumps, count)
        stiffness, begin = self.sides[2 * len(self.breaks)], 0.0
        shift = 0.25 * (B / J) ** 2
        a, b, c, d = 1.0, 0.0, 0.0, 1.0
        for j in range(count + 1):
            end = self.angles[j] if j < count else 2.0 * math.pi
            c0, s0, k = free_motion(stiffness / J - shift, (end - begin) / w)
            a, b, c, d = c0 * a + s0 * c, c0 * b + s0 * d, c0 * c - k * s0 * a, c0 * d - k * s0 * b
            if j < count:
                stiffness += self.jumps[j]
            begin = end
        return a + d


@routine
def free_motion(q: float, t: float) -> Any:
    """Return cos(sqrt(q) t), sin(sqrt(q) t)/sqrt(q) and q; hyperbolic for q < 0, infinite where no float holds them."""
    if q > 0.0:
        root = q**0.5
        return math.cos(root * t), math.sin(root * t) / root, q
    if q < 0.0:
        root = (-q) ** 0.5
        if root * t > 700.0:  # Python raises here
            return math.inf, math.inf, q
        return math.cosh(root * t), math.sinh(root * t) / root, q
    return 1.0, t, q


@routine
def sort_by_angle(angles: Floats, jumps: Floats, count: int) -> None:
    """Sort crossings by angle (they come nearly sorted)."""
    for i in range(1, count):
        j = i
        while j > 0 and angles[j - 1] > angles[j]:
            angles[j - 1], angles[j] = angles[j], angles[j - 1]
            jumps[j - 1], jumps[j] = jumps[j], jumps[j - 1]
            j -= 1


def _add_product_loops(matrix: Floats, z: Floats, r: Floats) -> None:
    for i in range(matrix.shape[0]):
        total = 0.0
        for j in range(matrix.shape[1]):
            total += matrix[i, j] * z[j]
        r[i] += total


@kernel_as(_add_product_loops)
def add_product(matrix: Floats, z: Floats, r: Floats) -> None:
    """Add matrix @ z (as many entries as the matrix has columns) to r."""
    r += matrix @ z[: matrix.shape[1]]


def crossings_for(law: Any, harmonics: int) -> Crossings:
    """Buffers for a law and a number of harmonics."""
    n, m = 2 * harmonics + 1, len(breakpoints_of(law))
    room, wide = MOST_CROSSINGS, 4 * harmonics + 1
    return Crossings(
        np.empty(room), np.empty(room), np.empty(room), np.empty(n), np.empty(n), np.empty(wide), np.empty(wide),
        np.empty((n, n)), np.empty(m), np.empty(2 * m + 1), np.empty(2 * m + 1), np.empty(1), np.empty(1),
    )  # fmt: skip


class Pieces(NamedTuple):
    """A law that is linear between breakpoints: `slopes` has one entry more than `breaks`."""

    breaks: Floats
    slopes: Floats


def pieces_of(law: Any) -> Pieces | None:
    """The pieces of a law, or None where it has no breakpoints or is not linear between them."""
    breakpoints = breakpoints_of(law)
    if not breakpoints:
        return None
    places = np.array(sorted({*breakpoints}), float)
    reach = float(np.max(np.abs(places))) or 1.0
    edges = np.concatenate([[places[0] - reach], places, [places[-1] + reach]])
    inside = edges[:-1, None] + np.diff(edges)[:, None] * np.array([0.5, 0.1, 0.3, 0.7, 0.9])
    values = np.broadcast_to(law.stiffness(inside), inside.shape)
    straight = np.all(np.ptp(values, axis=1) <= 1e-12 * np.max(np.abs(values), axis=1))
    return Pieces(places, values[:, 0].copy()) if straight else None


def is_piecewise_linear(law: Any) -> bool:
    """True for a law with breakpoints and a constant stiffness between them."""
    return pieces_of(law) is not None
