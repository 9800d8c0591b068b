"""`jumps`: what a slow run-up and run-down do on a response curve: where they jump, onto what, and the hysteresis.

The drive follows stable orbits. Where they end at a fold it jumps onto another stable orbit of the curve at the same
frequency; where several wait there, the basins of attraction decide, and the nearest in size is taken and named so.
"""

from dataclasses import dataclass, replace
from typing import Any, ClassVar, NamedTuple

import numpy as np

from ..base.records import Labelled, Result
from ..base.results import Booleans, Branch, Integers, Orbit
from ..base.terminal import on_screen
from .hysteresis_bands import HysteresisBand, Jump, Leg, bands_between, bands_sentence

SEAM = 1e-6  # relative difference of two pieces of a curve in value and in size that are one motion where they meet


class Sweep(NamedTuple):
    """A slow sweep: points of the branch in order, jumps, whether it reaches the other end, and legs between jumps."""

    path: Integers
    jumps: tuple[Jump, ...]
    finished: bool
    legs: list[Leg]


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
        raise ValueError("the branch has no stable motion that a run-up or run-down could follow")
    up, down = (_sweep(branch, pieces, sign) for sign in (1.0, -1.0))
    between = bands_between(up.legs, down.legs)
    bands = tuple(b for b in between if b.on_run_up or b.on_run_down or b.high - b.low > SEAM * abs(b.high))
    twice = doubled(branch)
    sentences = [
        _sweep_sentence(branch, "run-up", up, twice),
        _sweep_sentence(branch, "run-down", down, twice),
        bands_sentence(branch.parameter, bands),
        *_doubled_sentences(branch, np.union1d(up.path, down.path)),
    ]
    flips = doubled_spans(branch, np.isin(np.arange(len(twice)), [*up.path, *down.path]))
    return replace(jumps_of(branch.parameter, up, down, " ".join(sentences), bands), flips=flips)


def jumps_of(
    parameter: str, up: Sweep, down: Sweep, sentence: str, bands: tuple[HysteresisBand, ...]
) -> Jumps:  # fmt: skip
    """Put together two sweeps, with the pair of jumps of the band with the largest one."""
    held = {jump for band in bands for jump in (*band.on_run_up, *band.on_run_down)}
    alone = [HysteresisBand(j.value, j.value, (j,), ()) for j in (*up.jumps, *down.jumps) if j not in held]
    main = max((*bands, *alone), key=lambda band: band.size, default=HysteresisBand(0.0, 0.0, (), ()))
    return Jumps(
        parameter, main.jump_up, main.jump_down, main.width, run_up=up.path, run_down=down.path,
        on_run_up=up.jumps, on_run_down=down.jumps, finished_up=up.finished, finished_down=down.finished,
        sentence=sentence, bands=bands,
    )  # fmt: skip


def _sweep_sentence(branch: Branch, name: str, sweep: Sweep, twice: Booleans) -> str:
    """Course of max |x| on a sweep, in words; `twice` marks points that a motion of twice the period goes past."""
    parameter, path = branch.parameter, sweep.path
    changes = [
        f"{'rises' if j.after > j.before else 'drops'} at {parameter} = {j.value:.9g} from {j.before:.4g} to "
        f"{j.after:.4g} ({j.cause}{'; the nearest of several stable motions is used' if j.choices > 1 else ''})"
        for j in sweep.jumps
    ]
    without = f"changes without a jump{' where the motion is stable' if twice[path].any() else ''}"
    text = f"In the {name} max |x| " + (", then ".join(changes) if changes else without)
    if not sweep.finished:
        end = branch.values[path[-1]]
        text += f". Beyond {parameter} = {end:.6g} this branch has no stable motion; use a time integration there"
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
    spans = list[tuple[float, float]]()
    for first, end in edges.reshape(-1, 2).tolist():  # from one special point to the other
        start = first if branch.values[first] in special else first - 1
        stop = end if branch.values[end - 1] in special else end + 1
        run = inside[max(start, 0) : stop]
        if np.ptp(run) > 0.0:
            spans.append((float(np.min(run)), float(np.max(run))))
    return tuple(spans)


def _doubled_sentences(branch: Branch, visited: Integers) -> list[str]:
    inside = branch.values[visited[doubled(branch)[visited]]]
    if not len(inside):
        return []
    return [
        f"Between {branch.parameter} = {inside.min():.6g} and {inside.max():.6g} the motion has twice the period "
        "or more, or is not on this curve, so max |x| of the curve does not apply; use a time integration there."
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


def _sweep(branch: Branch, pieces: list[Any], sign: float) -> Sweep:
    """Follow a slow sweep (sign 1: up, -1: down) over the stable pieces of a branch.

    An open branch may leave its range and come back: the sweep goes from the end with the lower value to the other.
    """
    values = sign * branch.values
    begin, end = sorted(sign * bound for bound in branch.span)
    ahead = [p if values[p[-1]] > values[p[0]] else p[::-1] for p in pieces]
    current = min(range(len(ahead)), key=lambda k: max(begin, float(values[ahead[k][0]])))
    if not branch.closed:
        start = 0 if values[0] <= values[-1] else len(values) - 1
        current = next((k for k, p in enumerate(ahead) if p[0] == start), current)
    path = [i for i in ahead[current] if values[i] >= begin]
    legs: list[Leg] = []
    from_value = max(begin, float(values[ahead[current][0]]))
    while True:
        edge = float(values[path[-1]])
        following, jump = None, None
        if edge < end and len(legs) <= len(pieces):
            following, jump = _landing(branch, sign, ahead, current, path[-1])
        low, high = sorted((sign * from_value, sign * min(edge, end)))
        legs.append(Leg(current, low, high, jump))
        if following is None:
            break
        path += list(ahead[following][values[ahead[following]] > edge])
        current, from_value = following, edge
    inside = [i for i in path if values[i] <= end]
    taken = tuple(leg.jump for leg in legs if leg.jump is not None)
    return Sweep(np.array(inside or path), taken, edge >= end, legs)


def _landing(
    branch: Branch, sign: float, ahead: list[Any], current: int, last: int
) -> tuple[int | None, Jump | None]:  # fmt: skip
    """Piece onto which a sweep goes from the `last` point of its piece, the nearest in size, and its jump.

    No piece where no stable orbit waits there; no jump where both pieces are one motion.
    """
    values = sign * branch.values
    edge, before = float(values[last]), float(branch.peak[last])
    waiting = [k for k, p in enumerate(ahead) if values[p[0]] <= edge < values[p[-1]] and last not in p[:-1]]
    onto = [k for k in waiting if k != current]
    if not onto:
        return None, None
    sizes = [float(np.interp(edge, values[ahead[k]], branch.peak[ahead[k]])) for k in onto]
    nearest = int(np.argmin(np.abs(np.array(sizes) - before)))
    piece, after = onto[nearest], sizes[nearest]
    same = abs(after - before) <= SEAM * before and edge - float(values[ahead[piece][0]]) <= SEAM * abs(edge)
    return piece, None if same else Jump(sign * edge, before, after, _cause(branch, sign * edge), len(onto))


def _cause(branch: Branch, value: float) -> str:
    """Name of the special point at a value, where the stable orbits end."""
    special: list[Orbit] = [*branch.folds, *branch.doublings, *branch.branch_points]
    return next((o.label for o in special if o.value == value), "the stable motions end")
