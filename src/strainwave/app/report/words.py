"""The report's findings in sentences: warnings, what a sweep does, verdicts, and the summary on the terminal."""

import math
import re
from typing import Any

from ...files.project import Project
from ...model.drive import HDC_40_050, HDC_40_050_WARNING
from ...study.analysis.analysis import Analysis
from ...study.analysis.usage import gravest
from ...study.response.response import ExactResponse
from ...units import RPM
from ..console import BETWEEN, WHAT_X_IS, number
from ..units import AngleUnit, angle_unit
from .resonances import place

NUMBER = re.compile(r"[0-9.]*[0-9](?:e[-+]?[0-9]+)?")
SPEEDS = re.compile(rf"({NUMBER.pattern}(?:(?:, | to | and | or | \.\. ){NUMBER.pattern})*) rad/s(?![\^*/0-9])")
RADIANS = re.compile(r"(-?[0-9.]+(?:e[-+]?[0-9]+)?) rad\b(?![/^])")  # an angle in a sentence of the theory


def with_unit(text: str, angle: AngleUnit) -> str:
    """Write the angles of a sentence in the report's unit."""
    return RADIANS.sub(lambda found: angle.text(float(found[1])), text)


def with_rpm(project: Project, text: str) -> str:
    """Write the base-angle speeds of a sentence in rpm of the motor, where the base angle is the motor's."""
    if project.shaft == "forcing":
        return text

    def converted(found: re.Match[str]) -> str:
        return NUMBER.sub(lambda value: number(float(value[0]) / RPM, 5), found[1]) + " rpm at the motor"

    return SPEEDS.sub(converted, text)


def warnings(project: Project, analysis: Analysis) -> list[str]:
    """What the reader must know before using the numbers, the gravest first."""
    said = _overload(project, analysis)
    article = (HDC_40_050.law, HDC_40_050.J_m, HDC_40_050.J_l)
    if (project.drive.law, project.drive.J_m, project.drive.J_l) == article:
        said.append(HDC_40_050_WARNING)
    said += analysis.warnings
    sweep = analysis.response.sweep
    for band in () if sweep is None else sweep.bands:
        first, last = (speed_text(place(project, w)) for w in (band.low, band.high))
        said.append(
            f"Run-up and coast-down differ between {first.split()[0]} and {last}: two stable motions exist there, and "
            "which one the drive is on depends on its history; pass through that band quickly or keep out of it."
            + ("" if band.whole else " A jump between them lies outside the speed range; take a wider one to see it.")
        )
    for jump in () if sweep is None else sweep.alone:
        said.append(
            f"The response jumps at {speed_text(place(project, jump.value))}, and in the other direction its stable "
            "motions end before that speed: the curve does not tell what follows there; integrate to see it."
        )
    return [with_rpm(project, text) for text in (*said, *project.notes)]


def _overload(project: Project, analysis: Analysis) -> list[str]:
    """Which limits of the gear's datasheet the run passes, if any."""
    used, said = analysis.usage, []
    for finding in sorted(gravest(analysis.limits), key=lambda f: f.value != used.peak_torque):  # that one breaks gears
        where = {used.peak_torque: used.at_peak, used.average_torque: used.at_average}.get(finding.value)
        at = "" if where is None else f"At {speed_text(place(project, where))}: "
        said.append(at + finding.sentence.replace("N*m", "N·m"))
    return said


def sweep_sentences(project: Project, exact: ExactResponse, angle: AngleUnit) -> list[str]:
    """What a slow run-up and coast-down do, a sentence for each."""
    sweep, said = exact.sweep, []
    if sweep is None:
        return ["No motion on the curve is stable."]
    for name, jumps, whole in (
        ("run-up", sweep.on_run_up, sweep.finished_up),
        ("coast-down", sweep.on_run_down, sweep.finished_down),
    ):
        steps = [
            f"from {angle.text(j.before)} to {angle.text(j.after)} at {speed_text(place(project, j.value))}"
            for j in jumps
        ]
        text = f"On a slow {name} the largest |x| " + (f"jumps {' and '.join(steps)}" if steps else "does not jump")
        said.append(text + ("." if whole else "; the curve has no stable motion all the way, so the drive leaves it."))
    return said


def peak_verdict(row: dict[str, Any]) -> str:
    """How far the peak by multiple scales is off, in an engineer's words."""
    error = row["peak_error"]
    if error is None:
        return ""
    if error["predicted"]:
        off = (
            f"{number(100.0 * error['amplitude'], 2)} % in amplitude and {number(100.0 * error['speed'], 2)} % in speed"
        )
        return f"no computed curve to compare with; by its own estimate off by about {off}"
    sizes = [f"{number(100.0 * abs(error[name]), 2)} %" for name in ("amplitude", "speed")]
    higher, faster = ("too high" if error["amplitude"] > 0.0 else "too low"), "fast" if error["speed"] > 0.0 else "slow"
    return f"against the computed curve {sizes[0]} {higher} and {sizes[1]} too {faster}"


