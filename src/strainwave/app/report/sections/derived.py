"""The derived quantities of a drive: name, symbol, value, unit, remark."""

import math
from collections.abc import Iterator
from typing import Any, NamedTuple

from ....base.law import spring_stiffness
from ....base.number_text import percent
from ....base.protocols import terms_of
from ....base.sentences import Angle
from ....drive.train_curve import in_turns
from ....study.speed_map.error_equation import equation_orders
from ...console import number
from ...view import View
from ..section import Part, Table
from .opening import YIELDS
from .whole_train import mode_data

LIMITS = (
    ("Rated torque", "rated_torque", "N·m", "catalogue, output side"),
    ("Repeated peak torque", "repeated_peak_torque", "N·m", "catalogue, output side"),
    ("Momentary peak torque", "momentary_torque", "N·m", "catalogue, output side"),
    ("Largest input speed", "max_rpm", "rpm", "catalogue, with grease"),
    ("Average input speed", "average_rpm", "rpm", "catalogue, with grease"),
)


def derived_quantities(view: View) -> Part:
    """Quantities derived from the data of the drive, and the source of these data."""
    project, gear, rows = view.project, view.project.gear, [one._asdict() for one in quantities(view)]
    drive = {
        "law": repr(project.drive.law),
        "gear": gear.name if gear else None,
        "source": gear.source if gear else None,
        "notes": list(gear.notes) if gear else [],
        "has_memory": project.has_memory,
    }
    data = {"derived": rows, "damping": damping(view), "drive": drive}
    notes = [] if gear is None else [" ".join([f"Gear data: {gear.source}.", *gear.notes])]
    return Part("Derived quantities", data, tables=[Table(rows)], notes=notes, appendix=True)


class Quantity(NamedTuple):
    """A derived quantity: name, symbol, value (None with the reason as remark), unit and remark."""

    name: str
    symbol: str
    value: float | None
    unit: str
    note: str = ""


def quantities(view: View) -> list[Quantity]:
    """List the derived quantities of the drive, for both motor modes where they differ."""
    point = view.analysis.point
    spring = float(spring_stiffness(view.project.drive.law, point.x))
    yields = spring < point.stiffness * YIELDS
    bias = "at x₀ = " + Angle(point.x) + " under the mean torque" if point.mean_torque else "no mean torque"
    bias += "; for small vibrations, before the hysteresis yields" if yields else ""
    rows = [Quantity("Torsional stiffness at the operating point", "T'(x₀)", point.stiffness, "N·m/rad", bias)]
    if yields:
        rows.append(Quantity("Torsional stiffness of the spring alone", "K", spring, "N·m/rad", "hysteresis yielded"))
    for mode in ("free", "held"):
        rows += _of_mode(view, mode, spring, yields)
    return [*rows, *_damping_quantities(damping(view)), *_static(view)]


def _of_mode(view: View, mode: str, spring: float, yields: bool) -> Iterator[Quantity]:
    """Inertia, damping and natural frequency with the motor free or held, on a `spring` whose hysteresis may yield."""
    drive, stiffness = view.project.drive, view.analysis.point.stiffness
    symbol, inertia = ("J", drive.J) if mode == "free" else ("J_l", drive.J_l)
    usage = "used in this report" if view.analysis.train is None else "used in the error equation"
    mark = usage if mode == view.project.motor else "for comparison"
    omega_0, of_spring = math.sqrt(max(stiffness, 0.0) / inertia), math.sqrt(max(spring, 0.0) / inertia)
    yield Quantity(f"Inertia, motor {mode}", symbol, inertia, "kg·m²", mark)
    yield Quantity(f"Damping parameter B/{symbol}, motor {mode}", "μ", drive.B / inertia, "1/s", mark)
    if of_spring > 0.0:
        zeta = drive.B / (2.0 * inertia * of_spring)
        remark = "; from damping B and the spring, without the damping by hysteresis" if yields else ""
        yield Quantity(f"Damping ratio, motor {mode}", "ζ", zeta, "", mark + remark + _at_rest(view, spring, zeta))
    name = f"Natural frequency, motor {mode}"
    if not omega_0 > 0.0:
        yield Quantity(name, "ω₀", None, "rad/s", "no stiffness at the operating point")
        return
    mark += "; for small vibrations, before the hysteresis yields" if yields else ""
    yield Quantity(name, "ω₀", omega_0, "rad/s", mark)
    yield Quantity("", "f₀", omega_0 / (2.0 * math.pi), "Hz", mark)
    yield from _resonance_speeds(view, omega_0, mark)
    if yields:
        alone = f"Natural frequency of the spring alone, motor {mode}"
        yield Quantity(alone, "", of_spring, "rad/s", "hysteresis yielded")


