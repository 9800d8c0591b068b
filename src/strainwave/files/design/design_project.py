"""A design as a project file, so that every command and study takes it."""

import json

from ...model.gears import catalogue
from ...model.train.controls import Tuning
from ...study.design.result import Candidate
from ...study.design.specification import Specification
from ..entries import project_entry


def design_text(specification: Specification, candidate: Candidate) -> str:
    """Write a design as a project file: its drive under the worst load and the mean torque, through the speeds.

    Parameters
    ----------
    specification : Specification
        What was asked.
    candidate : Candidate
        A design of the answer.

    Returns
    -------
    str
        YAML that `read_project` reads.

    Raises
    ------
    ValueError
        If a project file does not take the loop of the motor.
    """
    spec, c = specification, candidate
    title = f"{spec.title}: {c.gear}" if spec.title else c.gear
    motor = c.motor_inertia + (catalogue.gear(c.gear).input_inertia or 0.0)
    low, high = spec.speeds
    torque = f", load_torque: {{mean: {c.load_torque!r} N*m}}" if c.load_torque else ""
    return (
        f"title: {json.dumps(title, ensure_ascii=False)}\n"
        f"gear: {c.gear}\n"
        f"motor: {{inertia: {motor!r} kg*m^2, {_loop(spec)}}}\n"
        f"load: {{inertia: {c.load_inertia!r} kg*m^2}}\n"
        f"damping: {{B: {c.B!r} N*m*s/rad}}\n"
        f"speed: {{from: {low!r} rad/s, to: {high!r} rad/s, shaft: load}}\n"
        f"excitation: {{{_error(spec)}{torque}}}\n"
        f"limit: {{oscillation: {spec.limit!r} rad}}\n"
    )


def _loop(spec: Specification) -> str:
    if spec.loop is None:
        return "mode: held"
    if not isinstance(spec.loop, Tuning):
        return f"loop: {project_entry(spec.loop)}"
    loop = spec.loop
    lag = f", lag: {loop.lag!r} s" if loop.lag else ""
    return f"loop: {{type: {loop.kind}, bandwidth: {loop.bandwidth!r} rad/s, damping: {loop.damping!r}{lag}}}"


def _error(spec: Specification) -> str:
    if spec.kinematic_error is None:
        return "accuracy: catalogue" if spec.accuracy is None else f"accuracy: {spec.accuracy!r} rad"
    lines = ", ".join(
        f"{{order: {line.order}, amplitude: {line.amplitude!r} rad, phase: {line.phase!r} rad}}"
        for line in spec.kinematic_error.lines
    )
    return f"kinematic_error: [{lines}]"
