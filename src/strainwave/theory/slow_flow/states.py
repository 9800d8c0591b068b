"""Every steady state at many speeds at once.

First order of a cubic law, and second order of a square and a cube under a line on the fast angle alone, are
polynomials in |z|^2: all their roots are found at once. Without hard lines the rate is z g(|z|) - push whatever the law
is: g is tabulated over |z| at a few speeds, and |z g| - |push| changes its sign at every state. With hard lines each
speed is searched by itself, in a scan of the plane. Newton's method in the flow moves what was found onto the states.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from ...base.results import Complexes, Floats, SolveError
from ...base.sentences import Sentence, Speed
from ...numerics.roots import positive_roots
from .averages.memory import remembers
from .averages.varying import varies
from .closed_forms import CubicFlow
from .fixed_points import RING, ROWS_PER_DECADE, Flow, amplitudes, attracts, is_stable, is_trivial, newton_step, scan
from .second_order import Forms, SecondOrderFlow

SPEEDS_AT_ONCE = 2000  # what they take fits the memory, and a user can interrupt between
GRID_SPEEDS = 8  # speeds of one polar grid
TABLE_SPEEDS = 33  # speeds at which g is tabulated
NEWTON_STEPS = 40  # steps of Newton's method at most
IDLE_STEPS = 8  # steps in a row that get no shorter: the search wanders and ends
LONGEST_STEP = 0.5  # of |z|: a longer step of Newton's method is cut to it
SHORT_STEP, LEAST_STEP = 1e-9, 1e-14  # of |z|: the last that may get no shorter, and the last of all
STATE_STEP = 1e-7  # of |z|: the shortest step at a state is no longer
ROUNDINGS, ROUNDING_STEP = 8.0, 1e-3  # of the hard lines over |z|, which lengthen that step; at most
SAME_DISTANCE = 1e-7  # of |z|: two states at most so far apart are one
SAME_START = 1e-6  # of |z|: the same of starts in few samples
CELL_PARTS = 16  # parts of a cell of the table that may hold a state
HIDDEN_RISE = 2.0  # of the change from row to row: so near to 0 an extremum of |z g| - |push| may hide two states
CLEAR_SHARE = 0.3  # share of the distance to the next fixed point within which a transient is taken to end on one
STILL_RATE = 1e-6  # rates relative to omega_0 |z| that vanish
STILL_STARTS = 60  # starts with such rates of an undamped flow; more are a continuum
EPSILON = float(np.finfo(float).eps)
Found = tuple[Any, Complexes]  # places among the speeds, and states there


@dataclass(frozen=True, eq=False)
class States:
    """Steady states at speeds.

    Attributes
    ----------
    z : (rows, speeds) complex array
        a exp(-i phase) [rad] by descending amplitude; not finite where there are fewer.
    stable : (rows, speeds) bool array
        Stability of each.
    """

    z: Complexes
    stable: Any


@dataclass(frozen=True, eq=False)
class Table:
    """Part of the law in g [1/s] beside `linear`, (amplitudes, speeds), over amplitudes [rad] and speeds [rad/s]."""

    amplitude: Floats
    omega: Floats
    pull: Complexes

    def at(self, omega: Floats) -> Complexes:
        """Interpolate to other speeds; the nodes are these speeds, or lie at equal distances."""
        if len(self.omega) == 1:
            return np.repeat(self.pull, len(omega), axis=1)
        i = np.clip(np.searchsorted(self.omega, omega) - 1, 0, len(self.omega) - 2)
        share = (omega - self.omega[i]) / (self.omega[i + 1] - self.omega[i])
        return _between(self.pull.T, i, slice(None), share[:, None]).T


def states(flow: Flow, omega: Floats) -> States:
    """All steady states at speeds (n,) [rad/s]; a = 0 where it is one."""
    search = None if remembers(flow.setting.system.law) else _search(flow, omega)
    parts: list[Any] = []
    for i in range(0, len(omega), SPEEDS_AT_ONCE):
        part = omega[i : i + SPEEDS_AT_ONCE]
        moving = _solved_speed_by_speed(flow, part) if search is None else _solved(flow.at(part), search)
        parts += [(places + i, z, stable) for places, z, stable in (moving, _resting(flow, part))]
    places, z, stable = map(np.concatenate, zip(*parts, strict=True))
    order, count = np.lexsort((-np.abs(z), places)), len(omega)
    places, z, stable = places[order], z[order], stable[order]
    return States(_padded(places, count, z, np.nan), _padded(places, count, stable, False))


def polished(flow: Flow, z: Complexes) -> Complexes:
    """Newton's method from a state [rad] at each speed of a flow; not finite where none is met."""
    best, size, going = np.full(len(z), np.nan + 0j), np.full(len(z), np.inf), np.arange(len(z))
    idle = np.zeros(len(z), int)  # steps since the shortest one: a state that wanders meets none
    with np.errstate(all="ignore"):
        for _ in range(NEWTON_STEPS):
            rate, matrix = _at_speeds(flow, going).balance(z)
            step = newton_step(matrix, rate)
            length = np.abs(step) / np.abs(z)
            nearer = length < size[going]
            best[going[nearer]], size[going[nearer]] = z[nearer], length[nearer]
            idle[going] = np.where(nearer, 0, idle[going] + 1)
            improves = nearer | (size[going] > SHORT_STEP)
            keep = np.isfinite(length) & improves & (length > LEAST_STEP) & (idle[going] < IDLE_STEPS)
            z = (z + step * np.minimum(1.0, LONGEST_STEP / length))[keep]
            going = going[keep]
            if not len(going):
                break
    # a small z keeps the rounding of hard lines, in sums whose order is that of the processor
    rounding = ROUNDINGS * EPSILON * np.sum(np.abs(flow.setting.hard), axis=-1) / np.abs(best)
    return np.where(size <= np.maximum(STATE_STEP, np.minimum(rounding, ROUNDING_STEP)), best, np.nan)


