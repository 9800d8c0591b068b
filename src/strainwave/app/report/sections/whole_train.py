"""The whole drive train beside its error equation: gains, modes, Bode plot, and its run-up."""

from typing import Any

import numpy as np

from ....base.number_text import unit_text
from ....base.quantities import parameters
from ....base.sentences import Angle, Sentence, Speed
from ....base.units import RPM
from ....drive.drive_response import DriveResponse
from ....drive.motor_words import motor_name
from ....drive.run import INPUTS
from ....drive.train_curve import follows_its_angle
from ....model.excitation import NoError
from ....model.laws.friction import NO_FRICTION
from ....model.train.shafts import NO_DRAG
from ....plot.loop import loop_rows
from ....plot.panels import BLACK, BLUE, DASHES, MOTOR, ORANGE, Panel
from ....plot.svg import figure
from ....study.analysis.train_study import TrainStudy
from ....study.analysis.words import load_text
from ....study.speed_map.error_equation import equation_orders
from ....study.speed_map.ramp import Ramp, turns
from ...console import number
from ...curves import curve_data
from ...view import View, sizes
from ..section import Part, Table
from .resonances import jump_speeds
from .single_speeds import envelope
from .variants import motor_in_words

MARGINS = " Gain margin of 6 dB: the loop is unstable when its gain rises by 6 dB; of −6 dB: when it falls by 6 dB."
STEPS = " Step responses: speeds after a step of the speed reference, angles after a step of the load torque."
RESPONSE = "Linear frequency response of the speeds to a torque on the"


def whole_train(view: View) -> Part:
    """Operating point, modes, steady motions and run-up; None where the error equation is all there is."""
    study, reduced = view.analysis.train, reduction(view)
    if study is None:
        return Part(data={"train": None, "reduction": reduced})
    data = train_data(view, study)
    point, control = data["operating_point"], study.train.motor.control
    gains = ", ".join(
        f"{p.path.removeprefix('loop.')} = {number(p.value)} {unit_text(p.unit)}" for p in parameters(control)
    )
    angle = "" if point["load_angle_rad"] is None else f", at a load angle of {number(point['load_angle_rad'])}"
    made, torque = data["parts"], number(point["torque_in_gear_Nm"])
    text = (
        f"{made[:1].upper()}{made[1:]}. {gains and f'Motor control: {gains}. '}Operating point{angle}: "
        f"{number(point['motor_speed_rpm'])} rpm, mean torque in the gear {torque} N·m. Linearised about this point "
        f"the drive train is {'stable' if data['stable'] else 'NOT stable'}. The table lists the modes, and for each "
        "order of the excitation the speed in rpm at which it excites the mode:"
    )
    table = Table(data["modes"], "hertz damping_ratio met_at_rpm")
    both = {"train": data, "reduction": reduced}
    return Part("The whole drive train", both, [text], [table], study.remarks, [_linear(view, study)], lines=[])


def _linear(view: View, study: TrainStudy) -> tuple[str, str]:
    """Figure of the motor's loop, or of a motor without one, and its caption."""
    if loop := view.project.loop:
        text = f"The motor's loop, {loop.caption}.{MARGINS}{STEPS * loop.stable}"
        return figure(loop_rows(loop), 170.0, "Bode plot and steps of the motor's loop"), text
    on = "load, with the motor held" if study.train.motor.held else "motor"
    return figure([study.bode.panels()], 290.0, "Bode plot"), f"{RESPONSE} {on}, about the operating point."


def run_up_of_train(view: View) -> Part:
    """Steady motions and run-up of the train; its numbers are those of `whole_train`."""
    study, reduced = view.analysis.train, reduction(view) or {"sentence": ""}
    if study is None:
        return Part()
    which = f"Largest |{view.analysis.drive.name}|, mean included, during a slow run-up. " + reduced["sentence"]
    notes = ["Largest |x| across the gear." if study.curve is None else which] if len(study.omega) else []
    drawn = [] if study.ramp is None else [_run_figure(view, study, study.ramp)]
    return Part(
        "The drive train at steady speeds and in a run-up", tables=[Table(train_data(view, study)["steady"])],
        notes=notes, figures=drawn, appendix=True,
    )  # fmt: skip


