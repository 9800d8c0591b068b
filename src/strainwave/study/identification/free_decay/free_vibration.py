"""A free decay computed by averaging: the undamped vibration of every amplitude, and how fast the damping leads down.

The undamped vibration between its extremes x- and x+ takes dt = dx/sqrt(2 (V(x+) - V(x))/J); with x = m + h cos(theta)
the integrand is smooth and periodic, so that the midpoint rule converges as a Fourier series does. The damping turns
D = <v (B v + T(x, v))> into heat, and the energy V(x+) falls by it: d x+/dt = -D/V'(x+).

Krack & Gross 2019, Harmonic Balance for Nonlinear Vibration Problems, sec. 4.1 (undamped vibration); Nayfeh & Mook
1979, Nonlinear Oscillations, sec. 3.3 (slow change of the amplitude by small damping).
"""

from typing import Any, NamedTuple

import numpy as np
from scipy.interpolate import CubicHermiteSpline, CubicSpline

from ....law import energy_of, torque_of
from ....results import Floats

ANGLES = 96  # of theta in half a vibration
SIZES = 40  # amplitudes of the table
HARMONICS = 9
NODES = 400  # of the decay in time
NEWTON = 30  # steps to the other extreme
SLOWEST = 1e-7  # decay rate and frequency at least, over the undamped frequency


class Vibrations(NamedTuple):
    """Undamped vibrations (n,) by their upper extreme.

    Attributes
    ----------
    extreme : (n,) array
        Upper extreme x+ [rad].
    omega : (n,) array
        Angular frequency [rad/s].
    rate : (n,) array
        -(d x+/dt)/x+ [1/s] by the damping.
    coefficients : (H+1, n) array
        Cosine coefficients of x: mean, first harmonic, ...
    """

    extreme: Floats
    omega: Floats
    rate: Floats
    coefficients: Floats


def vibrations(system: Any, extreme: Floats) -> Vibrations:
    """Undamped vibrations about rest, and what the damping does to them.

    Raises
    ------
    ValueError
        If the law has no potential to vibrate in.
    """
    law, J = system.law, system.J
    top = energy_of(law, extreme, ()) + 0.0 * extreme
    low = _other_extreme(law, extreme, top)
    middle, half = 0.5 * (extreme + low), 0.5 * (extreme - low)
    theta = np.pi * (np.arange(ANGLES) + 0.5)[:, None] / ANGLES
    x = middle + half * np.cos(theta)
    depth = top - energy_of(law, x, ())
    if not np.all(depth > 0.0):
        raise ValueError(f"{type(law).__name__} does not hold a vibration of {np.max(extreme):.4g} rad: it pushes away")
    pace = half * np.sin(theta) / np.sqrt(2.0 * depth / J)  # dt/dtheta
    quarter = np.fft.rfft(np.concatenate([pace, pace[::-1]]), axis=0) / (2 * ANGLES)
    k = np.arange(1, ANGLES)[:, None]
    waves = 2.0 * np.real(quarter[1:ANGLES] * np.exp(-0.5j * np.pi * k / ANGLES))
    slow = np.real(quarter[:1])
    t = slow * theta + np.einsum("ik,kj->ij", np.sin(theta * k.T), waves / k)
    omega = 1.0 / slow[0]
    weights = pace * (omega / ANGLES)  # mean over half a vibration
    order = np.arange(HARMONICS + 1)
    both = np.cos(order[:, None, None] * (omega * t))
    coefficients = np.einsum("kij,ij->kj", both, x * weights) * np.where(order == 0, 1.0, 2.0)[:, None]
    v = half * np.sin(theta) / pace
    friction = torque_of(law, x, v, ()) - torque_of(law, x, -v, ())
    heat = np.sum(weights * v * (system.B * v + 0.5 * friction), axis=0)
    pull = torque_of(law, extreme, 0.0, ())
    return Vibrations(extreme, omega, heat / (pull * extreme), coefficients)


def _other_extreme(law: Any, extreme: Floats, top: Floats) -> Floats:
    """Lower extremes (n,) at which the energy is that of the upper ones."""
    low = -extreme
    for _ in range(NEWTON):
        slope = torque_of(law, low, 0.0, ())
        step = np.divide(energy_of(law, low, ()) - top, slope, out=np.zeros_like(low), where=slope != 0.0)
        low = low - step
        if np.all(np.abs(step) <= 1e-13 * np.abs(low)):
            break
    return low


class Extended(NamedTuple):
    """A law with terms that it may lack: drag drag |v| v, dry friction dry sign v, and cubic x^3."""

    law: Any
    drag: float = 0.0
    dry: float = 0.0
    cubic: float = 0.0

    def torque(self, x: Any, v: Any) -> Any:
        """Torque [N*m] at torsion x [rad] and its rate v [rad/s]."""
        own = torque_of(self.law, x, v, ())
        return own + self.drag * abs(v) * v + self.dry * np.sign(v) + self.cubic * x * x * x

    def energy(self, x: Any) -> Any:
        """Energy stored [J] at torsion x [rad]."""
        return energy_of(self.law, x, ()) + 0.25 * self.cubic * x**4


class Decay(NamedTuple):
    """A decay in time: splines over the logarithm of the extreme, and that logarithm and the phase over time."""

    size: Any
    phase: Any
    shape: Any

    def motion(self, t: Floats) -> Floats:
        """Motion [rad] at times [s] from the start on."""
        c, phase = self.shape(self.size(t)), self.phase(t)
        wave, total = np.exp(1j * phase), c[:, 0].copy()
        power = np.ones(len(t), complex)
        for k in range(1, c.shape[1]):
            power *= wave
            total += c[:, k] * power.real
        return np.asarray(total)


def decay(system: Any, start: float, phase: float, least: float) -> Decay:
    """Free decay from an upper extreme [rad] and a phase [rad] at t = 0.

    Parameters
    ----------
    system : Oscillator
        Its excitation and error are left out.
    start, phase : float
        Extreme and phase of the vibration at t = 0.
    least : float
        Smallest extreme that is reached.
    """
    table = vibrations(system, np.geomspace(min(least, 0.9 * start), start, SIZES))
    at = np.log(table.extreme)
    rate = np.maximum(table.rate, SLOWEST * table.omega)
    # With z'' + 2 rate z' + omega^2 z = 0 the frequency is sqrt(omega^2 - rate^2 - d rate/dt).
    less = rate * (rate - CubicSpline(at, rate).derivative()(at))
    omega = np.sqrt(np.maximum(table.omega**2 - less, (SLOWEST * table.omega) ** 2))
    nodes = np.linspace(at[-1], at[0], NODES)
    elapsed, turned = (CubicSpline(at, integrand).antiderivative() for integrand in (1.0 / rate, omega / rate))
    time, swing = elapsed(at[-1]) - elapsed(nodes), phase + turned(at[-1]) - turned(nodes)
    size = CubicHermiteSpline(time, nodes, -CubicSpline(at, rate)(nodes))
    angle = CubicHermiteSpline(time, swing, CubicSpline(at, omega)(nodes))
    return Decay(size, angle, CubicSpline(at, table.coefficients.T))
