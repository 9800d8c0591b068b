"""The slow flow at second order, for any law.

With w = u - u0 and w = Re(z E) + F the equation w'' + mu w' + omega_0^2 w + n(w) = lines leaves on E

    z'' + (2 i Omega + mu) z' = soft - (omega_0^2 - Omega^2 + i mu Omega) z - 2 <n conj(E)> = R(z)

and nothing of it is expanded in the detuning or the damping. First order takes n at w alone. Second order takes the
small harmonics w_1 that every other harmonic of n drives, and z'' from the flow itself: z' = R/(2 i Omega + mu + f'),
f' the derivative of R/(2 i Omega + mu) (Nayfeh & Mook 1979, Nonlinear Oscillations, sec. 2.3.3; Krack & Gross 2019,
Harmonic Balance for Nonlinear Vibration Problems, ch. 2). Steady states are therefore the zeros of R. A law with a
square and a cube under one line has formulas (`closed_forms`, n' w_1 for what the small harmonics do to E); a law
with friction or memory is followed along its closed loops (`memory`), every other law is sampled, along w and along
w + w_1.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from ...base.law import breakpoints_of, polynomial_of
from ...base.results import Complexes, Floats
from ...model.laws.springs import taylor
from ...numerics.addressed import torques
from .averages.law_samples import Places, harmonics
from .averages.memory import LoopAverages, loop_averages, remembers
from .averaging import probes_of, turns_with_phase
from .second_order_forms import FORMS
from .setting import Setting, real_matrix

REACH = 7  # small harmonics up to this multiple of the fastest component
SMOOTH = 80  # points per period of the fastest component: numbers without large prime factors
KINKED = 128  # for a law with breakpoints, per period of the highest small harmonic
FREE_REACH, FREE_POINTS = 4, 24  # without resonance, of each of the two angles
MOST_SAMPLES = 6_000_000  # harmonics times sample points
STEP = 1e-5  # of the amplitude: central differences of R
AROUND = np.array([0.0, 1.0, -1.0, 1j, -1j])
Small = list[tuple[Any, Any]]  # speed [rad/s] and amplitude [rad, complex] of each small harmonic


@dataclass(frozen=True, eq=False)
class Forms:
    """Second order by formula.

    Attributes
    ----------
    square, cube : float
        c2 [1/(rad s^2)] and c3 [1/(rad^2 s^2)] of the law over J about u0.
    """

    square: float
    cube: float

    def values(self, s: Setting, z: Any) -> tuple[Small, Any]:
        """Small harmonics, and 2 <n conj(E)> [rad/s^2]."""
        ratio = s.resonance.ratio
        line = None if ratio is None or not s.orders else ratio / s.orders[0]
        form = FORMS[line]
        c = s.hard[..., 0] if s.orders else 0j
        speed = s.fast if line is None else s.fast / line.numerator
        other = s.omega * s.orders[0] if s.orders else s.omega
        small, first, back = form.values(self.square, self.cube, s.omega_0**2, s.mu, speed, other, z, c)
        speeds = [m * speed + n * other for m, n in form.numbers]
        return list(zip(speeds, small, strict=True)), first + back

    def primary(self, s: Setting) -> tuple[Any, Any] | None:
        """Factors of |z|^2 z and |z|^4 z in 2 <n conj(E)> of a line on E alone; None of other lines."""
        if not s.orders or s.resonance.ratio != s.orders[0]:
            return None
        form, k, w = FORMS[s.resonance.ratio / s.orders[0]], s.omega_0**2, s.fast
        _, _, by_square = form.values(self.square, 0.0, k, s.mu, w, w, 1.0 + 0j, 0j)
        _, by_cube, beyond = form.values(0.0, self.cube, k, s.mu, w, w, 1.0 + 0j, 0j)
        return by_square + by_cube, beyond


@dataclass(frozen=True, eq=False)
class Samples:
    """Second order by samples along the motion over the common period, or over both angles without resonance.

    Attributes
    ----------
    numbers : (m, 2) int array
        Small harmonics, and E last, as multiples of the angle chi and of the common angle of the lines (0 where chi is
        the only angle).
    points : tuple of int
        Samples over the turn of each angle, that of chi last.
    places : tuple of int
        Index in `numbers` of each forcing line; -1 for the soft one.
    """

    numbers: Any
    points: tuple[int, ...]
    places: tuple[int, ...]

    @property
    def waves(self) -> Places:
        """Places of all harmonics."""
        return tuple(self.numbers.T[::-1])[-len(self.points) :]

    def values(self, s: Setting, z: Any) -> tuple[Small, Any]:
        """Small harmonics, and 2 <n conj(E)> [rad/s^2]."""
        c, pull = np.zeros((*np.shape(z), len(self.numbers)), complex), s.omega_0**2
        c[..., -1] = z
        for line, index in enumerate(self.places):
            c[..., index] += s.hard[..., line]  # the last axis of z is that of the speeds
        n = self._torque(s, c, slice(-1))
        n[..., np.all(self.numbers[:-1] == 0, axis=1)] *= 0.5
        m, k = self.numbers[:-1].T
        speed = np.multiply.outer(s.fast / self.numbers[-1, 0], m) + np.multiply.outer(s.base * s.omega, k)
        stiff = np.asarray(pull)[..., None]
        small = ((stiff - 1j * s.mu * speed) * c[..., :-1] - n) / (stiff - speed**2 + 1j * s.mu * speed)
        c[..., :-1] += small
        back = self._torque(s, c, slice(-1, None))[..., 0] - pull * z
        return [(speed[..., i], small[..., i]) for i in range(len(m))], back

    def _torque(self, s: Setting, c: Complexes, some: slice) -> Complexes:
        """Harmonics [rad/s^2], at the waves `some`, of (T(u0 + w) - T(u0))/J along motions w of amplitudes c."""
        law, onto = s.system.law, tuple(wave[some] for wave in self.waves)
        origin = s.u0, float(law.torque(s.u0))
        means = harmonics(torques, law, c.reshape(-1, c.shape[-1]), self.waves, onto, self.points, origin)
        return np.asarray(2.0 / s.system.J * means.reshape(*c.shape[:-1], len(onto[0])))


@dataclass(frozen=True, eq=False)
class SecondOrderFlow:
    """The slow flow at second order.

    Attributes
    ----------
    setting : Setting
        The linear problem about the operating point.
    force, rough : Forms, Samples or LoopAverages
        Harmonics of the torque, and those of fewer samples with which steady states are first looked for.
    error : float
        Relative error of the means on E, from half as many samples: 0 where they are right to rounding.
    """

    setting: Setting
    force: Forms | Samples | LoopAverages
    rough: Forms | Samples | LoopAverages
    error: float = 0.0

    @property
    def coarse(self) -> "SecondOrderFlow":
        """The flow with fewer samples."""
        return replace(self, force=self.rough)

    def at(self, omega: Any) -> "SecondOrderFlow":
        """Return the flow at another speed [rad/s] of the base angle."""
        return replace(self, setting=self.setting.at(omega))

    @cached_property
    def push(self) -> Any:
        """Part of the rate [rad/s] that the soft line takes off, before z'' is counted."""
        return -self.setting.soft / self._carrier

    @cached_property
    def linear(self) -> Any:
        """Rate over z [1/s] of small free motions, before z'' is counted."""
        s = self.setting
        return -(s.omega_0**2 - s.fast**2 + 1j * s.mu * s.fast) / self._carrier

    def unforced(self, z: Complexes) -> Any:
        """Rate [rad/s] without the soft line and before z'' is counted."""
        return self.linear * z - self.force.values(self.setting, z)[1] / self._carrier

    @cached_property
    def _carrier(self) -> Any:
        return 2j * self.setting.fast + self.setting.mu

    def rates(self, z: Any) -> Any:
        """Rate z' [rad/s] for an array of z [rad]."""
        rate, by_re, by_im = self._slopes(z)
        push, other = self._carrier * rate, 0.5 * (by_re + 1j * by_im)
        direct = self._carrier + 0.5 * (by_re - 1j * by_im)  # direct z' + other conj(z') = push
        return (direct.conjugate() * push - other * push.conjugate()) / (np.abs(direct) ** 2 - np.abs(other) ** 2)

    def jacobian(self, z: complex) -> Floats:
        """Derivative [1/s] of (Re z', Im z') to (Re z, Im z), exact at steady states: shape (..., 2, 2)."""
        return self._slow(self.balance(z)[1])

    def stability(self, z: Complexes | complex) -> Floats:
        """Matrix [1/s] (..., 4, 4) of (fast z, z') next to a steady state, z'' and all: its eigenvalues decide.

        Of a law with friction or memory, whose loops are closed at the speed of E alone, that of the rates.
        """
        slope = self.balance(z)[1]
        if remembers(self.setting.system.law):
            return self._slow(slope)
        carrier, scale = self._matrix, np.asarray(self.setting.fast)[..., None, None]
        matrix = np.zeros((*slope.shape[:-2], 4, 4))
        matrix[..., :2, 2:] = scale * np.eye(2)
        matrix[..., 2:, :2] = carrier @ slope / scale
        matrix[..., 2:, 2:] = -carrier
        return self.setting.held(matrix, z)

    def linearized(self, z: complex) -> tuple[complex, Floats, complex]:
        """The rate before z'' is counted, which vanishes where z' does, and its derivatives to z and to omega."""
        step, d = STEP * (abs(z) + self._least), STEP * self.setting.omega
        moved = self.at(self.setting.omega + np.array([0.0, 0.0, 0.0, 0.0, 0.0, d, -d]))
        places = z + np.array([0.0, step, -step, 1j * step, -1j * step, 0.0, 0.0])
        rate, *ends = (moved.unforced(places) - moved.push).tolist()
        by_re, by_im, by_omega = np.subtract(ends[::2], ends[1::2]).tolist()
        return rate, real_matrix(by_re / (2.0 * step), by_im / (2.0 * step)), by_omega / (2.0 * d)

    def sound(self, z: Complexes) -> Any:
        """True for states whose small harmonics are smaller than their motions: beyond that no state is one."""
        s = self.setting
        small = sum(np.abs(amplitude) ** 2 for _, amplitude in self.small(z))
        return small <= np.abs(z) ** 2 + np.sum(np.abs(s.hard) ** 2, axis=-1)

    def small(self, z: Any) -> Small:
        """Speed [rad/s] and amplitude [rad, complex] of each small harmonic: the waveform's first correction."""
        return self.force.values(self.setting, z)[0]

    def phase_matters(self) -> bool:
        """True for a flow that depends on the phase, that is, for a resonance that appears up to second order."""
        if self.setting.soft != 0.0:
            return True
        return turns_with_phase(lambda z: self.force.values(self.setting, z)[1], self.setting, self.error)

    def balance(self, z: Complexes | complex) -> tuple[Any, Floats]:
        """The rate before z'' is counted, and its derivative to (Re z, Im z) by central differences."""
        rate, by_re, by_im = self._slopes(z)
        return rate, real_matrix(by_re, by_im)

    def _slopes(self, z: Any) -> tuple[Any, Any, Any]:
        """The rate before z'' is counted, and its derivatives to Re z and to Im z."""
        z = np.asarray(z, complex)
        step = STEP * (np.abs(z) + self._least)
        around = self.unforced(z + np.multiply.outer(AROUND, step))
        by_re, by_im = (around[1] - around[2]) / (2.0 * step), (around[3] - around[4]) / (2.0 * step)
        return around[0] - self.push, by_re, by_im

    @cached_property
    def _least(self) -> float:
        """Amplitude [rad] that gives the step of differences at rest."""
        return 1e-3 * max(self.setting.scales())

    @cached_property
    def _matrix(self) -> Floats:
        """2 i Omega + mu as a real matrix (..., 2, 2)."""
        carrier = np.asarray(self._carrier)
        return real_matrix(carrier, 1j * carrier)

    def _slow(self, slope: Floats) -> Floats:
        """Derivative of R/(2 i Omega + mu) with the share of z''."""
        return np.asarray(np.linalg.solve(self._matrix + slope, self._matrix @ slope))


