"""Opening of the report: the drive, the verdict, and the key numbers; and warnings to read before using them."""

import math
from typing import Any

from ....base.archive import version
from ....base.facts import data as told_once
from ....base.law import spring_stiffness
from ....base.sentences import Sentence, Speed, counted
from ....base.units import RPM
from ....drive.asked import MotorLimits
from ....files.notes import unsaid
from ....model.drive import HDC_40_050, HDC_40_050_WARNING
from ....model.gears.limits import gravest
from ....plot.svg import stacked
from ....study.analysis.analysis import Analysis, Largest
from ....study.analysis.verdict import Answer
from ....study.analysis.verdict_words import how_sure, ranges
from ....study.analysis.words import equation_alone, named, of_move, place_said, under_load
from ...console import WHAT_X_IS, number, percent
from ...view import View, sizes
from ..remedies import after_change, can_be_ordered
from .speed_range import drive_figure, figure_said
from .whole_train import modes, parts, train_warning

CONVENTIONS = (
    f"{WHAT_X_IS}; oscillation is the largest distance from the mean, in a run-up from the mean of its turns; peak is "
    "the largest size, the mean included; amplitudes of single harmonics are 0-to-peak; omega is the speed of the base "
    "angle"
)
YIELDS = 1.0 - 1e-9  # the spring alone is softer than the law by more than rounding
PAGE = 430.0  # width of the figure beside the remedies [px]
FIRST = 6  # remedies beside the figure
OSCILLATES = 0.5  # damping ratio below which a mode of the train is a key number