def _run_sentence(ramp: Ramp) -> Sentence:
    run = _run_data(ramp)
    lost = sorted(((J, name) for name, J in run["heat_J"].items() if J), reverse=True)
    heat = ", ".join(f"{number(J, 3)} J ({name})" for J, name in lost)
    sentence = Sentence(
        "Run-up through the speed range in {} s, after {} s at the lowest speed: largest |pointing error| {} at {} "
        "rpm, largest gear torque {} N·m; heat: {}; relative error of the energy balance {}.",
        number(run["seconds"], 3), number(run["held_before_s"], 3), Angle(run["largest_pointing_error_rad"]),
        number(run["at_rpm"], 5), number(run["largest_torque_Nm"]), heat, number(run["imbalance"], 1),
    )  # fmt: skip
    return Sentence(" ").join([sentence, *run["warnings"]])


def train_data(view: View, study: TrainStudy) -> dict[str, Any]:
    """Parts of a train, its operating point, its modes, its steady motions and its run-up."""
    control = study.train.motor.control
    state = tuple(study.state.tolist())
    return {
        "parts": parts(view),
        "control": type(control).__name__,
        "gains": {p.path: p.value for p in parameters(control)},
        "operating_point": {
            "motor_speed_rpm": study.speed / RPM,
            "torsion_rad": state[0],
            "torque_in_gear_Nm": float(study.train._replace(error=NoError()).torque(0.0, state)),
            "load_angle_rad": 0.0 if follows_its_angle(study.train) else None,
        },
        "modes": modes(view),
        "stable": bool(np.all(study.bode.poles.real < 1e-9 * np.max(np.abs(study.bode.poles)))),
        "steady": [
            {"omega_rad_per_s": w, "motor_speed_rpm": w / RPM, "peak_train_rad": a, "peak_equation_rad": b}
            for w, a, b in zip(study.omega, study.whole, study.reduced, strict=True)
        ],
        "curve": None if study.curve is None else _curve_data(view, study.curve),
        "run_up": None if study.ramp is None else _run_data(study.ramp),
        "gravity_exactly": (top := study.gravity) and view.speed_data(top[0]) | sizes(top[1], "oscillation"),
        "remarks": list(study.remarks),
    }


def modes(view: View) -> list[dict[str, Any]]:
    """Modes of the train about its operating point, and the speeds at which the excitation meets them."""
    orders, (low, high), study = equation_orders(view.analysis.system), view.analysis.speeds, view.analysis.train
    return [
        mode_data(abs(p), -p.real / abs(p))
        | {
            "met_at_rpm": {f"{k:.6g}": abs(p) / k / RPM for k in orders},
            "met_in_range": any(low <= abs(p) / k <= high for k in orders),
        }
        for p in ([] if study is None else study.modes)
    ]


def mode_data(omega: float, ratio: float) -> dict[str, Any]:
    """A mode [rad/s] and its damping ratio as data."""
    return {"omega_rad_per_s": omega, "hertz": omega / (2.0 * np.pi), "damping_ratio": ratio}


def parts(view: View) -> str:
    """Parts of the train of a project, in words."""
    train: Any = view.project.train
    couplings = len(train.load.couplings())
    shafts = (("motor", train.motor), ("load", train.load.end()))
    drags = [name for name, shaft in shafts if shaft.drag != NO_DRAG]
    behind = "a load behind " + ("a coupling" if couplings == 1 else f"{couplings} couplings in series")
    motor = motor_in_words(motor_name(train.motor.control, view.project.loop_inertia))
    friction = ["load-proportional friction of the gear"] if train.friction != NO_FRICTION else []
    friction += [f"friction or gravity on the {' and the '.join(drags)}"] if drags else []
    return ", ".join([motor, *([behind] if couplings else []), *friction])


def _curve_data(view: View, curve: DriveResponse) -> dict[str, Any]:
    top, facts = curve.largest(), curve_data(view.speeds, curve)
    return {key: facts[key] for key in ("harmonics", "left_out_relative", "complete", "rough", "message")} | {
        "without_gravity": curve.without_angle,
        "all_stable": bool(np.all(curve.stable)),
        "largest_across_gear_rad": curve.gear_peak,
        "at_rpm": None if top is None else float(curve.omega[top]) / RPM,
        "jumps": [{"omega_rad_per_s": w, "motor_speed_rpm": w / RPM} for w in jump_speeds(curve)],
    }


