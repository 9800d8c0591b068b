"""Steady states of a slow flow: by closed form or by a scan of the plane, then Newton; stability by eigenvalues."""

import math
from dataclasses import replace
from typing import Any

import numpy as np

from ...base.results import Floats, SolveError
from ...base.sentences import Sentence, Speed
from .averaging import AveragedFlow
from .cubic import CubicFlow
from .second_order import SecondOrderFlow
from .setting import Complexes

Integrals = AveragedFlow | SecondOrderFlow  # whose fixed points are sought on a grid
Flow = Integrals | CubicFlow
PHASES, ROWS_PER_DECADE = 48, 20  # of the polar grid
# where the phase plays no role: amplitudes per decade, parts of a cell that may hold a root, and most of such cells
RING, FINER, MOST_CELLS = 60, 16, 24
CLEAR = 0.3  # share of the distance to the next fixed point within which a transient is taken to end on one
POINTS = 10_000  # of the polar grid, all speeds counted, at once
BESIDE = np.array([[0.9], [1.0], [1.1]])  # times the middle of a cell: its amplitudes and a little more
EPSILON = float(np.finfo(float).eps)
MOST_ALONE = 60  # fixed points of an undamped flow; more are a continuum


def fixed_points(flow: Flow) -> list[complex]:
    """All nontrivial fixed points z [rad] by descending |z|; copies shifted by whole forcing periods count once."""
    if flow.setting.resonance.ratio is None:
        return []
    if isinstance(flow, CubicFlow):
        places = flow.fixed_points()
        rough = [complex(z) for z in places[np.isfinite(places)]]
    else:
        rough = [*scan(flow), *_weak(flow)] if np.any(flow.setting.hard) else rings(flow)
    if flow.setting.mu == 0.0 and len(rough) > MOST_ALONE:
        raise SolveError(
            Sentence(
                "without damping every small amplitude is a steady state at omega = {}; give the drive damping, or go "
                "to another speed",
                Speed(flow.setting.omega),
            )
        )
    found: list[complex] = []
    copies = np.exp(2j * np.pi * np.arange(flow.setting.copies) / flow.setting.copies)
    for z in rough:
        point = polish(flow, z)
        if point is None or not flow.sound(point):
            continue
        if any(np.min(np.abs(point * copies - other)) < 1e-7 * abs(other) for other in found):
            continue
        found.append(min((complex(point * c) for c in copies), key=lambda w: (round(abs(np.angle(w)), 9), -w.imag)))
    return sorted(found, key=abs, reverse=True)


def _weak(flow: Integrals) -> list[complex]:
    """The state of a nearly linear drive, whose amplitude may lie below all that `scan` covers; none where a = 0 is."""
    z = complex(newton_step(flow.jacobian(0j), np.array(complex(flow.rates(0j)))))
    return [] if is_trivial(flow) or not np.isfinite(z) else [z]


def attractor(flow: Flow, z: complex) -> complex | None:
    """Stable fixed point [rad] next to z, copies included; None unless it is much nearer than any other."""
    s = flow.setting
    if s.resonance.ratio is None:
        return 0j if s.mu > 0.0 else None
    copies = np.exp(2j * np.pi * np.arange(s.copies) / s.copies)
    points = [complex(point * copy) for point in fixed_points(flow) for copy in copies]
    points += [0j] if is_trivial(flow) else []
    points.sort(key=lambda point: abs(point - z))
    if not points or (len(points) > 1 and abs(points[0] - z) > CLEAR * abs(points[1] - z)):
        return None
    return points[0] if is_stable(flow, points[0]) else None


def rates_of(flow: Flow, z: Any) -> tuple[Any, Floats]:
    """What vanishes in a steady state [rad/s], and its derivative (..., 2, 2) to (Re z, Im z)."""
    return (flow.rates(z), flow.jacobian(z)) if isinstance(flow, CubicFlow) else flow.balance(z)


