"""`simulate`: integration in time of any system with `rhs(phase, y)`.

`Dopri5` adapts its step and, where the system has `breakpoints()` (torsions where its law is not smooth), ends a step
on each of them, so that the order of the method is kept. `Rk4` and `Dop8` use fixed steps. All of them end a step at
the `corners()` of profiles, and keep the largest values between samples.
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ...compile.jit import run
from ...law import is_spring
from ...quantities import number, positive_count, shown, with_parts
from ...results import Floats, Status, Trajectory
from .corners import across, stretches
from .marches import BOUND, DIVERGED, DONE, PAUSED, adaptive, fixed
from .record import Record

BUDGET = 65536  # steps per call of a kernel: between calls the user can interrupt
MOST_RECORDED = 100_000_000


@dataclass(frozen=True)
class Dopri5:
    """Adaptive Dormand-Prince 5(4) with dense output and located switches; rtol and atol apply to every state.

    Steps end at the `corners()` of profiles. A function of the base angle of your own without them is met as it comes:
    at rest too the system is looked at about fifteen times in the period of its fastest vibration, or two hundred times
    in the span where nothing restores it, so that no change that lasts longer than from one look to the next is missed.
    For shorter ones give the function `corners()`, or a `largest_step` of about their length.

    Parameters
    ----------
    rtol, atol : float
        Relative and absolute tolerance of the error of a step.
    max_steps : int
        Steps after which a run ends with `Status.TOO_MANY_STEPS`.
    largest_step : float, optional
        Length [s] that no step exceeds. Default: none.

    Raises
    ------
    ValueError
        If rtol is below 1e-14 (rounding alone is larger), atol or largest_step is not positive or max_steps is below 1.
    """

    rtol: float = 1e-9
    atol: float = 1e-12
    max_steps: int = 10_000_000
    largest_step: float | None = None

    def __post_init__(self) -> None:
        for name in ("rtol", "atol"):
            number(f"Dopri5.{name}", getattr(self, name))
        if not (1e-14 <= self.rtol < 1.0 and self.atol > 0.0):
            raise ValueError(
                f"Dopri5 has rtol {self.rtol:g} and atol {self.atol:g}; it needs 1e-14 <= rtol < 1, atol > 0"
            )
        positive_count("Dopri5.max_steps", self.max_steps)
        if self.largest_step is not None:
            number("Dopri5.largest_step [s]", self.largest_step, positive=True)


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


def simulate(system: Any, y0: ArrayLike, t: float | ArrayLike, *, method: Dopri5 | Rk4 = Dopri5()) -> Trajectory:
    """Integrate a system in time.

    Parameters
    ----------
    system : NamedTuple
        Anything with `rhs(phase, y)`; its `omega` [rad/s] turns time into phase (1 where it has none). Switches are
        located where it has `breakpoints()`.
    y0 : (states,) array_like
        State at the first time; for an `Oscillator` x [rad], x' [rad/s] and the internal states of its law, if any; for
        a train under gravity or load see `operating_state`.
    t : float or array_like
        End time [s] (from 0), or (start, end): every step is recorded, at a corner of a profile once just before and
        once just after it. More than two increasing times: the solution is recorded there, by dense output, with the
        largest values in between.
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
    spans = stretches(system, _omega(system), float(times[0]), float(times[-1]))
    y, rate = _start(system, spans[0][0], y0)
    with np.errstate(all="ignore"):  # the status tells of an overflow, also where nothing is compiled
        if isinstance(method, Dopri5):
            return _adaptive(system, y, spans, method, Record(system, times, spans, y, rate, len(times) > 2))
        return _fixed(system, y, rate, times, spans, method)


def first_time(t: float | ArrayLike) -> float:
    """Time [s] at which `simulate` begins: 0 where t is an end time."""
    return float(_times(t)[0])


def _omega(system: Any) -> float:
    return float(getattr(system, "omega", 1.0))


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
        rate = tuple(float(v) for v in system.rhs(_omega(system) * t, y))
    except (ArithmeticError, IndexError, ValueError) as error:
        raise ValueError(f"{name}.rhs does not accept y0 = {y} ({error}); give it as many states as it has") from error
    if len(rate) != len(y):
        raise ValueError(f"y0 has {len(y)} states but {name} has {len(rate)}; give as many")
    if not all(math.isfinite(v) and abs(u) < BOUND for u, v in zip(y, rate, strict=True)):
        raise ValueError(f"at y0 = {y} {name}.rhs gives the rates {rate}; start closer to equilibrium")
    return y, rate


