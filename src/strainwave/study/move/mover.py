"""Drive of a move: the train of a project with the limits of its gear and its motor, and with its payload."""

from dataclasses import dataclass
from typing import Any

from ...base.law import states_of
from ...base.protocols import terms_of
from ...base.quantities import checked, floated
from ...base.sentences import Sentence
from ...drive.demands.motor_limits import MotorLimits
from ...drive.demands.payload import Payload
from ...drive.motor_words import train_of
from ...drive.operating_point import mean_torque, repeats
from ...drive.run import holds_its_place
from ...model.gears.gear import Gear
from ...model.laws.dry import breakaway
from ...model.train.drive_train import DriveTrain

LINES_LEFT_OUT = "A move uses the mean torques; torque lines, defined for constant speed, are omitted."


@dataclass(frozen=True)
class Mover:
    """A train with a loop of its motor, functions of the time in seconds, and what limits it."""

    train: DriveTrain
    gear: Gear | None
    limits: MotorLimits
    remarks: tuple[str, ...]
    limited: bool = False  # the torque of the motor stays within its limit

    @property
    def depends_on_past(self) -> bool:
        """True where its rest depends on the motion before: a law or a drag has internal states or dry friction."""
        drags = self.train.motor.drag, self.train.load.end().drag
        laws = (self.train.law, *drags, *self.train.load.couplings())
        return any(states_of(law) for law in laws) or any(map(breakaway, drags))


def mover_of(project: Any, gear: Gear | None, limits: MotorLimits | None, payload: Payload | None) -> Mover:
    """The train of a project, or a train itself, with a payload.

    Raises
    ------
    ValueError
        If it has no whole train, or nothing makes its motor follow a reference.
    """
    drive, remarks = _train(project)
    if drive.motor.free:
        raise ValueError(
            "the motor of this drive is free and cannot follow a profile; add a loop, such as motor: {loop: "
            "{bandwidth: 30 Hz}} in the project file"
        )
    if not holds_its_place(drive.motor):
        raise ValueError(
            f"{drive.motor.control} does not correct the motor's angle: the load lags or sags; "
            "use a position loop, or a speed loop with K_i"
        )
    torques = drive.motor.excitation, drive.load.end().excitation
    if any(term.amplitude for torque in torques if repeats(torque) for term in terms_of(torque)):
        remarks = (*remarks, LINES_LEFT_OUT)
    means = [mean_torque(torque) if repeats(torque) else torque for torque in torques]
    train = drive._replace(omega=1.0).with_motor(excitation=means[0]).with_load(excitation=means[1])
    if payload is not None:
        train = checked(payload).on(train)
    if limits is not None:
        limits = floated(limits)
        limits.check()
    limits = limits or getattr(project, "motor_limits", None) or MotorLimits()
    return Mover(train, gear or getattr(project, "gear", None), limits, remarks)


FORWARD = "The kinematic error differs in backward motion; a move uses the error of forward motion throughout."


def _train(project: Any) -> tuple[DriveTrain, tuple[str, ...]]:
    name, train = train_of(project, "a move")
    if not name:
        return train, ()
    remarks: list[str] = []
    if not project.motor_named:
        remarks.append(Sentence("The project file has no loop of the motor; a {} is assumed.", name))
    if project.mean_range is not None:
        low, high = project.mean_range
        remarks.append(
            f"The mean torque of the load is given as a range, {low:g} to {high:g} N*m; the move uses the middle. "
            "Write gravity that changes with the angle in load.drag as an angle_torque, or in the payload."
        )
    if project.loaded_error is not None and project.loaded_error.backward is not None:
        remarks.append(FORWARD)
    return train, tuple(remarks)
