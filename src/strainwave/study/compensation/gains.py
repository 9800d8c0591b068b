"""Gains of controllers from the model of a bench: rates that stay stable, guards, and times in which runs settle.

Units of one type under one controller: a compensation under scatter.
"""

from collections.abc import Callable, Sequence
from math import ceil, pi
from typing import Any

import numpy as np

from ...base.protocols import lacking, lines_of, terms_of
from ...base.results import SolveError
from ...drive.equation.gear_torque import UNDAMPED
from ...drive.train_curve import in_turns
from ...model.controllers.adaptive import CELLS, AdaptiveCancellation, Repetitive
from ...model.excitation import Harmonics, KinematicError, shortest
from ...model.train.controls import motor_states
from ...model.train.drive_train import DriveTrain
from ...numerics.ensemble.linear_loops import LoopResponse
from ...numerics.ensemble.loops import LoopEnsemble, LoopRun, loop_ensemble, run_loop
from ..analysis.knobs import stiffer
from .bench import Bench, lines_in
from .result import Units

DISTANCE = 0.6  # of the loop of an adaptation from the critical point: a resonance may move, a gain grow by two
HALVINGS, GRID = 20, 300
GUARD = 5.0
GOLDEN = 0.5 * (5.0**0.5 - 1.0)  # of a period from one kept sample to the next: they meet all phases
KEPT_SAMPLES, BLOCK = 20_000, 20  # samples of an adaptation, and those whose rms is taken together
DRIFT = 1e-7  # of a pole from 1: rounding of the differences
NEARBY = 1.0 + np.concatenate([-np.geomspace(1e-4, 0.3, 25), np.geomspace(1e-4, 0.3, 25)])
QUICK = 0.3  # of the inverse time constant of the loop: rate of what adapts, slow beside all that it adapts
SMOOTH = 1e-4  # decay of a cell's fine structure that repetitive control has at least, in its rate of convergence
MARGIN = 1.5  # of the smoothing that an order needs
LEADS = 721  # leads that are tried
STANDING = 1e-3  # of the response at its orders: a table moves the mean where the response is larger there
GIVEN_UP = 0.9  # of the error before: a guard has tripped, or nothing is gained
SCATTER = (0.15, 0.5)  # of stiffness and kinematic error from unit to unit, as shares; the phase is any
TURNS = 4  # of the motor, and periods of the lowest order, that are measured at least


