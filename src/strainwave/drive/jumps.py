"""`jumps`: what a slow run-up and run-down do on a response curve: where they jump, onto what, and the hysteresis.

The drive follows stable orbits. Where they end at a fold it jumps onto another stable orbit of the curve at the same
frequency; where several wait there, the basins of attraction decide, and the nearest in size is taken and named so.

Bands of hysteresis between a slow run-up and run-down, each with its own pair of jumps.
"""

from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any, ClassVar, NamedTuple

import numpy as np

from ..base.records import Labelled, Result
from ..base.results import Booleans, Branch, Integers, Orbit
from ..base.terminal import on_screen

SEAM = 1e-6  # relative difference of two pieces of a curve in value and in size that are one motion where they meet


@dataclass(frozen=True)
class Jump:
    """One jump of a sweep: the frequency (or other parameter) and the largest |x| before and after; why it happens."""

    value: float
    before: float
    after: float
    cause: str
    choices: int


@dataclass(frozen=True)
class HysteresisBand:
    """A band in which a slow run-up and run-down are on different motions.

    Attributes
    ----------
    low, high : float
        Its ends: where the run-down jumps out of it, and where the run-up does. Where the band goes on beyond the range
        of the branch, or the other sweep finds no stable motion, there is no jump at that end.
    on_run_up, on_run_down : tuple of Jump
        The jumps of each sweep in the band and at its ends, in order.
    """

    low: float
    high: float
    on_run_up: tuple[Jump, ...]
    on_run_down: tuple[Jump, ...]

    @property
    def jump_up(self) -> float:
        """Value at which |x| jumps up (the largest such jump); nan without one."""
        return _largest([j for j in (*self.on_run_up, *self.on_run_down) if j.after > j.before])

    @property
    def jump_down(self) -> float:
        """Value at which |x| drops (the largest such jump); nan without one."""
        return _largest([j for j in (*self.on_run_up, *self.on_run_down) if j.after < j.before])

    @property
    def whole(self) -> bool:
        """True if both ends are jumps."""
        begins = any(j.value == self.low for j in self.on_run_down)
        return begins and any(j.value == self.high for j in self.on_run_up)

    @property
    def width(self) -> float:
        """Distance between its ends; 0 where one of them is no jump."""
        return self.high - self.low if self.whole else 0.0

    @property
    def size(self) -> float:
        """Largest change of max |x| in a jump."""
        return max((abs(j.after - j.before) for j in (*self.on_run_up, *self.on_run_down)), default=0.0)


class Leg(NamedTuple):
    """Stretch of a sweep between two jumps: a piece, the values between which, and the jump at its end."""

    piece: int
    low: float
    high: float
    jump: Jump | None


def bands_between(up: list[Leg], down: list[Leg]) -> tuple[HysteresisBand, ...]:
    """Bands in which the sweeps are on different pieces; where these overlap, each with a jump and its way back."""
    cuts = sorted({end for leg in (*up, *down) for end in (leg.low, leg.high)})
    apart: list[tuple[float, float]] = []
    for low, high in pairwise(cuts):
        pieces = {next((leg.piece for leg in legs if leg.low <= low and high <= leg.high), None) for legs in (up, down)}
        if len(pieces) == 1 or None in pieces:
            continue
        apart.append((apart.pop()[0] if apart and apart[-1][1] == low else low, high))
    bands: list[HysteresisBand] = []
    for low, high in apart:
        forth, back = [
            {(a.piece, b.piece): a.jump for a, b in pairwise(legs) if a.jump and low <= a.jump.value <= high}
            for legs in (up, down)
        ]
        pairs = [(forth.pop(pair), back.pop(pair[::-1])) for pair in list(forth) if pair[::-1] in back]
        bands += [HysteresisBand(again.value, jump.value, (jump,), (again,)) for jump, again in pairs]
        first, last = tuple(forth.values()), tuple(back.values())
        if pairs and last:
            low = min(jump.value for jump in last)
        if pairs and first:
            high = max(jump.value for jump in first)
        if first or last or not pairs:
            bands.append(HysteresisBand(low, high, first, last))
    return tuple(sorted(bands, key=lambda band: band.low))


def _largest(some: list[Jump]) -> float:
    return max(some, key=lambda j: abs(j.after - j.before)).value if some else float("nan")


