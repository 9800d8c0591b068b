"""The project file: a drive, its speed and what excites it, read from YAML with units and resolved to SI."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

from pydantic import ValidationError

from ..model import catalogue
from ..model.drive import Drive
from ..model.error_spectrum import accuracy_spectrum
from ..model.excitation import Harmonic, Harmonics, KinematicError, Line
from ..model.gear import Gear
from ..model.oscillator import Oscillator
from ..quantities import convert
from .complaints import complaints
from .own_gears import read_gears
from .schema import CATALOGUE, ExplicitGear, OwnGear, ProjectSpec, TorqueSpec
from .yaml_text import FileError, Keys, Problem, complaint, name, read, read_text, shown

ACCURACY_NOTE = (
    "The kinematic error stands for an accuracy class of {:.4g} arcsec peak-to-peak: its orders 1, 2 and 4 share it as "
    "1 : 4 : 1 by assumption; a measured scan (strainwave error-scan) replaces the assumption."
)


class ProjectError(FileError):
    """A project file cannot be used; one line `file:line:column: field: fact, value, remedy` per problem."""


UNUSUAL = 0.5  # damping ratio


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
        Inertias, ratio, damping B [N*m*s/rad] and torsion law.
    gear : Gear or None
        The record of the catalogue or of the user's own file, or None for an explicit law.
    motor : {"free", "held"}
        Whether the motor follows its torque or keeps its speed.
    shaft : {"motor", "load", "forcing"}
        The shaft that the file's speeds belong to; with "forcing" the base angle is the forcing phase itself.
    omega : tuple of float
        Speeds of the base angle [rad/s], ascending: the ends of the range if `is_range`, else every speed asked for.
    is_range : bool
        Whether the file gives a range (`from`, `to`) rather than single speeds (`at`).
    motor_torque, load_torque : Harmonics or None
        Torques [N*m] on the motor (motor side) and on the load (output side, a resisting load is negative).
    kinematic_error : KinematicError or None
        Lines of the gear's kinematic error [rad, output side].
    notes : tuple of str
        Sentences for the reader: doubts about the catalogue data, a motor inertia that cannot be right. What the run
        asks of the gear beyond its limits is in the analysis.
    """

    title: str
    path: Path
    text: str
    drive: Drive
    gear: Gear | None
    motor: Literal["free", "held"]
    shaft: Literal["motor", "load", "forcing"]
    omega: tuple[float, ...]
    is_range: bool
    motor_torque: Harmonics | None
    load_torque: Harmonics | None
    kinematic_error: KinematicError | None
    notes: tuple[str, ...] = ()

    @property
    def J(self) -> float:
        """Inertia [kg m^2] of the error equation in the project's motor mode."""
        return self.drive.J if self.motor == "free" else self.drive.J_l

    @property
    def omega_0(self) -> float:
        """Natural frequency [rad/s] in the project's motor mode; 0 where the law has no stiffness at rest (play)."""
        return self.drive.omega_0 if self.motor == "free" else self.drive.omega_0_held

    @property
    def damping_ratio(self) -> float | None:
        """Damping ratio B/(2 J omega_0) in the project's motor mode, or None where omega_0 is 0."""
        return self.drive.B / (2.0 * self.J * self.omega_0) if self.omega_0 else None

    def shaft_speed(self, omega: float) -> float:
        """Speed [rad/s] of the file's shaft when the base angle turns at `omega` [rad/s]."""
        return omega / self.drive.N if self.shaft == "load" else omega

    def system(self, omega: float) -> Oscillator:
        """Error equation at the base-angle speed `omega` [rad/s]."""
        return self.drive.error_equation(
            motor_torque=self.motor_torque,
            load_torque=self.load_torque,
            kinematic_error=self.kinematic_error,
            omega=omega,
            motor=self.motor,
        )


def load(path: str | Path) -> Project:
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
    path = Path(path)
    text = read_text(path)
    if isinstance(text, Problem):
        raise _error(path, [text])
    located = read(text)
    problems = list(located.problems)
    spec = None
    if located.content is not None:
        try:
            spec = ProjectSpec.model_validate(located.content)
        except ValidationError as error:
            problems += complaints(error, located)
    elif not problems:
        problems.append(Problem(1, 1, "file", "is empty; begin with a line such as 'gear: CSG-40-50'"))
    gear = None
    if spec is not None:
        try:
            gear = _record(spec, path)
        except FileError as error:
            raise ProjectError(str(error)) from None
        except ValueError as error:
            problems.append(Problem(*located.place(("gear", "name")), "gear.name", str(error)))
        else:
            found = _contradictions(spec, gear)
            problems += [Problem(*located.place(keys), name(keys), sentence) for keys, sentence in found]
    if problems or spec is None:
        raise _error(path, problems)
    return _resolved(spec, gear, path, text)


