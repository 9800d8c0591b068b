"""Lines in runs that nobody has named: over the angle and over the time, one strength after the other.

The power of a line over the noise around it is exponentially distributed where there is no line, and adds up over runs.
An order stands at one place over the angle in every run, a frequency at one place over the time. Runs at different
speeds, or one whose speed changes, have one sum above the other.
"""

import math
from collections.abc import Sequence
from typing import Literal, NamedTuple

import numpy as np
from scipy.special import gammaincc

from ....results import Floats
from ...kinematic_error.line_noise import Floor
from ..run import Run
from .order_fit import rounding, slow_columns, without

Kind = Literal["order", "frequency", "undecided"]
OVERSAMPLED = 6  # orders tried for each that is independent
DECIDED = 9.0  # difference of the sums from which on one of both is believed: e^9 to 1
CELL = 0.1  # rad: of the highest order, over which samples are counted as one place
TURN = 2.0 * math.pi


class FoundLine(NamedTuple):
    """A line that stands out.

    Attributes
    ----------
    place : float
        Order, or frequency [Hz] of kind "frequency".
    error : float
        Its standard deviation.
    kind : {"order", "frequency", "undecided"}
        What keeps it in place; "undecided" is given as an order.
    difference : float
        Sum over the angle less that over the time, in logarithms of the likelihood.
    false_alarm : float
        Probability that noise has a line as strong anywhere.
    reach : float
        Distance of another line that is not told apart from it.
    """

    place: float
    error: float
    kind: Kind
    difference: float
    false_alarm: float
    reach: float = 0.0


class Search:
    """What is left of runs while lines are found in them and taken out."""

    def __init__(self, runs: Sequence[Run], lowest: float, highest: float) -> None:
        least, self.speeds = [rounding(run.value) for run in runs], np.array([abs(run.speed) for run in runs])
        self.rest = [without(slow_columns(run, lowest), run.value) for run in runs]
        angles = [Coordinate(np.abs(run.angle - run.angle[0]), highest, v) for run, v in zip(runs, least, strict=True)]
        times = [
            Coordinate(TURN * (run.time - run.time[0]), highest * speed / TURN, v)
            for run, speed, v in zip(runs, self.speeds, least, strict=True)
        ]
        self.angle = Spectrum(angles, lowest)
        self.time = Spectrum(times, lowest * float(np.min(self.speeds)) / TURN)

    def strongest(self, false_alarm: float) -> FoundLine | None:
        """The line that stands out most, taken out; None where noise may have it."""
        sums = self.angle.sums(self.rest), self.time.sums(self.rest)
        order, frequency = self.angle.largest(sums[0]), self.time.largest(sums[1])
        here, there = self._both(sums, order), self._both_of_time(sums, frequency)
        by_time = there[1] - there[0] > DECIDED and max(there) > max(here) - DECIDED and here[0] - here[1] <= DECIDED
        spectrum, place, both = (self.time, frequency, there) if by_time else (self.angle, order, here)
        alarm = spectrum.false_alarm(max(both), 2.0 * spectrum.trials)
        return self._taken(spectrum, place, both, alarm) if alarm < false_alarm else None

    def near(self, order: float, trials: int, false_alarm: float) -> FoundLine | None:
        """A line around an order, one of so many that are looked at; None where noise may have it."""
        sums = self.angle.sums(self.rest), self.time.sums(self.rest)
        around = np.abs(self.angle.places - order) <= self.angle.spacing
        if not np.any(around):
            return None
        place = float(self.angle.places[around][np.argmax(sums[0][around])])
        both = self._both(sums, place)
        alarm = self.angle.false_alarm(both[0], 2.0 * trials)
        return self._taken(self.angle, place, both, alarm) if alarm < false_alarm else None

    def _both(self, sums: tuple[Floats, Floats], order: float) -> tuple[float, float]:
        """Sums at an order, and at the best frequency that a run has there."""
        return self.angle.sum_at(sums[0], order), self.time.largest_of(sums[1], order * self.speeds / TURN)

    def _both_of_time(self, sums: tuple[Floats, Floats], frequency: float) -> tuple[float, float]:
        return self.angle.largest_of(sums[0], frequency * TURN / self.speeds), self.time.sum_at(sums[1], frequency)

    def _taken(self, spectrum: "Spectrum", place: float, both: tuple[float, float], alarm: float) -> FoundLine:
        difference = both[0] - both[1]
        kind: Kind = "order" if difference > DECIDED else "frequency" if difference < -DECIDED else "undecided"
        if spectrum is self.angle and kind == "frequency":
            kind = "undecided"  # it has another place over the time, which is found for itself
        found = FoundLine(place, spectrum.error(place, self.rest), kind, difference, alarm)
        self.rest = [without(np.column_stack(c.wave(place)), r) for c, r in zip(spectrum.over, self.rest, strict=True)]
        return found


