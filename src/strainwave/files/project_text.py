"""A project, or a whole drive train built in Python, written as a project file."""

import math
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

from ..base.protocols import Law
from ..base.quantities import checked, interval, number, shown
from ..compile.tree import leaves
from ..drive.demands.motor_limits import MotorLimits
from ..drive.project import Project
from ..drive.sources import DriveUnit
from ..drive.speeds import Speeds
from ..model.error_spectrum import LoadedError
from ..model.excitation import Harmonic, Harmonics, KinematicError, NoError
from ..model.laws.friction import LoadFriction, NoFriction
from ..model.laws.hysteresis import Parallel
from ..model.laws.springs import Play
from ..model.oscillator import NoVariation
from ..model.train.drive_train import DriveTrain
from ..model.train.motion import Steady
from ..model.train.shafts import NO_DRAG, Load
from ..study.tuning.loop import with_control
from .fields import groups, schema
from .fields.drive_units import DriveUnitsSpec
from .fields.postures import PostureSpec
from .fields.rows import texts_of
from .loop_text import by_bandwidth, with_loop
from .reading import ProjectError, from_text


def project_text(
    source: Project | DriveTrain, omega: float | tuple[float, float] | None = None, *, title: str = ""
) -> str:
    """Write a project or a drive train as a project file that reads back as the same drive.

    Parameters
    ----------
    source : Project or DriveTrain
        A project as `read_project` returns it, changed by `dataclasses.replace` or not; or a train as `Drive.train`
        returns it: law, damping, kinematic error and torques, with loop, drag of the shafts and couplings, where it has
        them.
    omega : float or (float, float), optional
        Of a train: speed of the motor [rad/s], or a range. Default: that of the train.
    title : str, optional
        Of a train: title of the report.

    Returns
    -------
    str
        Of a project that is still what its file says, the text of that file; of one whose loop alone is another, that
        text with the other loop, gains to ten digits of the author's units. Else YAML in SI units, with every number
        as it is. A line of negative amplitude is written with its size and the phase moved by half a turn.

    Raises
    ------
    ValueError
        With what a project file does not hold.
    """
    if isinstance(source, Project):
        return _of_project(source)
    train = checked(source)
    if not isinstance(train.reference, Steady):
        fault = f"a project file needs constant speeds, but this train follows {train.reference}; use it in Python"
        raise ValueError(fault)
    text = _file(
        title=title or None,
        gear=schema.ExplicitGear(ratio=train.N, law=train.law),
        load_friction=_friction(train.friction),
        motor=_motor(train.motor, "free" if train.motor.free else "held"),
        load=_load(train.load),
        damping=schema.DampingSpec(B=train.B),
        speed=_speed(train.omega if omega is None else omega),
        excitation=groups.ExcitationSpec(
            kinematic_error=_error(train.error, train.N),
            motor_torque=_torque("the motor", train.motor.excitation),
            load_torque=_torque("the load", train.load.end().excitation),
        ),
    )
    try:
        from_text(text, Path("project.yaml"))
    except ProjectError as error:
        raise ValueError(f"a project file cannot hold this train: {error}") from error
    return text


def _of_project(project: Project) -> str:
    """Text of a project that reads back equal: the file's own, or one that is written from its parts."""
    if _reads_as(project, project.text):
        return project.text
    project = _without_bandwidth(project)
    edited = project.whole and with_loop(project.text, project.whole.motor.control)
    if edited and _reads_as(project, edited):
        return edited
    project = _written_scatter(project)
    for gear in _gears(project):
        if _reads_as(project, text := _file(**gear, **_parts(project))):
            return text
    raise ValueError(
        f"project {project.title!r} cannot be written as a project file: its parts contradict each other (a changed "
        "drive needs a changed train and whole), or files do not support them; change the file, or use it in Python"
    )


def _without_bandwidth(project: Project) -> Project:
    """The project without the scatter of a loop's bandwidth, beside gains."""
    kept = [i for i, (name, _) in enumerate(project.scatter) if not by_bandwidth(name)]
    table = project.correlation and tuple(tuple(project.correlation[i][j] for j in kept) for i in kept)
    return replace(project, scatter=tuple(project.scatter[i] for i in kept), correlation=table)


