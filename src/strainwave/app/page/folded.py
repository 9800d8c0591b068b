"""The project over the shortest period that all of its excitation repeats with: the curve that follows a slider."""

import math
from dataclasses import replace

from ...drive.project import Project
from ...model.excitation import Harmonics

POINTS = 40  # about; ends of bands and torques are those of 400 points within 0.2 %


def folded(project: Project) -> tuple[Project, int]:
    """The project over the shortest period of its excitation, and how often that is in a turn of the base angle."""
    orders = orders_of(project)
    g = 1 if any(order % 1 for order in orders) else math.gcd(*map(int, orders))
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


def orders_of(project: Project) -> list[int]:
    """Orders of the excitation on the base angle; of torques those with an amplitude."""
    lines = () if project.kinematic_error is None else project.kinematic_error.lines
    terms = [term for torque in (project.motor_torque, project.load_torque) if torque for term in torque.terms]
    return [line.order for line in lines] + [term.order for term in terms if term.amplitude]
