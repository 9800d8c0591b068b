"""A project, or a whole drive train built in Python, written as a project file."""

import json
import math
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

from ..base.quantities import checked, interval, number, shown
from ..base.speeds import Speeds
from ..drive.asked import MotorLimits
from ..drive.project import Project
from ..model.excitation import Harmonic, Harmonics, KinematicError, NoError
from ..model.laws.hysteresis import Parallel
from ..model.laws.meshing import LoadFriction, NoFriction
from ..model.laws.springs import Play
from ..model.train.controls import Lagged
from ..model.train.drive_train import DriveTrain
from ..model.train.motion import Steady
from ..model.train.shafts import NO_DRAG, Load
from ..model.varying import Variation
from .controller import controller_text
from .entries import deviation_text, project_entry
from .move_fields import task_text
from .reading import ProjectError, from_text

NEIGHBOURS = (0.0, -math.inf, math.inf)


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
        Of a project that is still what its file says, the text of that file. Else YAML in SI units, with every number
        as it is. A line of negative amplitude is written with its size and the phase moved by half a turn.

    Raises
    ------
    TypeError
        If it is neither.
    ValueError
        With what a project file does not hold.
    """
    if isinstance(source, Project):
        return _of_project(source)
    if not isinstance(source, DriveTrain):
        raise TypeError(
            f"project_text takes a Project or a DriveTrain, not {shown(source)}; drive.train(...) gives a train"
        )
    train = checked(source)
    if not isinstance(train.reference, Steady):
        raise ValueError(
            f"a project file has constant speeds, and this train follows {train.reference}; use it in Python"
        )
    groups = {
        "title": json.dumps(title, ensure_ascii=False) if title else "",
        "gear": f"{{ratio: {train.N!r}, law: {project_entry(train.law)}}}",
        "load_friction": _friction(train.friction),
        "motor": _motor(train.motor),
        "load": _load(train.load),
        "damping": f"{{B: {train.B!r} N*m*s/rad}}",
        "speed": _speed(train.omega if omega is None else omega),
        "excitation": _excitation(train),
    }
    text = "".join(f"{name}: {group}\n" for name, group in groups.items() if group)
    try:
        from_text(text, Path("project.yaml"))
    except ProjectError as error:
        raise ValueError(f"a project file does not take this train: {error}") from error
    return text


def _of_project(project: Project) -> str:
    """Text of a project that reads back equal: the file's own, or one that is written from its parts."""
    if _reads_as(project, project.text):
        return project.text
    for gear in _gears(project):
        text = "".join(f"{name}: {group}\n" for name, group in {**gear, **_parts(project)}.items() if group)
        if _reads_as(project, text):
            return text
    raise ValueError(
        f"no project file says what project {project.title!r} holds: its parts contradict each other (a changed drive "
        "needs a changed train and whole, too), or a file does not take them; change the file, or use it in Python"
    )


def _reads_as(project: Project, text: str) -> bool:
    """Whether a text reads as this project but for its notes, which follow from the file."""
    try:
        found = from_text(text, project.path)
    except ProjectError:
        return False
    return replace(found, text=project.text, notes=project.notes, gear=project.gear) == project


def _gears(project: Project) -> Iterator[dict[str, str]]:
    """Ways to write the gear, the shortest first: by its name in the catalogue, with a law of its own, in full."""
    whole = project.drive.law
    beside, law = _beside(whole)
    ratio = repr(project.drive.N)
    rated = "" if project.rated_torque is None else f"{project.rated_torque!r} N*m"
    if project.gear is not None:
        yield {"gear": project.gear.name, **beside}
        yield {"gear": _group(name=project.gear.name, law=project_entry(law)), **beside}
    yield {"gear": _group(ratio=ratio, law=project_entry(whole), rated_torque=rated)}
    yield {"gear": _group(ratio=ratio, law=project_entry(law), rated_torque=rated), **beside}


def _beside(law: Any) -> tuple[dict[str, str], Any]:
    """Hysteresis and backlash as a file has them beside a gear, and the law without them."""
    beside = {}
    if isinstance(law, Parallel):
        beside["hysteresis"], law = project_entry(law.second), law.first
    if isinstance(law, Play):
        beside["backlash"], law = f"{{half_gap: {law.half_gap!r} rad}}", law.law
    return beside, law


def _parts(project: Project) -> dict[str, str]:
    """Every group of a project but the gear."""
    drive = project.drive
    train = project.whole or drive.train(motor_torque=project.motor_torque, load_torque=project.load_torque)
    mode = project.motor if project.motor_named else ""
    motor = train.motor._replace(J=drive.J_m)
    errors = project.kinematic_error
    return {
        "title": json.dumps(project.title, ensure_ascii=False),
        "load_friction": _friction(train.friction),
        "motor": _motor(motor, mode, project.motor_limits),
        "controller": "" if project.sampling is None else controller_text(project.sampling),
        "load": _load(train.load),
        "damping": _damping(project),
        "stiffness": "" if project.stiffness is None else f"{{ripples: {_ripples(project.stiffness)}}}",
        "speed": _speeds(project.speeds),
        "excitation": _group(
            kinematic_error="" if errors is None else _lines(errors.lines, "rad"),
            motor_torque="" if project.motor_torque is None else _torque("the motor", project.motor_torque),
            load_torque=_torque("the load", project.load_torque or Harmonics((Harmonic(0.0),)), project.mean_range),
        ),
        "scatter": _group(**{name: deviation_text(d) for name, d in project.scatter}) if project.scatter else "",
        "scatter_correlation": "" if project.correlation is None else json.dumps(project.correlation),
        "limit": "" if project.limit is None else f"{{oscillation: {project.limit!r} rad}}",
        "move": "" if project.move is None else task_text(project.move),
    }


