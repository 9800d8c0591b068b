"""Torques and speeds of a speed map against the limits of its gear and its motor."""

import math
from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from ...base.units import RPM
from ...drive.demands.motor_limits import BRAKE, PEAK, Need
from ...drive.demands.usage import MotorUse, Usage, limit_findings
from ...drive.project import Project
from ...model.gears.limits import Finding, check_limits, gravest
from .intervals import Span
from .motions import MEAN, MOTOR, OMEGA, TORQUE, LoadMotions
from .rules import Rules, needs_of

NO_USAGE = Usage(0.0, 0.0, 0.0, 0.0)


def with_ratings(rules: Rules, project: Project, span: Span) -> Rules:
    """The rules with the speeds and the motor torque by which a drive of this gear and motor fails."""
    speeds = [f.bound * RPM for f in _findings(project, span[1], NO_USAGE) if f.fails]
    sheet = project.motor_limits
    findings = () if project.gear is None else check_limits(project.gear, peak_torque=0.0, average_torque=0.0)
    torques = {f.limit: f.bound for f in findings}
    mean = torques.pop("average_torque", None)
    return replace(
        rules, speed=min(speeds, default=None), sheet=sheet, gear_torque=min(torques.values(), default=None),
        motor_torque=None if sheet is None or math.isinf(sheet.torque) else sheet.torque, mean_torque=mean,
    )  # fmt: skip


def beyond_ratings(
    project: Project, fastest: float, by_load: list[LoadMotions], texts: dict[float, str], resting: float
) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Sentences about limits that the motions pass: those by which the drive fails, and others.

    Parameters
    ----------
    project : Project
        The drive with its gear and its motor.
    fastest : float
        Largest speed [rad/s].
    by_load : list of LoadMotions
        The motions under each load.
    texts : dict
        Name of each load.
    resting : float
        Largest torque [N*m, motor side] of the loads at rest.
    """
    worst = dict[str, tuple[Finding, str]]()
    for loaded in by_load:
        used, use = asked_under(loaded)
        places = {"average_torque": used.at_average, PEAK: use.at}
        for finding in _findings(project, fastest, used, use, needs_of(loaded), resting):
            known = worst.get(finding.limit)
            if known is None or known[0].value - known[0].bound < finding.value - finding.bound:
                omega = places.get(finding.limit, used.at_peak) if finding.omega is None else finding.omega
                where = f" (at {project.speeds.said(omega, 5)} under {texts[loaded.load]})"
                placed = finding.unit != "rpm" and finding.limit != BRAKE
                worst[finding.limit] = finding, finding.sentence + where * placed
    passed = gravest(tuple(finding for finding, _ in worst.values()))
    failures = tuple(worst[finding.limit][1] for finding in passed if finding.fails)
    return failures, tuple(worst[finding.limit][1] for finding in passed if not finding.fails)


def asked_under(loaded: LoadMotions) -> tuple[Usage, MotorUse]:
    """Largest torques that the motions under a load ask of the gear and of the motor, with their speeds."""
    table = np.concatenate([np.zeros((1, MEAN + 1)), *(run for run, _ in loaded.runs)])
    torque, mean, motor = (table[np.argmax(table[:, column])] for column in (TORQUE, MEAN, MOTOR))
    loose = [(one.torque, one.omega) for one in loaded.loose if math.isfinite(one.torque)]
    used = Usage(*max([(float(torque[TORQUE]), float(torque[OMEGA])), *loose]), float(mean[MEAN]), mean[OMEGA])
    return used, MotorUse(float(motor[MOTOR]), motor[OMEGA], 0.0)


def findings_under(project: Project, loaded: LoadMotions) -> tuple[Finding, ...]:
    """Limits of gear and motor that the motions under one load of a project pass, the gravest first."""
    resting = max(map(abs, project.load_torques)) / project.drive.N
    findings = _findings(project, project.speeds.given[-1], *asked_under(loaded), needs_of(loaded), resting)
    passed = gravest(tuple(one for one in findings if one.exceeded))
    return tuple(sorted(passed, key=lambda one: one.limit == "average_torque"))


def _findings(
    project: Project, fastest: float, used: Usage, motor: MotorUse | None = None, needs: Iterable[Need] = (),
    resting: float | None = None,
) -> tuple[Finding, ...]:  # fmt: skip
    speed = fastest if project.speeds.by_motor else None
    return limit_findings(project.gear, used, speed, project.motor_limits, motor, needs, resting)
