"""Loads under which a drive is asked: postures of its machine, and its own load under the torques of its range.

A posture takes the place of the load's inertia, of the torque of gravity and of the coupling's stiffness. Gains of the
loop and damping stay those of the project. Gravity is constant in a posture.
"""

from collections.abc import Iterable, Sequence
from dataclasses import replace
from math import cos
from typing import NamedTuple

import numpy as np

from ..base.quantities import Inertia, Torque, TorsionalStiffness, array_of, checked, number
from ..model.train.drive_train import DriveTrain
from ..model.train.shafts import Elastic
from .demands.payload import WEIGHT, Length, Mass
from .project import Project

ROUNDING = 1e-12
LOADS, WITH_MEMORY = 9, 5  # torques of a range; where a curve of a drive with friction or memory is one of many
FILE_LOAD = "nominal load"


class Posture(NamedTuple):
    """Load of a drive in a posture: inertia, torque of gravity, stiffness of the coupling next to the gear.

    A torque that resists the motion is negative. Without a torque the mean torque of the project stays, without a
    stiffness its coupling.
    """

    inertia: Inertia
    torque: Torque | None = None
    coupling: TorsionalStiffness | None = None
    name: str = ""

    def on(self, project: Project) -> Project:
        """The project in this posture.

        Raises
        ------
        ValueError
            If a number is out of range, or the project has no coupling with one stiffness.
        """
        torque = project.mean_load_torque if self.torque is None else number("Posture.torque [N*m]", self.torque)
        loaded = project.with_load_inertia(self.inertia).under(torque, level=True)
        if self.coupling is None:
            return loaded
        K = number("Posture.coupling [N*m/rad]", self.coupling, positive=True)
        return replace(loaded, subject=_coupled(loaded.subject, K))


def refuse_twice(rows: Sequence[Posture]) -> None:
    """Refuse two postures of one name (ValueError)."""
    names = [row.name for row in rows if row.name]
    if twice := next((name for name in names if names.count(name) > 1), ""):
        raise ValueError(f"two postures have the name {twice!r}; give them different names")


def titled(number: float, name: str) -> str:
    """Number of a posture, from 1 on, and its name."""
    return f"posture {number:g}" + (f" ({name})" if name else "")


def _coupled(train: DriveTrain, K: float) -> DriveTrain:
    load = train.load
    if not isinstance(load, Elastic) or "K" not in getattr(load.law, "_fields", ()):
        raise ValueError(
            "a posture gives a coupling stiffness, but the project has no coupling with a single stiffness K; write "
            "load: {coupling: {inertia: 0.1 kg*m^2, law: {type: linear, K: 2e5 N*m/rad}}}, or omit the stiffness"
        )
    return train._replace(load=load._replace(law=load.law._replace(K=K)))


class Link(NamedTuple):
    """A link of an arm: mass, length, distance of its centre from its joint, inertia about its centre.

    The distance is negative where a counterweight moves the centre behind the joint.
    """

    mass: Mass
    length: Length
    centre: Length
    inertia: Inertia

    @classmethod
    def rod(cls, mass: float, length: float) -> "Link":
        """A uniform rod."""
        mass, length = number("mass [kg]", mass, positive=True), number("length [m]", length, positive=True)
        return cls(mass, length, 0.5 * length, mass * length**2 / 12.0)

    def check(self) -> None:
        """Refuse a mass or length that is not positive, and a negative inertia (ValueError)."""
        for name, value in zip(self._fields, self, strict=True):
            if not (value > 0.0 or name == "centre" or (name == "inertia" and value == 0.0)):
                raise ValueError(f"Link.{name} is {value:g}; it must be positive")


def two_link(
    first: Link, second: Link, angles: Iterable[tuple[float, float]], *, joint: int = 1, payload: float = 0.0,
    gravity: float = WEIGHT,
) -> tuple[Posture, ...]:  # fmt: skip
    """Postures of one joint of an arm of two links in a vertical plane, the other joint held.

    Parameters
    ----------
    first, second : Link
        Links, from the base on.
    angles : iterable of (float, float)
        Angle [rad] of the first link above the horizontal, and of the second relative to the first.
    joint : {1, 2}
        Joint that the drive turns; its positive direction lifts a link that points along the horizontal.
    payload : float
        Point mass [kg] at the end of the second link.
    gravity : float
        Acceleration [m/s^2] in the plane of the arm.

    Raises
    ------
    ValueError
        If a link, an angle, the joint, the payload or the gravity is none.

    References
    ----------
    Spong, Hutchinson & Vidyasagar 2006, Robot Modeling and Control, sec. 7.3.2: d11, d22, phi1 and phi2.
    """
    if joint not in (1, 2):
        raise ValueError(f"joint is {joint!r}; it is 1, at the base, or 2, between the links")
    first, second, gravity = checked(first), checked(second), number("gravity [m/s^2]", gravity)
    payload = number("payload [kg]", payload)
    if payload < 0.0:
        raise ValueError(f"payload is {payload:g} kg; it must be 0 or positive")
    outer = second.mass * second.centre + payload * second.length  # first moment about the second joint
    moved = second.inertia + second.mass * second.centre**2 + payload * second.length**2
    tip, carried = first.length, second.mass + payload
    base = first.inertia + first.mass * first.centre**2 + carried * tip**2
    inner = first.mass * first.centre + carried * tip
    rows = []
    for q_1, q_2 in array_of("angles [rad]", list(angles), None, 2).tolist():
        lever = outer * cos(q_1 + q_2)
        inertia = moved
        if joint == 1:
            lever += inner * cos(q_1)
            inertia += base + 2.0 * tip * outer * cos(q_2)
        upright = abs(lever) < ROUNDING * (outer + inner)  # cos(90 deg) is 6e-17
        rows.append(Posture(inertia, 0.0 if upright else -gravity * lever))
    return tuple(rows)


class LoadCase(NamedTuple):
    """A load of a drive: its name, inertia [kg*m^2] behind all couplings, mean torque [N*m], and its posture.

    Without a posture it is the load of the file under this torque.
    """

    name: str
    inertia: float
    torque: float
    posture: Posture | None = None

    def on(self, project: Project) -> Project:
        """The project with this load."""
        return project.under(self.torque) if self.posture is None else self.posture.on(project)


def cases_of(project: Project, torques: Sequence[float] | None = None) -> tuple[LoadCase, ...]:
    """Every load of a project: its postures, and its own load under torques [N*m], by default those of `spread`."""
    J = project.subject.load.end().J
    of_file = f"{FILE_LOAD}, " if project.postures else ""
    torques = spread(project) if torques is None else torques
    rows = [LoadCase(f"{of_file}{torque:.4g} N*m", J, torque) for torque in torques]
    posed = []
    for i, row in enumerate(project.postures, 1):
        torque = project.mean_load_torque if row.torque is None else row.torque
        posed.append(LoadCase(titled(i, row.name), row.inertia, torque, row))
    return (*posed, *rows)


def spread(project: Project, count: int = LOADS) -> list[float]:
    """Torques [N*m] spread over those of the load."""
    low, high = project.other_loads
    return list(map(float, np.linspace(low, high, count if low < high else 1)))
