"""Reading a project file: YAML with units, resolved to a `Project` in SI, or every problem with its line and column.

From the fields of a project file to the project in SI: speeds, excitation, damping, the drive train.
"""

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from itertools import starmap
from pathlib import Path
from typing import NamedTuple, TypeVar

from ..base.number_text import number
from ..base.quantities import checked, convert
from ..base.terminal import printable
from ..drive.demands.motor_limits import MotorLimits
from ..drive.demands.move_task import Task
from ..drive.loops.instability import instability
from ..drive.postures import Posture, refuse_twice
from ..drive.project import Project
from ..drive.speeds import Speeds
from ..model.drive import Drive
from ..model.error_spectrum import LoadedError, accuracy_spectrum
from ..model.excitation import Harmonic, Harmonics, KinematicError, mean_torque
from ..model.gears import catalogue
from ..model.gears.gear import Gear
from ..model.laws.friction import NO_FRICTION, LoadFriction, NoFriction
from ..model.orders import BY_FIXED
from ..model.train.controls import FREE, Held, Tuning
from ..model.train.drive_train import DriveTrain
from ..model.train.filters import control_of
from ..model.train.shafts import NO_DRAG, Elastic
from .contradictions import contradictions
from .fields.groups import CATALOGUE, TorqueRange, TorqueSpec
from .fields.postures import postures_of
from .fields.python_law import with_python_laws
from .fields.rows import read_file
from .fields.schema import ExplicitGear, NamedGear, ProjectSpec, SpeedSpec
from .notes import notes, posture_note
from .own_gears import read_gears
from .sources import class_assumed, sources_of
from .yaml_text import FileError, Keys, Located, Problem, complaint, name, read, refuse, shown, text_of

T = TypeVar("T")
ACCURACY_NOTE = (
    "Assumed kinematic error: accuracy class {:.4g} arcsec peak-to-peak{}, orders 1, 2, 4 in the ratio 1 : 4 : 1, all "
    "phases zero. At very low speed the error is then ±{} arcsec, 65 % of the peak-to-peak class (50 to 65 % for "
    "random phases). A measured scan (strainwave order-scan) replaces the assumption."
)
FROM_REST = 0.01  # of the end of a range from 0: where it begins
REST_NOTE = "The speed range starts at 0; computed is the range from 1 % of its upper end, {}."


def resolved(
    spec: ProjectSpec, gear_entry: Gear | ExplicitGear, path: Path, text: str, sheet: MotorLimits | None
) -> Project:  # fmt: skip
    """Return the project that the fields of a file describe, with its notes; `text` is that of the file."""
    gear = gear_entry if isinstance(gear_entry, Gear) else None
    ratio, fixed = spec.ratio(gear), getattr(spec.gear, "fixed", None)
    J_l = spec.load.inertia + sum(coupling.inertia for coupling in spec.load.chain)  # that of a rigid load
    J_m = spec.motor.inertia or (gear.input_inertia if gear is not None else None) or 0.0
    excited, accuracy = spec.excitation, spec.excitation.accuracy
    if isinstance(accuracy, str):  # CATALOGUE or SPECIAL
        accuracy = None if gear is None else gear.accuracy_of(accuracy)
    drive = Drive(J_m, J_l, ratio, spec.damping.B or 0.0, spec.law(gear))
    drive = drive._replace(B=damping(spec, drive))
    error, through = kinematic_error(spec, accuracy, ratio), speeds(spec.speed, ratio)
    load_torque, loaded_error = torque(excited.load_torque), loaded(spec, error, ratio)
    if loaded_error is not None:
        error = loaded_error.under(-mean_torque(load_torque))
    project = Project(
        title=spec.title or printable(path.stem),
        revision=spec.revision,
        path=path,
        text=text,
        subject=drive_train(spec, drive, gear, error, through.given[0]),
        gear=gear,
        speeds=through,
        mean_range=None if excited.load_torque is None else excited.load_torque.range,
        loaded_error=loaded_error,
        damping=spec.damping.of(drive.B) if spec.damping.varies else None,
        stiffness=None if spec.stiffness is None else spec.stiffness.ripples,
        rated_torque=gear_entry.rated_torque,
        limit=None if spec.limit is None else spec.limit.oscillation,
        motor_named=spec.motor.named,
        motor_limits=sheet,
        sampling=None if spec.controller is None else spec.controller.sampling(sheet),
        drive_units=() if spec.motor.drive_units is None else spec.motor.drive_units.sizes,
        arrangement=None if fixed is None else BY_FIXED[fixed],
        scatter=tuple((spec.scatter or {}).items()),
        correlation=spec.scatter_correlation,
    )
    facts = tuple(notes(project, isinstance(spec.motor.loop, Tuning)))
    if accuracy is not None:
        itself = " (assumed)" if class_assumed(spec) else ""
        size = convert(accuracy, "rad", "arcsec")
        facts = (ACCURACY_NOTE.format(size, itself, number(0.65 * size, 3)), *facts)
    if spec.speed.from_ == 0.0:
        begin = f"{through.own(through.limits[0]):.4g} {through.own_unit}"
        facts = (*facts, REST_NOTE.format(begin))
    return replace(project, notes=facts)


