"""A drive in time: run-up and run-down by integration, and a constant speed until the motion repeats.

The run-up is an independent check of the response curve at a few speeds. Each simulation starts from the exact motion
at a neighbouring speed, the one before in the direction of the sweep, and ends on a motion that a closed orbit of the
integrated equation confirms.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, ClassVar, NamedTuple

import numpy as np

from ...base.protocols import System
from ...base.quantities import number
from ...base.records import Along, Result
from ...base.results import Branch, Floats, SolveError, Trajectory, largest_between
from ...base.sentences import Angle, Sentence, Speed
from ...base.series import largest_of_samples
from ...base.terminal import on_screen, silent
from ...base.units import RPM
from ...drive.drive_response import DriveResponse
from ...drive.equation.gear_torque import loses_energy, settling_time
from ...drive.project import Project
from ...drive.run import drive_run, waiting
from ...drive.train_curve import at_load, refuse_free, torque_in
from ...model.train.drive_train import DriveTrain
from ...model.train.train_forms import behind_gear
from ...numerics.balance.fourier import with_velocity
from ...numerics.curves.torus_motion import BESIDE, largest_in_turns, largest_of_turns
from ...numerics.integration.methods import Dopri5
from ...numerics.integration.record import uninterrupted
from ...numerics.integration.simulate import simulate
from ...numerics.steady import SteadyMotion, settle, settled
from ..speed_map.resonances import OperatingPoint, operating_point

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


TURN_SAMPLES = 512  # samples of a turn of the motor


class Beat(NamedTuple):
    """A motion that beats, turn by turn of the motor, until motor and output stand as before.

    Attributes
    ----------
    omega : float
        Speed of the motor [rad/s].
    turns : float
        Turns of the motor in a beat.
    balanced, integrated : (n,) arrays
        Largest |error - mean| [rad] over a turn that begins in each turn, by the balance and by integration from its
        state at angle 0, with the corners of the law; no integration of a free motor, of which nothing holds the speed.
    """

    omega: float
    turns: float
    balanced: Floats
    integrated: Floats

    @property
    def period(self) -> float:
        """Period [s]."""
        return 2.0 * math.pi * self.turns / self.omega

    @property
    def difference(self) -> float | None:
        """Largest difference of a turn by integration, relative to the largest turn; None without one."""
        has_turns = len(self.integrated) > 0
        return float(np.max(np.abs(self.integrated - self.balanced)) / np.max(self.balanced)) if has_turns else None


def beat_of(project: Project, response: DriveResponse) -> Beat | None:
    """The largest of the motions of a curve that a slow run-up or run-down meets; None where they do not beat."""
    waves, beat, train, top = response.curve.waves, response.curve.beat, project.whole, response.top
    if waves is None or beat is None or train is None or response.starts is None:
        return None
    omega, ratio = float(response.omega[top]), train.N
    balanced, integrated = largest_in_turns(waves.amplitudes[[top]], waves.pairs, ratio)[0], np.empty(0)
    if not train.motor.free:
        turns = np.arange(1, len(balanced) + 2)
        angles = 2.0 * np.pi / TURN_SAMPLES * np.arange(TURN_SAMPLES * (len(turns) + 2) + BESIDE + 1)
        run = drive_run(train._replace(omega=omega), response.starts[top], angles / omega)
        if run.trajectory.status:
            total = np.append(0.0, np.cumsum(run.pointing[1:] + run.pointing[:-1])) / (2.0 * TURN_SAMPLES)
            samples = TURN_SAMPLES * turns[:, None] + np.arange(-BESIDE, TURN_SAMPLES + BESIDE + 1)
            means = (total[TURN_SAMPLES:] - total[:-TURN_SAMPLES])[samples]
            integrated = np.roll(largest_of_turns(run.pointing[samples][None], means[None])[0], 1)
    return Beat(omega, beat, balanced, integrated)


SHOWN_TURNS, BLOCK_TURNS, MOST_BLOCKS = 12, 60, 8  # turns: of the settled motion, and waited for at most so many times
SAMPLES, PER_CYCLE = 96, 48  # of a turn at least, and of a cycle of the highest order
REPEAT_TOLERANCE = 1e-5  # of the range of the error: a smaller change from one turn to the next is none
METHOD = Dopri5(rtol=1e-9, atol=1e-13)


@dataclass(frozen=True, eq=False)
class DriveMotion(Result):
    """A drive at a constant speed, whose motion was integrated until it repeats with every turn.

    Attributes
    ----------
    omega : float
        Speed of the base angle [rad/s].
    load_torque : float
        Mean torque [N*m] on the load. A torque that follows the load's own angle, gravity for one, is left out: it
        repeats once in N turns of the motor.
    t, error, rate, torque : (n,) arrays
        Time [s], error [rad] as of `DriveResponse`, its rate [rad/s] and torque in the gear [N*m, output side] over the
        last 12 turns.
    begun : Trajectory
        From rest, where the mean torques hold the drive, over the first 60 turns: error and rate are its first states.
    turns : int
        Turns before the last ones.
    change : float
        Largest change [rad] of the error from one of the last turns to the next; 0 where the motion repeats.
    has_reference : bool
        Whether the error is the pointing error of the load; else it is that between motor and load.
    loads : (float, float) or None
        Least and largest torque [N*m] of a load that has more than the one of this motion.
    """

    omega: float
    load_torque: float
    t: Floats
    error: Floats
    rate: Floats
    torque: Floats
    begun: Trajectory
    turns: int
    change: float
    has_reference: bool = True
    loads: tuple[float, float] | None = None

    rows: ClassVar[str] = "t"
    arrays: ClassVar[Along] = {"t": {"error": "rad", "rate": "rad/s", "torque": "N*m"}}
    places: ClassVar[Along] = {"t": {"t": "s"}}

    @property
    def name(self) -> str:
        """Name of the error."""
        return "pointing error" if self.has_reference else "error between motor and load"

    @property
    def per_turn(self) -> int:
        """Samples of a turn."""
        return (len(self.t) - 1) // SHOWN_TURNS

    @property
    def mean(self) -> float:
        """Mean [rad] of the error."""
        return float(np.mean(self.error[:-1]))

    @property
    def oscillation(self) -> float:
        """Largest |error - mean| [rad], between the samples too."""
        return self._largest(self.mean)

    @property
    def peak(self) -> float:
        """Largest |error| [rad], between the samples too."""
        return self._largest(0.0)

    @property
    def peak_torque(self) -> float:
        """Largest size of the torque in the gear [N*m] over the last turn."""
        return float(largest_of_samples(self.torque[None, -1 - self.per_turn : -1])[0])

    def _largest(self, origin: float) -> float:
        x, v = self.error - origin, self.rate
        return largest_between(np.diff(self.t), x[:-1], v[:-1], x[1:], v[1:])

    @property
    def remark(self) -> str:
        """Reason for which the motion does not repeat with every turn; empty where it does."""
        if not self.change:
            return ""
        return Sentence(
            "after {} turns the motion does not repeat with every turn: the error changes by up to {} % of its range",
            self.turns, f"{100.0 * self.change / float(np.ptp(self.error)):.2g}",
        )  # fmt: skip

    @property
    def said(self) -> Sentence:
        """Its sizes."""
        sizes = map(Angle, (self.oscillation, self.mean, self.peak))
        return Sentence("oscillation {} about a mean of {}, largest size {}", *sizes)

    def __str__(self) -> str:
        alone = ""
        if self.loads is not None:
            low, high = self.loads
            alone = f"\n  the torque of the load goes from {low:.6g} to {high:.6g} N*m: give another as load"
        return on_screen(
            f"DriveMotion: {self.name} at {self.omega:.6g} rad/s ({self.omega / RPM:.6g} rpm) of the base angle, "
            f"{self.load_torque:.6g} N*m on the load\n"
            f"  {self.said}\n"
            f"  largest torque in the gear {self.peak_torque:.6g} N*m; "
            f"{self.remark or 'it repeats with every turn'}{alone}"
        )


def drive_motion(project: Project, omega: float, *, load: float | None = None) -> DriveMotion:
    """Integrate a drive at a constant speed from rest until its motion repeats.

    It is the whole train, with all that `Project.response` has; where the error equation is all there is, that.

    Parameters
    ----------
    project : Project
        From `read_project`.
    omega : float
        Speed of the base angle [rad/s].
    load : float, optional
        Constant torque [N*m] on the load in place of the project's; a resisting one is negative.

    Returns
    -------
    DriveMotion
        `error` [rad], `rate` [rad/s] and `torque` in the gear [N*m, output side] over `t` [s] of the last
        turns; `peak`, `oscillation` and `mean` [rad].

    Raises
    ------
    ValueError
        If a number is out of range; as `Project.response` for a free motor.
    SolveError
        If the law cannot carry the mean torque, or the integration ends early.
    """
    omega = number("omega [rad/s]", omega, positive=True)
    loaded = project if load is None else project.under(number("load [N*m]", load), level=True)
    low, high = project.load_torques
    if loaded.train is not None:
        refuse_free(loaded.train)
        motion = train_motion(loaded.train, omega, loaded.mean_load_torque)
    else:
        system = loaded.system(omega)
        motion = _motion(system, operating_point(system).start, loaded.mean_load_torque, loaded.motor == "held")
    return replace(motion, loads=(low, high)) if low < high else motion


def train_motion(train: DriveTrain, omega: float, load_torque: float) -> DriveMotion:
    """As `drive_motion`, of a train under a mean torque [N*m] on its load."""
    system = at_load(train._replace(omega=omega))
    if train.motor.free:
        system = system.linear_part().disturbed  # nothing else holds its speed
    start = waiting(system.train, 0.0)
    start[:2] += behind_gear(system.train, start)
    return _motion(system, start, load_torque, not train.motor.free)


def _motion(system: Any, start: Any, load_torque: float, has_reference: bool) -> DriveMotion:
    begun = _run(system, start, BLOCK_TURNS)
    waited, last = BLOCK_TURNS, _run(system, begun.y[:, -1], SHOWN_TURNS)
    while (change := _change(last)) and waited < MOST_BLOCKS * BLOCK_TURNS:
        waited += BLOCK_TURNS
        last = _run(system, _run(system, last.y[:, -1], BLOCK_TURNS - SHOWN_TURNS).y[:, -1], SHOWN_TURNS)
    x, v = last.y[:2]
    torque = torque_in(system, system.omega * last.t, tuple(last.y))
    return DriveMotion(system.omega, load_torque, last.t, x, v, torque, begun, waited, change, has_reference)


def _run(system: Any, start: Any, turns: int) -> Trajectory:
    """Some turns from a state."""
    count = turns * max(SAMPLES, PER_CYCLE * math.ceil(max((1, *system.orders()))))
    times = np.linspace(0.0, turns * 2.0 * np.pi / system.omega, count + 1)
    run = uninterrupted(simulate(system, start, times, method=METHOD))
    if not run.status:
        raise SolveError(Sentence("the motion at {} could not be integrated: {}", Speed(system.omega), run.message))
    return run


def _change(run: Trajectory) -> float:
    """Largest change [rad] of the error from one turn to the next; 0 where it repeats."""
    x, turn = run.y[0], (len(run.t) - 1) // SHOWN_TURNS
    change = float(np.max(np.abs(x[turn:] - x[:-turn])))
    return change if change > REPEAT_TOLERANCE * float(np.ptp(x)) else 0.0