def damping(view: View) -> dict[str, Any]:
    """B, the damping ratio of each mode due to B, and the loss of the hysteresis in a cycle, side by side.

    The loss is given as a damping ratio too: of a spring with the same secant stiffness and the same loss at its
    resonance, W/(4 pi E), E = T a/2 at the amplitude a (Chopra, Dynamics of Structures, 4th ed., eq. 3.9.2).
    """
    drive, loop, study = view.project.drive, view.analysis.loop, view.analysis.train
    stiffness = float(spring_stiffness(drive.law, view.analysis.point.x))
    omegas = {mode: math.sqrt(max(stiffness, 0.0) / J) for mode, J in (("free", drive.J), ("held", drive.J_l))}
    ratios = {mode: drive.B * omega / (2.0 * stiffness) for mode, omega in omegas.items() if omega}
    modes = [{"of": f"error equation, motor {mode}"} | mode_data(omegas[mode], ratios[mode]) for mode in ratios]
    poles = [] if study is None else study.modes
    modes += [{"of": "whole drive train"} | mode_data(abs(p), -p.real / abs(p)) for p in poles]
    loss = None
    if loop is not None:
        alike = loop.full.energy / (math.pi * loop.torque * loop.full.span)
        loss = {"J_per_cycle": loop.full.energy, "at_Nm": loop.torque, "as_damping_ratio": alike}
    return {"B_Nms_per_rad": drive.B, "modes": modes, "hysteresis_loss": loss}


def _damping_quantities(numbers: dict[str, Any]) -> list[Quantity]:
    """B, the modes of the train and the loss of the hysteresis; the modes of the error equation have their own rows."""
    rows = [Quantity("Damping across the spring", "B", numbers["B_Nms_per_rad"], "N·m·s/rad", "output side")]
    for mode in (m for m in numbers["modes"] if m["of"] == "whole drive train"):
        name = f"Damping ratio of the drive mode at {number(mode['hertz'], 3)} Hz"
        rows.append(Quantity(name, "ζ", mode["damping_ratio"], "", "about the operating point, small vibrations"))
    if (loss := numbers["hysteresis_loss"]) is not None:
        begin = f"slow cycle between ±{number(loss['at_Nm'])} N·m; equivalent to a damping ratio of "
        note = begin + percent(loss["as_damping_ratio"], 2)
        rows.append(Quantity("Energy loss of the hysteresis per cycle", "", loss["J_per_cycle"], "J", note))
    return rows


def _at_rest(view: View, stiffness: float, zeta: float) -> str:
    """Say which stiffness the ratio refers to, where there are two."""
    at_zero = float(spring_stiffness(view.project.drive.law, 0.0))
    if not at_zero > 0.0 or abs(stiffness / at_zero - 1.0) < 1e-9:
        return ""
    ratio = percent(zeta * math.sqrt(stiffness / at_zero))
    return f"; at the operating point ({ratio} at standstill without torque, the reference of 'damping: ratio')"


def _resonance_speeds(view: View, omega_0: float, mark: str) -> list[Quantity]:
    orders = equation_orders(view.analysis.system) if view.speeds.by_motor else ()
    rows = ((number(k, 5), omega_0 / k * view.speeds.scale) for k in orders)
    return [Quantity(f"Resonance speed of order {k}, at the motor", f"n{k}", rpm, "rpm", mark) for k, rpm in rows]


def _static(view: View) -> list[Quantity]:
    point, project, gear, (unit, factor) = view.analysis.point, view.project, view.project.gear, view.angle
    rows = [
        Quantity("Mean torque in the error equation", "τ₀", point.mean_torque, "N·m", "output side"),
        Quantity("Static error under the mean torque", "x₀", point.x * factor, unit, "between motor and load"),
    ]
    size = "0-to-peak, output side"
    for term in terms_of(view.analysis.system.excitation) if point.stiffness > 0.0 else ():
        if getattr(term, "amplitude", 0.0):
            static, k = abs(term.amplitude) / point.stiffness * factor, term.order
            rows.append(Quantity(f"Quasi-static error from the torque of order {k}", f"A{k}/T'", static, unit, size))
    for line in () if project.kinematic_error is None else project.kinematic_error.lines:
        order = in_turns(line.order, project.whole)
        name = f"Kinematic error, order {order}"
        rows.append(Quantity(name, f"e{order}", abs(line.amplitude) * factor, unit, size))
    if gear is not None:
        limits = ((f"{name} of {gear.name}", getattr(gear, of), unit, note) for name, of, unit, note in LIMITS)
        rows += [Quantity(name, "", value, unit, note) for name, value, unit, note in limits]
    return rows
