"""Friction of the gear's meshing: a share of the torque that the gear transmits, which opposes the wave generator.

The friction law of a train is a function of the transmitted torque T [N*m, output side] and of the motor's speed
[rad/s]; divided by the ratio it acts on the motor. A motor that drives the load gives T (1 + mu)/N, a load that drives
the motor takes T (1 - mu)/N back.
"""

from typing import Any, NamedTuple

from ...base.quantities import AngularSpeed, Ratio
from .friction import positive, smooth_sign


class NoFriction(NamedTuple):
    """The meshing loses nothing."""

    def torque(self, T: Any, v: Any) -> Any:
        """Torque [N*m, output side]: 0."""
        return 0.0


NO_FRICTION = NoFriction()


class LoadFriction(NamedTuple):
    """Load-proportional friction T_f = mu |T| v/sqrt(v^2 + width^2): mu |T| sign v, smoothed over the speed `width`.

    `Gear.load_friction` gives mu from a catalogue's efficiency. Without any other friction the efficiency is
    1/(1 + mu) where the motor drives and 1 - mu where the load does.
    """

    mu: Ratio
    width: AngularSpeed = 1.0

    def torque(self, T: Any, v: Any) -> Any:
        """Torque [N*m, output side] against the motor's turning, at the torque T [N*m] and the motor's speed v."""
        return self.mu * abs(T) * smooth_sign(v, self.width)

    def check(self) -> None:
        """Refuse friction that drives, and a gear that its own friction locks (ValueError)."""
        positive(self, "width")
        if not 0.0 <= self.mu < 1.0:
            raise ValueError(
                f"LoadFriction.mu is {self.mu:g}; it must be from 0 up to 1, where the load can no longer drive the "
                "motor; give a share of the transmitted torque, for example 0.08"
            )