def bands_sentence(parameter: str, bands: tuple[HysteresisBand, ...]) -> str:
    """Width and ends of every band in words."""
    if not bands:
        return "No bistable range."
    sentences = []
    for band in bands:
        ends = f"{parameter} = {band.low:.9g} to {band.high:.9g}"
        if band.whole:
            sentences.append(f"Hysteresis {band.width:.6g} wide{f', from {ends}' if len(bands) > 1 else ''}.")
            continue
        missing = "The jump of the other direction lies" if band.on_run_up or band.on_run_down else "Both jumps lie"
        sentences.append(f"The sweeps are on different motions from {ends}. {missing} outside the range.")
    return " ".join(sentences)


@dataclass(frozen=True, eq=False)
class Jumps(Result):
    """A slow run-up and run-down on a branch.

    Attributes
    ----------
    parameter : str
        Path of the parameter that is swept, "omega" [rad/s].
    jump_up, jump_down : float
        Where |x| jumps up and where it drops, in the band with the largest jump; nan where there is none.
    width : float
        Width of that band: the hysteresis; 0 where there is none, or one of its ends is no jump.
    run_up, run_down : integer arrays
        Points of the branch that the sweep visits, in order.
    on_run_up, on_run_down : tuple of Jump
        Every jump of each sweep, in order.
    finished_up, finished_down : bool
        Whether each sweep reaches the other end of the branch's range on stable orbits of the branch.
    sentence : str
        All of it in words.
    bands : tuple of HysteresisBand
        Each band with its own pair of jumps, by ascending `low`; they may overlap.
    flips : tuple of (float, float)
        Values between which a motion that a sweep comes to is unstable by a multiplier below -1: what follows repeats
        after two periods or more, or leaves the curve.
    """

    parameter: str
    jump_up: float
    jump_down: float
    width: float
    run_up: Integers
    run_down: Integers
    on_run_up: tuple[Jump, ...]
    on_run_down: tuple[Jump, ...]
    finished_up: bool
    finished_down: bool
    sentence: str
    bands: tuple[HysteresisBand, ...]
    flips: tuple[tuple[float, float], ...] = ()

    @property
    def jumping(self) -> tuple[HysteresisBand, ...]:
        """The bands that a sweep jumps into or out of."""
        return tuple(band for band in self.bands if band.on_run_up or band.on_run_down)

    @property
    def alone(self) -> tuple[Jump, ...]:
        """Jumps in no band: the other sweep ends before it comes there, as its stable motions do."""
        held = {jump for band in self.bands for jump in (*band.on_run_up, *band.on_run_down)}
        return tuple(jump for jump in (*self.on_run_up, *self.on_run_down) if jump not in held)

    rows: ClassVar[str] = "jump"

    def variables(self) -> Labelled:
        """Every jump, those of the run-up first: where, the largest |x| before and after, the sweep, the cause."""
        runs = (*self.on_run_up, *self.on_run_down)
        return {
            self.parameter: ("jump", np.array([j.value for j in runs]), "rad/s" if self.parameter == "omega" else ""),
            **{n: ("jump", np.array([getattr(j, n) for j in runs]), "rad") for n in ("before", "after")},
            "up": ("jump", np.arange(len(runs)) < len(self.on_run_up), ""),
            "cause": ("jump", np.array([j.cause for j in runs], str), ""),
            "run_up": ("visited on the run-up", self.run_up, ""),
            "run_down": ("visited on the run-down", self.run_down, ""),
        }

    def __str__(self) -> str:
        return on_screen(self.sentence)


