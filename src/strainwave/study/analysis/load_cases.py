"""A drive under the torques of its load: a curve under each, and the speeds to avoid under all of them.

A load torque that lies anywhere in a range, as that of gravity on an arm does, takes a curve at several torques.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from itertools import pairwise
from math import log, sqrt
from typing import Any

import numpy as np

from ...base.law import depends
from ...drive.drive_response import DriveResponse
from ...drive.project import Project
from .avoid import Avoid, Speeds, merged, speeds_to_avoid
from .resonances import operating_point

LEAST, WITH_MEMORY, MOST = 9, 5, 13  # torques of a range with a curve each; of laws with friction or memory; at most
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
    """

    torque: float
    drive: DriveResponse
    avoid: Avoid | None

    @property
    def bands(self) -> tuple[Speeds, ...]:
        """Speeds to avoid [rad/s] under this torque."""
        return () if self.avoid is None else self.avoid.bands


def load_cases(project: Project, mean_case: LoadCase, progress: Callable[[float], None]) -> tuple[LoadCase, ...]:
    """Follow the motions at torques spread over those of the load, their ends among them, and where bands lie apart.

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
    low, high = project.load_torques
    cases = {mean_case.torque: mean_case}

    def computed(torque: float) -> None:
        progress(torque)
        cases[torque] = _case(project.under(torque), torque)

    spring = not project.has_memory
    for torque in np.linspace(low, high, LEAST if spring else WITH_MEMORY).tolist():
        if abs(torque - mean_case.torque) > ROUNDING * (high - low):
            computed(torque)
    while spring and len(cases) < MOST:
        rows = sorted(cases)
        apart = [(a, b) for a, b in pairwise(rows) if _gap(cases[a].bands, cases[b].bands) > 0.0]
        if not apart:
            break
        a, b = max(apart, key=lambda pair: _gap(cases[pair[0]].bands, cases[pair[1]].bands))
        computed(0.5 * (a + b))
    return tuple(cases[torque] for torque in sorted(cases))


def over_all(avoid: Avoid | None, cases: tuple[LoadCase, ...]) -> Avoid | None:
    """Speeds to avoid under any torque of the range: bands of every torque, and all between those that belong.

    `avoid` is that of the drive under its own mean torque; largest and peaks are those of all torques.
    """
    per_torque = [avoided for avoided in (avoid, *(case.avoid for case in cases)) if avoided is not None]
    if not per_torque:
        return None
    bands = [band for avoided in per_torque for band in avoided.bands]
    for a, b in pairwise(cases):
        bands += hulls_between(a.bands, b.bands)
    worst = max(per_torque, key=lambda avoided: avoided.largest)
    return replace(per_torque[0], bands=merged(bands), largest=worst.largest, at=worst.at, peaks=worst.peaks)


def worst_of(cases: tuple[LoadCase, ...]) -> LoadCase | None:
    """The case with the largest oscillation; None where there are none."""
    return max(cases, key=lambda case: 0.0 if case.avoid is None else case.avoid.largest, default=None)


def _case(loaded: Project, torque: float) -> LoadCase:
    system = loaded.system(reduced=True)
    point, others = operating_point(system), searched(system.law)
    drive = loaded.train_response(coexisting=others) or loaded.equation_response(coexisting=others)
    return LoadCase(torque, drive, speeds_to_avoid(system, drive, point, loaded.limit))


def searched(law: Any) -> bool:
    """Whether motions that do not join the curve of a torque are looked for at its ends.

    With memory, and with a gap, the search would take most of the time.
    """
    return depends(law) == 1 and bool(law.stiffness(0.0) > 0.0)


def hulls_between(first: tuple[Speeds, ...], second: tuple[Speeds, ...]) -> Iterator[Speeds]:
    """Hulls of the bands of two torques that belong together: each with the nearest of the other torque."""
    for here, there in ((first, second), (second, first)):
        for band in here:
            if there:
                near = min(there, key=lambda other: abs(log(_middle(other) / _middle(band))))
                yield min(band[0], near[0]), max(band[1], near[1])


def _gap(first: tuple[Speeds, ...], second: tuple[Speeds, ...]) -> float:
    """Largest relative distance between bands that belong together; 0 where they overlap."""
    apart = 0.0
    for here, there in ((first, second), (second, first)):
        for low, high in here:
            if there:
                apart = max(apart, min(max(a / high, low / b) for a, b in there) - 1.0)
    return max(0.0, apart)


def _middle(band: Speeds) -> float:
    return sqrt(band[0] * band[1])
