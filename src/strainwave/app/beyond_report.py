"""The report's sections on hysteresis, a varying stiffness and the whole drive train: plain data, and figures."""

from typing import Any, Literal

import numpy as np

from ..model.shafts import Elastic
from ..study.analysis import Analysis
from ..study.beyond import GearLoop
from ..study.drive_runs import INPUTS
from ..study.parametric import ParametricResonance
from ..study.time_case import Cycle
from ..study.train_study import TrainStudy
from .facts import ARCSEC, RPM, AngleUnit
from .plots import BLACK, BLUE, DASHES, GREY, ORANGE
from .project import Project
from .svg import Curve, Panel, figure

BINS, CYCLE = 240, 100  # pieces of a run-up, at most, and samples in which every speed of it has a whole cycle
APART = 0.1  # relative difference of train and error equation that is warned of


def beyond_data(project: Project, analysis: Analysis) -> dict[str, Any]:
    """Every number of these sections with its unit; None stands for a section that the drive does not have."""
    found = analysis.beyond
    return {
        "hysteresis": None if found.loop is None else _loop_data(found.loop),
        "parametric_resonances": [_parametric(project, r) for r in found.parametric],
        "stiffness_varies": project.stiffness is not None,
        "train": None if found.train is None else _train_data(found.train),
        "remarks": list(found.remarks),
    }


def _loop_data(loop: GearLoop) -> dict[str, Any]:
    return {
        "full_load_Nm": loop.torque,
        "full_load_is_rated": loop.rated,
        "hysteresis_loss_rad": loop.full.loss,
        "hysteresis_loss_arcsec": loop.full.loss * ARCSEC,
        "torsion_from_end_to_end_rad": loop.full.span,
        "dissipated_J_per_cycle": loop.full.energy,
        "lost_motion_rad": loop.small.span,
        "lost_motion_arcsec": loop.small.span * ARCSEC,
    }


def _parametric(project: Project, r: ParametricResonance) -> dict[str, Any]:
    rpm = None if project.shaft == "forcing" else RPM
    return {
        "omega_rad_per_s": r.omega,
        "motor_speed_rpm": r.omega * rpm if rpm else None,
        "cause": r.cause.replace("omega_0", "ω₀"),
        "growth_per_s": r.growth,
        "unstable": r.unstable,
        "low_rad_per_s": r.low,
        "high_rad_per_s": r.high,
        "low_rpm": r.low * rpm if rpm else None,
        "high_rpm": r.high * rpm if rpm else None,
        "damping_ratio": r.damping_ratio,
        "damping_needed": r.damping_needed,
    }


def _train_data(study: TrainStudy) -> dict[str, Any]:
    control = study.train.motor.control
    damped = [p for p in study.bode.poles if p.imag > 1e-6 * abs(p)]
    return {
        "control": type(control).__name__,
        "gains": control._asdict(),
        "modes": [
            {"omega_rad_per_s": abs(p), "hertz": abs(p) / (2.0 * np.pi), "damping_ratio": -p.real / abs(p)}
            for p in sorted(damped, key=abs)
        ],
        "stable_about_standstill": bool(np.all(study.bode.poles.real < 1e-9 * np.max(np.abs(study.bode.poles)))),
        "steady": [
            {"omega_rad_per_s": w, "motor_speed_rpm": w * RPM, "peak_train_rad": a, "peak_equation_rad": b}
            for w, a, b in zip(study.omega, study.whole, study.reduced, strict=True)
        ],
        "run_up": None if study.run is None else _run_data(study),
        "remarks": list(study.remarks),
    }


def _run_data(study: TrainStudy) -> dict[str, Any]:
    run = study.run
    assert run is not None
    after = run.trajectory.t >= study.begin
    at = int(np.argmax(np.abs(run.error) * after))
    names = list(run.work)
    heat = run.lost(study.begin) if run.trajectory.status else {}
    return {
        "seconds": float(run.trajectory.t[-1]) - study.begin,
        "status": run.trajectory.message,
        "largest_error_rad": float(abs(run.error[at])),
        "largest_error_arcsec": float(abs(run.error[at])) * ARCSEC,
        "at_rpm": float(run.motor_speed[at]) * RPM,
        "largest_torque_Nm": float(np.max(np.abs(run.torque[after]))),
        "heat_J": heat,
        "put_in_J": {name: float(run.work[name][-1]) for name in names[:INPUTS]},
        "imbalance": run.imbalance,
        "warnings": list(run.warnings),
    }


