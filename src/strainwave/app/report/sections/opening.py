"""What the report is of, and the key numbers that it begins with."""

import math
from typing import Any

from .... import __version__
from ....law import spring_stiffness
from ....sentences import Speed
from ...console import BETWEEN, number, percent
from ...units import sizes
from ...view import View
from .whole_train import modes, parts

CONVENTIONS = (
    "x = theta_m/N - theta_l [rad, output side], the error between motor and load; the motor's own deviation from its "
    "reference is not in it; peak is the largest |x|, the mean included; amplitudes of single harmonics are 0-to-peak; "
    "omega is the speed of the base angle"
)
LIMIT = ("limit", "value", "bound", "unit", "exceeded")
YIELDS = 1.0 - 1e-9  # the spring alone is softer than the law by more than rounding
OSCILLATES = 0.5  # damping ratio below which a mode of the train is a key number


class Opening:
    """Title, key numbers, and what they are of."""

    heading = ""

    def data(self, view: View) -> dict[str, Any]:
        """Conventions, natural frequencies, the largest error and torque, and the limits of the gear."""
        project, worst = view.project, view.analysis.largest()
        return {
            "strainwave": __version__,
            "title": project.title,
            "project": project.text,
            "motor": project.motor,
            "base_angle": project.speeds.base_angle,
            "conventions": CONVENTIONS,
            "speed_range_rad_per_s": list(view.analysis.speeds),
            "natural_frequencies": natural_frequencies(view),
            "largest_error": view.place(worst.omega) | sizes(worst.peak) | {"method": worst.method, "of": worst.of},
            "largest_torque": _largest_torque(view),
            "limits": [{name: getattr(finding, name) for name in LIMIT} for finding in view.analysis.limits],
        }

    def lines(self, view: View, data: dict[str, Any]) -> list[str]:
        """The key numbers, below each other."""
        return [f"{value:>15}  {what}" for value, what, _ in self.key_numbers(view, data)]

    def about(self, view: View) -> str:
        """What the drive is, in words."""
        if view.analysis.train is not None:
            return parts(view.analysis.train)
        how = "driven by torque" if view.project.motor == "free" else "held at constant speed by a stiff speed loop"
        return f"motor {view.project.motor} ({how})"

    def key_numbers(self, view: View, data: dict[str, Any]) -> list[tuple[str, str, bool]]:
        """Value, meaning, and whether it is beyond a limit."""
        whole, in_run = view.analysis.train_curve is not None, view.analysis.run_alone is not None
        found: list[tuple[str, str, bool]] = []
        if whole:
            text = "mode of the whole drive train that the excitation meets in the range; damping ratio "
            for mode in modes(view):
                if mode["met_in_range"] and mode["damping_ratio"] < OSCILLATES:
                    found.append((f"{number(mode['hertz'], 3)} Hz", text + percent(mode["damping_ratio"], 2), False))
        else:
            small = " of small oscillations, before the law slips" if view.project.has_memory else ""
            for row in data["natural_frequencies"]:
                text = f"natural frequency{small}, motor {row['motor']}{' (used)' if row['used'] else ''}"
                found.append((f"{number(row['hertz'])} Hz", text, False))
        worst, torque = data["largest_error"], data["largest_torque"]
        what = "|x| in a run-up of the whole drive train" if in_run else "steady |x|"
        text = f"largest {what} {BETWEEN}, mean included, at " + Speed(worst["omega_rad_per_s"], digits=5)
        found.append((view.angle.text(worst["peak_rad"]), view.told(text), False))
        where = " in that run-up" if in_run else ", steady or in the run-up" if whole else ""
        size, beyond = torque["torque_Nm"], ""
        for name, end in (
            ("ratcheting", "; the teeth skip, this is no result"),
            ("momentary", ""),
            ("repeated_peak", ""),
        ):
            limit = torque[f"{name}_torque_Nm"]
            if not beyond and limit is not None and size > limit:
                beyond = f": more than the {name.replace('_', ' ')} torque of {number(limit)} N·m{end}"
        kind, at = "" if where else "steady ", Speed(torque["omega_rad_per_s"], digits=5)
        text = f"largest {kind}torque through the gear{where}, at " + at
        return [*found, (f"{number(size)} N·m", view.told(text) + beyond, bool(beyond))]


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


def _largest_torque(view: View) -> dict[str, Any]:
    """Largest torque through the gear in a steady motion, or the run-up in its place, beside the gear's limits."""
    used, gear, ramp = view.analysis.usage, view.project.gear, view.analysis.run_alone
    torque, omega = (used.peak_torque, used.at_peak) if ramp is None else ramp.largest(ramp.run.torque)
    return view.place(omega) | {
        "torque_Nm": torque,
        "repeated_peak_torque_Nm": gear.repeated_peak_torque if gear else None,
        "ratcheting_torque_Nm": gear.ratcheting_torque if gear else None,
        "momentary_torque_Nm": gear.momentary_torque if gear else None,
    }
