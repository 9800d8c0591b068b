"""The first questions of a reader with their answers: requirement, margin, worst speed, smallest change."""

import math
from typing import Any

from ...base.sentences import Angle, Sentence, Speed, listed
from ...base.units import RPM
from ...drive.asked import MotorLimits
from ...model.gears.limits import Finding
from ...study.analysis.avoid import out_of_reach
from ...study.analysis.verdict import Answer
from ..console import number, percent
from ..view import View
from .sections.whole_train import under_load
from .verdict import ADD_LIMIT, changes_said, ranges, share, torque_said

LEAST = 0.01  # share of the motor's torque from which on the steady part is told
FEW = 6  # speeds of jumps that are listed; of more the ends


def answers(view: View) -> dict[str, Any]:
    """Sentences by what they answer, in the order of the page; a question without an answer is left out."""
    verdict = view.analysis.verdict
    torque = torque_said(view, verdict, with_motor=False)
    found: dict[str, str] = {
        "requirement": _requirement(view),
        "largest oscillation": _worst(view),
        "margin": _margin(view),
        "jumps": _jumps(view),
        "torque": f"{torque[0].upper()}{torque[1:]}.",
        "motor": _motor(view),
        "smallest change": _change(view),
        "without a change": "",
    }
    if verdict.answer is Answer.BUT:
        found["without a change"] = Sentence("Keep to {}.", ranges(verdict.allowed))
    return {what: said for what, said in found.items() if said}


def _requirement(view: View) -> str:
    """The limit of the file, or how to write one."""
    if view.project.limit is None:
        return "The project file has no limit of the oscillation. " + ADD_LIMIT
    text = "The oscillation of the {} must stay within {} at {}."
    speeds = Speed(*view.analysis.speeds, digits=5, between=" to ")
    said = Sentence(text, view.analysis.drive.name, Angle(view.project.limit), speeds)
    avoid = view.analysis.avoid
    below = "" if avoid is None else out_of_reach(avoid.limit, avoid.slow)
    return said + f" {below[0].upper()}{below[1:]}." if below else said


def _motor(view: View) -> str:
    """The torque and the speed that the motor must have, and what it has."""
    motor, limits = view.analysis.motor, view.project.motor_limits
    if motor is None:
        return ""
    study, run = view.analysis.train, " in the run-up, its acceleration left out" * motor.in_run_up
    text = "It must give up to {} N·m{}, at {}"
    said = Sentence(text, number(motor.torque), run, Speed(motor.at, digits=5) + under_load(motor.load))
    if motor.holding > LEAST * motor.torque:
        said += f"; steady loads and friction alone take up to {number(motor.holding)} N·m"
    torque, speed = limits or MotorLimits()
    said += "." + _has(motor.torque, torque, "N·m")
    if view.speeds.by_motor:
        fastest = view.speeds.given[-1] / RPM
        said += f" It must turn at up to {number(fastest, 5)} rpm." + _has(fastest, speed / RPM, "rpm")
    if motor.run_up is not None and study is not None and study.ramp is not None:
        text = f" The run-up of {number(study.ramp.duration, 3)} s takes up to {number(motor.run_up)} N·m with its "
        slower = Finding("", motor.run_up, torque, "", "").exceeded
        said += text + "acceleration" + (": run up more slowly." if slower else ".")
    return said if limits else said + " The project file gives no limits of the motor."


def _has(asked: float, bound: float, unit: str) -> str:
    """What a motor has against what is asked of it; nothing where that is not known."""
    if not math.isfinite(bound):
        return ""
    return f" It has {number(bound)} {unit}" + (": too little." if Finding("", asked, bound, "", "").exceeded else ".")


def _worst(view: View) -> Sentence:
    """The largest oscillation, and the speed and load torque at which it is."""
    largest = view.analysis.largest_oscillation()
    return Sentence("{} at {}.", Angle(largest.peak), Speed(largest.omega, digits=5) + under_load(largest.torque))


def _margin(view: View) -> Sentence:
    """How far the oscillation is below its limit or above it; nothing without a limit."""
    part, limit = share(view), view.project.limit
    if part is None or limit is None:
        return Sentence("")
    where = "above" if part > 1.0 else "below"
    said = Sentence("{} ({}) {} the limit.", Angle(abs(part - 1.0) * limit), percent(abs(part - 1.0), 2), where)
    avoid = view.analysis.avoid
    if avoid is not None and avoid.largest_passed is not None and avoid.largest_passed[1] > limit:
        said += Sentence(" In the run-up the oscillation reaches {}.", Angle(avoid.largest_passed[1]))
    return said


def _jumps(view: View) -> Sentence:
    """The speeds at which a slow run-up or run-down jumps, under every load torque."""
    sweeps = [drive.response.sweep for _, drive in view.analysis.curves]
    at = sorted(
        {jump.value for sweep in sweeps if sweep is not None for jump in (*sweep.on_run_up, *sweep.on_run_down)}
    )
    if not at:
        return Sentence("No jump on a slow run-up or run-down." if None not in sweeps else "")
    if len(at) > FEW:
        return Sentence("On a slow run-up or run-down, between {}.", Speed(at[0], at[-1], digits=5))
    every = listed(Sentence("{}", Speed(omega, digits=5, bare=True)) for omega in at) + " " + Speed()
    return Sentence("On a slow run-up or run-down, at {}.", every)


def _change(view: View) -> Sentence:
    """The smallest change that makes a failing drive pass."""
    said = changes_said(view, view.analysis.verdict)
    if not said:
        passes = view.analysis.verdict.answer is Answer.ALL_RIGHT
        return Sentence("No change is needed." if passes and view.project.limit is not None else "")
    return Sentence(" ").join(said)