def jumps(branch: Branch) -> Jumps:
    """Tell what a slow sweep up and down in the parameter of a branch does.

    Parameters
    ----------
    branch : Branch
        From `frequency_response` or `parameter_response`.

    Returns
    -------
    Jumps
        `jump_up` and `jump_down`, values of the branch's parameter (speed [rad/s]) to the accuracy of the folds; nan
        without a jump. `run_up` and `run_down`, the points of the branch that each sweep visits, in order.

    Raises
    ------
    ValueError
        If the branch has no stable orbit.

    References
    ----------
    Nayfeh & Mook 1979, Nonlinear Oscillations, sec. 4.1.1 (jump phenomena).
    """
    low, high = branch.span if len(branch.values) else (0.0, 0.0)
    followed = pieces_of(branch, branch.stable | doubled(branch))  # or a stable motion of twice the period goes on
    pieces = [p for p in followed if np.max(branch.values[p]) > low and np.min(branch.values[p]) < high]
    if not pieces or not branch.stable.any():
        raise ValueError("the branch has no stable orbit that a sweep could follow")
    up, on_up, good_up, legs_up = _sweep(branch, pieces, 1.0)
    down, on_down, good_down, legs_down = _sweep(branch, pieces, -1.0)
    between = bands_between(legs_up, legs_down)
    bands = tuple(b for b in between if b.on_run_up or b.on_run_down or b.high - b.low > SEAM * abs(b.high))
    twice = doubled(branch)
    sentence = " ".join(
        [
            _sweep_sentence(branch, "run-up", on_up, good_up, up, twice),
            _sweep_sentence(branch, "run-down", on_down, good_down, down, twice),
            bands_sentence(branch.parameter, bands),
            *_doubled_sentences(branch, np.union1d(up, down)),
        ]
    )
    sweeps = jumps_of(branch.parameter, up, down, on_up, on_down, good_up, good_down, sentence, bands)
    return replace(sweeps, flips=doubled_spans(branch, np.isin(np.arange(len(twice)), [*up, *down])))


def jumps_of(
    parameter: str, up: Integers, down: Integers, on_up: tuple[Jump, ...], on_down: tuple[Jump, ...],
    good_up: bool, good_down: bool, sentence: str, bands: tuple[HysteresisBand, ...],
) -> Jumps:  # fmt: skip
    """Put together what was found, with the pair of jumps of the band with the largest one."""
    held = {jump for band in bands for jump in (*band.on_run_up, *band.on_run_down)}
    alone = [HysteresisBand(j.value, j.value, (j,), ()) for j in (*on_up, *on_down) if j not in held]
    main = max((*bands, *alone), key=lambda band: band.size, default=HysteresisBand(0.0, 0.0, (), ()))
    return Jumps(
        parameter, main.jump_up, main.jump_down, main.width, up, down, on_up, on_down, good_up, good_down, sentence,
        bands,
    )  # fmt: skip


def _sweep_sentence(
    branch: Branch, name: str, some: tuple[Jump, ...], good: bool, path: Integers, twice: Booleans
) -> str:  # fmt: skip
    parameter = branch.parameter
    changes = [
        f"{'rises' if j.after > j.before else 'drops'} at {parameter} = {j.value:.9g} from {j.before:.4g} to "
        f"{j.after:.4g} ({j.cause}{'; other stable orbits wait there, the nearest is taken' if j.choices > 1 else ''})"
        for j in some
    ]
    without = f"changes without a jump{' where the motion is stable' if twice[path].any() else ''}"
    text = f"On the {name} max |x| " + (", then ".join(changes) if changes else without)
    if not good:
        end = branch.values[path[-1]]
        text += f", and beyond {parameter} = {end:.6g} this branch has no stable orbit: integrate to see what follows"
    return text + "."


def doubled(branch: Branch) -> Booleans:
    """Points that are unstable by a multiplier below -1: a motion of twice the period goes on beside them."""
    if not branch.multipliers.size:
        return np.zeros(len(branch.values), bool)
    largest = branch.multipliers[np.arange(len(branch.values)), np.argmax(np.abs(branch.multipliers), axis=1)]
    return np.asarray(~branch.stable & (largest.real < -1.0))


