"""Several projects side by side: the response of each whole drive, and what an engineer compares of it."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from ...quantities import shown
from ...records import Labelled, Result
from ...results import Floats, Interrupted
from ...sentences import on_screen
from ...study.analysis.drive_response import DriveResponse
from ...units import ARCSEC, RPM
from ..project import Project

MOST = 20


@dataclass(frozen=True, eq=False)
class ProjectComparison(Result):
    """Drives side by side, in the order given.

    Attributes
    ----------
    titles, gears : tuple of str
        Title of each project and its gear; "own law" where the file writes it out.
    responses : tuple of DriveResponse
        Response of each whole drive through its own speeds.
    oscillation, speed : (n,) arrays
        Largest oscillation of the error [rad] over the stable motions, and the speed of the base angle there [rad/s].
    torque : (n,) array
        Largest torque in the gear [N*m] in the motions that a slow run-up or run-down visits.
    omega_0, damping_ratio, reflected_inertia, load_inertia : (n,) arrays
        Natural frequency [rad/s] and damping ratio at rest in the mode of the project, N^2 J_m and J_l [kg*m^2].
    jumps : (n,) array
        Number of folds of the response in its range.
    limit : (n,) array
        Largest oscillation that the project allows [rad]; nan where it has no limit.
    """

    titles: tuple[str, ...]
    gears: tuple[str, ...]
    responses: tuple[DriveResponse, ...]
    oscillation: Floats
    speed: Floats
    torque: Floats
    omega_0: Floats
    damping_ratio: Floats
    reflected_inertia: Floats
    load_inertia: Floats
    jumps: Floats
    limit: Floats

    rows: ClassVar[str] = "drive"

    def coordinates(self) -> Labelled:
        """Titles and gears."""
        return {"title": ("drive", list(self.titles), ""), "gear": ("drive", list(self.gears), "")}

    def variables(self) -> Labelled:
        """Every number that is compared."""
        units = {
            "oscillation": "rad", "speed": "rad/s", "torque": "N*m", "omega_0": "rad/s", "damping_ratio": "1",
            "reflected_inertia": "kg*m**2", "load_inertia": "kg*m**2", "jumps": "", "limit": "rad",
        }  # fmt: skip
        return {name: ("drive", getattr(self, name), unit) for name, unit in units.items()}

    def __str__(self) -> str:
        lines = [f"Comparison of {len(self.titles)} drives, the largest oscillation of the error of each"]
        for i in np.argsort(self.oscillation):
            lines.append(
                f"  {self.titles[i]} ({self.gears[i]}): {self.oscillation[i] / ARCSEC:.4g} arcsec at "
                f"{self.speed[i] / RPM:.5g} rpm of the base angle"
            )
        return on_screen("\n".join(lines))

    __repr__ = __str__


def compare_projects(
    projects: Sequence[Project], *, progress: Callable[[str, float], None] | None = None
) -> ProjectComparison:
    """Follow the responses of several projects and put them side by side.

    Parameters
    ----------
    projects : sequence of Project
        Two to twenty projects, as `read_project` gives them.
    progress : callable, optional
        Told the title of the project that is computed now, and the share of the work that is done.

    Raises
    ------
    TypeError, ValueError
        If they are no projects, or fewer than two; whatever `Project.response` refuses.
    SolveError
        If no periodic motion of a project is found.
    Interrupted
        On Ctrl-C after at least two projects, with the comparison of those.
    """
    given = list(projects) if isinstance(projects, Sequence) and not isinstance(projects, str) else [projects]
    if not all(isinstance(project, Project) for project in given):
        raise TypeError(f"projects are {shown(projects)}; give a list, such as [read_project('a.yaml'), ...]")
    if not 2 <= len(given) <= MOST:
        raise ValueError(f"there are {len(given)} projects; give 2 to {MOST} to compare")
    responses: list[DriveResponse] = []
    try:
        for i, project in enumerate(given):
            if progress is not None:
                progress(project.title, i / len(given))
            responses.append(project.response())
    except KeyboardInterrupt:
        if len(responses) < 2:
            raise
        some = f"the comparison is that of the first {len(responses)} of {len(given)} projects"
        raise Interrupted(f"interrupted; {some}", _compared(given[: len(responses)], responses)) from None
    return _compared(given, responses)


def _compared(given: list[Project], responses: list[DriveResponse]) -> ProjectComparison:
    tops = [_top(response) for response in responses]

    def each(number: Callable[[Project], Any]) -> Floats:
        return np.array([np.nan if (value := number(p)) is None else value for p in given], float)

    return ProjectComparison(
        tuple(p.title for p in given),
        tuple("own law" if p.gear is None else p.gear.name for p in given),
        tuple(responses),
        np.array([size for size, _ in tops]),
        np.array([omega for _, omega in tops]),
        np.array([response.usage.peak_torque for response in responses]),
        each(lambda p: p.omega_0),
        each(lambda p: p.damping_ratio),
        each(lambda p: p.drive.N**2 * p.drive.J_m),
        each(lambda p: p.drive.J_l),
        np.array([_folds(response) for response in responses], float),
        each(lambda p: p.limit),
    )


def _folds(response: DriveResponse) -> int:
    low, high = response.curve.span
    return sum(low <= fold.omega <= high for fold in response.folds)


def _top(response: DriveResponse) -> tuple[float, float]:
    """Largest oscillation [rad] of the stable motions in the range, of all where none is stable, and its speed."""
    inside = response.curve.inside
    known = inside & response.stable if np.any(inside & response.stable) else inside
    at = int(np.argmax(np.where(known, response.oscillation, -1.0)))
    return float(response.oscillation[at]), float(response.omega[at])
