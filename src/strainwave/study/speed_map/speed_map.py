"""`speed_map`: which motor speeds are allowed under every load, from the nonlinear response of the whole drive."""

from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ...base.quantities import interval, number, numbers, shown
from ...base.results import Booleans, Floats, Integers, Interrupted, SolveError
from ...base.terminal import silent
from ...base.units import ARCSEC
from ...drive.postures import LoadCase, Posture
from ...drive.project import Project
from ...drive.train_curve import in_turns
from .avoid import out_of_reach
from .campbell import CampbellLine, lines_of, resonances_of
from .decide import POSTURE, Decision, decide, under_each
from .intervals import Span, as_intervals, common, holds
from .motions import OMEGA, OSCILLATION, SMALLEST, TORQUE, LoadMotions, row_at
from .ramp import run_up_sizes
from .ratings import beyond_ratings
from .result import JumpSpeed, Scatter, SpeedMap, load_text
from .rules import bands_of, rules_of
from .under_load import Case, case_of, is_searched, under_load
from .vendor_rule import vendor_rules

CELLS = 500  # speeds of a range
QUANTILES = (0.05, 0.5, 0.95)
MOTION_DIFFERENCE = 0.01  # relative difference of the oscillations of one motion


class Cells(NamedTuple):
    """Stable motions under one load at speeds (m,).

    Attributes
    ----------
    oscillation, torque : (m,) arrays
        Largest oscillation [rad] and largest torque in the gear [N*m]; inf where no motion is known.
    motions : (m,) int array
        How many motions there are.
    subharmonic : (m,) bool array
        Whether one of them may repeat after more than one turn.
    smallest : (m,) array
        Oscillation [rad] of the smallest turn of the largest motion.
    """

    oscillation: Floats
    torque: Floats
    motions: Integers
    subharmonic: Booleans
    smallest: Floats


def speed_map(
    project: Project,
    *,
    speeds: ArrayLike | None = None,
    loads: ArrayLike | None = None,
    load_inertias: ArrayLike | None = None,
    postures: Sequence[Posture] = (),
    limit: float | None = None,
    amplification: float | None = None,
    margin: float | None = None,
    orders: Sequence[float] = (),
    units: Iterable[Project] = (),
    search: bool = True,
    threads: int | None = None,
    progress: Callable[[str, float], None] = silent,
) -> SpeedMap:
    """Map a drive over motor speed and load: the error, the torque, the motions, and the speeds to keep away from.

    Under each load every stable steady motion is followed through the range: the curve of the whole drive by harmonic
    balance, and motions apart from it, subharmonics among them, on which random starts settle. A speed is forbidden
    where the largest of them breaks a rule, between the jumps of a slow run-up and run-down, where no stable motion is
    known, and where the motor must turn faster than it or the gear may, or give more torque than it has.

    Parameters
    ----------
    project : Project
        From `read_project`.
    speeds : (low, high) or (m,) array_like, optional
        Range of the motor speed [rad/s], or the cells themselves, ascending. Default: the project's range.
    loads : (n,) array_like, optional
        Mean torques on the load [N*m]; a resisting one is negative. Default: postures, or one; over a range 9, and more
        where jumps begin or end between two.
    load_inertias : (n,) array_like, optional
        Inertias of the load [kg*m^2] in place of torques, as along a robot's reach.
    postures : sequence of Posture
        Loads in postures of the machine in place of torques: each by itself, nothing between two rows.
    limit : float, optional
        Largest oscillation of the error [rad]. Default, where no rule is given: the project's limit, or else an
        `amplification` of 2.
    amplification : float, optional
        Largest oscillation relative to that of quasi-static rotation.
    margin : float, optional
        Separation margin from every resonance as a share of the speed: 0.1 is the 10 % usual for torsional trains.
    orders : sequence of float
        Further orders on the motor's turn that the Campbell diagram shows, as those of `order_map`: 1/N of the output's
        turn, 2 N + 2 of the tooth mesh.
    units : iterable of Project
        Drives that scatter about this one (`scattered`), for the worst case and quantiles. They are followed along
        their main curve alone.
    search : bool
        Whether motions apart from the main curve are looked for.
    threads : int, optional
        Default: as many as there are processors.
    progress : callable
        Told what is done, and which share of all.

    Returns
    -------
    SpeedMap
        For each load intervals of the motor speed that are `forbidden` and `allowed` [rad/s], the largest
        `oscillation` [rad] and `torque` [N*m] in each cell (loads, speeds); `windows` [rad/s] are allowed under
        all loads.

    Raises
    ------
    ValueError
        If a range has no width, or a number is out of range.
    SolveError
        If the law cannot carry a load, or no periodic motion is found under any.
    Interrupted
        On Ctrl-C after the first load, with the map of the loads and units that were finished.

    References
    ----------
    Krack & Gross 2019, Harmonic Balance for Nonlinear Vibration Problems, secs. 2-4; Nayfeh & Mook 1979, Nonlinear
    Oscillations, sec. 4.1.1 (jumps).
    """
    cells, span = _speeds(project, speeds)
    default = speeds is None and loads is None and load_inertias is None and not postures
    rules = rules_of(limit, amplification, margin, project.limit)
    of_loads = 0.5 if (drives := list(units)) else 1.0
    decided = decide(
        project, rules, span, loads=loads, load_inertias=load_inertias, postures=postures, search=search,
        threads=threads, progress=lambda share: progress("motions", of_loads * share),
    )  # fmt: skip
    values, name, variants, by_load = decided.loads, decided.name, decided.projects, list(decided.by_load)
    rules, bands, names = decided.rules, decided.bands, [case.name for case in decided.load_cases]
    if not any(loaded.curves for loaded in by_load):
        raise SolveError(by_load[0].remarks[0])
    lines = decided.lines(tuple(number("order", k, positive=True) for k in orders))
    table = Cells(*map(np.array, zip(*(cells_of(loaded, cells) for loaded in by_load), strict=True)))
    scatter = _scatter_of(drives if len(values) == decided.total else [], decided, cells, progress)
    resting = max(abs(torque) for variant in variants for torque in variant.load_torques) / project.drive.N
    texts = {value: load_text(value, name, title) for value, title in zip(values.tolist(), names, strict=True)}
    failures, warnings = beyond_ratings(project, float(cells[-1]), by_load, texts, resting)
    result = SpeedMap(
        speeds=cells,
        loads=values,
        load_name=name,
        oscillation=table.oscillation,
        torque=table.torque,
        motions=table.motions,
        subharmonic=table.subharmonic,
        forbidden=tuple(one.forbidden for one in bands),
        allowed=tuple(one.allowed for one in bands),
        windows=decided.allowed,
        jumps=tuple(JumpSpeed(i, *jump) for i, loaded in enumerate(by_load) for jump in loaded.jumps),
        lines=tuple(lines),
        vendor=tuple(vendor_rules(variants, values, bands, span)),
        rules=rules,
        quasi_static=np.array([loaded.quasi_static for loaded in by_load]),
        crests=np.array([loaded.largest for loaded in by_load]),
        scatter=scatter,
        remarks=(*_remarks(decided, lines, search), *warnings, *_posture_remarks(decided.load_cases, project)),
        failures=failures,
        postures=tuple(names) if name == POSTURE else (),
        smallest=table.smallest if any(one.branch.beat for loaded in by_load for one in loaded.curves) else None,
        shaft=project.speeds.base,
        run_up=_run_up(project, decided) if search and default else None,
    )
    result = replace(result, failures=(*decided.faults, *(() if decided.faults else _unreachable(result)), *failures))
    finished = 0 if scatter is None else scatter.units
    if len(values) < decided.total or finished < len(drives):
        some = f"the map covers {len(values)} of {decided.total} loads and {finished} of {len(drives)} units"
        raise Interrupted(f"interrupted; {some}", result)
    return result


