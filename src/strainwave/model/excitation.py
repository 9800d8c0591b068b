"""Excitations of the error: periodic torques and the kinematic error of the gear, as functions of the base angle.

The base angle is the wave-generator angle (or the forcing phase); a line of integer order k repeats k times per turn of
it. Amplitudes are 0-to-peak.

`scaled(factor)` is the same function times a factor in the form that runs many steps: a phase, which may differ between
the members of an ensemble, leaves the cosine.
"""

from typing import Any, NamedTuple

import numpy as np

from ..base.protocols import Excitation, scaled
from ..base.quantities import Angle, Order, Reals, Torque, number
from ..compile.maths import cos, sin

HIGHEST = 10_000  # order: a wave generator's turn has some hundreds of teeth


def _refuse_high(name: str, order: float) -> None:
    if order > HIGHEST:
        raise ValueError(f"{name}.order is {order}; it must be at most {HIGHEST}")


class Harmonic(NamedTuple):
    """Torque mean + amplitude cos(order * angle + phase)."""

    amplitude: Torque
    order: int = 1
    phase: Angle = 0.0
    mean: Torque = 0.0

    def torque(self, angle: Reals) -> Any:
        """Torque [N*m] at the base angle [rad]."""
        return self.mean + self.amplitude * cos(self.order * angle + self.phase)

    def orders(self) -> tuple[int, ...]:
        """The order of the line."""
        return (self.order,)

    def scaled(self, factor: Reals) -> Any:
        """The same torque times a factor, with the phase in two amplitudes."""
        return wave(self.amplitude * factor, self.order, self.phase, self.mean * factor)

    def check(self) -> None:
        """Refuse an order below 1 (ValueError)."""
        if self.order < 1:
            raise ValueError(f"Harmonic.order is {self.order}; it must be at least 1 (a constant torque is the mean)")
        _refuse_high("Harmonic", self.order)


class Harmonics(NamedTuple):
    """Sum of several `Harmonic` torques (at least one)."""

    terms: tuple[Harmonic, ...]

    def torque(self, angle: Any) -> Any:
        """Torque [N*m] at the base angle [rad]."""
        total = 0.0 * angle
        for i in range(len(self.terms)):
            total = total + self.terms[i].torque(angle)
        return total

    def orders(self) -> tuple[int, ...]:
        """The orders of all terms."""
        return tuple(term.order for term in self.terms)

    def scaled(self, factor: Reals) -> Any:
        """The same torque times a factor, with every phase in two amplitudes."""
        return Waves(tuple(full_wave(t.amplitude * factor, t.order, t.phase, t.mean * factor) for t in self.terms))


def shortest(torque: Any) -> Any:
    """Return a torque in its shortest form, no torque for None, one term alone: drives that compile alike."""
    if torque is None:
        return Harmonic(0.0)
    return torque.terms[0] if isinstance(torque, Harmonics) and len(torque.terms) == 1 else torque


def as_harmonics(torque: Any) -> "Harmonics | None":
    """Return a torque with its terms, no torque as None: of what `shortest` returns what it was given."""
    if isinstance(torque, Harmonics):
        return torque
    return None if torque == Harmonic(0.0) else Harmonics((torque,))


def with_mean(torque: Harmonics | None, mean: float) -> Harmonics | None:
    """A torque with another mean [N*m], in its first line as of a file; None where neither mean nor lines are left."""
    mean = number("torque [N*m]", mean)
    first, *others = torque.terms if torque else (Harmonic(0.0),)
    if not (mean or first.amplitude or others):
        return None
    return Harmonics((first._replace(mean=mean), *(term._replace(mean=0.0) for term in others)))


def wave(amplitude: Reals, order: int, phase: Reals, mean: Reals = 0.0) -> Any:
    """Wave mean + amplitude cos(order angle + phase), in its shortest form."""
    if np.all(np.asarray(phase) == 0.0) and np.all(np.asarray(mean) == 0.0):
        return Cosine(amplitude, order)
    return full_wave(amplitude, order, phase, mean)


def full_wave(amplitude: Reals, order: int, phase: Reals, mean: Reals = 0.0) -> "Wave":
    """Wave mean + amplitude cos(order angle + phase)."""
    return Wave(mean, amplitude * np.cos(phase), -amplitude * np.sin(phase), order)


class Cosine(NamedTuple):
    """Torque amplitude cos(order angle)."""

    amplitude: Any
    order: int

    def torque(self, angle: Reals) -> Any:
        """Torque [N*m] at the base angle [rad]."""
        return self.amplitude * cos(self.order * angle)


