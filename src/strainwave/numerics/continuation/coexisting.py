"""Orbits that coexist at one base frequency, from one number of harmonics to the next; `connected` looks for them."""

from ...base.branch_labels import END
from ...base.protocols import Balance
from ...base.results import Floats
from ..balance.harmonics import SEARCH_PER_TURN
from .connected import alike, connected
from .trace import Trace, points_at


class Coexisting:
    """Orbits known at some base frequencies, carried from one number of harmonics to the next.

    Attributes
    ----------
    known : dict of float to list of (2H+1, states) arrays
        Tables of coefficients by frequency, of the torsion for a `SecondOrder` problem.
    begun : bool
        Whether other orbits than those of the branch are searched for.
    searched, alone, unfinished : set of float
        Frequencies of a search; those at which one orbit is all there can be; those whose search was cut short.
    apart : list of (2H+1, states) arrays
        Tables of `known` to which the branch has no way.
    """

    def __init__(self) -> None:
        self.known: dict[float, list[Floats]] = {}
        self.searched: set[float] = set()
        self.alone: set[float] = set()
        self.begun = False
        self.unfinished: set[float] = set()
        self.apart: list[Floats] = []

    def begin(self, problem: Balance, curve: Trace) -> bool:
        """Begin to search, if it has not begun and other orbits may exist at an end of a curve; whether it begins."""
        if self.begun or not len(curve.points):
            return False
        self.begun = True
        ends = curve.points[[0, -1]]
        may = problem.several_at(ends)
        self.alone = {*ends[~may, -1].tolist()} - {*ends[may, -1].tolist()}
        return bool(may.any()) or curve.outcome != END

    def guesses(self, problem: Balance, value: float, points: Floats) -> list[Floats]:
        """Guesses at a frequency for orbits beside those of a branch; searched for once, where there may be any."""
        if self.begun and value not in self.searched and value not in self.alone:
            self.searched.add(value)
            search = connected(problem, value, points_at(points, value)[:1])
            self.known.setdefault(value, []).extend(search.tables)
            if not search.complete:
                self.unfinished.add(value)
        tables = [table for table in self.known.get(value, []) if not any(table is other for other in self.apart)]
        some = [problem.fitted(table, value) for table in tables]
        return [point for point in some if point is not None]

    def note(self, problem: Balance, points: list[Floats]) -> None:
        """Keep orbits that were found by the way."""
        for point in points:
            self.known.setdefault(float(point[-1]), []).append(problem.table(point))

    def give_up(self, problem: Balance, points: list[Floats]) -> None:
        """Look no more for a way to orbits to which none was found with harmonics enough; they remain known."""
        if problem.turns * SEARCH_PER_TURN > problem.highest():
            return
        for point in points:
            table = problem.table(point)
            self.apart += [other for other in self.known[float(point[-1])] if alike(table, other, problem.turns)]
