"""Bands of hysteresis between a slow run-up and run-down, each with its own pair of jumps."""

from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple


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
        """Where |x| jumps up (the largest such jump); nan where there is none."""
        return _largest([j for j in (*self.on_run_up, *self.on_run_down) if j.after > j.before])

    @property
    def jump_down(self) -> float:
        """Where |x| drops (the largest such jump); nan where there is none."""
        return _largest([j for j in (*self.on_run_up, *self.on_run_down) if j.after < j.before])

    @property
    def whole(self) -> bool:
        """Whether both ends are jumps."""
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
    """What a sweep follows between two jumps: a piece, the values between which, and the jump at the end of it."""

    piece: int
    low: float
    high: float
    jump: Jump | None


def bands_between(up: list[Leg], down: list[Leg]) -> tuple[HysteresisBand, ...]:
    """Bands in which the sweeps are on different pieces; where these overlap, each with a jump and its way back."""
    cuts = sorted({end for leg in (*up, *down) for end in (leg.low, leg.high)})
    apart: list[tuple[float, float]] = []
    for low, high in pairwise(cuts):
        here = {next((leg.piece for leg in legs if leg.low <= low and high <= leg.high), None) for legs in (up, down)}
        if len(here) == 1 or None in here:
            continue
        apart.append((apart.pop()[0] if apart and apart[-1][1] == low else low, high))
    found: list[HysteresisBand] = []
    for low, high in apart:
        forth, back = (
            {(a.piece, b.piece): a.jump for a, b in pairwise(legs) if a.jump and low <= a.jump.value <= high}
            for legs in (up, down)
        )
        pairs = [(forth.pop(way), back.pop(way[::-1])) for way in list(forth) if way[::-1] in back]
        found += [HysteresisBand(again.value, there.value, (there,), (again,)) for there, again in pairs]
        first, last = (tuple(some.values()) for some in (forth, back))
        if pairs and last:
            low = min(jump.value for jump in last)
        if pairs and first:
            high = max(jump.value for jump in first)
        if first or last or not pairs:
            found.append(HysteresisBand(low, high, first, last))
    return tuple(sorted(found, key=lambda band: band.low))


def _largest(some: list[Jump]) -> float:
    return max(some, key=lambda j: abs(j.after - j.before)).value if some else float("nan")


def told_bands(parameter: str, bands: tuple[HysteresisBand, ...]) -> str:
    """Width and ends of every band in words."""
    if not bands:
        return "No hysteresis."
    told = []
    for band in bands:
        ends = f"{parameter} = {band.low:.9g} to {band.high:.9g}"
        if band.whole:
            told.append(f"Hysteresis {band.width:.6g} wide{f', from {ends}' if len(bands) > 1 else ''}.")
            continue
        missing = "The jump of the other direction lies" if band.on_run_up or band.on_run_down else "Both jumps lie"
        told.append(f"The sweeps are on different motions from {ends}. {missing} outside the range.")
    return " ".join(told)