def kinematic_error(spec: ProjectSpec, accuracy: float | None, ratio: float) -> KinematicError | None:
    """Lines of the file without a torque, or those of an accuracy class [rad]."""
    if accuracy is not None:
        return accuracy_spectrum(accuracy)
    error = tuple(line.line(ratio) for line in spec.excitation.kinematic_error)
    return checked(KinematicError(error)) if error else None


def loaded(spec: ProjectSpec, at_rest: KinematicError | None, ratio: float) -> LoadedError | None:
    """Lines by torque and direction of motion, where one of the file depends on these."""
    lines = spec.excitation.kinematic_error
    backward = tuple(line.line(ratio, backward=True) for line in lines)
    error = None if all(line.alike for line in lines) else checked(KinematicError(backward))
    growth = tuple(line.per_torque for line in lines)
    return LoadedError(at_rest, growth, error) if at_rest and (error or any(growth)) else None


def speeds(spec: SpeedSpec, ratio: float) -> Speeds:
    """The range or the single speeds, of the base angle."""
    factor = ratio if spec.shaft == "load" else 1.0
    if spec.to is not None and spec.from_ == 0.0:
        return Speeds((FROM_REST * factor * spec.to, factor * spec.to), (), spec.shaft, factor)
    given = sorted({factor * s for s in spec.at or (spec.from_, spec.to) if s is not None})
    if spec.at is not None:
        return Speeds.at(tuple(given), spec.shaft, factor)
    return Speeds((given[0], given[-1]), (), spec.shaft, factor)


def torque(spec: TorqueSpec | None) -> Harmonics | None:
    """A torque [N*m] with its mean, the middle of a range of means, in the first line."""
    if spec is None or (not spec.lines and not spec.mean):
        return None
    lines = [Harmonic(line.amplitude, line.order, line.phase) for line in spec.lines] or [Harmonic(0.0)]
    mean = 0.5 * (spec.mean.from_ + spec.mean.to) if isinstance(spec.mean, TorqueRange) else spec.mean
    return Harmonics((lines[0]._replace(mean=mean), *lines[1:]))


def damping(spec: ProjectSpec, drive: Drive) -> float:
    """B [N*m*s/rad]; a ratio and a quality refer to omega_0 of the spring at rest in the project's mode.

    That spring is the catalogue's K1, or `spring_stiffness` of the law: what hysteresis adds until it yields is not in
    it. The inertia is that of the mode: the load's with the motor held, the reduced one with the motor free.
    """
    if spec.damping.B is not None:
        return spec.damping.B
    ratio = spec.damping.ratio if spec.damping.quality is None else 0.5 / spec.damping.quality
    J, omega_0 = (drive.J, drive.omega_0) if spec.motor.mode == "free" else (drive.J_l, drive.omega_0_held)
    return 2.0 * (ratio or 0.0) * J * omega_0


def friction(spec: ProjectSpec, gear: Gear | None) -> LoadFriction | NoFriction:
    """Friction of the meshing: a share of the torque, or that of the gear's efficiency."""
    if spec.load_friction == CATALOGUE and gear is not None:
        return replace(gear, ratio=round(spec.ratio(gear))).friction
    return LoadFriction(float(spec.load_friction)) if spec.load_friction else NO_FRICTION


def drive_train(
    spec: ProjectSpec, drive: Drive, gear: Gear | None, error: KinematicError | None, omega: float
) -> DriveTrain:  # fmt: skip
    """The train with all that the file has, at a motor speed [rad/s]."""
    excited, control = spec.excitation, FREE if spec.motor.mode == "free" else Held()
    if spec.motor.loop is not None:
        control = control_of(spec.motor.loop, drive.loop_inertia)
    train = drive._replace(J_l=spec.load.inertia).train(
        motor_torque=torque(excited.motor_torque),
        load_torque=torque(excited.load_torque),
        kinematic_error=error,
        omega=omega,
        control=control,
        motor_drag=spec.motor.drag or NO_DRAG,
        load_drag=spec.load.drag or NO_DRAG,
        friction=friction(spec, gear),
    )
    if not spec.load.chain:
        return train
    for coupling in reversed(spec.load.chain):
        train = train._replace(load=Elastic(coupling.inertia, coupling.B, coupling.law, train.load))
    return checked(train)


