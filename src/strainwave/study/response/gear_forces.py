"""What the gear of an error equation transmits and loses, and how strongly it is damped: with any law, and varying.

The error equation is an `Oscillator`, whose law may have friction and memory, or a `VaryingOscillator`, whose stiffness
and damping follow the base angle.
"""

import math
from typing import Any

import numpy as np

from ...law import depends, losses_of, torque_of
from ...protocols import lacking

SETTLE = 8.0  # in units of 1/mu: the transient falls to exp(-4) before the orbit is closed
UNDAMPED_PERIODS = 50
ANGLES = 2.0 * np.pi * np.arange(256) / 256


def damping_of(system: Any) -> float:
    """Damping [N*m*s/rad] across the gear of small motions, the mean over a turn; without friction in the law."""
    if not lacking(system, "B"):
        return float(system.B)
    return float(np.mean(np.broadcast_to(system.damping.value(ANGLES, 0.0), ANGLES.shape)))


def loses_energy(system: Any) -> bool:
    """Whether motions lose energy: by damping, or in a law with friction or memory."""
    return damping_of(system) > 0.0 or depends(system.law) > 1


def no_multiple_scales(system: Any) -> str:
    """Why multiple scales does not describe a system, as a sentence; empty where it can."""
    if depends(system.law) > 1:
        return "first-order multiple scales describes springs, and this law has friction or memory"
    if lacking(system, "B"):
        return "first-order multiple scales describes a constant stiffness and damping, and these vary"
    return ""


def gear_torque(system: Any, phase: Any, u: Any, du: Any, z: Any = ()) -> Any:
    """Torque through the gear [N*m, output side] with its damping, at torsion u [rad], rate [rad/s] and states z."""
    torque = torque_of(system.law, u, du, z)
    if not lacking(system, "B"):
        return torque + system.B * du
    return system.variation.value(phase) * torque + system.damping.value(phase, du) * du


def heat(system: Any, phase: Any, u: Any, du: Any, z: Any = ()) -> Any:
    """Power [W] that damping, friction and memory turn into heat."""
    damping = system.damping.value(phase, du) if lacking(system, "B") else system.B
    return damping * du * du + sum(losses_of(system.law, u, du, z), 0.0)


def settling_time(system: Any) -> float:
    """Time [s] to wait for the transient; without damping it never goes, so a number of periods serves."""
    mu = damping_of(system) / system.J
    return SETTLE / mu if mu > 0.0 else UNDAMPED_PERIODS * 2.0 * math.pi / float(system.omega)
