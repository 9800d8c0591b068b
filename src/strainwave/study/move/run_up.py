"""`run_up`: the largest error of a run-up and a run-down through a range of speeds, at each rate, by integration.

The base angle is theta = omega t + r t^2/2 from t = 0 on. Before, the drive turns at its first speed until its motion
is steady, and the torque that the acceleration takes acts already: an acceleration that begins at once shakes a drive.
"""

import math
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ...base.facts import Fact
from ...base.law import repeating
from ...base.number_text import number
from ...base.quantities import AngularAcceleration, AngularSpeed, checked, interval, numbers, shown
from ...base.records import Along, Labelled, Result
from ...base.results import Floats, SolveError
from ...drive.equation.gear_torque import damping_of, loses_energy
from ...drive.project import Project
from ...drive.run import waiting
from ...drive.state_space import state_space
from ...model.excitation import mean_torque
from ...model.oscillator import Oscillator, VaryingOscillator
from ...model.train.drive_train import DriveTrain
from ...model.train.train_forms import AtLoad, behind_gear
from ...numerics.integration.methods import Dopri5
from ...numerics.integration.record import uninterrupted
from ...numerics.integration.simulate import simulate
from ...numerics.operating_point import loaded_state

BELOW, ABOVE = 0.5, 2.0  # times the lowest and the highest resonance of the lines: the usual range of a system
SETTLED, LONGEST = 20.0, 5000.0  # time constants of the slowest motion before a run, and at most so many turns
STANDS = 1e-9  # of the largest pole: a smaller one is no motion
PER_TURN, MOST_TURNS = 8, 100_000  # samples of a turn, between which the largest error is kept; turns of a run
METHOD = Dopri5(rtol=1e-8, atol=1e-13)
DIRECTIONS = ("run-up", "run-down")


class SpeedRamp(NamedTuple):
    """A constant speed [rad/s], from time 0 on with a constant rate [rad/s^2]. The angle is 0 at time 0.

    The curvature is the rate before, too: the torque that the acceleration takes is there when it begins.
    """

    speed: AngularSpeed
    rate: AngularAcceleration

    def value(self, phase: Any) -> Any:
        """Angle [rad] at a time [s]."""
        after = 0.5 * (phase + abs(phase))
        return self.speed * phase + 0.5 * self.rate * after * after

    def slope(self, phase: Any) -> Any:
        """Speed [rad/s] at a time [s]."""
        return self.speed + 0.5 * self.rate * (phase + abs(phase))

    def curvature(self, phase: Any) -> Any:
        """Acceleration [rad/s^2] whose torque acts at a time [s]."""
        return self.rate + 0.0 * phase

    def corners(self) -> tuple[float, ...]:
        """Time [s] at which the speed begins to change."""
        return (0.0,)


class OnMotion(NamedTuple):
    """A torque, a kinematic error or a variation of the base angle, as a function of the time on a motion."""

    part: Any
    motion: Any

    def torque(self, phase: Any) -> Any:
        """Torque [N*m] at a time [s]."""
        return self.part.torque(self.motion.value(phase))

    def value(self, phase: Any) -> Any:
        """Value at a time [s]."""
        return self.part.value(self.motion.value(phase))

    def slope(self, phase: Any) -> Any:
        """Derivative of the value by the time [1/s]."""
        return self.part.slope(self.motion.value(phase)) * self.motion.slope(phase)


class DampingOnMotion(NamedTuple):
    """The same of a damping of the base angle and of the rate of the torsion."""

    part: Any
    motion: Any

    def value(self, phase: Any, v: Any) -> Any:
        """Damping [N*m*s/rad] at a time [s] and a rate [rad/s]."""
        return self.part.value(self.motion.value(phase), v)

    def slope(self, phase: Any, v: Any) -> Any:
        """Derivative [N*m*s/rad] of the damping torque by the rate."""
        return self.part.slope(self.motion.value(phase), v)


