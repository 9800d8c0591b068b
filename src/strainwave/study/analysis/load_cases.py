"""A drive under torques of its load: steady motions and speeds to avoid under each, and under all of them.

Torques are spread over the range, and lie closer where jumps of the curve begin or end between two of them.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from ...drive.drive_response import DriveResponse
from ...drive.project import Project
from ...drive.train_curve import unfollowed
from .avoid import Avoid, Speeds, hulls_between, merged, searched, speeds_to_avoid
from .resonances import operating_point

LEAST, WITH_MEMORY, MORE = 9, 5, 4  # torques of a range; of laws with friction or memory; and between bands apart
HALVINGS = 4  # of the distance between two torques of which one alone has jumps
ROUNDING = 1e-9


@dataclass(frozen=True, eq=False)
class LoadCase:
    """A drive under one torque of its range.

    Attributes
    ----------
    torque : float
        Constant torque on the load [N*m].
    drive : DriveResponse
        Its steady motions.
    avoid : Avoid or None
        Speeds to avoid; None where no motion is stable.
    speeds : (float, float)
        Range of the base-angle speed [rad/s].
    """

    torque: float
    drive: DriveResponse
    avoid: Avoid | None
    speeds: Speeds

    @property
    def bands(self) -> tuple[Speeds, ...]:
        """Speeds to avoid [rad/s] under this torque: all of them where no motion is stable."""
        return (self.speeds,) if self.avoid is None else self.avoid.bands

    @property
    def unstable(self) -> tuple[Speeds, ...]:
        """Those at which no motion is stable."""
        return (self.speeds,) if self.avoid is None else self.avoid.unstable


def load_cases(project: Project, mean_case: LoadCase, progress: Callable[[float], None]) -> tuple[LoadCase, ...]:
    """Follow the motions at torques over those of the load, their ends among them.

    They lie closer where jumps begin or end between two, and where bands lie apart.

    Parameters
    ----------
    project : Project
        The drive, with torques of its load.
    mean_case : LoadCase
        The drive under its own mean torque.
    progress : callable
        Told every torque [N*m] before its curve is computed.

    Raises
    ------
    SolveError
        If the law cannot carry a torque of the range.
    """
    low, high = project.other_loads
    cases = {mean_case.torque: mean_case}

    def computed(torque: float) -> None:
        progress(torque)
        cases[torque] = _case(project.under(torque, project.is_beating), torque)

    for torque in spread(project):
        if abs(torque - mean_case.torque) > ROUNDING * (high - low):
            computed(torque)

    def jumps(torque: float) -> bool:
        if torque not in cases:
            computed(torque)
        return is_jumping(cases[torque].drive)

    with_ends_of_jumps(project, cases, jumps)
    worst = worst_of(tuple(cases.values())) if project.has_memory else None
    for a, b in pairwise(sorted(cases)):
        if worst is not None and worst.torque in (a, b):
            computed(0.5 * (a + b))
    most = len(cases) + MORE
    while not project.has_memory and len(cases) < most:
        rows = sorted(cases)
        apart = [(a, b) for a, b in pairwise(rows) if _gap(cases[a].bands, cases[b].bands) > 0.0]
        if not apart:
            break
        a, b = max(apart, key=lambda pair: _gap(cases[pair[0]].bands, cases[pair[1]].bands))
        computed(0.5 * (a + b))
    return tuple(cases[torque] for torque in sorted(cases))


def spread(project: Project) -> list[float]:
    """Torques [N*m] spread over those of the load."""
    return list(map(float, np.linspace(*project.other_loads, WITH_MEMORY if project.has_memory else LEAST)))


def with_ends_of_jumps(project: Project, torques: Iterable[float], jumps: Callable[[float], bool]) -> list[float]:
    """Torques, and more of them where jumps of the curve begin or end between two.

    Curves with memory, and those of beats, take too long for it.
    """
    slow = project.has_memory or project.is_beating
    known = {torque: not slow and jumps(torque) for torque in torques}
    for _ in range(HALVINGS):
        for a, b in pairwise(sorted(known)):
            if known[a] != known[b]:
                known[0.5 * (a + b)] = jumps(0.5 * (a + b))
    return sorted(known)


def is_jumping(drive: DriveResponse) -> bool:
    """Whether a slow run-up or run-down jumps."""
    return drive.sweep is not None and bool(drive.sweep.jumping)


def over_all(avoid: Avoid | None, cases: tuple[LoadCase, ...]) -> Avoid | None:
    """Speeds to avoid under any torque of the range: bands of every torque, and all between those that belong.

    `avoid` is that of the drive under its own mean torque; largest and peaks are those of all torques.
    """
    per_torque = [avoided for avoided in (avoid, *(case.avoid for case in cases)) if avoided is not None]
    if not per_torque:
        return None
    every: tuple[Avoid | LoadCase, ...] = (*per_torque, *cases)
    bands = [band for some in every for band in some.bands]
    unstable = merged(band for some in every for band in some.unstable)
    for a, b in pairwise(cases):
        bands += hulls_between(a.bands, b.bands)
    worst = max(per_torque, key=lambda avoided: avoided.largest)
    return replace(
        per_torque[0], bands=merged(bands), largest=worst.largest, at=worst.at, peaks=worst.peaks, unstable=unstable
    )


def worst_of(cases: tuple[LoadCase, ...]) -> LoadCase | None:
    """The case with the largest oscillation; None where there are none."""
    return max(cases, key=lambda case: 0.0 if case.avoid is None else case.avoid.largest, default=None)


def _case(loaded: Project, torque: float) -> LoadCase:
    system = loaded.system(reduced=True)
    point, (drive, curve) = operating_point(system), steady_motions(loaded)
    avoid = None if unfollowed(loaded.train, curve) else speeds_to_avoid(system, drive, point, loaded.limit)
    return LoadCase(torque, drive, avoid, loaded.speeds.limits)


def steady_motions(loaded: Project) -> tuple[DriveResponse, DriveResponse | None]:
    """Steady motions of a drive under one torque, and those of the whole train where they were followed."""
    others = searched(loaded.system(reduced=True).law)
    curve = loaded.train_response(coexisting=others)
    return curve or loaded.equation_response(coexisting=others), curve


def _gap(first: tuple[Speeds, ...], second: tuple[Speeds, ...]) -> float:
    """Largest relative distance between bands that belong together; 0 where they overlap."""
    apart = 0.0
    for here, there in ((first, second), (second, first)):
        for low, high in here:
            if there:
                apart = max(apart, min(max(a / high, low / b) for a, b in there) - 1.0)
    return max(0.0, apart)