def doubled_spans(branch: Branch, some: Booleans | bool = True) -> tuple[tuple[float, float], ...]:
    """Values in the range of a branch between which `some` motions are unstable by a multiplier below -1."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], doubled(branch) & some, [False]])))
    inside, special = np.clip(branch.values, *branch.span), {orbit.value for orbit in branch.doublings}
    values = branch.values.tolist()
    ends = ((a - (values[a] not in special), b + (values[b - 1] not in special)) for a, b in edges.reshape(-1, 2))
    runs = (inside[max(a, 0) : b] for a, b in ends)  # from one special point to the other
    return tuple((float(np.min(run)), float(np.max(run))) for run in runs if np.ptp(run) > 0.0)


def _doubled_sentences(branch: Branch, visited: Integers) -> list[str]:
    inside = branch.values[visited[doubled(branch)[visited]]]
    if not len(inside):
        return []
    return [
        f"Between {branch.parameter} = {inside.min():.6g} and {inside.max():.6g} the motion repeats after two periods "
        "or more, or leaves this curve: its max |x| is not that of this curve; integrate there."
    ]


def pieces_of(branch: Branch, good: Booleans) -> list[Integers]:
    """Runs of good points, monotonic in the parameter, such as those that are stable; special points may end a run."""
    special = {o.value for orbits in (branch.folds, branch.doublings, branch.branch_points) for o in orbits}
    values: list[float] = branch.values.tolist()
    marginal = [v in special for v in values]
    stable: list[bool] = np.asarray(good).tolist()
    pieces: list[list[int]] = []
    heading = 0.0
    for i, step in enumerate(np.sign(np.diff(branch.values)).tolist()):
        joined = (stable[i] or marginal[i]) and (stable[i + 1] or marginal[i + 1]) and (stable[i] or stable[i + 1])
        if not joined:
            heading = 0.0
            continue
        step = step or heading  # two points at one value belong to one run
        if step == 0.0:
            continue
        if step != heading:
            pieces.append([i])
        pieces[-1].append(i + 1)
        heading = step
    if branch.closed and len(pieces) > 1 and pieces[-1][-1] == len(values) - 1 and pieces[0][0] == 0:
        ahead = np.sign(values[pieces[0][1]] - values[0])
        if ahead == np.sign(values[pieces[-1][-1]] - values[pieces[-1][-2]]):  # one run through the seam of the loop
            pieces[0] = pieces.pop() + pieces[0]
    return [np.array(p) for p in pieces]


def _sweep(branch: Branch, pieces: list[Any], sign: float) -> tuple[Integers, tuple[Jump, ...], bool, list[Leg]]:
    """Points visited by a sweep (sign 1: up), its jumps, whether it reaches the end of the range, and its legs.

    An open branch may leave its range and come back: the sweep goes from the end with the lower value to the other.
    """
    values = sign * branch.values
    begin, ends = sorted(sign * end for end in branch.span)
    ahead = [p if values[p[-1]] > values[p[0]] else p[::-1] for p in pieces]
    current = min(range(len(ahead)), key=lambda k: max(begin, float(values[ahead[k][0]])))
    if not branch.closed:
        start = 0 if values[0] <= values[-1] else len(values) - 1
        current = next((k for k, p in enumerate(ahead) if p[0] == start), current)
    visited = [i for i in ahead[current] if values[i] >= begin]
    legs: list[Leg] = []
    begun, complete = max(begin, float(values[ahead[current][0]])), False
    while True:
        last, leg = visited[-1], current
        edge = float(values[last])
        complete = edge >= ends
        onto = [
            k
            for k, p in enumerate(ahead)
            if k != current and values[p[0]] <= edge < values[p[-1]] and last not in p[:-1]
        ]
        jump = None
        if not complete and onto and len(legs) <= len(pieces):
            before = float(branch.peak[last])
            landings = [float(np.interp(edge, values[ahead[k]], branch.peak[ahead[k]])) for k in onto]
            best = int(np.argmin(np.abs(np.array(landings) - before)))
            current = onto[best]
            begin_of = float(values[ahead[current][0]])
            if abs(landings[best] - before) > SEAM * before or edge - begin_of > SEAM * abs(edge):
                jump = Jump(sign * edge, before, landings[best], _cause(branch, sign * edge), len(onto))
            visited += list(ahead[current][values[ahead[current]] > edge])
        low, high = sorted((sign * begun, sign * min(edge, ends)))
        legs.append(Leg(leg, low, high, jump))
        if current == leg:
            break
        begun = edge
    inside = [i for i in visited if values[i] <= ends]
    taken = tuple(leg.jump for leg in legs if leg.jump is not None)
    return np.array(inside or visited), taken, complete, legs


def _cause(branch: Branch, value: float) -> str:
    special: list[Orbit] = [*branch.folds, *branch.doublings, *branch.branch_points]
    return next((o.label for o in special if o.value == value), "the stable orbits end")
