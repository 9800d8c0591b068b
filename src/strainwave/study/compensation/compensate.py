"""`compensate`: a controller on a drive against its plain loop, and a bench of several at several speeds."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ...base.protocols import lines_of
from ...base.quantities import number, numbers, shown, whole
from ...base.terminal import Progress, silent
from ...base.units import ARCSEC
from ...drive.project import Project
from ...drive.train_curve import in_turns
from ...model.controllers import Sampling
from ...model.controllers.loops import SampledPD
from ...model.excitation import mean_torque
from ...model.train.drive_train import DriveTrain
from ...numerics.ensemble.loops import MOST_SAMPLES, LoopEnsemble
from ...numerics.operating_point import loaded_state
from ..analysis.design_variables import stiffer
from .bench import Bench, lines_in, steady_bench_of
from .designs import COMPENSATORS, Compensator, given_compensator
from .gains import adaptation, converged_at, has_tripped, learning_rate, refuse_unstable, steady_run, times_of, turns_of
from .result import DIFFER, Compensation, CompensationBench, Residual, Robustness, TorqueUse, gains, grows
from .specimens import units_of

STIFFNESS_SHARES = (-0.2, 0.2)  # by which the stiffness of a gear may differ from the model
HERTZ = 2.0 * np.pi
MOST_UNITS = 100_000
PLAIN = "loop"  # name of the design that everything is compared with
ERROR_SHARE = 0.1  # of the error before: with more left, the guards are checked
SLOW_SHARE = 0.5  # of the rate of the plain loop: what is slower is waited for
SLOWEST_FACTOR = 100.0  # of the longest run that is taken: what is slower is not waited for
FEWEST_SAMPLES = 8.0  # samples in a period of the highest order: below, what is fed forward comes too coarse


def compensate(
    project: Project | DriveTrain,
    controller: Any = "adaptive-inverse",
    *,
    speed: float | None = None,
    sampling: Sampling | None = None,
    loop: Any = None,
    plant: DriveTrain | None = None,
    robust: bool = True,
    units: int = 0,
    seed: int = 1,
    load_angles: ArrayLike | None = None,
    progress: Progress = silent,
) -> Compensation:
    """Run a drive in closed loop with a controller, and with its plain loop, at a constant speed.

    The whole train is integrated under the sampled controller: period, delay, limit of the torque, encoders. Errors are
    those of the load, over a whole number of turns of the motor after all transients.

    Parameters
    ----------
    project : Project or DriveTrain
        The drive, with lines of a kinematic error or of torques. A project with the speeds of a forcing and a free
        motor is its error equation: the torque of the motor adds itself over N J_m to x'', and there is no plain loop.
    controller : str or controller
        Name of a design (`sw.study.COMPENSATORS`), which is then designed on the drive's model; or a controller itself.
    speed : float, optional
        Speed of the motor or the forcing [rad/s], negative in backward motion. Default: where the drive's largest
        order meets its resonance under the mean torque of the load, within its range.
    sampling : Sampling, optional
        Period, delay, limit, encoders. Default: those of the project's file (`controller`); without them every 250 us,
        one period of delay, 16 bits on the motor, 24 on the load, the motor's limit of the project.
    loop : controller, optional
        The plain loop. Default: that of the project, sampled; where it names none, a PD loop of 30 Hz.
    plant : DriveTrain, optional
        The drive that is run, where it differs from the project, on which the controller is designed.
    robust : bool
        True to run the controller on gears that are 20 % softer and stiffer than the model, too.
    units : int
        Number of units of the type that are run: stiffness within 15 %, lines within 50 %, any phase.
    seed : int
        The same seed gives the same units.
    load_angles : (n,) array_like, optional
        Angles of the load [rad] at which gravity is held, for each of which the controller is designed and run: the
        result is that of the angle at which it leaves most. Default: 0.
    progress : callable
        progress(stage, share): called before each stage.

    Returns
    -------
    Compensation
        Pointing error `before` and `after`, its `rms` and `peak` [rad]; torque of the motor `torque_before` and
        `torque`, its `rms` and `peak` [N*m]; whether the loop is `stable`; the `rate` [1/s] of one that adapts, and
        the time `converged` [s] that it took; `robustness` and `units` as asked.

    Raises
    ------
    ValueError
        If samples are too slow for the orders, the plain loop is unstable, or a number is out of range.
    """
    benches = benches_of(project, sampling, loop, plant, load_angles)
    motor_speed = _speed(next(iter(benches.values())), project, speed)
    design = compensator_of(controller)
    if whole("units", units) > MOST_UNITS:
        raise ValueError(f"units is {shown(units)}; give {MOST_UNITS:,} at most")
    return _at_worst_angle(benches, design, motor_speed, robust, int(units), whole("seed", seed), progress)


def compensation_bench(
    project: Project | DriveTrain,
    controllers: Sequence[Any] | str = tuple(COMPENSATORS),
    *,
    speeds: ArrayLike,
    sampling: Sampling | None = None,
    loop: Any = None,
    plant: DriveTrain | None = None,
    robust: bool = False,
    load_angles: ArrayLike | None = None,
    progress: Progress = silent,
) -> CompensationBench:
    """Run several controllers on one drive at several speeds; parameters and errors as of `compensate`.

    Parameters
    ----------
    project : Project or DriveTrain
        The drive.
    controllers : sequence of str or controller
        Names of designs, or controllers.
    speeds : (n,) array_like
        Speeds of the motor [rad/s], negative in backward motion.
    sampling, loop, plant, robust, load_angles, progress
        As of `compensate`.

    Returns
    -------
    CompensationBench
        `results[controller][speed]`, each a `Compensation`: root mean square and largest pointing error [rad]
        `before` and `after`.
    """
    benches = benches_of(project, sampling, loop, plant, load_angles)
    controllers = (controllers,) if isinstance(controllers, str) else controllers
    grid = numbers("speeds [rad/s]", speeds)
    designs = [compensator_of(controller) for controller in controllers]
    if not len(grid) or not designs:
        raise ValueError("nothing to simulate; give at least one controller and one speed")
    for speed in grid:
        _refuse_slow(next(iter(benches.values())), float(speed))
    results, finished = [], 0
    for design in designs:
        row = []
        for speed in grid.tolist():
            row.append(_at_worst_angle(benches, design, speed, robust, 0, 0, silent))
            finished += 1
            speed_text = next(iter(benches.values())).speeds.said(speed)
            progress(f"{design.name} at {speed_text}", finished / (len(designs) * len(grid)))
        results.append(tuple(row))
    return CompensationBench(grid, tuple(design.name for design in designs), tuple(results))


def benches_of(
    project: Project | DriveTrain,
    sampling: Sampling | None = None,
    loop: Any = None,
    plant: DriveTrain | None = None,
    load_angles: ArrayLike | None = None,
) -> dict[float, Bench]:
    """A bench for each angle of the load [rad]."""
    if load_angles is None:
        return {0.0: steady_bench_of(project, sampling, loop, plant)}
    angles = numbers("load_angles [rad]", load_angles)
    if not len(angles):
        raise ValueError("load_angles has no angle; give at least one, such as (0.0,)")
    return {angle: steady_bench_of(project, sampling, loop, plant, angle) for angle in angles.tolist()}


def _at_worst_angle(
    benches: dict[float, Bench], design: Compensator, speed: float, robust: bool, units: int, seed: int, progress: Any
) -> Compensation:
    """One controller at one speed, at the angle of the load where it leaves most."""
    if len(benches) == 1:
        ((angle, bench),) = benches.items()
        return replace(_compensation(bench, design, speed, robust, units, seed, progress), load_angle=angle)
    by_angle = {angle: _compensation(bench, design, speed, False, 0, 0, silent) for angle, bench in benches.items()}
    angle = max(by_angle, key=lambda angle: (not by_angle[angle].stable, by_angle[angle].after.rms))
    sizes = [result.after.rms / ARCSEC for result in by_angle.values()]
    result = by_angle[angle]
    if robust or units:
        result = _compensation(benches[angle], design, speed, robust, units, seed, progress)
    remark = (
        f"Of {len(by_angle)} load angles that of {np.degrees(angle):.4g} deg is the worst: residual error "
        f"with {design.name}: {max(sizes):.3g} arcsec there, {min(sizes):.3g} arcsec at the best angle."
    )
    return replace(result, load_angle=angle, remarks=(*result.remarks, remark))


def compensator_of(controller: Any) -> Compensator:
    """A design by its name, or one that gives a controller as it is."""
    if isinstance(controller, str):
        if controller not in COMPENSATORS:
            raise ValueError(f"there is no controller {shown(controller)}; there are {', '.join(COMPENSATORS)}")
        return COMPENSATORS[controller]
    return given_compensator(controller)


def _speed(bench: Bench, project: Project | DriveTrain, speed: float | None) -> float:
    if speed is None:
        speed = resonance_speed(bench)
        speeds = getattr(project, "speeds", None)
        if speeds is not None and getattr(speeds, "limits", None):
            low, high = speeds.limits
            speed = min(max(speed, low), high)
    _refuse_slow(bench, number("speed [rad/s]", speed))
    return float(speed)


def resonance_speed(bench: Bench) -> float:
    """Speed of the motor [rad/s] where the largest order meets the resonance of the load on the gear, the motor held.

    It is that of small vibrations about the mean torque of the load; 0 where the gear has no stiffness there. Without a
    kinematic error the largest line of torque counts, and of an error equation the motor is free.
    """
    model = bench.model
    line = max(lines_of(model.error) or lines_in(model), key=lambda line: line.amplitude)
    inertia, torque = model.load_inertia, -mean_torque(model.load.end().excitation)
    if bench.equation:
        inertia = 1.0 / (1.0 / inertia + 1.0 / (model.N**2 * model.motor.J))
    torsion = bench.start(1.0, model=True)[0] if bench.equation else loaded_state(model.law, torque)[0]
    speed: float = np.sqrt(float(model.law.stiffness(torsion)) / inertia) / line.order
    return speed


def _refuse_slow(bench: Bench, signed: float) -> None:
    speed = abs(signed)
    if not speed:
        raise ValueError("speed [rad/s] is 0, and a drive at rest has no orders; give a motor speed above 0")
    highest = max(bench.orders)
    fastest = 2.0 * np.pi / (FEWEST_SAMPLES * bench.sampling.period * highest)
    if speed > fastest:
        raise ValueError(
            f"samples every {1e3 * bench.sampling.period:.4g} ms are too slow for order "
            f"{in_turns(highest, bench.model)} at {bench.speeds.said(speed)}, as one period needs "
            f"{FEWEST_SAMPLES:g} samples: sample at least every {1e3 * bench.sampling.period * fastest / speed:.3g} "
            f"ms, or stay below {bench.speeds.said(fastest)}"
        )
    turns = turns_of(bench)
    least = turns * 2.0 * np.pi / (MOST_SAMPLES * bench.sampling.period)
    if speed < least:
        raise ValueError(
            f"{turns:.6g} turns at {bench.speeds.said(speed)} take more than {MOST_SAMPLES:g} samples, one "
            f"every {1e3 * bench.sampling.period:.4g} ms; stay above {bench.speeds.said(least, 3)}, or sample more "
            "slowly"
        )


def _compensation(
    bench: Bench, design: Compensator, speed: float, robust: bool, units: int, seed: int, progress: Any
) -> Compensation:
    """Run one controller and the plain loop at one speed."""
    bench = bench.at_speed(speed)
    slowest = refuse_unstable(bench, speed).slowest
    controller = design.controller_on(bench, speed)
    rate = learning_rate(bench, speed, controller)
    sure = design.name in COMPENSATORS and bench.plant == bench.model  # its design has looked
    sure = sure and bool(rate or controller.start() == bench.loop.start())  # it settles at its rate or as the loop
    growth = -np.inf if sure else bench.growth(controller, speed)
    if not rate and SLOWEST_FACTOR / (MOST_SAMPLES * bench.sampling.period) < -growth < SLOW_SHARE / slowest:
        rate = -growth
    settle, end = times_of(bench, speed, rate)
    before, after = [steady_run(bench, one, speed, settle, end) for one in (bench.loop, controller)]
    progress("the drive", 0.3 if robust or units else 1.0)
    robustness = tuple(_robustness(bench, design, speed, settle, end)) if robust else ()
    scatter = units_of(bench, controller, speed, settle, end, units, seed) if units else None
    progress("units of the type", 1.0)
    result = Compensation(
        name=design.name,
        title=design.title,
        speed=speed,
        before=_residual(before),
        after=_residual(after),
        torque=_torque(after),
        torque_before=_torque(before),
        gear_torque=float(after.gear_torque[0]),
        orders=after.orders,
        amplitude_before=before.amplitude[:, 0],
        amplitude_after=after.amplitude[:, 0],
        robustness=robustness,
        stable=bool(after.stable[0] and growth < 0.0),
        condition=design.stable,
        load_encoder=design.load_encoder,
        excluded=_excluded(bench, after),
        units=scatter,
        controller=controller,
        warnings=(),
        remarks=bench.remarks,
        shaft=bench.speeds.base,
        rate=rate,
    )
    warnings = []
    if rate:
        run = adaptation(bench, controller, speed, end)
        result = replace(result, converged=converged_at(run, ERROR_SHARE * result.before.rms))
        if result.after.rms > ERROR_SHARE * result.before.rms and has_tripped(controller, run.memory.state):
            warnings.append(_given_up(bench, speed))
    warnings += [*_bandwidth_warning(bench, design, speed), *_warnings(design, result, float(growth))]
    return replace(result, warnings=tuple(f"controller {design.name}: {text}" for text in warnings))


def _residual(loops: LoopEnsemble) -> Residual:
    rms, mean = float(loops.rms[0]), float(loops.mean[0])
    return Residual(rms, float(loops.peak[0]), 3.0 * rms, mean)


def _torque(loops: LoopEnsemble) -> TorqueUse:
    return TorqueUse(float(loops.torque_rms[0]), float(loops.torque_peak[0]), float(loops.limited[0]))


def _robustness(bench: Bench, design: Compensator, speed: float, settle: float, end: float) -> Iterator[Robustness]:
    """Run a design on softer and stiffer gears; none where the numbers of the law do not say how."""
    for share in STIFFNESS_SHARES:
        if stiffer(bench.plant.law, share) is None:
            return
        other = bench.with_stiffness(share)
        controller = design.controller_on(other, speed)
        before, after = [steady_run(other, one, speed, settle, end) for one in (bench.loop, controller)]
        decays = after.stable[0] and other.growth(controller, speed) < 0.0
        rms = float(after.rms[0]) if decays else float("inf")
        yield Robustness(share, float(before.rms[0]), rms)


def _excluded(bench: Bench, after: LoopEnsemble) -> str:
    """Reason for which a speed does not count; empty where it does."""
    if after.limited[0] > 0.0 and after.torque_peak[0] >= bench.sampling.limit:  # not while it settled alone
        limit, share = bench.sampling.limit, 100.0 * after.limited[0]
        return f"the motor torque is at its limit of {limit:.4g} N*m in {share:.3g} % of samples"
    peak = getattr(bench.gear, "repeated_peak_torque", None)
    carried = after.gear_torque[0]
    if peak and carried > peak:
        return f"the gear torque of {carried:.4g} N*m exceeds the repeated peak torque of {peak:.4g} N*m"
    return ""


def _given_up(bench: Bench, speed: float) -> str:
    """Sentence on a controller that takes little away and whose guard has dropped its torque."""
    return (
        f"the guard switched the correction torque off at {bench.speeds.said(speed)}, as it exceeded what the error "
        "of the model requires; compare the sign and the phase of the model with the drive."
    )


def _bandwidth_warning(bench: Bench, design: Compensator, speed: float) -> Iterator[str]:
    """A warning where an order lies beyond the bandwidth of the loop that a corrected angle has to go through."""
    train, gains = bench.model, bench.loop
    if design.name != "angle" or not isinstance(gains, SampledPD):
        return
    bandwidth = float(np.sqrt(gains.K_p / train.loop_inertia))
    order = max(bench.orders)
    if order * abs(speed) > bandwidth:
        yield (
            f"order {in_turns(order, train)} at {bench.speeds.said(speed)} is "
            f"{order * abs(speed) / HERTZ:.3g} Hz, beyond the loop's bandwidth of {bandwidth / HERTZ:.3g} Hz, "
            "so the motor follows the correction only in part; 'inverse' adds the missing torque."
        )


def _warnings(design: Compensator, result: Compensation, growth: float) -> Iterator[str]:
    """Sentences on the faults of a result, on the drive and on other gears."""
    where, share = f"at {result.axis.said(result.speed)}", result.after.rms / result.before.rms
    if growth >= 0.0:
        yield (
            f"small motions of the sampled loop grow {where}, by a factor e every "
            f"{1.0 / max(growth, 1e-9):.3g} s; the controller is unstable on this drive, and the residual error is not "
            "steady."
        )
    elif not result.stable:
        yield f"the error grows {where}; the controller is unstable on this drive."
    elif grows(result.before.rms, result.after.rms):
        yield f"the error is {share:.3g} times that of the plain loop {where}; do not use the controller there."
    elif not result.gains and design.name != PLAIN:
        left = f"the residual error is {100.0 * share:.3g} %; two runs differ by up to {100.0 * DIFFER:.0f} %"
        yield f"no benefit {where}: {left}; compare the model with the drive, or let the controller adapt."
    for one in result.robustness if design.name != PLAIN else ():
        gear = f"on a gear {abs(100.0 * one.stiffness):.0f} % {'softer' if one.stiffness < 0.0 else 'stiffer'}"
        change = f"{one.before / ARCSEC:.3g} to {one.after / ARCSEC:.3g} arcsec"
        if grows(one.before, one.after):
            yield f"{gear} than the model the error grows from {change} {where}; measure it, or use 'adaptive'."
        elif not gains(one.before, one.after) and result.gains:
            yield f"no benefit {gear} than the model, from {change} {where}."
