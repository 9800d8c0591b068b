"""The report's findings in sentences: warnings, what a sweep does, verdicts, and the summary on the terminal."""

from typing import Any

from ...files.project import Project
from ...model.drive import HDC_40_050, HDC_40_050_WARNING
from ...sentences import Angle, Sentence, Speed
from ...study.analysis.analysis import Analysis
from ...study.analysis.usage import gravest
from ...study.response.response import ExactResponse
from ..console import BETWEEN, WHAT_X_IS, number
from ..units import AngleUnit, angle_unit


def warnings(project: Project, analysis: Analysis) -> list[str]:
    """What the reader must know before using the numbers, the gravest first."""
    said = _overload(analysis)
    article = (HDC_40_050.law, HDC_40_050.J_m, HDC_40_050.J_l)
    if (project.drive.law, project.drive.J_m, project.drive.J_l) == article:
        said.append(HDC_40_050_WARNING)
    said += analysis.warnings
    sweep = analysis.response.sweep
    for band in () if sweep is None else sweep.bands:
        text = (
            "Run-up and run-down differ between {}: two stable motions exist there, and which one the drive is on "
            "depends on its history; pass through that band quickly or keep out of it."
        )
        beyond = "" if band.whole else " A jump between them lies outside the speed range; take a wider one to see it."
        said.append(Sentence(text, Speed(band.low, band.high, digits=5)) + beyond)
    for jump in () if sweep is None else sweep.alone:
        text = (
            "The response jumps at {}, and in the other direction its stable motions end before that speed: the curve "
            "does not show what follows there; integrate to see it."
        )
        said.append(Sentence(text, Speed(jump.value, digits=5)))
    return [*said, *project.notes]


def _overload(analysis: Analysis) -> list[str]:
    """Which limits of the gear's datasheet the run passes, if any."""
    used, said = analysis.usage, list[str]()
    for finding in sorted(gravest(analysis.limits), key=lambda f: f.value != used.peak_torque):  # that one breaks gears
        where = {used.peak_torque: used.at_peak, used.average_torque: used.at_average}.get(finding.value)
        at = "" if where is None else Sentence("At {}: ", Speed(where, digits=5))
        said.append(at + finding.sentence.replace("N*m", "N·m"))
    return said


def sweep_sentences(exact: ExactResponse) -> list[str]:
    """What a slow run-up and run-down do, a sentence for each."""
    sweep, said = exact.sweep, list[str]()
    if sweep is None:
        return ["No motion on the curve is stable."]
    for name, jumps, whole in (
        ("run-up", sweep.on_run_up, sweep.finished_up),
        ("run-down", sweep.on_run_down, sweep.finished_down),
    ):
        steps = Sentence(" and ").join(
            Sentence("from {} to {} at {}", Angle(j.before), Angle(j.after), Speed(j.value)) for j in jumps
        )
        does = Sentence("jumps {}", steps) if jumps else "does not jump"
        end = "." if whole else "; the curve has no stable motion all the way, so the drive leaves it."
        said.append(Sentence("On a slow {} the largest |x| {}{}", name, does, end))
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
    size, speed = "large" if error["amplitude"] > 0.0 else "small", "high" if error["speed"] > 0.0 else "low"
    return (
        f"relative to the computed curve, the amplitude is {sizes[0]} too {size} and the resonance speed {sizes[1]} "
        f"too {speed}"
    )


def jump_verdict(row: dict[str, Any]) -> str:
    """Where the computed curve jumps next to a resonance, and where multiple scales has it jump."""
    computed, predicted = (" and ".join(map(speed_text, row[name])) for name in ("jumps", "folds"))
    if not computed and not predicted:
        return ""
    said = f"The computed curve jumps at {computed}" if computed else "Here the computed curve does not jump"
    return said + (f"; multiple scales would at {predicted}." if predicted else ", that of multiple scales does not.")


def stability_text(results: dict[str, Any]) -> str:
    """The proof of stability in a line: what is claimed, or why nothing is."""
    proof = results["stability"]
    return f"no proof: {proof['obstacle']}" if proof["scope"] == "none" else f"{proof['scope']}; {proof['claim']}"


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
    lines.append(f"  stability{' of the error equation' if whole else ''}: {stability_text(results)}")
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
    for row in results["natural_frequencies"]:
        omega_0, spring = row["omega_rad_per_s"], row["spring_rad_per_s"]
        used = ", used here" if row["used"] else ""
        alone = "" if spring is None else f" before the hysteresis yields, {number(spring)} rad/s of the spring alone"
        said = f"{number(omega_0)} rad/s ({number(row['hertz'])} Hz){alone}"
        lines.append(f"  natural frequency, motor {row['motor']}{used}: {said}")
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
