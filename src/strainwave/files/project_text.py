"""A whole drive train built in Python, written as a project file."""

import json
import math
from pathlib import Path
from typing import Any

from ..model.excitation import Harmonic, Harmonics, KinematicError, NoError
from ..model.train.controls import Lagged
from ..model.train.drive_train import DriveTrain
from ..model.train.motion import Steady
from ..model.train.shafts import NO_DRAG, Load
from ..quantities import checked, interval, number, shown
from .entries import project_entry
from .project import ProjectError, from_text


def project_text(train: DriveTrain, omega: float | tuple[float, float] | None = None, *, title: str = "") -> str:
    """Write a drive train as a project file that `strainwave analyze` reads back as the same drive.

    Parameters
    ----------
    train : DriveTrain
        As `Drive.train` returns it: law, damping, kinematic error and torques, with loop, drag of the shafts and
        couplings, where it has them.
    omega : float or (float, float), optional
        Speed of the motor [rad/s], or a range. Default: that of the train.
    title : str, optional
        Title of the report.

    Returns
    -------
    str
        YAML in SI units, with every number as it is. A line of negative amplitude is written with its size and the
        phase moved by half a turn.

    Raises
    ------
    TypeError
        If it is no `DriveTrain`.
    ValueError
        With what a project file does not hold.
    """
    if not isinstance(train, DriveTrain):
        raise TypeError(f"project_text takes a DriveTrain, not {shown(train)}; drive.train(...) gives one")
    train = checked(train)
    if not isinstance(train.reference, Steady):
        raise ValueError(
            f"a project file has constant speeds, and this train follows {train.reference}; use it in Python"
        )
    groups = {
        "title": json.dumps(title, ensure_ascii=False) if title else "",
        "gear": f"{{ratio: {train.N!r}, law: {project_entry(train.law)}}}",
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


def _group(**fields: str) -> str:
    return "{" + ", ".join(f"{name}: {text}" for name, text in fields.items() if text) + "}"


def _drag(law: Any) -> str:
    return "" if (type(law), law) == (type(NO_DRAG), NO_DRAG) else project_entry(law)  # equal numbers make no equal law


def _motor(motor: Any) -> str:
    loop = "" if motor.free or motor.held else _loop(motor.control)
    mode = "free" if motor.free else "held"
    return _group(inertia=f"{motor.J!r} kg*m^2", mode=mode, loop=loop, drag=_drag(motor.drag))


def _loop(control: Any) -> str:
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


def _torque(where: str, torque: Any) -> str:
    if not isinstance(torque, Harmonic | Harmonics):
        raise ValueError(
            f"a project file holds torques as harmonics, and {where} has {shown(torque)}; use it in Python"
        )
    terms = torque.terms if isinstance(torque, Harmonics) else (torque,)
    mean, lines = sum(term.mean for term in terms), [term for term in terms if term.amplitude]
    given = {"mean": f"{mean!r} N*m" if mean else "", "lines": _lines(lines, "N*m") if lines else ""}
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
