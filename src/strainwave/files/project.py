"""The project file: a drive, its speed and what excites it, read from YAML with units and resolved to SI."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

from pydantic import ValidationError, create_model

from ..law import depends
from ..model.drive import Drive
from ..model.excitation import Harmonics, KinematicError
from ..model.gears import catalogue
from ..model.gears.gear import Gear
from ..model.oscillator import Oscillator
from ..model.train.controls import FREE, Held
from ..model.train.drive_train import DriveTrain
from ..model.train.loops import USUAL
from ..model.varying import GearDamping, NoVariation, Variation, VaryingOscillator
from ..quantities import checked, convert
from ..results import SolveError
from ..sentences import on_screen
from ..speeds import Speeds
from ..study.analysis.analysis import Analysis, analyze
from ..study.analysis.drive_response import DriveResponse, of_equation
from ..study.analysis.load_range import LoadRange
from ..study.analysis.remedies import Source
from ..study.analysis.runup import silent
from ..study.analysis.train_curve import NO_MOTION, has_curve, refuse_free, train_curve
from ..study.response.by_integration import response_through
from ..study.train.loop_margin import motor_name, unstable
from ..study.train.reductions import left_out, listed
from .complaints import complaints
from .contradictions import contradictions
from .load_torque import load_range, under
from .loop_fields import control_of
from .notes import notes
from .own_gears import read_gears
from .python_law import with_python_laws
from .resolve import (
    beyond_equation,
    damping,
    kinematic_error,
    loop_inertia,
    mean_range,
    speeds,
    torque,
    whole_inertia,
    whole_train,
)
from .schema import ExplicitGear, OwnGear, ProjectSpec, Spec
from .yaml_text import FileError, Problem, as_path, complaint, name, read, read_text, shown

ACCURACY_NOTE = (
    "The kinematic error stands for an accuracy class of {:.4g} arcsec peak-to-peak: its orders 1, 2 and 4 share it as "
    "1 : 4 : 1 by assumption; a measured scan (strainwave error-scan) replaces the assumption."
)


class ProjectError(FileError):
    """A project file cannot be used; one line `file:line:column: field: fact, value, remedy` per problem."""


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
    drive : Drive
        Inertias, ratio, damping B [N*m*s/rad] and torsion law; loop, drags and coupling are in `train` alone, and J_l
        holds the inertias on both sides of a coupling.
    gear : Gear or None
        The record of the catalogue or of the user's own file, or None for an explicit law.
    motor : {"free", "held"}
        Whether the motor follows its torque or keeps its speed.
    speeds : Speeds
        The range of speeds (`from`, `to`) or the single ones (`at`) of the file, and their shaft.
    motor_torque, load_torque : Harmonics or None
        Torques [N*m] on the motor (motor side) and on the load (output side, a resisting load is negative).
    kinematic_error : KinematicError or None
        Lines of the gear's kinematic error [rad, output side].
    notes : tuple of str
        Sentences for the reader: doubts about the catalogue data, a motor inertia that cannot be right. What the run
        asks of the gear beyond its limits is in the analysis.
    damping : GearDamping or None
        The damping, where it varies with angle, speed or temperature; its size is that of the drive.
    stiffness : Variation or None
        The factor of the stiffness over the base angle, where it varies.
    train : DriveTrain or None
        The whole drive train at constant speed, where the error equation leaves something of it out: a loop, friction
        on a shaft, gravity, a coupling, or the ripple of a free motor.
    rated_torque : float or None
        Rated torque [N*m] of the gear, where it is known.
    limit : float or None
        Largest oscillation of the error [rad] that the drive may have, where the file gives one.
    mean_range : (float, float) or None
        Least and largest mean torque [N*m] on the load, where the file gives a range; `load_torque` has its middle.
    whole : DriveTrain or None
        The drive train in any case, also where `train` is None; None where the damping or the stiffness varies, and for
        speeds of a forcing.
    motor_named : bool
        Whether the file gives a mode or a loop of the motor; else the ideally held one is an assumption.
    scatter : tuple of (str, float)
        Numbers of the file that scatter from drive to drive, and their standard deviations relative to themselves.
    """

    title: str
    path: Path
    text: str
    drive: Drive
    gear: Gear | None
    motor: Literal["free", "held"]
    speeds: Speeds
    motor_torque: Harmonics | None
    load_torque: Harmonics | None
    kinematic_error: KinematicError | None
    damping: GearDamping | None = None
    stiffness: Variation | None = None
    train: DriveTrain | None = None
    rated_torque: float | None = None
    limit: float | None = None
    mean_range: tuple[float, float] | None = None
    notes: tuple[str, ...] = ()
    whole: DriveTrain | None = None
    motor_named: bool = True
    scatter: tuple[tuple[str, float], ...] = ()

    def __str__(self) -> str:
        low, high = self.speeds.given[0], self.speeds.given[-1]
        gear = "gear of its own law" if self.gear is None else self.gear.name
        parts = f", with {listed(self.left_out)}" if self.left_out else ""
        return on_screen(
            f"Project {self.title!r} ({self.path.name}): {gear}, ratio {self.drive.N:g}, motor {self.motor}{parts}\n"
            f"  J {self.J:.6g} kg*m^2, B {self.drive.B:.6g} N*m*s/rad, omega_0 {self.omega_0:.6g} rad/s\n"
            f"  speeds {low:.6g} .. {high:.6g} rad/s of the {self.speeds.base_angle}, {len(self.notes)} notes"
        )

    __repr__ = __str__

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
    def has_memory(self) -> bool:
        """Whether the torsion law has friction or memory."""
        return depends(self.drive.law) > 1

    @property
    def left_out(self) -> tuple[str, ...]:
        """Parts of the drive that its error equation leaves out and that change the error; `train` has them all."""
        return () if self.train is None else left_out(self.train)

    def motors(self) -> dict[str, DriveTrain]:
        """The whole train by what drives its motor, in words; empty where there is no train (see `whole`).

        It is the one of the file. Where that names neither a mode nor a loop, the three between which the answer lies:
        ideally held, free, and in a position loop of 30 Hz and damping 0.7 (`from_bandwidth`, on `loop_inertia`).
        """
        if self.whole is None:
            return {}
        if self.motor_named:
            return {motor_name(self.whole.motor.control, self.loop_inertia): self.whole}
        controls = (Held(), FREE, control_of(USUAL, self.loop_inertia))
        trains = {motor_name(c, self.loop_inertia): self.whole.motor._replace(control=c) for c in controls}
        return {name: self.whole._replace(motor=motor) for name, motor in trains.items()}

    @property
    def loop_inertia(self) -> float:
        """Inertia [kg*m^2, motor side] that a loop of the motor turns: the motor, and the rigid load over N^2."""
        return loop_inertia(self.drive)

    def system(self, omega: float | None = None, *, reduced: bool = False) -> Oscillator | VaryingOscillator:
        """Error equation of the drive: an ideally held or a free motor, the gear, and a rigid load.

        Parameters
        ----------
        omega : float, optional
            Speed of the base angle [rad/s]. Default: the middle of the file's speeds.
        reduced : bool
            Whether it may leave out parts of the drive: those that `left_out` names.

        Raises
        ------
        ValueError
            If the drive has such parts and `reduced` is false.
        """
        if self.left_out and not reduced:
            raise ValueError(
                f"the error equation leaves out {listed(self.left_out)} of this drive; take project.train, the whole "
                "train, or system(omega, reduced=True) for the error equation without them"
            )
        system = self.drive.error_equation(
            motor_torque=self.motor_torque,
            load_torque=self.load_torque,
            kinematic_error=self.kinematic_error,
            omega=self.speeds.middle if omega is None else omega,
            motor=self.motor,
        )
        if self.damping is None and self.stiffness is None:
            return system
        damping = GearDamping(system.B) if self.damping is None else self.damping
        varying = NoVariation() if self.stiffness is None else self.stiffness
        whole: VaryingOscillator = checked(VaryingOscillator(system.J, damping, *system[2:], varying))
        return whole

    @property
    def load_range(self) -> LoadRange | None:
        """Torques of the load: those of `mean_range`, and of drags that follow the load's own angle; None of one."""
        return load_range(self)

    def response(self, harmonics: int | None = None) -> DriveResponse:
        """Steady motions of the whole drive through its speeds, with jumps; the pointing error of the load leads.

        Parameters
        ----------
        harmonics : int, optional
            Highest harmonic of the base angle. Default: grown until those left out are negligible.

        Raises
        ------
        SolveError
            If no periodic motion is found.
        """
        system, speeds = self.system(reduced=True), self.speeds.limits
        if self.train is not None:
            refuse_free(self.train)
            if has_curve(self.train):
                found = train_curve(self.train, speeds, harmonics)
                if found is None:
                    raise SolveError(NO_MOTION)
                return found
        exact = response_through(system, speeds, harmonics=harmonics)
        if not len(exact.curve):
            raise SolveError(exact.curve.message)
        return of_equation(system, exact, self.motor == "held")

    def analyze(self, progress: Callable[[str, float], None] = silent) -> Analysis:
        """Analyse the drive through its speeds; `progress` and errors as `study.analysis.analysis.analyze`."""
        return analyze(
            self.system(reduced=True),
            self.speeds,
            gear=self.gear,
            train=self.train,
            rated_torque=self.rated_torque,
            limit=self.limit,
            source=Source(self.drive, self.motor == "free", self.speeds.by_motor, self._equation, self.gear),
            load=self.load_range,
            has_reference=self.motor == "held",
            motors={} if self.motor_named else self.motors(),
            progress=progress,
        )

    def _equation(self, drive: Drive, torque: float | None) -> Oscillator | VaryingOscillator:
        """Error equation of another drive, under a constant torque [N*m] of the load or that of the file."""
        damping = None if self.damping is None else self.damping._replace(B=drive.B)
        loaded = self.load_torque if torque is None else under(self.load_torque, torque)
        return replace(self, drive=drive, damping=damping, load_torque=loaded).system(reduced=True)


