"""Gains of controllers from the model of a bench: rates that stay stable, guards, and times in which runs settle."""

from collections.abc import Callable
from math import ceil, pi
from typing import Any

import numpy as np

from ...base.results import SolveError
from ...drive.equation.gear_torque import UNDAMPED
from ...drive.train_curve import in_turns
from ...model.controllers.adaptive import CELLS, AdaptiveCancellation, Repetitive
from ...model.train.controls import motor_states
from ...numerics.ensemble.linear_loops import LoopResponse
from ...numerics.ensemble.loops import LoopEnsemble, LoopRun, loop_ensemble, run_loop
from .bench import Bench

LEAST_DISTANCE = 0.6  # of the loop of an adaptation from the critical point: a resonance may move, a gain grow by two
HALVINGS, GRID_POINTS = 20, 300  # of a rate at most, and frequencies of the distance from the critical point
GUARD_FACTOR = 5.0  # times the torque that cancels the error of the model
GOLDEN = 0.5 * (5.0**0.5 - 1.0)  # of a period from one kept sample to the next: they meet all phases
KEPT_SAMPLES, BLOCK = 20_000, 20  # samples of an adaptation, and those whose rms is taken together
POLE_ROUNDING = 1e-7  # of a pole from 1: rounding of the differences
NEARBY = 1.0 + np.concatenate([-np.geomspace(1e-4, 0.3, 25), np.geomspace(1e-4, 0.3, 25)])
ADAPTING_SHARE = 0.3  # of the inverse time constant of the loop: rate of what adapts, slow beside all that it adapts
LEAST_SMOOTHING = (
    1e-4  # decay of a cell's fine structure that repetitive control has at least, in its rate of convergence
)
SMOOTHING_MARGIN = 1.5  # of the smoothing that an order needs
LEADS = 721  # leads that are tried
LEAST_RESPONSE = 1e-3  # of the response at its orders: a table moves the mean where the response is larger there
LEAST_TURNS = 4  # of the motor, and periods of the lowest order, that are measured at least


def refuse_unstable(bench: Bench, speed: float) -> LoopResponse:
    """Response of the model under the plain loop at the bench's orders; an unstable one is refused (ValueError)."""
    response = bench.response(speed)
    largest = float(np.max(np.abs(response.poles)))
    if bench.memory or abs(largest - 1.0) < POLE_ROUNDING:
        _refuse_overloaded(bench, speed)
    if abs(largest - 1.0) < POLE_ROUNDING:
        raise ValueError(
            UNDAMPED
            if bench.equation and bench.model.B == 0.0
            else "motions under the plain loop neither decay nor grow: motor loop or gear has no stiffness at its "
            "operating point; use a loop with a position gain, or a mean load outside the backlash"
        )
    if not response.stable:
        raise ValueError(
            f"the plain loop is unstable with samples every {1e3 * bench.sampling.period:.4g} ms and "
            f"{1e3 * bench.sampling.delay:.4g} ms of delay, its speed the difference of two angles over a period; "
            "reduce the bandwidth or sample faster"
        )
    return response


def _refuse_overloaded(bench: Bench, speed: float) -> None:
    """Refuse a law that cannot carry the mean torque, as a hysteresis that has yielded (ValueError)."""
    try:
        bench.held(speed, model=True)
    except SolveError as error:
        raise ValueError(f"the plain loop has no steady motion to be designed about, as {error}") from None


def times_of(bench: Bench, speed: float, rate: float = 0.0) -> tuple[float, float]:
    """Times [s] after which transients have died, and at which a run ends, a whole number of turns later.

    What is measured lasts as long as the slower of the loop's slowest motion and of what adapts with a rate [1/s].
    """
    slowest, adaptation = bench.response(speed).slowest, 1.0 / rate if rate else 0.0
    settle = 10.0 * (slowest + adaptation)
    turn = 2.0 * pi / abs(speed)
    return settle, settle + turns_of(bench, max(0.5, slowest, adaptation) / turn) * turn


def turns_of(bench: Bench, least: float = 0.0) -> float:
    """Turns of the motor that are measured, so many at least: whole turns, or whole beats in each of two halves."""
    unit = 2.0 * bench.repeat if bench.repeat > 1.0 else 1.0
    lowest: float = min(bench.orders)
    return ceil(max(LEAST_TURNS, LEAST_TURNS / lowest, least) / unit) * unit


def plain_run(bench: Bench, speed: float, *, model: bool) -> LoopEnsemble:
    """The model or the plant under the plain loop, in steady state."""
    return steady_run(bench, bench.loop, speed, *times_of(bench, speed), model=model)


def steady_run(
    bench: Bench, controller: Any, speed: float, settle: float, end: float, *, model: bool = False
) -> LoopEnsemble:
    """The plant or the model under a controller: its orders from a time [s] until the end."""
    loop, orders = bench.closed(controller, speed, model=model), np.array(bench.orders, float)
    start = bench.start(speed, model=model)
    return loop_ensemble(loop, {}, end, settle=settle, orders=orders, y0=start)


