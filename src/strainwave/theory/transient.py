"""Transients of the slow flow: from a physical start to x(t)."""

import math
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline

from ..results import Floats, SolveError
from .averaging import AveragedFlow, Sampled
from .fixed_points import Flow
from .slow_results import Evolution

SAMPLES = 32  # per period of the fastest component, where the caller names only the end


def evolve(flow: Flow, y0: tuple[float, float], t: Floats) -> Evolution:
    """Integrate the slow flow from the state that y0 = (x, x') at t[0] means, and put x(t) together again.

    With u = u0 + Re(z E) + F the start asks Re(z E) = x - e - u0 - F and Re((i Omega z + z') E) = x' - omega (e' + F'),
    so x and its derivative leave from y0 exactly (z' is of first order: without it the start would be off by
    mu/omega_0).
    """
    s = flow.setting
    e, theta = s.system.error, s.omega * float(t[0])
    x = y0[0] - float(e.value(theta)) - s.u0 - float(s.forced(theta))
    v = y0[1] - s.omega * (float(e.slope(theta)) + float(s.forced_slope(theta)))
    z0 = _start(flow, x, v, complex(np.exp(1j * s.fast * float(t[0]))))
    fast, angles = np.exp(1j * s.fast * t), s.omega * t
    if len(t) == 1:
        z = np.array([z0])
        rate = flow.rates(z)
    else:
        z, rate = _decay(flow, z0, t) if s.resonance.ratio is None else _integrate(flow, z0, t)
    x_of_t = s.u0 + (z * fast).real + s.forced(angles) + e.value(angles)
    v_of_t = ((rate + 1j * s.fast * z) * fast).real + s.omega * (s.forced_slope(angles) + e.slope(angles))
    return Evolution(t, np.abs(z), -np.unwrap(np.angle(z)), x_of_t, v_of_t)


def _start(flow: Flow, x: float, v: float, turn: complex) -> complex:
    """Initial z with Re(z E) = x and Re((i Omega z + z') E) = v, by Newton in Im(z E) from its leading value."""
    fast = flow.setting.fast
    leading = part = -v / fast
    for _ in range(20):
        z = complex(x, part) / turn
        miss = (complex(flow.rates(z)) * turn).real - fast * part - v
        direction = 1j / turn
        by_part = flow.jacobian(z) @ np.array([direction.real, direction.imag])
        slope = (complex(by_part[0], by_part[1]) * turn).real - fast
        if not (math.isfinite(miss) and slope < -0.1 * fast):
            return complex(x, leading) / turn  # too far from small amplitudes for the first-order correction
        part -= miss / slope
        if abs(miss) <= 1e-14 * fast * (abs(x) + abs(part)):
            break
    return complex(x, part) / turn


def _decay(flow: Flow, z0: complex, t: Floats) -> tuple[Any, Any]:
    """Without resonance a = a0 exp(-mu t/2) and the phase rate depends on a alone: a quadrature over time."""
    mu, a0 = flow.setting.mu, abs(z0)
    if a0 == 0.0:
        return np.zeros(len(t), complex), np.zeros(len(t), complex)
    nodes = np.linspace(t[0], t[-1], 257 if flow.error > 0.0 else 1025)
    a = a0 * np.exp(-0.5 * mu * (nodes - t[0]))
    shift = CubicSpline(nodes, _batched(flow, a.astype(complex)).imag / a)
    z = z0 * np.exp(-0.5 * mu * (t - t[0]) + 1j * shift.antiderivative()(t))
    return z, (-0.5 * mu + 1j * shift(t)) * z


def _integrate(flow: Flow, z0: complex, t: Floats) -> tuple[Any, Any]:
    def rates(_: float, y: Floats) -> Floats:
        rate = complex(flow.rates(complex(y[0], y[1])))
        return np.array([rate.real, rate.imag])

    # a tolerance below the error of the averages would only follow their kinks
    rtol = max(1e-10, 10.0 * flow.error)
    size = max(abs(z0), max(flow.setting.scales()) * 1e-3)
    solution = solve_ivp(rates, (t[0], t[-1]), [z0.real, z0.imag], "DOP853", t, rtol=rtol, atol=0.01 * rtol * size)
    if not solution.success or not np.all(np.isfinite(solution.y)):
        raise SolveError(
            f"the slow flow from a = {abs(z0):.6g} rad could not be followed to t = {t[-1]:.6g} s; {solution.message} "
            "start closer to equilibrium, or check the signs of damping and stiffness"
        )
    z = solution.y[0] + 1j * solution.y[1]
    return z, _batched(flow, z)


def _batched(flow: Flow, z: Any) -> Any:
    """Rates at many points, in pieces that fit the memory whatever the number of quadrature points."""
    points = flow.means.rest.size if isinstance(flow, AveragedFlow) and isinstance(flow.means, Sampled) else 64
    pieces = math.ceil(len(z) * points / 500_000)
    return np.concatenate([flow.rates(part) for part in np.array_split(z, pieces)])


def times(flow: Flow, t: Any) -> Floats:
    """Check the times; an end time alone becomes samples from 0 that resolve the fastest component.

    Raises
    ------
    ValueError
        If the times are not finite or do not increase.
    """
    asked = np.atleast_1d(np.asarray(t, float))
    if asked.ndim != 1 or asked.size == 0 or not np.all(np.isfinite(asked)) or not np.all(np.diff(asked) > 0.0):
        raise ValueError(f"t must be an end time or finite increasing times [s], not {t!r}")
    if asked.size > 1:
        return asked
    if asked[0] <= 0.0:
        raise ValueError(f"the end time is {asked[0]:.6g} s; it must be positive")
    s = flow.setting
    fastest = max(s.fast, s.omega * max(s.orders, default=1))
    return np.linspace(0.0, float(asked[0]), 2 + math.ceil(SAMPLES * float(asked[0]) * fastest / (2.0 * np.pi)))
