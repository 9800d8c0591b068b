"""Harmonic balance of any system with `rhs(phase, y)`: internal states, laws with memory and the like.

omega/turns dY/dpsi = f(turns psi, Y) with one block of coefficients (mean, cosines, sines) a state, each in units of
the state's size in the linear response, by alternating frequency/time. It runs in NumPy on whole arrays of samples:
`rhs` and `jacobian` must take arrays, as all arithmetic without branches does. Of a system whose laws have breakpoints
the samples end at the kinks of the motion (see `panels`).

Krack & Gross 2019, Harmonic Balance for Nonlinear Vibration Problems, secs. 2.2-2.4.
"""

import itertools
import math
from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from ...law import is_spring
from ...protocols import has_jacobian, omega_of
from ...quantities import positive_count
from ...results import Floats
from ...tree import leaves, with_leaf
from ..integration.corners import repeating
from .fourier import analysis, extend, from_blocks, multiply_rows, synthesis, to_blocks
from .panels import Distance, distances, samples_between
from .second_order import STRENGTH, second_order

MOST_STATES = 64
ASKED, EQUAL = 1e-4, 1e-8  # size of the states, and of the largest rate, where a system is asked whether it repeats
SAME = ("J", "B", "law", "excitation", "omega", "error")  # what a system of the form of `Oscillator` has
DIFFERENCE = 6e-6  # of a state's size: the cube root of rounding, for central differences
NEAR_KINKS = 1e-7  # the same for laws with breakpoints, which a difference must not reach across


class FirstOrder(NamedTuple):
    """Balance of omega/turns dY/dpsi = f(turns psi, Y); an orbit takes `turns` turns of the base angle, or a part 1/g.

    `sizes` are the units of the states, `omega` is the base frequency where it does not vary, `error` and `tau` only
    say how many coefficients a state and all states have.
    """

    system: Any
    leaf: int
    omega_leaf: int
    turns: float
    omega: float
    sizes: Floats
    synthesis: Floats
    analysis: Floats
    analysis_double: Floats
    angles: Floats
    tau: Floats
    error: Floats
    kinked: bool = False

    def base(self, z: Any) -> float:
        """Base frequency [rad/s] at z = (coefficients, parameter)."""
        return float(z[-1]) if self.leaf == self.omega_leaf else self.omega

    def states(self, z: Any) -> Floats:
        """Coefficients (states, 2H+1), in blocks and in the states' own units."""
        return np.asarray(z[: len(self.tau)].reshape(len(self.sizes), -1) * self.sizes[:, None])

    def point(self, table: Floats, value: float) -> Floats:
        """Point (coefficients, parameter) of a table (2H+1, states): mean, cos 1, sin 1, ...; cut or filled up."""
        n = len(self.error)
        series = np.zeros((n, len(self.sizes)))
        series[: min(n, len(table))] = table[:n]
        return np.append((to_blocks(series).T / self.sizes[:, None]).ravel(), value)

    def table(self, point: Floats) -> Floats:
        """Table (2H+1, states) of a point: mean, cos 1, sin 1, ..."""
        return from_blocks(self.states(point).T)

    def whole(self, table: Floats) -> Floats:
        """Table of the states that `find_orbit` takes: the same."""
        return table

    def highest(self) -> int:
        """Highest harmonic of an orbit."""
        return len(self.error) // 2

    def fitted(self, table: Floats, value: float) -> Floats | None:
        """Point of a table, cut or filled up."""
        return self.point(table, value)

    def difference(self) -> float:
        """Half of the central differences for the Jacobian, in units of the states' sizes."""
        return NEAR_KINKS if self.kinked else DIFFERENCE

    def sampled(self, system: Any, y: Floats, wide: int = 1) -> tuple[Floats, Floats, Floats]:
        """Base angles [rad] of the samples, synthesis of the states there, and analysis up to harmonic `wide` H."""
        if not self.kinked:
            return self.angles, self.synthesis, self.analysis if wide == 1 else self.analysis_double
        return panels(system, y, self.turns, wide)

    def varied(self, of: Callable[..., Floats], z: Any, angles: Floats, y: Floats) -> Floats:
        """Rates, or their derivatives, in the states y (states, samples) at base angles [rad] and the parameter.

        With STRENGTH what varies with the angle at a fixed state is multiplied, and its mean over a turn is not.
        """
        system = with_leaf(self.system, self.leaf, float(z[-1]))
        here = of(system, angles, y)
        if self.leaf != STRENGTH:
            return here
        turn = np.broadcast_to(y[..., None], (*y.shape, len(self.angles)))
        mean: Floats = of(system, self.angles, turn).mean(axis=-1)
        return mean + float(np.exp(z[-1])) * (here - mean)

    def residual(self, z: Any, work: Any, r: Any) -> None:
        """Residual of every coefficient, in units of the state's size a second."""
        y = self.states(z)
        angles, synthesis, analysis = self.sampled(with_leaf(self.system, self.leaf, float(z[-1])), y)
        rates = self.varied(rates_at, z, angles, y @ synthesis)
        balance = self.base(z) / self.turns * derivative(y) - rates @ analysis
        r[:] = (balance / self.sizes[:, None]).ravel()

    def linearise(self, z: Any, work: Any, jacobian: Any, slope: Any) -> None:
        """Derivatives of the residual by the coefficients and by the parameter."""
        n = len(self.error)
        h = n // 2
        y = self.states(z)
        angles, synthesis, analysis = self.sampled(with_leaf(self.system, self.leaf, float(z[-1])), y, 2)
        slopes = partial(jacobians_at, sizes=self.sizes, difference=self.difference())
        matrices = self.varied(slopes, z, angles, y @ synthesis)
        gc, gs, product = np.empty(4 * h + 1), np.empty(4 * h + 1), np.empty((n, n))
        k = np.arange(1, h + 1)
        kw = self.base(z) / self.turns * k
        for i, j in np.ndindex(len(self.sizes), len(self.sizes)):
            block = jacobian[i * n : (i + 1) * n, j * n : (j + 1) * n]
            if np.any(matrices[i, j]):
                extend(matrices[i, j] @ analysis, h, gc, gs)
                multiply_rows(gc, gs, h, 1, product)
                block[:] = product * (-self.sizes[j] / self.sizes[i])
            else:
                block[:] = 0.0
            if i == j:
                block[k, h + k] += kw
                block[h + k, k] -= kw
        self.parameter_slope(z, work, slope)

    def parameter_slope(self, z: Any, work: Any, slope: Any) -> None:
        """Derivative with respect to the parameter by a central difference."""
        d = 1e-6 * max(abs(float(z[-1])), 1e-3)
        after, before, other = z.copy(), z.copy(), np.empty(len(self.tau))
        after[-1] += d
        before[-1] -= d
        self.residual(after, work, slope)
        self.residual(before, work, other)
        slope -= other
        slope /= 2.0 * d

    def linear_response(self, value: float) -> Floats:
        """Guess (coefficients, parameter): the response of the system linearised where its mean rate vanishes."""
        z = np.append(np.zeros(len(self.tau)), value)
        means = np.arange(len(self.sizes)) * len(self.error)
        r, slope, a = np.empty(len(self.tau)), np.empty(len(self.tau)), np.empty((len(self.tau), len(self.tau)))
        for _ in range(20):
            self.residual(z, None, r)
            self.linearise(z, None, a, slope)
            step = np.linalg.lstsq(a[np.ix_(means, means)], r[means], rcond=None)[0]
            if not np.all(np.isfinite(step)):
                return np.append(np.zeros(len(self.tau)), value)
            z[means] -= step
            if np.linalg.norm(step) < 1e-10:
                break
        self.residual(z, None, r)
        self.linearise(z, None, a, slope)
        z[:-1] -= np.linalg.lstsq(a, r, rcond=None)[0]
        return z


