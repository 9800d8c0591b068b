"""Where multiple scales hold: their error against harmonic balance, over speed and strength of the excitation.

At every speed and strength the stable steady states of largest amplitude of both orders are moved to true motions at
that speed by Newton's method (7 harmonics of the fastest component; Krack & Gross 2019, Harmonic Balance for Nonlinear
Vibration Problems, ch. 2). True motions also start from those of the neighbouring cells, so that a motion which both
orders miss is met as well. The largest stable one of them is what the orders are compared with.
"""

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ...quantities import numbers, shown
from ...results import Floats
from ...theory.slow_flow.certificate.balance import Balance, balance_of, corrected
from ...theory.slow_flow.multiple_scales import slow_flow
from ...theory.slow_flow.resonance import Resonance
from ...theory.slow_flow.setting import Complexes
from ...theory.slow_flow.states import states
from .validity_results import ORDERS, ValidityMap

TOGETHER = 500  # cells in one step of Newton's method: a user can interrupt between
LARGER = 1.05  # times the own motion: a neighbour's motion is then tried in a cell
MOST_SPREADS = 400  # rounds of such trials
REST = 1e-6  # of the whole motion: a component near omega_0 below it is absent


def validity_map(system: Any, resonance: Resonance, speeds: ArrayLike, amplitudes: ArrayLike) -> ValidityMap:
    """Where each order of multiple scales holds, over speed and strength of the excitation of a drive.

    Parameters
    ----------
    system : Oscillator
        The drive; its own omega is ignored.
    resonance : Resonance
        p omega ~ q omega_0 on the base angle.
    speeds : (n,) array_like
        Speeds of the base angle [rad/s], positive, in rising order.
    amplitudes : (m,) array_like
        Factors of every line of the system's torque and kinematic error, positive, in rising order; 1 is the system as
        it is. The mean torque stays.

    Returns
    -------
    ValidityMap
        The error of both orders in the amplitude of the component near omega_0.

    Raises
    ------
    ValueError
        If the axes are not positive and rising, or the slow flow refuses the system at a speed.
    """
    speeds, amplitudes = axis("speeds [rad/s]", speeds), axis("amplitudes", amplitudes)
    near = system._replace(omega=float(speeds[len(speeds) // 2]))
    flows = [slow_flow(near, resonance, order=order)._flow for order in ORDERS]
    for w in speeds.tolist():
        flows[0].setting.refuse_on_resonance(w)
    omega, factor = (grid.ravel() for grid in np.meshgrid(speeds, amplitudes, indexing="ij"))
    shape = len(speeds), len(amplitudes)
    everywhere = flows[0].setting.scaled(factor).at(omega)
    cells = _Cells(replace(balance_of(flows[0].setting), setting=everywhere), omega)
    motions = []
    for flow in flows:
        z = states(flow, omega, factor).largest_stable()
        motions.append(_motion(cells, replace(flow, setting=everywhere), z))
        cells.improve(np.flatnonzero(np.isfinite(z)), motions[-1])
    cells.spread(shape)
    error = np.stack([cells.error(motion).reshape(shape) for motion in motions])
    return ValidityMap(str(resonance.checked()), speeds, amplitudes, error, cells.size().reshape(shape))


def axis(name: str, values: ArrayLike) -> Floats:
    """Positive numbers in rising order, or a sentence (ValueError)."""
    found = numbers(name, values)
    if not (np.all(found > 0.0) and np.all(np.diff(found) > 0.0)):
        raise ValueError(f"{name} are {shown(values)}; they must be positive and in rising order")
    return found


def _motion(cells: "_Cells", flow: Any, z: Complexes) -> Complexes:
    """Coefficients (cells, H+1) of the motions of a flow; not finite where there is no state."""
    return np.where(np.isfinite(z)[:, None], cells.balance.motion(flow, z), np.nan)


class _Cells:
    """The true motions of all cells: the largest stable one that was met so far."""

    def __init__(self, balance: Balance, omega: Floats) -> None:
        self.balance, self.omega = balance, omega
        self.c = np.full((len(omega), balance.harmonics + 1), np.nan + 0j)

    def size(self) -> Floats:
        """Amplitude [rad] of the component near omega_0; 0 where there is none, or no true motion was met."""
        return np.asarray(np.nan_to_num(np.abs(self.c[:, self.balance.fast])))

    def improve(self, which: Any, motion: Complexes) -> Any:
        """Start from motions (all cells) in some cells; return in which a larger stable motion was met."""
        better = [self._improve(part, motion[part]) for part in np.array_split(which, len(which) // TOGETHER + 1)]
        return np.concatenate(better)

    def _improve(self, which: Any, start: Complexes) -> Any:
        if not len(which):
            return which
        balance, omega = self.balance.of(which), self.omega[which]
        found = corrected(balance, start, omega, None)
        good = np.flatnonzero(found.converged)
        good = good[balance.of(good).holds_still(found.c[good], omega[good])] if len(good) else good
        where, c = which[good], found.c[good]
        fast = self.balance.fast
        missing = ~np.isfinite(self.c[where, fast])
        larger = missing | (np.abs(c[:, fast]) > (1.0 + REST) * np.nan_to_num(np.abs(self.c[where, fast])))
        self.c[where[larger]] = c[larger]
        return where[larger]

    def spread(self, shape: tuple[int, int]) -> None:
        """Try the motions of neighbouring cells where these are larger, until nothing changes."""
        new = np.arange(len(self.omega))
        cell = np.arange(len(self.omega)).reshape(shape)
        for _ in range(MOST_SPREADS):
            changed = np.zeros(len(self.omega), bool)
            changed[new] = True
            size, new = self.size(), np.zeros(0, int)
            for here, there in (
                (cell[1:], cell[:-1]),
                (cell[:-1], cell[1:]),
                (cell[:, 1:], cell[:, :-1]),
                (cell[:, :-1], cell[:, 1:]),
            ):
                mine, its = here.ravel(), there.ravel()
                try_it = changed[its] & (size[its] > LARGER * size[mine])
                start = np.full_like(self.c, np.nan)
                start[mine[try_it]] = self.c[its[try_it]]
                new = np.union1d(new, self.improve(mine[try_it], start))
            if not len(new):
                break

    def error(self, motion: Complexes) -> Floats:
        """Relative error of motions: of the component near omega_0, or where it is absent of the whole; at most 1."""
        fast = self.balance.fast
        mine, its = np.abs(motion[:, fast]), np.abs(self.c[:, fast])
        whole = np.linalg.norm(self.c[:, 1:], axis=1)
        off = np.linalg.norm(motion - self.c, axis=1)
        with np.errstate(all="ignore"):
            rest = (mine <= REST * whole) & (its <= REST * whole)
            error = np.where(rest, off / whole, np.abs(mine - its) / its)
        return np.where(np.isfinite(error), np.minimum(error, 1.0), 1.0)
