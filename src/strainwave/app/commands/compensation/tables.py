"""What `strainwave compensate` prints: tables of 80 columns, and the same as plain data."""

from textwrap import wrap
from typing import TYPE_CHECKING, Any

import numpy as np

from ....study.compensation.designs import COMPENSATORS
from ....study.compensation.result import Compensation, Units
from ....units import ARCSEC, RPM
from ...console import number

if TYPE_CHECKING:
    from .compensate import Run

WIDTH, NAME, CELL = 80, 18, 10  # columns of the terminal, of a name, of a speed
SHARES = (0.05, 0.5, 0.95)  # quantiles of the units
KEY = "x: a limit of motor or gear was met; !: the error grew"


def rows(run: "Run") -> list[dict[str, Any]]:
    """One row for every controller at every speed."""
    return [_row(one) for row in run.found.results for one in row]


def _row(one: Compensation) -> dict[str, Any]:
    return {
        "controller": one.name,
        "motor_speed_rpm": one.speed / RPM,
        "rms_before_arcsec": one.before.rms / ARCSEC,
        "rms_after_arcsec": one.after.rms / ARCSEC,
        "reduction_dB": one.reduction,
        "peak_before_arcsec": one.before.peak / ARCSEC,
        "peak_after_arcsec": one.after.peak / ARCSEC,
        "three_sigma_after_arcsec": one.after.three_sigma / ARCSEC,
        "motor_torque_rms_N_m": one.torque.rms,
        "motor_torque_peak_N_m": one.torque.peak,
        "at_limit_share": one.torque.limited,
        "gear_torque_peak_N_m": one.gear_torque,
        "load_encoder": int(one.load_encoder),
        "stable": int(one.stable),
        "excluded": one.excluded,
    }


def data(run: "Run") -> dict[str, Any]:
    """Return the numbers of the command."""
    s = run.bench.sampling
    return {
        "title": run.project.title,
        "sampling": {
            "period_s": s.period, "delay_s": s.delay, "torque_limit_N_m": s.limit if s.limit < 1e9 else None,
            "motor_encoder_step_rad": s.motor_quantum, "load_encoder": bool(s.load_encoder),
        },
        "controllers": [
            {"name": name, "title": row[0].title, "load_encoder": row[0].load_encoder, "condition": row[0].condition}
            for name, row in zip(run.found.names, run.found.results, strict=True)
        ],
        "results": rows(run),
        "best": None if run.best is None else _row(run.best),
        "best_without_load_encoder": None if run.without is None else _row(run.without),
        "other_gears": [] if run.detail is None else [
            {"stiffness": r.stiffness, "rms_before_arcsec": r.before / ARCSEC, "rms_after_arcsec": r.after / ARCSEC}
            for r in run.detail.robustness
        ],
        "units": None if run.detail is None or run.detail.units is None else _units(run.detail.units),
        "warnings": warnings(run),
        "remarks": remarks(run),
    }  # fmt: skip


def _units(units: Units) -> dict[str, Any]:
    return {
        "count": len(units.after.rms),
        "rms_before_arcsec": (np.quantile(units.before.rms, SHARES) / ARCSEC).tolist(),
        "rms_after_arcsec": [value / ARCSEC for value in units.quantiles(SHARES)],
        "quantiles": SHARES,
        "unstable": [{"unit": i, "cause": cause} for i, cause in units.unstable],
    }


def warnings(run: "Run") -> list[str]:
    """Every warning once."""
    every = [text for row in run.found.results for one in row for text in one.warnings]
    return list(dict.fromkeys([*every, *(() if run.detail is None else run.detail.warnings)]))


def remarks(run: "Run") -> list[str]:
    """What was assumed and left out."""
    return list(dict.fromkeys([*run.bench.remarks, *run.left_out]))


def summary(run: "Run") -> str:
    """Return the tables as text."""
    lines = [f"{run.project.title}: rms of the load's pointing error about its mean, arcsec"]
    lines += _residuals(run)
    if run.best is not None:
        lines += ["", "best that is stable and within all limits", *_best(run)]
    if run.detail is not None:
        lines += [""]
        for r in run.detail.robustness:
            gear = f"{abs(100.0 * r.stiffness):.0f} % {'softer' if r.stiffness < 0.0 else 'stiffer'} than the model"
            lines.append(
                f"  {run.detail.name} on a gear {gear}: {number(r.before / ARCSEC, 3)} → {number(r.after / ARCSEC, 3)}"
            )
        if run.detail.units is not None:
            lines += _units_text(run.detail.units, run.detail.name)
    lines += [f"  warning: {text}" for text in warnings(run)]
    lines += [f"  note: {text}" for text in remarks(run)]
    return "\n".join(part for line in lines for part in _folded(line))


def _folded(line: str) -> list[str]:
    return [line] if len(line) <= WIDTH else wrap(line, WIDTH, subsequent_indent="    ")


def _residuals(run: "Run") -> list[str]:
    """Residuals, controllers down and speeds across, in as many blocks as the speeds need."""
    lines, at_once = [], (WIDTH - NAME - 2) // CELL
    marked = False
    for begin in range(0, len(run.found.speeds), at_once):
        part = slice(begin, begin + at_once)
        lines.append(f"  {'motor rpm':{NAME}}" + "".join(f"{w / RPM:{CELL}.5g}" for w in run.found.speeds[part]))
        for name, row in zip(run.found.names, run.found.results, strict=True):
            marks = ["!" if not one.stable else "x" if one.excluded else "" for one in row[part]]
            marked |= any(marks)
            cells = (
                f"{number(one.after.rms / ARCSEC, 3) + mark:>{CELL}}"
                for one, mark in zip(row[part], marks, strict=True)
            )
            lines.append(f"  {name:{NAME}}" + "".join(cells))
    return [*lines, f"  {KEY}"] if marked else lines


def _best(run: "Run") -> list[str]:
    """The best at every speed with its numbers, and the best without an encoder on the load."""
    from .compensate import best_at

    lines = [f"  {'motor rpm':>9}  {'controller':{NAME}}{'arcsec':>16}{'dB':>7}{'N·m rms':>9}{'largest':>9}"]
    for i, speed in enumerate(run.found.speeds):
        named = dict.fromkeys(
            one.name for one in (best_at(run.found, i), best_at(run.found, i, load_encoder=False)) if one is not None
        )
        for name in named:
            one = run.found.results[run.found.names.index(name)][i]
            change = f"{number(one.before.rms / ARCSEC, 3)} → {number(one.after.rms / ARCSEC, 3)}"
            mark = "*" if COMPENSATORS[name].load_encoder else ""
            lines.append(
                f"  {speed / RPM:9.5g}  {name + mark:{NAME}}{change:>16}{one.reduction:7.1f}{one.torque.rms:9.3g}"
                f"{one.torque.peak:9.3g}"
            )
    starred = any("*" in line for line in lines)
    return [*lines, "  * measures the angle of the load"] if starred else lines


def _units_text(units: Units, name: str) -> list[str]:
    low, middle, high = (number(value / ARCSEC, 3) for value in units.quantiles(SHARES))
    lines = [
        f"  {name} on {len(units.after.rms)} units: median {middle}, 5 to 95 %: {low} to {high} (plain loop: median "
        f"{number(float(np.median(units.before.rms)) / ARCSEC, 3)}); {len(units.unstable)} unstable"
    ]
    causes: dict[str, int] = {}
    for _, cause in units.unstable:
        causes[cause] = causes.get(cause, 0) + 1
    return lines + [f"    {count} of them: {cause}" for cause, count in causes.items()]
