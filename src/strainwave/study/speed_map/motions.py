"""Every stable steady motion of a drive under one load: curves, and how large the error is on them.

A curve is cut into runs of stable motions along which the speed rises or falls only; between its points it is the
monotonic cubic (PCHIP) over the length of the curve, so that no peak is higher than the points that harmonic balance
found.
"""

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...base.results import Branch, Floats
from ...base.series import largest_size
from ...drive.drive_response import DriveResponse
from ...drive.jumps import pieces_of

SLOW_SHARE = 1e-3  # share of a motion by which it repeats later than what drives it
FINER_POINTS = 8  # places on a curve between two of its points
OMEGA, OSCILLATION, TORQUE, LOW, HIGH, MOTOR, RMS, SMALLEST, MEAN = range(9)  # columns of a run


class LooseMotion(NamedTuple):
    """Motion of a trajectory that no curve has: speed [rad/s], oscillation [rad] and torque [N*m]."""

    omega: float
    oscillation: float
    torque: float
    turns: int


@dataclass(frozen=True, eq=False)
class MotionCurve:
    """One curve of steady motions.

    Attributes
    ----------
    response : DriveResponse
        Its points, with stability and torques.
    every : int
        How often in a turn of the motor all that drives the motions repeats.
    """

    response: DriveResponse
    every: int = 1

    @property
    def branch(self) -> Branch:
        """Its points, with stability."""
        return self.response.curve

    @cached_property
    def subharmonic(self) -> bool:
        """True if its motions take longer to repeat than what drives them."""
        h = self.branch.coefficients.shape[1] // 2
        waves = np.hypot(self.branch.coefficients[:, 1::2], self.branch.coefficients[:, 2::2])
        slow = np.arange(1, h + 1) % (self.turns * self.every) > 0
        return bool(np.max(np.linalg.norm(waves[:, slow], axis=1)) > SLOW_SHARE * np.max(np.linalg.norm(waves, axis=1)))

    @property
    def turns(self) -> int:
        """Turns of the motor that a motion takes."""
        return int(self.branch.period)

    @cached_property
    def table(self) -> Floats:
        """Speed, oscillation, torque, least and largest error, peak and rms of the motor's torque (n, 9) of points.

        The last columns are the oscillation of the smallest turn and the cubic mean of the torque. Where motions beat
        the least and largest errors are those of what repeats with every turn.
        """
        low, high = extremes(self.branch.coefficients)
        torque, of_motor = self.response.torque, (self.response.motor_torque, self.response.motor_rms)
        motor = [0.0 * torque if size is None else size for size in of_motor]
        envelope, largest = self.branch.envelope, self.branch.oscillation
        smallest = largest if envelope is None else envelope[:, 1]
        return np.column_stack(
            [self.branch.omega, largest, torque, low, high, *motor, smallest, self.response.mean_torque]
        )

    @cached_property
    def runs(self) -> tuple[Floats, ...]:
        """Tables (m, 9) of the stable runs of the curve, each with rising speed."""
        return tuple(finer(self.table[run]) for run in stable_runs(self.branch))

    def rows_at(self, omega: float) -> list[Floats]:
        """Rows (9,) of the stable motions of this curve at a speed [rad/s]."""
        return [row_at(run, omega) for run in self.runs if run[0, OMEGA] <= omega <= run[-1, OMEGA]]


@dataclass(frozen=True, eq=False)
class LoadMotions:
    """Motions of a drive under one load, over the range of speeds.

    Attributes
    ----------
    load : float
        The load: torque [N*m] or inertia [kg*m^2].
    curves : tuple of MotionCurve
        The main curve first.
    quasi_static : float
        Oscillation [rad] of a drive that turns slowly.
    jumps : tuple of (float, bool, bool)
        Speed [rad/s] of every jump of a slow run-up or run-down, whether it is of the run-up, and whether the error is
        larger after it.
    jumping : tuple of (float, float)
        Speeds [rad/s] between which a slow run-up and run-down are on different motions, and one of them jumps.
    flips : tuple of (float, float)
        Speeds [rad/s] at which the motion that a slow run-up or run-down comes to repeats after more turns, or is left.
    doubled : tuple of (float, float)
        Speeds [rad/s] between which the main curve repeats after more than one turn.
    loose : tuple of LooseMotion
        Motions on which trajectories settled and that no curve has.
    remarks : tuple of str
        What a reader must know, in sentences.
    """

    load: float
    curves: tuple[MotionCurve, ...]
    quasi_static: float
    jumps: tuple[tuple[float, bool, bool], ...] = ()
    jumping: tuple[tuple[float, float], ...] = ()
    flips: tuple[tuple[float, float], ...] = ()
    doubled: tuple[tuple[float, float], ...] = ()
    loose: tuple[LooseMotion, ...] = ()
    remarks: tuple[str, ...] = field(default=())

    @cached_property
    def runs(self) -> list[tuple[Floats, bool]]:
        """Every stable run, and whether its motions are subharmonic."""
        return [(run, curve.subharmonic) for curve in self.curves for run in curve.runs]

    @property
    def largest(self) -> tuple[float, float]:
        """Speed [rad/s] and oscillation [rad] of the largest stable motion; nan and 0 where none is known."""
        tops = [run[np.argmax(run[:, OSCILLATION])] for run, _ in self.runs]
        sizes = [(float(row[OMEGA]), float(row[OSCILLATION])) for row in tops]
        sizes += [(one.omega, one.oscillation) for one in self.loose]
        return max(sizes, key=lambda pair: pair[1], default=(float("nan"), 0.0))

    def rows_at(self, omega: float) -> list[Floats]:
        """Rows of all stable motions at a speed [rad/s]."""
        return [row for curve in self.curves for row in curve.rows_at(omega)]


