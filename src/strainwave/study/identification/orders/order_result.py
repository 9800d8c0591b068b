"""Result of a scan of runs for orders: lines with their errors, and a delay."""

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from ....base.facts import aligned
from ....base.number_text import number
from ....base.quantities import number as checked_number
from ....base.quantities import numbers, shown
from ....base.records import Labelled, Result
from ....base.results import Floats
from ....base.terminal import on_screen
from ....base.units import ARCSEC
from ....model.excitation import KinematicError, Line
from ..intervals import Interval, interval
from ..run import angle_before, refuse_descending
from .order_search import Kind, Pair
from .places import CHANCE
from .responses import Responses

RUN_FACTOR, RUNS_FACTOR = 1.1, 1.5  # of a speed up to which runs tell it: a run alone, and runs at several speeds
FEWEST_SPEEDS = 3  # that tell how much an amplitude varies with the speed
VARIATION = 0.05  # of the mean amplitude in the runs, from which one amplitude is not that of all


@dataclass(frozen=True)
class OrderLine:
    """One line: amplitude cos(order angle(t - delay) + phase).

    Attributes
    ----------
    order : float
        Order on the angle of the runs; for kind "frequency" that at the mean speed of the first run.
    order_error : float
        What the order may be off by: half of what runs over part of a turn cannot resolve, and two standard deviations;
        0 of an order that was given.
    amplitude, amplitude_error : float
        0-to-peak, and its standard deviation, in the unit of the runs.
    phase, phase_error : float
        [rad].
    kind : {"order", "frequency", "undecided"}
        Whether it stays with the angle or with the time; "given" orders are "order".
    why : str
        The reason.
    false_alarm : float
        Probability that noise has such a line; 0 of an order that was given.
    frequency : float
        [Hz], of the kind "frequency"; NaN otherwise.
    by_run, by_run_error : (runs,) arrays
        Amplitude in each run, and its standard deviation.
    same : float
        Probability that amplitudes as different come from one.
    freedom : float
        Degrees of freedom of the standard deviations.
    pairs : tuple of (int, int)
        Pairs (j, k) of turns that it may belong to, j of the motor and k of the output: more than one where the runs
        cannot tell them apart, none without a ratio or where none is near.
    """

    order: float
    order_error: float
    amplitude: float
    amplitude_error: float
    phase: float
    phase_error: float
    kind: Kind
    why: str
    false_alarm: float
    frequency: float
    by_run: Floats
    by_run_error: Floats
    same: float
    freedom: float
    pairs: tuple[Pair, ...] = ()

    @property
    def pair(self) -> Pair | None:
        """The pair of turns that it belongs to; None where the runs cannot tell, or the ratio is not known."""
        return self.pairs[0] if len(self.pairs) == 1 else None

    def interval(self, name: str = "amplitude", level: float = 0.95) -> Interval:
        """Interval of "amplitude", from 0 on, "phase" or "order"."""
        if name == "order":
            return Interval(self.order - self.order_error, self.order + self.order_error)
        if name not in ("amplitude", "phase"):
            raise ValueError(f"{shown(name)} has no interval; a line has intervals of amplitude, phase and order")
        bounds = interval(getattr(self, name), getattr(self, f"{name}_error"), self.freedom, level)
        return bounds if name == "phase" else Interval(max(bounds.low, 0.0), bounds.high)


