"""Units of one type under one controller: what scatter leaves of a compensation."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from ...base.protocols import lines_of
from ...model.controllers.adaptive import AdaptiveCancellation
from ...model.excitation import KinematicError, Line
from ...model.train.drive_train import DriveTrain
from ...numerics.sampled.loops import loop_ensemble
from ..analysis.remedies.knobs import stiffer
from .bench import Bench
from .gains import DISTANCE, distance, rate_of
from .result import Units

GIVEN_UP = 0.9  # of the error before: a guard has tripped, or nothing is gained
SCATTER = (0.15, 0.5)  # of stiffness and kinematic error from unit to unit, as shares; the phase is any


def units_of(bench: Bench, controller: Any, speed: float, settle: float, end: float, units: int, seed: int) -> Units:
    """Run units whose stiffness, kinematic error and its phases differ, under the plain loop and a controller."""
    draw = np.random.default_rng(seed)
    stiffness = 1.0 + SCATTER[0] * draw.uniform(-1.0, 1.0, units)
    amplitude = 1.0 + SCATTER[1] * draw.uniform(-1.0, 1.0, units)
    phases = draw.uniform(0.0, 2.0 * np.pi, (units, len(lines_of(bench.plant.error))))
    plants = [
        unit_of(bench.plant, *row) for row in zip(stiffness.tolist(), amplitude.tolist(), phases.tolist(), strict=True)
    ]
    found = []
    orders, y0 = np.array(bench.orders, float), bench.start(speed)
    for one in (bench.loop, controller):
        loops = [bench.closed(one, speed)._replace(train=plant._replace(omega=speed)) for plant in plants]
        found.append(loop_ensemble(loops[0], loops, end, settle=settle, orders=orders, y0=y0))
    before, after = found
    lost = ~after.stable | (after.rms > GIVEN_UP * before.rms)
    unstable = tuple(
        (int(i), _cause(bench, controller, speed, plants[i], float(after.limited[i]))) for i in np.flatnonzero(lost)
    )
    return Units(before, after, stiffness, amplitude, unstable)


def unit_of(plant: DriveTrain, stiffness: float, amplitude: float, phases: Sequence[float]) -> DriveTrain:
    """A train with factors of its stiffness and kinematic error, and phases [rad] of the lines of that."""
    law = stiffer(plant.law, stiffness - 1.0)
    if law is None:
        raise ValueError(
            f"the stiffness of {type(plant.law).__name__} cannot be scaled by its numbers: no units are drawn"
        )
    lines = tuple(
        Line(line.order, line.amplitude * amplitude, phase)
        for line, phase in zip(lines_of(plant.error), phases, strict=True)
    )
    return plant._replace(law=law, error=KinematicError(lines))


def _cause(bench: Bench, controller: Any, speed: float, plant: DriveTrain, limited: float) -> str:
    """Why the error of a unit grew: the plant's phase at an order that adapts, or its poles."""
    unit = Bench(plant, plant, bench.loop, bench.sampling)
    response = unit.response(speed, bench.orders)
    if not response.stable:
        return "the plain loop itself is unstable on it"
    inner = controller
    while isinstance(inner, AdaptiveCancellation):
        off = np.degrees(np.angle(np.exp(1j * inner.phase) / response.error_of_torque[bench.orders.index(inner.order)]))
        if abs(off) > 90.0:
            return f"the plant's phase at order {inner.order} is {off:.0f} degrees off the model's, beyond 90"
        inner = inner.loop
    if limited > 0.0:
        return f"the torque meets its limit of {bench.sampling.limit:.4g} N*m in {100.0 * limited:.3g} % of the samples"
    near = distance(bench, speed, rate_of(bench, speed), unit)
    if inner is not controller and near < DISTANCE / 2.0:
        return f"the adaptation is only {near:.2g} away from instability on it, as its resonance lies elsewhere"
    return "the controller takes nothing away on it, although its phases are within 90 degrees of the model's"
