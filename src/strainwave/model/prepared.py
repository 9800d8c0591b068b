"""The forms of models that run many steps: what a step would compute again and again is computed once.

`prepared(model)` asks a model for its own (`model.prepared()`), which must behave like the model; its numbers may be
arrays, one value for each member of an ensemble. A model without one is its own. The inertia goes into the torques
(`law.scaled(1/J)`), divisions become multiplications, a phase that may differ between members leaves the cosine,
breakpoints are found beforehand.
"""

from typing import Any, NamedTuple

import numpy as np

from ..law import torque_of, z_rate_of
from ..maths import cos, sign, sin


def prepared(model: Any) -> Any:
    """Prepared form of a model, or the model itself where it defines none."""
    return model.prepared() if hasattr(model, "prepared") else model


def scaled_law(law: Any, factor: Any) -> Any:
    """Law whose torque is that of another times a factor, in its form for many steps."""
    return law.scaled(factor) if hasattr(law, "scaled") else Geared(prepared(law), factor)


def scaled_torque(excitation: Any, factor: Any) -> Any:
    """Excitation times a factor, in its form for many steps."""
    return excitation.scaled(factor) if hasattr(excitation, "scaled") else Driven(prepared(excitation), factor)


class Geared(NamedTuple):
    """Law of any kind whose torque is multiplied by a factor."""

    law: Any
    factor: Any

    def torque(self, x: Any, v: Any, z: Any) -> Any:
        """Torque at torsion x [rad], its rate v [rad/s] and the law's states z."""
        return self.factor * torque_of(self.law, x, v, z)

    def z_rate(self, x: Any, v: Any, z: Any) -> Any:
        """Rates of the law's states."""
        return z_rate_of(self.law, x, v, z)


class Driven(NamedTuple):
    """Excitation of any kind, multiplied by a factor."""

    excitation: Any
    factor: Any

    def torque(self, angle: Any) -> Any:
        """Torque at the base angle [rad]."""
        return self.factor * self.excitation.torque(angle)


class Cosine(NamedTuple):
    """Torque amplitude cos(order angle)."""

    amplitude: Any
    order: int

    def torque(self, angle: Any) -> Any:
        """Torque [N*m] at the base angle [rad]."""
        return self.amplitude * cos(self.order * angle)


class Wave(NamedTuple):
    """Periodic function mean + cosine cos(order angle) + sine sin(order angle), as torque or as kinematic error."""

    mean: Any
    cosine: Any
    sine: Any
    order: int

    def torque(self, angle: Any) -> Any:
        """Value at the base angle [rad]."""
        a = self.order * angle
        return self.mean + self.cosine * cos(a) + self.sine * sin(a)

    def value(self, angle: Any) -> Any:
        """Value at the base angle [rad]."""
        return self.torque(angle)

    def slope(self, angle: Any) -> Any:
        """Derivative with respect to the base angle."""
        a = self.order * angle
        return self.order * (self.sine * cos(a) - self.cosine * sin(a))


class Waves(NamedTuple):
    """Sum of waves of one mean."""

    waves: tuple[Any, ...]

    def torque(self, angle: Any) -> Any:
        """Value at the base angle [rad]."""
        total = self.waves[0].torque(angle)
        for i in range(1, len(self.waves)):
            total = total + self.waves[i].torque(angle)
        return total

    def value(self, angle: Any) -> Any:
        """Value at the base angle [rad]."""
        return self.torque(angle)

    def slope(self, angle: Any) -> Any:
        """Derivative with respect to the base angle."""
        total = self.waves[0].slope(angle)
        for i in range(1, len(self.waves)):
            total = total + self.waves[i].slope(angle)
        return total


def wave(amplitude: Any, order: int, phase: Any, mean: Any = 0.0) -> Any:
    """Wave mean + amplitude cos(order angle + phase), in its shortest form."""
    if np.all(np.asarray(phase) == 0.0) and np.all(np.asarray(mean) == 0.0):
        return Cosine(amplitude, order)
    return full_wave(amplitude, order, phase, mean)


def full_wave(amplitude: Any, order: int, phase: Any, mean: Any = 0.0) -> Wave:
    """Wave mean + amplitude cos(order angle + phase)."""
    return Wave(mean, amplitude * np.cos(phase), -amplitude * np.sin(phase), order)


class LinearAndCubic(NamedTuple):
    """Odd law linear x + cubic x^3: `Cubic` with its coefficients multiplied out."""

    linear: Any
    cubic: Any

    def torque(self, x: Any) -> Any:
        """Torque T(x) [N*m] at torsion x [rad]."""
        return x * (self.linear + self.cubic * (x * x))


class Slopes(NamedTuple):
    """Odd law of three slopes with breakpoints x1 < x2: `PiecewiseLinear` without its divisions."""

    K3: Any
    inner: Any
    outer: Any
    x1: Any
    x2: Any

    def torque(self, x: Any) -> Any:
        """Torque T(x) [N*m] at torsion x [rad]."""
        inner = self.inner * (abs(x + self.x1) - abs(x - self.x1))
        return self.K3 * x + inner + self.outer * (abs(x + self.x2) - abs(x - self.x2))


class Yielding(NamedTuple):
    """`BoucWen` without divisions; its exponent is the length of a tuple, which the compiler knows."""

    elastic: Any
    plastic: Any
    A: Any
    per_yield: Any
    beta: Any
    gamma: Any
    exponent: tuple[int, ...]

    def states(self) -> int:
        """Number of internal states."""
        return 1

    def torque(self, x: Any, v: Any, z: Any) -> Any:
        """Torque [N*m] at torsion x [rad], its rate v [rad/s] and z = (z,) [rad]."""
        return self.elastic * x + self.plastic * z[0]

    def z_rate(self, x: Any, v: Any, z: Any) -> Any:
        """Rate (z',) [rad/s] of the internal state."""
        size = abs(z[0] * self.per_yield)
        level = size
        for _ in range(len(self.exponent) - 1):
            level = level * size
        return (self.A * v - level * (self.beta * abs(v) * sign(z[0]) + self.gamma * v),)


class FreeOfError(NamedTuple):
    """Oscillator whose gear has no kinematic error; its torques are divided by the inertia."""

    B: Any
    law: Any
    excitation: Any
    omega: Any

    def rhs(self, phase: Any, y: Any) -> Any:
        """Time derivatives of the state y at the base phase [rad]."""
        x, v, z = y[0], y[1], y[2:]
        torque = torque_of(self.law, x, v, z)
        return (v, self.excitation.torque(phase) - self.B * v - torque, *z_rate_of(self.law, x, v, z))


class WithError(NamedTuple):
    """Oscillator whose gear has a kinematic error; its torques are divided by the inertia."""

    B: Any
    law: Any
    excitation: Any
    omega: Any
    error: Any

    def rhs(self, phase: Any, y: Any) -> Any:
        """Time derivatives of the state y at the base phase [rad]."""
        v, z = y[1], y[2:]
        u = y[0] - self.error.value(phase)
        du = v - self.omega * self.error.slope(phase)
        torque = torque_of(self.law, u, du, z)
        return (v, self.excitation.torque(phase) - self.B * du - torque, *z_rate_of(self.law, u, du, z))
