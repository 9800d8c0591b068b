"""`export`: a plant, a controller or a joint for another program."""

import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from numpy.typing import ArrayLike

from ...base.archive import atomic
from ...base.protocols import lacking, terms_of
from ...base.quantities import checked, choice
from ...base.terminal import on_screen
from ...drive.project import Project
from ...model.controllers.loops import Measurement
from ...model.drive import Drive
from ...model.train.drive_train import DriveTrain
from ...numerics.integration.methods import FixedStep
from .c_code import c_name
from .controller import controller_code
from .fmu import write_fmu
from .joint import mjcf, working_torque
from .plant import creep_of, plant_of
from .plant_code import plant_code

Target = Literal["c", "fmu2", "fmu3", "mjcf"]
ENDINGS = {"c": ".c", "fmu2": ".fmu", "fmu3": ".fmu", "mjcf": ".xml"}
SAMPLE = Measurement(*[0.0] * len(Measurement._fields))
STIFFER = "stiffer states, as with friction under load, use smaller steps"
FORWARD = "its kinematic error is always that of forward motion under the mean torque of the project file"
SOURCES_ALONE = "no compiler cc was found: the FMU contains the sources only; compile them on the target"


@dataclass(frozen=True)
class Exported:
    """Result of an export.

    Attributes
    ----------
    path : Path
        The file; the header of C code stands beside it.
    notes : tuple of str
        Sentences on the step that was chosen, and on the parts that are left out.
    """

    path: Path
    notes: tuple[str, ...] = ()

    def __str__(self) -> str:
        return on_screen("\n".join([f"Exported: {self.path}", *(f"  {note}" for note in self.notes)]))

    __repr__ = __str__


def export(
    source: Any,
    path: str | os.PathLike[str],
    *,
    to: Target,
    step: float | None = None,
    method: FixedStep | None = None,
    start: ArrayLike | None = None,
    measurement: Any = SAMPLE,
) -> Exported:
    """Write a drive train or a controller for another program.

    Parameters
    ----------
    source : Project, Drive, DriveTrain, or controller
        A project stands for its whole train. Of a train its motor, gear and load are the plant; its control loop, its
        reference and the torques of its own are left out. A controller is a NamedTuple with `start()`, a tuple of
        floats, and `update(state, measurement)`, the next state and the torque [N*m]; only C takes one.
    path : str or path
        File, whose stem is the name in the other program: .c (and .h beside it), .fmu or .xml.
    to : {"c", "fmu2", "fmu3", "mjcf"}
        C99 without allocation; functional mock-up unit of FMI 2.0 (model exchange and co-simulation) or 3.0
        (co-simulation); a joint for MuJoCo.
    step : float, optional
        Of C and FMI: length of a step [s]. Default: as many steps of the method per shortest time scale as it has.
    method : Rk4 or Dop8, optional
        Of C and FMI. Default: `Dop8()`.
    start : (states,) array_like, optional
        Of C and FMI: state to begin with, as `state_names()` of the train with a free motor lists it; for instance
        `operating_state`. Default: zeros.
    measurement : NamedTuple, optional
        Of a controller: any measurement, whose fields become the inputs. Default: that of the library's controllers.

    Returns
    -------
    Exported
        The `path` of the file, and `notes`: sentences on its step and on what is not in it.

    Raises
    ------
    ValueError
        If the format or the ending is another, the stem is not a name in C, the step is too long for the train, or
        `start` has another number of states.
    TypeError
        If a law or a controller branches on a value, or a controller's state or measurement is no tuple of floats.
    OSError
        If the path cannot be written.
    """
    choice("to", to, *ENDINGS)
    path, name = c_name(path, ENDINGS[to])
    if not lacking(source, "start", "update") and lacking(source, "results"):
        if to != "c":
            raise ValueError(f"a controller is exported to c alone, not to {to}")
        return Exported(controller_code(source, measurement, name).write(path))
    train = _train(source)
    if to == "mjcf":
        with atomic(path) as part:
            text, notes = mjcf(checked(train), name, working_torque(source, train))
            Path(part).write_text(text, encoding="utf-8")
        return Exported(path, notes)
    plant = plant_of(train, step, method, start)
    remarks = _left_out(train)
    if step is None:
        remarks += [f"step size {plant.step:.6g} s, chosen for the fastest motion of this train", STIFFER]
    if getattr(source, "loaded_error", None) is not None:
        remarks.append(FORWARD)
    remarks += creep_of(plant.train)
    if to == "c":
        plant_code(plant, name).write(path)
    elif not write_fmu(plant, path, name, int(to[-1])):
        remarks.append(SOURCES_ALONE)
    return Exported(path, tuple(remarks))


def _left_out(train: DriveTrain) -> list[str]:
    """Parts that a plant in C or an FMU leaves to its surroundings, a sentence each."""
    held = "the motor (held in the file) is free" if train.motor.held else "the motor's control loop is omitted"
    terms = [term for shaft in (train.motor, train.load.end()) for term in terms_of(shaft.excitation)]
    driven = any(getattr(term, size, 1.0) for term in terms for size in ("mean", "amplitude"))
    torques = "shaft torques of the project file are omitted; apply them as motor_torque and load_torque"
    return [f"{held}: its torque is the input motor_torque"] * (not train.motor.free) + [torques] * driven


def _train(source: Any) -> DriveTrain:
    """The whole train of a drive or a project; a train itself (ValueError)."""
    if isinstance(source, Drive):
        return source.train()
    if isinstance(source, Project):
        if source.whole is None:
            raise ValueError(
                "this project has no drive train (its damping or its stiffness varies, or its speeds are those of a "
                "forcing); export takes a train"
            )
        return source.whole
    train: DriveTrain = source
    return train