def cells_of(loaded: LoadMotions, speeds: Floats) -> Cells:
    """Evaluate the stable motions under one load at speeds (m,) [rad/s]."""
    oscillation, torque, smallest = np.full((3, len(speeds)), -np.inf)
    motions, subharmonic = np.zeros(len(speeds), np.int64), np.zeros(len(speeds), bool)
    counted: list[Floats] = []
    for run, slower in loaded.runs:
        inside = (speeds >= run[0, OMEGA]) & (speeds <= run[-1, OMEGA])
        rows = row_at(run, speeds)
        smallest = np.where(inside & (rows[:, OSCILLATION] > oscillation), rows[:, SMALLEST], smallest)
        for out, column in ((oscillation, OSCILLATION), (torque, TORQUE)):
            out[inside] = np.maximum(out[inside], rows[inside, column])
        new = inside.copy()
        for other in counted:  # a run-down along the motions of the run-up
            new &= ~(np.abs(rows[:, OSCILLATION] - other) < MOTION_DIFFERENCE * other)
        counted.append(np.where(inside, rows[:, OSCILLATION], np.nan))
        motions[new] += 1
        subharmonic[inside] |= slower
    for low, high in loaded.doubled:
        subharmonic |= (speeds >= low) & (speeds <= high)
    for omega, size, strain, turns in loaded.loose:
        cell = int(np.argmin(np.abs(speeds - omega)))
        oscillation[cell], torque[cell] = max(oscillation[cell], size), max(torque[cell], strain)
        motions[cell] += 1
        subharmonic[cell] |= turns != 1
    oscillation, torque, smallest = np.where(motions == 0, np.inf, [oscillation, torque, smallest])
    return Cells(oscillation, torque, motions, subharmonic, smallest)


def _speeds(project: Project, speeds: ArrayLike | None) -> tuple[Floats, Span]:
    """Cells (m,) and range [rad/s]."""
    given = np.array(project.speeds.limits if speeds is None else speeds, object)
    if given.shape == (2,):
        low, high = interval("the range of speeds [rad/s]", tuple(given), positive=True)
        return np.linspace(low, high, CELLS), (low, high)
    cells = numbers("speeds [rad/s]", speeds)
    if len(cells) < 2 or not (np.all(np.diff(cells) > 0.0) and cells[0] > 0.0):
        raise ValueError(f"speeds are {shown(speeds)}; they must be positive and ascend, or be (low, high)")
    return cells, interval("the range of speeds [rad/s]", (float(cells[0]), float(cells[-1])), positive=True)