def _written_scatter(project: Project) -> Project:
    """The project with the scatter of what is written: B for a ratio of damping."""
    names = {"damping.ratio": "damping.B", "damping.quality": "damping.B"}  # B is as many percent off as they are
    return replace(project, scatter=tuple((names.get(name, name), share) for name, share in project.scatter))


def _reads_as(project: Project, text: str) -> bool:
    """True for a text that reads as this project but for its notes, which follow from the file; gains to 1e-9."""
    try:
        reread = from_text(text, project.path)
    except ProjectError:
        return False
    loops = [(one.whole and one.whole.motor.control) or () for one in (project, reread)]
    gains, other_gains = map(leaves, loops)
    if gains != other_gains and len(gains) == len(other_gains) and all(map(math.isclose, gains, other_gains)):
        reread = with_control(reread, loops[0])
    return replace(reread, text=project.text, notes=project.notes, gear=project.gear) == project


def _file(**groups: Any) -> str:
    return "".join(f"{name}: {text}\n" for name, text in texts_of(schema.ProjectSpec(**groups)).items())


def _gears(project: Project) -> Iterator[dict[str, Any]]:
    """Ways to write the gear, the shortest first: by its name in the catalogue, with a law of its own, in full."""
    law, additions = project.drive.law, dict[str, Any]()
    ratio, rated = project.drive.N, project.rated_torque
    fixed = None if project.arrangement is None else project.arrangement.fixed.replace(" ", "_")
    in_full = {"gear": schema.ExplicitGear(ratio=ratio, law=law, rated_torque=rated, fixed=fixed)}
    if isinstance(law, Parallel):
        additions["hysteresis"], law = law.second, law.first
    if isinstance(law, Play):
        additions["backlash"], law = schema.BacklashSpec(half_gap=law.half_gap), law.law
    if project.gear is not None:
        name = project.gear.name
        yield {"gear": schema.NamedGear(name=name, fixed=fixed) if fixed else name, **additions}
        yield {"gear": schema.NamedGear(name=name, law=law, fixed=fixed), **additions}
    yield in_full
    yield {"gear": schema.ExplicitGear(ratio=ratio, law=law, rated_torque=rated, fixed=fixed), **additions}


def _parts(project: Project) -> dict[str, Any]:
    """Every group of a project but the gear."""
    drive, load = project.drive, project.load_torque or Harmonics((Harmonic(0.0),))
    train, free = project.subject, project.motor_torque
    mode = project.motor if project.motor_named else None
    return {
        "title": project.title,
        "revision": project.revision,
        "load_friction": _friction(train.friction),
        "motor": _motor(train.motor, mode, project.motor_limits, project.drive_units),
        "controller": project.sampling and groups.ControllerSpec.of(project.sampling),
        "load": _load(train.load),
        "damping": _damping(project),
        "stiffness": project.stiffness and schema.StiffnessSpec(ripples=project.stiffness),
        "speed": _speeds(project.speeds),
        "excitation": groups.ExcitationSpec(
            kinematic_error=_loaded(project.loaded_error, drive.N) or _error(project.kinematic_error, drive.N),
            motor_torque=None if free is None else _torque("the motor", free),
            load_torque=_torque("the load", load, project.mean_range),
        ),
        "scatter": dict(project.scatter) or None,
        "scatter_correlation": project.correlation,
        "sources": dict(_kept(project)) or None,
        "limit": None if project.limit is None else schema.LimitSpec(oscillation=project.limit),
        "move": project.move and schema.MoveSpec.of(project.move),
        "postures": [PostureSpec(**row._asdict() | {"name": row.name or None}) for row in project.postures] or None,
    }


def _kept(project: Project) -> Iterator[tuple[str, str]]:
    """Sources that the file must name: those of its numbers, not of what follows from a name or a default."""
    for one in project.sources:
        if one.word in (groups.ASSUMED, groups.MEASURED, groups.CATALOGUE) and not one.why and one.name != "gear":
            group_names = (g for g in ("damping", "motor.loop") if one.name.startswith(f"{g}."))
            yield next(group_names, one.name), one.word


def _damping(project: Project) -> schema.DampingSpec:
    numbers = ({} if project.damping is None else project.damping._asdict()) | {"B": project.drive.B}
    ripples = numbers.pop("variation", None)
    return schema.DampingSpec(ripples=None if isinstance(ripples, NoVariation) else ripples, **numbers)