def extremes(coefficients: Floats) -> tuple[Floats, Floats]:
    """Least and largest value (n,) over a period of series (n, 2H+1)."""
    shifted, mean = coefficients.copy(), coefficients[:, 0]
    shifted[:, 0] = span = np.sum(np.abs(coefficients[:, 1:]), axis=1)  # moved so far that no value has the other sign
    above = largest_size(shifted) - span
    shifted[:, 0] = -span
    return mean - (largest_size(shifted) - span), mean + above


def stable_runs(branch: Branch) -> list[NDArray[np.int64]]:
    """Runs of points of a branch that are stable, their speeds rising; special points may end a run."""
    runs, omega = pieces_of(branch, branch.stable), branch.omega
    return [run if omega[run[-1]] > omega[run[0]] else run[::-1] for run in runs]


def finer(table: Floats) -> Floats:
    """A run with more places on it, over the length of the curve."""
    if len(table) < 3:
        return table
    scaled = table / np.maximum(np.ptp(table, axis=0), 1e-300)
    steps = np.linalg.norm(np.diff(scaled[:, :TORQUE], axis=0), axis=1)
    kept = np.concatenate([[True], steps > 1e-12])
    table, steps = table[kept], steps[kept[1:]]
    if len(table) < 3:
        return table
    h, rise = steps[:, None], np.diff(table, axis=0)
    slopes, share = _monotone_slopes(h, rise / h), (np.arange(FINER_POINTS) / FINER_POINTS)[:, None]
    first, last = ((h * side)[:, None] for side in (slopes[:-1], slopes[1:]))
    rise = rise[:, None]
    within = share * (first + share * (3.0 * rise - 2.0 * first - last + share * (first + last - 2.0 * rise)))
    return np.concatenate([(table[:-1, None] + within).reshape(-1, table.shape[1]), table[-1:]])


def _monotone_slopes(h: Floats, secants: Floats) -> Floats:
    """Slopes (n, k) of a monotone cubic by the secants between its places, of lengths h (n - 1, 1).

    Fritsch & Butland 1984, SIAM J. Sci. Stat. Comput. 5(2), 300-304, eq. (5); at the ends the three-point formula of
    Moler 2004, Numerical Computing with MATLAB, sec. 3.6. SciPy's takes longer to load than a response is computed.
    """
    left, right = secants[:-1], secants[1:]
    w0, w1 = h[:-1] + 2.0 * h[1:], 2.0 * h[:-1] + h[1:]
    same = left * right > 0.0
    inner = np.zeros_like(left)
    np.divide((w0 + w1) * left * right, w0 * right + w1 * left, out=inner, where=same)

    def end(a: Floats, b: Floats, d: Floats, e: Floats) -> Floats:
        slope = ((2.0 * a + b) * d - a * e) / (a + b)
        slope = np.where((d * e <= 0.0) & (np.abs(slope) > 3.0 * np.abs(d)), 3.0 * d, slope)
        return np.where(slope * d > 0.0, slope, 0.0)

    first, last = end(*h[:2], *secants[:2]), end(*h[:-3:-1], *secants[:-3:-1])
    return np.concatenate([first[None], inner, last[None]])


def row_at(run: Floats, omega: Any) -> Floats:
    """Row (9,) of a run at a speed, or rows (n, 9) at speeds."""
    return np.stack([np.interp(omega, run[:, OMEGA], run[:, j]) for j in range(run.shape[1])], axis=-1)
