"""Averages of a torque that is linear between breakpoints, along a short Fourier series: exact, without quadrature.

Along u(psi) = mean + Re(z exp(i f psi)) + lines the torque is N(u) = sum of jumps G_j (u - b_j) that begin where u
crosses the breakpoint b_j, besides the straight line it starts on. The averages of N exp(-i f psi), of its stiffness N'
and of N' exp(-2 i f psi) are therefore sums over the crossings. Crossings are bracketed on a grid whose points at an
extremum of u are moved onto it, so that the shortest visit beyond a breakpoint is seen too.
"""

import math
from typing import Any

import numpy as np

from ....base.results import Floats
from ....compile.jit import kernel
from ....compile.maths import cos, sin
from .law_samples import waves_at

POINTS = 32  # of the grid, per period of the highest harmonic
FULL = 2.0 * math.pi
CLOSE = 1e-14  # of the location of a crossing [rad]
EDGE = 1e-12  # of the reach of u: rounding


@kernel
def terms(f: float, lines: Floats) -> Any:
    """Harmonics and coefficients c of u = mean + Re(sum of c exp(i k psi)): of z first, whose place is left 0."""
    harmonics, c = np.empty(len(lines) + 1), np.zeros(len(lines) + 1, np.complex128)
    harmonics[0], harmonics[1:] = f, lines[:, 0]
    c[1:] = lines[:, 1] - 1j * lines[:, 2]
    return harmonics, c


@kernel
def series(mean: Any, c: Any, harmonics: Floats, psi: Any, turns: Any) -> Any:
    """u, u' and u'' at psi; writes the turns exp(i k psi)."""
    value, slope, bend = mean, 0.0, 0.0
    for j in range(len(c)):
        k = harmonics[j]
        turns[j] = cos(k * psi) + 1j * sin(k * psi)
        part = c[j] * turns[j]
        value, slope, bend = value + part.real, slope - k * part.imag, bend - k * k * part.real
    return value, slope, bend


@kernel
def integral(c: Any, harmonics: Floats, psi: Any, turns: Any) -> Any:
    """Integral of (u - mean) exp(-i f psi) up to psi, with f the harmonic of z, by the turns there."""
    total = 0j * psi
    for j in range(len(c)):
        apart, part = harmonics[j] - harmonics[0], c[j] * turns[j]
        total = total + 0.5j * turns[0].conjugate() * part.conjugate() / (harmonics[j] + harmonics[0])
        total = total + (0.5 * c[j] * psi if apart == 0.0 else -0.5j * turns[0].conjugate() * part / apart)
    return total


@kernel
def _crossing(
    b: float, rise: float, psi: float, low: float, high: float, mean: float, c: Any, harmonics: Floats, turns: Any
) -> float:
    """Angle at which u passes b between low and high, by Newton's method in the bracket; leaves the turns there."""
    for _ in range(30):
        value, slope, _ = series(mean, c, harmonics, psi, turns)
        if (value - b) * rise < 0.0:
            low = psi
        else:
            high = psi
        step = (value - b) / slope if slope != 0.0 else FULL
        if abs(step) < CLOSE or high - low < CLOSE:
            break
        psi -= step
        if not low <= psi <= high:
            psi = 0.5 * (low + high)
    return psi


def averages(
    breaks: Floats, slopes: Floats, mean: Floats, re: Floats, im: Floats, f: float, lines: Floats, table: Floats,
    force: Any, stiffness: Floats, twice: Any,
) -> None:  # fmt: skip
    """Write the averages of N exp(-i f psi), N' and N' exp(-2 i f psi) for every u: N(0) and jumps as in `Pieces`.

    `mean`, `re` and `im` (items,) give mean and z of each u, `lines` (lines, 3) what all have in common, and `table`
    (3, points) cos f psi, sin f psi and the sum of the lines on the grid. A constant part of N plays no role.
    """
    n = table.shape[1]
    spacing, u, torsions, psi = FULL / n, np.empty(n), np.empty(n), np.empty(n + 1)
    harmonics, c = terms(f, lines)
    turns, reach = np.empty_like(c), np.sum(np.abs(c))
    for i in range(len(re)):
        c[0] = re[i] + 1j * im[i]
        amplitude = (abs(c[0]) + reach) * (1.0 + EDGE)
        piece = 0
        for b in breaks:
            piece += 1 if b <= mean[i] - amplitude else 0
        force[i], stiffness[i], twice[i] = 0.5 * slopes[piece] * c[0], slopes[piece], 0.0
        if piece == len(breaks) or breaks[piece] > mean[i] + amplitude:  # u stays on one piece
            continue
        for k in range(n):
            u[k] = mean[i] + re[i] * table[0, k] - im[i] * table[1, k] + table[2, k]
        for k in range(n):
            before, after = u[k] - u[k - 1], u[k + 1 if k + 1 < n else 0] - u[k]
            psi[k], torsions[k] = spacing * k, u[k]
            if before * after > 0.0:
                continue
            close = False
            for b in breaks:
                close = close or abs(u[k] - b) <= max(abs(before), abs(after))
            if close:
                for _ in range(4):
                    _, slope, bend = series(mean[i], c, harmonics, psi[k], turns)
                    step = slope / bend if bend != 0.0 else 0.0
                    psi[k] = min(spacing * (k + 0.5), max(spacing * (k - 0.5), psi[k] - step))
                torsions[k] = series(mean[i], c, harmonics, psi[k], turns)[0]
        psi[n] = psi[0] + FULL
        series(mean[i], c, harmonics, psi[n], turns)
        back, total = turns[0].conjugate(), integral(c, harmonics, psi[n], turns)
        piece = 0
        for b in breaks:
            piece += 1 if b <= torsions[0] else 0
        force[i], stiffness[i] = 0.5 * slopes[piece] * c[0], slopes[piece]
        for k in range(n):
            after = torsions[k + 1 if k + 1 < n else 0]
            while (piece < len(breaks) and breaks[piece] <= after) or (piece > 0 and breaks[piece - 1] > after):
                up = piece < len(breaks) and breaks[piece] <= after
                b, rise = breaks[piece] if up else breaks[piece - 1], after - torsions[k]
                first = psi[k] + (psi[k + 1] - psi[k]) * (b - torsions[k]) / rise
                crossing = _crossing(b, rise, first, psi[k], psi[k + 1], mean[i], c, harmonics, turns)
                following = piece + 1 if up else piece - 1
                jump, turn = (slopes[following] - slopes[piece]) / FULL, turns[0].conjugate()
                ramp = total - integral(c, harmonics, crossing, turns) + 1j * (mean[i] - b) / f * (back - turn)
                force[i] += jump * ramp
                stiffness[i] += jump * (psi[n] - crossing)
                twice[i] += jump * 0.5j * (back * back - turn * turn) / f
                piece = following


def grid_table(f: int, harmonics: tuple[int, ...], lines: Floats) -> Floats:
    """Table of `averages`: cos f psi, sin f psi and the sum of the lines, at `POINTS` per period of the highest one."""
    n = POINTS * max(1, f, *harmonics)
    cosine, sine = waves_at(n, (*map(int, lines[:, 0]), f))
    return np.stack([cosine[-1], sine[-1], lines[:, 1] @ cosine[:-1] + lines[:, 2] @ sine[:-1]])
