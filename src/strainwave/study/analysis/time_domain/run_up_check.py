"""Run-up and run-down of an error equation by integration: an independent check of its response curve at a few speeds.

Each simulation starts from the exact motion at a neighbouring speed, the one before in the direction of the sweep, and
ends on a motion that a closed orbit of the integrated equation confirms.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ....base.protocols import System
from ....base.results import Branch, Floats, SolveError
from ....base.terminal import silent
from ....drive.drive_response import DriveResponse
from ....drive.equation.gear_torque import loses_energy, settling_time
from ....numerics.balance.fourier import with_velocity
from ....numerics.integration.methods import Dopri5
from ....numerics.steady import SteadyMotion, settle, settled
from ...speed_map.error_equation import OperatingPoint

CHECKS, BEYOND_CHECKS = 8, 4  # speeds per direction on the curve, and where the curve has no stable motion to follow
FOLD_GAP = 0.003  # relative distance in speed within which motions settle too slowly to be a check
TOLERANCE = Dopri5(rtol=1e-8, atol=1e-13)


@dataclass(frozen=True, eq=False)
class RunUp:
    """Simulated steady motions at a few speeds, by ascending speed.

    Attributes
    ----------
    up, down : tuple of SteadyMotion
        Motions reached from below and from above.
    curve_up, curve_down : (n,) arrays
        Largest |x| [rad] of the response curve at the same speeds; nan where it has none to compare with.
    """

    up: tuple[SteadyMotion, ...]
    down: tuple[SteadyMotion, ...]
    curve_up: Floats
    curve_down: Floats

    def worst(self) -> SteadyMotion | None:
        """The motion with the largest |x| among those that the simulation reached; None without any."""
        return max((m for m in (*self.up, *self.down) if m.status), key=lambda motion: motion.peak, default=None)

    def difference(self) -> float | None:
        """Largest difference between the peaks of simulated motions that repeat and exact ones, relative to these.

        None where there is nothing to compare.
        """
        motions = (*self.up, *self.down)
        exact = np.concatenate([self.curve_up, self.curve_down])
        errors = [abs(m.peak / e - 1.0) for m, e in zip(motions, exact, strict=True) if m.closed and np.isfinite(e)]
        return max(errors) if errors else None


def run_up_and_down(
    system: Any,
    speeds: tuple[float, float],
    exact: DriveResponse,
    point: OperatingPoint,
    progress: Callable[[float], None] = silent,
) -> RunUp:
    """Simulate up and down; `progress` is told the finished share after each speed.

    Parameters
    ----------
    system : Oscillator
        The error equation; its omega is replaced.
    speeds : (float, float)
        Range of the base-angle speed [rad/s].
    exact : DriveResponse
        Where the simulations start, and what they are compared with.
    point : OperatingPoint
        Where a simulation starts that has no motion to start from.
    """
    sides = []
    for share, upwards in ((0.0, True), (0.5, False)):
        visits = _visits(exact, speeds, upwards)
        motions: list[SteadyMotion] = []
        for omega, start, _ in visits:
            turning = system._replace(omega=omega)
            resting = motions[-1].end if motions and motions[-1].status and loses_energy(system) else point.start
            motions.append(_settled(turning, resting if start is None else (*_state(exact.curve, start), *resting[2:])))
            progress(share + 0.5 * len(motions) / len(visits))
        peaks = np.array([math.nan if index is None else exact.curve.peak[index] for _, _, index in visits])
        order = slice(None) if upwards else slice(None, None, -1)
        sides.append((tuple(motions[order]), peaks[order]))
    (up, curve_up), (down, curve_down) = sides
    if not any(motion.status for motion in (*up, *down)):
        raise SolveError(f"no simulated speed reached a steady motion: {up[0].message}")
    return RunUp(up, down, curve_up, curve_down)


def _visits(
    exact: DriveResponse, speeds: tuple[float, float], upwards: bool
) -> list[tuple[float, int | None, int | None]]:
    """Speeds [rad/s] of one direction in order, with the points of the curve to start from and to arrive at."""
    first, last = speeds if upwards else speeds[::-1]
    path = np.empty(0, int)
    if exact.sweep is not None:
        path = exact.sweep.run_up if upwards else exact.sweep.run_down
        inside = (exact.curve.omega[path] >= speeds[0]) & (exact.curve.omega[path] <= speeds[1])
        path = path[inside]
    if len(path) < CHECKS:
        return [(float(omega), None, None) for omega in np.linspace(first, last, CHECKS)]
    omega, peak = exact.curve.omega[path], exact.curve.peak[path]
    arc = np.cumsum(np.hypot(np.diff(omega) / (speeds[1] - speeds[0]), np.diff(peak) / (np.max(peak) or 1.0)))
    places = np.minimum(1 + np.searchsorted(arc, arc[-1] * (np.arange(CHECKS) + 0.5) / CHECKS), len(path) - 1)
    folds = np.array([fold.omega for fold in exact.curve.folds])
    clear = np.array([np.all(np.abs(folds / w - 1.0) > FOLD_GAP) for w in omega])
    later = [np.flatnonzero(clear[i:])[:1] + i for i in np.unique(places)]
    visits: list[tuple[float, int | None, int | None]] = [
        (float(omega[i]), int(path[i - 1]), int(path[i])) for i in np.unique(np.concatenate(later))
    ]
    if abs(last - omega[-1]) > 1e-3 * (speeds[1] - speeds[0]):  # the sweep ends where stability does
        visits += [(float(w), None, None) for w in np.linspace(omega[-1], last, BEYOND_CHECKS + 1)[1:]]
    return visits


def _state(curve: Branch, index: int) -> tuple[float, float]:
    """State (x [rad], x' [rad/s]) of a point of the curve at base angle 0."""
    series = with_velocity(curve.coefficients[index], float(curve.omega[index]))
    x, v = series[0] + np.sum(series[1::2], axis=0)
    return float(x), float(v)


def _settled(system: System, state: tuple[float, ...]) -> SteadyMotion:
    """Motion that a simulation from `state` ends on: of period 1, or 2 or 3 where that does not close."""
    if not loses_energy(system):
        return settle(system, state, time=settling_time(system), close=False, method=TOLERANCE)
    motion = settled(system, state, time=settling_time(system), method=TOLERANCE)
    if motion.closed or not motion.status:
        return motion
    for period in (2, 3):
        longer = settle(system, motion.end, time=0.0, period=period, method=TOLERANCE)
        if longer.closed:
            return longer
    return motion