def fixed_points(flow: Flow) -> list[complex]:
    """All nontrivial states [rad] of a flow at its one speed by descending |z|; copies by whole periods count once."""
    return sorted(_solved_at_one_speed(flow)[0].tolist(), key=abs, reverse=True)


def attractor(flow: Flow, z: complex) -> complex | None:
    """Stable fixed point [rad] next to z, copies included; None unless it is much nearer than any other."""
    s = flow.setting
    if s.resonance.ratio is None:
        return 0j if s.mu > 0.0 else None
    copies = np.exp(2j * np.pi * np.arange(s.copies) / s.copies)
    points = [complex(point * copy) for point in fixed_points(flow) for copy in copies]
    points += [0j] if is_trivial(flow) else []
    points.sort(key=lambda point: abs(point - z))
    if not points or (len(points) > 1 and abs(points[0] - z) > CLEAR_SHARE * abs(points[1] - z)):
        return None
    return points[0] if is_stable(flow, points[0]) else None


def _solved_at_one_speed(flow: Flow) -> tuple[Complexes, Any]:
    """Nontrivial states of a flow at its one speed, and whether they attract."""
    if flow.setting.resonance.ratio is None:
        return np.zeros(0, complex), np.zeros(0, bool)
    search = _search(flow, np.array([flow.setting.omega]))
    return _solved(flow, _by_scan if search in (None, _by_grid) else search)[1:]


def _search(flow: Flow, omega: Floats) -> Callable[[Any], Found] | None:
    """First search for states at many speeds at once; None where each speed is searched by itself."""
    s = flow.setting
    if _is_polynomial(flow):
        return _by_polynomial
    if not (np.any(s.hard) or varies(s.system)):
        return partial(_by_table, table=_table(flow, omega))
    if isinstance(flow, SecondOrderFlow) and s.resonance.ratio is not None and not remembers(s.system.law):
        return _by_grid
    return None


def _solved(flow: Flow, search: Callable[[Any], Found]) -> tuple[Any, Complexes, Any]:
    """Nontrivial states of a flow at its speeds: their places, the states, whether they attract."""
    places, z = search(flow)
    if isinstance(flow, SecondOrderFlow) and flow.rough is not flow.force:  # its coarse flow has fewer samples
        places, z = _distinct(flow, *_moved_coarsely(flow, places, z))
    places, z = _distinct(flow, *_moved_finely(flow, places, z))
    return places, z, attracts(_at_speeds(flow, places).stability(z))


def _at_speeds(flow: Any, places: Any) -> Any:
    """The flow at its speeds in these places."""
    return replace(flow, setting=flow.setting.of(places))


def _moved_coarsely(flow: Any, places: Any, z: Complexes) -> Found:
    """Starts moved to the states of the coarse flow; one that leads to none stays, but for a law with memory.

    Few samples of a kink may keep a state from being met.
    """
    moved = polished(_at_speeds(flow, places).coarse, z)
    led = np.isfinite(moved)
    kept = led | (not remembers(flow.setting.system.law))
    return places[kept], np.where(led, moved, z)[kept]


def _moved_finely(flow: Flow, places: Any, z: Complexes) -> Found:
    """States to which starts lead, where the flow is sound."""
    local = _at_speeds(flow, places)
    z = polished(local, z)
    with np.errstate(all="ignore"):
        sound = np.isfinite(z) & local.sound(z)
    return places[sound], z[sound]


