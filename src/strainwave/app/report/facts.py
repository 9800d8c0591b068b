"""The derived quantities of a drive as rows of the report: name, symbol, value, unit, remark."""

import math
from typing import Any, NamedTuple

from ...files.project import Project
from ...law import spring_stiffness
from ...protocols import terms_of
from ...sentences import Angle, Sentence
from ...study.analysis.analysis import Analysis
from ...study.response.resonances import active_orders
from ..console import BETWEEN, number
from ..units import AngleUnit

YIELDS = 1.0 - 1e-9  # the spring alone is softer than the law by more than rounding


class Fact(NamedTuple):
    """One row: what it is, its symbol, its value (None with a remark that says why), unit and remark."""

    name: str
    symbol: str
    value: float | None
    unit: str
    note: str = ""


def facts(project: Project, analysis: Analysis, angle: AngleUnit) -> list[Fact]:
    """List what follows from the data of the drive, for both motor modes where they differ."""
    drive, point = project.drive, analysis.point
    used, spring = project.motor, float(spring_stiffness(drive.law, point.x))
    yields = spring < point.stiffness * YIELDS
    bias = _bias(analysis) + ("; of small vibrations, before the hysteresis yields" if yields else "")
    rows = [Fact("Torsional stiffness at the operating point", "T'(x₀)", point.stiffness, "N·m/rad", bias)]
    if yields:
        rows.append(Fact("Torsional stiffness of the spring alone", "K", spring, "N·m/rad", "after it has yielded"))
    for mode, inertia in (("free", drive.J), ("held", drive.J_l)):
        mark = "used in this report" if mode == used else "for comparison"
        symbol = "J" if mode == "free" else "J_l"
        omega_0, of_spring = (math.sqrt(max(K, 0.0) / inertia) for K in (point.stiffness, spring))
        rows.append(Fact(f"Inertia, motor {mode}", symbol, inertia, "kg·m²", mark))
        rows.append(Fact(f"Damping parameter B/{symbol}, motor {mode}", "μ", drive.B / inertia, "1/s", mark))
        if of_spring > 0.0:
            zeta = drive.B / (2.0 * inertia * of_spring)
            more = "; of the damping B and the spring, hysteresis damps too" if yields else ""
            note = mark + more + _at_rest(project, spring, zeta)
            rows.append(Fact(f"Damping ratio, motor {mode}", "ζ", zeta, "", note))
        if omega_0 > 0.0:
            if yields:
                mark += "; of small vibrations, before the hysteresis yields"
            rows.append(Fact(f"Natural frequency, motor {mode}", "ω₀", omega_0, "rad/s", mark))
            rows.append(Fact("", "f₀", omega_0 / (2.0 * math.pi), "Hz", mark))
            rows += _resonance_speeds(project, analysis, omega_0, mark)
            if yields:
                name, note = f"Natural frequency of the spring alone, motor {mode}", "after it has yielded"
                rows.append(Fact(name, "", of_spring, "rad/s", note))
        else:
            rows.append(
                Fact(f"Natural frequency, motor {mode}", "ω₀", None, "rad/s", "no stiffness at the operating point")
            )
    return rows + _static(project, analysis, angle)


def natural_frequencies(project: Project, analysis: Analysis) -> list[dict[str, Any]]:
    """Natural frequencies [rad/s] at the operating point in both motor modes, where there are any.

    `spring_rad_per_s` is that of the spring alone, after the hysteresis has yielded; None without hysteresis.
    """
    point, spring = analysis.point, float(spring_stiffness(project.drive.law, analysis.point.x))
    yields = spring < point.stiffness * YIELDS
    return [
        {
            "motor": mode,
            "omega_rad_per_s": math.sqrt(point.stiffness / inertia),
            "hertz": math.sqrt(point.stiffness / inertia) / (2.0 * math.pi),
            "spring_rad_per_s": math.sqrt(max(spring, 0.0) / inertia) if yields else None,
            "used": mode == project.motor,
        }
        for mode, inertia in (("free", project.drive.J), ("held", project.drive.J_l))
        if point.stiffness > 0.0
    ]


def _at_rest(project: Project, stiffness: float, zeta: float) -> str:
    """Say which stiffness the ratio refers to, where there are two."""
    rest = float(spring_stiffness(project.drive.law, 0.0))
    if not rest > 0.0 or abs(stiffness / rest - 1.0) < 1e-9:
        return ""
    ratio = number(100.0 * zeta * math.sqrt(stiffness / rest))
    return f"; at the operating point ({ratio} % at rest without torque, where 'damping: ratio' belongs)"


def _bias(analysis: Analysis) -> str:
    point = analysis.point
    if point.mean_torque == 0.0:
        return "no mean torque"
    return Sentence("at x₀ = {} under the mean torque", Angle(point.x))


def _resonance_speeds(project: Project, analysis: Analysis, omega_0: float, mark: str) -> list[Fact]:
    if not project.speeds.by_motor:
        return []
    orders = active_orders(analysis.system)
    return [
        Fact(f"Resonance speed of order {k}, at the motor", f"n{k}", omega_0 / k * project.speeds.scale, "rpm", mark)
        for k in orders
    ]


def _static(project: Project, analysis: Analysis, angle: AngleUnit) -> list[Fact]:
    point, system = analysis.point, analysis.system
    rows = [
        Fact("Mean torque on the error equation", "τ₀", point.mean_torque, "N·m", "output side"),
        Fact("Static error under the mean torque", "x₀", point.x * angle.factor, angle.name, BETWEEN),
    ]
    if point.stiffness > 0.0:
        terms = terms_of(system.excitation)
        for term in terms:
            if getattr(term, "amplitude", 0.0):
                static = abs(term.amplitude) / point.stiffness * angle.factor
                name = f"Quasi-static error of the torque of order {term.order}"
                rows.append(Fact(name, f"A{term.order}/T'", static, angle.name, "0-to-peak, output side"))
    if project.kinematic_error is not None:
        for line in project.kinematic_error.lines:
            name = f"Kinematic error of order {line.order}"
            size = abs(line.amplitude) * angle.factor
            rows.append(Fact(name, f"e{line.order}", size, angle.name, "0-to-peak, output side"))
    gear = project.gear
    if gear is not None:
        for name, value, unit in (
            ("Rated torque", gear.rated_torque, "N·m"),
            ("Repeated peak torque", gear.repeated_peak_torque, "N·m"),
            ("Momentary peak torque", gear.momentary_torque, "N·m"),
            ("Largest input speed", gear.max_rpm, "rpm"),
            ("Average input speed", gear.average_rpm, "rpm"),
        ):
            rows.append(
                Fact(
                    f"{name} of the {gear.name}",
                    "",
                    value,
                    unit,
                    "catalogue, output side" if unit == "N·m" else "catalogue, with grease",
                )
            )
    return rows
