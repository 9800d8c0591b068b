"""Input shaping: a motion made of delayed copies of itself, which leaves a vibration at rest."""

from math import exp, pi, sqrt
from typing import Any, NamedTuple

from ...base.protocols import need
from ...base.quantities import Time, number, shown

KINDS = ("ZV", "ZVD")


class Shaped(NamedTuple):
    """Sum of copies of a reference motion, each a time later and times a weight; the weights add up to 1.

    The base angle is the time: for runs with omega = 1. `shaped` finds times and weights for a vibration.
    """

    motion: Any
    times: tuple[Time, ...]
    weights: tuple[float, ...]

    def value(self, phase: Any) -> Any:
        """Angle [rad] at a time [s]."""
        total = 0.0 * phase
        for i in range(len(self.times)):
            total = total + self.weights[i] * self.motion.value(phase - self.times[i])
        return total

    def slope(self, phase: Any) -> Any:
        """Speed [rad/s] at a time [s]."""
        total = 0.0 * phase
        for i in range(len(self.times)):
            total = total + self.weights[i] * self.motion.slope(phase - self.times[i])
        return total

    def curvature(self, phase: Any) -> Any:
        """Acceleration [rad/s^2] at a time [s]."""
        total = 0.0 * phase
        for i in range(len(self.times)):
            total = total + self.weights[i] * self.motion.curvature(phase - self.times[i])
        return total

    def check(self) -> None:
        """Refuse a motion that is none (TypeError), and weights that do not add up to 1 (ValueError)."""
        need("Shaped.motion", self.motion, "curvature")
        if len(self.times) != len(self.weights) or abs(sum(self.weights) - 1.0) > 1e-9:
            raise ValueError(
                f"Shaped has {len(self.times)} times and weights that add up to {sum(self.weights):g}; give each time "
                "a weight, together 1"
            )


def shaped(motion: Any, frequency: float, damping: float = 0.0, *, kind: str = "ZVD") -> Shaped:
    """Return a motion that leaves a vibration of a linear plant at rest.

    Parameters
    ----------
    motion : reference motion
        In time, such as a `SpeedProfile`.
    frequency : float
        Natural frequency of the vibration [rad/s], without damping.
    damping : float
        Its damping ratio, from 0 to below 1.
    kind : {"ZV", "ZVD"}
        Two copies, or three, which make it insensitive to a frequency that is off: 5 % of the vibration is left where
        it is off by 3 % (ZV) or 14 % (ZVD). It lengthens the motion by half a period or a whole one.

    Returns
    -------
    Shaped

    Raises
    ------
    ValueError
        If a number is out of range, or the kind is another.

    References
    ----------
    Singer & Seering, Preshaping command inputs to reduce system vibration, J. Dyn. Sys. Meas. Control 112(1), 1990,
    76-82.
    """
    omega, zeta = number("frequency [rad/s]", frequency, positive=True), number("damping", damping)
    if not 0.0 <= zeta < 1.0:
        raise ValueError(f"damping is {zeta:g}; it must be from 0 to below 1, or nothing vibrates")
    if kind not in KINDS:
        raise ValueError(f"kind is {shown(kind)}; it must be 'ZV' or 'ZVD'")
    half = pi / (omega * sqrt(1.0 - zeta * zeta))
    K = exp(-zeta * omega * half)
    weights = (1.0, K) if kind == "ZV" else (1.0, 2.0 * K, K * K)
    found = Shaped(motion, tuple(half * i for i in range(len(weights))), tuple(w / sum(weights) for w in weights))
    need("motion", motion, "curvature")
    return found
