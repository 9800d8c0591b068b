"""The curve that follows a slider: fewer points, over the shortest period that all of the excitation repeats with.

Where every order is a multiple of g, the drive repeats g times in a turn. Its motions are those of a base angle that is
g times as fast, with orders and harmonics g times lower: the same equation, with a g-th of the unknowns.
"""

import math
from dataclasses import replace
from typing import NamedTuple

from ...files.project import Project
from ...model.excitation import Harmonics
from ...numerics.balance.truncation import MATTERS
from ...study.analysis.drive_response import DriveResponse

POINTS = 40  # about; ends of bands and torques are those of 400 points within 0.2 %
FEWEST, MOST = 7, 63  # harmonics in a period: to begin with, and at most


class Curve(NamedTuple):
    """A response over a base angle, the project in it, and what turns rad/s of it into the speeds that are shown."""

    found: DriveResponse
    project: Project
    scale: float


def solved(project: Project, whole: bool = False) -> Curve:
    """The response with machine code; `whole` looks for motions that do not join the curve, too, at more points."""
    scale = project.speeds.scale
    if whole:
        return Curve(project.response(), project, scale)
    own, g = folded(project)
    if g == 1:
        return Curve(own.response(coexisting=False, points=POINTS), own, scale)
    h = max([FEWEST, *_orders(own)])
    while True:
        found = own.response(h, coexisting=False, points=POINTS)
        if found.curve.tail <= MATTERS or h >= MOST:
            return Curve(_as_fast(found, g) if own.motor == "held" else found, own, scale / g)
        h = min(2 * h + 1, MOST)


def _as_fast(found: DriveResponse, g: int) -> DriveResponse:
    """The response with the torque of the motor itself; a motor that is g times as fast gives a g-th of it."""
    if found.motor_torque is None or found.motor_mean is None:
        return found
    return replace(found, motor_torque=g * found.motor_torque, motor_mean=g * found.motor_mean)


def folded(project: Project) -> tuple[Project, int]:
    """The project over the shortest period of its excitation, and how often that is in a turn of the base angle."""
    g = math.gcd(*_orders(project))
    others = (project.train, project.damping, project.stiffness)  # these do not repeat with it, or need not
    if g < 2 or project.has_memory or any(one is not None for one in others):
        return project, 1
    error = project.kinematic_error
    if error is not None:
        error = error._replace(lines=tuple(line._replace(order=line.order // g) for line in error.lines))
    low, high = project.speeds.limits
    single = tuple(g * omega for omega in project.speeds.single)
    whole = project.whole
    if whole is not None and whole.motor.held:
        whole = whole._replace(N=g * whole.N, error=error or whole.error)
    return replace(
        project, speeds=replace(project.speeds, limits=(g * low, g * high), single=single), kinematic_error=error,
        motor_torque=_slower(project.motor_torque, g), load_torque=_slower(project.load_torque, g), whole=whole,
    ), g  # fmt: skip


def _slower(torque: Harmonics | None, g: int) -> Harmonics | None:
    """A torque over an angle that is g times as fast; a term without amplitude is its mean alone."""
    if torque is None:
        return None
    return Harmonics(tuple(term._replace(order=max(1, term.order // g)) for term in torque.terms))


def _orders(project: Project) -> list[int]:
    """Orders of the excitation on the base angle; of torques those with an amplitude."""
    lines = () if project.kinematic_error is None else project.kinematic_error.lines
    terms = [term for torque in (project.motor_torque, project.load_torque) if torque for term in torque.terms]
    return [line.order for line in lines] + [term.order for term in terms if term.amplitude]
