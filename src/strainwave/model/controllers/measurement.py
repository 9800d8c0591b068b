"""What a sampled controller is given: the reference motion, the encoders' angles and the torque that was in force.

A controller is a NamedTuple of floats with two methods:

- `start()`: its memory before the first sample, a tuple of floats, or of such tuples,
- `update(state, m)`: its memory after a sample and the torque [N*m] that it asks of the motor, from a `Measurement`.

A controller that adds to another one has it as its field `loop`, so that they nest. Controllers are written without
branches (`abs`, `choices`, `maths`): one definition is run by compiled ensembles and is exported as C.
"""

from typing import Any, NamedTuple

from ...base.choices import select
from ...base.quantities import Angle, AngularAcceleration, AngularSpeed, Torque
from ...compile.jit import kernel


class Measurement(NamedTuple):
    """One sample: the motor's reference motion, the measured angles, and the torque after the last one's limit.

    `load` is the angle of the load on its own shaft; it is NaN where no encoder measures it. `cut` is what the limit
    did to the last torque: `applied` less the whole torque that was asked for, by all controllers around each other.
    """

    reference: Angle
    speed: AngularSpeed
    acceleration: AngularAcceleration
    motor: Angle
    load: Angle
    applied: Torque
    cut: Torque


@kernel
def moved(m: Any, angle: Any, speed: Any, acceleration: Any) -> Any:
    """The same sample with another motion to follow: the reference and what is added to it."""
    return Measurement(
        m.reference + angle, m.speed + speed, m.acceleration + acceleration, m.motor, m.load, m.applied,
        m.cut,
    )  # fmt: skip


@kernel
def known(value: Any) -> Any:
    """Return a number, or 0 where it is NaN."""
    return select(value == value, value, 0.0)
