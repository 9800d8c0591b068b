"""The project file: a drive, its speed and what excites it, read from YAML with units and resolved to SI."""

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from ..model.catalogue import Gear
from ..model.drive import Drive
from ..model.excitation import Harmonics, KinematicError
from ..model.oscillator import Oscillator


class ProjectError(ValueError):
    """A project file cannot be used; one line `file:line:column: field: fact, value, remedy` per problem."""


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
        The catalogue record, or None for an explicit law.
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
        Sentences for the reader: doubts about the catalogue data, speeds and torques beyond the gear's limits.
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

    Raises
    ------
    ProjectError
        If the file cannot be read or does not describe a drive; all problems found, one line each.
    """
    raise ProjectError(f"{path}:1:1: file: not read yet")
