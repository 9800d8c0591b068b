"""A response curve as data and as columns of a file, for commands and reports."""

import cmath
import math
from typing import Any

from ..base.results import Branch, Floats, Status
from ..base.units import Speeds
from ..drive.drive_response import DriveResponse
from .console import WHAT_X_IS
from .view import sizes, speed_data

CONVENTIONS = (
    f"{WHAT_X_IS}; oscillation is the largest distance from the mean, in a run-up from the mean of its turns; peak is "
    "the largest size, the mean included; amplitudes of single harmonics are 0-to-peak; omega is the speed of the base "
    "angle"
)


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
    return [
        *speed_columns(speeds, curve.omega), *sizes.items(), *amplitudes, ("stable", curve.stable.astype(float)),
    ]  # fmt: skip
