"""What moves: the train of a project as a move takes it, with the limits of its gear and its motor."""

from dataclasses import dataclass
from typing import Any, NamedTuple

from ...law import states_of
from ...model.gears.gear import Gear
from ...model.train.drive_train import DriveTrain
from ...protocols import lacking, terms_of
from ...quantities import checked, shown
from ...sentences import Sentence
from ..train.operating_point import mean_torque
from ..train.run import holds_its_place
from .demands import MotorLimits
from .payload import Payload

LINES_LEFT_OUT = (
    "The torques have their means; their lines, which follow an angle at constant speed, are left out of a move."
)


class Task(NamedTuple):
    """What a project file asks of a move: parts of the profile, angle at the begin [rad], payload, window [rad].

    `files` has for every part the name of its file, empty where it is in the project file itself.
    """

    profile: tuple[Any, ...] = ()
    start: float | None = None
    payload: Payload | None = None
    window: float | None = None
    files: tuple[str, ...] = ()


@dataclass(frozen=True)
class Mover:
    """A train with a loop of its motor, functions of the time in seconds, and what limits it."""

    train: DriveTrain
    gear: Gear | None
    limits: MotorLimits
    remarks: tuple[str, ...]

    @property
    def remembers(self) -> bool:
        """Whether where it comes to rest depends on how it got there: a law or a drag has internal states."""
        end = self.train.load.end()
        laws = (self.train.law, self.train.motor.drag, end.drag, *self.train.load.couplings())
        return any(states_of(law) for law in laws)


def mover_of(project: Any, gear: Gear | None, limits: MotorLimits | None, payload: Payload | None) -> Mover:
    """The train of a project, or a train itself, with a payload.

    Raises
    ------
    TypeError
        If it is neither.
    ValueError
        If it has no whole train, or nothing makes its motor follow a reference.
    """
    given, remarks = _train(project)
    if given.motor.free:
        raise ValueError(
            "the motor of this drive is free and follows no profile; give it a loop, such as motor: {loop: "
            "{bandwidth: 30 Hz}} in the project file"
        )
    if not holds_its_place(given.motor):
        raise ValueError(
            f"{given.motor.control} answers no deviation of the motor's angle, so that the load falls behind or sags; "
            "give a position loop, or a speed loop with K_i"
        )
    end, motor = given.load.end(), given.motor
    repeating = [torque for torque in (motor.excitation, end.excitation) if _repeats(torque)]
    if any(term.amplitude for torque in repeating for term in terms_of(torque)):
        remarks = (*remarks, LINES_LEFT_OUT)
    motor, end = (
        shaft._replace(excitation=mean_torque(shaft.excitation)) if _repeats(shaft.excitation) else shaft
        for shaft in (motor, end)
    )
    given = given._replace(motor=motor, load=given.load.with_end(end))
    train = given._replace(omega=1.0)
    if payload is not None:
        if not isinstance(payload, Payload):
            raise TypeError(f"payload is {shown(payload)}; give a Payload(mass, radius)")
        train = checked(payload).on(train)
    if gear is not None and not isinstance(gear, Gear):
        raise TypeError(f"gear is {shown(gear)}; give a record, such as catalogue.gear('CSG-40-50')")
    own = getattr(project, "motor_limits", None) or MotorLimits()
    return Mover(train, gear or getattr(project, "gear", None), checked_limits(limits) or own, remarks)


def _repeats(torque: Any) -> bool:
    """Whether a torque is a function of an angle with a mean, not of the time."""
    return not (lacking(torque, "mean") and lacking(torque, "terms"))


def checked_limits(limits: MotorLimits | None) -> MotorLimits | None:
    """Return limits of a motor, or refuse what is none (TypeError) or not positive (ValueError)."""
    if limits is not None:
        if not isinstance(limits, MotorLimits):
            raise TypeError(f"limits is {shown(limits)}; give MotorLimits(torque, speed)")
        limits.check()
    return limits


def _train(project: Any) -> tuple[DriveTrain, tuple[str, ...]]:
    if isinstance(project, DriveTrain):
        return checked(project), ()
    if lacking(project, "motors"):
        raise TypeError(f"move takes a Project or a DriveTrain, not {shown(project)}; read_project gives a project")
    trains = project.motors()
    if not trains:
        raise ValueError(
            "this project has no whole drive train, as its damping or stiffness varies or its speeds are those of a "
            "forcing; a move needs one: leave the variation out, and give the speeds of the motor or the load"
        )
    name, train = list(trains.items())[-1]  # where the file names no motor: the position loop
    remarks: list[str] = []
    if not project.motor_named:
        remarks.append(Sentence("The file names no loop of the motor; a {} is assumed.", name))
    if project.mean_range is not None:
        low, high = project.mean_range
        remarks.append(
            f"The mean torque of the load is given as a range, {low:g} to {high:g} N*m; the move has its middle. "
            "Gravity that changes with the angle belongs in load.drag as an angle_torque, or in the payload."
        )
    return train, tuple(remarks)