class Wave(NamedTuple):
    """Periodic function mean + cosine cos(order angle) + sine sin(order angle), as torque or as kinematic error."""

    mean: Any
    cosine: Any
    sine: Any
    order: int

    def torque(self, angle: Reals) -> Any:
        """Value at the base angle [rad]."""
        a = self.order * angle
        return self.mean + self.cosine * cos(a) + self.sine * sin(a)

    def value(self, angle: Any) -> Any:
        """Value at the base angle [rad]."""
        return self.torque(angle)

    def slope(self, angle: Reals) -> Any:
        """Derivative with respect to the base angle."""
        a = self.order * angle
        return self.order * (self.sine * cos(a) - self.cosine * sin(a))


class Waves(NamedTuple):
    """Sum of waves of one mean."""

    waves: tuple[Any, ...]

    def torque(self, angle: Reals) -> Any:
        """Value at the base angle [rad]."""
        total = self.waves[0].torque(angle)
        for i in range(1, len(self.waves)):
            total = total + self.waves[i].torque(angle)
        return total

    def value(self, angle: Reals) -> Any:
        """Value at the base angle [rad]."""
        return self.torque(angle)

    def slope(self, angle: Reals) -> Any:
        """Derivative with respect to the base angle."""
        total = self.waves[0].slope(angle)
        for i in range(1, len(self.waves)):
            total = total + self.waves[i].slope(angle)
        return total


def scaled_torque(excitation: Excitation, factor: Reals) -> Any:
    """Excitation times a factor, in its form for many steps."""
    return scaled(excitation, factor, Driven)


def mean_torque(excitation: Excitation | None) -> float:
    """Mean over a turn of the base angle [N*m]; 0 of none."""
    match excitation:
        case None:
            return 0.0
        case Harmonic(mean=mean):
            return float(mean)
        case Harmonics(terms=terms):
            return sum(mean_torque(term) for term in terms)
        case _:
            angles = np.linspace(0.0, 2.0 * np.pi, 1024, endpoint=False)
            return float(np.mean([excitation.torque(float(angle)) for angle in angles]))


class Driven(NamedTuple):
    """Excitation of any kind, multiplied by a factor."""

    excitation: Any
    factor: Any

    def torque(self, angle: Any) -> Any:
        """Torque at the base angle [rad]."""
        return self.factor * self.excitation.torque(angle)


class Line(NamedTuple):
    """One line of a kinematic-error spectrum: amplitude cos(order * angle + phase), output side.

    A line of the output's turn, or of both turns, has an order that is not whole: j + k/N repeats j times per turn of
    the wave generator and k times per turn of the output, counted along the output's motion: an oval spline that turns
    with it has 2 + 2/N with the circular spline fixed, whose output runs against the motor, and 2 - 2/N with the
    flexspline fixed and the ratio N + 1 in place of N.
    """

    order: Order
    amplitude: Angle
    phase: Angle = 0.0

    def check(self) -> None:
        """Refuse an order that is not above 0 (ValueError)."""
        if not self.order > 0:
            raise ValueError(f"Line.order is {self.order}; it must be above 0 (a constant error has no effect)")
        _refuse_high("Line", self.order)


class KinematicError(NamedTuple):
    """Kinematic error e = sum of lines A_k cos(k angle + phi_k): the rigid gear gives theta_l = theta_m/N - e.

    At least one line; a gear without kinematic error has `NoError()`.
    """

    lines: tuple[Line, ...]

    def value(self, angle: Reals) -> Any:
        """Error e [rad] at the base angle [rad]."""
        total = 0.0 * angle
        for i in range(len(self.lines)):
            line = self.lines[i]
            total = total + line.amplitude * cos(line.order * angle + line.phase)
        return total

    def slope(self, angle: Reals) -> Any:
        """Derivative de/dangle [rad/rad] at the base angle [rad]."""
        total = 0.0 * angle
        for i in range(len(self.lines)):
            line = self.lines[i]
            total = total - line.amplitude * line.order * sin(line.order * angle + line.phase)
        return total

    def curvature(self, angle: Reals) -> Any:
        """Second derivative of e [rad/rad^2] at the base angle [rad]."""
        total = 0.0 * angle
        for i in range(len(self.lines)):
            line = self.lines[i]
            total = total - line.amplitude * line.order * line.order * cos(line.order * angle + line.phase)
        return total

    def orders(self) -> tuple[float, ...]:
        """The orders of all lines."""
        return tuple(line.order for line in self.lines)

    def scaled(self, factor: Reals) -> Any:
        """The same error times a factor, with every phase in two amplitudes."""
        return Waves(tuple(full_wave(line.amplitude * factor, line.order, line.phase) for line in self.lines))


class NoError(NamedTuple):
    """A gear without kinematic error: e = 0."""

    def value(self, angle: Reals) -> Any:
        """Error e = 0 [rad]."""
        return 0.0 * angle

    def slope(self, angle: Reals) -> Any:
        """Derivative de/dangle = 0."""
        return 0.0 * angle

    def curvature(self, angle: Any) -> Any:
        """Second derivative 0."""
        return 0.0 * angle
