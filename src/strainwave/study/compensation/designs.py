"""Controllers designed on a bench: each by its name, with what it needs and the condition under which it is stable.

A new one is a function of a bench and a motor speed [rad/s] that returns a controller, with an entry in `COMPENSATORS`.
A controller that is given, not designed, becomes one by `given_compensator`.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from math import pi
from typing import Any

import numpy as np

from ...base.protocols import lines_of
from ...compile.tree import leaves
from ...model.controllers.adaptive import CELLS, AdaptiveCancellation, Repetitive
from ...model.controllers.feedforward import AngleFeedforward, InverseDynamics, TorqueTable
from ...model.controllers.loops import DisturbanceObserver, Measurement, SampledPD, notch
from ...model.excitation import Harmonic, Harmonics, KinematicError
from .bench import Bench
from .gains import (
    amplitudes_of,
    guard,
    motor_guard,
    motor_lag_of,
    rate_of,
    repetitive_gains,
    response_at_error,
    torque_against,
)

FOLLOWING = ("angle", "nonlinear-inverse", "adaptive-motor", "observer", "notch")  # they need a motor on a reference
OBSERVER_BANDWIDTH = 2.0  # in those of the loop
GAIN_SHARES, GAINS = (0.5, 0.25), ("gain", "bandwidth")  # tried where all gains are unstable; fields that are gains


@dataclass(frozen=True)
class Compensator:
    """A way to cancel the error.

    Attributes
    ----------
    name, title : str
        Name on the command line, and title.
    build : callable
        Of a bench and a motor speed [rad/s]: the controller.
    load_encoder : bool
        True for one that measures the load's angle.
    stable : str
        The condition under which it is stable, as a sentence.
    feedback : bool
        True for one that moves the poles of the plain loop: it is then built on a model that it does not make unstable.
    """

    name: str
    title: str
    build: Callable[[Bench, float], Any]
    load_encoder: bool
    stable: str
    feedback: bool = True

    def controller_on(self, bench: Bench, speed: float) -> Any:
        """The controller for a bench and a motor speed [rad/s]; refused where it is blind or unstable (ValueError)."""
        if bench.equation and self.name in FOLLOWING:
            raise ValueError(
                f"{self.name} needs a motor that follows a reference, which the error equation lacks; use "
                "'inverse' or 'adaptive', or give the speeds of the motor and a loop"
            )
        if self.load_encoder and not bench.sampling.load_encoder:
            raise ValueError(
                f"{self.name} needs an encoder on the load, but Sampling.load_encoder is 0; set it to 1, or use a "
                "controller without load encoder, such as 'inverse'"
            )
        built = self.build(bench, speed)
        return _stabilised(self.name, bench, built, speed) if self.feedback else built


def _stabilised(name: str, bench: Bench, controller: Any, speed: float) -> Any:
    """A controller on whose model all small motions decay: as it is, or with half the gains with which they do."""
    first = bench.growth(controller, speed, model=True)
    if first < 0.0:
        return controller
    for share in GAIN_SHARES:
        lower = scaled_gains(controller, share)
        if lower == controller:
            break
        if bench.growth(lower, speed, model=True) < 0.0:
            return scaled_gains(controller, 0.5 * share)
    has_gains = scaled_gains(controller, 0.5) != controller
    still = f", even with {GAIN_SHARES[-1]:g} of the gains" if has_gains else ""
    raise ValueError(
        f"{name} is unstable on its own model at {bench.speeds.said(speed)}: small motions of the sampled loop grow by "
        f"a factor e every {1.0 / max(first, 1e-9):.3g} s{still}; use another controller, or change the plain loop"
    )


def scaled_gains(controller: Any, share: float) -> Any:
    """A controller with a share of its gains of feedback; its plain loop stays."""
    if not hasattr(controller, "loop"):
        return controller
    changed = {name: share * getattr(controller, name) for name in GAINS if hasattr(controller, name)}
    return controller._replace(loop=scaled_gains(controller.loop, share), **changed)


def _linear_inverse(bench: Bench, speed: float, share: float = 1.0) -> Any:
    model, J, lead, loop = bench.model, share * bench.model.motor.J, bench.lead, bench.loop
    twists, torques = bench.twists(speed), bench.against if share else ()
    if not bench.equation and (lines_of(model.error) or twists):
        error = KinematicError((*lines_of(model.error), *twists)) if twists else model.error
        loop = AngleFeedforward(loop, error, model.N, lead, J)
    elif not torques:
        raise ValueError(
            "no motor angle cancels the error of this drive; only a torque does; use 'inverse', "
            "'predicted-table' or 'adaptive'"
        )
    return TorqueTable(loop, Harmonics(torques), lead) if torques else loop


_angle = partial(_linear_inverse, share=0.0)


def _nonlinear_inverse(bench: Bench, _speed: float) -> Any:
    return InverseDynamics(bench.loop, bench.model, bench.lead)


def table_against(bench: Bench, speed: float, amplitudes: Any) -> TorqueTable:
    """Torque table [N*m] that cancels complex amplitudes [rad] of the error at the bench's orders, by its model."""
    torque = torque_against(bench, speed, bench.orders, amplitudes)
    orders = [round(order / bench.table_turns) for order in bench.orders]
    lines = [Harmonic(float(abs(t)), k, float(np.angle(t))) for k, t in zip(orders, torque, strict=True)]
    return TorqueTable(bench.loop, Harmonics(tuple(lines)), turns=bench.table_turns)


def _table(bench: Bench, speed: float, *, model: bool) -> Any:
    return table_against(bench, speed, amplitudes_of(bench, speed, model=model))


