"""Opening of the report: the drive and its verdict."""

import math
from html import escape
from typing import Any

from ....base.archive import version
from ....base.facts import data as told_once
from ....base.law import spring_stiffness
from ....base.sentences import Speed
from ....base.units import RPM
from ....drive.demands.motor_limits import MotorLimits
from ....plot.svg import stacked
from ....study.analysis.analysis import Largest
from ....study.analysis.words import how_sure
from ...curves import CONVENTIONS
from ...view import View, sizes
from ..section import Part, html_table, paragraph
from .remedies import after_change, can_be_ordered
from .speed_range import drive_figure
from .whole_train import parts

YIELDS = 1.0 - 1e-9  # the spring alone is softer than the law by more than rounding
MARKS = "Dashed grey lines: resonances, numbered as in the appendix."
IN_SENTENCE = ("requirement", "postures", "largest oscillation", "margin", "torque")  # answers of its sentence
PAGE = 430.0  # width of the figure beside the remedies [px]
FIRST = 6  # remedies beside the figure


def opening(view: View) -> Part:
    """The verdict, conventions, natural frequencies, the largest error and torque, and the limits of the gear."""
    project, analysis = view.project, view.analysis
    data = {
        "strainwave": version(),
        "title": project.title,
        "revision": project.revision,
        "project": project.text,
        "motor": project.motor,
        "base_angle": project.speeds.base_angle,
        "verdict": (verdict := view.rendered(told_once(analysis.facts())["verdict"])),
        "conventions": CONVENTIONS,
        "speed_range_rad_per_s": list(analysis.speeds),
        "natural_frequencies": natural_frequencies(view),
        "error": analysis.drive.name,
        "largest_oscillation": _largest(view, analysis.largest_oscillation(), "oscillation"),
        "largest_error": _largest(view, analysis.largest(), "peak"),
        "largest_torque": _largest_torque(view),
        "required_motor": _required_motor(view),
        "move": None if analysis.moved is None else told_once(analysis.moved.facts()),
        "loop_margins": None if project.loop is None else project.loop.data(),
        "how_sure": told_once(project.sureness.facts(project.limit))["how_sure"]
        | {
            "sentence": how_sure(analysis),
            "ends": [
                {"damping_Nms_per_rad": end.after, **after_change(view, end), "above_limit": end.exceeds}
                for end in analysis.other_damping
            ],
        },
        "limits": [finding.data() for finding in analysis.limits],
    }
    quiet = {*IN_SENTENCE, *(("jumps",) if not analysis.jumping else ())}
    quiet |= {"loop"} if project.loop and not project.loop.weak and not analysis.verdict.fault else set()
    answers = (f"{what}: {answer}" for what, answer in verdict["answers"].items() if what not in quiet)
    return Part(data=data, lines=[verdict["sentence"], *answers], page=_first(view, verdict))


def _first(view: View, verdict: dict[str, Any]) -> str:
    """Title, drive and verdict, with the oscillation against speed, its limit and the speeds to avoid."""
    project, speeds = view.project, view.speeds
    gear = project.gear.name if project.gear else "explicit torsion law"
    ends = speeds.name + " " + Speed(*view.analysis.speeds, digits=5, between=" to ", bare=True) + f" {speeds.unit}"
    revision = f" · revision {project.revision}" if project.revision else ""
    drawn = stacked(drive_figure(view)[:1], 250.0, "oscillation of the error against speed", PAGE)
    answers = verdict["answers"]
    rows = "".join(f"<tr><th>{escape(w)}</th><td>{escape(text)}</td></tr>\n" for w, text in answers.items())
    over = "" if verdict["answer"] == "pass" else " over"
    marks = MARKS if view.analysis.train_curve is None and view.analysis.regimes else ""
    return (
        f"<header><h1>{escape(project.title)}</h1>\n"
        + paragraph(f"Dynamic error analysis · {gear} · {_about(view)} · {view.rendered(ends)}{revision}", "sub")
        + f'</header>\n<div class="verdict{over}">{paragraph(verdict["headline"], "answer")}'
        + f'<div class="first"><figure>{drawn}</figure>{_orders(view, answers)}</div>\n'
        + paragraph(marks, "note")
        + f'<table class="answers"><tbody>{rows}</tbody></table></div>\n'
    )