@dataclass(frozen=True, eq=False)
class OrderScan(Result):
    """Lines of one or several runs.

    Attributes
    ----------
    lines : tuple of OrderLine
        By order.
    delay, delay_error : float
        Time [s] by which the value lags behind the angle, and its standard deviation: 0 and infinite where all runs
        have one speed, which cannot tell it from a phase.
    speeds : (runs,) array
        Mean speeds [rad/s].
    residual : float
        Root mean square of what is left, slow parts and lines taken out.
    base : float
        Number of which most lines are multiples, such as the ratio of the gear; 0 where there is none.
    notes : tuple of str
        What the runs cannot tell.
    unit : str
        Of the values.
    freedom : float
        Degrees of freedom of the delay's deviation.
    forward, backward : tuple of OrderLine
        Lines of the runs of one direction alone, where there are both.
    responses : Responses or None
        How the lines change with the speed, where the runs show it: a hold of the channel, delays and growth of lines.
    """

    rows: ClassVar[str] = "line"

    lines: tuple[OrderLine, ...]
    delay: float
    delay_error: float
    speeds: Floats
    residual: float
    base: float
    notes: tuple[str, ...]
    unit: str
    freedom: float
    forward: tuple[OrderLine, ...] = ()
    backward: tuple[OrderLine, ...] = ()
    responses: Responses | None = None

    @property
    def varying(self) -> tuple[OrderLine, ...]:
        """Lines over the angle whose amplitude differs between runs, by more than their errors and by 5 %."""
        over_angle = [line for line in self.lines if line.kind != "frequency" and line.same < CHANCE / len(self.lines)]
        return tuple(line for line in over_angle if np.ptp(line.by_run) > VARIATION * np.mean(line.by_run))

    def line(self, order: float) -> OrderLine:
        """The line nearest to an order."""
        if not self.lines:
            raise ValueError("the scan has no lines")
        return min(self.lines, key=lambda line: abs(line.order - order))

    def delay_interval(self, level: float = 0.95) -> Interval:
        """Interval of the delay [s]."""
        return interval(self.delay, self.delay_error, self.freedom, level)

    def predict(self, time: ArrayLike, angle: ArrayLike) -> Floats:
        """Sum of the lines that stay with the angle, in another motion.

        Parameters
        ----------
        time, angle : (n,) array_like
            Times [s], ascending, and angles [rad], from the same zero as those of the runs; the shaft may turn back.

        Returns
        -------
        (n,) array
            Without mean and slow parts, which belong to each run.
        """
        t, a = numbers("time", time), numbers("angle", angle)
        if len(t) != len(a) or len(t) < 2:
            raise ValueError(f"time has {len(t)} samples and angle {len(a)}; give equally many, 2 at least")
        refuse_descending(t)
        if self.responses is not None:
            return self.responses.value(t, a)
        theta = angle_before(t, a, self.delay)
        lines = [Line(line.order, line.amplitude, line.phase) for line in self.lines if line.kind != "frequency"]
        return np.asarray(KinematicError(tuple(lines)).value(theta))

    def amplitude_at(self, order: float, speed: float, level: float = 0.95) -> tuple[float, float]:
        """Amplitude of a line at another speed, from runs at speeds near it.

        Runs within 10 % of the speed tell it alone. Otherwise three speeds or more must reach it in steps of at most a
        factor of 1.5; the interval then holds how much they differ. A resonance narrower than the steps is not seen.

        Parameters
        ----------
        order : float
            Order of the line.
        speed : float
            Speed [rad/s] of the angle that the runs have, negative backward.
        level : float
            Probability that the interval holds the amplitude.

        Returns
        -------
        value, half : float
            Amplitude, 0-to-peak, and half the width of its interval, in the unit of the values.

        Raises
        ------
        ValueError
            If no line over the angle is there, or the runs do not tell it at this speed.
        """
        over_angle = [line for line in self.lines if line.kind != "frequency"]
        lines = [line for line in over_angle if abs(line.order - order) <= max(line.order_error, 1e-6 * order)]
        if not lines:
            raise ValueError(f"the scan has no line at order {order:g}; give orders=[{order:g}] to fit it")
        line, speed = min(lines, key=lambda some: abs(some.order - order)), checked_number("speed [rad/s]", speed)
        speeds, sizes, errors = np.abs(self.speeds), line.by_run, line.by_run_error
        close = (speeds <= abs(speed) * RUN_FACTOR) & (speeds * RUN_FACTOR >= abs(speed))
        if np.any(same_way := close & (self.speeds * speed > 0.0)):
            close = same_way
        if np.any(close):
            weights = 1.0 / errors[close] ** 2
            value = float(np.average(sizes[close], weights=weights))
            excess = float(np.sum(weights * (sizes[close] - value) ** 2)) / max(int(np.sum(close)) - 1, 1)
            ends = interval(value, math.sqrt(max(excess, 1.0) / float(np.sum(weights))), math.inf, level)
            return value, 0.5 * (ends.high - ends.low)
        ascending = np.argsort(speeds)
        steps = 1 + np.flatnonzero(speeds[ascending][1:] > RUN_FACTOR * speeds[ascending][:-1])
        groups = np.split(ascending, steps)
        _refuse_far(order, abs(speed), np.array([float(np.mean(speeds[group])) for group in groups]))
        means, many = np.array([float(np.mean(sizes[group])) for group in groups]), len(groups)
        deviation = math.sqrt(float(np.var(means, ddof=1)) * (1.0 + 1.0 / many) + float(np.mean(errors**2)))
        ends = interval(float(np.mean(means)), deviation, float(many - 1), level)
        return float(np.mean(means)), 0.5 * (ends.high - ends.low)

    def coordinates(self) -> Labelled:
        """Orders."""
        return {"order": ("line", np.array([line.order for line in self.lines]), "")}

    def variables(self) -> Labelled:
        """Amplitudes and phases."""
        angles = {"phase": "rad", "phase_error": "rad", "order_error": ""}
        units = {"amplitude": self.unit, "amplitude_error": self.unit} | angles
        return {n: ("line", np.array([getattr(line, n) for line in self.lines]), u) for n, u in units.items()}

    def __str__(self) -> str:
        size, unit = (ARCSEC, " arcsec") if self.unit == "rad" else (1.0, f" {self.unit}" if self.unit else "")
        speeds = ", ".join(dict.fromkeys(f"{speed:.4g}" for speed in self.speeds))
        lines = [f"Order scan of {len(self.speeds)} runs at {speeds} rad/s"]
        rows = [
            ["line", f"amplitude{unit}", "95 %: from", "to", "phase deg", "+-", "false alarm", "order or frequency"]
        ]
        for line in self.lines:
            sizes = [number(value / size) for value in (line.amplitude, *line.interval())]
            order = f"order {line.order:g} +- {line.order_error:.2g}"
            title = f"{line.frequency:.4g} Hz" if line.kind == "frequency" else order
            phase = number(math.degrees(line.phase)), number(math.degrees(line.phase_error), 2)
            rows.append([title, *sizes, *phase, f"{line.false_alarm:.0e}", line.why])
        lines += [f"  {row}" for row in aligned(rows) if self.lines]
        if math.isfinite(self.delay_error):
            low, high = [number(1e3 * end) for end in self.delay_interval()]
            lines.append(f"  the value lags {number(1e3 * self.delay)} ms behind the angle (95 %: {low} to {high})")
        lines.append(f"  residual: {number(self.residual / size)}{unit} rms without slow parts and lines")
        return on_screen("\n".join(lines + [f"  {note}" for note in self.notes]))


def _refuse_far(order: float, speed: float, speeds: Floats) -> None:
    """Refuse a speed [rad/s] that the measured speeds, ascending, do not bracket closely (ValueError).

    The neighbours must lie within a factor of `RUNS_FACTOR` squared of each other, one of them within `RUNS_FACTOR`.
    """
    reached = [*speeds[(speeds < speed)][-1:], speed, *speeds[speeds > speed][:1]]
    steps = [b / a for a, b in pairwise(reached)] if speed > 0.0 else [math.inf]
    if len(speeds) >= FEWEST_SPEEDS and max(steps) <= RUNS_FACTOR * RUNS_FACTOR and min(steps) <= RUNS_FACTOR:
        return
    hertz = ", ".join(f"{order * one / (2.0 * math.pi):.3g}" for one in speeds)
    raise ValueError(
        f"order {order:g} was measured at {', '.join(f'{one:.3g}' for one in speeds)} rad/s, which is {hertz} Hz: at "
        f"{speed:.3g} rad/s or {order * speed / (2.0 * math.pi):.3g} Hz a resonance may change it; give a run within "
        f"10 % of it, or runs at {FEWEST_SPEEDS} speeds or more in steps of at most a factor of {RUNS_FACTOR:g}"
    )
