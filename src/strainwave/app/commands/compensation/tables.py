"""Output of `strainwave compensate`: tables of 80 columns, and plain data."""

import re
from collections import Counter
from collections.abc import Iterator
from operator import itemgetter
from typing import Any, NamedTuple

import numpy as np

from ....base.facts import Fact, aligned
from ....base.facts import data as as_data
from ....base.facts import table as table_of
from ....base.units import ARCSEC, RPM
from ....drive.project import Project
from ....study.compensation.bench import Bench
from ....study.compensation.compensate import PLAIN
from ....study.compensation.result import Compensation, CompensationBench, Units, grows
from ...console import number
from .order_tables import TableAlone

WIDTH = 80  # columns of the terminal
SHARES = (0.05, 0.5, 0.95)  # quantiles of the units


class Run(NamedTuple):
    """Results of a command: controllers at all speeds, sentences about those left out, the best in detail.

    `benches` are the drive by the angle of its load [rad]. `best` holds the best controller that measures the load and
    the best that does not, at the speed where the plain loop has the largest error. `details` are the same on other
    gears and units, as far as they were computed. `tables` are the order tables that are written, by name.
    """

    project: Project
    benches: dict[float, Bench]
    results: CompensationBench
    left_out: tuple[str, ...]
    best: tuple[Compensation, ...] = ()
    details: tuple[Compensation, ...] = ()
    tables: tuple[tuple[str, TableAlone], ...] = ()


def rows(run: Run) -> list[dict[str, Any]]:
    """One row for every controller at every speed."""
    return [as_data(case.facts()) for row in run.results.results for case in row]


def data(run: Run) -> dict[str, Any]:
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
            for name, row in zip(run.results.names, run.results.results, strict=True)
        ],
        "results": rows(run),
        "best": [as_data(one.facts()) for one in run.best],
        "details": [_detail(one) for one in run.details],
        "order_tables": {
            name: {"source": table.source, "delay_s": table.delay, "rms_alone_arcsec": rms / ARCSEC}
            for name, (table, rms) in run.tables
        },
        "warnings": warnings(run),
        "remarks": remarks(run),
    }  # fmt: skip


def _detail(case: Compensation) -> dict[str, Any]:
    gears = [
        {"stiffness": r.stiffness, "rms_before_arcsec": r.before / ARCSEC, "rms_after_arcsec": r.after / ARCSEC}
        for r in case.robustness
    ]
    units = None if case.units is None else _units(case.units)
    return {"controller": case.name, "motor_speed_rpm": case.speed / RPM, "other_gears": gears, "units": units}


def _units(units: Units) -> dict[str, Any]:
    return {
        "count": len(units.after.rms),
        "quantiles": SHARES,
        "rms_before_arcsec": (np.quantile(units.before.rms, SHARES) / ARCSEC).tolist(),
        "rms_after_arcsec": [value / ARCSEC for value in units.quantiles(SHARES)],
        "not_compensated": [{"unit": i, "cause": cause} for i, cause in units.unstable],
    }


def warnings(run: Run) -> list[str]:
    """Every warning once."""
    texts = [text for row in run.results.results for case in row for text in case.warnings]
    return list(dict.fromkeys([*texts, *(text for case in run.details for text in case.warnings)]))


def remarks(run: Run) -> list[str]:
    """Assumptions, and controllers that were left out."""
    return list(dict.fromkeys([*(text for bench in run.benches.values() for text in bench.remarks), *run.left_out]))


def summary(run: Run) -> str:
    """Return the tables as text."""
    lines = [f"{run.project.title}: rms pointing error about its mean, at the sampling times [arcsec]"]
    lines += run.results.residuals(WIDTH)
    if run.best:
        lines += ["", "best stable controllers within all limits, by the encoders required", *_best(run)]
    for case in run.details:
        lines += ["", *_on_others(case)]
    lines += [f"  order table, {name}: {case.table.source}" for name, case in run.tables]
    lines += [f"  warning: {text}" for text in _worse(run)]
    lines += [f"  note: {text}" for text in remarks(run)]
    return "\n".join(lines)


def _best(run: Run) -> list[str]:
    """Numbers of the best controllers at every speed, each at its worst angle: with an encoder on the load, without."""
    speeds = range(len(run.results.speeds))
    cases = [best_at(run.results, i, load_encoder=seeing) for i in speeds for seeing in (True, False)]
    angled, present = len(run.benches) > 1, [case for case in cases if case is not None]
    rows = [(*case.facts(), *_more(case, angled)) for case in present]
    return [f"  {line}" for line in aligned(table_of(rows))] if rows else []


def _more(case: Compensation, angled: bool) -> Iterator[Fact]:
    yield Fact("", "motor and load" if case.load_encoder else "motor", "encoders")
    if angled:
        yield Fact("", float(np.degrees(case.load_angle)), "load deg")


def _on_others(case: Compensation) -> list[str]:
    """A controller on gears and units that differ from the model."""
    lines = [f"{case.name} at {case.axis.said(case.speed)}", *(f"  {sentence}" for sentence in case.on_others())]
    unstable = () if case.units is None else case.units.unstable
    causes = Counter(re.sub(r" in [0-9.e+-]+ % of the samples", "", cause) for _, cause in unstable)
    return lines + [f"    {count} of them: {cause}" for cause, count in causes.most_common()]


def _worse(run: Run) -> list[str]:
    """Sentences about controllers that increase the error, and warnings about other gears."""
    texts = []
    for name, row in zip(run.results.names, run.results.results, strict=True):
        grown = [case for case in row if case.stable and grows(case.before.rms, case.after.rms)]
        problems = {
            "the error grows (controller unstable on this drive)": [case for case in row if not case.stable],
            "the error is larger than under the plain loop": grown,
            "no gain": [case for case in row if case.stable and not case.gains and case not in grown and name != PLAIN],
        }
        for problem, bad in filter(itemgetter(1), problems.items()):
            axis = run.results.axis
            speeds = ", ".join(number(axis.scale * case.speed) for case in bad)
            texts.append(f"controller {name}: {problem} at {speeds} {axis.unit}")
    texts += [text for row in run.results.results for case in row for text in case.warnings if case.gains]
    given = {text for row in run.results.results for case in row for text in case.warnings}
    return texts + [text for case in run.details if case.gains for text in case.warnings if text not in given]


def worst(bench: CompensationBench) -> int:
    """Number of the speed at which the plain loop has the largest error."""
    return int(np.argmax([case.before.rms for case in bench.results[0]]))


def best_at(bench: CompensationBench, i: int, *, load_encoder: bool) -> Compensation | None:
    """The best controller at a speed, with or without an encoder on the load: stable and within all limits."""
    column = [row[i] for row in bench.results if row[i].load_encoder == load_encoder and row[i].name != PLAIN]
    good = [case for case in column if case.stable and not case.excluded]
    return min(good, key=lambda case: case.after.rms, default=None)
