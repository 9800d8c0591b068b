"""Torque, losses and damping of the gear of an error equation, with any law and varying."""

import math
from typing import Any

import numpy as np

from ...base.law import depends, losses_of, torque_of
from ...base.protocols import lacking
from ...base.quantities import States
from ...base.results import Floats

SETTLING_TIME = 8.0  # in units of 1/mu: the transient falls to exp(-4) before the orbit is closed
UNDAMPED_PERIODS = 50
ANGLES = 2.0 * np.pi * np.arange(256) / 256


def damping_of(system: Any) -> float:
    """Damping [N*m*s/rad] across the gear of small motions, the mean over a turn; without friction in the law."""
    if not lacking(system, "B"):
        return float(system.B)
    return float(np.mean(np.broadcast_to(system.damping.value(ANGLES, 0.0), ANGLES.shape)))


UNDAMPED = (
    "the damping is 0: no vibration decays, a steady motion is neither stable nor unstable, and no resonance has a "
    "finite peak; give a damping, a damping ratio or a quality factor"
)


def loses_energy(system: Any) -> bool:
    """True if motions lose energy: by damping, or in a law with friction or memory."""
    return damping_of(system) > 0.0 or depends(system.law) > 1


def no_multiple_scales(system: Any) -> str:
    """Reason for which multiple scales does not describe a system, as a sentence; empty where it can."""
    if depends(system.law) > 1:
        return "first-order multiple scales requires a spring, but this torsion law has friction or hysteresis"
    if lacking(system, "B"):
        return "first-order multiple scales describes a constant stiffness and damping, and these vary"
    return ""


def gear_torque(system: Any, phase: Floats, u: Floats, du: Floats, z: States = ()) -> Any:
    """Torque through the gear [N*m, output side] with its damping, at torsion u [rad], rate [rad/s] and states z."""
    torque = torque_of(system.law, u, du, z)
    if not lacking(system, "B"):
        return torque + system.B * du
    return system.variation.value(phase) * torque + system.damping.value(phase, du) * du


def heat(system: Any, phase: Floats, u: Floats, du: Floats, z: States = ()) -> Any:
    """Power [W] that damping, friction and memory turn into heat."""
    damping = system.damping.value(phase, du) if lacking(system, "B") else system.B
    return damping * du * du + sum(losses_of(system.law, u, du, z), 0.0)


def settling_time(system: Any) -> float:
    """Time [s] to wait for the transient; without damping it never goes, so a number of periods serves."""
    mu = damping_of(system) / system.J
    return SETTLING_TIME / mu if mu > 0.0 else UNDAMPED_PERIODS * 2.0 * math.pi / float(system.omega)
