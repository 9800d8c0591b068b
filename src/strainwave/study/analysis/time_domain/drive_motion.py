"""`drive_motion`: a drive at a constant speed, integrated until its motion repeats with every turn."""

import math
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np

from ....base.quantities import number
from ....base.records import Along, Result
from ....base.results import Floats, SolveError, Trajectory, largest_between
from ....base.sentences import Angle, Sentence, Speed
from ....base.series import largest_of_samples
from ....base.terminal import on_screen
from ....base.units import RPM
from ....drive.project import Project
from ....drive.run import waiting
from ....drive.train_curve import at_load, refuse_free, torque_in
from ....model.train.drive_train import DriveTrain
from ....model.train.train_forms import behind_gear
from ....numerics.integration.methods import Dopri5
from ....numerics.integration.record import uninterrupted
from ....numerics.integration.simulate import simulate
from ...speed_map.error_equation import operating_point

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
    def sizes_text(self) -> Sentence:
        """Words on its oscillation, mean and largest size."""
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
            f"  {self.sizes_text}\n"
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
    """Integrate from a state until the motion repeats with every turn, or for 480 turns."""
    begun = _run(system, start, BLOCK_TURNS)
    waited, last = BLOCK_TURNS, _run(system, begun.y[:, -1], SHOWN_TURNS)
    while (change := _change(last)) and waited < MOST_BLOCKS * BLOCK_TURNS:
        waited += BLOCK_TURNS
        last = _run(system, _run(system, last.y[:, -1], BLOCK_TURNS - SHOWN_TURNS).y[:, -1], SHOWN_TURNS)
    x, v = last.y[:2]
    torque = torque_in(system, system.omega * last.t, tuple(last.y))
    return DriveMotion(
        system.omega, load_torque, t=last.t, error=x, rate=v, torque=torque, begun=begun, turns=waited, change=change,
        has_reference=has_reference,
    )  # fmt: skip


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