def read_project(path: str | Path) -> Project:
    """Read a project file.

    Parameters
    ----------
    path : str or Path
        YAML file of at most 256 KiB, see `examples/projects`.

    Raises
    ------
    ProjectError
        If the file cannot be read or does not describe a drive; all problems found, one line each.
    """
    path = as_path(path)
    text = read_text(path)
    if isinstance(text, Problem):
        raise _error(path, [text])
    return from_text(text, path)


def from_text(text: str, path: Path) -> Project:
    """Read the text of a project file that is, or could be, at a path (ProjectError as `read_project`)."""
    located = read(text)
    content, wrong = with_python_laws(located, path.parent)
    problems = [*located.problems, *wrong]
    if located.content is None:
        if not problems:
            problems.append(Problem(1, 1, "file", "is empty; begin with a line such as 'gear: CSG-40-50'"))
        raise _error(path, problems)
    try:
        spec = ProjectSpec.model_validate(content)
    except ValidationError as error:
        problems += complaints(error, located)
        if not isinstance(located.content, dict):
            raise _error(path, problems) from None
        spec = _what_is_right(content)
    gear: Gear | ExplicitGear | None = None
    elsewhere = ""
    try:
        gear = _gear(spec, path)
    except FileError as error:
        elsewhere = str(error)
    except ValueError as error:
        problems.append(Problem(*located.place(("gear", "name")), "gear.name", str(error)))
    else:
        found = contradictions(spec, gear if isinstance(gear, Gear) else None, located.content)
        problems += [Problem(*located.place(keys), name(keys), sentence) for keys, sentence in found]
    if problems or elsewhere or gear is None:
        raise ProjectError("\n".join(part for part in (problems and complaint(path, problems), elsewhere) if part))
    project = _resolved(spec, gear, path, text)
    if project.train is not None and (sentence := unstable(project.train, project.loop_inertia)):
        raise _error(path, [Problem(*located.place(("motor", "loop")), "motor.loop", sentence)])
    return project


