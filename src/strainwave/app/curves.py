"""A response curve as sentences, as data and as columns of a file, for commands, reports and the page."""

import cmath
import math
from typing import Any

from ..base.facts import Fact
from ..base.results import Branch, Floats, Status
from ..drive.drive_response import DriveResponse
from ..drive.project import Project
from ..drive.speeds import Speeds
from ..drive.two_turns import A_TURN, beat_said
from .console import number
from .view import AngleUnit, angle_unit, sizes, speed_data

# What the errors are, wherever a command or the report shows one.
WHAT_X_IS = (
    "pointing error = reference angle of the motor/N − angle of the load; error between motor and load: "
    "x = θ_m/N − θ_l; with an ideally held motor both are equal"
)
CONVENTIONS = (
    f"{WHAT_X_IS}; oscillation is the largest distance from the mean, in a run-up from the mean of its turns; peak is "
    "the largest size, the mean included; amplitudes of single harmonics are 0-to-peak; omega is the speed of the base "
    "angle"
)
UNCOVERED = "of the stable motions that are known; at some speeds the drive leaves them, and there"


def ranged(project: Project) -> bool:
    """True if the load has a range of torques."""
    return project.other_loads[0] < project.other_loads[1]


def sizes_said(
    project: Project, motions: DriveResponse, covered: bool, angle: AngleUnit | None = None
) -> tuple[str, ...]:  # fmt: skip
    """The largest oscillation against its limit; none where no motion is stable."""
    top, limit, speeds, against = motions.largest_oscillation(), project.limit, project.speeds, ""
    if top is None:
        return ()
    size = float(motions.oscillation[top])
    angle = angle or angle_unit(size)
    if limit is not None and size <= limit:  # one that is passed is among the failures
        bound, alone = angle_unit(limit).text(limit), " under this load alone" * ranged(project)
        against = f", within the limit of {bound}{alone}"
        if not covered:
            against = f", {UNCOVERED} the limit of {bound} is not known to be met"
    at = f"{number(speeds.own(float(motions.omega[top])), project.digits(5))} {speeds.own_unit}"
    load = f" with {number(project.mean_load_torque)} N·m on the load" * ranged(project)
    return (f"{motions.name}, largest oscillation: {angle.text(size, project.digits())} at {at}{load}{against}",)


def beat_facts(project: Project, found: DriveResponse) -> tuple[Fact, ...]:
    """Period of a beat, and the oscillation in its smallest turn, at the speed of the largest."""
    curve, top = found.curve, found.top
    if curve.envelope is None or curve.beat is None:
        return ()
    period, every = 2.0 * math.pi * curve.beat / float(curve.omega[top]), beat_said(project.whole)[1]
    return (
        Fact("beat.turns", curve.beat), Fact("beat.period_s", period, f"the error {every}, there {{}}"),
        Fact("beat.smallest_arcsec", float(curve.envelope[top, 1]), f"{{}} in the turn where it is smallest; {A_TURN}"),
    )  # fmt: skip


def torques_said(project: Project, judged: Any) -> str:
    """Torques of gear and motor: under a range of loads lower bounds, as vibration under the others is not known."""
    many, motor, digits = ranged(project), judged.motor, project.digits()
    asked = f", motor {number(motor.torque, digits)} N·m" if motor else ""
    text = f"gear {number(judged.used.peak_torque, digits)} N·m{asked}"
    if motor and project.motor == "free" and project.train is None:
        text += " beside the mean that keeps a free motor's speed"
    elif motor and not many:
        text += f" (mean {number(motor.holding, digits)} N·m)"
    return f"{text} or more: vibration is known for this load alone; analyze computes all loads" if many else text


def curve_data(speeds: Speeds, exact: DriveResponse) -> dict[str, Any]:
    """Key numbers of a response curve: folds, jumps, accuracy."""
    curve, sweep = exact.curve, exact.sweep

    def jump(omega: float) -> dict[str, Any] | None:
        return speed_data(speeds, omega) if math.isfinite(omega) else None

    return {
        "method": exact.method,
        "harmonics": curve.coefficients.shape[1] // 2 if curve.waves is None else waves_data(curve, exact.top),
        "left_out_relative": curve.tail,
        "complete": curve.status.found,
        "rough": curve.status is Status.TRUNCATED,
        "message": exact.message,
        "folds": [speed_data(speeds, fold.omega) | sizes(fold.peak) for fold in curve.folds],
        "jump_up": jump(sweep.jump_up if sweep else math.nan),
        "jump_down": jump(sweep.jump_down if sweep else math.nan),
        "bands": [
            {end: jump(getattr(band, end)) for end in ("low", "high", "jump_up", "jump_down")} | {"whole": band.whole}
            for band in (sweep.bands if sweep else ())
        ],
        "hysteresis_rad_per_s": sweep.width if sweep else None,
        "sweep": sweep.sentence if sweep else "no motion on the curve is stable",
    }


def waves_data(curve: Branch, i: int) -> list[dict[str, Any]]:
    """Waves of a motion that beats, the largest first: repeats per turn of motor and output, amplitude and phase."""
    assert curve.waves is not None
    sizes_of, pairs = curve.waves.amplitudes[i], curve.waves.pairs.tolist()
    rows = [
        {"wave_generator": j, "output": k, **sizes(abs(size), "amplitude"), "phase_rad": cmath.phase(size)}
        for (j, k), size in zip(pairs[1:], sizes_of[1:].tolist(), strict=True)
    ]
    return sorted(rows, key=lambda row: -row["amplitude_rad"])


def speed_columns(speeds: Speeds, omega: Floats) -> list[tuple[str, Floats]]:
    """Speed of the base angle, and of the motor where the base angle is its own."""
    named = [("omega_rad_per_s", omega)]
    return [*named, ("motor_speed_rpm", speeds.scale * omega)] if speeds.by_motor else named


def drive_columns(speeds: Speeds, drive: DriveResponse) -> list[tuple[str, Floats]]:
    """Columns of the motions of a drive in arc order; the error is the pointing error, or x without a reference."""
    error = "pointing_error" if drive.has_reference else "x"
    sizes = {
        f"oscillation_of_{error}_rad": drive.oscillation, f"peak_{error}_rad": drive.peak,
        "peak_x_across_gear_rad": drive.across, "peak_torque_in_gear_Nm": drive.torque,
    }  # fmt: skip
    if drive.curve.beat is not None and drive.curve.envelope is not None:
        sizes[f"smallest_oscillation_of_{error}_rad"] = drive.curve.envelope[:, 1]
    sizes_of_motor = {"peak": drive.motor_torque, "rms": drive.motor_rms}
    motor = [(f"{name}_torque_of_motor_Nm", size) for name, size in sizes_of_motor.items() if size is not None]
    return [*curve_columns(speeds, drive.curve, sizes), *motor]


def curve_columns(speeds: Speeds, curve: Branch, sizes: dict[str, Floats]) -> list[tuple[str, Floats]]:
    """Columns of a response curve in arc order: speed, sizes, first harmonics of x, stability."""
    harmonics = range(1, min(9, curve.coefficients.shape[1] // 2) + 1)
    amplitudes = [(f"amplitude_{k}_rad", curve.amplitude(k)) for k in harmonics]
    stable = "stable", curve.stable.astype(float)
    return [*speed_columns(speeds, curve.omega), *sizes.items(), *amplitudes, stable]