@dataclass(frozen=True, eq=False)
class RunUps(Result):
    """The largest error of run-ups and run-downs at several rates.

    Attributes
    ----------
    rates : (n,) array
        Rates [rad/s^2] of the speed of the base angle.
    largest : (2, n) array
        Largest |error| [rad] of the run-up and of the run-down, between samples too.
    at : (2, n) array
        Speeds [rad/s] of the base angle there.
    speeds : (float, float)
        Range of the speeds [rad/s].
    name : str
        Name of the error.
    """

    rates: Floats
    largest: Floats
    at: Floats
    speeds: tuple[float, float]
    name: str

    rows: ClassVar[str] = "rate"
    arrays: ClassVar[Along] = {("direction", "rate"): {"largest": "rad", "at": "rad/s"}}

    def coordinates(self) -> Labelled:
        """Both directions, and the rates."""
        return {"direction": ("direction", list(DIRECTIONS), ""), "rate": ("rate", self.rates, "rad/s^2")}

    def facts(self) -> tuple[Fact, ...]:
        """The largest error at every rate, both ways."""
        low, high = map(number, self.speeds)
        rows = zip(self.rates.tolist(), self.largest.T.tolist(), self.at.T.tolist(), strict=True)
        return (
            Fact("speeds_rad_per_s", self.speeds),
            Fact("", f"Run-up and run-down, {low} to {high} rad/s: largest {self.name}", "{}"),
            Fact("runs", tuple(_row(*row) for row in rows), "{}"),
        )


def _row(rate: float, largest: list[float], speeds: list[float]) -> tuple[Fact, ...]:
    """Facts of a rate."""
    return (
        Fact("rate_rad_per_s2", rate, "rate"),
        Fact("run_up_rad", largest[0], "run-up"), Fact("run_up_at_rad_per_s", speeds[0], "at"),
        Fact("run_down_rad", largest[1], "run-down"), Fact("run_down_at_rad_per_s", speeds[1], "at"),
    )  # fmt: skip


def run_up(system: Any, rates: ArrayLike, *, speeds: tuple[float, float] | None = None) -> RunUps:
    """Run a drive up and down through a range of speeds at several rates, by integration.

    The base angle is theta = omega t + r t^2/2 from t = 0 to the other end of the range, r the rate. Before, it is
    theta = omega t until the drive has settled, from rest under its mean torques. On a train the torque that the
    acceleration takes acts already then: an acceleration that begins at once would shake it.

    Parameters
    ----------
    system : Project, DriveTrain, Oscillator or VaryingOscillator
        The drive, under the middle of a range of load torques. The motor of a train follows the speed, or its loop
        does; torques that follow the base angle follow it through the run.
    rates : float or (n,) array_like
        Rates [rad/s^2] of the speed of the base angle, positive: a run-down has minus the rate.
    speeds : (low, high), optional
        Range of the speed of the base angle [rad/s]. Default: that of the project; of an error equation from half the
        lowest to twice the highest speed at which a line of its excitation is in resonance.

    Returns
    -------
    RunUps
        `rates` (n,) [rad/s^2]; `largest` (2, n), the largest |error| [rad] of run-up and run-down, the mean included:
        the pointing error of the load of a project or a train, x of an error equation; `at` (2, n), the speed [rad/s]
        there.

    Raises
    ------
    ValueError
        If a rate or a speed is not positive and finite, a run has more than 100,000 turns, the motor is free, or the
        drive loses no energy.
    TypeError
        If `system` is none of these.
    SolveError
        If a law cannot carry its mean torque, or an integration ends early.
    """
    given, rates = rates, numbers("rates [rad/s^2]", rates)
    if not np.all(rates > 0.0):
        raise ValueError(f"rates [rad/s^2] is {shown(given)}; give positive ones: a run-down has minus the rate")
    if isinstance(system, Project):
        speeds = system.speeds.limits if speeds is None else speeds
        system = system.system(reduced=True) if system.whole is None else system.whole
    if not isinstance(system, DriveTrain | Oscillator | VaryingOscillator):
        raise TypeError(f"run_up takes a Project, a DriveTrain or an Oscillator, not {shown(system)}")
    system = repeating("run_up", checked(system))
    low, high = _resonance_speeds(system) if speeds is None else interval("speeds [rad/s]", speeds, positive=True)
    turns = 0.25 * (high * high - low * low) / math.pi / rates
    if np.max(turns) > MOST_TURNS:
        least = float(np.max(turns * rates)) / MOST_TURNS
        raise ValueError(
            f"at {np.min(rates):g} rad/s^2 a run from {low:g} to {high:g} rad/s takes {np.max(turns):.2g} turns, more "
            f"than {MOST_TURNS:,}; use rates of at least {least:.2g} rad/s^2, or a narrower speed range"
        )
    each = list(zip(rates.tolist(), turns.tolist(), strict=True))
    runs = [[_run(system, *ends, rate, n) for rate, n in each] for ends in ((low, high), (high, low))]
    largest, speed = np.moveaxis(np.array(runs), 2, 0)
    return RunUps(rates, largest, speed, (low, high), "pointing error" if isinstance(system, DriveTrain) else "error x")


