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
