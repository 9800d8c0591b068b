"""Motions at the ends of a range that do not join its response curve, and sentences on what not to trust in a curve."""

from dataclasses import replace as with_changes
from itertools import groupby

import numpy as np

from ...base.protocols import Balance
from ...base.results import GROWS, Branch, Floats, Orbit
from ...base.sentences import Sentence, Speed
from ...compile.tree import leaf_of, with_leaf
from ..balanced_orbit import find_orbit
from ..continuation.coexisting import Coexisting
from ..continuation.connected import alike
from ..continuation.trace import Trace

FOLLOWED = ": parameter_response with its orbit in `elsewhere` as start follows it"
NEVER_STABLE = "no point of it is stable"
NEUTRAL = "without damping no point of it attracts"
CUT_SHORT = "the search for other motions was cut short, and there may be more than are listed here: "
FROM_STARTS = "isolas with resonance=PRIMARY looks for them from random starts"
BY_HAND = "simulate from other states shows them"

Places = tuple[tuple[float, Floats], ...]


def with_all_said(problem: Balance, branch: Branch, curve: Trace) -> Branch:
    """The branch of a trace with the orbits that it does not pass, and all that there is to say."""
    return with_others(problem, branch, curve.elsewhere, remarks(problem, curve, branch), FOLLOWED)


def with_left_over(problem: Balance, curve: Trace, pool: Coexisting) -> Trace:
    """The trace of a curve with the frequencies and tables of the known orbits through which it does not pass."""
    places: list[tuple[float, Floats]] = []
    for value, tables in pool.known.items():
        tables_there = [problem.table(z) for z in curve.points[curve.points[:, -1] == value]]
        for table in tables:
            if not any(alike(table, former, problem.turns) for former in tables_there):
                tables_there.append(table)
                places.append((value, table))
    if pool.unfinished:
        remedy = FROM_STARTS if problem.hill() else BY_HAND
        message = Sentence("{}; at omega = {} {}", curve.message, Speed(*sorted(pool.unfinished)), CUT_SHORT + remedy)
        curve = with_changes(curve, message=message)
    return with_changes(curve, elsewhere=tuple(places)) if places else curve


def with_others(problem: Balance, branch: Branch, places: Places, texts: list[str], followed: str = "") -> Branch:
    """The branch with the orbits at the ends of its range that it does not pass, and with what there is to say.

    `followed` says at the end of the sentence on an orbit how it is followed.
    """
    elsewhere = orbits_at(problem, places, branch) if places else []
    texts = [branch.message, *other_motions(elsewhere, followed), *texts]
    return with_changes(branch, message=Sentence("; ").join(texts), elsewhere=elsewhere) if len(texts) > 1 else branch


def orbits_at(problem: Balance, places: Places, branch: Branch) -> list[Orbit]:
    """Orbits from such tables, with the harmonics that they need, but for those that are on the branch after all."""
    orbits: list[Orbit] = []
    leaf = leaf_of(problem.system, "omega")
    for value, table in places:
        system = with_leaf(problem.system, leaf, value)
        orbit = find_orbit(system, guess=problem.state_table(table), period=int(problem.turns))
        if not orbit.status.found:
            continue
        x = orbit.coefficients[:, :1]
        tables_there = [c[:, None] for c in branch.coefficients[branch.omega == value]]
        tables_there += [former.coefficients[:, :1] for former in orbits if former.omega == value]
        if not any(alike(x, former, problem.turns) for former in tables_there):
            orbits.append(orbit)
    return sorted(orbits, key=lambda orbit: (orbit.omega, -orbit.peak))


def other_motions(orbits: list[Orbit], followed: str) -> list[str]:
    """Sentences on the stable orbits that a curve does not join."""
    texts: list[str] = []
    for omega, group in groupby((orbit for orbit in orbits if orbit.stable), key=lambda orbit: orbit.omega):
        sizes = [f"{orbit.peak:.6g}" for orbit in group]
        verb = "is another stable motion" if len(sizes) == 1 else "are other stable motions"
        join = "does not join" if len(sizes) == 1 else "do not join"
        size = f"max |x| {' and '.join(sizes)}"
        texts.append(Sentence(f"at omega = {{}} there {verb}, {size}, which {join} this curve{followed}", Speed(omega)))
    return texts


def remarks(problem: Balance, curve: Trace, branch: Branch) -> list[str]:
    """List what to know about a response curve."""
    texts: list[str] = []
    if len(branch) and not branch.stable.any():
        texts.append(NEUTRAL if np.min(np.abs(branch.multipliers[:, 0])) < GROWS else NEVER_STABLE)
    loose = curve.points[problem.floating(curve.points), -1]
    if len(loose):
        texts.append(
            Sentence(
                "at omega = {} the law gives no torque and any mean is in balance (the middle is shown): a mean torque "
                "would place it",
                Speed(np.min(loose), np.max(loose), between=" .. "),
            )
        )
    return texts
