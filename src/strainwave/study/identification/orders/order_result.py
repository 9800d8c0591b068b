"""What a scan of runs for orders finds: lines with their errors, and a delay."""

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from ....base.arguments import typed
from ....base.quantities import numbers, shown
from ....base.records import Labelled, Result
from ....base.results import Floats
from ....base.sentences import number, on_screen
from ....base.units import ARCSEC
from ..intervals import Interval, interval
from ..run import angle_before, refuse_descending
from .order_search import Kind
from .places import RARE

VARIES = 0.05  # of the mean amplitude in the runs, from which one amplitude is not that of all


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

    def interval(self, name: str = "amplitude", level: float = 0.95) -> Interval:
        """Interval of "amplitude", from 0 on, "phase" or "order"."""
        if name == "order":
            return Interval(self.order - self.order_error, self.order + self.order_error)
        if name not in ("amplitude", "phase"):
            raise ValueError(f"{shown(name)} has no interval; a line has those of amplitude, phase and order")
        found = interval(getattr(self, name), getattr(self, f"{name}_error"), self.freedom, level)
        return found if name == "phase" else Interval(max(found.low, 0.0), found.high)


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

    @property
    def varying(self) -> tuple[OrderLine, ...]:
        """Lines over the angle whose amplitude differs between runs, by more than their errors and by 5 %."""
        over_angle = [line for line in self.lines if line.kind != "frequency" and line.same < RARE / len(self.lines)]
        return tuple(line for line in over_angle if np.ptp(line.by_run) > VARIES * np.mean(line.by_run))

    @typed
    def line(self, order: float) -> OrderLine:
        """The line nearest to an order."""
        if not self.lines:
            raise ValueError("the scan has no lines")
        return min(self.lines, key=lambda line: abs(line.order - order))

    @typed
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
        theta = angle_before(t, a, self.delay)
        total = np.zeros(len(theta))
        for line in self.lines:
            if line.kind != "frequency":
                total += line.amplitude * np.cos(line.order * theta + line.phase)
        return total

    def coordinates(self) -> Labelled:
        """Orders."""
        return {"order": ("line", np.array([line.order for line in self.lines]), "")}

    def variables(self) -> Labelled:
        """Amplitudes and phases."""
        names = {"amplitude": self.unit, "amplitude_error": self.unit, "phase": "rad", "phase_error": "rad"}
        table = {n: ("line", np.array([getattr(line, n) for line in self.lines]), u) for n, u in names.items()}
        errors = np.array([line.order_error for line in self.lines])
        return table | {"order_error": ("line", errors, "")}

    def __str__(self) -> str:
        size, unit = (ARCSEC, " arcsec") if self.unit == "rad" else (1.0, f" {self.unit}" if self.unit else "")
        speeds = ", ".join(dict.fromkeys(f"{speed:.4g}" for speed in self.speeds))
        lines = [f"Order scan of {len(self.speeds)} runs at {speeds} rad/s"]
        for line in self.lines:
            low, high = [number(end / size, 4) for end in line.interval()]
            place = (
                f"{line.frequency:.4g} Hz"
                if line.kind == "frequency"
                else f"order {line.order:g} +- {line.order_error:.2g}"
            )
            phase = f"{number(math.degrees(line.phase))} +- {number(math.degrees(line.phase_error), 2)} deg"
            told = f"{number(line.amplitude / size)}{unit} (95 %: {low} to {high}), phase {phase}"
            lines.append(f"  {place}: {told}; {line.why}; false alarm {line.false_alarm:.0e}")
        if math.isfinite(self.delay_error):
            low, high = [number(1e3 * end) for end in self.delay_interval()]
            lines.append(f"  the value lags {number(1e3 * self.delay)} ms behind the angle (95 %: {low} to {high})")
        lines.append(f"  left: {number(self.residual / size)}{unit} rms, slow parts and lines taken out")
        return on_screen("\n".join(lines + [f"  {note}" for note in self.notes]))
