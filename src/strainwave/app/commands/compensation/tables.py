"""Output of `strainwave compensate`: tables of 80 columns, plain data, and tables of orders for drives."""

import re
from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import replace
from math import atan2, cos, hypot, pi, sin
from operator import itemgetter
from typing import Any, NamedTuple

import numpy as np

from ....base.facts import Fact, aligned
from ....base.facts import data as as_data
from ....base.facts import table as table_of
from ....base.protocols import terms_of
from ....base.units import ARCSEC, RPM
from ....drive.project import Project
from ....files.order_table import OrderTable
from ....model.controllers import AdaptiveCancellation, AngleFeedforward, TorqueTable
from ....model.excitation import Harmonic, Harmonics, KinematicError, Line, mean_torque
from ....numerics.ensemble.loops import LoopRun, loop_ensemble, run_loop
from ....study.compensation.bench import Bench
from ....study.compensation.compensate import PLAIN
from ....study.compensation.gains import behind_of, own_rate, times_of
from ....study.compensation.result import Compensation, CompensationBench, Units, grows
from ...console import number

DIGITS = 12  # of a delay [s], behind which is rounding
WIDTH = 80  # columns of the terminal
SHARES = (0.05, 0.5, 0.95)  # quantiles of the units


class Alone(NamedTuple):
    """An order table, and the rms of the pointing error [rad] under the plain loop with this table alone."""

    table: OrderTable
    rms: float


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
    tables: tuple[tuple[str, Alone], ...] = ()


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
    lines = [f"{run.project.title}: rms of the pointing error about its mean at the samples, arcsec"]
    lines += run.results.residuals(WIDTH)
    if run.best:
        lines += ["", "best that is stable and within all limits, by the encoders that it needs", *_best(run)]
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
            "the error grows, as the controller is unstable on this drive,": [case for case in row if not case.stable],
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
    column = [row[i] for row in bench.results if row[i].load_encoder == load_encoder and row[i].name != "loop"]
    good = [case for case in column if case.stable and not case.excluded]
    return min(good, key=lambda case: case.after.rms, default=None)


def stated(bench: Bench, case: Compensation) -> tuple[tuple[str, Alone], ...]:
    """Tables of `tables_of`; `source` has the rms of a run with each alone, and of one with all of them.

    Of an error equation there are none: the phase of a forcing is no angle that a drive controller knows.
    """
    if bench.equation:
        return ()
    bench, speed = bench.at_speed(case.speed), case.speed
    tables = tables_of(bench, case)
    joint = left(bench, tables.values(), speed) / ARCSEC if len(tables) > 1 else 0.0
    alone = []
    for name, table in tables.items():
        rms = left(bench, [table], speed)
        source = (
            f"{table.source}; used alone it leaves {rms / ARCSEC:.3g} of {case.before.rms / ARCSEC:.3g} arcsec rms "
            "of the pointing error there"
        )
        others = " and ".join(f"order-table-{other}.json" for other in tables if other != name)
        source += f", with {others} {joint:.3g}" if others else ""
        alone.append((name, Alone(replace(table, source=source), rms)))
    return tuple(alone)


def left(bench: Bench, tables: Iterable[OrderTable], speed: float) -> float:
    """Rms of the pointing error [rad] about its mean at a motor speed [rad/s], under the plain loop and tables."""
    controller = bench.loop
    for table in tables:
        turns = 1.0 / bench.model.N if table.turn == "output" else 1.0
        fixed = table.at_speed(turns * abs(speed))
        lines = fixed.backward if speed < 0.0 and fixed.backward is not None else fixed.lines
        if table.unit == "rad":
            error = KinematicError(tuple(line._replace(order=turns * line.order) for line in lines))
            controller = AngleFeedforward(controller, error, bench.model.N)
        else:
            terms = tuple(Harmonic(line.amplitude, line.order, line.phase) for line in lines)
            controller = TorqueTable(controller, Harmonics(terms), turns=turns)
    settle, end = times_of(bench, speed)
    return float(loop_ensemble(bench.closed(controller, speed), {}, end, settle=settle, y0=bench.start(speed)).rms[0])