def _resonance_speeds(system: Any) -> tuple[float, float]:
    """Speeds [rad/s] around the resonances of an error equation."""
    stiffness = 0.0 if isinstance(system, DriveTrain) else float(system.law.stiffness(_at_rest(system)[0]))
    if not (stiffness > 0.0 and (orders := system.orders())):
        name = type(system).__name__
        raise ValueError(f"this {name} has no known resonance to run through; give speeds=(low, high) in rad/s")
    omega_0 = math.sqrt(stiffness / system.J)
    return BELOW * omega_0 / max(orders), ABOVE * omega_0 / min(orders)


def _at_rest(system: Any) -> tuple[float, ...]:
    """Error [rad] of an error equation under its mean torque, its rate, and the internal states of its law."""
    x, *z = loaded_state(system.law, mean_torque(system.excitation))
    return (x, 0.0, *z)


def _run(system: Any, first: float, last: float, rate: float, turns: float) -> tuple[float, float]:
    """Largest |error| [rad] from one speed to the other, and the speed [rad/s] there."""
    ramp = SpeedRamp(first, math.copysign(rate, last - first))
    moving, start, decay = (_train_on_ramp if isinstance(system, DriveTrain) else _equation_on_ramp)(system, ramp)
    before = min(SETTLED / decay if decay else math.inf, LONGEST * 2.0 * math.pi / first)
    times = np.linspace(0.0, abs(last - first) / rate, 2 + math.ceil(PER_TURN * turns))
    run = uninterrupted(simulate(moving, start, np.append(-before, times), method=METHOD))
    if not run.status or run.largest is None:
        raise SolveError(f"the run from {first:g} to {last:g} rad/s at {rate:g} rad/s^2 ends early: {run.message}")
    sizes = run.largest[0, 2:]
    i = int(np.argmax(sizes))
    return float(sizes[i]), float(ramp.slope(times[1 + i]))


def _equation_on_ramp(system: Any, ramp: SpeedRamp) -> tuple[Any, Any, float]:
    """An error equation on a ramp, the state in which its run begins, and the decay [1/s] of its slowest motion."""
    if not loses_energy(system):
        raise ValueError("the system has no damping and never settles at the first speed; add damping")

    def on(part: Any) -> OnMotion:
        return OnMotion(part, ramp)

    moving = system._replace(excitation=on(system.excitation), error=on(system.error), omega=1.0)
    if isinstance(system, VaryingOscillator):
        moving = moving._replace(variation=on(system.variation), damping=DampingOnMotion(system.damping, ramp))
    return moving, _at_rest(system), 0.5 * damping_of(system) / system.J


def _train_on_ramp(train: DriveTrain, ramp: SpeedRamp) -> tuple[Any, Any, float]:
    """The same of a train, in coordinates of its load."""
    if train.motor.free:
        raise ValueError("a free motor follows a torque, not a speed; add a motor loop, or hold the motor")
    ends = train.motor.excitation, train.load.end().excitation
    motor, load = [OnMotion(excitation, ramp) for excitation in ends]
    moving = train._replace(omega=1.0, reference=ramp).with_motor(excitation=motor).with_load(excitation=load)
    state = waiting(moving, 0.0)
    poles = state_space(train, at=state, speed=ramp.speed).poles
    decays = -poles.real[poles.real < -STANDS * np.max(np.abs(poles))]
    state[:2] += behind_gear(moving, state)
    return AtLoad(moving, 1.0), state, float(np.min(decays)) if len(decays) else 0.0