def _speeds(speeds: Speeds) -> schema.SpeedSpec:
    """Speeds of the shaft that they were given for: the numbers that times the ratio give those of the base angle."""
    given = tuple(_share(omega, speeds.ratio) for omega in speeds.given)
    if speeds.single:
        return schema.SpeedSpec(at=given, shaft=speeds.shaft)
    return schema.SpeedSpec(**{"from": given[0], "to": given[1], "shaft": speeds.shaft})


def _share(omega: float, ratio: float) -> float:
    """Number that times the ratio is omega, to the bit where there is one."""
    neighbours = [math.nextafter(omega / ratio, omega / ratio + direction) for direction in (0.0, -math.inf, math.inf)]
    return next((value for value in neighbours if value * ratio == omega), neighbours[0])


def _drag(law: Law) -> Any:
    return None if (type(law), law) == (type(NO_DRAG), NO_DRAG) else law  # equal numbers make no equal law


def _friction(friction: object) -> float | None:
    if isinstance(friction, NoFriction):
        return None
    if not isinstance(friction, LoadFriction) or friction != LoadFriction(friction.mu):
        usual = LoadFriction(0.0).width
        raise ValueError(
            f"a project file holds load-proportional friction smoothed over {usual:g} rad/s, and this train has "
            f"{shown(friction)}; use it in Python"
        )
    return friction.mu


def _motor(
    motor: Any, mode: str | None, limits: MotorLimits | None = None, units: tuple[DriveUnit, ...] = ()
) -> schema.MotorSpec:  # fmt: skip
    return schema.MotorSpec(
        inertia=motor.J or None,
        mode=mode,
        loop=None if motor.free or motor.held else motor.control,
        drag=_drag(motor.drag),
        drive_units=DriveUnitsSpec.of(units),
        **schema.MotorSpec.sheet_of(limits),
    )


def _load(load: Any) -> schema.LoadSpec:
    chain = []
    while not isinstance(load, Load):
        chain.append(schema.CouplingSpec(inertia=load.J, B=load.B, law=load.law))
        load = load.load
    chained = {"coupling": chain[0]} if len(chain) == 1 else {"couplings": chain or None}
    return schema.LoadSpec(inertia=load.J, drag=_drag(load.drag), **chained)


def _speed(omega: Any) -> schema.SpeedSpec:
    if isinstance(omega, tuple | list):
        low, high = interval("omega [rad/s]", omega, positive=True)
        return schema.SpeedSpec(**{"from": low, "to": high, "shaft": "motor"})
    return schema.SpeedSpec(at=(number("omega [rad/s]", omega, positive=True),), shaft="motor")


def _torque(where: str, torque: object, means: tuple[float, float] | None = None) -> groups.TorqueSpec | None:
    if not isinstance(torque, Harmonic | Harmonics):
        has = f"{where} has {shown(torque)}; use it in Python"
        raise ValueError(f"a project file holds torques as harmonics, and {has}")
    terms = torque.terms if isinstance(torque, Harmonics) else (torque,)
    lines = [groups.TorqueLine.of(term) for term in terms if term.amplitude]
    span = means and groups.TorqueRange(**{"from": means[0], "to": means[1]})
    mean = span or sum(term.mean for term in terms) or None
    group = groups.LoadTorqueSpec(mean=mean, lines=lines or None)
    return group if group.given else None


def _error(error: object, ratio: float) -> list[groups.ErrorLine] | None:
    if error is None or isinstance(error, NoError):
        return None
    if not isinstance(error, KinematicError):
        raise ValueError(f"a project file holds lines of a kinematic error, not {shown(error)}; use it in Python")
    return [groups.ErrorLine.of(line, ratio) for line in error.lines]


def _loaded(error: LoadedError | None, ratio: float) -> list[groups.ErrorLine]:
    """Lines whose amplitudes depend on torque or direction; none of a project without such."""
    if error is None:
        return []
    back = error.at_rest if error.backward is None else error.backward
    rows = zip(error.at_rest.lines, error.per_torque, back.lines, strict=True)
    return [groups.ErrorLine.of(line, ratio, growth, other.amplitude) for line, growth, other in rows]