def _distinct(flow: Flow, places: Any, z: Complexes) -> Found:
    """Places and states without those that are among the others; of copies by whole periods one."""
    s = flow.setting
    turns = np.exp(2j * np.pi * np.arange(s.copies) / s.copies)[:, None]
    copies = z * turns
    key = np.round(np.abs(np.angle(copies)), 9) - 1e-10 * np.sign(copies.imag)
    z = copies[np.argmin(key, axis=0), np.arange(len(z))]
    order = np.argsort(places, kind="stable")
    rows = _padded(places[order], np.size(s.omega), z[order], np.nan)
    for i, row in enumerate(rows):
        for former in rows[:i]:
            with np.errstate(all="ignore"):
                row[np.any(np.abs(row * turns - former) < SAME_DISTANCE * np.abs(former), axis=0)] = np.nan
    _, places = np.nonzero(np.isfinite(rows))
    return places, rows[np.isfinite(rows)]


def _solved_speed_by_speed(flow: Flow, omega: Floats) -> tuple[Any, Complexes, Any]:
    """Nontrivial states of a flow that each speed is searched for by itself."""
    z, attract = zip(*(_solved_at_one_speed(flow.at(w)) for w in omega.tolist()), strict=True)
    return np.repeat(np.arange(len(z)), list(map(len, z))), np.concatenate(z), np.concatenate(attract)


def _resting(flow: Flow, omega: Floats) -> tuple[Any, Complexes, Any]:
    """States with a = 0."""
    pushed = flow.setting.at(float(omega[0])).soft != 0.0
    resting = [(i, one) for i, w in enumerate(omega.tolist()) if not pushed and is_trivial(one := flow.at(w))]
    attract = [is_stable(one, 0j) for _, one in resting]
    return np.array([i for i, _ in resting], int), np.zeros(len(resting), complex), np.array(attract, bool)


def _padded(index: Any, count: int, values: Any, filler: Any) -> Any:
    """Table (rows, count) of values whose places, rising, are `index`."""
    row = np.arange(len(index)) - np.searchsorted(index, index)
    table = np.full((int(np.max(row, initial=-1)) + 1 or 1, count), filler, values.dtype)
    table[row, index] = values
    return table


def _is_polynomial(flow: Flow) -> bool:
    """True for a flow whose steady states are roots of a polynomial in |z|^2."""
    if not isinstance(flow, SecondOrderFlow):
        return isinstance(flow, CubicFlow)
    return isinstance(flow.force, Forms) and flow.force.primary(flow.setting) is not None


def _by_polynomial(flow: Any) -> Found:
    """States as the roots of a polynomial in |z|^2."""
    s = flow.setting
    if isinstance(flow, CubicFlow):
        z = flow.fixed_points()
    else:
        # (linear + by_one |z|^2 + by_two |z|^4) z = soft: its square is a polynomial of |z|^2 of degree 5
        linear = s.omega_0**2 - s.fast**2 + 1j * s.mu * s.fast
        by_one, by_two = flow.force.primary(s)

        def product(a: Any, b: Any) -> Any:
            return (a * np.conj(b)).real

        square = positive_roots(
            product(by_two, by_two), 2.0 * product(by_one, by_two),
            product(by_one, by_one) + 2.0 * product(linear, by_two), 2.0 * product(linear, by_one),
            product(linear, linear), -product(s.soft, s.soft),
        )  # fmt: skip
        with np.errstate(all="ignore"):
            direction = s.soft / (linear + (by_one + by_two * square) * square)
            z = np.sqrt(square) * direction / np.abs(direction)
    z = z.reshape(len(z), np.size(s.omega))
    _, places = np.nonzero(np.isfinite(z))
    return places, z[np.isfinite(z)]


def _table(flow: Any, omega: Floats) -> Table:
    """Tabulate g over the amplitudes that matter, at every speed or at `TABLE_SPEEDS` of them."""
    lo, hi = float(np.min(omega)), float(np.max(omega))
    nodes = np.unique(omega) if len(np.unique(omega)) <= TABLE_SPEEDS else np.linspace(lo, hi, TABLE_SPEEDS)
    ends = [amplitudes(flow.at(w).coarse, RING) for w in {lo, 0.5 * (lo + hi), hi}]
    low, high = min(a[0] for a in ends), max(a[-1] for a in ends)
    a = np.geomspace(low, high, int(np.ceil(RING * np.log10(high / low))))
    each = [flow.coarse.at(float(w)) for w in nodes]
    with np.errstate(all="ignore"):
        pull = np.stack([one.unforced(a.astype(complex)) / a - one.linear for one in each], axis=1)
    return Table(a, nodes, pull)


