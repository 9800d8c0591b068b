"""The torques and speeds of a speed map against the limits of its gear and its motor."""

import math
from dataclasses import replace
from typing import Any

import numpy as np

from ...model.gears.limits import Finding, gravest
from ...results import Floats
from ...units import RPM
from ..analysis.usage import MotorUse, Usage, limit_findings
from .motions import MOTOR, OMEGA, UnderLoad
from .rules import Rules, Span

NOTHING = Usage(0.0, 0.0, 0.0, 0.0)


def with_ratings(rules: Rules, project: Any, span: Span) -> Rules:
    """The rules with the speeds and the motor torque by which a drive of this gear and motor fails."""
    bounds = [f.bound * RPM for f in _findings(project, span[1], NOTHING) if f.fails]
    most = math.inf if project.motor_limits is None else project.motor_limits.torque
    return replace(rules, speed=min(bounds, default=None), motor_torque=most if math.isfinite(most) else None)


def beyond_ratings(
    project: Any, speeds: Floats, loads: Floats, torque: Floats, found: list[UnderLoad], unit: str
) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Sentences about limits that the map passes: those by which the drive fails, and others.

    Speeds (m,) [rad/s] and loads (n,) of cells, torques (n, m) [N*m] in the gear, and the motions under each load.
    """
    known = np.where(np.isfinite(torque), torque, 0.0)
    load, at = np.unravel_index(np.argmax(known), known.shape)
    used = replace(NOTHING, peak_torque=float(known[load, at]))
    tops = [(run[np.argmax(run[:, MOTOR])], own.load) for own in found for run, _ in own.runs]
    top, under = max(tops, key=lambda one: float(one[0][MOTOR]), default=(np.zeros(MOTOR + 1), 0.0))
    motor = MotorUse(float(top[MOTOR]), float(top[OMEGA]), 0.0)
    places = {"motor torque": (motor.at, under)}

    def said(finding: Finding) -> str:
        omega, value = places.get(finding.limit, (speeds[at], loads[load]))
        where = "" if finding.unit == "rpm" else f" (at {omega / RPM:.5g} rpm under {value:.4g} {unit})"
        return finding.sentence + where

    passed = gravest(_findings(project, float(speeds[-1]), used, motor))
    return tuple(said(f) for f in passed if f.fails), tuple(said(f) for f in passed if not f.fails)


def _findings(project: Any, fastest: float, used: Usage, motor: MotorUse | None = None) -> tuple[Finding, ...]:
    return limit_findings(project.gear, used, fastest if project.speeds.by_motor else None, project.motor_limits, motor)
