"""The verb that takes a plant, a controller or a joint to another program."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, get_args

from numpy.typing import ArrayLike

from ...archive import atomic
from ...model.controllers.measurement import Measurement
from ...model.drive import Drive
from ...model.train.drive_train import DriveTrain
from ...numerics.integration.methods import FixedStep
from ...protocols import lacking
from ...quantities import checked, shown
from ...sentences import on_screen
from ..project import Project
from .c_code import c_name
from .controller import controller_code
from .fmu import write_fmu
from .joint import mjcf, urdf
from .plant import plant_code, plant_of

Target = Literal["c", "fmu2", "fmu3", "mjcf", "urdf"]
ENDINGS = {"c": ".c", "fmu2": ".fmu", "fmu3": ".fmu", "mjcf": ".xml", "urdf": ".urdf"}
SAMPLE = Measurement(*[0.0] * len(Measurement._fields))
STIFFER = "where a state is stiffer, as with friction under load, it takes a step in parts"
SOURCES_ALONE = "there is no compiler cc here: the unit holds the sources alone, build them where it runs"


@dataclass(frozen=True)
class Exported:
    """What an export wrote.

    Attributes
    ----------
    path : Path
        The file; the header of C code stands beside it.
    notes : tuple of str
        Sentences on the step that was chosen, and on what is not in it.
    """

    path: Path
    notes: tuple[str, ...] = ()

    def __str__(self) -> str:
        return on_screen("\n".join([f"Exported: {self.path}", *(f"  {note}" for note in self.notes)]))

    __repr__ = __str__


def export(
    source: Any,
    path: Any,
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
        File, whose stem is the name in the other program: .c (and .h beside it), .fmu, .xml or .urdf.
    to : {"c", "fmu2", "fmu3", "mjcf", "urdf"}
        C99 without allocation; functional mock-up unit of FMI 2.0 (model exchange and co-simulation) or 3.0
        (co-simulation); a joint for MuJoCo, or of the Unified Robot Description Format.
    step : float, optional
        Of C and FMI: length of a step [s]. Default: as many steps of the method per shortest time scale as it has.
    method : FixedStep, optional
        Of C and FMI: `Rk4()`, `Dop8()` or any other scheme of fixed steps. Default: `Dop8()`.
    start : (states,) array_like, optional
        Of C and FMI: state to begin with, as `state_names()` of the train with a free motor lists it; for instance
        `operating_state`. Default: zeros.
    measurement : NamedTuple, optional
        Of a controller: any measurement, whose fields become the inputs. Default: that of the library's controllers.

    Returns
    -------
    Exported
        The file, and what is not in it.

    Raises
    ------
    ValueError
        If the format or the ending is another, the stem is not a name in C, the step is too long for the train, or
        `start` has another number of states.
    TypeError
        If the source is of another kind, or a law or a controller branches on a value.
    OSError
        If the path cannot be written.
    """
    if to not in ENDINGS:
        raise ValueError(f"to is {shown(to)}; it must be one of {', '.join(get_args(Target))}")
    path, name = c_name(path, ENDINGS[to])
    if not lacking(source, "start", "update"):
        if to != "c":
            raise ValueError(f"a controller is exported to c alone, not to {to}")
        return Exported(controller_code(source, measurement, name).write(path))
    train = _train(source)
    if to in ("mjcf", "urdf"):
        with atomic(path) as part:
            Path(part).write_text((mjcf if to == "mjcf" else urdf)(checked(train), name), encoding="utf-8")
        return Exported(path)
    plant = plant_of(train, step, method, start)
    said = (
        ()
        if step is not None
        else (
            f"it takes steps of {plant.step:.6g} s, chosen for the fastest motion of this train",
            STIFFER,
        )
    )
    if to == "c":
        return Exported(plant_code(plant, name).write(path), said)
    built = write_fmu(plant, path, name, int(to[-1]))
    return Exported(path, said if built else (*said, SOURCES_ALONE))


def _train(source: Any) -> DriveTrain:
    if isinstance(source, Drive):
        return source.train()
    if isinstance(source, Project):
        if source.whole is None:
            raise ValueError(
                "this project has no drive train (its damping or its stiffness varies, or its speeds are those of a "
                "forcing); export takes a train"
            )
        return source.whole
    if not isinstance(source, DriveTrain):
        raise TypeError(f"export takes a Project, a Drive, a DriveTrain or a controller, not {shown(source)}")
    return source