class Opening:
    """Title, drive, verdict and key numbers."""

    heading = ""

    def data(self, view: View) -> dict[str, Any]:
        """The verdict, conventions, natural frequencies, the largest error and torque, and the limits of the gear."""
        project, worst = view.project, view.analysis.largest()
        return {
            "strainwave": version(),
            "title": project.title,
            "revision": project.revision,
            "project": project.text,
            "motor": project.motor,
            "base_angle": project.speeds.base_angle,
            "verdict": told_once(view.analysis.facts())["verdict"],
            "conventions": CONVENTIONS,
            "speed_range_rad_per_s": list(view.analysis.speeds),
            "natural_frequencies": natural_frequencies(view),
            "error": view.analysis.drive.name,
            "largest_oscillation": _largest(view, view.analysis.largest_oscillation(), "oscillation"),
            "largest_error": _largest(view, worst, "peak"),
            "largest_torque": _largest_torque(view),
            "required_motor": _required_motor(view),
            "move": None if view.analysis.moved is None else told_once(view.analysis.moved.facts()),
            "loop_margins": None if project.loop is None else project.loop.data(),
            "how_sure": told_once(project.sureness.facts(project.limit))["how_sure"]
            | {
                "sentence": how_sure(view.analysis),
                "ends": [
                    {"damping_Nms_per_rad": end.after, **after_change(view, end), "above_limit": end.exceeds}
                    for end in view.analysis.other_damping
                ],
            },
            "limits": [finding.data() for finding in view.analysis.limits],
        }

    def lines(self, view: View, data: dict[str, Any]) -> list[str]:
        """The verdict, and the key numbers below each other."""
        verdict = data["verdict"]
        texts = [verdict[key] for key in ("headline", "sentence", "what_to_do", "how_sure") if verdict[key]]
        texts += [data["loop_margins"]["weak"]] if data["loop_margins"] and data["loop_margins"]["weak"] else []
        return texts + [f"{value:>15}  {meaning}" for value, meaning, _ in self.key_numbers(view, data)]

    def figures(self, view: View) -> list[str]:
        """Oscillation of the error against speed, with its limit and the speeds to avoid."""
        return [stacked(drive_figure(view)[:1], 250.0, "oscillation of the error against speed", PAGE)]

    def sentences(self, view: View) -> list[str]:
        """Content of the figure."""
        return [said for said in figure_said(view) if said]

    def orders(self, view: View) -> list[tuple[str, str, bool | None]]:
        """What can be ordered or set, the oscillation that it leaves, and whether that is above the limit."""
        remedies = [remedy for remedy in view.analysis.remedies if can_be_ordered(remedy) and remedy.helps]
        sizes_left = (after_change(view, remedy)["oscillation_rad"] for remedy in remedies)
        left = [view.angle.text(size, view.project.digits()) for size in sizes_left]
        rows = [(str(remedy), size, remedy.exceeds) for remedy, size in zip(remedies, left, strict=True)][:FIRST]
        verdict = view.analysis.verdict
        if verdict.answer is Answer.BUT:
            rows.append((str(view.told(Sentence("keep to {}", ranges(verdict.allowed, -1)))), "", None))
        return rows

    def about(self, view: View) -> str:
        """The drive in words."""
        if view.analysis.train is not None:
            return parts(view)
        how = "driven by torque" if view.project.motor == "free" else "held at constant speed by a stiff speed loop"
        return f"motor {view.project.motor} ({how})"

    def key_numbers(self, view: View, data: dict[str, Any]) -> list[tuple[str, str, bool]]:
        """Value, meaning, and whether it is beyond a limit."""
        whole = view.analysis.train_curve is not None
        rows: list[tuple[str, str, bool]] = []
        if whole:
            text = "mode of the whole drive train that the excitation meets in the range; damping ratio "
            for mode in modes(view):
                if mode["met_in_range"] and mode["damping_ratio"] < OSCILLATES:
                    rows.append((f"{number(mode['hertz'], 3)} Hz", text + percent(mode["damping_ratio"], 2), False))
        else:
            small = " of small oscillations, before the law slips" if view.project.has_memory else ""
            for row in data["natural_frequencies"]:
                text = f"natural frequency{small}, motor {row['motor']}{' (used)' if row['used'] else ''}"
                rows.append((f"{number(row['hertz'])} Hz", text, False))
        for name, mean in (("oscillation", ""), ("peak", ", mean included")):
            size = data["largest_error" if mean else "largest_oscillation"]
            run = " in a run-up" if size["of"].startswith("run-up") else equation_alone(view.analysis)
            error = data["error"] if mean else f"oscillation of the {data['error']}"
            speed = Speed(size["omega_rad_per_s"], digits=5) + under_load(size["load_torque_Nm"])
            where = place_said(view.analysis.largest_oscillation()) if "beat_s" in size else speed
            text = f"largest {error}{run}{mean}, at " + where
            rows.append((view.angle.text(size[f"{name}_rad"], view.project.digits()), view.told(text), False))
        study, torque = view.analysis.train, data["largest_torque"]
        condition = " in a steady motion" if study is None or study.ramp is None else ", steady or in the run-up"
        size, excess = torque["torque_Nm"], ""
        for name in ("ratcheting", "momentary", "repeated_peak"):
            limit = torque[f"{name}_torque_Nm"]
            if not excess and limit is not None and size > limit:
                end = "; the teeth skip, this is no result" if name == "ratcheting" else ""
                excess = f": more than the {name.replace('_', ' ')} torque of {number(limit)} N·m{end}"
        text = f"largest torque through the gear{condition}, at " + Speed(torque["omega_rad_per_s"], digits=5)
        text += under_load(torque["load_torque_Nm"])
        rows.append((f"{number(size, view.project.digits())} N·m", view.told(text) + excess, bool(excess)))
        return [*rows, *_motor_numbers(view), *_move_numbers(view)]


