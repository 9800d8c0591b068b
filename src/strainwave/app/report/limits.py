"""Limits of gear and motor in words, and the move of the file against them."""

from ...base.sentences import Angle, Sentence
from ...base.units import RPM
from ...drive.asked import BRAKE, PEAK, RMS
from ...model.gears.limits import RATED, Finding, gravest
from ..console import number
from ..view import View

MOTOR = (PEAK, "motor speed", RMS, RATED, BRAKE)
REST = ("max_rpm", "average_rpm", "average_torque", *MOTOR)  # limits that are named only where they are passed
NAMES = {
    "max_rpm": "largest input speed", "average_rpm": "average input speed", "motor torque": "motor's largest torque",
    "motor speed": "motor's largest speed", RMS: "motor's continuous torque", RATED: "motor's rated speed",
    BRAKE: "torque of the motor's brake",
}  # fmt: skip


def above(finding: Finding) -> str:
    """What is above which limit."""
    return f"{number(finding.value)} {_unit(finding)} are above {named(finding)}"


def named(finding: Finding) -> str:
    """Name and size of a limit."""
    name = NAMES.get(finding.limit, finding.limit.replace("_", " "))
    return f"the {name} of {number(finding.bound)} {_unit(finding)}"


def _unit(finding: Finding) -> str:
    return finding.unit.replace("*", "·")


def of_move(view: View) -> list[Finding]:
    """Limits of gear and motor by which the move of the file fails."""
    moved = view.analysis.moved
    return [] if moved is None else [finding for finding in gravest(moved.findings) if finding.fails]


def move_said(view: View) -> str:
    """What the move of the file asks of gear and motor, and how far the load is off in it."""
    moved = view.analysis.moved
    if moved is None:
        return ""
    times, digits = [time for time in moved.settling_times if time is not None], view.project.digits()
    still = f"it settles {number(max(times), 3)} s after its end" if times else "it does not settle in the run"
    still = still if len(times) in (0, len(moved.settling_times)) else "it does not settle after each motion"
    text = (
        "It takes up to {} N·m of the motor, rms {} N·m, at up to {} rpm, and {} N·m through the gear. The load is off "
    )
    text += "by up to {}; {}."
    torques = (moved.peak_motor_torque, moved.rms_motor_torque, moved.peak_gear_torque)
    peak, rms, gear = (number(torque, digits) for torque in torques)
    said = Sentence(text, peak, rms, number(moved.peak_speed / RPM), gear, Angle(moved.peak_error), still)
    return said + "".join(" " + one.sentence.replace("*", "·") for one in of_move(view))
