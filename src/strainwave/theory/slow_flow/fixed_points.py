"""Search for steady states of a slow flow: a scan of the plane, a step of Newton's method, stability."""

import math
from dataclasses import replace
from typing import Any

import numpy as np

from ...base.results import Complexes, Floats
from ...numerics.balance.piecewise import pieces_of
from .averages.memory import remembers
from .averages.varying import varies
from .averaging import ERRORS_OF_AVERAGES, ROUNDING, AveragedFlow
from .closed_forms import CubicFlow
from .second_order import SecondOrderFlow
from .setting import Setting

Integrals = AveragedFlow | SecondOrderFlow  # whose fixed points are sought on a grid
Flow = Integrals | CubicFlow
PHASES, ROWS_PER_DECADE = 48, 20  # of the polar grid
RING = 60  # amplitudes per decade where the phase plays no role
POINTS = 10_000  # of the polar grid, all speeds counted, at once
BESIDE = np.array([[0.9], [1.0], [1.1]])  # times the middle of a cell: its amplitudes and a little more


def is_trivial(flow: Flow) -> bool:
    """True if z = 0 is a fixed point."""
    s = flow.setting
    if s.soft != 0.0:
        return False
    if isinstance(flow, CubicFlow):
        return bool(flow.rates(0j) == 0.0)
    force = float(abs(flow.mean_force(0j))) if isinstance(flow, AveragedFlow) else 0.0
    noise = ROUNDING * s.omega_0 * max(s.scales()) + ERRORS_OF_AVERAGES * flow.error * force
    return bool(abs(flow.rates(0j)) <= noise)


def is_stable(flow: Flow, z: complex) -> bool:
    """True if all eigenvalues next to a steady state have negative real parts (beyond rounding)."""
    return bool(attracts(flow.stability(z)))


def are_stable(flow: Flow, omega: Floats, z: Complexes) -> Any:
    """Stability (n,) of steady states (n,) at speeds (n,) [rad/s]: one by one where averages hold at one speed."""
    s = flow.setting
    one_speed = isinstance(flow, AveragedFlow) and (np.any(s.hard) or varies(s.system))
    if remembers(s.system.law) or one_speed:
        return [is_stable(flow.at(float(speed)), complex(state)) for speed, state in zip(omega, z, strict=True)]
    return attracts(flow.at(omega).stability(z))


def attracts(matrices: Floats) -> Any:
    """True if the slow eigenvalues of matrices (..., n, n) have negative real parts (beyond rounding).

    They are the two nearest to 0. With z'' there are two more, near twice the fast speed: the same motions seen from
    the turn the other way, of which nothing slow is known.
    """
    every = np.linalg.eigvals(matrices)
    slow = np.take_along_axis(every, np.argsort(np.abs(every), axis=-1)[..., :2], axis=-1)
    return np.max(slow.real, axis=-1) < -ROUNDING * np.max(np.abs(matrices), axis=(-2, -1))


def newton_step(matrix: Floats, rate: Complexes) -> Any:
    """Solve the 2x2 systems matrix (Re dz, Im dz) = -rate; not finite where singular."""
    (a, b), (c, d) = np.moveaxis(matrix, (-2, -1), (0, 1))
    with np.errstate(all="ignore"):
        return (-(d * rate.real - b * rate.imag) - 1j * (a * rate.imag - c * rate.real)) / (a * d - b * c)


def scan(flow: Integrals, sizes: Floats) -> tuple[Any, Complexes]:
    """Scan a polar grid of amplitudes [rad] for cells in which both rates may vanish, at one speed or many.

    Returns the place of each cell among the speeds, and its middle [rad]. Cells are left out where no state is sound,
    and amplitudes at which the torsion stays on one piece of the law: a damped drive has one state there, that of the
    linear equation.
    """
    sizes = sizes[max(0, np.count_nonzero(sizes < _on_one_piece(flow.setting)) - 1) :]
    speeds = np.size(flow.setting.omega)
    phases = 2.0 * np.pi * (np.arange(PHASES + 1) + 0.37) / PHASES
    turn = np.exp(-1j * phases)[:, None]
    rows = max(2, POINTS // (turn.size * speeds))
    relative_rates = []
    with np.errstate(all="ignore"):
        for first in range(0, len(sizes), rows):
            z = sizes[first : first + rows, None, None] * turn
            rates = flow.unforced(np.broadcast_to(z, (*z.shape[:2], speeds))) - flow.push
            relative_rates.append(rates / z)
    polar = np.concatenate(relative_rates)
    i, j, index = np.nonzero(_may_vanish(polar.real) & _may_vanish(polar.imag))
    z = np.sqrt(sizes[i] * sizes[i + 1]) * np.exp(-0.5j * (phases[j] + phases[j + 1]))
    flows = replace(flow, setting=flow.setting.of(index)) if np.ndim(flow.setting.omega) else flow
    with np.errstate(all="ignore"):
        kept = np.any(flows.sound(z * BESIDE), axis=0)
    return index[kept], z[kept]


def _on_one_piece(s: Setting) -> float:
    """Amplitude [rad] up to which a damped motion at every speed stays where the law is linear; 0 where nowhere."""
    pieces = None if s.mu == 0.0 or remembers(s.system.law) or varies(s.system) else pieces_of(s.system.law)
    if pieces is None:
        return 0.0
    return float(np.min(np.abs(pieces.breaks - s.u0))) - float(np.max(np.sum(np.abs(s.hard), axis=-1)))


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
    wide = max(scales) * np.geomspace(1e-5, 1e5, 101)
    phases = np.exp(2j * np.pi * (np.arange(8 if np.any(s.hard) else 1) + 0.2) / 8)
    with np.errstate(all="ignore"):
        off = np.mean((flow.unforced(wide[:, None] * phases) / phases).imag, axis=1) / wide
        crossings = wide[:-1][np.isfinite(off[1:]) & (off[1:] * off[:-1] <= 0.0)]
    scales += [float(a) for a in crossings]
    drive = abs(complex(flow.rates(0j)))
    if drive > ROUNDING * s.omega_0 * max(scales):
        # a weak drive, as C^3 in a superharmonic, gives small amplitudes: the linear one, and the one at resonance
        linear = abs(complex(newton_step(flow.jacobian(0j), np.array(flow.rates(0j)))))
        scales += [a for a in (linear, 2.0 * drive / s.mu if s.mu > 0.0 else math.inf) if 0.0 < a < math.inf]
    decades = math.log10(max(scales) / min(scales)) + 2.5
    return np.asarray(np.geomspace(min(scales) / 18.0, 18.0 * max(scales), math.ceil(per_decade * decades)))