def is_trivial(flow: Flow) -> bool:
    """Whether z = 0 is a fixed point."""
    s = flow.setting
    if s.soft != 0.0:
        return False
    if isinstance(flow, CubicFlow):
        return bool(flow.rates(0j) == 0.0)
    return bool(abs(flow.rates(0j)) <= 1e-13 * s.omega_0 * max(s.scales()) + 30.0 * flow.error * abs(_force(flow)))


def _force(flow: Flow) -> float:
    return float(abs(flow.mean_force(0j))) if isinstance(flow, AveragedFlow) else 0.0


def is_stable(flow: Flow, z: complex) -> bool:
    """Whether all eigenvalues next to a steady state have negative real parts (beyond rounding)."""
    return bool(attracts(flow.stability(z)))


def attracts(matrices: Floats) -> Any:
    """Whether the slow eigenvalues of matrices (..., n, n) have negative real parts (beyond rounding).

    They are the two nearest to 0. With z'' there are two more, near twice the fast speed: the same motions seen from
    the turn the other way, of which nothing slow is known.
    """
    every = np.linalg.eigvals(matrices)
    slow = np.take_along_axis(every, np.argsort(np.abs(every), axis=-1)[..., :2], axis=-1)
    return np.max(slow.real, axis=-1) < -1e-13 * np.max(np.abs(matrices), axis=(-2, -1))


def polish(flow: Flow, z: complex, steps: int = 40) -> complex | None:
    """Newton's method from z; None where it does not converge to a nontrivial point."""
    best, size = z, math.inf
    for _ in range(steps):
        rate, matrix = rates_of(flow, z)
        step = newton_step(matrix, np.asarray(rate))
        if not np.isfinite(step) or z == 0.0:
            break
        if abs(step) < size:
            best, size = z, abs(step)
        elif size < 1e-9 * abs(best):
            break
        z = z + complex(step) * min(1.0, 0.5 * abs(z) / max(abs(step), 1e-300))
    # near a fold rounding in the rates alone moves the point by about sqrt(1e-16); a small z keeps that of hard lines
    rounding = EPSILON * float(np.sum(np.abs(flow.setting.hard)))
    return best if size <= max(1e-7 * abs(best), min(rounding, 1e-3 * abs(best))) else None


def newton_step(matrix: Floats, rate: Any) -> Any:
    """Solve the 2x2 systems matrix (Re dz, Im dz) = -rate; not finite where singular."""
    (a, b), (c, d) = np.moveaxis(matrix, (-2, -1), (0, 1))
    with np.errstate(all="ignore"):
        return (-(d * rate.real - b * rate.imag) - 1j * (a * rate.imag - c * rate.real)) / (a * d - b * c)


def scan(flow: Integrals) -> list[complex]:
    """Find every fixed point of a general flow: cells of a polar grid in which both rates may vanish, then Newton."""
    rough = flow.coarse
    _, z = scanned(rough, amplitudes(rough, ROWS_PER_DECADE))
    return _converged(rough, z)


