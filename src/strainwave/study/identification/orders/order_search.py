"""Lines in runs that nobody has named: over the angle and over the time, one strength after the other.

The power of a line over the noise around it is exponentially distributed where there is no line, and adds up over runs.
An order stands at one place over the angle in every run, a frequency at one place over the time. Runs at different
speeds, or one whose speed changes, have one sum above the other.
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np
from scipy.fft import rfft
from scipy.special import gammaincc

from ....base.results import Floats, Integers
from ..intervals import orthogonal
from ..run import Run
from .order_fit import Floor, rounding

Kind = Literal["order", "frequency", "undecided"]
Pair = tuple[int, int]
OVERSAMPLING = 6  # orders tried for each that is independent
DECISION = 9.0  # difference of the sums from which on one of both is believed: e^9 to 1
CELL_RAD = 0.25  # rad of the highest order: of the cells that samples are shared out to
BAND, MOST_BINS = 20, 160  # frequencies on both sides of a line, and of all, that a line is judged by
SIDE_WIDTH = 4.0  # resolutions beside an order, where its own slow changes are
LEAKAGE = 30.0  # resolutions: lines that are nearer disturb each other
ROUNDS, SETTLED_CHANGE = 5, 1e-7  # of finding a place anew, and a change in resolutions that is none
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
    pairs : tuple of (int, int)
        Turns of the motor and of the output that it may belong to.
    joint : bool
        Whether its place was found together with that of a line that beats with it.
    second : float
        Amplitude of another one beside it that the runs do not exclude, over its own; 0 where that was not looked at.
    """

    place: float
    error: float
    kind: Kind
    difference: float
    false_alarm: float
    reach: float = 0.0
    pairs: tuple[Pair, ...] = ()
    joint: bool = False
    second: float = 0.0

    @property
    def alone(self) -> bool:
        """True if the runs part it from its neighbours."""
        return self.joint or len(self.pairs) == 1