def _run_data(ramp: Ramp) -> dict[str, Any]:
    """Key numbers of the run-up after it has settled at the lowest speed."""
    run, begin = ramp
    (pointing, omega), (torque, strained) = ramp.largest(run.pointing), ramp.largest(run.torque)
    return {
        "seconds": float(run.trajectory.t[-1]) - begin,
        "held_before_s": begin,
        "status": run.trajectory.message,
        "complete": bool(run.trajectory.status),
        **sizes(pointing, "largest_pointing_error"),
        **sizes(ramp.largest(run.error)[0], "largest_between_motor_and_load"),
        "at_rpm": omega / RPM,
        "largest_torque_Nm": torque,
        "largest_torque_at_rpm": strained / RPM,
        "heat_J": run.lost(begin) if run.trajectory.status else {},
        "put_in_J": {name: float(run.work[name][-1]) for name in list(run.work)[:INPUTS]},
        "imbalance": run.imbalance,
        "warnings": list(run.warnings),
    }


def reduction(view: View) -> dict[str, Any] | None:
    """Comparison of the error equation with the train of the drive; None without a curve of that.

    The oscillations are compared: the mean holds the wind-up of a loop, which that equation has not.
    """
    curve, exact = view.analysis.train_curve, view.analysis.exact
    top, top_reduced = None if curve is None else curve.largest_oscillation(), exact.largest_oscillation()
    if curve is None or top is None or top_reduced is None:
        return None
    motor = "a free motor" if view.project.motor == "free" else "an ideally held motor"
    load = load_text(view.project.mean_load_torque if view.analysis.load_cases else None)
    full, reduced = float(curve.oscillation[top]), float(exact.oscillation[top_reduced])
    fast, slow = float(curve.omega[top]), float(exact.omega[top_reduced])
    return {
        **sizes(reduced, "oscillation"),
        **view.speed_data(slow),
        "oscillation_relative_to_train": reduced / full,
        "speed_relative_to_train": slow / fast,
        "sentence": Sentence(
            f"For comparison, with {motor} and a rigid load (error equation) the oscillation{load} would reach {{}} at "
            f"{{}}: {_times(reduced / full, 'equal to the value', ' the value')} of the whole drive train, at "
            f"{_times(slow / fast, 'the same speed', ' the speed')}.",
            Angle(reduced),
            Speed(slow, digits=5),
        ),
    }


def about_appendix(view: View) -> str:
    """Sentences on an appendix that is not about the whole drive, and its distance from that; empty otherwise."""
    if view.analysis.train is None:
        return ""
    text, compared = (
        "Resonances, motions at single speeds and stability are computed with the error equation.",
        reduction(view),
    )
    return f"{text} {view.rendered(compared['sentence'])}" if compared else text


def _times(ratio: float, same: str, of: str) -> str:
    return same if (times := number(ratio, 3)) == "1" else f"{times} times{of}"


def _run_figure(view: View, study: TrainStudy, ramp: Ramp) -> tuple[str, Sentence]:
    run = ramp.run
    keep = run.trajectory.t >= ramp.begin
    speed = run.motor_speed[keep]
    panel = Panel("", MOTOR, view.angle.axis("pointing error"))
    low, high, middles = envelope(speed, run.pointing[keep], turns(run.trajectory.t[keep], speed))
    panel.band(middles, low, high, BLUE, "run-up of the whole drive (range within each turn)")
    curves = [(view.analysis.exact, ORANGE, "error equation, steady, largest |error|", DASHES)]
    if study.curve is not None:
        name = "whole drive, steady, largest |error|" + (" without gravity" if study.curve.without_angle else "")
        curves.insert(0, (study.curve, BLACK, name, ""))
    for response, colour, name, dash in curves:
        if response.sweep is not None:
            path = response.sweep.run_up
            panel.line(response.curve.omega[path], response.curve.peak[path], colour, name, dash, 1.3)
    return figure([[panel]], 300.0, "run-up of the drive train"), _run_sentence(ramp)