def refuse_unstable(bench: Bench, speed: float) -> LoopResponse:
    """Response of the model under the plain loop at the bench's orders; an unstable one is refused (ValueError)."""
    response = bench.response(speed)
    largest = float(np.max(np.abs(response.poles)))
    if bench.memory or abs(largest - 1.0) < DRIFT:
        _refuse_overloaded(bench, speed)
    if abs(largest - 1.0) < DRIFT:
        raise ValueError(
            UNDAMPED
            if bench.equation and bench.model.B == 0.0
            else "under the plain loop a motion neither decays nor grows, as the loop has no stiffness against the "
            "motor's angle or the gear none about its mean torque; give a loop with a position gain, or a load off the "
            "backlash"
        )
    if not response.stable:
        raise ValueError(
            f"the plain loop is unstable with samples every {1e3 * bench.sampling.period:.4g} ms and "
            f"{1e3 * bench.sampling.delay:.4g} ms of delay, its speed the difference of two angles over a period; "
            "lower its bandwidth or sample faster"
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
    slowest, adapting = bench.response(speed).slowest, 1.0 / rate if rate else 0.0
    settle = 10.0 * (slowest + adapting)
    turn = 2.0 * pi / abs(speed)
    return settle, settle + turns_of(bench, max(0.5, slowest, adapting) / turn) * turn


def turns_of(bench: Bench, least: float = 0.0) -> float:
    """Turns of the motor that are measured, so many at least: whole turns, or whole beats in each of two halves."""
    unit = 2.0 * bench.repeat if bench.repeat > 1.0 else 1.0
    lowest: float = min(bench.orders)
    return ceil(max(TURNS, TURNS / lowest, least) / unit) * unit


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


def adapting(bench: Bench, controller: Any, speed: float, end: float) -> LoopRun:
    """A run from the first sample on, of which so many samples are kept, each at another phase of the lowest order.

    Of a run of few turns more are kept of a turn: a block of them has at least one.
    """
    period = 2.0 * pi / (abs(speed) * min(bench.orders)) / bench.sampling.period  # in samples
    wanted = end / bench.sampling.period / KEPT_SAMPLES
    parts = min(BLOCK // 2, max(1.0, GOLDEN * period // wanted))
    every = round((wanted // period + GOLDEN) * period / parts)
    return run_loop(bench.closed(controller, speed), end, y0=bench.start(speed), every=max(1, every))


def converged_at(run: LoopRun, small: float) -> float:
    """Time [s] from which on the rms of the error in a run of `adapting` stays below a size [rad]; inf where never."""
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
    Control 39(9), 1994, 1939-1944): its loop stays `DISTANCE` away from the critical point.
    """
    response = refuse_unstable(bench, speed)
    rate: float = min(QUICK / response.slowest, 0.1 * abs(speed) * min(bench.orders))
    for _ in range(HALVINGS):
        if distance(bench, speed, rate) >= DISTANCE:
            break
        rate *= 0.5
    return rate


def distance(bench: Bench, speed: float, rate: float, real: Bench | None = None) -> float:
    """Least |1 - C G| over the frequencies: C adapts on the bench's model with a rate, G is that of a real drive."""
    period, orders, turning = bench.sampling.period, np.array(bench.orders, float), abs(speed)
    limit = 0.9 * pi / (turning * period)
    grid = np.unique(np.concatenate([np.geomspace(1e-2, limit, GRID), *(k * NEARBY for k in orders)]))
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
    return GUARD * torque


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
    behind = behind_of(bench)
    turn = np.exp(-1j * np.outer(bench.orders, speed * run.time[late]))
    amplitude = 2.0 * np.abs(turn @ behind(run.states[:, late])) / np.sum(late)
    return GUARD * float(np.max(amplitude / np.abs(bench.response(speed, output=behind).error_of_torque)))


def behind_of(bench: Bench) -> Callable[[Any], Any]:
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
            f"repetitive control learns over the motor's turn, and order {in_turns(other, bench.model)} is a line of "
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
        s = MARGIN * float(np.max(-r[1:] / c[1:], initial=SMOOTH))
        if r[0] > STANDING and np.all(r[orders] > 0.0):
            kept = float(np.max(s * c[orders] / (r[orders] + s * c[orders])))
            best = min(best, (kept, float(lead), s))
    kept, lead, s = best
    if kept == 1.0:
        raise ValueError(
            "repetitive control cannot lower the mean and every order of the error with any lead, as with an integral "
            "in the plain loop; use 'adaptive'"
        )
    largest = float(np.max(np.abs(G) + s * c))
    rate = min(rate_of(bench, speed) / largest, 0.5 / (turn * largest), 0.5 / (s * period * CELLS))
    return lead, s * rate * period * CELLS, rate


def units_of(bench: Bench, controller: Any, speed: float, settle: float, end: float, units: int, seed: int) -> Units:
    """Run units whose stiffness, kinematic error and its phases differ, under the plain loop and a controller."""
    draw = np.random.default_rng(seed)
    stiffness = 1.0 + SCATTER[0] * draw.uniform(-1.0, 1.0, units)
    amplitude = 1.0 + SCATTER[1] * draw.uniform(-1.0, 1.0, units)
    phases = draw.uniform(0.0, 2.0 * np.pi, (units, len(lines_in(bench.plant))))
    draws = zip(stiffness.tolist(), amplitude.tolist(), phases.tolist(), strict=True)
    plants = [unit_of(bench.plant, *row) for row in draws]
    runs = []
    orders, y0 = np.array(bench.orders, float), bench.start(speed)
    for one in (bench.loop, controller):
        loops = [bench.closed(one, speed)._replace(train=plant._replace(omega=speed)) for plant in plants]
        runs.append(loop_ensemble(loops[0], loops, end, settle=settle, orders=orders, y0=y0))
    before, after = runs
    lost = np.flatnonzero(~after.stable | (after.rms > GIVEN_UP * before.rms)).tolist()
    causes = (_cause(bench, controller, speed, plants[i], float(after.limited[i])) for i in lost)
    return Units(before, after, stiffness, amplitude, tuple(zip(lost, causes, strict=True)))


def unit_of(plant: DriveTrain, stiffness: float, amplitude: float, phases: Sequence[float]) -> DriveTrain:
    """A train with factors of its stiffness and of its lines, of error and of torque, and their phases [rad]."""
    law = stiffer(plant.law, stiffness - 1.0)
    if law is None:
        fault = f"the stiffness of {type(plant.law).__name__} cannot be scaled by its numbers: no units are drawn"
        raise ValueError(fault)
    left = iter(phases)

    def unit(line: Any) -> Any:
        return line._replace(amplitude=line.amplitude * amplitude, phase=next(left)) if line.amplitude else line

    lines, ends = tuple(map(unit, lines_of(plant.error))), (plant.motor, plant.load.end())
    motor, load = [
        torque if lacking(terms_of(torque)[0], "amplitude") else shortest(Harmonics(tuple(map(unit, terms_of(torque)))))
        for torque in (end.excitation for end in ends)
    ]
    changed = plant._replace(law=law, error=KinematicError(lines) if lines else plant.error)
    return changed.with_motor(excitation=motor).with_load(excitation=load)


def _cause(bench: Bench, controller: Any, speed: float, plant: DriveTrain, limited: float) -> str:
    """Reason why the error of a unit grew: the plant's phase at an order that adapts, or its poles."""
    unit = Bench(plant, plant, bench.loop, bench.sampling)
    response = unit.response(speed, bench.orders)
    if not response.stable:
        return "the plain loop itself is unstable on it"
    inner = controller
    while isinstance(inner, AdaptiveCancellation):
        off = np.degrees(np.angle(np.exp(1j * inner.phase) / response.error_of_torque[bench.orders.index(inner.order)]))
        if abs(off) > 90.0:
            return f"the plant's phase at order {inner.order:.6g} is {off:.0f} degrees off the model's, beyond 90"
        inner = inner.loop
    if limited > 0.0:
        return f"the torque meets its limit of {bench.sampling.limit:.4g} N*m in {100.0 * limited:.3g} % of the samples"
    adapts = inner is not controller
    if adapts and (margin := distance(bench, speed, rate_of(bench, speed), unit)) < DISTANCE / 2.0:
        return f"the adaptation is only {margin:.2g} away from instability on it, as its resonance lies elsewhere"
    return "the controller takes nothing away on it, although its phases are within 90 degrees of the model's"


def amplitudes_of(bench: Bench, speed: float, *, model: bool) -> Any:
    """Complex amplitudes [rad] of the error under the plain loop: run on the model, or measured on the plant."""
    loops = plain_run(bench, speed, model=model)
    return (loops.amplitude * np.exp(1j * loops.phase))[:, 0]


def response_at_error(bench: Bench, speed: float) -> Any:
    """Response (orders,) at the size that the plain loop's error has on the model."""
    return bench.response(speed, size=size_of(bench, amplitudes_of(bench, speed, model=True))).error_of_torque


def own_rate(bench: Bench, speed: float, controller: Any) -> float:
    """Slowest rate [1/s] at which a controller learns on a bench, by its own gains; 0 where it does not."""
    rates, inner = [], controller
    while inner is not None:
        if isinstance(inner, AdaptiveCancellation):
            rates += [0.5 * inner.gain * g for g in _along(bench, speed, inner)]
        elif isinstance(inner, Repetitive):
            orders = np.array([order for order in bench.orders if order % 1 == 0])
            learned = np.real(-bench.response(speed, orders).error_of_torque * np.exp(1j * orders * inner.lead))
            forgotten = inner.smooth * (1.0 - np.cos(2.0 * pi * orders / CELLS)) / inner.period
            rates.append(max(0.0, float(np.min(inner.gain * learned + forgotten, initial=np.inf))) / CELLS)
        inner = getattr(inner, "loop", None)
    return float(min((rate for rate in rates if rate > 0.0), default=0.0))


def _along(bench: Bench, speed: float, inner: AdaptiveCancellation) -> list[float]:
    """Response [rad/(N*m)] at the order of an adaptation along its phase, of an equation's plain loop at both sizes."""
    base: Any = inner
    while isinstance(base, AdaptiveCancellation):
        base = base.loop
    if not (bench.equation and inner.on_load and base == bench.loop):
        output = None if inner.on_load else behind_of(bench)
        return [float(abs(bench.response(speed, [inner.order], output).error_of_torque[0]))]
    i = bench.orders.index(inner.order)
    both = bench.response(speed).error_of_torque[i], response_at_error(bench, speed)[i]
    return [float(np.real(g * np.exp(-1j * inner.phase))) for g in both]


def tripped(controller: Any, state: Any) -> bool:
    """True where a guard in a controller has dropped its torque, by its memory."""
    while hasattr(controller, "loop"):
        if isinstance(controller, AdaptiveCancellation | Repetitive) and state[-1]:
            return True
        holds = controller.start() != controller.loop.start()  # its memory beside that of its loop
        controller, state = controller.loop, state[0] if holds else state
    return False
