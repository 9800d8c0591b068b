"""Dry friction of a shaft as it is: the shaft slides one way, or it sticks.

A shaft that sticks has no acceleration until the other torques on it exceed its break-away torque. Where it slides,
friction has the sign of its speed.
"""

import math
from collections.abc import Iterator
from typing import Any, NamedTuple

from ...base.law import class_of, energy_of, has, losses_of, share, tail, torque_of, z_rate_of
from ...base.quantities import Ratio, Reals, States
from ...compile.elementwise import select
from ...compile.jit import chosen
from .friction import Coulomb, LuGre, Stribeck, Viscous
from .hysteresis import Parallel
from .springs import Linear

STUCK = 2.0**60  # times its inertia: a shaft that sticks
REST = 1e-9  # rad/s for 1 rad/s of the motor: a slower shaft is at rest
CREEP = 1e-11  # rad/s beyond rest at which a slip ends, far above the rounding of speeds
SMOOTHED = 0.1  # rad/s of the motor, 1 rpm: below it dry friction creeps where steps are equal
SPARE = 1e-9  # of the break-away torque by which it is exceeded when a slip begins


class Dry(NamedTuple):
    """Drag of a shaft that slides one way, with the sign 1 or -1 of its speed, or sticks, with the sign 0."""

    drag: Any
    sign: Ratio

    def torque(self, x: Reals, v: Reals, z: States) -> Any:
        """Torque [N*m] at the speed v [rad/s]; of a shaft that sticks that of the other parts of its drag."""
        return one_way(self.drag, self.sign, x, v, z)

    def z_rate(self, x: Reals, v: Reals, z: States) -> Any:
        """Rates of the internal states."""
        return z_rate_of(self.drag, x, v, z)

    def stiffness(self, x: Reals) -> Any:
        """Stiffness [N*m/rad] of the drag."""
        return self.drag.stiffness(x)

    def energy(self, x: Reals, z: States) -> Any:
        """Energy stored [J] in the drag."""
        return energy_of(self.drag, x, z)

    def losses(self, x: Reals, v: Reals, z: States) -> Any:
        """Powers [W] that its parts turn into heat."""
        return losses_of(self.drag, x, v, z)


@chosen
def one_way(law: Any, sign: Any, x: Any, v: Any, z: Any) -> Any:
    """Torque [N*m] of a drag whose dry friction has a sign, 0 for none."""
    if class_of(law) is Parallel:
        return _one_way_of_both
    return _one_way if has(law, "sliding") else _any_way


def _one_way_of_both(law: Any, sign: Any, x: Any, v: Any, z: Any) -> Any:
    first = one_way(law.first, sign, x, v, share(law.first, z))
    return first + one_way(law.second, sign, x, v, tail(law.first, z))


def _one_way(law: Any, sign: Any, x: Any, v: Any, z: Any) -> Any:
    return sign * law.sliding(v)


def _any_way(law: Any, sign: Any, x: Any, v: Any, z: Any) -> Any:
    return torque_of(law, x, v, z)


@chosen
def breakaway(law: Any) -> Any:
    """Largest torque [N*m] of the dry friction in a drag, that at rest."""
    if class_of(law) is Dry:
        return _of_drag
    if class_of(law) is Parallel:
        return _of_both
    return _at_rest if has(law, "sliding") else _none


def _of_drag(law: Any) -> Any:
    return breakaway(law.drag)


def _of_both(law: Any) -> Any:
    return breakaway(law.first) + breakaway(law.second)


def _at_rest(law: Any) -> Any:
    return select(law.width == 0.0, law.sliding(0.0), 0.0)


def _none(law: Any) -> Any:
    return 0.0


@chosen
def guards_of(law: Any, v: Any, pull: Any) -> Any:
    """Functions that stay positive while a shaft slides as it does, at a speed [rad/s], or sticks at a pull [N*m]."""
    return _guards if class_of(law) is Dry else _no_guards


def _guards(law: Any, v: Any, pull: Any) -> Any:
    sticks = 1.0 - law.sign * law.sign
    spare = (1.0 + SPARE) * breakaway(law) - abs(pull)
    return (sticks * spare + law.sign * v + (1.0 - sticks) * CREEP,)


def _no_guards(law: Any, v: Any, pull: Any) -> Any:
    return ()


@chosen
def moved(law: Any, J: Any) -> Any:
    """Inertia [kg*m^2] that the torques on a shaft of this drag move."""
    return _held_fast if class_of(law) is Dry else _unstuck


def _held_fast(law: Any, J: Any) -> Any:
    return J * (1.0 + STUCK * (1.0 - law.sign * law.sign))