def _by_table(many: Any, table: Table) -> Found:
    """Starts where |z g| - |push| changes its sign, in cells of the table and in finer ones inside them."""
    a, (omega, linear, soft) = np.log(table.amplitude), map(np.atleast_1d, (many.setting.omega, many.linear, many.push))
    push = np.abs(soft)
    with np.errstate(all="ignore"):
        pull = table.at(omega)
        cells, at_speed = _near_zero(np.abs(linear + pull) * np.exp(a)[:, None] - push)
        parts = np.linspace(0.0, 1.0, CELL_PARTS + 1)[:, None]
        g = linear[at_speed] + _between(pull, cells, at_speed, parts)
        size = a[cells] + parts * (a[cells + 1] - a[cells])
        value = np.abs(g) * np.exp(size) - push[at_speed]
        row, j = _near_zero(value)
        zero = value[row, j] / (value[row, j] - value[row + 1, j])  # its place in a part, from 0 to 1
        zero = np.where((zero >= 0.0) & (zero <= 1.0), zero, 0.5)
        start = np.exp(size[row, j] * (1.0 - zero) + size[row + 1, j] * zero)
        direction = soft[at_speed[j]] / (g[row, j] * (1.0 - zero) + g[row + 1, j] * zero)
        z = start * direction / np.abs(direction)  # z g = push in a state
    finite = np.isfinite(z)
    return at_speed[j][finite], z[finite]


def _by_grid(flow: SecondOrderFlow) -> Found:
    """Starts in the cells of a polar grid in which both rates may vanish, for a few speeds at once."""
    rough = flow.coarse
    with np.errstate(all="ignore"):  # and the one of a nearly linear drive
        weak = newton_step(*reversed(flow.balance(np.zeros(np.shape(flow.setting.omega), complex))))
    linear = np.flatnonzero(np.isfinite(weak) & (flow.setting.soft != 0.0))
    places, z = [linear], [weak[linear]]
    order = np.argsort(np.abs(flow.setting.hard).sum(axis=-1), kind="stable")  # alike in the amplitudes that matter
    for chunk in np.array_split(order, -(-len(order) // GRID_SPEEDS)):
        local_flows = (_at_speeds(rough, int(i)) for i in chunk)
        ends = [a[[0, -1]] for a in (amplitudes(local, ROWS_PER_DECADE) for local in local_flows)]
        low, high = np.min(ends), np.max(ends)
        a = np.geomspace(low, high, math.ceil(ROWS_PER_DECADE * math.log10(high / low)))
        rows, starts = scan(_at_speeds(rough, chunk), a)
        places, z = [*places, chunk[rows]], [*z, starts]
    return np.concatenate(places), np.concatenate(z)


def _by_scan(flow: Any) -> Found:
    """Starts at one speed where the phase matters: in few samples, and the one of a nearly linear drive."""
    rough, s = flow.coarse, flow.setting
    starts = scan(rough, amplitudes(rough, ROWS_PER_DECADE))[1]
    still = np.abs(rough.balance(starts)[0]) < STILL_RATE * s.omega_0 * np.abs(starts)
    if s.mu == 0.0 and np.count_nonzero(still) > STILL_STARTS:
        raise SolveError(
            Sentence(
                "without damping every small amplitude is a steady state at omega = {}; give the drive damping, or go "
                "to another speed",
                Speed(s.omega),
            )
        )
    z = list[complex]()
    for point in polished(rough, starts).tolist():
        if np.isfinite(point) and all(abs(point - other) > SAME_START * abs(other) for other in z):
            z.append(point)
    # whose amplitude may lie below all that is scan
    weak = complex(newton_step(flow.jacobian(0j), np.array(complex(flow.rates(0j)))))
    z += [] if is_trivial(flow) or not np.isfinite(weak) else [weak]
    return np.zeros(len(z), int), np.array(z, complex)


def _near_zero(value: Floats) -> tuple[Any, Any]:
    """Rows and columns of what changes its sign to the next row, and of both sides of an extremum that may hide two."""
    rise = np.diff(value, axis=0)
    crossed = value[1:] * value[:-1] <= 0.0
    steep = np.maximum(np.abs(rise[1:]), np.abs(rise[:-1]))
    turns = (rise[1:] * rise[:-1] <= 0.0) & (np.abs(value[1:-1]) < HIDDEN_RISE * steep)
    crossed[:-1] |= turns
    crossed[1:] |= turns
    row, column = np.nonzero(crossed)
    return row, column


def _between(pull: Complexes, row: Any, column: Any, share: Floats) -> Complexes:
    """Cubic through four rows (Catmull & Rom), at shares of the way from a row to the next."""
    rows = np.clip(row + np.array([[-1], [0], [1], [2]]), 0, len(pull) - 1)
    before, left, right, after = pull[rows, column]
    bend, turn = 2.0 * before - 5.0 * left + 4.0 * right - after, 3.0 * (left - right) + after - before
    return np.asarray(left + 0.5 * share * (right - before + share * (bend + share * turn)))