class ProjectError(FileError):
    """A project file cannot be used; one line `file:line:column: field: fact, value, remedy` per problem."""


def read_project(path: str | Path) -> Project:
    """Read a project file.

    Parameters
    ----------
    path : str or Path
        YAML file of at most 256 KiB, see `examples/projects`.

    Returns
    -------
    Project
        The whole drive, its speeds and what is asked of it, in SI and radians.

    Raises
    ------
    ProjectError
        If the file cannot be read or does not describe a drive; all problems found, one line each.
    """
    path = Path(path)
    return from_text(text_of(path, error=ProjectError), path)


def from_text(text: str, path: Path) -> Project:
    """Read the text of a project file that is, or could be, at a path (ProjectError as `read_project`)."""
    return from_located(read(text), text, path)


def from_located(located: Located, text: str, path: Path) -> Project:
    """Make a project of what was read of a text (ProjectError as `read_project`)."""
    parts = _collected(located, path)
    project = resolved(parts.spec, parts.gear, path, text, parts.sheet)
    project = replace(project, move=parts.move, postures=parts.postures)
    project = replace(project, sources=sources_of(located.content, parts.spec, project.gear))
    project = replace(project, notes=(*project.notes, *posture_note(project)))
    refuse(path, list(starmap(partial(_problem, located), _faults(project))), ProjectError)
    return project


class Parts(NamedTuple):
    """Parts of a project as its file and the other files of its folder have them."""

    spec: ProjectSpec
    gear: Gear | ExplicitGear
    move: Task | None
    sheet: MotorLimits | None
    postures: tuple[Posture, ...]


def _collected(located: Located, path: Path) -> Parts:
    """Collect the parts of a project; ProjectError with all that is wrong in its file and in those it names."""
    content, wrong = with_python_laws(located, path.parent)
    spec, problems = read_file(content, ProjectSpec, located)
    problems += wrong
    if spec is None:
        raise ProjectError(complaint(path, problems))
    gear: Gear | ExplicitGear | None = None
    elsewhere: list[str] = []

    def of_files(part: Callable[[Path], T]) -> T | None:
        """A part of the project that other files of its folder have; None where these are wrong."""
        try:
            return part(path.parent)
        except FileError as error:
            elsewhere.append(str(error))
            return None

    move = None if spec.move is None else of_files(spec.move.task)
    sheet = None if spec.motor is None else of_files(spec.motor.limits)
    if sheet is not None and (fault := sheet.crossing()):
        problems.append(_problem(located, ("motor", "continuous_torque"), fault))
    postures = of_files(lambda folder: postures_of(spec.postures, folder)) or ()
    try:
        gear = of_files(lambda folder: _gear(spec, folder))
    except ValueError as error:
        problems.append(_problem(located, ("gear", "name"), str(error)))
    if gear is not None or spec.gear is None:
        faults = contradictions(spec, gear if isinstance(gear, Gear) else None, located.content)
        problems += starmap(partial(_problem, located), faults)
    if problems or elsewhere or gear is None:
        raise ProjectError("\n".join(part for part in (problems and complaint(path, problems), *elsewhere) if part))
    (sheet or MotorLimits()).check()
    return Parts(spec, gear, move, sheet, postures)


def _problem(located: Located, keys: Keys, sentence: str) -> Problem:
    return Problem(*located.position(keys), name(keys), sentence)


def _faults(project: Project) -> Iterator[tuple[Keys, str]]:
    """Fields, with a sentence, of a posture that the drive cannot take, and else of a loop that is unstable."""
    try:
        refuse_twice(project.postures)
        for posture in project.postures:
            posture.on(project)
    except ValueError as error:
        yield ("postures",), str(error)
        return
    train = project.train
    if train is not None and project.loop_fault and (sentence := instability(train, project.loop_inertia)):
        yield ("motor", "loop"), sentence


def _gear(spec: ProjectSpec, folder: Path) -> Gear | ExplicitGear | None:
    """The gear's record, or the gear that the file writes out; None of a file without."""
    if not isinstance(spec.gear, NamedGear):
        return catalogue.gear(spec.gear) if isinstance(spec.gear, str) else spec.gear
    if spec.gear.file is None:
        return catalogue.gear(spec.gear.name)
    gears = read_gears(folder / spec.gear.file)
    if spec.gear.name not in gears:
        raise ValueError(f"{spec.gear.file} has no gear {shown(spec.gear.name)}; it has {', '.join(gears)[:200]}")
    return gears[spec.gear.name]