def _unstuck(law: Any, J: Any) -> Any:
    return J


def dry(law: Any) -> Any:
    """A drag that knows whether its shaft slides, if there is dry friction in it."""
    return law if isinstance(law, Dry) or not breakaway(law) else Dry(law, 0.0)


def stuck(law: Any) -> Any:
    """The drag of a shaft that sticks, if there is dry friction in it."""
    return Dry(law.drag, 0.0) if isinstance(law, Dry) else law


def rubbing(law: Any) -> float:
    """Torque [N*m] of the dry friction in a drag, well above the speed by which it has fallen."""
    return float(sum(part.T_c for part in _parts(law) if isinstance(part, Coulomb | Stribeck) and not part.width))


def parted(law: Any) -> float:
    """Speed [rad/s] above which a shaft of a drag only slides: three times that by which its friction has fallen."""
    return max(3.0 * part.v_s if isinstance(part, Stribeck) else 0.0 for part in _parts(law))


def comes_to_rest(law: Any, v: float, turning: float) -> bool:
    """True if a shaft is at rest at a speed v [rad/s] while its motor turns: one that slides as v changes sign."""
    return law.sign * v <= 0.0 if isinstance(law, Dry) else abs(v) <= REST * (1.0 + abs(turning))


def sign_at(law: Any, v: float, pull: float, rests: bool) -> float:
    """Sign of a slip at a speed [rad/s], or from rest under a pull [N*m], where it has none within the break-away."""
    if rests and abs(pull) <= breakaway(law):
        return 0.0
    return math.copysign(1.0, pull if rests else v)


def sliding(train: Any, speed: float) -> Any:
    """A drive train whose shafts slide as they do at a speed [rad/s] of its motor; at 0 without dry friction."""

    def slides(drag: Any) -> Any:
        return Dry(drag, math.copysign(1.0, speed)) if speed and breakaway(drag) else drag if speed else smooth(drag)

    return train.with_motor(drag=slides(train.motor.drag)).with_load(drag=slides(train.load.end().drag))


def is_dry(train: Any) -> bool:
    """True for a train with dry friction on a shaft."""
    return bool(breakaway(train.motor.drag) or breakaway(train.load.end().drag))


def smooth(law: Any) -> Any:
    """A drag without its dry friction."""
    if isinstance(law, Parallel):
        return Parallel(smooth(law.first), smooth(law.second))
    return Linear(0.0) if breakaway(law) else law


def without_dry_friction(train: Any) -> Any:
    """A drive train without the dry friction of its shafts, bristles included."""
    motor, load = settled(train.motor.drag), settled(train.load.end().drag)
    return sliding(train.with_motor(drag=motor).with_load(drag=load), 0.0)


def smoothed(train: Any) -> Any:
    """A drive train for equal steps: dry friction of its shafts creeps below `SMOOTHED`, that of the load over N."""

    def creeping(law: Any, width: float) -> Any:
        if isinstance(law, Parallel):
            return Parallel(creeping(law.first, width), creeping(law.second, width))
        if isinstance(law, Stribeck):
            width = min(width, 0.1 * law.v_s)
        return law._replace(width=width) if isinstance(law, Coulomb | Stribeck) else law

    motor, load = creeping(train.motor.drag, SMOOTHED), creeping(train.load.end().drag, SMOOTHED / train.N)
    return train.with_motor(drag=motor).with_load(drag=load)


def settled(law: Any) -> Any:
    """A drag as it is at steady speeds: bristles that slip (LuGre) are dry friction beside a viscous one."""
    if isinstance(law, Parallel):
        return Parallel(settled(law.first), settled(law.second))
    if isinstance(law, LuGre):
        return Parallel(Stribeck(law.T_c, law.T_s, law.v_s), Viscous(law.sigma_2))
    return law


def law_width(drag: Any) -> float:
    """Largest width [rad/s] of the friction in a drag, 0 of one that sticks or has none."""
    return max(getattr(part, "width", 0.0) for part in _parts(drag))


def refuse_dry(name: str, law: Any) -> None:
    """Refuse a law between shafts whose friction has no width (ValueError): `name` names it."""
    for part in _parts(law):
        if not getattr(part, "width", 1.0):
            raise ValueError(
                f"{name} has a {type(part).__name__} without a width; between two shafts the sign of friction is "
                "smoothed: give width [rad/s], well below the speeds that matter"
            )


def _parts(law: Any) -> Iterator[Any]:
    if isinstance(law, Dry):
        yield from _parts(law.drag)
    elif isinstance(law, Parallel):
        yield from (*_parts(law.first), *_parts(law.second))
    else:
        yield law