def second_order(s: Setting) -> SecondOrderFlow:
    """The second-order flow of a setting."""
    if remembers(s.system.law):
        loops, error = loop_averages(s, 2, probes_of(s))
        return SecondOrderFlow(s, loops, loops.coarse(), error)
    cubic = _square_and_cube(s)
    ratio = s.resonance.ratio
    line = None if ratio is None or not s.orders else ratio / s.orders[0]
    if cubic is not None and s.gap is None and len(s.orders) <= 1 and line in FORMS:
        return SecondOrderFlow(s, Forms(*cubic), Forms(*cubic))
    rough = _samples(s, False)
    if len(breakpoints_of(s.system.law)) == 0:
        return SecondOrderFlow(s, rough, rough)
    samples = _samples(s, True)
    return SecondOrderFlow(s, samples, rough, _error(s, samples))


def _error(s: Setting, samples: Samples) -> float:
    """Relative change of the means of a law with breakpoints when every other sample is left out."""
    first, *others = samples.points
    half = replace(samples, points=(first // 2, *others))
    probes = probes_of(s)
    with np.errstate(all="ignore"):
        fine, coarse = samples.values(s, probes)[1], half.values(s, probes)[1]
    size = float(np.nanmax(np.abs(fine), initial=0.0))
    return float(np.nanmax(np.abs(fine - coarse), initial=0.0)) / size if size > 0.0 else 0.0


def _square_and_cube(s: Setting) -> tuple[float, float] | None:
    """Square and cube of the law over J about u0; None where it has more, or is no polynomial."""
    square, cube = taylor(s.system.law, s.u0)
    higher = any((polynomial_of(s.system.law) or ())[4:])
    return None if square is None or cube is None or higher else (square / s.system.J, cube / s.system.J)


def _samples(s: Setting, kinked: bool) -> Samples:
    ratio = s.resonance.ratio
    if ratio is None:
        base, top = s.base, max(s.orders, default=0)
        reach = FREE_REACH * top // base
        pairs = [(m, n) for m in range(FREE_REACH + 1) for n in range(-reach, reach + 1)]
        numbers = [pair for pair in pairs if pair >= (0, 0) and pair != (1, 0)]
        count = FREE_POINTS * (4 if kinked else 1)
        points: tuple[int, ...] = (count * top // base, count) if top else (count,)
        places = tuple(numbers.index((0, k // base)) for k in s.orders)
        return Samples(np.array([*numbers, (1, 0)]), points, places)
    fast, top = s.fast_place, REACH * s.top
    numbers = [(m, 0) for m in range(top + 1) if m != fast]
    points = (s.points(KINKED * (top + 1) if kinked else SMOOTH * s.top),)
    if points[0] * top > MOST_SAMPLES:
        p, q = s.resonance
        raise ValueError(
            f"second order of the resonance {p}:{q} with lines of order {', '.join(map(str, s.orders))} needs "
            f"{top // REACH} harmonics of their common period, which is too many; take order=1 or harmonic balance"
        )
    places = tuple(-1 if k == fast else numbers.index((k, 0)) for k in s.places)
    return Samples(np.array([*numbers, (fast, 0)]), points, places)
