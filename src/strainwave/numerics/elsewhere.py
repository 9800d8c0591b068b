"""Motions at the ends of a range that do not join the response curve, and the sentence that tells of them."""

from itertools import groupby
from typing import Any

from .._jit import with_leaf
from ..results import Branch, Floats, Orbit
from .branches import Trace, leaf_of
from .coexisting import Coexisting
from .connected import alike, table_of
from .first_order import FirstOrder
from .fourier import from_blocks
from .half_wave import all_orders
from .orbits import find_orbit

Places = tuple[tuple[float, Floats], ...]


def left_over(problem: Any, found: Trace, others: Coexisting) -> Places:
    """Frequencies and tables of the known orbits through which a curve does not pass."""
    places: list[tuple[float, Floats]] = []
    for value, tables in others.known.items():
        known = [table_of(problem, z) for z in found.points[found.points[:, -1] == value]]
        for table in tables:
            if not any(alike(table, other, problem.turns) for other in known):
                known.append(table)
                places.append((value, table))
    return tuple(places)


def orbits_at(problem: Any, places: Places, branch: Branch) -> list[Orbit]:
    """Orbits from such tables, each with the harmonics that it needs, but for those that are on the branch after all."""
    found: list[Orbit] = []
    leaf = leaf_of(problem.system, "omega")
    for value, table in places:
        system = with_leaf(problem.system, leaf, value)
        orbit = find_orbit(system, guess=_whole(problem, table), period=problem.turns)
        if not orbit.status:
            continue
        x = orbit.coefficients[:, :1]
        known = [c[:, None] for c in branch.coefficients[branch.omega == value]]
        known += [other.coefficients[:, :1] for other in found if other.omega == value]
        if not any(alike(x, other, problem.turns) for other in known):
            found.append(orbit)
    return sorted(found, key=lambda orbit: (orbit.omega, -orbit.peak))


def told(orbits: list[Orbit]) -> list[str]:
    """Sentences on the stable orbits that a curve does not join."""
    said = []
    for omega, some in groupby((orbit for orbit in orbits if orbit.stable), key=lambda orbit: orbit.omega):
        sizes = [f"{orbit.peak:.6g}" for orbit in some]
        many = len(sizes) > 1
        said.append(
            f"at omega = {omega:.6g} rad/s there {'are other stable motions' if many else 'is another stable motion'}, "
            f"max |x| {' and '.join(sizes)}, which {'do' if many else 'does'} not join this curve: parameter_response "
            f"with start={'one of these' if many else 'this orbit'} of `elsewhere` follows it"
        )
    return said


def _whole(problem: Any, table: Floats) -> Floats:
    """Table of the states that `find_orbit` takes: of x = u + e where the problem is one in the torsion u."""
    if isinstance(problem, FirstOrder):
        return table
    error = from_blocks(all_orders(problem, problem.error[None, :])[0])[: len(table), None]
    whole = table.copy()
    whole[: len(error)] += error
    return whole
