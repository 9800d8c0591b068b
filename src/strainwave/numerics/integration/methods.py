"""Integration methods: a step (see `steps`) with its step control.

`Dopri5` chooses its steps by tolerances and, where the system has `breakpoints()` (torsions where its law is not
smooth), ends a step on each of them, so that its order is kept. `Rk4` and `Dop8` take equal steps.
"""

import math
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from ...base.law import breakpoints_of, has
from ...base.protocols import Scheme, System, has_jacobian, omega_of, orders_of
from ...base.quantities import States, number, positive_count, shown
from ...base.results import Floats, Status, Trajectory
from ...compile.jit import run
from ..addressed import system_by_address
from .addressed_steps import attempts_by_address, steps_by_address
from .implicit import implicit_by_address
from .marches import DIVERGED, DONE, PAUSED, STOPPED, march_adaptively, march_evenly
from .record import Record, uninterrupted
from .step_control import DIFFERENCE_SIZE, ROUNDS, StepControl
from .steps import ORDER, Classical, EighthOrder
from .workspace import K, Y, workspace

BUDGET = 65536  # steps per call of a kernel: between calls the user can interrupt
MOST_STEPS = 10_000_000  # of an integration: some seconds, and where each is recorded up to a GB
HOPELESS = 10  # times as many steps, by what the start tells, are not begun
STABLE = 3.3  # length of the real interval of stability of Dormand & Prince 5(4) (Hairer & Wanner II, sec. IV.2)
LOOKS = np.array([[0.1, 0.425, 0.55, 0.675]])  # fractions of its step where its stages are more than 1/8 of it apart
ENDED = {DONE: Status.OK, DIVERGED: Status.DIVERGED, PAUSED: Status.TOO_MANY_STEPS, STOPPED: Status.TOO_MANY_STEPS}


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
        Steps after which a run ends with `Status.TOO_MANY_STEPS`; it ends at its start where the fastest vibration
        there takes ten times as many, and a hundred million.
    largest_step : float, optional
        Length [s] that no step exceeds. Default: none.

    Raises
    ------
    ValueError
        If rtol is below 1e-14 (rounding alone is larger), atol or largest_step is not positive or max_steps is below 1.
    """

    adaptive: ClassVar = True
    order: ClassVar = ORDER
    stable: ClassVar = STABLE
    looks: ClassVar = LOOKS
    by_address: ClassVar = staticmethod(attempts_by_address)

    rtol: float = 1e-9
    atol: float = 1e-12
    max_steps: int = MOST_STEPS
    largest_step: float | None = None

    def __post_init__(self) -> None:
        rtol, atol = number("Dopri5.rtol", self.rtol), number("Dopri5.atol", self.atol)
        if not (1e-14 <= rtol < 1.0 and atol > 0.0):
            raise ValueError(f"Dopri5 has rtol {rtol:g}, atol {atol:g}; it needs 1e-14 <= rtol < 1, atol > 0")
        positive_count("Dopri5.max_steps", self.max_steps)
        if self.largest_step is not None:
            number("Dopri5.largest_step [s]", self.largest_step, positive=True)

    def trajectory(self, system: Any, y: Any, rate: Any, times: Floats, spans: Any) -> Trajectory:
        """Trajectory over the stretches `spans` from the state y, recorded at the times or, if two, at every step."""
        sampled = len(times) > 2
        return self.recorded(system, y, spans, Record(system, times, spans, y, rate, sampled, sampled))

    def recorded(self, system: System, y: States, spans: Any, record: Record) -> Trajectory:
        """Trajectory over the stretches `spans` from the state y, in a given record."""
        omega = float(omega_of(system))
        breakpoints = breakpoints_of(system)
        kinks = np.array([breakpoints, [1.0] * len(breakpoints)])
        span = spans[-1][1] - spans[0][0]
        if self.looks.size and _is_hopeless(system, spans[0][0], span, y, max(MOST_STEPS, self.max_steps)):
            return record.trajectory(Status.TOO_MANY_STEPS, 0)
        longest, rtol, atol = float(self.largest_step or math.inf), float(self.rtol), float(self.atol)
        control = StepControl(self.order, self.stable, self.looks, longest, span, rtol, atol)
        t, h, kink, w = spans[0][0], 0.0, -1, workspace(y)
        guard = np.zeros((1, len(guards_of(system, omega * t, y))))

        def addressed() -> tuple[Any, Any]:
            kinked = len(breakpoints) > 0
            system_at = system_by_address(system, len(y), torsion=kinked, guards=guard.shape[1])
            return type(self).by_address(system, len(y), kinked), system_at

        attempts, by_address = addressed()
        steps, rejected, switches, status = 0, 0, 0, DONE
        try:
            for begin, end in spans:
                status = PAUSED
                if begin > t:
                    t, w[Y], w[K] = across(system, omega, t, tuple(w[Y].tolist()), begin)
                    status = STOPPED if guard.size else PAUSED
                    record.go_on(t, w[Y], w[K])
                while status in (PAUSED, STOPPED) and t < end and steps + rejected < self.max_steps:
                    if status == STOPPED:
                        system, w[Y], w[K] = slipping(system, omega * t, tuple(w[Y].tolist()))
                        record.go_on(t, w[Y], w[K])
                        (attempts, by_address), h, kink = addressed(), 0.0, -1
                    budget = record.room(min(BUDGET, self.max_steps - steps - rejected))
                    t, h, kink, filled, status, new, bad, crossed = run(
                        march_adaptively, attempts, by_address, control, kinks, guard, record.recording(), omega, t,
                        end, h, kink, w, record.filled, budget,
                    )  # fmt: skip
                    record.keep(filled, t)
                    steps, rejected, switches = steps + new, rejected + bad, switches + crossed
                if t < end:
                    break
                status = DONE
        except KeyboardInterrupt:
            return record.trajectory(Status.INTERRUPTED, steps, rejected, switches)
        return record.trajectory(ENDED[status], steps, rejected, switches)


@dataclass(frozen=True)
class Rodas(Dopri5):
    """Adaptive implicit RODAS 4(3), for systems whose fast motions have died away; else as `Dopri5`."""

    order: ClassVar = 4
    stable: ClassVar = math.inf
    looks: ClassVar = np.empty((1, 0))
    by_address: ClassVar = staticmethod(implicit_by_address)


@dataclass(frozen=True)
class FixedStep:
    """Equal steps, second order only across a breakpoint.

    `steps` per shortest time scale (2 pi/omega_0 at the largest stiffness met, and the forcing period), or exactly
    `steps_per_period` per period of the base angle.

    Parameters
    ----------
    steps, steps_per_period : int
        Numbers of steps.

    Raises
    ------
    ValueError
        If a number of steps is no whole number of at least 1.
    """

    adaptive: ClassVar = False
    piece: ClassVar = 1  # steps that the measures of an ensemble take together
    scheme: ClassVar[Scheme]

    steps: int = 64
    steps_per_period: int | None = None

    def __post_init__(self) -> None:
        name = type(self).__name__
        positive_count(f"{name}.steps", self.steps)
        if self.steps_per_period is not None:
            positive_count(f"{name}.steps_per_period", self.steps_per_period)

    def trajectory(self, system: Any, y: Any, rate: Any, times: Floats, spans: Any) -> Trajectory:
        """Trajectory over the stretches `spans` from the state y, recorded at the times or, if two, at every step."""
        omega, (t, _), steps, status = float(omega_of(system)), spans[0], 0, DONE
        if len(guards_of(system, omega * t, y)):
            name = type(self).__name__
            raise ValueError(f"{name} has equal steps, and dry friction ends some; integrate with Dopri5(...)")
        record, w = Record(system, times, spans, y, rate, True, True), workspace(y)
        scheme = steps_by_address(self.scheme, system, len(y))
        by_address = system_by_address(system, len(y))
        try:
            h = self.step_of(system, y, rate, times, spans)
            if len(times) == 2:
                record = Record(system, _grid(times, spans, h), spans, y, rate, True, False)
            if spans[-1][1] - t > HOPELESS * MOST_STEPS * h:
                return record.trajectory(Status.TOO_MANY_STEPS, 0)
            for begin, end in spans:
                if begin > t:
                    t, w[Y], w[K] = across(system, omega, t, tuple(w[Y].tolist()), begin)
                status = PAUSED
                while status == PAUSED:
                    t, filled, status, new = run(
                        march_evenly, scheme, by_address, record.recording(), omega, t, end, h, w, record.filled,
                        BUDGET,
                    )  # fmt: skip
                    record.keep(filled, t)
                    steps += new
                if status != DONE:
                    break
        except KeyboardInterrupt:
            return record.trajectory(Status.INTERRUPTED, steps)
        return record.trajectory(ENDED[status], steps)

    def step_of(self, system: Any, y: States, rate: States, times: Floats, spans: Any) -> float:
        """Step [s] that resolves the shortest time scale, from the Jacobian along a coarse adaptive solution."""
        omega = float(omega_of(system))
        if self.steps_per_period is not None:
            if omega == 0.0:
                raise ValueError("with omega = 0 there is no period; give steps instead of steps_per_period")
            return 2.0 * math.pi / abs(omega) / self.steps_per_period
        if not has_jacobian(system):
            name = type(system).__name__
            raise TypeError(f"{name} has no jacobian to choose a step from; give steps_per_period or use Dopri5")
        record = Record(system, times[[0, -1]], spans, y, rate, False, False)
        coarse = uninterrupted(Dopri5(rtol=1e-3, atol=1e-6).recorded(system, y, spans, record))
        # On the way to infinity the stiffness has no bound; what counts is the stiffness before.
        almost = times[0] + 0.99 * (coarse.t[-1] - times[0])
        end = len(coarse.t) if coarse.status else int(np.searchsorted(coarse.t, almost))
        use = slice(0, max(1, end), max(1, end // 2000))
        rows = system.jacobian(omega * coarse.t[use], tuple(coarse.y[:, use]))
        entries = np.array([[np.broadcast_to(entry, coarse.t[use].shape) for entry in row] for row in rows], float)
        fastest = float(np.max(np.abs(np.linalg.eigvals(np.moveaxis(entries, 2, 0)))))
        order = max((1, *orders_of(system)))
        return 2.0 * math.pi / max(fastest, abs(omega) * order) / self.steps


@dataclass(frozen=True)
class Rk4(FixedStep):
    """Classical Runge-Kutta with a fixed step.

    `steps` per shortest time scale (2 pi/omega_0 at the largest stiffness met, and the forcing period), or exactly
    `steps_per_period` per period of the base angle. It is of second order only across a breakpoint.
    """

    piece: ClassVar = 2
    scheme: ClassVar = Classical()


@dataclass(frozen=True)
class Dop8(FixedStep):
    """The eighth-order method of DOP853 with a fixed step; `steps` and `steps_per_period` as in `Rk4`."""

    scheme: ClassVar = EighthOrder()

    steps: int = 16


Method = Dopri5 | FixedStep


def checked(method: Any) -> Method:
    """Return a method, or refuse what is none (TypeError)."""
    if not isinstance(method, Method):
        raise TypeError(f"method is {shown(method)}; it must be Dopri5(...), Rk4(...) or Dop8(...)")
    return method


def slipping(system: Any, phase: float, y: Any) -> tuple[Any, Any, Any]:
    """The system as its shafts slide or stick from a state on, that state and its rates."""
    if has(system, "slipping"):
        system, y = system.slipping(phase, y)
    return system, y, tuple(float(rate) for rate in system.rhs(phase, y))


def guards_of(system: Any, phase: float, y: Any) -> Any:
    """Guards of a system in a state: none of one that does not say."""
    return system.guards(phase, y) if has(system, "guards") else ()


def _grid(times: Floats, spans: Any, h: float) -> Floats:
    """Ends of all equal steps of at most h."""
    counts = [math.ceil((end - begin) / h * (1.0 - 1e-12)) for begin, end in spans]
    if sum(counts) > HOPELESS * MOST_STEPS:
        raise ValueError(
            f"{sum(counts):.3g} steps are too many to record; give the times at which to record, or fewer steps"
        )
    grid = np.concatenate([np.linspace(begin, end, 1 + n) for (begin, end), n in zip(spans, counts, strict=True)])
    grid[[0, -1]] = times
    return grid


def _is_hopeless(system: Any, t: float, span: float, y: States, max_steps: int) -> bool:
    """True if a span [s] takes far more than `max_steps`, by what the system does at its start.

    A step is at most as long as the method is stable for the largest eigenvalue of the Jacobian (by power iteration,
    two rounds together, because those of a vibration are a pair), and as a period of the highest order.
    """
    omega, fastest = float(omega_of(system)), HOPELESS * max_steps / span
    if abs(omega) * max((1, *orders_of(system))) > 2.0 * math.pi * fastest:
        return True
    distance = DIFFERENCE_SIZE * (1.0 + max(map(abs, y)))
    change, size, before, grown = [1.0] * len(y), 1.0, 0.0, 0.0
    for _ in range(ROUNDS):
        y_near = tuple(value + distance / size * part for value, part in zip(y, change, strict=True))
        try:
            rates = system.rhs(omega * t, y_near), system.rhs(omega * t, y)
        except ArithmeticError:
            return False
        change = [float(a) - float(b) for a, b in zip(*rates, strict=True)]
        size = max(map(abs, change))
        if not 0.0 < size < math.inf:
            return False
        before, grown = grown, size / distance
        if before == 0.0 and not grown > STABLE * fastest:
            return False
    return math.sqrt(grown * before) > STABLE * fastest


def across(system: System, omega: float, t: float, y: Any, begin: float) -> tuple[float, Any, Any]:
    """Time, state and rates just after a corner, from the state y just before it, at t."""
    rate = system.rhs(omega * begin, y)
    y = tuple(float(value + (begin - t) * change) for value, change in zip(y, rate, strict=True))
    return begin, y, tuple(float(change) for change in rate)
