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
    bands: list[HysteresisBand] = []
    for low, high in _spans_apart(up, down):
        forth, back = (_jumps_within(legs, low, high) for legs in (up, down))
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


def _spans_apart(up: list[Leg], down: list[Leg]) -> list[tuple[float, float]]:
    """Spans of values, from end to end, in which both sweeps are on stable orbits, each on another piece."""
    spans: list[tuple[float, float]] = []
    for low, high in pairwise(sorted({end for leg in (*up, *down) for end in (leg.low, leg.high)})):
        pieces = {_piece_at(legs, low, high) for legs in (up, down)}
        if len(pieces) == 1 or None in pieces:
            continue
        if spans and spans[-1][1] == low:
            low, _ = spans.pop()
        spans.append((low, high))
    return spans


def _piece_at(legs: list[Leg], low: float, high: float) -> int | None:
    """Piece on which a sweep is between two values; None where it is on none."""
    return next((leg.piece for leg in legs if leg.low <= low and high <= leg.high), None)


def _jumps_within(legs: list[Leg], low: float, high: float) -> dict[tuple[int, int], Jump]:
    """Jumps of a sweep between two values, by the pieces from and onto which they lead."""
    pairs = ((a.piece, b.piece, a.jump) for a, b in pairwise(legs))
    return {(leaves, lands): jump for leaves, lands, jump in pairs if jump and low <= jump.value <= high}


def _largest(some: list[Jump]) -> float:
    """Value at the largest of some jumps; nan of none."""
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
        missing = "The jump of the other sweep lies" if band.on_run_up or band.on_run_down else "Both jumps lie"
        sentences.append(f"Run-up and run-down are on different motions from {ends}. {missing} outside the range.")
    return " ".join(sentences)
