"""The verdict on one curve of a drive, where no analysis follows the others: what `analyze` decides, decided alike."""

from typing import Any, NamedTuple

from ....model.gears.limits import Finding, gravest
from ....results import SolveError
from ...response.resonances import operating_point
from ..avoid import Avoid, out_of_reach, speeds_to_avoid
from ..drive_response import DriveResponse
from ..usage import MotorUse, Usage, limit_findings
from .verdict import Answer, Verdict, verdict_of


class Judged(NamedTuple):
    """What one curve says of a drive.

    Attributes
    ----------
    verdict : Verdict
        Answer, and speeds to keep out of.
    passes : bool or None
        Whether the drive passes; None where the project has no limit of the oscillation and fails by nothing else, and
        where other torques of its load have curves of their own.
    avoid : Avoid or None
        Speeds to avoid for the oscillation alone.
    used, motor : Usage, MotorUse or None
        What gear and motor must take, and at least what every torque on the load takes at steady speed.
    findings : tuple of Finding
        The same against the limits of the gear and of the motor.
    jumps : bool
        Whether a drive with a limit of its oscillation fails by jumps of a slow run-up or run-down.
    """

    verdict: Verdict
    passes: bool | None
    avoid: Avoid | None
    used: Usage
    motor: MotorUse | None
    findings: tuple[Finding, ...]
    jumps: bool = False

    @property
    def failures(self) -> tuple[str, ...]:
        """Limits of the gear and of the motor by which the drive fails, a limit out of reach, and jumps."""
        jumps = ["The motion jumps on a slow run-up or run-down."] if self.jumps else []
        return (*self._below(True), *jumps, *(finding.sentence for finding in gravest(self.findings) if finding.fails))

    @property
    def remarks(self) -> tuple[str, ...]:
        """What is beyond a limit and no failure."""
        return (*self._below(False), *(finding.sentence for finding in gravest(self.findings) if not finding.fails))

    def _below(self, failing: bool) -> tuple[str, ...]:
        if self.avoid is None or failing != (self.verdict.answer is not Answer.ALL_RIGHT):
            return ()
        said = out_of_reach(self.avoid.limit, self.avoid.slow)
        return (f"{said[0].upper()}{said[1:]}.",) if said else ()


def judged(project: Any, found: DriveResponse, turns: int = 1) -> Judged:
    """Judge the motions of a curve by the rules of `analyze`.

    Parameters
    ----------
    project : Project
        The drive, with its limits.
    found : DriveResponse
        Its curve, under the mean torque of its load.
    turns : int
        Turns of the project's base angle in one of the motor.
    """
    mean, loads, speeds = project.mean_load_torque, project.load_torques, project.speeds
    used, motor = found.asked(mean, loads, project.drive.N)
    fastest = speeds.given[-1] / turns if speeds.by_motor else None
    findings = limit_findings(project.gear, used, fastest, project.motor_limits, motor)
    avoid = _avoid(project, found)
    verdict = verdict_of(speeds.limits, (found,), avoid, used, findings, motor=motor, turns=turns)
    passes: bool | None = verdict.answer is Answer.ALL_RIGHT
    if project.limit is None:
        passes = False if verdict.exceeded or avoid is None or avoid.unstable else None
    jumps = project.limit is not None and found.response.sweep is not None and bool(found.response.sweep.jumping)
    passes = passes if loads[0] == loads[1] or not passes else None
    return Judged(verdict, passes, avoid, used, motor, findings, jumps)


def _avoid(project: Any, found: DriveResponse) -> Avoid | None:
    """Speeds to avoid; None for a drive whose spring cannot hold its load, and where no motion is stable."""
    system = project.system(reduced=True)
    try:
        return speeds_to_avoid(system, found.response, operating_point(system), project.limit)
    except (ValueError, SolveError):
        return None