def _run_up(project: Project, decided: Decision) -> Floats | None:
    """Speeds (k, 2) [rad/s] that a run-up adds to the forbidden ones, where it has torques that no curve has."""
    passed = run_up_sizes(project)
    if passed is None:
        return None
    above = as_intervals(passed.above(decided.rules.level(float(decided.by_load[0].quasi_static))))
    return common(above, decided.quiet)


def _unreachable(result: SpeedMap) -> tuple[str, ...]:
    """Sentence on a limit of the oscillation that no speed meets under any load; none where one does."""
    limit, slow = result.rules.limit, float(np.max(result.quasi_static))
    load, speed = np.unravel_index(np.argmin(result.oscillation), result.oscillation.shape)
    least = float(result.oscillation[load, speed])
    if limit is None or not limit < least < np.inf or any(map(len, result.allowed)):
        return ()
    return (
        f"The limit of {limit / ARCSEC:.4g} arcsec cannot be met at any speed: the largest oscillation at each speed "
        f"is at least {least / ARCSEC:.4g} arcsec, its minimum at {result.axis.said(result.speeds[speed], 5)} "
        f"with {result.load_text(int(load))}, and {slow / ARCSEC:.4g} arcsec at very low speed; "
        "raise the limit, or reduce the excitation.",
    )


def _scatter_of(
    drives: list[Project], decided: Decision, cells: Floats, progress: Callable[[str, float], None]
) -> Scatter | None:  # fmt: skip
    """Quantiles over units, each followed along its main curve; after Ctrl-C over those finished, None without any."""
    units: list[Floats] = []  # each (loads, 2, cells): oscillation [rad], and 1 where a speed is forbidden
    with suppress(KeyboardInterrupt):
        for i, drive in enumerate(drives):
            variants = under_each(drive, decided.name, decided.loads, decided.load_cases)
            cases = [case_of(*each, decided.span) for each in zip(variants, decided.loads, strict=True)]
            units.append(np.array([_cells_of_unit(case, cells, decided) for case in cases]))
            progress("units", 0.5 + 0.5 * (i + 1.0) / len(drives))
    if not units:
        return None
    oscillation, forbidden = np.moveaxis(np.array(units), 2, 0)
    quantiles = np.quantile(oscillation, QUANTILES, axis=0, method="higher")
    worst, share = np.max(oscillation, axis=0), np.mean(forbidden, axis=0)
    return Scatter(np.array(QUANTILES), quantiles, worst, share, len(units))


def _cells_of_unit(case: Case, cells: Floats, decided: Decision) -> tuple[Floats, Booleans]:
    """Largest oscillation (m,) [rad] of one unit under a load by its main curve, and where it is forbidden."""
    span, rules = decided.span, decided.rules
    loaded, _ = under_load(case, span, None, rules=rules)
    lines = [] if rules.margin is None else lines_of([case], [loaded], ())
    bands = bands_of(loaded, rules, span, resonances_of(loaded, lines), 0.0)
    return cells_of(loaded, cells)[0], holds(bands.forbidden, cells)


def _posture_remarks(cases: Sequence[LoadCase], project: Project) -> tuple[str, ...]:
    """Sentence on postures that have no torque of gravity, or that are left out."""
    rows = [case.posture for case in cases if case.posture is not None]
    if project.postures and not rows:
        return ("the postures of the project are ignored because loads are given",)
    count, mean = sum(row.torque is None for row in rows), f"{project.mean_load_torque:.4g} N*m"
    return (f"{count} of {len(rows)} postures have no gravity torque: they use the mean, {mean}",) * bool(count)


def _remarks(decided: Decision, lines: list[CampbellLine], search: bool) -> tuple[str, ...]:
    """Remarks for the reader, each once."""
    cases, by_load, name, span, rules = decided.cases, decided.by_load, decided.name, decided.span, decided.rules
    remarks = [remark for loaded in by_load if loaded.curves for remark in loaded.remarks]
    if still := ", ".join(f"{loaded.load:g}" for loaded in by_load if not loaded.curves):
        remarks.append(f"no stable steady motion is known with a {name} of {still}")
    if not search or not all(is_searched(case.equation) for case in cases):
        remarks.append("other motions at the same speed (subharmonics) were not searched")
    met = {line.order for line in lines if np.any((line.speed >= span[0]) & (line.speed <= span[1]))}
    if idle := sorted({line.order for line in lines} - met):
        listing = ", ".join(in_turns(order, cases[0].full_train) for order in idle)
        remarks.append(f"orders without a resonance in this speed range: {listing}")
    if below := out_of_reach(rules.limit, max(loaded.quasi_static for loaded in by_load), cases[0].train):
        remarks.append(below)
    if any(loaded.loose for loaded in by_load):
        remarks.append("some simulations settled on motions without a curve; neighbouring speeds are judged alike")
    return tuple(dict.fromkeys(remarks))
