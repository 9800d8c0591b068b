"""What a reader of the results should know about the input of a project."""

from collections.abc import Iterator
from typing import Any

from ..units import RPM
from .plausibility import doubts


def notes(project: Any) -> Iterator[str]:
    """Sentences on what a reader of the results should know about the input."""
    yield from _torque_notes(project)
    yield from doubts(project)
    gear = project.gear
    if gear is None:
        return
    if gear.input_inertia is not None and project.drive.J_m < gear.input_inertia:
        yield (
            f"motor.inertia is {project.drive.J_m:g} kg*m^2, less than the {gear.input_inertia:g} kg*m^2 of the wave "
            f"generator of {gear.name} alone; it must include the wave generator."
        )


def _torque_notes(project: Any) -> Iterator[str]:
    """Notes on mean torques that a free motor cannot balance."""
    drive = project.drive
    at_motor, at_load = (
        0.0 if t is None else sum(h.mean for h in t.terms) for t in (project.motor_torque, project.load_torque)
    )
    whole = drive.N * at_motor + at_load
    if project.motor == "free" and abs(whole) > 1e-9 * (abs(drive.N * at_motor) + abs(at_load)):
        rate = drive.N * whole / (drive.N * drive.N * drive.J_m + drive.J_l)
        yield (
            f"The mean torques do not balance: the motor speeds up by {rate / RPM:.4g} rpm/s and does not keep the "
            "speeds analysed; give the "
            f"free motor a mean torque of {-at_load / drive.N:.4g} N*m, or write 'mode: held'."
        )