_predicted_table, _measured_table = partial(_table, model=True), partial(_table, model=False)


def _adaptive_inverse(bench: Bench, speed: float) -> Any:
    return adaptive_cancellation(bench, speed, _linear_inverse(bench, speed))


def adaptive_cancellation(
    bench: Bench, speed: float, loop: Any = None, output: Any = None, largest: float | None = None
) -> Any:
    """Adaptive cancellation of every order around a loop, with the model's phase: of the load's error, or an output."""
    alone = bench.equation and loop is None and output is None
    loop = bench.loop if loop is None else loop
    G, rate = bench.response(speed, output=output).error_of_torque, rate_of(bench, speed)
    largest, period = guard(bench, speed) if largest is None else largest, bench.sampling.period
    sized = response_at_error(bench, speed) if alone else G
    for k, g, large in zip(bench.orders, G, sized, strict=True):
        middle = g + large * (abs(g) / abs(large))  # where a stiffness bends, no phase is far off in small and large
        gain, phase, on_load = 2.0 * rate / float(abs(g)), float(np.angle(middle)), int(output is None)
        loop = AdaptiveCancellation(loop, bench.model.N, gain, phase, largest, period, order=k, on_load=on_load)
    return loop


def _repetitive(bench: Bench, speed: float) -> Any:
    lead, smooth, rate = repetitive_gains(bench, speed)
    size = float(np.max(np.abs(bench.response(speed).error_of_torque)))
    period, largest = bench.sampling.period, guard(bench, speed, mean=True)
    return Repetitive(bench.loop, bench.model.N, CELLS * rate / size, lead, smooth, largest, period)


def _adaptive_motor(bench: Bench, speed: float) -> Any:
    return adaptive_cancellation(bench, speed, bench.loop, motor_lag_of(bench), motor_guard(bench, speed))


def _observer(bench: Bench, _speed: float) -> Any:
    inertia = bench.model.motor.J
    gains = bench.loop
    bandwidth = np.sqrt(gains.K_p / inertia) if isinstance(gains, SampledPD) else 0.1 / bench.sampling.period
    limit = 0.2 / (bench.sampling.period + bench.sampling.delay + bench.lag)
    return DisturbanceObserver(gains, inertia, float(min(OBSERVER_BANDWIDTH * bandwidth, limit)), bench.sampling.period)


def _notch(bench: Bench, speed: float) -> Any:
    """Notch at the resonance of the free train: there the loop excites it most."""
    train = bench.model
    stiffness = float(train.law.stiffness(bench.start(speed, model=True)[0]))
    frequency = np.sqrt(stiffness * (1.0 / train.load_inertia + 1.0 / (train.N**2 * train.motor.J)))
    return notch(bench.loop, float(min(frequency, 0.9 * pi / bench.sampling.period)), bench.sampling.period)


POLES = "All poles of the sampled loop lie inside the unit circle."
POSITIVE = "The controller is stable if the plain loop is: a torque independent of measurements moves no pole."
MEASURED = POSITIVE + " The error decreases if the phase error of the model is below 60 degrees."
ADAPTED = "The adaptation converges for a small gain if the model's phase error is below 90 degrees at every order."
HELD = ADAPTED + " The load retains the error of a held motor."
REPEATED = (
    "Learning converges for a small gain if the plant's phase and the phase lead differ by less than 90 degrees at "
    "every order within the smoothing bandwidth."
)
OBSERVED = "The observer bandwidth is below a fifth of the inverse of delay and period."
NOTCHED = "The phase lag of the filter is within the phase margin of the loop."
BY_INVERSE = "torque table from the measured error and the inverse model"
DESIGNS = (
    Compensator("loop", "the plain loop", lambda bench, _: bench.loop, False, POLES, False),
    Compensator("angle", "angle feedforward N (theta_ref + e)", _angle, False, POSITIVE, False),
    Compensator(
        "inverse", "linear inverse: angle feedforward with the motor's inertia", _linear_inverse, False, POSITIVE, False
    ),
    Compensator("nonlinear-inverse", "nonlinear inverse of the model", _nonlinear_inverse, False, POSITIVE, False),
    Compensator(
        "predicted-table", "torque table from the error of the model", _predicted_table, False, POSITIVE, False
    ),
    Compensator("measured-table", BY_INVERSE, _measured_table, True, MEASURED, False),
    Compensator("adaptive", "adaptive cancellation of the load's error", adaptive_cancellation, True, ADAPTED),
    Compensator("adaptive-inverse", "linear inverse, adapted to the residual error", _adaptive_inverse, True, ADAPTED),
    Compensator("adaptive-motor", "adaptive cancellation of the motor's deviation", _adaptive_motor, False, HELD),
    Compensator("repetitive", "repetitive control over the motor's turn", _repetitive, True, REPEATED),
    Compensator("observer", "disturbance observer on the motor", _observer, False, OBSERVED),
    Compensator("notch", "notch filter at the resonance with free motor", _notch, False, NOTCHED),
)
COMPENSATORS = {design.name: design for design in DESIGNS}


def given_compensator(controller: Any) -> Compensator:
    """A design that gives a controller as it is."""
    name = type(controller).__name__
    condition = "Stability is that of the sampled loop, which is computed."
    return Compensator(name, name, lambda _bench, _speed: controller, sees_load(controller), condition, False)


def sees_load(controller: Any) -> bool:
    """True for a controller that depends on the load's angle."""
    measurements = [Measurement(0.3, 0.0, 0.0, 0.3, load, 0.0, 0.0) for load in (0.0, 1e-3)]
    without, shifted = [leaves(controller.update(controller.start(), m)) for m in measurements]
    return bool(without != shifted)