def _what_is_right(content: dict[str, Any]) -> ProjectSpec:
    """The groups of a file that are right by themselves; None in place of the others."""
    right: dict[str, Any] = {}
    for group, info in ProjectSpec.model_fields.items():
        one = create_model(group, __base__=Spec, **{group: (info.annotation, info)})  # type: ignore[call-overload]
        try:
            given = {group: content[group]} if group in content else {}
            right[group] = getattr(one.model_validate(given), group)
        except ValidationError:
            right[group] = None
    return ProjectSpec.model_construct(**right)


def _gear(spec: ProjectSpec, path: Path) -> Gear | ExplicitGear | None:
    """The gear's record, or the gear that the file writes out; None of a file without."""
    if isinstance(spec.gear, OwnGear):
        file = path.parent / spec.gear.file
        gears = read_gears(file)
        if spec.gear.name not in gears:
            raise ValueError(f"{spec.gear.file} has no gear {shown(spec.gear.name)}; it has {', '.join(gears)[:200]}")
        return gears[spec.gear.name]
    return catalogue.gear(spec.gear) if isinstance(spec.gear, str) else spec.gear


def _error(path: Path, problems: list[Problem]) -> ProjectError:
    return ProjectError(complaint(path, problems))


def _resolved(spec: ProjectSpec, own: Gear | ExplicitGear, path: Path, text: str) -> Project:
    gear, ratio = own if isinstance(own, Gear) else None, float(own.ratio)
    J_m = spec.motor.inertia or (gear.input_inertia if gear is not None else None) or 0.0
    accuracy = spec.excitation.accuracy
    if isinstance(accuracy, str):  # CATALOGUE
        accuracy = None if gear is None else gear.accuracy
    drive = Drive(J_m, whole_inertia(spec.load), ratio, spec.damping.B or 0.0, spec.law(gear))
    drive = drive._replace(B=damping(spec, drive))
    error, through = kinematic_error(spec, accuracy), speeds(spec.speed, ratio)
    varies = spec.damping.varies or spec.stiffness is not None
    whole = None if varies or not through.by_motor else whole_train(spec, drive, error, through.given[0])
    project = Project(
        title=spec.title or path.stem,
        path=path,
        text=text,
        drive=drive,
        gear=gear,
        motor=spec.motor.mode,
        speeds=through,
        motor_torque=torque(spec.excitation.motor_torque),
        load_torque=torque(spec.excitation.load_torque),
        mean_range=mean_range(spec.excitation.load_torque),
        kinematic_error=error,
        damping=spec.damping.of(drive.B) if spec.damping.varies else None,
        stiffness=None if spec.stiffness is None else spec.stiffness.ripples,
        train=whole if beyond_equation(spec, error) else None,
        rated_torque=own.rated_torque,
        limit=None if spec.limit is None else spec.limit.oscillation,
        whole=whole,
        motor_named=spec.motor.named,
        scatter=tuple((spec.scatter or {}).items()),
    )
    said = tuple(notes(project))
    if accuracy is not None:
        said = (ACCURACY_NOTE.format(convert(accuracy, "rad", "arcsec")), *said)
    if spec.speed.low == 0.0:
        begin = f"{through.own(through.limits[0]):.4g} {through.own_unit}"
        said = (*said, f"The speed range is given from 0, where nothing turns; it begins at 1 % of its end, {begin}.")
    return replace(project, notes=said)