def distance_along(system: Any, y: Floats, turns: float) -> Distance:
    """Distance of a motion, states with coefficients y (states, 2H+1), from the breakpoints of its laws."""
    return lambda psi, table: distances(system, turns * psi, y @ table)


def panels(system: Any, y: Floats, turns: float, wide: int) -> tuple[Floats, Floats, Floats]:
    """As `FirstOrder.sampled` for states with coefficients y (states, 2H+1), cut at the kinks of the motion."""
    h = y.shape[1] // 2
    samples = samples_between(distance_along(system, y, turns), h)
    basis = samples.basis(wide * h)
    own = np.concatenate([basis[: h + 1], basis[wide * h + 1 : (wide + 1) * h + 1]])
    return turns * samples.psi, own, samples.analysis(basis)


def derivative(series: Floats) -> Floats:
    """Coefficients (states, 2H+1) of the derivatives of series in blocks."""
    h = series.shape[1] // 2
    k = np.arange(1, h + 1)
    out = np.zeros_like(series)
    out[:, 1 : h + 1], out[:, h + 1 :] = k * series[:, h + 1 :], -k * series[:, 1 : h + 1]
    return out


def rates_at(system: Any, angles: Floats, y: Floats) -> Floats:
    """Rates (states, ...) of a system in the states y (states, ...) at base angles [rad]."""
    return np.array([np.broadcast_to(rate, y.shape[1:]) for rate in system.rhs(angles, tuple(y))], float)


