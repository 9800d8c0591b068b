"""A drive train in time: what it transmits, how its speed ripples, and where its energy goes."""

from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from ..base.law import depends, states_of, torque_of
from ..base.protocols import lacking, with_parts
from ..base.quantities import number, numbers, shown
from ..base.records import Along, Labelled, Result
from ..base.results import Floats, SolveError, Trajectory, largest_between
from ..base.terminal import on_screen
from ..model.excitation import Harmonic
from ..model.gears.gear import Gear
from ..model.gears.limits import Finding, check_limits
from ..model.train.controls import FREE, core_of
from ..model.train.drive_train import DriveTrain
from ..model.train.shafts import Motor
from ..model.train.train_forms import Metered
from ..numerics.integration.methods import Dopri5, Method
from ..numerics.integration.peaks import watched_ends
from ..numerics.integration.simulate import first_time, simulate
from .operating_point import operating_state, repeats

INPUTS = 3  # of the powers, the first ones: motor torque, control, load torque
TURN_ANGLES = 2.0 * np.pi * np.arange(4096) / 4096
TEST_ANGLE = 1e-3  # rad, a deviation that any loop on the angle answers
ACCURATE_METHOD = Dopri5(rtol=1e-11, atol=1e-14)  # energies too: their balance closes to about the tolerance


@dataclass(frozen=True, eq=False)
class DriveRun(Result):
    """A motion of a drive train, with its energies.

    Attributes
    ----------
    train : DriveTrain
        What was simulated.
    trajectory : Trajectory
        Times [s] and the states that `train.state_names()` lists; its `status` says whether the end was reached.
    motor_speed, load_speed : (n,) arrays
        Speeds theta_m' and theta_l' [rad/s].
    pointing : (n,) array
        Pointing error of the load [rad]: its reference angle, that of the motor over N, minus its angle.
    error : (n,) array
        Dynamic error between motor and load [rad], x = theta_m/N - theta_l with the twists of all couplings. The
        motor's own deviation from its reference is not in it.
    torque : (n,) array
        Torque that the gear transmits [N*m, output side].
    energy : (n,) array
        Energy in the train [J], kinetic and stored.
    work : dict of str to (n,) array
        Energies [J] since the start by `train.power_names()`: put in by motor torque, control and load torque (a
        load that resists takes energy out: negative), and lost in each element.
    findings : tuple of Finding
        What the run asked of the gear against its datasheet, if a gear was given.
    warnings : tuple of str
        The findings beyond a limit, as sentences.
    peak_pointing, peak_error, peak_torque, peak_speed : float
        Largest |pointing| and |error| [rad], |torque| in the gear [N*m] and |motor speed| [rad/s], between the samples
        too, however far these are apart.
    """

    train: DriveTrain
    trajectory: Trajectory
    motor_speed: Floats
    load_speed: Floats
    pointing: Floats
    error: Floats
    torque: Floats
    energy: Floats
    work: dict[str, Floats]
    findings: tuple[Finding, ...]
    warnings: tuple[str, ...]
    peak_pointing: float
    peak_error: float
    peak_torque: float
    peak_speed: float

    rows: ClassVar[str] = "t"
    arrays: ClassVar[Along] = {
        "t": {
            "pointing": "rad", "error": "rad", "torque": "N*m", "motor_speed": "rad/s", "load_speed": "rad/s",
            "energy": "J",
        },
    }  # fmt: skip

    def coordinates(self) -> Labelled:
        """Times, and the names of the states and of the powers that are integrated."""
        names, powers = list(self.train.state_names()), list(self.work)
        return {"t": ("t", self.trajectory.t, "s"), "state": ("state", names, ""), "power": ("power", powers, "")}

    def variables(self) -> Labelled:
        """Both errors, torque, speeds and energy over the time; states and their rates; energy by power."""
        y, rate, works = self.trajectory.y, self.trajectory.rate, np.array(list(self.work.values()))
        states: Labelled = {"y": (("state", "t"), y, ""), "rate": (("state", "t"), rate, "")}
        return {**super().variables(), **states, "work": (("power", "t"), works, "J")}

    @property
    def imbalance(self) -> float:
        """Largest gap of the energy balance over the run, relative to the largest energy that was moved."""
        powers = list(self.work.values())
        gap = self.energy - self.energy[0] - sum(powers[:INPUTS]) + sum(powers[INPUTS:])
        return float(np.max(np.abs(gap)) / max(np.max(np.abs([self.energy, *powers])), 1e-300))

    def efficiency(self, after: float = 0.0) -> float:
        """Energy that the load took over what motor and control gave, from t = `after` [s] on.

        It is the efficiency of a steady motion, over whole periods of it; in a run-up kinetic energy is in it too.

        Raises
        ------
        ValueError
            If nothing was put in by the motor side.
        """
        motor, control, load = [self._since(name, after) for name in list(self.work)[:INPUTS]]
        if not motor + control > 0.0:
            raise ValueError(f"the motor supplied {motor + control:g} J after t = {after:g} s: no efficiency exists")
        return -load / (motor + control)

    def lost(self, after: float = 0.0) -> dict[str, float]:
        """Energy [J] that each element turned into heat from t = `after` [s] on."""
        return {name: self._since(name, after) for name in list(self.work)[INPUTS:]}

    def largest(self) -> tuple[float, float, float]:
        """Largest |dynamic error| [rad], also between samples; time [s], motor speed [rad/s] of the largest sample."""
        top = int(np.argmax(np.abs(self.error)))
        return self.peak_error, float(self.trajectory.t[top]), float(self.motor_speed[top])

    def _since(self, name: str, after: float) -> float:
        t, after = self.trajectory.t, number("after [s]", after)
        if not t[0] <= after < t[-1]:
            raise ValueError(f"the run lasts from {t[0]:g} to {t[-1]:g} s; {after:g} s is outside this time")
        return float(self.work[name][-1] - self.work[name][np.searchsorted(t, after)])

    def __str__(self) -> str:
        largest, t, speed = self.largest()
        heat = ", ".join(f"{name} {value:.4g}" for name, value in self.lost(float(self.trajectory.t[0])).items())
        return on_screen(
            f"DriveRun: t = {self.trajectory.t[0]:.6g} .. {self.trajectory.t[-1]:.6g} s, {len(self.trajectory.t)} "
            f"samples\n  largest |pointing error| {self.peak_pointing:.6g} rad, |dynamic error| {largest:.6g} rad at "
            f"t = {t:.6g} s, motor {speed:.6g} rad/s\n"
            f"  largest |torque| in the gear {self.peak_torque:.6g} N*m\n"
            f"  heat [J]: {heat}\n  energy balance to {self.imbalance:.1e}; {self.trajectory.message}"
        )