def _largest(view: View, largest: Largest, name: str) -> dict[str, Any]:
    """A largest error as data; the torque is that of the load, where the drive has a range of them."""
    origin = {"method": largest.method, "of": largest.of, "load_torque_Nm": largest.torque}
    beat = {} if largest.beat is None else sizes(largest.smallest, "smallest") | {"beat_s": largest.beat}
    return view.place(largest.omega) | sizes(largest.peak, name) | origin | beat


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
    return view.place(motor.at) | {
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


def _motor_numbers(view: View) -> list[tuple[str, str, bool]]:
    """Key numbers of the motor, where they are known."""
    motor, exceeded = view.analysis.motor, {f.limit: f for f in view.analysis.limits if f.fails}
    if motor is None:
        return []

    def excess(name: str) -> str:
        if name not in exceeded:
            return ""
        value, bound, unit, omega = [getattr(exceeded[name], key) for key in ("value", "bound", "unit", "omega")]
        if omega is not None:
            return f"; {number(value - bound)} {unit} short at {number(omega / RPM, 5)} rpm"
        return f": more than its {number(bound)} {unit}"

    run = " in the run-up, its acceleration left out" if motor.in_run_up else ""
    text = f"largest torque that the motor must give{run}, at " + Speed(motor.at, digits=5) + under_load(motor.load)
    meaning = view.told(text) + excess("motor torque").replace("*", "·")
    rows = [(f"{number(motor.torque, view.project.digits())} N·m", meaning, "motor torque" in exceeded)]
    if "motor speed" in exceeded:
        speed = f"{number(exceeded['motor speed'].value, 5)} rpm"
        rows.append((speed, "speed at which the motor must turn" + excess("motor speed"), True))
    return rows


def _move_numbers(view: View) -> list[tuple[str, str, bool]]:
    """Key numbers of the move of the file."""
    moved = view.analysis.moved
    if moved is None:
        return []
    rows = []
    for where, size in (("of the motor", moved.peak_motor_torque), ("through the gear", moved.peak_gear_torque)):
        excess = "".join(f": above {named(one)}" for one in of_move(view.analysis) if one.value == size)
        text = f"largest torque {where} in the move of the file{excess}"
        rows.append((f"{number(size, view.project.digits())} N·m", text, bool(excess)))
    return rows


def _largest_torque(view: View) -> dict[str, Any]:
    """Largest torque through the gear in a steady motion or the run-up, beside the gear's limits."""
    used = view.analysis.usage
    loads = [load for load, drive in view.analysis.curves if drive.usage.peak_torque == used.peak_torque]
    names = ("repeated_peak_torque", "ratcheting_torque", "momentary_torque")
    of_gear = {f"{name}_Nm": getattr(view.project.gear, name, None) for name in names}
    known = {"torque_Nm": used.peak_torque, "load_torque_Nm": loads[0] if loads else None}
    return view.place(used.at_peak) | known | of_gear


class Warnings:
    """Warnings of the analysis, exceeded limits of the gear, and doubts about the file."""

    heading = ""
    template = "warnings.html.j2"

    def data(self, view: View) -> dict[str, Any]:
        """All warnings in sentences."""
        return {"warnings": warnings(view)}

    def lines(self, _: View, data: dict[str, Any]) -> list[str]:
        """Their number."""
        count = len(data["warnings"])
        return [f"{counted(count, 'warning')} in the report"] if count else []


def warnings(view: View) -> list[str]:
    """Sentences to read before using the numbers, the gravest first."""
    project, analysis = view.project, view.analysis
    sentences = [*train_warning(view), *_overload(analysis)]
    article = (HDC_40_050.law, HDC_40_050.J_m, HDC_40_050.J_l)
    if (project.drive.law, project.drive.J_m, project.drive.J_l) == article:
        sentences.append(HDC_40_050_WARNING)
    sentences += [project.loop.weak] if project.loop and project.loop.weak else []
    sentences += analysis.warnings
    sweep = analysis.drive.sweep
    for band in () if sweep is None else sweep.bands:
        text = (
            "Run-up and run-down differ between {}: two stable motions exist there, and which one the drive is on "
            "depends on its history; pass through that band quickly or keep out of it."
        )
        remark = "" if band.whole else " A jump between them lies outside the speed range; take a wider one to see it."
        sentences.append(Sentence(text, Speed(band.low, band.high, digits=5)) + remark)
    for jump in () if sweep is None else sweep.alone:
        text = (
            "The response jumps at {}, and in the other direction its stable motions end before that speed: the curve "
            "does not show what follows there; integrate to see it."
        )
        sentences.append(Sentence(text, Speed(jump.value, digits=5)))
    return [*sentences, *unsaid(project.notes, sentences)]


def _overload(analysis: Analysis) -> list[str]:
    """Sentences on exceeded limits of the gear's datasheet."""
    used, sentences = analysis.usage, list[str]()
    for finding in sorted(gravest(analysis.limits), key=lambda f: f.value != used.peak_torque):  # that one breaks gears
        speed = {used.peak_torque: used.at_peak, used.average_torque: used.at_average}.get(finding.value)
        begin = "" if speed is None else "At " + Speed(speed, digits=5) + ": "
        sentences.append(begin + finding.sentence.replace("N*m", "N·m"))
    return sentences
