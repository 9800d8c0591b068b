"""`speed_map`: which motor speeds are allowed under every load, from the nonlinear response of the whole drive."""

import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import FIRST_EXCEPTION, ThreadPoolExecutor, wait
from contextlib import suppress
from dataclasses import replace
from functools import partial
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ...base.quantities import interval, number, numbers, positive_count, shown
from ...base.results import Floats, Interrupted, SolveError
from ...base.sentences import silent
from ...base.units import ARCSEC
from ...drive.postures import Posture
from ...drive.project import Project
from ...drive.train_curve import in_turns
from ...drive.two_turns import is_beating
from ..analysis.avoid import out_of_reach
from ..analysis.load_cases import is_jumping, with_ends_of_jumps
from .motions import OMEGA, OSCILLATION, SMALLEST, TORQUE, UnderLoad, row_at
from .result import POSTURE, JumpSpeed, Scatter, SpeedMap, load_text
from .rules import Rules, Span, bands_of, beyond_ratings, holds, none, rules_of, vendor_rules, windows, with_ratings
from .under_load import APART, CampbellLine, Case, campbell, case_of, extended, main_curve, under_load, untried

CELLS, LOADS = 500, 9  # speeds of a range, and loads of one
QUANTILES = (0.05, 0.5, 0.95)
GOLDEN = 0.5 * (5.0**0.5 - 1.0)  # spreads the speeds of the search from load to load
SAME = 0.01  # relative difference of the oscillations of one motion
NEAR = 0.1  # relative distance at which a peak belongs to a line of the Campbell diagram

Cells = tuple[Floats, Floats, Any, Any, Floats]  # oscillation, torque, motions, subharmonic, smallest of one load


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
    rules = with_ratings(rules_of(limit, amplification, margin, project.limit), project, span)
    values, name, variants = _loads(project, span, loads, load_inertias, postures)
    rows = (*postures, *project.postures)[: len(values)] if name == POSTURE else ()
    count = positive_count("threads", os.cpu_count() or 1 if threads is None else threads)
    cases = [case_of(variant, value, span) for variant, value in zip(variants, values.tolist(), strict=True)]
    total, of_loads = len(cases), 0.5 if (drives := list(units)) else 1.0
    computed, by_load = _all_motions(cases, span, search, count, rules, progress, of_loads)
    cases, variants, values = [cases[i] for i in computed], [variants[i] for i in computed], values[computed]
    if not any(loaded.curves for loaded in by_load):
        raise SolveError(by_load[0].remarks[0])
    lines = _lines(cases, by_load, tuple(number("order", k, positive=True) for k in orders))
    apart = _apart(len(cases))
    bands = [
        bands_of(loaded, rules, span, _resonances(loaded, [line for line in lines if line.load == loaded.load]), apart)
        for loaded in by_load
    ]
    faults = list(dict.fromkeys(one.loop_fault for one in variants if one.loop_fault))
    bands = [none(span) if one.loop_fault else own for one, own in zip(variants, bands, strict=True)]
    table = [cells_of(loaded, cells) for loaded in by_load]
    oscillation, torque, motions, subharmonic, smallest = map(np.array, zip(*table, strict=True))
    scatter = _scatter(drives if len(computed) == total else [], values, name, rows, cells, span, rules, progress)
    resting = max(abs(torque) for variant in variants for torque in variant.load_torques) / project.drive.N
    texts = {value: load_text(value, name, rows[int(value) - 1].name if rows else "") for value in values.tolist()}
    failures, warnings = beyond_ratings(project, cells, values, torque, by_load, texts, resting)
    result = SpeedMap(
        speeds=cells,
        loads=values,
        load_name=name,
        oscillation=oscillation,
        torque=torque,
        motions=motions,
        subharmonic=subharmonic,
        forbidden=tuple(one.forbidden for one in bands),
        allowed=tuple(one.allowed for one in bands),
        windows=windows([one.forbidden for one in bands], span, name != POSTURE),
        jumps=tuple(JumpSpeed(i, *jump) for i, loaded in enumerate(by_load) for jump in loaded.jumps),
        lines=tuple(lines),
        vendor=tuple(vendor_rules(variants, values, bands, span)),
        rules=rules,
        quasi_static=np.array([loaded.quasi_static for loaded in by_load]),
        scatter=scatter,
        remarks=(*_remarks(cases, by_load, name, lines, span, rules, search), *warnings, *_without(rows, project)),
        failures=failures,
        postures=tuple(rows[i] for i in computed) if rows else (),
        smallest=smallest if project.is_beating else None,
        shaft=project.speeds.base,
    )
    result = replace(result, failures=(*faults, *(() if faults else _unreachable(result)), *failures))
    finished = 0 if scatter is None else scatter.units
    if len(computed) < total or finished < len(drives):
        some = f"the map is that of {len(computed)} of {total} loads and {finished} of {len(drives)} units"
        raise Interrupted(f"interrupted; {some}, which were finished", result)
    return result


