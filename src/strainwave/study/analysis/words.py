"""Words that several parts of an `Analysis` share: limits of gear and motor, the move of the file, speeds and loads."""

import math
from typing import TYPE_CHECKING, Any

from ...base.number_text import number
from ...base.sentences import Angle, Sentence, Speed, listed
from ...base.units import RPM
from ...drive.demands.motor_limits import BRAKE, PEAK, RMS
from ...drive.train_curve import unfollowed
from ...model.gears.limits import RATED, Finding, gravest

if TYPE_CHECKING:
    from .analysis import Analysis

MOTOR = (PEAK, "motor speed", RMS, RATED, BRAKE)
NOTHING_STABLE = "no steady motion of the range is stable"
PASSED_ONLY = ("max_rpm", "average_rpm", "average_torque", *MOTOR)  # limits that are named only where they are passed
NAMES = {
    "max_rpm": "largest input speed", "average_rpm": "average input speed", "motor torque": "motor's largest torque",
    "motor speed": "motor's largest speed", RMS: "motor's continuous torque", RATED: "motor's rated speed",
    BRAKE: "torque of the motor's brake",
}  # fmt: skip


def excess_text(finding: Finding) -> str:
    """Words on a value that is above a limit."""
    return f"{number(finding.value)} {_unit(finding)} exceeds {limit_text(finding)}"


def limit_text(finding: Finding) -> str:
    """Name and size of a limit."""
    name = NAMES.get(finding.limit, finding.limit.replace("_", " "))
    return f"the {name} of {number(finding.bound)} {_unit(finding)}"


def _unit(finding: Finding) -> str:
    return finding.unit.replace("*", "·")


def move_failures(analysis: "Analysis") -> list[Finding]:
    """Limits of gear and motor by which the move of the file fails."""
    moved = analysis.moved
    return [] if moved is None else [finding for finding in gravest(moved.findings) if finding.fails]


def move_sentence(analysis: "Analysis") -> str:
    """Demands of the file's move on gear and motor, and its pointing error."""
    moved = analysis.moved
    if moved is None:
        return ""
    times, digits = [time for time in moved.settling_times if time is not None], analysis.project.digits()
    still = f"settles {number(max(times), 3)} s after the move" if times else "does not settle in the simulated time"
    still = still if len(times) in (0, len(moved.settling_times)) else "does not settle after every motion"
    text = "Motor torque up to {} N·m, rms {} N·m, motor speed up to {} rpm; gear torque up to {} N·m. Pointing "
    text += "error up to {} during the move. The load {}."
    torques = (moved.peak_motor_torque, moved.rms_motor_torque, moved.peak_gear_torque)
    peak, rms, gear = (number(torque, digits) for torque in torques)
    sentence = Sentence(text, peak, rms, number(moved.peak_speed / RPM), gear, Angle(moved.peak_error), still)
    return sentence + "".join(" " + one.sentence.replace("*", "·") for one in move_failures(analysis))


def load_text(torque: float | None) -> str:
    """The torque [N*m] of the load that a result is for, where it has a range of them."""
    return "" if torque is None else f" under a load torque of {number(torque)} N·m"


def largest_text(largest: Any) -> Sentence:
    """Speed and load of the largest oscillation; where it beats, its smallest turn and its period too."""
    sentence = Speed(largest.omega, digits=5) + load_text(largest.torque)
    if largest.smallest is None or largest.beat is None:
        return sentence
    text = " (it beats: {} in the smallest turn, with a period of {} s)"
    return sentence + Sentence(text, Angle(largest.smallest), number(largest.beat, 3))


def equation_alone(analysis: "Analysis") -> str:
    """Model of the steady motions where the whole drive has no stable one; "" where they are its own."""
    study = analysis.train
    if study is None or not unfollowed(study.train, analysis.train_curve):
        return ""
    motor = "driven by torque" if analysis.project.motor == "free" else "ideally held"
    return f" in the error equation alone, with the motor {motor} and the load rigid"


def largest_of_all(analysis: "Analysis") -> tuple[float, str]:
    """The largest oscillation [rad] under the load of the file and in all postures, and the posture that has it."""
    tops = [(row.peak, f" in {row.title}") for row in analysis.postures if row.peak > 0.0]
    return max([(analysis.largest_oscillation().peak, ""), *tops], key=lambda top: top[0])


def postures_data(analysis: "Analysis") -> list[dict[str, Any]]:
    """Every posture as data: its load, its answer, its largest oscillation, and the limits that it passes."""
    rows = []
    for row in analysis.postures:
        load = {"posture": row.title, "load_inertia_kg_m2": row.inertia, "load_torque_Nm": row.torque}
        size, speed = (None, None) if math.isnan(row.peak) else (row.peak, row.omega)
        rows.append(load | {"answer": str(row.answer), "oscillation_rad": size, "at_rad_per_s": speed})
        rows[-1]["limits_passed"] = [one.sentence for one in row.exceeded]
    return rows


def posture_sentence(analysis: "Analysis", ending: str = "") -> Sentence:
    """The worst posture of the file, with its largest oscillation and a last sentence; empty where it has none."""
    worst = analysis.posture
    if worst is None:
        return Sentence("")
    size = Sentence("oscillation {} at {}", Angle(worst.peak), Speed(worst.omega, digits=5))
    reasons = listed([NOTHING_STABLE if math.isnan(worst.peak) else size, *map(excess_text, worst.exceeded)])
    text = "Worst of the {} postures: {}, {}: {}." + ending
    return Sentence(text, len(analysis.postures), worst.title, worst.answer, reasons)


def how_sure(analysis: "Analysis") -> Sentence:
    """Sentence on the range for all assumed numbers, or for the damping alone; empty where nothing is assumed."""
    sure = analysis.project.sureness
    if not sure.doubts:
        return _damping_range(analysis)
    together = sure.together(analysis.project.limit)
    return Sentence(f"{together[:1].upper()}{together[1:]}.")


def _damping_range(analysis: "Analysis") -> Sentence:
    """Sentence on the oscillation with less and with more damping, which no catalogue prints; empty if measured."""
    project, avoid = analysis.project, analysis.avoid
    measured = any(one.word == "measured" and one.name.startswith("damping.") for one in project.sources)
    if measured or len(analysis.other_damping) < 2 or avoid is None:
        return Sentence("")
    less, more = analysis.other_damping
    ratio, B = project.damping_ratio, project.drive.B
    size, unit = (B, "N·m·s/rad") if ratio is None else (100.0 * ratio, "%")
    low, high = number(size * (1.0 + less.share), 2), number(size * (1.0 + more.share), 2)
    sizes = [Angle(end.ratio * avoid.largest, digits=3) for end in (less, more)]
    sides = {(True, True): "all above", (False, False): "all within", (True, False): "the second value within"}
    side = sides.get((bool(less.exceeds), bool(more.exceeds)))
    against = f", {side} the limit" if side and avoid.limit is not None else ""
    text = "Damping {} {} is not marked as measured; {} to {} {} would give an oscillation of {} to {}{}."
    return Sentence(text, number(size, 2), unit, low, high, unit, *sizes, against)
