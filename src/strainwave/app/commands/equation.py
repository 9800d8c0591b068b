"""Remarks on the error equation of a drive: a motor that is ideally held or free, the gear, a rigid load."""

from typing import TYPE_CHECKING

from ...drive.reductions import error_slope
from ...model.laws.meshing import NO_FRICTION
from ...model.train.shafts import NO_DRAG

if TYPE_CHECKING:
    from ...drive.project import Project


def remarks(project: "Project") -> tuple[str, ...]:
    """Notes of the file, and sentences about effects that the error equation neglects."""
    train, sentences = project.train, list(project.notes)
    if train is None:
        return tuple(sentences)
    if train.motor.drag != NO_DRAG and train.motor.held:
        sentences.append("motor.drag does not enter: an ideally held motor keeps its speed whatever opposes it.")
    if train.friction != NO_FRICTION and train.motor.held:
        sentences.append("load_friction does not enter: an ideally held motor keeps its speed whatever opposes it.")
    if train.motor.free and project.kinematic_error is not None:
        sentences.append(
            "With the motor free the error equation leaves out the motor's answer to the changing ratio, N e' up to "
            f"{error_slope(train):.2g}, and the ripple of the motor's speed; `strainwave analyze` compares it with the "
            "whole drive train."
        )
    return tuple(sentences)