def tables_of(bench: Bench, case: Compensation) -> dict[str, OrderTable]:
    """Tables of a controller by the signal they are added to, "angle" or "torque"; adapted ones after convergence.

    A torque holds at the speed of the result alone, in its direction and under the mean torque on its load; it has that
    of the motor's inertia along a corrected angle. An angle without a torque is read ahead by the time until a sample's
    torque acts.
    """
    about: dict[str, Any] = {"ratio": bench.model.N, "source": f"{case.name} at {case.speed / RPM:.4g} rpm"}
    held = about | {
        "speeds": (abs(case.speed), abs(case.speed)),
        "direction": "forward" if case.speed > 0.0 else "backward",
        "load": mean_torque(bench.plant.load.end().excitation),
    }
    tables: dict[str, OrderTable] = {}
    controller, lines = case.controller, list[Line]()
    run = _adapted(bench, case) if isinstance(controller, AdaptiveCancellation) else None
    memory: Any = run and run.memory.state
    while run is not None and isinstance(controller, AdaptiveCancellation):
        memory, a, b, _ = memory
        ripple_a, ripple_b = _ripple(bench, controller, run, case.speed)
        a, b = a - ripple_a, b - ripple_b
        lines.append(Line(controller.order, hypot(a, b), atan2(-b, a)))
        controller = controller.loop
    table = controller if isinstance(controller, TorqueTable) else None
    controller = table.loop if table else controller
    if table and lines:
        ahead = table.lead * case.speed
        lines += [Line(h.order, h.amplitude, h.phase + h.order * ahead) for h in terms_of(table.table)]
    elif table:
        turn = "motor" if table.turns == 1.0 else "output"
        tables["torque"] = OrderTable.of(table.table, turn=turn, delay=table.lead, **held)
    if isinstance(controller, AngleFeedforward):
        lines += _of_inertia(controller, case.speed) if lines else []
        ahead = 0.0 if lines else round(bench.lead, DIGITS)
        one_way = {} if bench.backward is None else {"direction": held["direction"]}
        tables["angle"] = OrderTable.of(controller.error, delay=ahead, **about, **one_way)
    if lines:
        tables["torque"] = OrderTable.of(lines[::-1], unit="N*m", **held)
    return tables


def _of_inertia(controller: AngleFeedforward, speed: float) -> list[Line]:
    """Torque lines [N*m] that move the motor's inertia along a corrected angle at a steady motor speed [rad/s]."""
    ahead, size = controller.lead * speed, controller.J * controller.N * speed * speed
    lines = controller.error.lines if size else ()
    return [Line(line.order, -size * line.order**2 * line.amplitude, line.phase + line.order * ahead) for line in lines]


def _adapted(bench: Bench, case: Compensation) -> LoopRun:
    """Run until the controller has converged."""
    settle, _ = times_of(bench, case.speed, own_rate(bench, case.speed, case.controller))
    return run_loop(bench.closed(case.controller, case.speed), settle, y0=bench.start(case.speed))


def _ripple(bench: Bench, controller: AdaptiveCancellation, run: LoopRun, speed: float) -> tuple[float, float]:
    """Ripple of both amplitudes [N*m] at the end of a run, due to the mean y of the measured error.

    a' = -g y cos(k theta + phi) and b' = -g y sin(k theta + phi) of a constant y are waves about the converged values.
    """
    error = run.error if controller.on_load else behind_of(bench)(run.states)
    turn = round(2.0 * pi / abs(speed) / bench.sampling.period)
    step = controller.order * speed * bench.sampling.period
    size = controller.period * controller.gain * float(np.mean(error[-turn:])) / (2.0 * sin(0.5 * step))
    late = step * (len(run.time) - 0.5) + (controller.phase if speed > 0.0 else -controller.phase)
    return -size * sin(late), size * cos(late)