def jump_verdict(row: dict[str, Any]) -> str:
    """Where the computed curve jumps next to a resonance, and where multiple scales has it jump."""
    computed, predicted = (" and ".join(map(speed_text, row[name])) for name in ("jumps", "folds"))
    if not computed and not predicted:
        return ""
    said = f"The computed curve jumps at {computed}" if computed else "Here the computed curve does not jump"
    return said + (f"; multiple scales would at {predicted}." if predicted else ", that of multiple scales does not.")


def stability_text(results: dict[str, Any], angle: AngleUnit) -> str:
    """The proof of stability in a line: what is claimed, or why nothing is."""
    proof = results["stability"]
    if proof["scope"] != "none":
        return f"{proof['scope']}; {with_unit(proof['claim'], angle)}"
    reason = with_unit(proof["reason"], angle)
    return f"no proof: {re.split(r'; |(?<=[a-z]): |, whose ', reason)[0].rstrip('.')}"


def summary(results: dict[str, Any]) -> str:
    """Key numbers in a few lines."""
    worst, torque = results["largest_error"], results["largest_torque"]
    angle = angle_unit(worst["peak_rad"])
    whole = (results.get("train") or {}).get("curve") is not None
    lines = [results["title"], *(_train_lines(results) if whole else _equation_lines(results, angle))]
    steady = "|x| in the run-up" if worst["of"].startswith("run-up") else "steady |x|"
    lines.append(f"  largest {steady} {BETWEEN}: {angle.text(worst['peak_rad'])} at {speed_text(worst)}")
    text = f"  largest torque through the gear: {number(torque['torque_Nm'])} N·m at {speed_text(torque)}"
    for name in ("momentary", "repeated_peak"):
        limit = torque[f"{name}_torque_Nm"]
        if limit is not None and torque["torque_Nm"] > limit:
            text += f", MORE than the {name.replace('_', ' ')} torque of {number(limit)} N·m"
            break
    lines.append(text)
    advice = results.get("advice")
    if advice is not None:
        lines += [f"  {advice[name]}" for name in ("sentence", "about", "nominal", "remedy_sentence") if advice[name]]
    if results.get("reduction"):
        lines.append(f"  {results['reduction']['sentence']}")
    lines.append(f"  stability{' of the error equation' if whole else ''}: {stability_text(results, angle)}")
    lines.append(f"  {WHAT_X_IS}")
    if results["warnings"]:
        lines.append(f"  {len(results['warnings'])} warning(s) in the report")
    return "\n".join(lines)


def _train_lines(results: dict[str, Any]) -> list[str]:
    """Lines about a whole drive train: its modes and its jumps."""
    train = results["train"]
    modes = [f"{number(m['hertz'], 3)} Hz ({number(100.0 * m['damping_ratio'], 2)} %)" for m in train["modes"]]
    said = [
        f"  whole drive train: {train['parts']}",
        f"  its modes at the operating point (damping ratio): {', '.join(modes) or 'none'}",
    ]
    jumps = train["curve"]["jumps"]
    if jumps:
        said.append(f"  it jumps at {' and '.join(speed_text(place) for place in jumps)}")
    if not train["curve"]["all_stable"]:
        said.append("  part of its curve is unstable")
    return said


def _equation_lines(results: dict[str, Any], angle: AngleUnit) -> list[str]:
    """Lines about the error equation: natural frequencies and primary resonances."""
    lines = []
    free = {(f["name"], f["unit"]): f["value"] for f in results["derived"]}
    for mode in ("free", "held"):
        omega_0 = free.get((f"Natural frequency, motor {mode}", "rad/s"))
        used = ", used here" if mode == results["motor"] else ""
        spring = free.get((f"Natural frequency of the spring alone, motor {mode}", "rad/s"))
        if omega_0:
            hertz = number(omega_0 / (2.0 * math.pi))
            told = (
                f" before the hysteresis yields, {number(spring)} rad/s of the spring alone"
                if spring is not None
                else ""
            )
            lines.append(f"  natural frequency, motor {mode}{used}: {number(omega_0)} rad/s ({hertz} Hz){told}")
    for row in results["resonances"]:
        if row["inside_range"] and row["name"] == "primary":
            lines += _resonance_lines(row, angle)
    return lines


def _resonance_lines(row: dict[str, Any], angle: AngleUnit) -> list[str]:
    """Lines about a resonance, and the jumps of the computed curve next to it."""
    top = row["top"]
    text = f"  {row['name']} resonance of order {row['order']}: small oscillations at {speed_text(row)}"
    lines = [text + (f", largest at {speed_text(top)}" if top else "")]
    if row["jumps"]:
        lines.append(f"    jumps at {' and '.join(speed_text(jump) for jump in row['jumps'])}")
    if row["peak"]:
        lines.append(f"    peak by multiple scales {angle.text(row['peak']['amplitude_rad'])}: {peak_verdict(row)}")
    return lines


def speed_text(row: dict[str, Any]) -> str:
    """Write the speed of a place: at the motor, or the forcing frequency."""
    if row["motor_speed_rpm"] is None:
        return f"{number(row['omega_rad_per_s'], 5)} rad/s"
    return f"{number(row['motor_speed_rpm'], 5)} rpm at the motor"