def _orders(view: View, answers: dict[str, str]) -> str:
    """Table of changes that can be ordered or set, the oscillation after each, and its mark against the limit."""
    rows, mark = list[tuple[str, str]](), {True: " ✗", False: " ✓", None: ""}
    for remedy in [one for one in view.analysis.remedies if can_be_ordered(one) and one.helps][:FIRST]:
        left = view.angle.text(after_change(view, remedy)["oscillation_rad"], view.project.digits())
        rows.append((str(remedy), left + mark[remedy.exceeds]))
    within = "; ✓: within the limit" * bool(view.project.limit)
    note = f"One change at a time, with the largest oscillation after it{within}." * bool(rows)
    if keep := answers.get("without a change"):
        rows.append((keep, ""))
    table = html_table(("change", "oscillation"), rows) + paragraph(note, "note")
    return f"<div><h2>What can be ordered or set</h2>{table}</div>" if rows else ""


def _about(view: View) -> str:
    """The drive in words."""
    if view.analysis.train is not None:
        return parts(view)
    how = "driven by torque" if view.project.motor == "free" else "held at constant speed by a stiff speed loop"
    return f"motor {view.project.motor} ({how})"


def _largest(view: View, largest: Largest, name: str) -> dict[str, Any]:
    """A largest error as data; the torque is that of the load, where the drive has a range of them."""
    origin = {"method": largest.method, "of": largest.of, "load_torque_Nm": largest.torque}
    beat = {} if largest.beat is None else sizes(largest.smallest, "smallest") | {"beat_s": largest.beat}
    return view.speed_data(largest.omega) | sizes(largest.peak, name) | origin | beat


def natural_frequencies(view: View) -> list[dict[str, Any]]:
    """Natural frequencies [rad/s] at the operating point in both motor modes, where there are any.

    `spring_rad_per_s` is that of the spring alone, after the hysteresis has yielded; None without hysteresis.
    """
    drive, point = view.project.drive, view.analysis.point
    spring = float(spring_stiffness(drive.law, point.x))
    return [
        {
            "motor": mode,
            "omega_rad_per_s": (omega_0 := math.sqrt(point.stiffness / inertia)),
            "hertz": omega_0 / (2.0 * math.pi),
            "spring_rad_per_s": math.sqrt(max(spring, 0.0) / inertia) if spring < point.stiffness * YIELDS else None,
            "used": mode == view.project.motor,
        }
        for mode, inertia in (("free", drive.J), ("held", drive.J_l))
        if point.stiffness > 0.0
    ]


def _required_motor(view: View) -> dict[str, Any] | None:
    """Torque and speed required of the motor, beside its limits in the file; None where not known."""
    motor, limits = view.analysis.motor, view.project.motor_limits or MotorLimits()
    if motor is None:
        return None
    return view.speed_data(motor.at) | {
        "torque_Nm": motor.torque,
        "holding_torque_Nm": motor.holding,
        "load_torque_Nm": motor.load,
        "in_run_up": motor.in_run_up,
        "run_up_torque_Nm": motor.run_up,
        "speed_rpm": view.speeds.rpm(view.speeds.given[-1]),
        "max_torque_Nm": limits.most if math.isfinite(limits.most) else None,
        "max_speed_rpm": limits.fastest / RPM if math.isfinite(limits.fastest) else None,
        "current_A": motor.torque / limits.K_t if math.isfinite(limits.K_t) else None,
    }


def _largest_torque(view: View) -> dict[str, Any]:
    """Largest torque through the gear in a steady motion or the run-up, beside the gear's limits."""
    used = view.analysis.usage
    loads = [load for load, drive in view.analysis.curves if drive.usage.peak_torque == used.peak_torque]
    names = ("repeated_peak_torque", "ratcheting_torque", "momentary_torque")
    of_gear = {f"{name}_Nm": getattr(view.project.gear, name, None) for name in names}
    carried = {"torque_Nm": used.peak_torque, "load_torque_Nm": loads[0] if loads else None}
    return view.speed_data(used.at_peak) | carried | of_gear
