"""Formulas as the article prints them, beside those that follow from its equations of motion.

The numbers E1 to E11 are those of the errata list of the documentation.
"""

import math

import numpy as np

from ..base.results import Floats
from ..base.series import largest_of_samples
from ..model.oscillator import Oscillator
from .resonance import SUBHARMONIC, Resonance
from .slow_flow.flow import SlowFlow, slow_flow

SAMPLES = 512  # of a turn of the fastest component

FORMS = (  # place, what, as printed, correct, number of the erratum
    ("error equation", "F(t)", "(T_m J_l − T_l J_m)/(N J_m J_l)", "T_m/(N J_m) − T_l/J_l", "E1"),
    ("cases 1 to 4", "ω₀a², ω₀C², ω₀C³", "without α", "each with α", "E2"),
    ("case 1", "β′", "3/8 ω₀a² + 3/4 ω₀C²", "αω₀(3/8 a² + 3/4 C²)", "E3"),
    ("case 1", "x(t)", "a₀ exp(−μt/2) cos(ω₀t + β₀) + C cos ωt", "β₀ + ∫β′dt in place of β₀", "E10"),
    ("case 2", "response", "μ²/4 + (σ − 3/8 ω₀C²)² = f²/(4ω₀²C²)", "α before ω₀, a for C; f = A", "E4"),
    ("case 2", "x(t)", "a cos(ω₀t − φ)", "a cos(ωt − φ)", "E9"),
    ("case 3", "response", "right side (ω₀C³/8)²", "right side (αω₀C³/8)²", "E5"),
    ("case 4", "response", "(σ − 9/8 ω₀C² − 9/4 ω₀²a²)²", "(σ − 9/4 αω₀C² − 9/8 αω₀a²)²", "E6"),
    ("stability", "global", "for α > 0", "for α ≥ 0; for α < 0 inside the saddles ±1/√|α|", "E7"),
    ("stability", "stable focus", "always", "for μ < 2ω₀, a node beyond", "E11"),
    ("Table 1", "f(x) = x + αx³", "dimensionless", "rad", "E11"),
)


def without_alpha(system: Oscillator) -> Oscillator:
    """The system whose slow flow is the one that the article prints in cases 1 to 3, cubic terms without alpha (E2)."""
    return system._replace(law=system.law._replace(alpha=1.0))


def _numbers(system: Oscillator) -> tuple[float, float, float]:
    """The article's omega_0 [rad/s], mu [1/s] and C [rad]."""
    omega_0, mu = math.sqrt(system.law.K / system.J), system.B / system.J
    return omega_0, mu, system.excitation.amplitude / system.J / (omega_0**2 - system.omega**2)


def printed_x(system: Oscillator, t: Floats) -> Floats:
    """Motion x(t) [rad] from rest, case 1 as printed: a0 exp(-mu t/2) cos(omega_0 t + beta_0) + C cos(omega t)."""
    omega_0, mu, C = _numbers(system)
    z = complex(-C, 0.5 * mu * C / omega_0)  # a0 exp(i beta_0), by x = x' = 0 at time 0
    free = (z * np.exp((-0.5 * mu + 1j * omega_0) * t)).real
    return np.asarray(free + C * np.cos(system.omega * t))


def printed_steady(system: Oscillator, resonance: Resonance) -> tuple[float | None, float | None]:
    """Steady a [rad] by the printed response equation, and the largest |x| [rad]; None where it gives none.

    Case 4 (E6): 9/4 mu^2 + (sigma - 9/8 omega_0 C^2 - 9/4 omega_0^2 a^2)^2 = (9/8 omega_0 C a)^2. The phase between its
    components is not printed.
    """
    if resonance != SUBHARMONIC:
        return steady(slow_flow(without_alpha(system), resonance))
    omega_0, mu, C = _numbers(system)
    shifted, slope = system.omega - 3.0 * omega_0 - 1.125 * omega_0 * C**2, 2.25 * omega_0**2
    linear = 2.0 * shifted * slope + (1.125 * omega_0 * C) ** 2
    squares = np.roots([slope**2, -linear, shifted**2 + 2.25 * mu**2])
    sizes = [math.sqrt(square.real) for square in squares if square.imag == 0.0 < square.real]
    return (max(sizes), None) if sizes else (None, abs(C))


def steady(flow: SlowFlow) -> tuple[float, float]:
    """Largest steady a [rad] of a slow flow, and the largest |x| [rad] of its motion."""
    state, (p, q) = flow.steady_states()[0], flow.resonance
    turn = 2.0 * math.pi * max(q, 1) / flow.system.omega
    return state.amplitude, largest(flow.steady_x(state.z, np.linspace(0.0, turn, SAMPLES * max(p, q, 1), False)))


def largest(x: Floats) -> float:
    """Largest |x| of equidistant samples, at a crest between them."""
    return float(largest_of_samples(x[None])[0])