def adaptation(bench: Bench, controller: Any, speed: float, end: float) -> LoopRun:
    """A run from the first sample on, of which so many samples are kept, each at another phase of the lowest order.

    Of a run of few turns more are kept of a turn: a block of them has at least one.
    """
    period = 2.0 * pi / (abs(speed) * min(bench.orders)) / bench.sampling.period  # in samples
    wanted = end / bench.sampling.period / KEPT_SAMPLES
    parts = min(BLOCK // 2, max(1.0, GOLDEN * period // wanted))
    every = round((wanted // period + GOLDEN) * period / parts)
    return run_loop(bench.closed(controller, speed), end, y0=bench.start(speed), every=max(1, every))


def converged_at(run: LoopRun, small: float) -> float:
    """Time [s] from which on the rms of the error in an `adaptation` stays below a size [rad]; inf where never."""
    count = len(run.time) // BLOCK
    rms = np.std(run.error[: count * BLOCK].reshape(count, BLOCK), axis=1)
    large = np.flatnonzero(~(rms <= small))
    if large.size and large[-1] == count - 1:
        return float("inf")
    return float(run.time[BLOCK * (large[-1] + 1)]) if large.size else 0.0


def rate_of(bench: Bench, speed: float) -> float:
    """Rate [1/s] at which every order may adapt on a loop, slow beside its slowest motion and the turn.

    With angle-wise adaptation at constant speed the controller is a linear filter with its poles at the orders
    (Bodson, Sacks & Khosla, Harmonic generation in adaptive feedforward cancellation schemes, IEEE Trans. Autom.
    Control 39(9), 1994, 1939-1944): its loop stays `LEAST_DISTANCE` away from the critical point.
    """
    response = refuse_unstable(bench, speed)
    rate: float = min(ADAPTING_SHARE / response.slowest, 0.1 * abs(speed) * min(bench.orders))
    for _ in range(HALVINGS):
        if distance(bench, speed, rate) >= LEAST_DISTANCE:
            break
        rate *= 0.5
    return rate


def distance(bench: Bench, speed: float, rate: float, real: Bench | None = None) -> float:
    """Least |1 - C G| over the frequencies: C adapts on the bench's model with a rate, G is that of a real drive."""
    period, orders, turning = bench.sampling.period, np.array(bench.orders, float), abs(speed)
    limit = 0.9 * pi / (turning * period)
    grid = np.unique(np.concatenate([np.geomspace(1e-2, limit, GRID_POINTS), *(k * NEARBY for k in orders)]))
    grid = grid[(grid < limit) & np.all(np.abs(grid[:, None] - orders) > 1e-9, axis=1)]
    G = (real or bench).response(speed, grid).error_of_torque
    z = np.exp(1j * turning * period * grid)
    C = np.zeros(len(grid), complex)
    for k, g in zip(orders, bench.response(speed).error_of_torque, strict=True):
        turn = np.exp(1j * turning * period * k)
        gain, side = 2.0 * rate / abs(g) * period, np.exp(-1j * np.angle(g))
        C -= 0.5 * gain * (side * turn / (z - turn) + np.conj(side * turn) / (z - np.conj(turn)))
    return float(np.min(np.abs(1.0 - C * G)))


def guard(bench: Bench, speed: float, *, mean: bool = False) -> float:
    """Torque [N*m] that no adaptation needs: five times what cancels the error of the model against its own loop.

    With `mean` what cancels its mean is in it.
    """
    loops = plain_run(bench, speed, model=True)
    torque = float(np.max(np.abs(torque_against(bench, speed, bench.orders, loops.amplitude[:, 0]))))
    if mean:
        torque += abs(float(loops.mean[0]) / float(abs(bench.response(speed, [0.0]).error_of_torque[0])))
    return GUARD_FACTOR * torque


def size_of(bench: Bench, amplitudes: Any) -> float:
    """Amplitude [rad] for which the gear's stiffness is taken: of an error equation the error's, 0 of a train."""
    return float(np.max(np.abs(amplitudes))) if bench.equation else 0.0


def torque_against(bench: Bench, speed: float, orders: Any, amplitudes: Any) -> Any:
    """Torques (orders,) [N*m] of the motor that cancel complex amplitudes [rad] of the error, by the model."""
    G = bench.response(speed, orders, size=size_of(bench, amplitudes)).error_of_torque
    return -np.asarray(amplitudes) / (G if speed > 0.0 else np.conj(G))


def motor_guard(bench: Bench, speed: float) -> float:
    """Torque [N*m] that no adaptation to the motor needs: five times what keeps the model's motor on its reference."""
    settle, end = times_of(bench, speed)
    run = run_loop(bench.closed(bench.loop, speed, model=True), end, y0=bench.start(speed, model=True))
    late = run.time >= settle
    behind = motor_lag_of(bench)
    turn = np.exp(-1j * np.outer(bench.orders, speed * run.time[late]))
    amplitude = 2.0 * np.abs(turn @ behind(run.states[:, late])) / np.sum(late)
    return GUARD_FACTOR * float(np.max(amplitude / np.abs(bench.response(speed, output=behind).error_of_torque)))


def motor_lag_of(bench: Bench) -> Callable[[Any], Any]:
    """Function of the state of the train: lag of the motor behind its reference, over N [rad]."""
    model = bench.model
    return lambda y: -motor_states(model.motor.control, y)[0][0] / model.N


def repetitive_gains(bench: Bench, speed: float) -> tuple[float, float, float]:
    """Lead [rad] that leaves least of the error, smoothing that every other order needs, and rate [1/s] of learning.

    At order k the table grows with r_k = Re(-G_k e^(i k lead)), relative to the largest of the orders of the error, and
    decays with s c_k, c_k = 1 - cos(2 pi k/M): the error keeps s c_k/(r_k + s c_k) of itself. In a turn no order
    changes by more than half of itself.
    """
    if bench.repeat > 1.0:
        other = next(order for order in bench.orders if order % 1)
        raise ValueError(
            f"repetitive control learns over the motor's turn, and order {in_turns(other, bench.model)} belongs to "
            "the output's turn; use 'adaptive'"
        )
    period, orders = bench.sampling.period, np.array(bench.orders)
    turn = 2.0 * pi / abs(speed)
    k = np.arange(int(min(CELLS // 2, 0.9 * pi / period / abs(speed))) + 1)
    G = -bench.response(speed, k).error_of_torque / np.max(np.abs(bench.response(speed).error_of_torque))
    c = 1.0 - np.cos(2.0 * pi * k / CELLS)
    best: tuple[float, float, float] = (1.0, 0.0, 0.0)
    for lead in np.linspace(-pi, pi, LEADS) / min(orders):
        r = np.real(G * np.exp(1j * k * lead))
        s = SMOOTHING_MARGIN * float(np.max(-r[1:] / c[1:], initial=LEAST_SMOOTHING))
        if r[0] > LEAST_RESPONSE and np.all(r[orders] > 0.0):
            kept = float(np.max(s * c[orders] / (r[orders] + s * c[orders])))
            best = min(best, (kept, float(lead), s))
    kept, lead, s = best
    if kept == 1.0:
        raise ValueError(
            "no phase lead makes repetitive control reduce every order of the error (often caused by an integral "
            "in the plain loop); use 'adaptive'"
        )
    largest = float(np.max(np.abs(G) + s * c))
    rate = min(rate_of(bench, speed) / largest, 0.5 / (turn * largest), 0.5 / (s * period * CELLS))
    return lead, s * rate * period * CELLS, rate


def amplitudes_of(bench: Bench, speed: float, *, model: bool) -> Any:
    """Complex amplitudes [rad] of the error under the plain loop: run on the model, or measured on the plant."""
    loops = plain_run(bench, speed, model=model)
    return (loops.amplitude * np.exp(1j * loops.phase))[:, 0]


def response_at_error(bench: Bench, speed: float) -> Any:
    """Response (orders,) at the size that the plain loop's error has on the model."""
    return bench.response(speed, size=size_of(bench, amplitudes_of(bench, speed, model=True))).error_of_torque


def learning_rate(bench: Bench, speed: float, controller: Any) -> float:
    """Slowest rate [1/s] at which a controller learns on a bench, by its own gains; 0 where it does not."""
    rates, inner = [], controller
    while inner is not None:
        if isinstance(inner, AdaptiveCancellation):
            rates += [0.5 * inner.gain * g for g in _responses_along_phase(bench, speed, inner)]
        elif isinstance(inner, Repetitive):
            orders = np.array([order for order in bench.orders if order % 1 == 0])
            learned = np.real(-bench.response(speed, orders).error_of_torque * np.exp(1j * orders * inner.lead))
            forgotten = inner.smooth * (1.0 - np.cos(2.0 * pi * orders / CELLS)) / inner.period
            rates.append(max(0.0, float(np.min(inner.gain * learned + forgotten, initial=np.inf))) / CELLS)
        inner = getattr(inner, "loop", None)
    return float(min((rate for rate in rates if rate > 0.0), default=0.0))


def _responses_along_phase(bench: Bench, speed: float, inner: AdaptiveCancellation) -> list[float]:
    """Response [rad/(N*m)] at the order of an adaptation along its phase, of an equation's plain loop at both sizes."""
    base: Any = inner
    while isinstance(base, AdaptiveCancellation):
        base = base.loop
    if not (bench.equation and inner.on_load and base == bench.loop):
        output = None if inner.on_load else motor_lag_of(bench)
        return [float(abs(bench.response(speed, [inner.order], output).error_of_torque[0]))]
    i = bench.orders.index(inner.order)
    both = bench.response(speed).error_of_torque[i], response_at_error(bench, speed)[i]
    return [float(np.real(g * np.exp(-1j * inner.phase))) for g in both]


def has_tripped(controller: Any, state: Any) -> bool:
    """True where a guard in a controller has dropped its torque, by its memory."""
    while hasattr(controller, "loop"):
        if isinstance(controller, AdaptiveCancellation | Repetitive) and state[-1]:
            return True
        holds = controller.start() != controller.loop.start()  # its memory beside that of its loop
        controller, state = controller.loop, state[0] if holds else state
    return False