def cells_of(loaded: UnderLoad, speeds: Floats) -> Cells:
    """Largest oscillation and torque, stable motions, flag of subharmonics, smallest turn of the largest, at speeds."""
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
            new &= ~(np.abs(rows[:, OSCILLATION] - other) < SAME * other)
        counted.append(np.where(inside, rows[:, OSCILLATION], np.nan))
        motions[new] += 1
        subharmonic[inside] |= slower
    for low, high in loaded.doubled:
        subharmonic |= (speeds >= low) & (speeds <= high)
    for omega, size, strain, turns in loaded.loose:
        here = int(np.argmin(np.abs(speeds - omega)))
        oscillation[here], torque[here] = max(oscillation[here], size), max(torque[here], strain)
        motions[here] += 1
        subharmonic[here] |= turns != 1
    oscillation, torque, smallest = np.where(motions == 0, np.inf, [oscillation, torque, smallest])
    return oscillation, torque, motions, subharmonic, smallest


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


def _loads(
    project: Project, span: Span, loads: ArrayLike | None, load_inertias: ArrayLike | None,
    postures: Sequence[Posture] = (),
) -> tuple[Floats, str, list[Any]]:  # fmt: skip
    """Loads (n,), what they are, and the project under each."""
    arguments = ("loads", loads), ("load_inertias", load_inertias), ("postures", postures or None)
    given = [name for name, value in arguments if value is not None]
    if given[1:]:
        raise ValueError(f"{' and '.join(given[:2])} are both given; give one of them")
    if loads is None and load_inertias is None and (rows := tuple(postures) or project.postures):
        return np.arange(1.0, len(rows) + 1.0), POSTURE, [row.on(project) for row in rows]
    if load_inertias is not None:
        values = np.unique(numbers("load_inertias [kg*m^2]", load_inertias))
        if not values[0] > 0.0:
            raise ValueError(f"load_inertias are {shown(load_inertias)}; inertias must be positive")
        loaded = project.under(project.mean_load_torque, project.is_beating)
        return values, "load inertia", [loaded.with_load_inertia(J) for J in values.tolist()]
    if loads is None:
        low, high = project.other_loads
        spread = np.linspace(low, high, LOADS if low < high else 1)
        loads = spread if low == high else with_ends_of_jumps(project, spread, partial(_jumps, project, span))
    values = np.unique(numbers("loads [N*m]", loads))
    return values, "load torque", [project.under(torque, project.is_beating) for torque in values.tolist()]


def _jumps(project: Project, span: Span, torque: float) -> bool:
    """Whether the curve under a torque jumps, also beside the span: jumps come into it from there, torque by torque.

    A torque that the law cannot carry has no curve.
    """
    low, high = project.speeds.limits
    wide = min(low, span[0]), max(high, span[1])
    try:
        return is_jumping(main_curve(case_of(project.under(torque, project.is_beating), torque, wide), wide))
    except SolveError:
        return False


def _apart(loads: int) -> float:
    """Relative distance of the speeds of the search: up to twice as large where neighbouring loads have others."""
    return APART * min(2.0, max(1.0, 0.25 * loads))


def _all_motions(
    cases: list[Case], span: Span, search: bool, threads: int, rules: Rules, progress: Callable[[str, float], None],
    share: float,
) -> tuple[list[int], list[UnderLoad]]:  # fmt: skip
    """Motions under every load, or under those finished at Ctrl-C, with their numbers.

    Motions apart from the main curve are tried under the neighbouring loads too.
    """
    apart = _apart(len(cases)) if search else None
    by_load: dict[int, UnderLoad] = {}
    seeds: dict[int, Any] = {}

    def one(i: int) -> None:
        loaded, seeds[i] = under_load(cases[i], span, apart, (GOLDEN * i) % 1.0, rules)
        by_load[i] = loaded
        progress("motions", share * len(by_load) / len(cases))

    with ThreadPoolExecutor(threads) as pool:  # the first compiles, where that is still to do, before threads start
        left: set[Any] = set()
        try:
            one(0)
            left = {pool.submit(one, i) for i in range(1, len(cases))}
            while left:  # not for ever at once: Windows hears of Ctrl-C between waits
                done, left = wait(left, timeout=1.0, return_when=FIRST_EXCEPTION)
                for future in done:
                    future.result()
        except BaseException as error:
            for future in left:
                future.cancel()
            if not (by_load and isinstance(error, KeyboardInterrupt)):
                raise
    computed = sorted(by_load)
    for way in (computed, computed[::-1]):
        for before, here in pairwise(way):
            if tried := untried(cases[here], seeds[before], by_load[before], by_load[here]):
                by_load[here], new = extended(by_load[here], cases[here], span, np.empty(0), tried)
                seeds[here] = (*seeds[here], *new)
    return computed, [by_load[i] for i in computed]


def _lines(cases: list[Case], found: list[UnderLoad], orders: tuple[float, ...]) -> list[CampbellLine]:
    """Lines of the Campbell diagram under every load, up to the largest oscillation that any stable motion has."""
    largest = max((float(np.max(run[:, OSCILLATION])) for own in found for run, _ in own.runs), default=0.0)
    return [line for case in cases for line in campbell(case, largest, orders)]


