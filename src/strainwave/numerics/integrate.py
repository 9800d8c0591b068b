"""`simulate`: integration in time of any system with `rhs(phase, y)`.

`Dopri5` adapts its step and, where the system has `breakpoints()` (torsions where its law is not smooth), ends a step
on each of them, so that the order of the method is kept. `Rk4` and `Dop8` use fixed steps.
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from .._dispatch import is_spring
from .._jit import axpy, kernel, run
from ..quantities import number, positive_count, shown, with_parts
from ..results import Floats, Status, Trajectory
from .record import Record
from .steps import dense_output, dop8_step, dopri5_step, rk4_step
from .switches import first_switch, set_sides, step_onto

BUDGET = 65536  # steps per call of a kernel: between calls the user can interrupt
DONE, DIVERGED, PAUSED = 0, 1, 2
BOUND = 1e30  # of every state: far beyond any physics, and its powers in a law still fit a float
MOST_RECORDED = 100_000_000
LEAST = math.log(1e-4)  # the step control remembers no smaller error than this


@dataclass(frozen=True)
class Dopri5:
    """Adaptive Dormand-Prince 5(4) with dense output and located switches; rtol and atol apply to every state.

    Raises
    ------
    ValueError
        If rtol is below 1e-14 (rounding alone is larger), atol is not positive or max_steps is below 1.
    """

    rtol: float = 1e-9
    atol: float = 1e-12
    max_steps: int = 10_000_000

    def __post_init__(self) -> None:
        for name in ("rtol", "atol"):
            number(f"Dopri5.{name}", getattr(self, name))
        if not (1e-14 <= self.rtol < 1.0 and self.atol > 0.0):
            raise ValueError(
                f"Dopri5 has rtol {self.rtol:g} and atol {self.atol:g}; it needs 1e-14 <= rtol < 1, atol > 0"
            )
        positive_count("Dopri5.max_steps", self.max_steps)


@dataclass(frozen=True)
class Rk4:
    """Classical Runge-Kutta with a fixed step.

    `steps` per shortest time scale (2 pi/omega_0 at the largest stiffness met, and the forcing period), or exactly
    `steps_per_period` per period of the base angle. Second order only across a breakpoint.

    Raises
    ------
    ValueError
        If a number of steps is no whole number of at least 1.
    """

    steps: int = 64
    steps_per_period: int | None = None

    def __post_init__(self) -> None:
        name = type(self).__name__
        positive_count(f"{name}.steps", self.steps)
        if self.steps_per_period is not None:
            positive_count(f"{name}.steps_per_period", self.steps_per_period)


@dataclass(frozen=True)
class Dop8(Rk4):
    """The eighth-order method of DOP853 with a fixed step; `steps` and `steps_per_period` as in `Rk4`."""

    steps: int = 16


@kernel
def error_norm(error: Any, y: Any, y_end: Any, rtol: float, atol: float) -> float:
    """Root mean square of the error in units of the tolerance (Hairer, Norsett & Wanner I, eq. II.4.11)."""
    total = 0.0
    for i in range(len(y)):
        scaled = error[i] / (atol + rtol * max(abs(y[i]), abs(y_end[i])))
        total += scaled * scaled
    return math.sqrt(total / len(y))


@kernel
def bounded(y: Any, bound: float) -> bool:
    """Whether every state is below the bound (False for NaN)."""
    good = True
    for i in range(len(y)):
        good = good and abs(y[i]) < bound
    return good


@kernel
def first_step(system: Any, omega: float, t: float, y: Any, k: Any, rtol: float, atol: float) -> float:
    """Starting step size (Hairer, Norsett & Wanner I, sec. II.4)."""
    zero = axpy(y, -1.0, y)
    d0, d1 = error_norm(y, y, zero, rtol, atol), error_norm(k, y, zero, rtol, atol)
    h0 = 1e-6 if d0 < 1e-5 or d1 < 1e-5 else 0.01 * d0 / d1
    k1 = system.rhs(omega * (t + h0), axpy(y, h0, k))
    d2 = error_norm(axpy(k1, -1.0, k), y, zero, rtol, atol) / h0
    largest = max(d1, d2)
    h1 = max(1e-6, h0 * 1e-3) if largest <= 1e-15 else (0.01 / largest) ** 0.2
    return float(min(100.0 * h0, h1))


@kernel
def store(out_t: Any, out_y: Any, out_rate: Any, place: int, t: float, y: Any, k: Any) -> None:
    """Write one sample (time, state, rate) into the output arrays."""
    out_t[place] = t
    for i in range(len(y)):
        out_y[i, place], out_rate[i, place] = y[i], k[i]


@kernel
def adaptive(
    system: Any, omega: float, t: float, y: Any, t_end: float, h: float, rtol: float, atol: float,
    breakpoints: Any, sides: Any, at: int, samples: Any, filled: int, budget: int,
    out_t: Any, out_y: Any, out_rate: Any,
) -> Any:  # fmt: skip
    """Integrate from t towards t_end in at most `budget` attempts; record every step, or the samples inside them."""
    k = system.rhs(omega * t, y)
    if breakpoints is not None:
        set_sides(system, omega, t, y, k, breakpoints, sides, at)
    every = len(samples) == 0
    status, steps, rejected, switches, old = PAUSED, 0, 0, 0, LEAST
    if h <= 0.0:
        h = first_step(system, omega, t, y, k, rtol, atol)
    while status == PAUSED and steps + rejected < budget:
        last = t + 1.0000001 * h >= t_end
        if last:
            h = t_end - t
        y1, k1, error, dense = dopri5_step(system, omega * t, omega * h, y, h, k)
        tried, at = h, -1
        if breakpoints is not None and bounded(y1, BOUND):
            s, at = first_switch(system, omega, t, h, y, k, y1, k1, dense, breakpoints, sides)
            if at >= 0:
                there, h, y1, k1, error, dense = step_onto(system, omega, t, s * h, y, k, breakpoints[at], t_end)
                last, at = False, at if there else -1
        e = error_norm(error, y, y1, rtol, atol)
        if not (e <= 1.0 and bounded(y1, BOUND)):
            rejected += 1
            h *= max(0.2, 0.9 * e**-0.2) if 1.0 < e < BOUND else 0.1
            if not t + h > t:
                status = DIVERGED
            continue
        # PI control (Hairer & Wanner II, sec. IV.2): 0.9 h e_old^0.04 e^-0.17, with one logarithm for two powers.
        log_e = math.log(max(e, 1e-10))
        h_next = h * min(10.0, max(0.2, 0.9 * math.exp(0.04 * old - 0.17 * log_e)))
        old = max(log_e, LEAST)
        if at >= 0:
            switches += 1
            h_next = tried
        t1 = t_end if last else t + h
        if every and t1 > t:
            store(out_t, out_y, out_rate, filled, t1, y1, k1)
            filled += 1
        while filled < len(samples) and samples[filled] <= t1:
            there = dense_output((samples[filled] - t) / h, h, y, k, y1, k1, dense)
            rate = system.rhs(omega * samples[filled], there)
            store(out_t, out_y, out_rate, filled, samples[filled], there, rate)
            filled += 1
        t, y, k, h = t1, y1, k1, h_next
        steps += 1
        if t >= t_end:
            status = DONE
        elif breakpoints is not None:
            set_sides(system, omega, t, y, k, breakpoints, sides, at)
    return t, y, h, at, filled, status, steps, rejected, switches


@kernel
def fixed(
    system: Any, omega: float, t: float, y: Any, h: float, eighth: bool, samples: Any, filled: int, budget: int,
    out_t: Any, out_y: Any, out_rate: Any,
) -> Any:  # fmt: skip
    """Integrate from sample to sample, in at most `budget` steps, with equal steps no longer than h."""
    status, steps = PAUSED, 0
    while status == PAUSED and steps < budget:
        n = max(1, math.ceil((samples[filled] - t) / h * (1.0 - 1e-12)))
        step = (samples[filled] - t) / n
        now = min(n, budget - steps)
        for i in range(now):
            if eighth:
                y = dop8_step(system, omega * (t + i * step), omega * step, y, step)
            else:
                y = rk4_step(system, omega * (t + i * step), omega * step, y, step)
        steps += now
        t = samples[filled] if now == n else t + now * step
        k = system.rhs(omega * t, y)
        if not (bounded(y, BOUND) and bounded(k, math.inf)):
            status = DIVERGED
        elif now == n:
            store(out_t, out_y, out_rate, filled, t, y, k)
            filled += 1
            if filled == len(samples):
                status = DONE
    return t, y, filled, status, steps


def simulate(system: Any, y0: ArrayLike, t: float | ArrayLike, *, method: Dopri5 | Rk4 = Dopri5()) -> Trajectory:
    """Integrate a system in time.

    Parameters
    ----------
    system : NamedTuple
        Anything with `rhs(phase, y)`; its `omega` [rad/s] turns time into phase (1 where it has none). Switches are
        located where it has `breakpoints()`.
    y0 : (states,) array_like
        State at the first time; for an `Oscillator` x [rad], x' [rad/s] and the internal states of its law, if any.
    t : float or array_like
        End time [s] (from 0), or (start, end): every step is recorded. More than two increasing times: the solution is
        recorded there, by dense output.
    method : Dopri5, Rk4 or Dop8
        Integration method and its tolerances or steps.

    Returns
    -------
    Trajectory
        `status` tells whether the end was reached; every value in it is finite. An interrupt (Ctrl-C) ends the run with
        what is finished and the status INTERRUPTED.

    Raises
    ------
    ValueError
        If y0 or t are not finite, of the wrong shape, or t does not increase; if y0 does not have the system's number
        of states; if a parameter of the system is out of range.
    TypeError
        If the system has no rhs, or holds something that is not a number or a model.

    References
    ----------
    Hairer, Norsett & Wanner, Solving Ordinary Differential Equations I, 2nd ed., secs. II.4-II.6.
    """
    system = with_parts("simulate", system, "rhs")
    if not isinstance(method, Dopri5 | Rk4):
        raise TypeError(f"method is {shown(method)}; it must be Dopri5(...), Rk4(...) or Dop8(...)")
    times = _times(t)
    y, rate = _start(system, times[0], y0)
    samples = len(times) if len(times) > 2 else 0
    with np.errstate(all="ignore"):  # the status tells of an overflow, also where nothing is compiled
        if isinstance(method, Dopri5):
            return _adaptive(system, y, times, method, Record(times[0], times[-1], y, rate, samples))
        return _fixed(system, y, rate, times, method)


def _numbers(value: ArrayLike, sentence: str) -> Floats:
    try:
        array = np.atleast_1d(np.asarray(value, float))
    except (TypeError, ValueError):
        raise ValueError(f"{sentence}, not {shown(value)}") from None
    if array.ndim != 1 or array.size == 0 or not np.all(np.isfinite(array)):
        raise ValueError(f"{sentence}, not {shown(value)}")
    return array


def _times(t: float | ArrayLike) -> Floats:
    sentence = "t must be an end time or finite increasing times"
    times = _numbers(t, sentence)
    if times.size == 1:
        times = np.array([0.0, times[0]])
    if not np.all(np.diff(times) > 0.0):
        raise ValueError(f"{sentence}, not {shown(t)}")
    if np.spacing(np.max(np.abs(times))) > 1e-6 * (times[-1] - times[0]):
        raise ValueError(f"t = {times[0]:g} s is too far from 0 for floats to resolve the span; start nearer to 0")
    return times


def _start(system: Any, t: float, y0: ArrayLike) -> tuple[Any, Any]:
    """Return the starting state and its rate as tuples, after checking that they fit the system."""
    y = tuple(_numbers(y0, "y0 must be a finite state, for an Oscillator (x, x')").tolist())
    name = type(system).__name__
    if hasattr(system, "state_names") and len(y) != len(system.state_names()):
        names = ", ".join(system.state_names())
        raise ValueError(f"y0 has {len(y)} states but {name} has {len(system.state_names())}: {names}; give each one")
    try:
        rate = tuple(float(v) for v in system.rhs(float(getattr(system, "omega", 1.0) * t), y))
    except (ArithmeticError, IndexError, ValueError) as error:
        raise ValueError(f"{name}.rhs does not accept y0 = {y} ({error}); give it as many states as it has") from error
    if len(rate) != len(y):
        raise ValueError(f"y0 has {len(y)} states but {name} has {len(rate)}; give as many")
    if not all(math.isfinite(v) and abs(u) < BOUND for u, v in zip(y, rate, strict=True)):
        raise ValueError(f"at y0 = {y} {name}.rhs gives the rates {rate}; start closer to equilibrium")
    return y, rate


def _adaptive(system: Any, y: Any, times: Floats, method: Dopri5, record: Record) -> Trajectory:
    omega = float(getattr(system, "omega", 1.0))
    places = system.breakpoints() if hasattr(system, "breakpoints") else ()
    breakpoints = np.array(places, float) if places else None  # None: the kernel for smooth laws leaves the search out
    samples = times if record.samples else np.empty(0)
    t, t_end, h, at, sides = float(times[0]), float(times[-1]), 0.0, -1, np.ones(len(places))
    steps, rejected, switches, status = 0, 0, 0, PAUSED
    try:
        while status == PAUSED and steps + rejected < method.max_steps:
            budget = record.room(min(BUDGET, method.max_steps - steps - rejected))
            t, y, h, at, filled, status, new, bad, crossed = run(
                adaptive, system, omega, t, y, t_end, h, float(method.rtol), float(method.atol),
                breakpoints, sides, at, samples, record.filled, budget, *record.buffers(),
            )  # fmt: skip
            record.keep(filled, t)
            steps, rejected, switches = steps + new, rejected + bad, switches + crossed
    except KeyboardInterrupt:
        return record.trajectory(Status.INTERRUPTED, steps, rejected, switches)
    outcome = {DONE: Status.OK, DIVERGED: Status.DIVERGED, PAUSED: Status.TOO_MANY_STEPS}[status]
    return record.trajectory(outcome, steps, rejected, switches)


def _fixed(system: Any, y: Any, rate: Any, times: Floats, method: Rk4) -> Trajectory:
    omega = float(getattr(system, "omega", 1.0))
    t, steps, status, samples = float(times[0]), 0, PAUSED, times
    record = Record(t, times[-1], y, rate, 0)
    try:
        h = _fixed_step(system, omega, y, rate, times, method)
        if len(times) == 2:
            n = math.ceil((times[-1] - t) / h * (1.0 - 1e-12))
            if n > MOST_RECORDED:
                raise ValueError(
                    f"{n:.3g} steps are too many to record; give the times at which to record, or fewer steps"
                )
            samples = np.linspace(t, times[-1], 1 + n)
        record = Record(t, times[-1], y, rate, len(samples))
        while status == PAUSED:
            eighth = isinstance(method, Dop8)
            t, y, filled, status, new = run(
                fixed, system, omega, t, y, h, eighth, samples, record.filled, BUDGET, *record.buffers()
            )
            record.keep(filled, t)
            steps += new
    except KeyboardInterrupt:
        return record.trajectory(Status.INTERRUPTED, steps)
    return record.trajectory(Status.OK if status == DONE else Status.DIVERGED, steps)


def _fixed_step(system: Any, omega: float, y: Any, rate: Any, times: Floats, method: Rk4) -> float:
    """Step that resolves the shortest time scale, found from the Jacobian along a coarse adaptive solution."""
    if method.steps_per_period is not None:
        if omega == 0.0:
            raise ValueError("with omega = 0 there is no period; give steps instead of steps_per_period")
        return 2.0 * math.pi / abs(omega) / method.steps_per_period
    if not hasattr(system, "jacobian") or not is_spring(system):
        name = type(system).__name__
        raise TypeError(f"{name} has no jacobian to choose a step from; give steps_per_period or use Dopri5")
    coarse = _adaptive(system, y, times[[0, -1]], Dopri5(rtol=1e-3, atol=1e-6), Record(times[0], times[-1], y, rate, 0))
    if coarse.status is Status.INTERRUPTED:
        raise KeyboardInterrupt
    # On the way to infinity the stiffness has no bound; what counts is the stiffness before.
    end = (
        len(coarse.t) if coarse.status else int(np.searchsorted(coarse.t, times[0] + 0.99 * (coarse.t[-1] - times[0])))
    )
    use = slice(0, max(1, end), max(1, end // 2000))
    rows = system.jacobian(omega * coarse.t[use], tuple(coarse.y[:, use]))
    entries = np.array([[np.broadcast_to(entry, coarse.t[use].shape) for entry in row] for row in rows], float)
    fastest = float(np.max(np.abs(np.linalg.eigvals(np.moveaxis(entries, 2, 0)))))
    order = max((1, *system.orders())) if hasattr(system, "orders") else 1
    return 2.0 * math.pi / max(fastest, abs(omega) * order) / method.steps
