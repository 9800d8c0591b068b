"""Loads under which a drive is asked: one list for every command.

A range of torques and gravity by angle are torques spread over their range; each posture of the machine is a load.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from .postures import Posture, titled
from .project import Project

LOADS, WITH_MEMORY = 9, 5  # torques of a range; where a curve of a drive with friction or memory is one of many
OF_FILE = "load of the file"


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
    J = project.drive.J_l if project.whole is None else project.whole.load.end().J
    of_file = f"{OF_FILE}, " if project.postures else ""
    own = spread(project) if torques is None else torques
    rows = [LoadCase(f"{of_file}{torque:.4g} N*m", J, torque) for torque in own]
    posed = [in_posture(project, i, row) for i, row in enumerate(project.postures, 1)]
    return (*posed, *rows)


def in_posture(project: Project, number: int, row: Posture) -> LoadCase:
    """The load of a project in a posture."""
    torque = project.mean_load_torque if row.torque is None else row.torque
    return LoadCase(titled(number, row.name), row.inertia, torque, row)


def spread(project: Project, count: int = LOADS) -> list[float]:
    """Torques [N*m] spread over those of the load."""
    low, high = project.other_loads
    return list(map(float, np.linspace(low, high, count if low < high else 1)))
