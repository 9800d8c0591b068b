"""Decision on the speeds of a drive that are allowed under every load; nothing else decides it.

All stable motions under every load, coexisting ones among them, jumps, the limits of gear and motor, and the stability
of the motor's loop.
"""

import os
from collections.abc import Callable, Sequence
from concurrent.futures import FIRST_EXCEPTION, ThreadPoolExecutor, wait
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ...base.quantities import numbers, positive_count, shown
from ...base.results import Floats, SolveError
from ...base.terminal import silent
from ...drive.drive_response import DriveResponse
from ...drive.postures import LoadCase, Posture, cases_of, refuse_twice, spread
from ...drive.project import Project
from . import under_load as one_load
from .campbell import CampbellLine, lines_of, resonances_of
from .intervals import Span, as_intervals, windows
from .motions import LoadMotions
from .ratings import with_ratings
from .rules import Bands, Rules, bands_of
from .under_load import Case

GOLDEN_RATIO = 0.5 * (5.0**0.5 - 1.0)  # spreads the speeds of the search from load to load
HALVINGS = 4  # of the distance between two torques of which one alone has jumps
TORQUE, INERTIA, POSTURE = "load torque", "load inertia", "posture"  # what the loads are


@dataclass(frozen=True, eq=False)
class Decision:
    """Speeds [rad/s] that a drive may have under its loads, and what decides it.

    Attributes
    ----------
    span : (float, float)
        Range of the speed [rad/s].
    rules : Rules
        What forbids a speed.
    name : str
        What the loads are: torques, inertias or postures.
    loads : (n,) array
        The loads: torques [N*m], inertias [kg*m^2] or numbers.
    load_cases : tuple of LoadCase
        The same as the list of the project has them.
    projects, cases : tuple of Project, tuple of Case
        The project under each of them.
    by_load : tuple of UnderLoad
        All stable motions under each.
    bands, moving : tuple of Bands
        Forbidden and allowed speeds under each; and by the motions alone, without the limits of gear and motor.
    allowed, quiet : (k, 2) array
        Speeds [rad/s] that are allowed under all loads and those between them; and by the motions alone, postures left
        out.
    faults : tuple of str
        That the motor's loop is unstable under a load.
    total : int
        Loads that were asked; after Ctrl-C more than `loads` has.
    """

    span: Span
    rules: Rules
    name: str
    loads: Floats
    load_cases: tuple[LoadCase, ...]
    projects: tuple[Project, ...]
    cases: tuple[Case, ...]
    by_load: tuple[LoadMotions, ...]
    bands: tuple[Bands, ...]
    moving: tuple[Bands, ...]
    allowed: Floats
    quiet: Floats
    faults: tuple[str, ...]
    total: int

    @property
    def of_file(self) -> list[int]:
        """Numbers of the loads that are no posture."""
        return [i for i, case in enumerate(self.load_cases) if case.posture is None]

    def lines(self, orders: tuple[float, ...] = ()) -> list[CampbellLine]:
        """Lines of the Campbell diagram under every load, up to the largest oscillation of any stable motion."""
        return lines_of(self.cases, self.by_load, orders)


