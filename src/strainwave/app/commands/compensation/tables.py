"""What `strainwave compensate` prints: tables of 80 columns, and the same as plain data."""

import re
from collections import Counter
from textwrap import wrap
from typing import TYPE_CHECKING, Any

import numpy as np

from ....study.compensation.compensate import PLAIN
from ....study.compensation.result import Compensation, Units, grows
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
    s = next(iter(run.benches.values())).sampling
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
        "best": [_row(one) for one in run.best],
        "details": [_detail(one) for one in run.details],
        "order_tables": {
            name: {
                "source": one.table.source, "delay_s": one.table.delay, "rms_alone_arcsec": one.rms / ARCSEC,
            } for name, one in run.tables
        },
        "warnings": warnings(run),
        "remarks": remarks(run),
    }  # fmt: skip


def _detail(one: Compensation) -> dict[str, Any]:
    gears = [
        {"stiffness": r.stiffness, "rms_before_arcsec": r.before / ARCSEC, "rms_after_arcsec": r.after / ARCSEC}
        for r in one.robustness
    ]
    units = None if one.units is None else _units(one.units)
    return {"controller": one.name, "motor_speed_rpm": one.speed / RPM, "other_gears": gears, "units": units}


def _units(units: Units) -> dict[str, Any]:
    return {
        "count": len(units.after.rms),
        "quantiles": SHARES,
        "rms_before_arcsec": (np.quantile(units.before.rms, SHARES) / ARCSEC).tolist(),
        "rms_after_arcsec": [value / ARCSEC for value in units.quantiles(SHARES)],
        "not_compensated": [{"unit": i, "cause": cause} for i, cause in units.unstable],
    }


def warnings(run: "Run") -> list[str]:
    """Every warning once."""
    every = [text for row in run.found.results for one in row for text in one.warnings]
    return list(dict.fromkeys([*every, *(text for one in run.details for text in one.warnings)]))


def remarks(run: "Run") -> list[str]:
    """What was assumed and left out."""
    return list(dict.fromkeys([*(text for bench in run.benches.values() for text in bench.remarks), *run.left_out]))


def summary(run: "Run") -> str:
    """Return the tables as text."""
    lines = [f"{run.project.title}: rms of the load's pointing error about its mean, arcsec"]
    lines += _residuals(run)
    if run.best:
        lines += ["", "best that is stable and within all limits", *_best(run)]
    for one in run.details:
        lines += ["", *_on_others(one)]
    lines += [f"  order table, {name}: {one.table.source}" for name, one in run.tables]
    lines += [f"  warning: {text}" for text in _worse(run)]
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
    """The best at every speed with its numbers: that which measures the load, and that which does not."""
    from .compensate import best_at

    lines = [f"  {'motor rpm':>9}  {'controller':{NAME}}{'arcsec':>16}{'dB':>7}{'N·m rms':>9}{'largest':>9}"]
    for i in range(len(run.found.speeds)):
        for one in (best_at(run.found, i, load_encoder=seeing) for seeing in (True, False)):
            if one is not None:
                change = f"{number(one.before.rms / ARCSEC, 3)} → {number(one.after.rms / ARCSEC, 3)}"
                name = one.name + "*" * one.load_encoder
                lines.append(
                    f"  {one.speed / RPM:9.5g}  {name:{NAME}}{change:>16}{one.reduction:7.1f}{one.torque.rms:9.3g}"
                    f"{one.torque.peak:9.3g}"
                )
    starred = any("*" in line for line in lines)
    return [*lines, "  * measures the angle of the load"] if starred else lines


def _on_others(one: Compensation) -> list[str]:
    """A controller on gears and units that differ from the model."""
    lines = [f"{one.name} at {number(one.speed / RPM)} rpm, arcsec"]
    for r in one.robustness:
        gear = f"{abs(100.0 * r.stiffness):.0f} % {'softer' if r.stiffness < 0.0 else 'stiffer'} than the model"
        lines.append(f"  on a gear {gear}: {number(r.before / ARCSEC, 3)} → {number(r.after / ARCSEC, 3)}")
    if one.units is not None:
        low, middle, high = (number(value / ARCSEC, 3) for value in one.units.quantiles(SHARES))
        before = number(float(np.median(one.units.before.rms)) / ARCSEC, 3)
        lines.append(
            f"  on {len(one.units.after.rms)} units: median {before} → {middle}, 5 to 95 %: {low} to {high}; "
            f"{len(one.units.unstable)} not compensated"
        )
        causes = Counter(re.sub(r" in [0-9.e+-]+ % of the samples", "", cause) for _, cause in one.units.unstable)
        lines += [f"    {count} of them: {cause}" for cause, count in causes.most_common()]
    return lines


def _grows(one: Compensation) -> bool:
    return grows(one.before.rms, one.after.rms)


def _worse(run: "Run") -> list[str]:
    """Where controllers do harm, a sentence for each of them; then what is wrong on other gears."""
    said = []
    for name, row in zip(run.found.names, run.found.results, strict=True):
        for what, bad in (
            ("the error grows", [one for one in row if not one.stable]),
            ("the error is larger than under the plain loop", [one for one in row if one.stable and _grows(one)]),
            ("no gain", [one for one in row if one.stable and not one.gains and not _grows(one) and name != PLAIN]),
        ):
            if bad:
                said.append(f"{name}: {what} at {', '.join(number(one.speed / RPM) for one in bad)} rpm")
    said += [text for row in run.found.results for one in row for text in one.warnings if one.gains]
    told = {text for row in run.found.results for one in row for text in one.warnings}
    return said + [text for one in run.details for text in one.warnings if text not in told]
