"""Torques of the motor from outside, which a sampled controller gives: on its own motion, or on the error alone."""

from typing import Any, NamedTuple

from ...base.quantities import Reals, States


class Commanded(NamedTuple):
    """A torque from outside: it is the internal state z [N*m] itself, which a sampled controller overwrites.

    Between two samples it stays as it is.
    """

    def states(self) -> int:
        """Number of internal states."""
        return 1

    def torque(self, x: Reals, v: Reals, z: Any) -> Any:
        """Torque [N*m] against the deviation: the commanded torque pushes along the motion."""
        return -z[0]

    def z_rate(self, x: Reals, v: Reals, z: Any) -> Any:
        """Rate of the held torque: 0."""
        return (0.0 * z[0],)


COMMANDED = Commanded()


class TorqueDriven(NamedTuple):
    """A free motor under a torque from outside, at the level of the error equation: x alone moves.

    As `Commanded`, but the motor's own motion is left out: its deviation stays 0, so that the pointing error is x. A
    torque of the motor adds itself over N J_m to x''.
    """

    def states(self) -> int:
        """Number of internal states."""
        return 1

    def torque(self, x: Reals, v: Reals, z: Any) -> Any:
        """Torque [N*m] against the deviation: the commanded torque pushes along the motion."""
        return -z[0]

    def z_rate(self, x: Reals, v: Reals, z: Any) -> Any:
        """Rate of the held torque: 0."""
        return (0.0 * z[0],)

    def respond(self, J: Reals, torque: Reals, excitation: Reals, reference: States, deviation: States, z: Any) -> Any:
        """Result of `controlled`: the acceleration of a free motor, whose deviation does not move."""
        still = 0.0 * deviation[0]
        return (excitation + torque + z[0]) / J, z[0], (still, still, still)
