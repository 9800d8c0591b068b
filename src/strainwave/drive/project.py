"""A project: a drive, its speeds and what excites it, in SI, and what is asked of it."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any, Literal

from ..base.above import above
from ..base.law import depends
from ..base.number_text import counted
from ..base.quantities import checked, number, whole
from ..base.results import SolveError
from ..base.sentences import listed
from ..base.terminal import on_screen
from ..model.controllers.closed_loop import Sampling
from ..model.drive import Drive
from ..model.error_spectrum import LoadedError
from ..model.excitation import Harmonics, KinematicError, as_harmonics, mean_torque, shortest, with_mean
from ..model.gears.gear import Gear
from ..model.orders import Arrangement
from ..model.oscillator import GearDamping, NoVariation, Oscillator, Variation, VaryingOscillator
from ..model.train.controls import FREE, USUAL, Held
from ..model.train.drive_train import DriveTrain
from ..model.train.filters import control_of
from .demands.motor_limits import MotorLimits
from .demands.move_task import Task
from .drive_response import DriveResponse
from .equation.gear_torque import UNDAMPED, loses_energy
from .equation.left_out import LOOP_PART, beyond_equation, left_out
from .loops.worst_margins import WorstMargins, loop_fault, worst_margins
from .motor_words import motor_name
from .operating_point import refuse_overload
from .sources import DriveUnit, Source
from .speeds import Speeds
from .steady import equation_curve, is_beating, leaves_angle_out, train_motions
from .train_curve import NO_MOTION, has_curve, refuse_free, torques_of_angle, without_gravity

SIZE_FIELDS = ("damping", "excitation.kinematic_error", "excitation.accuracy", "motor.loop", "motor.mode", "hysteresis")
ASSUMED_DIGITS = 3  # digits of what rests on an assumed one of these


@dataclass(frozen=True)
class Project:
    """A drive with its speed and excitation, in SI and radians.

    Attributes
    ----------
    title : str
        Title of the report; the file's name where the file gives none.
    path : Path
        The project file.
    text : str
        Its content, for the record.
    subject : DriveTrain
        The whole drive train at constant speed, with its torques and its kinematic error; `drive` and others are views.
    gear : Gear or None
        The record of the catalogue or of the user's own file, or None for an explicit law.
    speeds : Speeds
        The range of speeds (`from`, `to`) or the single ones (`at`) of the file, and their shaft.
    notes : tuple of str
        Sentences for the reader: doubts about the catalogue data, a motor inertia that cannot be right.
    damping, stiffness : GearDamping, Variation or None
        The damping, and the factor of the stiffness over the base angle, where they vary; `drive` has the sizes.
    rated_torque, limit : float or None
        Rated torque [N*m] of the gear, and the largest oscillation of the error [rad] that the file allows, if known.
    mean_range : (float, float) or None
        Least and largest mean torque [N*m] on the load, where the file gives a range; `load_torque` has its middle.
    motor_named : bool
        Whether the file gives a mode or a loop of the motor; else the ideally held one is an assumption.
    scatter, correlation
        Numbers of the file that scatter with their standard deviations relative to themselves, of phases in rad; their
        correlation matrix, None where they are independent.
    motor_limits, move, sampling : MotorLimits, Task, Sampling or None
        Largest torque [N*m] and speed [rad/s] of the motor.
        What the file asks of a move; samples and encoders of the drive's controller, with the motor's largest torque.
    drive_units, postures : tuple of DriveUnit, tuple of Posture
        What 1 of the drive's own parameters is; loads of the drive in the postures of the machine.
    arrangement, revision : Arrangement or None, str
        Members of the gear that are fixed and the output; revision of the file, as it says them.
    loaded_error : LoadedError or None
        Lines by torque and direction of motion, where they depend on these.
    sources : tuple of Source
        Where each number comes from: `name`, `value`, `word` (catalogue, assumed, yours or measured), `why`.
    """

    title: str
    path: Path
    text: str
    subject: DriveTrain
    gear: Gear | None
    speeds: Speeds
    damping: GearDamping | None = None
    stiffness: Variation | None = None
    rated_torque: float | None = None
    limit: float | None = None
    mean_range: tuple[float, float] | None = None
    notes: tuple[str, ...] = ()
    motor_named: bool = True
    scatter: tuple[tuple[str, float], ...] = ()
    correlation: tuple[tuple[float, ...], ...] | None = None
    motor_limits: MotorLimits | None = None
    move: Task | None = None
    sampling: Sampling | None = None
    postures: tuple[Any, ...] = ()
    arrangement: Arrangement | None = None
    revision: str = ""
    drive_units: tuple[DriveUnit, ...] = ()
    loaded_error: LoadedError | None = None
    sources: tuple[Source, ...] = field(default=(), compare=False)

    def __str__(self) -> str:
        low, high = self.speeds.given[0], self.speeds.given[-1]
        gear = "gear of its own law" if self.gear is None else self.gear.name
        motor = next(iter(self.motors())) if self.motor_named and self.whole is not None else self.motor
        parts = f", with {listed(more)}" if (more := [part for part in self.left_out if part != LOOP_PART]) else ""
        return on_screen(
            f"Project {self.title!r} ({self.path.name}): {gear}, ratio {self.drive.N:g}, motor: {motor}{parts}\n"
            f"  equation: J {self.J:.6g} kg*m^2, B {self.drive.B:.6g} N*m*s/rad, omega_0 {self.omega_0:.6g} rad/s\n"
            f"  speeds {low:.6g} .. {high:.6g} rad/s of the {self.speeds.base_angle}, "
            + counted(len(self.notes), "note")
        )

    __repr__ = __str__

    def _repr_html_(self) -> str:
        """Numbers in a notebook."""
        return str(above("card")(self))

    @property
    def motor(self) -> Literal["free", "held"]:
        """Mode of the motor: it follows its torque ("free") or keeps its speed ("held")."""
        return "free" if self.subject.motor.free else "held"

    @cached_property
    def drive(self) -> Drive:
        """Inertias, ratio, damping B [N*m*s/rad] and torsion law; J_l holds the inertias of all couplings."""
        train = self.subject
        J_l = train.load.end().J + sum(J for J, _, _ in train.load.chain())
        return Drive(train.motor.J, J_l, train.N, train.B, train.law)

    @property
    def motor_torque(self) -> Harmonics | None:
        """Torque [N*m] on the motor, motor side."""
        return as_harmonics(self.subject.motor.excitation)

    @property
    def load_torque(self) -> Harmonics | None:
        """Torque [N*m] on the load, output side; a resisting load is negative."""
        return as_harmonics(self.subject.load.end().excitation)

    @property
    def kinematic_error(self) -> KinematicError | None:
        """Lines of the gear's kinematic error [rad, output side], those under the mean torque of the load."""
        error = self.subject.error
        return error if isinstance(error, KinematicError) else None

    @property
    def whole(self) -> DriveTrain | None:
        """The train; None where the damping or the stiffness varies, and for speeds of a forcing."""
        return self.subject if self.speeds.by_motor and self.damping is None and self.stiffness is None else None

    @cached_property
    def train(self) -> DriveTrain | None:
        """The train where its error equation has not all of it, such as a loop, friction, gravity or a coupling."""
        return self.whole if self.whole is not None and beyond_equation(self.whole) else None

    @property
    def J(self) -> float:
        """Inertia [kg m^2] of the error equation in the project's motor mode."""
        return self.drive.J if self.motor == "free" else self.drive.J_l

    @property
    def omega_0(self) -> float:
        """Natural frequency [rad/s] of the law's spring in the project's motor mode; 0 where that has none at rest."""
        return self.drive.omega_0 if self.motor == "free" else self.drive.omega_0_held

    @property
    def damping_ratio(self) -> float | None:
        """Damping ratio B/(2 J omega_0) in the project's motor mode, or None where omega_0 is 0."""
        return self.drive.B / (2.0 * self.J * self.omega_0) if self.omega_0 else None

    @property
    def undamped(self) -> str:
        """Sentence on an error equation that loses no energy; empty of every other drive."""
        return "" if self.left_out or loses_energy(self._at_middle) else UNDAMPED

    @property
    def assumed(self) -> tuple[Source, ...]:
        """Assumed numbers on which an oscillation rests: of damping, hysteresis, kinematic error and motor."""
        return tuple(one for one in self.sources if one.word == "assumed" and one.name.startswith(SIZE_FIELDS))

    def digits(self, most: int = 4) -> int:
        """Digits with which an answer is printed."""
        return min(whole("most", most), ASSUMED_DIGITS if self.assumed else most)

    @property
    def has_memory(self) -> bool:
        """True if the torsion law has friction or memory."""
        return depends(self.drive.law) > 1

    @property
    def left_out(self) -> tuple[str, ...]:
        """Parts of the drive that its error equation leaves out and that change the error; `train` has them all."""
        return () if self.train is None else left_out(self.train)

    def motors(self) -> dict[str, DriveTrain]:
        """The whole train by what drives its motor, in words; empty where there is no train (see `whole`).

        It is the file's; where that names neither mode nor loop: held, free, and in a loop of 30 Hz and damping 0.7.
        """
        if self.whole is None:
            return {}
        if self.motor_named:
            return {motor_name(self.whole.motor.control, self.loop_inertia): self.whole}
        controls = (Held(), FREE, control_of(USUAL, self.loop_inertia))
        return {motor_name(c, self.loop_inertia): self.whole.with_motor(control=c) for c in controls}

    @property
    def loop_inertia(self) -> float:
        """Inertia [kg*m^2, motor side] that a loop of the motor turns: the motor, and the rigid load over N^2."""
        return self.drive.loop_inertia

    def system(self, omega: float | None = None, *, reduced: bool = False) -> Oscillator | VaryingOscillator:
        """Error equation of the drive: an ideally held or a free motor, the gear, and a rigid load.

        At a speed `omega` of the base angle [rad/s], else the file's middle; `reduced` lacks what `left_out` names. A
        drive with such parts is a ValueError where `reduced` is false.
        """
        if self.left_out and not reduced:
            raise ValueError(
                f"the error equation neglects {listed(self.left_out)} of this drive; use project.train, the whole "
                "drive train, or system(omega, reduced=True) for the error equation without these parts"
            )
        return self._at_middle if omega is None else self._system(omega)

    @cached_property
    def _at_middle(self) -> Oscillator | VaryingOscillator:
        return self._system(self.speeds.middle)

    def _system(self, omega: float, drive: Drive | None = None) -> Oscillator | VaryingOscillator:
        system = (drive or self.drive).error_equation(
            motor_torque=self.motor_torque, load_torque=self.load_torque, kinematic_error=self.kinematic_error,
            omega=omega, motor=self.motor)  # fmt: skip
        if self.damping is None and self.stiffness is None:
            return system
        damping = GearDamping(system.B) if self.damping is None else self.damping._replace(B=system.B)
        varying = self.stiffness or NoVariation()
        oscillator: VaryingOscillator = checked(VaryingOscillator(system.J, damping, *system[2:], varying))
        return oscillator

    @property
    def mean_load_torque(self) -> float:
        """Mean torque [N*m] on the load; of a range the middle."""
        return mean_torque(self.load_torque)

    @property
    def load_torques(self) -> tuple[float, float]:
        """Least and largest torque [N*m] on the load: of `mean_range`, and of drags that follow its own angle."""
        low, high = self.mean_range or (self.mean_load_torque, self.mean_load_torque)
        if self.train is None:
            return low, high
        lowest, highest = torques_of_angle(self.train.load.end().drag)
        return low + lowest, high + highest

    @property
    def other_loads(self) -> tuple[float, float]:
        """Least and largest torque [N*m] on the load beside the curve's: without those of its angle in a beat."""
        curve = self.mean_range or (self.mean_load_torque,) * 2
        return self.load_torques if leaves_angle_out(self.subject) else curve

    @property
    def cases(self) -> Any:
        """Every load of the drive, a `LoadCase` each: its postures, and its own load under its torques."""
        return above("cases_of")(self)

    def under(self, torque: float, level: bool | None = None) -> "Project":
        """The project with a constant torque [N*m] of the load in place of its range and of torques of its angle.

        Motions of two turns have the torques of the angle beside it, unless it is `level`.
        """
        level = leaves_angle_out(self.subject) if level is None else level
        train = without_gravity(self.subject) if level else self.subject
        train = train.with_load(excitation=shortest(with_mean(self.load_torque, torque)))
        error = train.error if self.loaded_error is None else self.loaded_error.under(-torque)
        return replace(self, mean_range=None, subject=train._replace(error=error))

    def with_load_inertia(self, J_l: float) -> "Project":
        """The project with another inertia [kg*m^2] of the load behind all couplings; B and the loop stay."""
        return replace(self, subject=self.subject.with_load(J=number("J_l [kg*m^2]", J_l, positive=True)))

    def response(
        self, harmonics: int | None = None, *, coexisting: bool = True, points: int | None = None
    ) -> DriveResponse:  # fmt: skip
        """Steady motions of the whole drive through its speeds, with jumps; the pointing error of the load leads.

        Where motions beat `coexisting` and `points` do not count: motions apart from the curve are not looked for.

        Parameters
        ----------
        harmonics : int, optional
            Highest harmonic of the base angle. Default: grown until those left out are negligible, in a beat always.
        coexisting : bool
            Whether motions that do not join the curve are looked for at the ends of the range: most of the time.
        points : int, optional
            About so many, 100 (of a whole train 60) by default, more at bends; crests and folds are always among them.

        Raises
        ------
        ValueError
            If `points` (at most 10 000) or `harmonics` is not a positive whole number or given where motions beat,
            or if the motor is free and the drive has parts that the error equation leaves out.
        SolveError
            If no periodic motion is found.
        """
        how = {"coexisting": coexisting, "points": points}
        response = None
        if self.train is not None:
            refuse_free(self.train)
            response = self.train_response(harmonics, **how)
            if response is None and has_curve(self.train):
                refuse_overload(self.train)
                raise SolveError(NO_MOTION)
        if response is None:
            response = self.equation_response(harmonics, **how)
        if len(response.curve):
            return response
        raise SolveError(response.message)

    def train_response(self, harmonics: int | None = None, **how: Any) -> DriveResponse | None:
        """Steady motions of the whole train; None where it has no curve, or none is found."""
        if self.train is None:
            return None
        return train_motions(self.train, self.speeds.limits, self.limit, harmonics, **how)

    def equation_response(self, harmonics: int | None = None, **how: Any) -> DriveResponse:
        """Steady motions of the error equation alone, whose curve may be empty."""
        train, ratio = (self.whole, None) if self.train is None else (None, self.drive.N)
        return equation_curve(
            self.system(reduced=True), self.speeds.limits, self.limit, train, harmonics,
            has_reference=self.motor == "held", ratio=ratio, **how,
        )  # fmt: skip

    def held_response(self, points: int | None = None) -> DriveResponse | None:
        """The curve of the error equation beside that of a train with a held motor; None of other drives."""
        if self.train is None or self.motor != "held" or is_beating(self.subject.error):
            return None
        return self.equation_response(coexisting=False, points=points)

    @cached_property
    def sureness(self) -> Any:
        """Range of the response for assumed numbers, a `Sureness`; as of `how_sure`."""
        return above("how_sure")(self)

    @cached_property
    def loop(self) -> WorstMargins | None:
        """Margins of the motor's loop, the worst over all loads and postures, sampled as `sampling` says.

        None where the drive has no loop.
        """
        return worst_margins(self)

    @cached_property
    def loop_fault(self) -> str:
        """Sentence on a motor's loop that is unstable under a load; empty where it is not."""
        return loop_fault(self)

    def judged(self, response: DriveResponse) -> Any:
        """The verdict on one curve of the drive by the rules of `analyze`, a `Judged`."""
        return above("judged")(self, response)

    def analyze(self, progress: Callable[[str, float], None] | None = None, **parts: bool) -> Any:
        """Analyse the drive through its speeds, an `Analysis`; arguments and errors as of `study.analysis.analyze`."""
        return above("analyze")(self, progress, **parts)

    def equation_of(self, drive: Drive, torque: float | None) -> Oscillator | VaryingOscillator:
        """Error equation of another drive, under a constant torque [N*m] of the load or that of the file."""
        return (self if torque is None else self.under(torque))._system(self.speeds.middle, drive)
