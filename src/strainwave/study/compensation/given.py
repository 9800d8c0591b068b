"""Controllers that are given, not designed: what they measure, how fast they learn, and whether they gave up."""

from math import pi
from typing import Any

import numpy as np

from ...model.controllers.adaptive import AdaptiveCancellation
from ...model.controllers.loops import LoadIntegral
from ...model.controllers.measurement import Measurement
from ...model.controllers.repetitive import CELLS, Repetitive
from ...tree import leaves
from .bench import Bench
from .designs import Compensator
from .gains import behind_of


def given(controller: Any) -> Compensator:
    """A design that gives a controller as it is."""
    name = type(controller).__name__
    return Compensator(
        name,
        name,
        lambda _bench, _speed: controller,
        sees_load(controller),
        "Its small motions are those of the sampled loop, which are computed.",
        False,
    )


def sees_load(controller: Any) -> bool:
    """Whether what a controller does depends on the load's angle."""
    seen = [Measurement(0.3, 0.0, 0.0, 0.3, load, 0.0, 0.0) for load in (0.0, 1e-3)]
    one, other = (leaves(controller.update(controller.start(), m)) for m in seen)
    return bool(one != other)


def own_rate(bench: Bench, speed: float, controller: Any) -> float:
    """Slowest rate [1/s] at which a controller learns on a bench, by its own gains; 0 where it does not."""
    rates, inner = [], controller
    while inner is not None:
        if isinstance(inner, AdaptiveCancellation):
            output = None if inner.on_load else behind_of(bench)
            rates.append(0.5 * inner.gain * abs(bench.response(speed, [inner.order], output).error_of_torque[0]))
        elif isinstance(inner, Repetitive):
            orders = np.array(bench.orders)
            learned = np.real(-bench.response(speed).error_of_torque * np.exp(1j * orders * inner.lead))
            forgotten = inner.smooth * (1.0 - np.cos(2.0 * pi * orders / CELLS)) / inner.period
            rates.append(max(0.0, float(np.min(inner.gain * learned + forgotten))) / CELLS)
        elif isinstance(inner, LoadIntegral):
            rates.append(inner.gain)
        inner = getattr(inner, "loop", None)
    return float(min((rate for rate in rates if rate > 0.0), default=0.0))


def tripped(controller: Any, state: Any) -> bool:
    """Whether a guard in a controller has dropped its torque, by its memory."""
    while hasattr(controller, "loop"):
        if isinstance(controller, AdaptiveCancellation | Repetitive) and state[-1]:
            return True
        holds = controller.start() != controller.loop.start()  # its memory beside that of its loop
        controller, state = controller.loop, state[0] if holds else state
    return False
