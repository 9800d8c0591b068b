"""A drive under torques of its load: steady motions and speeds to avoid under each, and under all of them."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ...drive.drive_response import DriveResponse
from ...drive.project import Project
from ..speed_map.avoid import Avoid, avoid_in_bands
from ..speed_map.decide import Decision
from ..speed_map.intervals import Span, complement, merged
from ..speed_map.motions import OMEGA, OSCILLATION, LoadMotions
from ..speed_map.size_curve import SizeCurve


class AtTorque(NamedTuple):
    """Decision on a drive under one torque of its load's range.

    Attributes
    ----------
    torque : float
        Constant torque on the load [N*m].
    drive : DriveResponse
        Its steady motions.
    avoid : Avoid or None
        What its motions say; None where none is stable.
    bands : tuple of (float, float)
        Speeds to avoid [rad/s]: all of them where no motion is stable.
    """

    torque: float
    drive: DriveResponse
    avoid: Avoid | None
    bands: tuple[Span, ...]

    @property
    def unstable(self) -> tuple[Span, ...]:
        """Speeds at which no motion is stable."""
        return self.bands if self.avoid is None else self.avoid.unstable


def load_cases(project: Project, decided: Decision) -> tuple[AtTorque, ...]:
    """The drive under each torque of its load's range; empty where it has one."""
    cases = []
    low, high = project.other_loads
    for i in decided.of_file if low < high else ():
        loaded, bands = decided.by_load[i], merged(decided.moving[i].forbidden.tolist())
        response = loaded.curves[0].response if loaded.curves else None
        drive = response or decided.projects[i].equation_response(coexisting=False)
        avoid = avoid_in_bands(drive, loaded.quasi_static, project.limit, bands) if response else None
        cases.append(AtTorque(decided.load_cases[i].torque, drive, avoid, bands))
    return tuple(cases)


def avoid_under_all(
    drive: DriveResponse, decided: Decision, cases: tuple[AtTorque, ...], limit: float | None, passed: SizeCurve | None
) -> Avoid | None:  # fmt: skip
    """Speeds to avoid under every torque of the file's load, by the motions alone; None where none is stable.

    `drive` is its curve under the mean torque; largest and peaks are those of all torques. `passed` are the motions of
    a run-up that has torques which the curve has not.
    """
    by_load = [decided.by_load[i] for i in decided.of_file]
    bands = merged(complement(decided.quiet, decided.span).tolist())
    alone = avoid_in_bands(drive, by_load[0].quasi_static, limit, bands, passed)
    avoids = [avoid for avoid in (alone, *(case.avoid for case in cases)) if avoid is not None]
    if not avoids or not any(one.curves for one in by_load):
        return None
    worst = max(avoids, key=lambda avoid: avoid.largest)
    unstable = merged(band for case in (alone, *cases) if case for band in case.unstable)
    return replace(
        avoids[0], largest=worst.largest, at=worst.at, peaks=worst.peaks, bands=bands, unstable=unstable,
        apart=_apart(by_load),
    )  # fmt: skip


def _apart(by_load: list[LoadMotions]) -> tuple[float, float] | None:
    """Speed [rad/s] and oscillation [rad] of the largest motion that no main curve has."""
    rows = [run[np.argmax(run[:, OSCILLATION])] for one in by_load for curve in one.curves[1:] for run in curve.runs]
    sizes = [(float(row[OMEGA]), float(row[OSCILLATION])) for row in rows]
    sizes += [(one.omega, one.oscillation) for loaded in by_load for one in loaded.loose]
    return max(sizes, key=lambda pair: pair[1], default=None)


def largest_case(cases: tuple[AtTorque, ...]) -> AtTorque | None:
    """The case with the largest oscillation; None where there are none."""
    return max(cases, key=lambda case: 0.0 if case.avoid is None else case.avoid.largest, default=None)