def drive_run(
    train: DriveTrain,
    y0: ArrayLike | None = None,
    t: float | ArrayLike = 1.0,
    *,
    gear: Gear | None = None,
    method: Method = ACCURATE_METHOD,
) -> DriveRun:
    """Simulate a drive train: a start, a stop, a run-up through resonance, or a steady motion.

    Parameters
    ----------
    train : DriveTrain
        The train; with omega = 1 its excitations and its reference are functions of the time in seconds.
    y0 : (states,) array_like, optional
        State at the first time, as `train.state_names()` lists it. Default: where the mean torques, and profiles as
        they are just before, hold the train at the angle and the speed of its reference (`operating_state`): the load
        is where gravity leaves it, the torsion of the gear at rest.
    t : float or array_like
        End time [s], or (start, end), or the times to record.
    gear : Gear, optional
        Datasheet record; torque and speed beyond its limits are said in `warnings`, never an error.
    method : Dopri5, Rk4 or Dop8
        Integration method; the energies are integrated with the states. Steps end at the `corners()` of profiles.

    Returns
    -------
    DriveRun
        `pointing` and `error` [rad], `torque` in the gear [N*m, output side], `motor_speed` and `load_speed`
        [rad/s] and `energy` [J] over `trajectory.t` [s], all finite; `trajectory.status` is the reason if it
        ends early.

    Raises
    ------
    ValueError, TypeError
        As `simulate`.
    SolveError
        If no y0 is given and the torques hold the train in no state.
    """
    train = with_parts("drive_run", train, "power_names")
    names = train.state_names()
    start = waiting(train, first_time(t)) if y0 is None else numbers("y0", y0)
    if start.shape != (len(names),):
        raise ValueError(f"y0 is {shown(y0)}; it must be {len(names)} numbers: {', '.join(names)}")
    powers = train.power_names()
    run = simulate(Metered(train), np.append(start, np.zeros(len(powers))), t, method=method)
    y, phase = run.y[: len(names)], train.omega * run.t
    states = tuple(y)
    pointing, error, peak_torque, peak_speed = _peaks(train, run, len(names))
    findings: tuple[Finding, ...] = ()
    if gear is not None:
        findings = check_limits(gear, peak_torque=peak_torque, max_speed=peak_speed)
    return DriveRun(
        train, replace(run, y=y, rate=run.rate[: len(names)]),
        motor_speed=np.broadcast_to(train.motor_speed(phase, states), run.t.shape),
        load_speed=np.broadcast_to(train.load_speed(phase, states), run.t.shape),
        pointing=train.pointing_error(states), error=train.load_error(states),
        torque=np.broadcast_to(train.torque(phase, states), run.t.shape),
        energy=np.broadcast_to(train.energy(phase, states), run.t.shape),
        work=dict(zip(powers, run.y[len(names) :], strict=True)),
        findings=findings, warnings=tuple(finding.sentence for finding in findings if finding.exceeded),
        peak_pointing=pointing, peak_error=error, peak_torque=peak_torque, peak_speed=peak_speed,
    )  # fmt: skip


