"""Specimens of one type of gear, the units of a scatter, under one controller: a compensation under scatter."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from ...base.protocols import lacking, lines_of, terms_of
from ...model.controllers.adaptive import AdaptiveCancellation
from ...model.excitation import Harmonics, KinematicError, shortest
from ...model.train.drive_train import DriveTrain
from ...numerics.ensemble.loops import loop_ensemble
from ..analysis.design_variables import stiffer
from .bench import Bench, lines_in
from .gains import LEAST_DISTANCE, distance, rate_of
from .result import Units

STIFFNESS_SCATTER, LINE_SCATTER = 0.15, 0.5  # largest relative differences from unit to unit; the phase is any
GIVEN_UP = 0.9  # of the error before: a guard has tripped, or nothing is gained


def units_of(bench: Bench, controller: Any, speed: float, settle: float, end: float, units: int, seed: int) -> Units:
    """Run units whose stiffness, kinematic error and its phases differ, under the plain loop and a controller."""
    draw = np.random.default_rng(seed)
    stiffness = 1.0 + STIFFNESS_SCATTER * draw.uniform(-1.0, 1.0, units)
    amplitude = 1.0 + LINE_SCATTER * draw.uniform(-1.0, 1.0, units)
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
        return "the plain loop itself is unstable on this unit"
    inner = controller
    while isinstance(inner, AdaptiveCancellation):
        off = np.degrees(np.angle(np.exp(1j * inner.phase) / response.error_of_torque[bench.orders.index(inner.order)]))
        if abs(off) > 90.0:
            return f"the plant's phase at order {inner.order:.6g} is {off:.0f} degrees off the model's, beyond 90"
        inner = inner.loop
    if limited > 0.0:
        return f"the torque is at its limit of {bench.sampling.limit:.4g} N*m in {100.0 * limited:.3g} % of the samples"
    adapts = inner is not controller
    if adapts and (margin := distance(bench, speed, rate_of(bench, speed), unit)) < LEAST_DISTANCE / 2.0:
        return f"the adaptation is only {margin:.2g} away from instability, as the resonance differs from the model's"
    return "the controller does not reduce the error, although the phase error of the model is below 90 degrees"
