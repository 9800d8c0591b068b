"""A drive under torques of its load: steady motions and speeds to avoid under each, and under all of them."""

from dataclasses import dataclass, replace

import numpy as np

from ...drive.drive_response import DriveResponse
from ...drive.project import Project
from ..speed_map.avoid import Avoid, avoided
from ..speed_map.bands import Motions, Speeds, merged
from ..speed_map.decide import Decision
from ..speed_map.motions import OMEGA, OSCILLATION, UnderLoad
from ..speed_map.rules import complement, windows


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


def load_cases(project: Project, decided: Decision) -> tuple[LoadCase, ...]:
    """The drive under each torque of its load's range; empty where it has one."""
    cases = []
    rows = zip(decided.load_cases, decided.projects, decided.found, decided.moving, strict=True)
    for case, loaded, found, bands in rows:
        if case.posture is None and project.other_loads[0] < project.other_loads[1]:
            drive = found.curves[0].found if found.curves else loaded.equation_response(coexisting=False)
            own = merged(bands.forbidden.tolist())
            avoid = avoided(drive, found.quasi_static, project.limit, own) if found.curves else None
            cases.append(LoadCase(case.torque, drive, avoid, decided.span))
    return tuple(cases)


def over_all(
    drive: DriveResponse, decided: Decision, cases: tuple[LoadCase, ...], limit: float | None, passed: Motions | None
) -> Avoid | None:  # fmt: skip
    """Speeds to avoid under every torque of the file's load, by the motions alone; None where none is stable.

    `drive` is its curve under the mean torque; largest and peaks are those of all torques. `passed` are the motions of
    a run-up that has torques which the curve has not.
    """
    own = [i for i, case in enumerate(decided.load_cases) if case.posture is None]
    forbidden, found = [decided.moving[i].forbidden for i in own], [decided.found[i] for i in own]
    free = windows(forbidden, decided.span, [True] * (len(own) - 1))
    bands = merged(complement(free, decided.span).tolist())
    alone = avoided(drive, found[0].quasi_static, limit, bands, passed)
    known = [avoid for avoid in (alone, *(case.avoid for case in cases)) if avoid is not None]
    if not known or not any(one.curves for one in found):
        return None
    worst = max(known, key=lambda avoid: avoid.largest)
    unstable = merged(band for some in known for band in some.unstable)
    unstable = merged([*unstable, *(band for case in cases for band in case.unstable)])
    return replace(
        known[0], largest=worst.largest, at=worst.at, peaks=worst.peaks, bands=bands, unstable=unstable,
        apart=_apart(found),
    )  # fmt: skip


def _apart(found: list[UnderLoad]) -> tuple[float, float] | None:
    """Speed [rad/s] and oscillation [rad] of the largest motion that no main curve has."""
    rows = [run[np.argmax(run[:, OSCILLATION])] for own in found for curve in own.curves[1:] for run in curve.runs]
    sizes = [(float(row[OMEGA]), float(row[OSCILLATION])) for row in rows]
    sizes += [(one.omega, one.oscillation) for own in found for one in own.loose]
    return max(sizes, key=lambda pair: pair[1], default=None)


def worst_of(cases: tuple[LoadCase, ...]) -> LoadCase | None:
    """The case with the largest oscillation; None where there are none."""
    return max(cases, key=lambda case: 0.0 if case.avoid is None else case.avoid.largest, default=None)
