"""Random drives that averaging takes without a frequency at rest or with stiffness that varies; own integration."""

import math

import numpy as np
from scipy.integrate import solve_ivp

import strainwave as sw


def with_gap(rng):
    """A random drive with a gap and no mean torque, at a random speed and force."""
    K, J, gap = 10 ** rng.uniform(-1.0, 4.0), 10 ** rng.uniform(-2.0, 1.0), 10 ** rng.uniform(-4.0, 0.0)
    zeta, share = 10 ** rng.uniform(-2.0, -1.0), rng.uniform(0.3, 1.2)
    force = sw.Harmonic(K * gap * 10 ** rng.uniform(-1.0, 0.5), 1, rng.uniform(-3.0, 3.0))
    return sw.Oscillator(J, 2.0 * zeta * math.sqrt(K * J), sw.Backlash(K, gap), force, share * math.sqrt(K / J))


def with_varying(rng):
    """A random drive whose stiffness and damping vary, and its resonance: the tongue alone, or forced inside it."""
    K, J, forced = 10 ** rng.uniform(-1.0, 4.0), 10 ** rng.uniform(-2.0, 1.0), rng.random() < 0.5
    omega_0, zeta, n = math.sqrt(K / J), 10 ** rng.uniform(-2.5, -1.8), int(rng.integers(1, 4))
    k = zeta * rng.uniform(6.0, 12.0)
    n = 2 if forced else n
    law = (
        sw.Cubic(K, rng.uniform(0.02, 0.5))
        if rng.random() < 0.7
        else sw.PiecewiseLinear(K, 1.3 * K, 1.6 * K, 0.3 * K, K)
    )
    stiffness = sw.gears.Variation((sw.gears.Ripple(n, k, rng.uniform(0.0, 6.0)), sw.gears.Ripple(n + 1, 0.3 * k)))
    beside = sw.gears.Variation((sw.gears.Ripple(n, 0.3, rng.uniform(0.0, 6.0)),))
    damping = sw.gears.GearDamping(2.0 * zeta * math.sqrt(K * J), beside, fast=rng.uniform(0.5, 1.0), v_fast=omega_0)
    line = sw.Harmonic(K * rng.uniform(0.5, 2.0) * k * forced, 1, rng.uniform(0.0, 6.0))
    omega = 2.0 * omega_0 / n * (1.0 + k * rng.uniform(-0.15, 0.5))
    system = sw.gears.VaryingOscillator(J, damping, law, line, omega, variation=stiffness)
    return system, sw.Resonance(n, 2)


def integrated(flow, z, damping):
    """Amplitude [rad] on the fast angle on which an integration from the motion of the state z settles."""
    system, q = flow.system, flow.resonance.q
    period = 2.0 * math.pi * q / system.omega
    x, after = flow.steady_x(z, np.array([0.0, 1e-6 * period]))
    t = period * (math.ceil(24.0 * system.J / damping / period) + np.arange(512) / 512)

    def rates(t, y):
        return system.rhs(system.omega * t, y)

    y0, tolerance = (x, (after - x) / (1e-6 * period)), 1e-10 * abs(z)
    found = solve_ivp(rates, (0.0, t[-1]), y0, "DOP853", t, rtol=1e-9, atol=tolerance, max_step=period / q / 40)
    return 2.0 * abs(np.mean(found.y[0] * np.exp(-2j * np.pi * flow.resonance.p * np.arange(512) / 512)))
