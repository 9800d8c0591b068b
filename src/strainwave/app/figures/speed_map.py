"""Figures of a speed map: forbidden bands over the loads, the largest oscillation, and the bent Campbell diagram."""

import numpy as np

from ...base.results import Floats
from ...base.units import RPM
from ...study.speed_map.result import SpeedMap
from ..console import number
from ..view import angle_unit
from .svg import Note, Panel

WIDTH, HEIGHT = 430.0, 260.0  # narrow, so that its text is read on a telephone too
BAND, WORST, LIMIT = "#8c2d04", "#222222", "#D55E00"
LOADS = ("#0072B2", "#009E73", "#CC79A7")
DASHES = ("", "7 3", "2 3")  # of the loads shown: told apart without colour, too
BAR = 0.42  # of the distance between loads


def shown_loads(found: SpeedMap) -> list[int]:
    """Numbers of the loads that figures show: the first, the middle one and the last."""
    last = len(found.loads) - 1
    return sorted({0, last // 2, last})


def load_text(found: SpeedMap, i: int) -> str:
    """A load with its unit."""
    return f"{number(float(found.loads[i]), 3)} {found.load_unit.replace('*', '·').replace('^2', '²')}"


def panels(found: SpeedMap) -> list[Panel]:
    """The three panels, below each other."""
    ends = float(found.speeds[0] / RPM), float(found.speeds[-1] / RPM)
    return [bands(found, ends), oscillation(found, ends), campbell(found, ends)]


def bands(found: SpeedMap, ends: tuple[float, float]) -> Panel:
    """Forbidden speeds as a bar for every load, and the vendors' resonance speed."""
    name = found.load_name
    unit = "N·m" if name == "load torque" else "kg·m²"
    step = float(np.min(np.diff(found.loads))) if len(found.loads) > 1 else 1.0
    panel = Panel("Forbidden speeds", "motor speed (rpm)", f"{name} ({unit})", xlim=ends)
    for load, some in zip(found.loads.tolist(), found.forbidden, strict=True):
        for low, high in some / RPM:
            across = np.array([low, high])
            bar = np.full(2, load)
            panel.line(across, bar - BAR * step, BAND, "forbidden")
            panel.curves[-1] = panel.curves[-1]._replace(upper=bar + BAR * step)
    if found.vendor:
        speed = np.array([rule.speed / RPM for rule in found.vendor])
        loads = np.array([rule.load for rule in found.vendor])
        across, up = np.repeat(speed, 2), np.column_stack([loads - 0.5 * step, loads + 0.5 * step]).ravel()
        panel.line(across, up, WORST, "vendors' rule, 30 f_n", dash="5 4", width=1.8)
    low, high = float(found.loads[0]) - 0.6 * step, float(found.loads[-1]) + 0.6 * step
    panel.ylim = (low, high)
    return panel


def oscillation(found: SpeedMap, ends: tuple[float, float]) -> Panel:
    """Largest oscillation of all stable motions: under all loads, under some of them, and the limit."""
    rows = np.where(np.isfinite(found.oscillation), found.oscillation, np.nan)
    unit = angle_unit(float(np.nanmax(rows)))
    rpm = found.speeds / RPM
    panel = Panel(
        "Largest of all stable motions", "motor speed (rpm)", f"oscillation ({unit.name})", xlim=ends, log=True
    )
    worst = np.nanmax(np.where(np.isnan(rows), 0.0, rows), axis=0)
    panel.line(rpm, worst * unit.factor, WORST, "worst load", width=2.6)
    if len(found.loads) > 1:
        for i, colour, dash in zip(shown_loads(found), LOADS, DASHES, strict=False):
            panel.line(rpm, filled(rows[i]) * unit.factor, colour, load_text(found, i), dash)
    if found.scatter is not None:
        share = found.scatter.shares[-1]
        some = np.max(found.scatter.oscillation[-1], axis=0)
        panel.line(
            rpm,
            np.where(np.isfinite(some), some, worst) * unit.factor,
            LIMIT,
            f"{100 * share:.0f} % of units are below",
            "8 2 2 2",
        )
    if found.rules.limit is not None:
        level = found.rules.limit * unit.factor
        panel.line(np.array(ends), np.array([level, level]), LIMIT, "limit", dash="8 4", width=1.4)
    return panel


def campbell(found: SpeedMap, ends: tuple[float, float]) -> Panel:
    """Amplitude against the motor speed at which each order meets the resonance, under some loads."""
    largest = max((float(line.amplitude[-1]) for line in found.lines), default=0.0) or 1e-6
    unit = angle_unit(largest)
    panel = Panel("Where orders meet resonances", "motor speed (rpm)", f"torsion amplitude ({unit.name})", xlim=ends)
    some = shown_loads(found)
    for line in found.lines:
        at = [j for j, i in enumerate(some) if found.loads[i] == line.load]
        speed = line.speed / RPM
        if not at or not np.any((speed >= ends[0]) & (speed <= ends[1])):
            continue
        up = line.amplitude * unit.factor
        if len(up) == 1:  # one speed at every amplitude
            speed, up = np.repeat(speed, 2), np.array([0.0, largest * unit.factor])
        label = load_text(found, some[at[0]])
        panel.line(speed, up, LOADS[at[0]], label, DASHES[at[0]], 2.0 if line.excited else 1.0)
        if at[0] == len(some) - 1:
            panel.notes.append(
                Note(float(speed[-1]), float(up[-1]) * (0.98 - 0.09 * (int(line.order) % 3)), f"order {line.order:g}")
            )
    panel.ylim = (0.0, 1.05 * largest * unit.factor)
    if not panel.curves:
        panel.line(np.array(ends), np.zeros(2), WORST, "no order meets a resonance in this range")
        panel.ylim = (0.0, 1.0)
    return panel


def filled(row: Floats) -> Floats:
    """A row whose gaps are closed by straight lines."""
    good = np.isfinite(row)
    return np.interp(np.arange(len(row)), np.flatnonzero(good), row[good]) if good.any() else np.zeros(len(row))
