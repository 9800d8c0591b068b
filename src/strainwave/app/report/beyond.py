"""The report's sections on hysteresis, a varying stiffness and the whole drive train: plain data, and figures."""

from typing import Any

from ...files.project import Project
from ...speeds import Speeds
from ...study.analysis.analysis import Analysis
from ...study.analysis.beyond import GearLoop
from ...study.analysis.time_case import Cycle
from ...study.gear.parametric import ParametricResonance
from ...units import ARCSEC
from ..figures.plots import BLACK, BLUE, ORANGE
from ..figures.svg import Panel, figure
from ..units import AngleUnit
from .train import train_data, train_figures


def beyond_data(project: Project, analysis: Analysis) -> dict[str, Any]:
    """Every number of these sections with its unit; None stands for a section that the drive does not have."""
    found = analysis.beyond
    return {
        "hysteresis": None if found.loop is None else _loop_data(found.loop),
        "parametric_resonances": [_parametric(project.speeds, r) for r in found.parametric],
        "stiffness_varies": project.stiffness is not None,
        "train": None if found.train is None else train_data(analysis, found.train),
        "remarks": list(found.remarks),
    }


def _loop_data(loop: GearLoop) -> dict[str, Any]:
    return {
        "full_load_Nm": loop.torque,
        "full_load_is_rated": loop.rated,
        "hysteresis_loss_rad": loop.full.loss,
        "hysteresis_loss_arcsec": loop.full.loss / ARCSEC,
        "torsion_from_end_to_end_rad": loop.full.span,
        "dissipated_J_per_cycle": loop.full.energy,
        "lost_motion_rad": loop.small.span,
        "lost_motion_arcsec": loop.small.span / ARCSEC,
    }


def _parametric(speeds: Speeds, r: ParametricResonance) -> dict[str, Any]:
    return {
        "omega_rad_per_s": r.omega,
        "motor_speed_rpm": speeds.rpm(r.omega),
        "cause": r.cause.replace("omega_0", "ω₀"),
        "growth_per_s": r.growth,
        "unstable": r.unstable,
        "low_rad_per_s": r.low,
        "high_rad_per_s": r.high,
        "low_rpm": speeds.rpm(r.low),
        "high_rpm": speeds.rpm(r.high),
        "damping_ratio": r.damping_ratio,
        "damping_needed": r.damping_needed,
    }


def beyond_figures(analysis: Analysis, angle: AngleUnit) -> dict[str, str]:
    """Figures of the sections that there are, as SVG: "loop", "bode" and "run"."""
    found, out = analysis.beyond, dict[str, str]()
    cycles = [case.cycle for case in analysis.cases if case.cycle is not None]
    if found.loop is not None:
        out["loop"] = _loop_figure(found.loop, max(cycles, key=lambda c: c.peak) if cycles else None, angle)
    if found.train is not None:
        out |= train_figures(analysis, found.train, angle)
    return out


def _loop_figure(loop: GearLoop, cycle: Cycle | None, angle: AngleUnit) -> str:
    left = Panel("input locked, torque slowly 0, +T, −T, +T", f"torsion ({angle.name})", "torque (N·m)")
    left.line(loop.full.torsion * angle.factor, loop.full.torque, BLUE, "full load")
    left.line(loop.small.torsion * angle.factor, loop.small.torque, ORANGE, "4 % of full load", width=2.2)
    if cycle is None:
        return figure([[left]], 300.0, "hysteresis loop")
    right = Panel("steady motion, largest |x| of the cases", f"torsion ({angle.name})", "torque in the gear (N·m)")
    right.line(cycle.u * angle.factor, cycle.torque, BLACK, "steady motion, damping included", width=1.3)
    return figure([[left, right]], 300.0, "hysteresis loop")
