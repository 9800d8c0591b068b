"""`monitor`: amplitude and phase of orders over a record, at a known angle or without one."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from ...base.quantities import checked, interval, number, reals, samples_of, shown
from ...base.records import Along, Labelled, Result
from ...base.results import Floats
from ...base.terminal import on_screen
from ...compile.jit import borrowed, kernel, run
from ...model.controllers.monitor import Average, Demodulator, Tracker

SETTLED = 0.01  # share of the first error that is left of a settled estimate
EVEN = 0.01  # of the period: samples further apart than this are not even
TURNS = 3.0  # that the rate of a demodulator takes by default, of the lowest order


@dataclass(frozen=True, eq=False)
class Monitored(Result):
    """Orders of a signal over time.

    Attributes
    ----------
    time : (n,) array
        Times [s].
    orders : (orders,) array
        Orders of the angle; 1 where the angle was not known.
    amplitude, phase : (orders, n) arrays
        Amplitude cos(order angle + phase), in units of the signal and rad; where the angle was not known, the phase is
        that of the line itself.
    mean : (n,) array
        Mean of the signal.
    frequency : (n,) array
        Of the lowest order [rad/s].
    settled_from : float
        Time [s] from which on less than 1 % of the first error is left.
    standard_error : float
        Of an amplitude, in units of the signal, from what is left of the signal once the estimate has settled; inf
        where it has not.
    lost : int
        Samples that are NaN: over them the estimate stays as it is.
    """

    rows: ClassVar[str] = "time"
    arrays: ClassVar[Along] = {
        ("order", "time"): {"amplitude": "", "phase": "rad"},
        "time": {"mean": "", "frequency": "rad/s"},
    }

    time: Floats
    orders: Floats
    amplitude: Floats
    phase: Floats
    mean: Floats
    frequency: Floats
    settled_from: float
    standard_error: float
    lost: int

    def coordinates(self) -> Labelled:
        """Times and orders."""
        return {"time": ("time", self.time, "s"), "order": ("order", self.orders, "")}

    def __str__(self) -> str:
        lines = [
            f"Monitored: {len(self.time)} samples, settled from {self.settled_from:.4g} s; at the end, in units of the "
            f"signal (standard error {self.standard_error:.2g}):"
        ]
        for k, a, p in zip(self.orders, self.amplitude[:, -1], self.phase[:, -1], strict=True):
            lines.append(f"  order {k:g}: amplitude {a:.4g}, phase {np.degrees(p):.4g} deg")
        order, frequency, mean = self.orders[0], self.frequency[-1], self.mean[-1]
        lines.append(f"  frequency of order {order:g}: {frequency:.4g} rad/s; mean {mean:.4g}")
        if self.settled_from > self.time[-1]:
            remedy = "raise the bandwidth, or take a longer record"
            lines.append(f"  the record ends before the estimate has settled: {remedy}")
        if self.lost:
            lines.append(f"  {self.lost} samples are NaN; the estimate is constant during these samples")
        return on_screen("\n".join(lines))


def monitor(
    time: ArrayLike,
    signal: ArrayLike,
    *,
    angle: ArrayLike | None = None,
    orders: Sequence[int] = (2,),
    bandwidth: float | None = None,
    frequencies: tuple[float, float] | None = None,
) -> Monitored:
    """Follow the amplitude and phase of orders in a record, as a controller does it from sample to sample.

    Parameters
    ----------
    time : (n,) array_like
        Times [s] of even samples.
    signal : (n,) array_like
        The signal; NaN where a sample is lost.
    angle : (n,) array_like, optional
        Angle [rad] that the orders count on. Without it the strongest line within `frequencies` is tracked.
    orders : sequence of int
        Orders of the angle.
    bandwidth : float, optional
        Rate [1/s] of the estimates: they settle as exp(-bandwidth t). Default: a third of the lowest order's turns per
        second; without an angle, a twentieth of the lowest frequency.
    frequencies : (low, high), optional
        Range [rad/s] of the line that is tracked where the angle is not known.

    Returns
    -------
    Monitored
        `amplitude` (0-to-peak, in units of the signal) and `phase` [rad] of each order over `time` [s], with
        the `standard_error` of an amplitude.

    Raises
    ------
    ValueError
        If arrays differ in length, samples are not even or too slow for an order, the angle does not move, or neither
        an angle nor a range of frequencies is given.
    """
    if np.any(np.isinf(reals(signal))):
        raise ValueError("signal has infinite numbers; give NaN where a sample is lost")
    t, y = samples_of("time", time), samples_of("signal", signal)
    if t.ndim != 1 or t.shape != y.shape or len(t) < 4:
        raise ValueError(f"time has the shape {t.shape} and signal {y.shape}; give as many numbers of both, at least 4")
    if not np.all(np.isfinite(t)):
        raise ValueError("time has numbers that are not finite; remove these samples, or give their times")
    steps = np.diff(t)
    period = float(np.median(steps))
    if not period > 0.0 or np.any(np.abs(steps - period) > EVEN * period):
        raise ValueError("the samples are not even in time; put them on an even grid, NaN where there is none")
    if np.all(np.isnan(y)):
        raise ValueError("signal contains only NaN; give measured numbers")
    if angle is None:
        return _tracked(t, y, period, frequencies, bandwidth)
    return _demodulated(t, y, period, samples_of("angle", angle), tuple(orders), bandwidth)


def _demodulated(
    t: Floats, y: Floats, period: float, angle: Floats, orders: Sequence[int], bandwidth: float | None
) -> Monitored:
    if angle.shape != t.shape or not np.all(np.isfinite(angle)):
        raise ValueError(f"angle has the shape {angle.shape}; give a finite angle for each of the {len(t)} samples")
    angle = np.unwrap(angle)
    if not orders or any(k % 1 or k < 1 for k in orders):
        raise ValueError(f"orders is {shown(orders)}; give integers of at least 1")
    if len(set(orders)) < len(orders):
        raise ValueError(f"orders is {shown(orders)}; give each order once")
    speed = np.abs(np.gradient(angle, period))
    fastest = float(np.max(speed))
    if not fastest > 0.0:
        fault = "the angle is constant and has no orders; give `frequencies` to track a line in time"
        raise ValueError(fault)
    if fastest * max(orders) * period > 0.5 * np.pi:
        raise ValueError(
            f"samples every {period:.4g} s are too slow for order {max(orders)} at {fastest:.4g} rad/s; sample at "
            f"least every {0.5 * np.pi / fastest / max(orders):.3g} s"
        )
    usual = float(np.mean(speed)) * min(orders) / (2.0 * np.pi) / TURNS
    rate = usual if bandwidth is None else number("bandwidth [1/s]", bandwidth, positive=True)
    chain: Any = Average(rate, period)
    ordered = sorted(int(k) for k in orders)
    for k in ordered:
        chain = Demodulator(chain, rate, period, order=k)
    chain = checked(chain)
    rows, left = np.zeros((1 + 2 * len(ordered), len(t))), np.zeros(len(t))
    run(demodulate, chain, angle, y, rows, left)
    amplitudes, frequency = rows[1::2] - 1j * rows[2::2], np.gradient(angle, period) * ordered[0]
    lines = np.array(ordered, float), np.abs(amplitudes), np.angle(amplitudes), rows[0], frequency
    return _monitored(t, y, lines, left, chain.settling(SETTLED), chain.noise_gain())


def _tracked(
    t: Floats, y: Floats, period: float, frequencies: tuple[float, float] | None, bandwidth: float | None
) -> Monitored:
    if frequencies is None:
        fault = "there is neither an angle nor a range of frequencies; give angle=..., or frequencies=(low, high)"
        raise ValueError(fault)
    low, high = interval("frequencies [rad/s]", frequencies, positive=True)
    rate = 0.05 * low if bandwidth is None else number("bandwidth [1/s]", bandwidth, positive=True)
    tracker = checked(Tracker(low, high, rate, period))
    rows, left = np.zeros((4, len(t))), np.zeros(len(t))
    run(track, tracker, y, rows, left)
    lines = np.ones(1), np.hypot(rows[0], rows[1])[None], np.arctan2(rows[1], rows[0])[None], rows[2], rows[3]
    gain = tracker.noise_gain(float(np.mean(rows[3])))
    return _monitored(t, y, lines, left, tracker.settling(SETTLED), gain)


def _monitored(t: Floats, y: Floats, lines: tuple[Floats, ...], left: Floats, settle: float, gain: float) -> Monitored:
    """Orders over a record, with the standard error that what is left of it gives; inf where nothing has settled.

    `lines` are the fields of `Monitored` from `orders` to `frequency`.
    """
    late = left[(t >= t[0] + settle) & np.isfinite(left)]
    error = float(np.std(late) * np.sqrt(gain)) if len(late) > 1 else float("inf")
    orders, amplitude, phase, mean, frequency = lines
    return Monitored(
        time=t, orders=orders, amplitude=amplitude, phase=phase, mean=mean, frequency=frequency,
        settled_from=float(t[0] + settle), standard_error=error, lost=int(np.sum(np.isnan(y))),
    )  # fmt: skip


@kernel
def demodulate(chain: Any, angle: Any, signal: Any, rows: Any, left: Any) -> None:
    """Run nested demodulators over a record; write their numbers, and what was not expected."""
    angle, signal, rows, left = borrowed((angle, signal, rows, left))
    state = chain.start()
    for k in range(len(signal)):
        left[k] = signal[k] - chain.expected(state, angle[k])
        state = chain.update(state, angle[k], signal[k])
        chain.written(state, rows, k)


@kernel
def track(tracker: Any, signal: Any, rows: Any, left: Any) -> None:
    """Run a tracker over a record; write its numbers, and what was not expected."""
    signal, rows, left = borrowed((signal, rows, left))
    state = tracker.start()
    for k in range(len(signal)):
        state = tracker.update(state, signal[k])
        left[k] = signal[k] - state[0] - state[2]
        for i in range(4):
            rows[i, k] = state[i]