def _resonances(own: UnderLoad, lines: list[CampbellLine]) -> Iterator[Span]:
    """Speeds over which every excited resonance bends: from small amplitudes to the peaks that lie on its line."""
    tops = []
    for run, _ in own.runs:
        at = int(np.argmax(run[:, OSCILLATION]))
        tops += [run[at]] if run[at, OSCILLATION] > 2.0 * own.quasi_static else []
    for line in lines:
        if line.excited:
            near = [float(top[OMEGA]) for top in tops if abs(top[OMEGA] / line.at(top[OSCILLATION]) - 1.0) < NEAR]
            yield min([float(line.speed[0]), *near]), max([float(line.speed[0]), *near])


def _unreachable(result: SpeedMap) -> tuple[str, ...]:
    """That no speed meets the limit of the oscillation under any load, in one sentence."""
    limit, slow = result.rules.limit, float(np.max(result.quasi_static))
    load, speed = np.unravel_index(np.argmin(result.oscillation), result.oscillation.shape)
    least = float(result.oscillation[load, speed])
    if limit is None or not limit < least < np.inf or any(map(len, result.allowed)):
        return ()
    return (
        f"The limit of {limit / ARCSEC:.4g} arcsec is met at no speed: the largest motion at each speed of the map "
        f"oscillates by at least {least / ARCSEC:.4g} arcsec, the least at {result.axis.said(result.speeds[speed], 5)} "
        f"with {result.load_text(int(load))}, and by {slow / ARCSEC:.4g} arcsec where the drive turns slowly; "
        "raise the limit, or reduce the excitation.",
    )


def _scatter(
    drives: list[Any], values: Floats, name: str, rows: Sequence[Posture], cells: Floats, span: Span, rules: Rules,
    progress: Callable[[str, float], None],
) -> Scatter | None:  # fmt: skip
    """Quantiles over units, each followed along its main curve; after Ctrl-C over those finished, None without any."""
    results = []
    given: Any = {"load torque": (values, None), "load inertia": (None, values)}.get(name, (None, None, rows))
    with suppress(KeyboardInterrupt):
        for i, drive in enumerate(drives):
            pairs = zip(_loads(drive, span, *given)[2], values, strict=True)
            results.append([_of_unit(case_of(one, load, span), cells, span, rules) for one, load in pairs])
            progress("units", 0.5 + 0.5 * (i + 1.0) / len(drives))
    if not results:
        return None
    table, shares = np.array([[size for size, _ in rows] for rows in results]), np.array(QUANTILES)
    forbidden = np.array([[bad for _, bad in rows] for rows in results], float)
    quantiles = np.quantile(table, shares, axis=0, method="higher")
    return Scatter(shares, quantiles, np.max(table, axis=0), np.mean(forbidden, axis=0), len(results))


def _of_unit(case: Case, cells: Floats, span: Span, rules: Rules) -> tuple[Floats, Any]:
    """Largest oscillation (m,) [rad] of one unit under a load by its main curve, and where it is forbidden."""
    own, _ = under_load(case, span, None, rules=rules)
    lines = [] if rules.margin is None else _lines([case], [own], ())
    return cells_of(own, cells)[0], holds(bands_of(own, rules, span, _resonances(own, lines), 0.0).forbidden, cells)


def _without(rows: Sequence[Posture], project: Project) -> tuple[str, ...]:
    """That postures have no torque of gravity, in one sentence."""
    count, mean = sum(row.torque is None for row in rows), f"{project.mean_load_torque:.4g} N*m"
    return (f"{count} of {len(rows)} postures give no torque of gravity: they have the mean, {mean}",) * bool(count)


def _remarks(
    cases: list[Case], by_load: list[UnderLoad], name: str, lines: list[CampbellLine], span: Span, rules: Rules,
    search: bool,
) -> tuple[str, ...]:  # fmt: skip
    """What a reader must know, each once."""
    remarks = [remark for loaded in by_load if loaded.curves for remark in loaded.remarks]
    if still := ", ".join(f"{loaded.load:g}" for loaded in by_load if not loaded.curves):
        repeats = "" if is_beating(cases[0].equation.error) else " that repeats with every turn"
        remarks.append(f"no stable steady motion{repeats} is known with a {name} of {still}")
    if not search or not all(case.searched for case in cases):
        remarks.append("separate branches (subharmonics) were not searched")
    met = {line.order for line in lines if np.any((line.speed >= span[0]) & (line.speed <= span[1]))}
    if idle := sorted({line.order for line in lines} - met):
        listing = ", ".join(in_turns(order, cases[0].whole) for order in idle)
        remarks.append(f"orders that meet no resonance in this range: {listing}")
    if below := out_of_reach(rules.limit, max(loaded.quasi_static for loaded in by_load), cases[0].train):
        remarks.append(below)
    if any(loaded.loose for loaded in by_load):
        remarks.append("some trajectories settled on motions not followed; speeds beside them count as they do")
    return tuple(dict.fromkeys(remarks))