def train_warning(analysis: Analysis, angle: AngleUnit) -> list[str]:
    """Say where the whole train and the error equation of the report are far apart; a free motor has a sentence."""
    study = analysis.beyond.train
    if study is None or study.left_out is not None:
        return []
    if not np.any(np.isfinite(study.whole)):
        return [
            "This report is about the error equation with an ideally held motor and a rigid load; the loop, friction, "
            "gravity and coupling of the file are in the section of the whole drive train alone."
        ]
    apart = np.nan_to_num(np.abs(np.log(study.reduced / study.whole)))
    at = int(np.argmax(apart))
    if apart[at] < np.log1p(APART):
        return []
    loudest = int(np.nanargmax(study.whole))
    more = ", with the twist of the coupling on top" if isinstance(study.train.load, Elastic) else ""
    return [
        "This report is about the error equation with an ideally held motor and a rigid load; the whole drive train "
        f"of the file has at {study.omega[at] * RPM:.4g} rpm {angle.text(float(study.whole[at]))} across the gear in "
        f"place of {angle.text(float(study.reduced[at]))}{more}. Of the speeds computed its largest is "
        f"{angle.text(float(study.whole[loudest]))} at {study.omega[loudest] * RPM:.4g} rpm: see its section."
    ]


def beyond_figures(analysis: Analysis, angle: AngleUnit) -> dict[str, str]:
    """Figures of the sections that there are, as SVG: "loop", "bode" and "run"."""
    found, out = analysis.beyond, {}
    cycles = [case.cycle for case in analysis.cases if case.cycle is not None]
    if found.loop is not None:
        out["loop"] = _loop_figure(found.loop, max(cycles, key=lambda c: c.peak) if cycles else None, angle)
    if found.train is not None:
        out["bode"] = _bode_figure(found.train)
        if found.train.run is not None:
            out["run"] = _run_figure(found.train, angle)
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


def _bode_figure(study: TrainStudy) -> str:
    plot = study.bode
    hertz = plot.omega / (2.0 * np.pi)
    ends = float(hertz[0]), float(hertz[-1])
    size = Panel("", "frequency (Hz)", "speed per torque\n(dB re 1 rad/(N·m·s))", xlim=ends, xlog=True)
    phase = Panel("", "frequency (Hz)", "phase (deg)", xlim=ends, xlog=True)
    lines: tuple[tuple[Literal["motor", "load"], str, str], ...] = (("motor", BLUE, ""), ("load", ORANGE, DASHES))
    for shaft, colour, dash in lines:
        if shaft == "motor" and not np.any(plot.motor):
            continue
        size.line(hertz, plot.decibels(shaft), colour, f"{shaft} speed", dash)
        phase.line(hertz, plot.degrees(shaft), colour, f"{shaft} speed", dash)
    return figure([[size, phase]], 290.0, "Bode plot")


def _run_figure(study: TrainStudy, angle: AngleUnit) -> str:
    run = study.run
    assert run is not None
    keep = run.trajectory.t >= study.begin
    speed, error = run.motor_speed[keep] * RPM, run.error[keep] * angle.factor
    panel = Panel("", "motor speed (rpm)", f"x at the load\n({angle.name})")
    starts = np.linspace(0, len(speed), min(BINS, max(2, len(speed) // CYCLE)), endpoint=False).astype(int)
    low, high = np.minimum.reduceat(error, starts), np.maximum.reduceat(error, starts)
    at = np.add.reduceat(speed, starts) / np.diff([*starts, len(speed)])
    panel.curves.append(Curve(at, low, BLUE, "run-up of the whole train (band of its cycles)", upper=high))
    for values, colour, name, marker in (
        (study.whole, BLACK, "train, steady, largest |x| of the gear", "o"),
        (study.reduced, GREY, "error equation, steady, largest |x|", "^"),
    ):
        good = np.isfinite(values)
        if np.any(good):
            panel.points(study.omega[good] * RPM, values[good] * angle.factor, colour, name, marker, "#ffffff")
    return figure([[panel]], 300.0, "run-up of the drive train")