def _adaptive(system: Any, y: Any, spans: Any, method: Dopri5, record: Record) -> Trajectory:
    omega = _omega(system)
    places = system.breakpoints() if hasattr(system, "breakpoints") else ()
    breakpoints = np.array(places, float) if places else None  # None: the kernel for smooth laws leaves the search out
    longest, span = float(method.largest_step or math.inf), spans[-1][1] - spans[0][0]
    limits = longest, span, float(method.rtol), float(method.atol)
    t, h, at, sides = spans[0][0], 0.0, -1, np.ones(len(places))
    steps, rejected, switches, status = 0, 0, 0, DONE
    try:
        for begin, end in spans:
            if begin > t:
                t, y, rate = across(system, omega, t, y, begin)
                record.go_on(t, y, rate)
            status = PAUSED
            while status == PAUSED and steps + rejected < method.max_steps:
                budget = record.room(min(BUDGET, method.max_steps - steps - rejected))
                t, y, h, at, filled, status, new, bad, crossed = run(
                    adaptive, system, omega, t, y, end, h, *limits, breakpoints, sides, at, record.samples,
                    record.filled, budget, *record.buffers(),
                )  # fmt: skip
                record.keep(filled, t)
                steps, rejected, switches = steps + new, rejected + bad, switches + crossed
            if status != DONE:
                break
    except KeyboardInterrupt:
        return record.trajectory(Status.INTERRUPTED, steps, rejected, switches)
    outcome = {DONE: Status.OK, DIVERGED: Status.DIVERGED, PAUSED: Status.TOO_MANY_STEPS}[status]
    return record.trajectory(outcome, steps, rejected, switches)


def _fixed(system: Any, y: Any, rate: Any, times: Floats, spans: Any, method: Rk4) -> Trajectory:
    omega, (t, _), steps, status = _omega(system), spans[0], 0, DONE
    record = Record(system, times, spans, y, rate, True)
    try:
        h = _fixed_step(system, omega, y, rate, times, spans, method)
        if len(times) == 2:
            counts = [math.ceil((end - begin) / h * (1.0 - 1e-12)) for begin, end in spans]
            if sum(counts) > MOST_RECORDED:
                raise ValueError(
                    f"{sum(counts):.3g} steps are too many to record; give the times at which to record, or fewer steps"
                )
            parts = [np.linspace(begin, end, 1 + n) for (begin, end), n in zip(spans, counts, strict=True)]
            grid = np.concatenate(parts)
            grid[[0, -1]] = times
            record = Record(system, grid, spans, y, rate, True)
        for begin, end in spans:
            if begin > t:
                t, y, rate = across(system, omega, t, y, begin)
            status = PAUSED
            while status == PAUSED:
                eighth = isinstance(method, Dop8)
                t, y, filled, status, new = run(
                    fixed, system, omega, t, y, end, h, eighth, record.samples, record.filled, BUDGET,
                    *record.buffers(),
                )  # fmt: skip
                record.keep(filled, t)
                steps += new
            if status != DONE:
                break
    except KeyboardInterrupt:
        return record.trajectory(Status.INTERRUPTED, steps)
    return record.trajectory(Status.OK if status == DONE else Status.DIVERGED, steps)


def _fixed_step(system: Any, omega: float, y: Any, rate: Any, times: Floats, spans: Any, method: Rk4) -> float:
    """Step that resolves the shortest time scale, found from the Jacobian along a coarse adaptive solution."""
    if method.steps_per_period is not None:
        if omega == 0.0:
            raise ValueError("with omega = 0 there is no period; give steps instead of steps_per_period")
        return 2.0 * math.pi / abs(omega) / method.steps_per_period
    if not hasattr(system, "jacobian") or not is_spring(system):
        name = type(system).__name__
        raise TypeError(f"{name} has no jacobian to choose a step from; give steps_per_period or use Dopri5")
    record = Record(system, times[[0, -1]], spans, y, rate, False)
    coarse = _adaptive(system, y, spans, Dopri5(rtol=1e-3, atol=1e-6), record)
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