class Search:
    """Residual of runs while lines are found in them and taken out.

    What a strong line leaves where its place is a little wrong, and its leakage into the places of others, would look
    like more lines: after each new one the places of those near it are found anew (Li & Stoica 1996, IEEE Trans. Signal
    Process. 44(2), 281-295).
    """

    def __init__(self, runs: Sequence[Run], lowest: float, highest: float) -> None:
        self.runs, self.speeds = runs, np.array([abs(run.speed) for run in runs])
        self.least = least = [rounding(run.value) for run in runs]
        self.slow = [np.linalg.qr(run.slow_columns(2.0 * lowest))[0] for run in runs]
        self.rest = [orthogonal(q, run.value) for q, run in zip(self.slow, runs, strict=True)]
        self.lines: list[TakenLine] = []
        angles = [Coordinate(np.abs(run.angle - run.angle[0]), highest, v) for run, v in zip(runs, least, strict=True)]
        times = [
            Coordinate(TURN * (run.time - run.time[0]), highest * speed / TURN, v)
            for run, speed, v in zip(runs, self.speeds, least, strict=True)
        ]
        self.angle = Spectrum(angles, lowest)
        self.time = Spectrum(times, lowest * float(np.min(self.speeds)) / TURN)

    def strongest(self, false_alarm: float) -> FoundLine | None:
        """The line that stands out most, taken out; None where noise may have it."""
        ratios, by_angle, by_time = self._ratios()
        order, frequency = self.angle.largest(by_angle), self.time.largest(by_time)
        order_sum, frequency_sum = self.angle.sum_at(by_angle, order), self.time.sum_at(by_time, frequency)
        alarm = chance_of(max(order_sum, frequency_sum), self.angle.trials + self.time.trials, len(self.runs))
        if not alarm < false_alarm:
            return None
        if order_sum >= frequency_sum:
            frequency = self.time.highest(by_time, order * self.speeds / TURN)
        else:
            order = self.angle.highest(by_angle, frequency * TURN / self.speeds)
        return self._taken(order, frequency, alarm, ratios)

    def around(self, order: float, trials: int, false_alarm: float) -> FoundLine | None:
        """A line around an order, one of so many that are looked at; None where noise may have it."""
        ratios, by_angle, by_time = self._ratios()
        top = self.angle.highest(by_angle, [order])
        alarm = chance_of(self.angle.sum_at(by_angle, top), 2.0 * trials, len(self.runs))
        if not alarm < false_alarm:
            return None
        frequency = self.time.highest(by_time, order * self.speeds / TURN)
        return self._taken(top, frequency, alarm, ratios, as_order=True)

    def _ratios(self) -> tuple[tuple[Floats, Floats], Floats, Floats]:
        """Power over noise in the runs over angle and time, and the sums of both over the runs."""
        both = self.angle.ratios(self.rest), self.time.ratios(self.rest)
        return both, np.sum(both[0], axis=0), np.sum(both[1], axis=0)

    def _taken(
        self, order: float, frequency: float, alarm: float, ratios: tuple[Floats, Floats], *, as_order: bool = False
    ) -> FoundLine:
        """The line at an order or at a frequency, whichever leaves less around both (Whittle's likelihood)."""
        before, bands = self.rest, self._bands(order, frequency)
        trials = []
        for spectrum, start, ratio in ((self.angle, order, ratios[0]), (self.time, frequency, ratios[1])):
            self.rest = before
            error = spectrum.error(start, ratio)
            line = TakenLine(spectrum, start, [np.zeros(2) for _ in before])
            self._settle(line)
            trials.append((line, error, self.rest, self._likelihood(bands)))
        difference = trials[0][3] - trials[1][3]
        kind: Kind = "order" if difference > DECISION else "frequency" if difference < -DECISION else "undecided"
        if kind == "frequency" and (as_order or self._beside(frequency, ratios[1])):
            kind = "undecided"  # it has another place over the time, or is what an order leaves whose size varies
        line, error, self.rest, _ = trials[kind == "frequency"]
        line.kind, line.difference = kind, difference
        self.lines.append(line)
        for other in self.lines[:-1]:
            if other.spectrum is not line.spectrum or abs(other.place - line.place) < LEAKAGE * line.spectrum.spacing:
                self._settle(other, 1)
        if len(self.lines) > 1:
            self._settle(line)
        return FoundLine(line.place, error, kind, difference, alarm)

    def reconsidered(self, lines: list[FoundLine]) -> list[FoundLine]:
        """The lines with their places now; frequencies that are orders once the others are known become those."""
        for line in self.lines:
            if line.spectrum is self.time:
                self._reconsider(line)
        return [
            one._replace(place=line.place, kind=line.kind, difference=line.difference)
            for one, line in zip(lines, self.lines, strict=True)
        ]

    def _reconsider(self, line: "TakenLine") -> None:
        """Turn a frequency into the order of a run that leaves less, or no more where that order was found too."""
        after, columns = self.rest, self._columns(line)
        before = [less(r, c, -ab) for r, c, ab in zip(after, columns, line.amplitudes, strict=True)]
        for speed in np.unique(self.speeds):
            order = line.place * TURN / float(speed)
            bands = self._bands(order, line.place)
            self.rest = after
            likelihood, self.rest = self._likelihood(bands), before
            candidate = TakenLine(self.angle, order, [np.zeros(2) for _ in before])
            self._settle(candidate)
            candidate.difference = self._likelihood(bands) - likelihood
            same = [
                one for one in self.lines if one.spectrum is self.angle and abs(one.place - order) < self.angle.spacing
            ]
            if candidate.difference > (-DECISION if same else DECISION):
                line.spectrum, line.place, line.amplitudes = self.angle, candidate.place, candidate.amplitudes
                line.kind, line.difference = "order", max([candidate.difference, *(one.difference for one in same)])
                return
        self.rest = after

    def _beside(self, frequency: float, ratios: Floats) -> bool:
        """True if a frequency stands within a few resolutions of a taken order, in every run that has it."""
        orders = [line.place for line in self.lines if line.kind == "order"]
        close = np.abs(self.time.places - frequency) <= self.time.spacing
        seen = np.max(ratios[:, close], axis=1, initial=0.0)
        runs = zip(self.speeds, self.time.over, seen >= min(DECISION, float(np.max(seen))), strict=True)
        return all(
            not stands or any(abs(frequency - k * v / TURN) < SIDE_WIDTH * TURN / c.reach for k in orders)
            for v, c, stands in runs
        )

    def _bands(self, order: float, frequency: float) -> list[Integers]:
        """Numbers of the time's places, in each run, about the frequencies of an order there and about a frequency."""
        bands = []
        for run, c in zip(self.runs, self.time.over, strict=True):
            wide, thin = BAND * TURN / c.reach, max(1, len(run.time) // 200)
            speed = np.abs(np.gradient(run.angle[::thin], run.time[::thin]))
            slow, fast = [order * rate / TURN for rate in np.quantile(speed, (0.05, 0.95)).tolist()]
            places = self.time.places
            inside = ((places > slow - wide) & (places < fast + wide)) | (np.abs(places - frequency) < wide)
            some = np.flatnonzero(inside & (places <= c.highest))[:: max(1, round(TURN / c.reach / self.time.step))]
            bands.append(some[:: max(1, len(some) // MOST_BINS)])
        return bands

    def _likelihood(self, bands: list[Integers]) -> float:
        """Logarithm of the likelihood of what is left, as noise that is even over the bands."""
        total = 0.0
        for power, band, least, residual in zip(self.time.powers(self.rest), bands, self.least, self.rest, strict=True):
            if len(band):
                total -= len(band) * math.log(max(float(np.mean(power[band])), 4.0 * least / len(residual), 1e-300))
        return total

    def _settle(self, line: "TakenLine", rounds: int = ROUNDS) -> None:
        """Find place and amplitudes of a line anew in what the others leave (Gauss-Newton)."""
        axes, start = line.spectrum.over, line.place
        columns = self._columns(line)
        remainders = [less(r, c, -ab) for r, c, ab in zip(self.rest, columns, line.amplitudes, strict=True)]
        for _ in range(rounds):
            top = bottom = 0.0
            line.amplitudes = [shares(c, r) for c, r in zip(columns, remainders, strict=True)]
            self.rest = [less(r, c, ab) for r, c, ab in zip(remainders, columns, line.amplitudes, strict=True)]
            for one, (a, b), c, q, left in zip(axes, line.amplitudes, columns, self.slow, self.rest, strict=True):
                cosine, sine = one.wave(line.place)
                slope = orthogonal(q, one.x * (b * cosine - a * sine))
                slope -= c @ shares(c, slope)
                weight = 1.0 / max(float(left @ left), 1e-300)
                top, bottom = top + weight * float(slope @ left), bottom + weight * float(slope @ slope)
            change = top / bottom if bottom > 0.0 else 0.0
            if abs(line.place + change - start) > line.spectrum.spacing / OVERSAMPLING:
                return  # it is no single line: its place stays
            line.place += change
            columns = self._columns(line)
            if abs(change) < SETTLED_CHANGE * line.spectrum.spacing:
                break
        line.amplitudes = [shares(c, r) for c, r in zip(columns, remainders, strict=True)]
        self.rest = [less(r, c, ab) for r, c, ab in zip(remainders, columns, line.amplitudes, strict=True)]

    def _columns(self, line: "TakenLine") -> list[Floats]:
        """Cosine and sine (n, 2) of a line in every run, without what the slow columns say of them."""
        waves = [np.column_stack(one.wave(line.place)) for one in line.spectrum.over]
        return [orthogonal(q, wave) for q, wave in zip(self.slow, waves, strict=True)]


@dataclass
class TakenLine:
    """A line that was taken out: where it stands, and its cosine and sine in every run."""

    spectrum: "Spectrum"
    place: float
    amplitudes: list[Floats]
    kind: Kind = "undecided"
    difference: float = 0.0


def shares(columns: Floats, values: Floats) -> Floats:
    """Share of each column in values (least squares); a cosine and a sine are nearly orthogonal."""
    return np.asarray(np.linalg.solve(columns.T @ columns, columns.T @ values))


def less(values: Floats, columns: Floats, amplitudes: Floats) -> Floats:
    """Values without so much of each column."""
    return np.asarray(values - columns @ amplitudes)


def chance_of(total: float, trials: float, runs: int, *, between: bool = True) -> float:
    """Probability that noise of so many runs reaches a sum at so many independent places, or between them too.

    Between them it crosses the sum as often as Davies 1987, Biometrika 74, 33-43, says.
    """
    single = float(gammaincc(runs, max(total, 0.0)))
    if between:
        trials *= max(1.0, math.sqrt(math.pi * max(total, 0.0) / 3.0))
    return -math.expm1(trials * math.log1p(-min(single, 1.0 - 1e-16)))


class Coordinate(NamedTuple):
    """Coordinate of a run, the angle travelled [rad] or 2 pi times the time [s], and its highest place."""

    x: Floats
    highest: float
    least: float
    """Variance of rounding."""

    @property
    def reach(self) -> float:
        """Length of the coordinate."""
        return float(np.max(self.x))

    def wave(self, k: float) -> tuple[Floats, Floats]:
        """Cosine and sine (n,) of a line."""
        return np.cos(k * self.x), np.sin(k * self.x)


class Spectrum:
    """Power over noise at places from a lowest one on, added up over the runs."""

    def __init__(self, over: list[Coordinate], lowest: float) -> None:
        self.over = over
        highest, self.spacing = max(c.highest for c in over), TURN / max(c.reach for c in over)
        step = self.spacing / OVERSAMPLING
        self.first = max(1, math.ceil(lowest / step))
        count = max(2, math.ceil(highest / step) - self.first)
        self.places: Floats = step * (self.first + np.arange(count, dtype=float))
        self.step = step
        self.trials = max(1.0, float(self.places[-1] - self.places[0]) / self.spacing)
        self.parts = 1 << math.ceil(math.log2(TURN / step / (CELL_RAD / highest)))
        self.cell = TURN / step / self.parts

    def powers(self, residuals: Sequence[Floats]) -> list[Floats]:
        """Power (places,) of every run.

        A sample is shared out to four cells (Lagrange): where it is only rounded, a strong line has images.
        """
        spectra = []
        for c, r in zip(self.over, residuals, strict=True):
            scaled = c.x / self.cell + 1.0
            cell = scaled.astype(int)
            s = scaled - cell
            left, right = (s + 1.0) * s, (s - 1.0) * (s - 2.0)
            weights = (-s * right / 6.0, 0.5 * (s + 1.0) * right, -0.5 * left * (s - 2.0), left * (s - 1.0) / 6.0)
            cells = sum(np.bincount(cell + k, r * w, self.parts) for k, w in enumerate(weights, -1))
            sums = rfft(cells, self.parts)[self.first : self.first + len(self.places)]
            spectra.append(np.asarray(np.abs(2.0 / len(r) * sums) ** 2))
        return spectra

    def ratios(self, residuals: Sequence[Floats]) -> Floats:
        """Power over noise (runs, places), as sure as if the noise were known; 1 above the highest place of a run.

        With noise from so many others the power has Fisher's distribution, (1 + z/f)^-f in the place of exp(-z).
        """
        ratios = np.ones((len(self.over), len(self.places)))
        for i, (c, r, power) in enumerate(zip(self.over, residuals, self.powers(residuals), strict=True)):
            inside = self.places <= c.highest
            if not inside.any():
                continue  # a run whose samples show no order that is looked for
            noise, freedom = self._noise(c, power, len(r))
            ratios[i, inside] = (freedom * np.log1p(power / noise / freedom))[inside]
        return ratios

    def _noise(self, c: Coordinate, power: Floats, samples: int) -> tuple[Floats, Floats]:
        """Mean power (places,) of the noise, and how many values it is from: those that are independent in the run.

        What leaks from elsewhere may vanish at all of them and not between them: of both floors the larger one counts.
        """
        step = max(1, round(TURN / c.reach / (self.spacing / OVERSAMPLING)))
        means, freedoms = np.zeros(len(self.places)), np.ones(len(self.places))
        for begin in (0, step // 2) if step > 1 else (0,):
            some = self.places[begin::step]
            places = some[some <= c.highest]
            if not len(places):
                continue
            powers = np.interp(places, self.places, power)
            floor = Floor(places, powers, TURN / c.reach, math.ceil(c.highest), samples, 4.0 * c.least / samples)
            mean, freedom = floor.estimates(places)
            mean = np.exp(np.interp(self.places, places, np.log(mean)))
            freedoms = np.where(mean > means, np.interp(self.places, places, freedom), freedoms)
            means = np.maximum(means, mean)
        return means, freedoms

    def largest(self, sums: Floats) -> float:
        """Place of the largest sum, between the places that were looked at."""
        i = int(np.clip(np.argmax(sums), 1, len(sums) - 2))
        below, top, above = np.log(np.maximum(sums[i - 1 : i + 2], 1e-300))
        bend = below - 2.0 * top + above
        return float(
            self.places[i] + (0.5 * (below - above) / bend if bend < 0.0 else 0.0) * self.spacing / OVERSAMPLING
        )

    def sum_at(self, sums: Floats, centre: float) -> float:
        """Largest sum within the width of a line around a place; 0 outside of all places."""
        return float(np.max(sums[np.abs(self.places - centre) <= self.spacing], initial=0.0))

    def highest(self, sums: Floats, centres: Iterable[float]) -> float:
        """Place of the largest sum within the width of a line around several places."""
        around = [int(np.argmax(np.where(np.abs(self.places - p) <= self.spacing, sums, -1.0))) for p in centres]
        return float(self.places[max(around, key=lambda i: sums[i])])

    def error(self, centre: float, ratios: Floats) -> float:
        """Standard deviation of a place (Rife & Boorstyn 1974, IEEE Trans. Inf. Theory 20(5), 591-598)."""
        i = int(np.argmin(np.abs(self.places - centre)))
        information = sum(max(z, 0.0) * c.reach**2 / 6.0 for z, c in zip(ratios[:, i], self.over, strict=True))
        return 1.0 / math.sqrt(information) if information > 0.0 else math.inf