def jacobians_at(system: Any, angles: Floats, y: Floats, sizes: Floats, difference: float = DIFFERENCE) -> Floats:
    """Derivatives (states, states, ...) of the rates by the states; by central differences if the system has none.

    `difference` is half of each, in units of the states' `sizes`. An `Oscillator` knows them for a law
    torque(x) alone.
    """
    if has_jacobian(system):
        rows = system.jacobian(angles, tuple(y))
        return np.array([[np.broadcast_to(entry, y.shape[1:]) for entry in row] for row in rows], float)
    columns = []
    for j, size in enumerate(sizes):
        d = np.zeros(len(y)).reshape(-1, *[1] * (y.ndim - 1))
        d[j] = difference * size
        columns.append((rates_at(system, angles, y + d) - rates_at(system, angles, y - d)) / (2.0 * difference * size))
    return np.stack(columns, axis=1)


def number_of_states(system: Any) -> int:
    """How many states `rhs` takes: the smallest number of which it returns as many rates.

    Raises
    ------
    TypeError
        If there is none.
    """
    for n in range(1, MOST_STATES + 1):
        try:
            with np.errstate(all="ignore"):
                if len(system.rhs(np.zeros(1), tuple(np.zeros((n, 1))))) == n:
                    return n
        except (IndexError, ValueError):  # it takes more
            continue
    name = type(system).__name__
    raise TypeError(f"{name}.rhs(phase, y) returns as many rates as y has states for no number up to {MOST_STATES}")


def is_second_order(system: Any) -> bool:
    """Whether a system is J x'' + B u' + T(u) = tau, with the fields of `Oscillator` and a law torque(x)."""
    return all(hasattr(system, name) for name in SAME) and is_spring(system)


def periodic(verb: str, system: Any, turns: int = 1) -> Any:
    """Return the system, or refuse one whose rates differ so many turns of the base angle apart (ValueError).

    An oscillator with orders on its base angle repeats by its form; others are asked at two states.
    """
    system, turns = repeating(verb, system), positive_count("period", turns)
    if is_second_order(system) or not hasattr(system, "rhs"):
        return system
    places = list(itertools.product((0.0, 1.0, 2.5), (0.0, ASKED)))
    states, later = number_of_states(system), 2.0 * math.pi * turns
    with np.errstate(all="ignore"):
        rates = np.array([[system.rhs(at + by, (y,) * states) for at, y in places] for by in (0.0, later)], float)
    if np.any(np.abs(rates[1] - rates[0]) > EQUAL * np.nanmax(np.abs(rates), initial=0.0)):
        raise ValueError(
            f"{type(system).__name__} does not repeat after {turns} turn{'s' * (turns > 1)} of the base angle; {verb} "
            "takes what repeats: with gravity at the load give the number of motor turns after which it does, the "
            "ratio, as period where there is one, or use simulate or drive_run"
        )
    return system


def balance_of(system: Any, leaf: int, omega_leaf: int, harmonics: int, turns: int = 1) -> Any:
    """Balance problem of a system at its own parameters: on its torsion alone where it is J x'' + B u' + T(u) = tau.

    Raises
    ------
    TypeError
        If the system has neither those fields nor a method rhs(phase, y).
    """
    if is_second_order(system):
        return second_order(system, leaf, omega_leaf, harmonics, turns)
    if not hasattr(system, "rhs"):
        raise TypeError(f"{type(system).__name__} has no rhs(phase, y), nor the fields {', '.join(SAME)}")
    return first_order(system, leaf, omega_leaf, harmonics, turns)


def first_order(system: Any, leaf: int, omega_leaf: int, harmonics: int, turns: float = 1) -> FirstOrder:
    """Build the general balance problem of a system for a number of harmonics of omega/turns."""
    samples = 4 * harmonics + 4
    states, n = number_of_states(system), 2 * harmonics + 1
    kinked = len(distances(system, np.zeros(1), np.zeros((states, 1)))) > 0
    problem = FirstOrder(
        system, leaf, omega_leaf, turns, float(omega_of(system)), np.ones(states),
        synthesis(harmonics, samples), analysis(harmonics, samples), analysis(2 * harmonics, samples),
        2.0 * np.pi * turns * np.arange(samples) / samples, np.zeros(states * n), np.zeros(n), kinked,
    )  # fmt: skip
    if leaf == omega_leaf:
        value = problem.omega
    else:
        value = leaves(system)[leaf]
    with np.errstate(all="ignore"):
        sizes = np.linalg.norm(problem.states(problem.linear_response(value)), axis=1)
    if hasattr(system, "sizes"):  # a state that vanishes in the linear response
        sizes = np.maximum(np.nan_to_num(sizes), system.sizes())
    return problem._replace(sizes=np.where(np.isfinite(sizes) & (sizes > 0.0), sizes, 1.0))