class Coordinate(NamedTuple):
    """What a run is looked at over, the angle travelled [rad] or 2 pi times the time [s], and its highest place."""

    x: Floats
    highest: float
    least: float
    """Variance of rounding."""

    @property
    def reach(self) -> float:
        """How far it goes."""
        return float(np.max(self.x))

    def wave(self, place: float) -> tuple[Floats, Floats]:
        """Cosine and sine (n,) of a line."""
        return np.cos(place * self.x), np.sin(place * self.x)


class Spectrum:
    """Power over noise at places from a lowest one on, added up over the runs."""

    def __init__(self, over: list[Coordinate], lowest: float) -> None:
        self.over = over
        highest, self.spacing = max(c.highest for c in over), TURN / max(c.reach for c in over)
        step = self.spacing / OVERSAMPLED
        self.first = max(1, math.ceil(lowest / step))
        count = max(2, math.ceil(highest / step) - self.first)
        self.places: Floats = step * (self.first + np.arange(count, dtype=float))
        self.trials = max(1.0, float(self.places[-1] - self.places[0]) / self.spacing)
        self.parts = 1 << math.ceil(math.log2(TURN / step / (CELL / highest)))
        self.cell = TURN / step / self.parts

    def ratios(self, rest: Sequence[Floats]) -> Floats:
        """Power over noise (runs, places), as sure as if the noise were known; 1 above the highest place of a run.

        With noise from so many others the power has Fisher's distribution, (1 + z/f)^-f in the place of exp(-z).
        """
        found = np.ones((len(self.over), len(self.places)))
        for i, (c, r) in enumerate(zip(self.over, rest, strict=True)):
            cells = np.bincount(np.rint(c.x / self.cell).astype(int), r)
            sums = np.fft.rfft(cells, self.parts)[self.first : self.first + len(self.places)]
            power = np.abs(2.0 / len(r) * sums) ** 2
            noise, freedom = self._noise(c, power, len(r))
            inside = self.places <= c.highest
            found[i, inside] = (freedom * np.log1p(power / noise / freedom))[inside]
        return found

    def _noise(self, c: Coordinate, power: Floats, samples: int) -> tuple[Floats, Floats]:
        """Mean power (places,) of the noise, and how many values it is from: those that are independent in the run."""
        some = self.places[:: max(1, round(TURN / c.reach / (self.spacing / OVERSAMPLED)))]
        at = some[some <= c.highest]
        powers = np.interp(at, self.places, power)
        floor = Floor(at, powers, TURN / c.reach, math.ceil(c.highest), samples, 4.0 * c.least / samples)
        means, freedoms = floor.estimates(at)
        return np.exp(np.interp(self.places, at, np.log(means))), np.interp(self.places, at, freedoms)

    def sums(self, rest: Sequence[Floats]) -> Floats:
        """`ratios` added up."""
        return np.asarray(np.sum(self.ratios(rest), axis=0))

    def largest(self, sums: Floats) -> float:
        """Place of the largest sum, between the places that were looked at."""
        i = int(np.clip(np.argmax(sums), 1, len(sums) - 2))
        below, top, above = np.log(np.maximum(sums[i - 1 : i + 2], 1e-300))
        bend = below - 2.0 * top + above
        return float(
            self.places[i] + (0.5 * (below - above) / bend if bend < 0.0 else 0.0) * self.spacing / OVERSAMPLED
        )

    def sum_at(self, sums: Floats, place: float) -> float:
        """Largest sum within the width of a line around a place; 0 outside of all places."""
        near = np.abs(self.places - place) <= self.spacing
        return float(np.max(sums[near], initial=0.0))

    def largest_of(self, sums: Floats, places: Floats) -> float:
        """Largest `sum_at` of several places."""
        return max(self.sum_at(sums, place) for place in places)

    def false_alarm(self, total: float, trials: float) -> float:
        """Probability that noise reaches a sum at so many independent places or between them.

        Between independent places it crosses the sum as often as Davies 1987, Biometrika 74, 33-43, says.
        """
        single = float(gammaincc(len(self.over), total))
        trials *= max(1.0, math.sqrt(math.pi * total / 3.0))
        return -math.expm1(trials * math.log1p(-min(single, 1.0 - 1e-16)))

    def error(self, place: float, rest: Sequence[Floats]) -> float:
        """Standard deviation of a place (Rife & Boorstyn 1974, IEEE Trans. Inf. Theory 20(5), 591-598)."""
        i = int(np.argmin(np.abs(self.places - place)))
        sums = self.ratios(rest)[:, i]
        told = sum(max(z, 0.0) * c.reach**2 / 6.0 for z, c in zip(sums, self.over, strict=True))
        return 1.0 / math.sqrt(told) if told > 0.0 else math.inf