def decide(
    project: Project, rules: Rules, span: Span | None = None, *, loads: ArrayLike | None = None,
    load_inertias: ArrayLike | None = None, postures: Sequence[Posture] = (), search: bool = True,
    threads: int | None = None, progress: Callable[[float], None] = silent,
) -> Decision:  # fmt: skip
    """Follow every stable motion of a drive under every load, and apply the rules to them.

    Parameters
    ----------
    project : Project
        The drive; its list of loads counts where none are given.
    rules : Rules
        What forbids a speed, beside the limits of the gear and of the motor.
    span : (float, float), optional
        Range of speeds [rad/s]. Default: that of the project.
    loads, load_inertias, postures
        As of `speed_map`.
    search : bool
        Whether motions apart from the main curve are looked for.
    threads : int, optional
        Default: as many as there are processors.
    progress : callable
        Told the share of the loads that is done.

    Raises
    ------
    ValueError
        If a load is none, or the motor is free and the drive has parts that the error equation leaves out.
    SolveError
        If the law cannot carry a load.
    """
    span = project.speeds.limits if span is None else span
    rules = with_ratings(rules, project, span)
    values, name, of_project, followed = loads_of(project, span, loads, load_inertias, postures)
    variants = under_each(project, name, values, of_project)
    count = positive_count("threads", os.cpu_count() or 1 if threads is None else threads)
    cases = [_case(*each, span) for each in zip(variants, values.tolist(), of_project, strict=True)]
    main_curves = [followed.get(row.torque) if row.posture is None else None for row in of_project]
    computed, by_load = _all_motions(cases, main_curves, span, search, count, rules, progress)
    apart = _search_step(len(cases))
    cases, variants = [cases[i] for i in computed], [variants[i] for i in computed]
    lines = [] if rules.margin is None else lines_of(cases, by_load, ())
    alone = replace(rules, speed=None, motor_torque=None, sheet=None, gear_torque=None, mean_torque=None)
    pairs = list(zip(variants, by_load, strict=True))
    bands = [_bands(*pair, rules, span, lines, apart) for pair in pairs]
    moving = [_bands(*pair, alone, span, lines, apart) for pair in pairs]
    rows = tuple(of_project[i] for i in computed)
    joined = [a.posture is None and b.posture is None for a, b in pairwise(rows)]
    allowed = windows([one.forbidden for one in bands], span, joined)
    quiet_bands = [one.forbidden for one, row in zip(moving, rows, strict=True) if row.posture is None]
    quiet = windows(quiet_bands, span, [True] * (len(quiet_bands) - 1))
    faults = dict.fromkeys(one.loop_fault for one in variants if one.loop_fault)
    return Decision(
        span=span, rules=rules, name=name, loads=values[computed], load_cases=rows, projects=tuple(variants),
        cases=tuple(cases), by_load=tuple(by_load), bands=tuple(bands), moving=tuple(moving), allowed=allowed,
        quiet=quiet, faults=tuple(faults), total=len(values),
    )  # fmt: skip


def _case(variant: Project, value: float, row: LoadCase, span: Span) -> Case:
    try:
        return one_load.case_of(variant, value, span)
    except SolveError as error:
        raise SolveError(f"{row.name}: {error}") from None


def _bands(
    variant: Project, one: LoadMotions, rules: Rules, span: Span, lines: list[CampbellLine], apart: float
) -> Bands:  # fmt: skip
    if variant.loop_fault:
        return Bands(as_intervals([span]), as_intervals([]))
    return bands_of(one, rules, span, resonances_of(one, [line for line in lines if line.load == one.load]), apart)


def loads_of(
    project: Project, span: Span, loads: ArrayLike | None = None, load_inertias: ArrayLike | None = None,
    postures: Sequence[Posture] = (),
) -> tuple[Floats, str, tuple[LoadCase, ...], dict[float, DriveResponse | None]]:  # fmt: skip
    """Loads (n,), what they are, the same as load cases, and curves that are known of torques [N*m].

    Of a project with postures the loads are numbers from 1 on.
    """
    arguments = ("loads", loads), ("load_inertias", load_inertias), ("postures", postures or None)
    given = [name for name, value in arguments if value is not None]
    if given[1:]:
        raise ValueError(f"{' and '.join(given[:2])} are both given; give one of them")
    if postures:
        refuse_twice(postures)
        rows = cases_of(replace(project, postures=tuple(postures)), ())
        return np.arange(1.0, len(rows) + 1.0), POSTURE, rows, {}
    if load_inertias is not None:
        values = np.unique(numbers("load_inertias [kg*m^2]", load_inertias))
        if not values[0] > 0.0:
            raise ValueError(f"load_inertias are {shown(load_inertias)}; inertias must be positive")
        torque = project.mean_load_torque
        return values, INERTIA, tuple(LoadCase(f"{J:.4g} kg*m^2", J, torque) for J in values.tolist()), {}
    if loads is not None:
        values = np.unique(numbers("loads [N*m]", loads))
        return values, TORQUE, cases_of(replace(project, postures=()), values.tolist()), {}
    curves = with_ends_of_jumps(project, span)
    rows = cases_of(project, sorted(curves))
    if project.postures:
        return np.arange(1.0, len(rows) + 1.0), POSTURE, rows, curves
    return np.array([row.torque for row in rows]), TORQUE, rows, curves