def _record(spec: ProjectSpec, path: Path) -> Gear | None:
    """Look up the record of the project's gear."""
    if isinstance(spec.gear, OwnGear):
        file = path.parent / spec.gear.file
        gears = read_gears(file)
        if spec.gear.name not in gears:
            raise ValueError(f"{spec.gear.file} has no gear {shown(spec.gear.name)}; it has {', '.join(gears)[:200]}")
        return gears[spec.gear.name]
    return None if isinstance(spec.gear, ExplicitGear) else catalogue.gear(spec.gear)


def _error(path: Path, problems: list[Problem]) -> ProjectError:
    return ProjectError(complaint(path, problems))


def _contradictions(spec: ProjectSpec, gear: Gear | None) -> Iterator[tuple[Keys, str]]:
    """Fields that are right by themselves but do not go together."""
    driven = spec.excitation
    if gear is not None and gear.input_inertia is None and spec.motor.inertia is None:
        yield ("motor", "inertia"), f"is missing and no source gives it for {gear.name}; write 'inertia: 4.5 kg*cm^2'"
    if isinstance(spec.gear, ExplicitGear):
        if spec.motor.inertia is None:
            yield ("motor", "inertia"), "is missing for an explicit gear; write for example 'inertia: 4.5 kg*cm^2'"
        if spec.damping.B is None and not spec.gear.law.model().stiffness(0.0) > 0.0:
            way = "ratio" if spec.damping.ratio is not None else "quality"
            yield ("damping", way), "has no meaning for a law without stiffness at rest (play); write B: 10 N*m*s/rad"
    if spec.motor.mode == "held" and driven.motor_torque is not None:
        sentence = "a held motor keeps its speed whatever its torque; remove it or write 'mode: free' under motor"
        yield ("excitation", "motor_torque"), sentence
    torques = [t for t in (driven.motor_torque, driven.load_torque) if t is not None]
    amplitudes = [line.amplitude for line in driven.kinematic_error]
    amplitudes += [line.amplitude for torque in torques for line in torque.lines]
    yield from _accuracy_problems(spec, gear)
    if not any(amplitudes) and driven.accuracy is None:
        sentence = (
            "nothing periodic drives the error; write for example 'kinematic_error: [{order: 2, amplitude: 23 arcsec}]'"
        )
        yield ("excitation",), sentence


def _accuracy_problems(spec: ProjectSpec, gear: Gear | None) -> Iterator[tuple[Keys, str]]:
    """What an accuracy class does not go together with."""
    accuracy, field = spec.excitation.accuracy, ("excitation", "accuracy")
    if accuracy is None:
        return
    if spec.excitation.kinematic_error:
        yield field, "stands beside kinematic_error, which it would be a guess of; remove one of them"
    if spec.speed.shaft == "forcing":
        yield field, "belongs to the motor's turn, and the speeds to the forcing's; write 'shaft: motor' under speed"
    if accuracy == CATALOGUE and (gear is None or gear.accuracy is None):
        name = "an explicit gear" if gear is None else gear.name
        yield field, f"no source gives one for {name}; write it as an angle, for example 1 arcmin"


def _kinematic_error(spec: ProjectSpec, gear: Gear | None) -> KinematicError | None:
    """Lines of the file, or those of its accuracy class."""
    accuracy = spec.excitation.accuracy
    if accuracy is not None:
        return accuracy_spectrum(_class_of(spec, gear))
    error = tuple(Line(line.order, line.amplitude, line.phase) for line in spec.excitation.kinematic_error)
    return KinematicError(error) if error else None


def _class_of(spec: ProjectSpec, gear: Gear | None) -> float:
    accuracy = gear.accuracy if gear is not None and spec.excitation.accuracy == CATALOGUE else spec.excitation.accuracy
    assert isinstance(accuracy, float)
    return accuracy


