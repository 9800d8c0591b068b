"""`simulate`: integration in time of any system with `rhs(phase, y)`.

`Dopri5` adapts its step and, where the system has `breakpoints()` (torsions at which its law is not smooth), ends a step on
each of them, so that the order of the method is kept. `Rk4` and `Dop8` use fixed steps.
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from .._jit import axpy, kernel, run, torsion
from ..quantities import floated, parameters
from ..results import Floats, Status, Trajectory
from .steps import dense_output, dop8_step, dopri5_step, rk4_step

BUDGET = 65536  # steps per call of a kernel: between calls the user can interrupt
DONE, DIVERGED, PAUSED = 0, 1, 2
BOUND = 1e100
SCAN = 4  # places inside a step where the torsion is compared with the breakpoints


@dataclass(frozen=True)
class Dopri5:
    """Adaptive Dormand-Prince 5(4) with dense output and located switches; atol applies to every state."""

    rtol: float = 1e-9
    atol: float = 1e-12
    max_steps: int = 100_000_000


@dataclass(frozen=True)
class Rk4:
    """Classical Runge-Kutta with a fixed step.

    `steps` per shortest time scale (2 pi/omega_0 at the largest stiffness met, and the forcing period), or exactly
    `steps_per_period` per period of the base angle. Second order only across a breakpoint.
    """

    steps: int = 64
    steps_per_period: int | None = None


@dataclass(frozen=True)
class Dop8:
    """The eighth-order method of DOP853 with a fixed step; `steps` and `steps_per_period` as in `Rk4`."""

    steps: int = 16
    steps_per_period: int | None = None


@kernel
def error_norm(error: Any, y: Any, y_end: Any, rtol: float, atol: float) -> float:
    """Root mean square of the error in units of the tolerance (Hairer, Norsett & Wanner I, eq. II.4.11)."""
    total = 0.0
    for i in range(len(y)):
        scaled = error[i] / (atol + rtol * max(abs(y[i]), abs(y_end[i])))
        total += scaled * scaled
    return (total / len(y)) ** 0.5


@kernel
def bounded(y: Any) -> bool:
    """Whether every state is finite and below the bound (False for NaN)."""
    good = True
    for i in range(len(y)):
        good = good and abs(y[i]) < BOUND
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
def set_sides(system: Any, omega: float, t: float, y: Any, k: Any, breakpoints: Any, sides: Any, at: int) -> None:
    """Record on which side of each breakpoint the torsion is; on breakpoint number `at`, where the flow carries it."""
    u = torsion(system, omega * t, y)
    ahead = torsion_rate(system, omega, t, y, k)
    for j in range(len(breakpoints)):
        away = u - breakpoints[j]
        if j == at or away == 0.0:
            away = ahead
        sides[j] = 1.0 if away >= 0.0 else -1.0


@kernel
def torsion_rate(system: Any, omega: float, t: float, y: Any, k: Any) -> float:
    """Rate of the torsion along the flow, by a central difference (only its sign and about six digits matter)."""
    d = 1e-5 / (1.0 + omega)
    after = torsion(system, omega * (t + d), axpy(y, d, k))
    before = torsion(system, omega * (t - d), axpy(y, -d, k))
    return float((after - before) / (2.0 * d))


@kernel
def first_switch(
    system: Any, omega: float, t: float, h: float, y: Any, k: Any, y1: Any, k1: Any, dense: Any, breakpoints: Any, sides: Any
) -> Any:
    """First fraction of the step at which the torsion changes side of a breakpoint, and that breakpoint (-1: none)."""
    low = 0.0
    for i in range(1, SCAN + 1):
        high = i / SCAN
        u = torsion(system, omega * (t + high * h), dense_output(high, h, y, k, y1, k1, dense))
        best, at = 2.0, -1
        for j in range(len(breakpoints)):
            if (u - breakpoints[j]) * sides[j] < 0.0:
                a, b = low, high
                for _ in range(40):
                    s = 0.5 * (a + b)
                    inside = torsion(system, omega * (t + s * h), dense_output(s, h, y, k, y1, k1, dense))
                    if (inside - breakpoints[j]) * sides[j] < 0.0:
                        b = s
                    else:
                        a = s
                if b < best:
                    best, at = b, j
        if at >= 0:
            return best, at
        low = high
    return 2.0, -1


@kernel
def adaptive(
    system: Any, omega: float, t: float, y: Any, t_end: float, h: float, rtol: float, atol: float,
    breakpoints: Any, sides: Any, at: int, samples: Any, filled: int, budget: int, out_t: Any, out_y: Any, out_rate: Any,
) -> Any:  # fmt: skip
    """Integrate from t towards t_end in at most `budget` attempts; record every step, or the samples inside the steps."""
    k = system.rhs(omega * t, y)
    if breakpoints is not None:
        set_sides(system, omega, t, y, k, breakpoints, sides, at)
    every = len(samples) == 0
    status, steps, rejected, switches, old = PAUSED, 0, 0, 0, 1e-4
    if h <= 0.0:
        h = first_step(system, omega, t, y, k, rtol, atol)
    while steps + rejected < budget:
        if t >= t_end:
            status = DONE
            break
        last = t + 1.0000001 * h >= t_end
        if last:
            h = t_end - t
        y1, k1, error, dense = dopri5_step(system, omega, t, y, h, k)
        e = error_norm(error, y, y1, rtol, atol)
        if not (e <= 1.0 and bounded(y1)):
            rejected += 1
            h *= max(0.2, 0.9 * e**-0.2) if 1.0 < e < BOUND else 0.1
            if t + h == t:
                status = DIVERGED
                break
            continue
        e = max(e, 1e-10)
        h_next = h * min(10.0, max(0.2, 0.9 * old**0.04 * e**-0.17))
        old = max(e, 1e-4)
        at = -1
        if breakpoints is not None:
            s, at = first_switch(system, omega, t, h, y, k, y1, k1, dense, breakpoints, sides)
            if at >= 0:
                # End the step on the breakpoint: the whole step is repeated, so the order of the method holds there too.
                last = False
                switches += 1
                h *= s
                for i in range(4):
                    y1, k1, error, dense = dopri5_step(system, omega, t, y, h, k)
                    gap = torsion(system, omega * (t + h), y1) - breakpoints[at]
                    rate = torsion_rate(system, omega, t + h, y1, k1)
                    if i < 3 and abs(gap) < 0.1 * h * abs(rate):
                        h -= gap / rate
        t1 = t_end if last else t + h
        if every:
            out_t[filled] = t1
            for i in range(len(y)):
                out_y[i, filled], out_rate[i, filled] = y1[i], k1[i]
            filled += 1
        else:
            while filled < len(samples) and samples[filled] <= t1:
                there = dense_output((samples[filled] - t) / h, h, y, k, y1, k1, dense)
                rate_there = system.rhs(omega * samples[filled], there)
                out_t[filled] = samples[filled]
                for i in range(len(y)):
                    out_y[i, filled], out_rate[i, filled] = there[i], rate_there[i]
                filled += 1
        t, y, k, h = t1, y1, k1, h_next
        steps += 1
        if breakpoints is not None:
            set_sides(system, omega, t, y, k, breakpoints, sides, at)
    return t, y, h, at, filled, status, steps, rejected, switches


@kernel
def fixed(
    system: Any, omega: float, t: float, y: Any, h: float, eighth: bool, samples: Any, filled: int, budget: int,
    out_t: Any, out_y: Any, out_rate: Any,
) -> Any:  # fmt: skip
    """Integrate from sample to sample with equal steps no longer than h."""
    status, steps = PAUSED, 0
    while steps < budget and status == PAUSED:
        if filled >= len(samples):
            status = DONE
            break
        n = max(1, int(math.ceil((samples[filled] - t) / h * (1.0 - 1e-12))))
        step = (samples[filled] - t) / n
        for i in range(n):
            if eighth:
                y = dop8_step(system, omega, t + i * step, y, step)
            else:
                y = rk4_step(system, omega, t + i * step, y, step)
        if not bounded(y):
            status = DIVERGED
            break
        steps += n
        t = samples[filled]
        k = system.rhs(omega * t, y)
        out_t[filled] = t
        for i in range(len(y)):
            out_y[i, filled], out_rate[i, filled] = y[i], k[i]
        filled += 1
    return t, y, filled, status, steps


def simulate(system: Any, y0: ArrayLike, t: float | ArrayLike, *, method: Dopri5 | Rk4 | Dop8 = Dopri5()) -> Trajectory:
    """Integrate a system in time.

    Parameters
    ----------
    system : NamedTuple
        Anything with `rhs(phase, y)`; its `omega` [rad/s] turns time into phase (1 where it has none). Switches are located
        where it has `breakpoints()`.
    y0 : (states,) array_like
        State at the first time; for an `Oscillator` x [rad] and x' [rad/s].
    t : float or array_like
        End time [s] (from 0), or (start, end): every step is recorded. More than two increasing times: the solution is
        recorded there, by dense output.
    method : Dopri5, Rk4 or Dop8
        Integration method and its tolerances or steps.

    Returns
    -------
    Trajectory
        `status` tells whether the end was reached; every value in it is finite.

    Raises
    ------
    ValueError
        If y0 or t are not finite, of the wrong shape, or t does not increase.

    References
    ----------
    Hairer, Norsett & Wanner, Solving Ordinary Differential Equations I, 2nd ed., secs. II.4-II.6.
    """
    system = floated(system)
    times = np.atleast_1d(np.asarray(t, float))
    start = np.atleast_1d(np.asarray(y0, float))
    if times.size == 1:
        times = np.array([0.0, times[0]])
    if times.ndim != 1 or not np.all(np.isfinite(times)) or not np.all(np.diff(times) > 0.0):
        raise ValueError(f"t must be an end time or finite increasing times, not {t!r}")
    if start.ndim != 1 or not np.all(np.isfinite(start)):
        raise ValueError(f"y0 must be a finite state, for an Oscillator (x, x'), not {y0!r}")
    bad = [p.path for p in parameters(system) if not math.isfinite(p.value)]
    if bad:
        raise ValueError(f"{type(system).__name__}.{bad[0]} is not finite; give it a number")
    if isinstance(method, Dopri5):
        return _adaptive(system, start, times, method)
    return _fixed(system, start, times, method)


def _adaptive(system: Any, y0: Floats, times: Floats, method: Dopri5) -> Trajectory:
    omega = float(getattr(system, "omega", 1.0))
    places = system.breakpoints() if hasattr(system, "breakpoints") else ()
    breakpoints = np.array(places, float) if places else None  # None: the kernel for smooth laws leaves the search out
    samples = times[1:] if len(times) > 2 else np.empty(0)
    t, y, h, at, sides = float(times[0]), tuple(y0.tolist()), 0.0, -1, np.ones(len(places))
    record = _Record(system, omega, t, y, len(samples))
    steps, rejected, switches, status = 0, 0, 0, PAUSED
    try:
        while status == PAUSED and steps + rejected < method.max_steps:
            out = record.buffers(BUDGET)
            t, y, h, at, filled, status, new, bad, crossed = run(
                adaptive, system, omega, t, y, float(times[-1]), h, method.rtol, method.atol,
                breakpoints, sides, at, samples, record.start, BUDGET, *out,
            )  # fmt: skip
            record.keep(filled)
            steps, rejected, switches = steps + new, rejected + bad, switches + crossed
    except KeyboardInterrupt:
        return record.trajectory(Status.INTERRUPTED, t, steps, rejected, switches)
    outcome = {DONE: Status.OK, DIVERGED: Status.DIVERGED, PAUSED: Status.TOO_MANY_STEPS}[status]
    return record.trajectory(outcome, t, steps, rejected, switches)


def _fixed(system: Any, y0: Floats, times: Floats, method: Rk4 | Dop8) -> Trajectory:
    omega = float(getattr(system, "omega", 1.0))
    t, y = float(times[0]), tuple(y0.tolist())
    h = _fixed_step(system, omega, y0, times, method)
    samples = times[1:]
    if len(samples) == 1:
        samples = np.linspace(t, times[-1], 1 + math.ceil((times[-1] - t) / h * (1.0 - 1e-12)))[1:]
    record = _Record(system, omega, t, y, len(samples))
    steps, status = 0, PAUSED
    try:
        while status == PAUSED:
            t, y, filled, status, new = run(
                fixed, system, omega, t, y, h, isinstance(method, Dop8), samples, record.start, BUDGET, *record.buffers(0)
            )
            record.keep(filled)
            steps += new
    except KeyboardInterrupt:
        return record.trajectory(Status.INTERRUPTED, t, steps, 0, 0)
    return record.trajectory(Status.OK if status == DONE else Status.DIVERGED, t, steps, 0, 0)


def _fixed_step(system: Any, omega: float, y0: Floats, times: Floats, method: Rk4 | Dop8) -> float:
    """Step that resolves the shortest time scale, found from the Jacobian along a coarse adaptive solution."""
    if method.steps_per_period is not None:
        return 2.0 * math.pi / omega / method.steps_per_period
    coarse = _adaptive(system, y0, times[[0, -1]], Dopri5(rtol=1e-3, atol=1e-6))
    use = slice(None, None, max(1, len(coarse.t) // 2000))
    rows = system.jacobian(omega * coarse.t[use], tuple(coarse.y[:, use]))
    entries = np.array([[np.broadcast_to(entry, coarse.t[use].shape) for entry in row] for row in rows], float)
    fastest = float(np.max(np.abs(np.linalg.eigvals(np.moveaxis(entries, 2, 0)))))
    order = max((1, *system.orders())) if hasattr(system, "orders") else 1
    return 2.0 * math.pi / max(fastest, omega * order) / method.steps


class _Record:
    """The recorded samples of a running integration, kept in pieces of a step budget."""

    def __init__(self, system: Any, omega: float, t: float, y: Any, samples: int) -> None:
        rate = system.rhs(omega * t, y)
        self.first = (np.array([t]), np.array([y]).T, np.array([rate], float).T)
        self.pieces: list[tuple[Floats, ...]] = [self.first]
        self.samples, self.states, self.start = samples, len(y), 0
        self.out: tuple[Floats, ...] = ()

    def buffers(self, budget: int) -> tuple[Floats, ...]:
        """Arrays for the kernel: one for all samples, or a new one for each piece of steps."""
        if not (self.samples and self.out):
            n = self.samples or budget
            self.out = (np.empty(n), np.empty((self.states, n)), np.empty((self.states, n)))
        return self.out

    def keep(self, filled: int) -> None:
        """Take over what the kernel has filled."""
        if self.samples:
            self.start = filled
        else:
            self.pieces.append(tuple(a[..., :filled].copy() for a in self.out))

    def trajectory(self, status: Status, t: float, steps: int, rejected: int, switches: int) -> Trajectory:
        """Assemble the result with one sentence on how it ended."""
        if self.samples:
            self.pieces = [self.first, tuple(a[..., : self.start] for a in self.out)]
        times, y, rate = (np.concatenate(parts, axis=-1) for parts in zip(*self.pieces, strict=True))
        message = status.value if status else f"stopped at t = {t:.6g} s: {status.value}"
        return Trajectory(times, y, rate, status, message, steps, rejected, switches)