def under_each(project: Project, name: str, values: Floats, rows: Sequence[LoadCase]) -> list[Project]:
    """The project under each load."""
    if name == INERTIA:
        loaded = project.under(project.mean_load_torque)
        return [loaded.with_load_inertia(J) for J in values.tolist()]
    return [row.on(project) for row in rows]


def with_ends_of_jumps(project: Project, span: Span) -> dict[float, DriveResponse | None]:
    """Torques [N*m] of the load's range with their curves, and more torques where jumps begin or end between two.

    Jumps come into the span from beside it, torque by torque: those of the project's speeds count. A torque has no
    curve where the law cannot carry it, where the curve is one of wider speeds, and where nothing is added: curves with
    memory, and those beside which no other motions are looked for, take too long.
    """
    torques = spread(project)
    if len(torques) == 1 or project.has_memory or not one_load.is_searched(project.system(reduced=True)):
        return dict.fromkeys(torques)
    low, high = project.speeds.limits
    wide = min(low, span[0]), max(high, span[1])

    def curve(torque: float) -> DriveResponse | None:
        with suppress(SolveError):
            return one_load.main_curve(one_load.case_of(project.under(torque), torque, wide), wide)
        return None

    curves = {torque: curve(torque) for torque in torques}
    for _ in range(HALVINGS):
        for a, b in pairwise(sorted(curves)):
            if _jumps(curves[a]) != _jumps(curves[b]):
                curves[0.5 * (a + b)] = curve(0.5 * (a + b))
    return curves if wide == span else dict.fromkeys(curves)


def _jumps(curve: DriveResponse | None) -> bool:
    """True for a curve on which a slow run-up or run-down jumps."""
    return curve is not None and curve.sweep is not None and bool(curve.sweep.jumping)


def _search_step(loads: int) -> float:
    """Relative distance of the speeds of the search: up to twice as large where neighbouring loads have others."""
    return one_load.SPEED_STEP * min(2.0, max(1.0, 0.25 * loads))


def _all_motions(
    cases: list[Case], main_curves: list[DriveResponse | None], span: Span, search: bool, threads: int, rules: Rules,
    progress: Callable[[float], None],
) -> tuple[list[int], list[LoadMotions]]:  # fmt: skip
    """Numbers of the loads, and the motions under each; after Ctrl-C of those that were finished.

    Of `main_curves`, those that are None are still to be computed. Motions apart from them are tried under the
    neighbouring loads too.
    """
    apart = _search_step(len(cases)) if search else None
    by_load: dict[int, LoadMotions] = {}
    seeds: dict[int, Any] = {}

    def follow(i: int) -> None:
        loaded, seeds[i] = one_load.under_load(cases[i], span, apart, (GOLDEN_RATIO * i) % 1.0, rules, main_curves[i])
        by_load[i] = loaded
        progress(len(by_load) / len(cases))

    with ThreadPoolExecutor(threads) as pool:  # the first compiles, where that is still to do, before threads start
        left: set[Any] = set()
        try:
            follow(0)
            left = {pool.submit(follow, i) for i in range(1, len(cases))}
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
    for order in (computed, computed[::-1]):
        for before, after in pairwise(order):
            if tried := one_load.seeds_for(seeds[before], by_load[before], by_load[after]):
                by_load[after], new = one_load.with_search_result(
                    by_load[after], cases[after], span, np.empty(0), tried
                )
                seeds[after] = (*seeds[after], *new)
    return computed, [by_load[i] for i in computed]