def _resolved(spec: ProjectSpec, gear: Gear | None, path: Path, text: str) -> Project:
    J_m = spec.motor.inertia or (gear.input_inertia if gear is not None else None) or 0.0
    if isinstance(spec.gear, ExplicitGear):
        law, ratio = spec.gear.law.model(), spec.gear.ratio
    else:
        assert gear is not None
        law, ratio = gear.law, float(gear.ratio)
    drive = Drive(J_m, spec.load.inertia, ratio, spec.damping.B or 0.0, law)
    drive = drive._replace(B=_damping(spec, drive))
    factor = ratio if spec.speed.shaft == "load" else 1.0
    speeds = spec.speed.at or [s for s in (spec.speed.low, spec.speed.high) if s is not None]
    project = Project(
        title=spec.title or path.stem,
        path=path,
        text=text,
        drive=drive,
        gear=gear,
        motor=spec.motor.mode,
        shaft=spec.speed.shaft,
        omega=tuple(sorted({factor * s for s in speeds})),
        is_range=spec.speed.at is None,
        motor_torque=_torque(spec.excitation.motor_torque),
        load_torque=_torque(spec.excitation.load_torque),
        kinematic_error=_kinematic_error(spec, gear),
    )
    notes = tuple(_notes(project))
    if spec.excitation.accuracy is not None:
        notes = (ACCURACY_NOTE.format(convert(_class_of(spec, gear), "rad", "arcsec")), *notes)
    return replace(project, notes=notes)


def _damping(spec: ProjectSpec, drive: Drive) -> float:
    """Return B [N*m*s/rad]; a ratio and a quality refer to omega_0 at rest in the project's motor mode."""
    if spec.damping.B is not None:
        return spec.damping.B
    ratio = spec.damping.ratio if spec.damping.quality is None else 0.5 / spec.damping.quality
    J, omega_0 = (drive.J, drive.omega_0) if spec.motor.mode == "free" else (drive.J_l, drive.omega_0_held)
    return 2.0 * (ratio or 0.0) * J * omega_0


def _torque(spec: TorqueSpec | None) -> Harmonics | None:
    if spec is None or (not spec.lines and not spec.mean):
        return None
    lines = [Harmonic(line.amplitude, line.order, line.phase) for line in spec.lines] or [Harmonic(0.0)]
    return Harmonics((lines[0]._replace(mean=spec.mean), *lines[1:]))


def _torque_notes(project: Project) -> Iterator[str]:
    """Notes on mean torques that a free motor cannot balance and on damping that no gear has."""
    drive = project.drive
    at_motor, at_load = (
        0.0 if t is None else sum(h.mean for h in t.terms) for t in (project.motor_torque, project.load_torque)
    )
    whole = drive.N * at_motor + at_load
    if project.motor == "free" and abs(whole) > 1e-9 * (abs(drive.N * at_motor) + abs(at_load)):
        rate = drive.N * whole / (drive.N * drive.N * drive.J_m + drive.J_l)
        yield (
            f"The mean torques do not balance: the motor speeds up by {rate:.4g} rad/s^2 and does not keep the speeds "
            f"analysed; give the free motor a mean torque of {-at_load / drive.N:.4g} N*m, or write 'mode: held'."
        )
    if project.damping_ratio is not None and project.damping_ratio > UNUSUAL:
        yield (
            f"The damping ratio is {project.damping_ratio:.3g} ({100.0 * project.damping_ratio:.3g} % of critical); "
            "0.01 to 0.05 is usual, and 4 % is written '4 %' or 0.04."
        )


def _notes(project: Project) -> Iterator[str]:
    """Sentences on what a reader of the results should know about the input."""
    yield from _torque_notes(project)
    gear = project.gear
    if project.motor == "free" and project.kinematic_error is not None:
        yield (
            "With a free motor and a kinematic error the reduction to one equation drops the motor's speed ripple, "
            "an error of up to about a fifth near resonance; a stiff speed loop is described by 'mode: held'."
        )
    if gear is None:
        return
    yield from gear.notes
    if gear.input_inertia is not None and project.drive.J_m < gear.input_inertia:
        yield (
            f"motor.inertia is {project.drive.J_m:g} kg*m^2, less than the {gear.input_inertia:g} kg*m^2 of the wave "
            f"generator of {gear.name} alone; it must include the wave generator."
        )
