"""Projects asked for their error equation: a drive that has more is refused, with the command that follows all of it.

The error equation knows a motor that is ideally held or free, the gear, and a rigid load.
"""

from typing import TYPE_CHECKING

from ...model.train.shafts import NO_DRAG
from ...study.train.reductions import error_slope, left_out, listed

if TYPE_CHECKING:
    from ...files.project import Project


def refuse_reduced(project: "Project", command: str) -> None:
    """Refuse a drive of which the error equation leaves something out (ValueError), for a command that follows it."""
    train, file = project.train, project.path.name
    if train is None or not (parts := left_out(train)):
        return
    raise ValueError(
        f"{file}: `strainwave {command}` follows the error equation, which leaves out {listed(parts)} of this drive; "
        + (
            "write a loop or 'mode: held' under motor, and `strainwave analyze` follows the whole drive train"
            if train.motor.free
            else f"`strainwave analyze {file} -o DIR` follows the whole drive train"
        )
    )


def remarks(project: "Project") -> tuple[str, ...]:
    """The file's notes, and sentences about what the error equation makes of a drive of which it leaves out no part."""
    train, said = project.train, list(project.notes)
    if train is None:
        return tuple(said)
    if train.motor.drag != NO_DRAG and train.motor.held:
        said.append("motor.drag does not enter: an ideally held motor keeps its speed whatever opposes it.")
    if train.motor.free and project.kinematic_error is not None:
        said.append(
            "With the motor free the error equation leaves out the motor's answer to the changing ratio, N e' up to "
            f"{error_slope(train):.2g}, and the ripple of the motor's speed; `strainwave analyze` compares it with the "
            "whole drive train."
        )
    return tuple(said)