def _peaks(train: DriveTrain, run: Trajectory, states: int) -> Any:
    """Largest |pointing error|, |error| [rad], |gear torque| [N*m] and |motor speed| [rad/s] of a metered run."""
    if run.largest is not None:
        first = np.abs(np.array(Metered(train).watched(train.omega * run.t[0], tuple(run.y[:states, 0])), float))
        return np.maximum(first, np.max(run.largest[-len(first) :], axis=1)).tolist()
    steps = np.flatnonzero(np.diff(run.t))  # not those between two samples at once, where a shaft begins to stick
    every = watched_ends(Metered(train), run, steps)
    return [largest_between(np.diff(run.t)[steps], *ends) for ends in every]


def waiting(train: DriveTrain, t: float) -> Floats:
    """Find the state (states,) in which a train begins a motion at a time [s], as `drive_run` does.

    The mean torques, and those that do not repeat as they are just before t, hold it at the angle and the speed of its
    reference (`operating_state`), with the kinematic error of that angle. A motor that no stiffness of its loop holds
    against a torque, such as a free one, begins on its reference.
    """
    phase = train.omega * np.nextafter(t, -np.inf)
    angle, speed = float(train.reference.value(phase)), float(train.omega * train.reference.slope(phase))
    begun, left_out = _begun(train, phase), 0
    if not holds_its_place(train.motor):
        left_out = states_of(train.motor.control)  # 0, as there is no deviation yet
        begun = begun.with_motor(control=FREE)
    try:
        state = operating_state(begun, speed, angle=angle)
    except SolveError as error:
        raise SolveError(f"{error}; give the initial state, y0") from error
    if speed:  # at standstill it is in the state already
        state[0] += train.error.value(angle)
        state[1] += train.error.slope(angle) * speed
    return np.insert(state, 4, np.zeros(left_out)) if left_out else state


def holds_its_place(motor: Motor) -> bool:
    """True if the control answers a deviation of the angle, at once or by states of its own."""
    control = core_of(motor.control)
    if motor.held or depends(control) == 3:
        return True
    return float(torque_of(control, -TEST_ANGLE, 0.0, ())) != float(torque_of(control, TEST_ANGLE, 0.0, ()))


def _begun(train: DriveTrain, phase: float) -> DriveTrain:
    """Return the train with its mean torques, those that do not repeat constant as they are at a phase."""

    def constant(torque: Any) -> Any:
        if repeats(torque):
            return torque
        phases = np.array([phase]) if lacking(torque, "orders") else TURN_ANGLES
        return Harmonic(0.0, mean=float(np.mean(np.broadcast_to(torque.torque(phases), phases.shape))))

    motor, end = train.motor, train.load.end()
    return train.with_motor(excitation=constant(motor.excitation)).with_load(excitation=constant(end.excitation))