def _damping(project: Project) -> str:
    varying, B = project.damping, f"{project.drive.B!r} N*m*s/rad"
    if varying is None:
        return _group(B=B)
    names = {"warming": " K", "per_kelvin": " 1/K", "fast": "", "v_fast": " rad/s"}
    numbers = {name: f"{getattr(varying, name)!r}{unit}" for name, unit in names.items()}
    return _group(B=B, ripples=_ripples(varying.variation), **numbers)


def _ripples(variation: Any) -> str:
    """Ripples of a variation; empty where it has none."""
    lines = variation.ripples if isinstance(variation, Variation) else ()
    groups = [_group(order=str(r.order), depth=repr(r.depth), phase=f"{r.phase!r} rad") for r in lines]
    return f"[{', '.join(groups)}]" if groups else ""


def _speeds(speeds: Speeds) -> str:
    """Speeds of the shaft that they were given for: the numbers that times the ratio give those of the base angle."""
    own = [f"{_share(omega, speeds.ratio)!r} rad/s" for omega in speeds.given]
    if speeds.single:
        return _group(at=f"[{', '.join(own)}]", shaft=speeds.shaft)
    return _group(**{"from": own[0], "to": own[1], "shaft": speeds.shaft})


def _share(omega: float, ratio: float) -> float:
    """Number that times the ratio is omega, to the bit where there is one."""
    near = [math.nextafter(omega / ratio, omega / ratio + way) for way in NEIGHBOURS]
    return next((value for value in near if value * ratio == omega), near[0])


def _group(**fields: str) -> str:
    return "{" + ", ".join(f"{name}: {text}" for name, text in fields.items() if text) + "}"


def _drag(law: Any) -> str:
    return "" if (type(law), law) == (type(NO_DRAG), NO_DRAG) else project_entry(law)  # equal numbers make no equal law


def _friction(friction: Any) -> str:
    if isinstance(friction, NoFriction):
        return ""
    if not isinstance(friction, LoadFriction) or friction != LoadFriction(friction.mu):
        usual = LoadFriction(0.0).width
        raise ValueError(
            f"a project file holds load-proportional friction smoothed over {usual:g} rad/s, and this train has "
            f"{shown(friction)}; use it in Python"
        )
    return repr(friction.mu)


def _motor(motor: Any, mode: str | None = None, limits: MotorLimits | None = None) -> str:
    loop = "" if motor.free or motor.held else loop_text(motor.control)
    if mode is None:
        mode = "free" if motor.free else "held"
    inertia = f"{motor.J!r} kg*m^2" if motor.J else ""
    most = limits or MotorLimits()
    torque = f"{most.torque!r} N*m" if math.isfinite(most.torque) else ""
    speed = f"{most.speed!r} rad/s" if math.isfinite(most.speed) else ""
    return _group(
        inertia=inertia, mode=mode, loop=loop, drag=_drag(motor.drag), max_torque=torque, max_speed=speed
    )  # fmt: skip


def loop_text(control: Any) -> str:
    """A loop of the motor by its gains, as a project file has it."""
    if isinstance(control, Lagged):
        return project_entry(control.loop).removesuffix("}") + f", lag: {control.lag!r} s}}"
    return project_entry(control)


def _load(load: Any) -> str:
    couplings = []
    while not isinstance(load, Load):
        B, law = f"{load.B!r} N*m*s/rad", project_entry(load.law)
        couplings.append(_group(inertia=f"{load.J!r} kg*m^2", B=B, law=law))
        load = load.load
    one, more = (couplings[0], "") if len(couplings) == 1 else ("", ", ".join(couplings))
    chain = f"[{more}]" if more else ""
    return _group(inertia=f"{load.J!r} kg*m^2", drag=_drag(load.drag), coupling=one, couplings=chain)


def _speed(omega: Any) -> str:
    if isinstance(omega, tuple | list):
        low, high = interval("omega [rad/s]", omega, positive=True)
        return _group(**{"from": f"{low!r} rad/s", "to": f"{high!r} rad/s", "shaft": "motor"})
    return f"{{at: [{number('omega [rad/s]', omega, positive=True)!r} rad/s], shaft: motor}}"


def _lines(lines: Any, unit: str) -> str:
    written = []
    for line in lines:
        phase = line.phase if line.amplitude >= 0.0 else line.phase + math.pi
        at = f"{phase!r} rad" if phase else ""
        written.append(_group(order=str(line.order), amplitude=f"{abs(line.amplitude)!r} {unit}", phase=at))
    return "[" + ", ".join(written) + "]"


def _torque(where: str, torque: Any, means: tuple[float, float] | None = None) -> str:
    if not isinstance(torque, Harmonic | Harmonics):
        raise ValueError(
            f"a project file holds torques as harmonics, and {where} has {shown(torque)}; use it in Python"
        )
    terms = torque.terms if isinstance(torque, Harmonics) else (torque,)
    mean, lines = sum(term.mean for term in terms), [term for term in terms if term.amplitude]
    said = f"{{from: {means[0]!r} N*m, to: {means[1]!r} N*m}}" if means else f"{mean!r} N*m" if mean else ""
    given = {"mean": said, "lines": _lines(lines, "N*m") if lines else ""}
    return _group(**given) if any(given.values()) else ""


def _excitation(train: Any) -> str:
    if not isinstance(train.error, KinematicError | NoError):
        raise ValueError(f"a project file holds lines of a kinematic error, not {shown(train.error)}; use it in Python")
    load = train.load.end()
    return _group(
        kinematic_error=_lines(train.error.lines, "rad") if isinstance(train.error, KinematicError) else "",
        motor_torque=_torque("the motor", train.motor.excitation),
        load_torque=_torque("the load", load.excitation),
    )
