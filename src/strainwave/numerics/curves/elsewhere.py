"""Motions at the ends of a range that do not join the response curve, and the sentence that tells of them."""

from dataclasses import replace as with_changes
from itertools import groupby

from ...protocols import Balance
from ...results import Branch, Floats, Orbit
from ...sentences import Sentence, Speed
from ...tree import leaf_of, with_leaf
from ..continuation.coexisting import Coexisting
from ..continuation.connected import alike
from ..continuation.trace import Trace
from ..orbits.find_orbit import find_orbit

CUT_SHORT = "the search for other motions was cut short, and there may be more than are listed here: "
FROM_STARTS = "isolas with resonance=PRIMARY looks for them from random starts"
BY_HAND = "simulate from other states shows them"

Places = tuple[tuple[float, Floats], ...]


def with_left_over(problem: Balance, found: Trace, others: Coexisting) -> Trace:
    """The trace of a curve with the frequencies and tables of the known orbits through which it does not pass."""
    places: list[tuple[float, Floats]] = []
    for value, tables in others.known.items():
        known = [problem.table(z) for z in found.points[found.points[:, -1] == value]]
        for table in tables:
            if not any(alike(table, other, problem.turns) for other in known):
                known.append(table)
                places.append((value, table))
    if others.unfinished:
        remedy = FROM_STARTS if problem.hill() else BY_HAND
        message = Sentence("{}; at omega = {} {}", found.message, Speed(*sorted(others.unfinished)), CUT_SHORT + remedy)
        found = with_changes(found, message=message)
    return with_changes(found, elsewhere=tuple(places)) if places else found


def with_others(problem: Balance, branch: Branch, places: Places, said: list[str], followed: str = "") -> Branch:
    """The branch with the orbits at the ends of its range that it does not pass, and with what there is to say.

    `followed` says at the end of the sentence on an orbit how it is followed.
    """
    elsewhere = orbits_at(problem, places, branch) if places else []
    said = [branch.message, *told(elsewhere, followed), *said]
    return with_changes(branch, message=Sentence("; ").join(said), elsewhere=elsewhere) if len(said) > 1 else branch


def orbits_at(problem: Balance, places: Places, branch: Branch) -> list[Orbit]:
    """Orbits from such tables, with the harmonics that they need, but for those that are on the branch after all."""
    found: list[Orbit] = []
    leaf = leaf_of(problem.system, "omega")
    for value, table in places:
        system = with_leaf(problem.system, leaf, value)
        orbit = find_orbit(system, guess=problem.whole(table), period=int(problem.turns))
        if not orbit.status.found:
            continue
        x = orbit.coefficients[:, :1]
        known = [c[:, None] for c in branch.coefficients[branch.omega == value]]
        known += [other.coefficients[:, :1] for other in found if other.omega == value]
        if not any(alike(x, other, problem.turns) for other in known):
            found.append(orbit)
    return sorted(found, key=lambda orbit: (orbit.omega, -orbit.peak))


def told(orbits: list[Orbit], followed: str) -> list[str]:
    """Sentences on the stable orbits that a curve does not join."""
    said: list[str] = []
    for omega, some in groupby((orbit for orbit in orbits if orbit.stable), key=lambda orbit: orbit.omega):
        sizes = [f"{orbit.peak:.6g}" for orbit in some]
        there = "is another stable motion" if len(sizes) == 1 else "are other stable motions"
        join = "does not join" if len(sizes) == 1 else "do not join"
        size = f"max |x| {' and '.join(sizes)}"
        said.append(Sentence(f"at omega = {{}} there {there}, {size}, which {join} this curve{followed}", Speed(omega)))
    return said
