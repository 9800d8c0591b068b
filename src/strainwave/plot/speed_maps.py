"""Figures of a speed map: forbidden speeds, largest oscillation, and where orders meet resonances."""

import numpy as np

from ..base.results import Floats
from ..study.speed_map.result import SpeedMap
from . import panels
from .panels import BLACK, BLUE, ORANGE, Axis, Panel, angle, of_speeds, panels_of

BAND, LOADS, STYLES = "#8c2d04", (BLUE, panels.GREEN, panels.PINK), ("", "7 3", "2 3")  # of the loads shown
BAR = 0.42  # of the distance between loads
GREYS = range(0xFA, 0x8F, -9)  # of oscillations from small to large


def shown_loads(grid: SpeedMap) -> list[int]:
    """Numbers of the loads that figures show: the first, the middle one and the last."""
    last = len(grid.loads) - 1
    return sorted({0, last // 2, last})


@panels_of.register
def speed_map_panels(grid: SpeedMap) -> list[Panel]:
    """Forbidden speeds on shades of the oscillation, its largest values, and where orders meet resonances."""
    ends = float(grid.speeds[0]), float(grid.speeds[-1])
    return [_bands(grid, ends), _oscillation(grid, ends), _campbell(grid, ends)]


def _bands(grid: SpeedMap, ends: tuple[float, float]) -> Panel:
    """Forbidden speeds as a bar for every load, and the vendors' resonance speed."""
    step = float(np.min(np.diff(grid.loads))) if len(grid.loads) > 1 else 1.0
    y = Axis(grid.load_name, grid.load_unit.replace("^", "**"))
    panel = Panel("Forbidden speeds; darker grey: larger oscillation", of_speeds(grid.axis), y, xlim=ends)
    for load, bands in zip(grid.loads.tolist(), grid.forbidden, strict=True):
        for band in bands:
            panel.band(band, load - BAR * step, load + BAR * step, BAND, "forbidden")
    good = np.isfinite(grid.oscillation) & (grid.oscillation > 0.0)
    if np.any(good):
        size = np.log10(np.where(good, grid.oscillation, np.min(grid.oscillation[good])))
        share = (size - np.min(size)) / (np.ptp(size) or 1.0)
        shade = np.where(good, np.round((len(GREYS) - 1) * share), -1.0).astype(int)
        middle = np.concatenate([grid.speeds[:1], 0.5 * (grid.speeds[1:] + grid.speeds[:-1]), grid.speeds[-1:]])
        edges = np.append(grid.loads - 0.5 * step, grid.loads[-1] + 0.5 * step)
        panel.cells = panels.Cells(middle, edges, shade, [f"#{3 * f'{grey:02x}'}" for grey in GREYS])
    if grid.vendor:
        loads = np.array([rule.load for rule in grid.vendor])
        up = np.column_stack([loads - 0.5 * step, loads + 0.5 * step]).ravel()
        across = np.repeat([rule.speed for rule in grid.vendor], 2)
        panel.line(across, up, BLACK, "vendors' rule, 30 f_n", "5 4", 1.8)
    panel.ylim = (float(grid.loads[0]) - 0.6 * step, float(grid.loads[-1]) + 0.6 * step)
    return panel


def _oscillation(grid: SpeedMap, ends: tuple[float, float]) -> Panel:
    """Largest oscillation of all stable motions: under all loads, under some of them, and the limit."""
    rows = np.where(np.isfinite(grid.oscillation), grid.oscillation, np.nan)
    x, y = of_speeds(grid.axis), angle("oscillation", rows)
    panel = Panel("Largest oscillation of all stable motions", x, y, xlim=ends, log=True)
    worst = np.nanmax(np.where(np.isnan(rows), 0.0, rows), axis=0)
    panel.line(grid.speeds, worst, BLACK, "worst load", width=2.6)
    if len(grid.loads) > 1:
        for i, colour, dash in zip(shown_loads(grid), LOADS, STYLES, strict=False):
            panel.line(grid.speeds, _filled(rows[i]), colour, grid.load_text(i), dash)
    if grid.scatter is not None:
        share, quantile = grid.scatter.shares[-1], np.max(grid.scatter.oscillation[-1], axis=0)
        name = f"{100 * share:.0f} % of units are below"
        panel.line(grid.speeds, np.where(np.isfinite(quantile), quantile, worst), ORANGE, name, "8 2 2 2")
    if grid.rules.limit is not None:
        panel.level(grid.rules.limit, ORANGE, "limit", "8 4", 1.4)
    return panel


def _campbell(grid: SpeedMap, ends: tuple[float, float]) -> Panel:
    """Amplitude against the motor speed at which each order meets the resonance, under some loads."""
    largest = max((float(line.amplitude[-1]) for line in grid.lines), default=0.0) or 1e-6
    panel = Panel("Campbell diagram", of_speeds(grid.axis), angle("torsion amplitude", largest), xlim=ends)
    loads = [float(grid.loads[i]) for i in shown_loads(grid)]
    for line in grid.lines:
        speed, up = line.speed, line.amplitude
        if line.load not in loads or not np.any((speed >= ends[0]) & (speed <= ends[1])):
            continue
        if len(up) == 1:  # one speed at every amplitude
            speed, up = np.repeat(speed, 2), np.array([0.0, largest])
        look, name = loads.index(line.load), grid.load_text(int(np.argmin(np.abs(grid.loads - line.load))))
        panel.line(speed, up, LOADS[look], name, STYLES[look], 2.0 if line.excited else 1.0)
        if look == len(loads) - 1:
            height = float(up[-1]) * (0.98 - 0.09 * (int(line.order) % 3))
            panel.note(float(speed[-1]), height, f"order {line.order:g}")
    panel.ylim = (0.0, 1.05 * largest)
    if not panel.curves:
        panel.line(ends, [0.0, 0.0], BLACK, "no order excites a resonance in this range")
    return panel


def _filled(row: Floats) -> Floats:
    """A row whose gaps are closed by straight lines."""
    good = np.isfinite(row)
    return np.interp(np.arange(len(row)), np.flatnonzero(good), row[good]) if good.any() else np.zeros(len(row))