def scanned(flow: Integrals, sizes: Floats) -> tuple[Any, Complexes]:
    """Middles [rad] of the cells of a polar grid in which both rates may vanish, at one speed or many.

    With the place of each among the speeds. Cells are left out where no state is sound.
    """
    speeds = np.size(flow.setting.omega)
    phases = 2.0 * np.pi * (np.arange(PHASES + 1) + 0.37) / PHASES
    turn = np.exp(-1j * phases)[:, None]
    rows = max(2, POINTS // (turn.size * speeds))
    with np.errstate(all="ignore"):
        polar = np.concatenate(
            [
                (flow.unforced(np.broadcast_to(z, (*z.shape[:2], speeds))) - flow.push) / z
                for z in (a[:, None, None] * turn for a in (sizes[i : i + rows] for i in range(0, len(sizes), rows)))
            ]
        )
    i, j, which = np.nonzero(_may_vanish(polar.real) & _may_vanish(polar.imag))
    z = np.sqrt(sizes[i] * sizes[i + 1]) * np.exp(-0.5j * (phases[j] + phases[j + 1]))
    here = replace(flow, setting=flow.setting.of(which)) if np.ndim(flow.setting.omega) else flow
    with np.errstate(all="ignore"):
        kept = np.any(here.sound(z * BESIDE), axis=0)
    return which[kept], z[kept]


def rings(flow: Integrals) -> list[complex]:
    """Fixed points where no hard line breaks the symmetry: z' = z g(|z|) - push fixes |z g(|z|)|."""
    flow, push = flow.coarse, flow.push

    def excess(a: Floats) -> Floats:
        with np.errstate(all="ignore"):
            return np.asarray(np.abs(flow.unforced(a.astype(complex))) - abs(push))

    a = amplitudes(flow, RING)
    value = excess(a)
    for _ in range(3):  # two roots may lie close together, about an extremum that a coarse grid steps over
        rise = np.diff(value)
        turns = np.flatnonzero(rise[1:] * rise[:-1] <= 0.0) + 1
        crossed = np.flatnonzero(value[1:] * value[:-1] <= 0.0)
        cells = np.unique(np.concatenate([turns - 1, turns, crossed]))
        cells = cells[np.argsort(np.abs(value[cells]))[:MOST_CELLS]]
        inside = np.linspace(a[cells], a[cells + 1], FINER, endpoint=False)[1:].ravel()
        a, place = np.unique(np.concatenate([a, inside]), return_index=True)
        value = np.concatenate([value, excess(inside)])[place]
    near = a[:-1][value[1:] * value[:-1] <= 0.0].astype(complex)
    turn = push * near / flow.unforced(near) if push else near  # z g = push where the rate vanishes
    return _converged(flow, near.real * turn / np.abs(turn))


def _may_vanish(values: Floats) -> Any:
    """Cells whose corner values change sign, or nearly do."""
    corners = np.stack([values[:-1, :-1], values[1:, :-1], values[:-1, 1:], values[1:, 1:]])
    low, high = corners.min(0), corners.max(0)
    slack = 0.3 * (high - low)
    return (low - slack <= 0.0) & (high + slack >= 0.0)


def amplitudes(flow: Integrals, per_decade: int) -> Floats:
    """Logarithmic grid of |z| [rad] that covers the forced amplitudes and those on the backbone."""
    s = flow.setting
    scales = s.scales()
    wide = max(scales) * np.geomspace(1e-5, 1e5, 301)
    phases = np.exp(2j * np.pi * (np.arange(8 if np.any(s.hard) else 1) + 0.2) / 8)
    with np.errstate(all="ignore"):
        off = np.mean((flow.unforced(wide[:, None] * phases) / phases).imag, axis=1) / wide
        crossings = wide[:-1][np.isfinite(off[1:]) & (off[1:] * off[:-1] <= 0.0)]
    scales += [float(a) for a in crossings]
    drive = abs(complex(flow.rates(0j)))
    if drive > 1e-13 * s.omega_0 * max(scales):
        # a weak drive, as C^3 in a superharmonic, gives small amplitudes: the linear one, and the one at resonance
        linear = abs(complex(newton_step(flow.jacobian(0j), np.array(flow.rates(0j)))))
        scales += [a for a in (linear, 2.0 * drive / s.mu if s.mu > 0.0 else math.inf) if 0.0 < a < math.inf]
    decades = math.log10(max(scales) / min(scales)) + 2.5
    return np.asarray(np.geomspace(min(scales) / 18.0, 18.0 * max(scales), math.ceil(per_decade * decades)))


def _converged(flow: Integrals, z: Complexes) -> list[complex]:
    """Newton from many starts at once; distinct limits only."""
    size = np.full(z.shape, np.inf)
    with np.errstate(all="ignore"):
        for _ in range(25):
            rate, matrix = rates_of(flow, z)
            step = newton_step(matrix, rate)
            step = np.where(np.isfinite(step), step, 0.1 * z)
            size = np.abs(step) / np.abs(z)
            z = z + step * np.minimum(1.0, 0.5 / size)
            if np.all((size < 1e-12) | ~np.isfinite(size)):
                break
    found: list[complex] = []
    for point in z[size < 1e-3]:
        if all(abs(point - other) > 1e-6 * abs(other) for other in found):
            found.append(complex(point))
    return found
