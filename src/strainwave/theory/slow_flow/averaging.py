"""First-order averaging for any law: the slow flow by averaging integrals.

The torsion is u = u0 + Re(z E) + F(theta), with E = exp(i (p/q) theta), z = a exp(-i phase) and the hard lines in F.
With N(u) = T(u) - T(u0) - T'(u0)(u - u0) and Omega = p omega/q, elimination of secular terms gives

    z' = -(mu/2 + i (Omega - omega_0)) z + (i/omega_0) <(N/J - S) conj(E)>

with S the soft line, k = p/q, and < > the mean over one common period, or over both angles without resonance
(Nayfeh & Mook 1979, Nonlinear Oscillations, sec. 4.1; Nayfeh 1981, Introduction to Perturbation Techniques, ch. 9).
In polar form: a' = -mu a/2 + <N sin eta>/(J omega_0) - <S sin eta>/omega_0, and the like with cos eta for a phase'.

A law without stiffness at u0 has omega_0 = Omega, with Omega/2 for the detuning, and N is its whole torque: steady
states then are those of one harmonic, (w^2(a) - Omega^2 + i mu Omega) z = S, w^2(a) = 2 <T cos eta>/(J a) the
describing function (Gelb & Vander Velde 1968, Multiple-Input Describing Functions, sec. 2.3).

The means of a law that is linear between breakpoints are exact (`averages.piecewise_averages`); those of other laws are
taken by the trapezoid rule, spectrally accurate where the law is smooth.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ...base.results import Complexes, Floats
from ...compile.jit import run
from ...numerics.balance.piecewise import Pieces, pieces_of
from .averages.memory import LoopAverages, loop_averages, remembers
from .averages.piecewise_averages import averages, grid_table
from .averages.varying import dampings, stiffnesses, torques, varies
from .setting import Setting, real_matrix

TARGET, LIMIT, LIMIT_2D = 1e-14, 8192, 65536  # accuracy of the trapezoid rule, and its most points
SAME_FORCE = 1e-9  # relative change of a force over the phases of z, where it only turns with them
SPEED_STEP = 1e-5  # of omega: of central differences
ROUNDING = 1e-13  # of the terms of a sum: so much rounding leaves
ERRORS_OF_AVERAGES = 30.0  # a force so many errors of the averages large, or smaller, may be none
ALONG, FEWEST = 512, 16  # points of the second angle for exact means, and points per turn of the coarsest grid


@dataclass(frozen=True, eq=False)
class Sampled:
    """Means by the trapezoid rule.

    Attributes
    ----------
    turn : (n,) complex array
        E at the sample points.
    lines : (lines, n) complex array
        exp(i k theta) at the sample points.
    forced : (n,) array
        u0 + F [rad] there.
    """

    turn: Complexes
    lines: Complexes
    forced: Floats

    def at(self, s: Setting) -> "Sampled":
        """Return the same points for another speed, or without hard lines for many."""
        if not np.any(s.hard):
            return replace(self, forced=np.full(len(self.turn), s.u0))
        return replace(self, forced=s.u0 + (s.hard @ self.lines).real)

    def force(self, s: Setting, z: Complexes) -> Complexes:
        """<N conj(E)> [N*m] for a vector of z."""
        law, u = s.system.law, self._torsion(z)
        return self._against_turn(law.torque(u) - law.torque(s.u0) - law.stiffness(s.u0) * (u - s.u0))

    def linear(self, s: Setting, z: Complexes) -> tuple[Complexes, Complexes, Complexes]:
        """`force`, and its derivatives [N*m/rad] to Re z and Im z."""
        law, u = s.system.law, self._torsion(z)
        change = law.stiffness(u) - law.stiffness(s.u0) + 0.0 * u
        slopes = self._against_turn(change * self.turn.real), -self._against_turn(change * self.turn.imag)
        return self.force(s, z), *slopes

    def _torsion(self, z: Complexes) -> Floats:
        """Torsion [rad] at the sample points for every z: shape (number of z, n)."""
        return np.asarray(self.forced + z.real[:, None] * self.turn.real - z.imag[:, None] * self.turn.imag)

    def _against_turn(self, values: Floats) -> Complexes:
        """Mean of values times conj(E) over the sample points."""
        mean = np.empty(len(values), complex)
        mean.real = values @ self.turn.real
        mean.imag = -(values @ self.turn.imag)
        mean /= len(self.turn)
        return mean


@dataclass(frozen=True, eq=False)
class Varied(Sampled):
    """Means by the trapezoid rule of a stiffness and a damping that vary.

    Attributes
    ----------
    theta : (n,) array
        Base angle [rad] at the sample points.
    """

    theta: Floats

    def force(self, s: Setting, z: Complexes) -> Complexes:
        """<N conj(E)> [N*m] for a vector of z."""
        law, u = s.system.law, self._torsion(z)
        linear = law.torque(s.u0) + law.stiffness(s.u0) * (u - s.u0)
        return self._against_turn(torques(s, self.theta, u, self._rate(s, z)) - linear)

    def linear(self, s: Setting, z: Complexes) -> tuple[Complexes, Complexes, Complexes]:
        """`force`, and its derivatives [N*m/rad] to Re z and Im z."""
        along = self.theta, self._torsion(z), self._rate(s, z)
        pull, drag = stiffnesses(s, *along) - s.system.law.stiffness(s.u0), s.fast * dampings(s, *along)
        cosine, sine = self.turn.real, self.turn.imag
        slopes = self._against_turn(pull * cosine - drag * sine), -self._against_turn(pull * sine + drag * cosine)
        return self.force(s, z), *slopes

    def _rate(self, s: Setting, z: Complexes) -> Floats:
        """Rate u' [rad/s] at the sample points for every z."""
        forced = s.omega * ((1j * np.array(s.orders) * s.hard) @ self.lines).real
        return np.asarray(forced - s.fast * (z.real[:, None] * self.turn.imag + z.imag[:, None] * self.turn.real))


@dataclass(frozen=True, eq=False)
class Exact:
    """Exact means of a law that is linear between breakpoints.

    Attributes
    ----------
    pieces : Pieces
        Breakpoints, and slopes of N.
    fast, harmonics : int, tuple of int
        Harmonics of the common period: of E, and of the lines.
    lines, table : arrays
        Lines and grid of `piecewise_averages.averages`; without lines in the non-resonant case.
    means : (m,) array
        Torsion [rad] that the fast motion is about: u0, or u0 + F at m places of the second angle without resonance.
    """

    pieces: Pieces
    fast: int
    harmonics: tuple[int, ...]
    lines: Floats
    table: Floats
    means: Floats

    def at(self, s: Setting) -> "Exact":
        """Return the same for another speed, or without hard lines for many."""
        if s.resonance.ratio is not None and not (np.any(s.hard) or len(self.lines)) and self.table.size:
            return self
        if s.resonance.ratio is None:
            return replace(self, means=_along(s, len(self.means)))
        lines = np.column_stack([self.harmonics, s.hard.real, -s.hard.imag])[s.hard != 0.0]
        return replace(self, lines=lines, table=grid_table(self.fast, self.harmonics, lines))

    def force(self, s: Setting, z: Complexes) -> Complexes:  # noqa: ARG002 (all that depends on s is in the fields)
        """<N conj(E)> [N*m] for a vector of z."""
        return self._means(z)[0]

    def linear(self, s: Setting, z: Complexes) -> tuple[Complexes, Complexes, Complexes]:  # noqa: ARG002
        """`force`, and its derivatives [N*m/rad] to Re z and Im z."""
        force, mean, twice = self._means(z)
        return force, 0.5 * (mean + twice), 0.5j * (mean - twice)

    def _means(self, z: Complexes) -> tuple[Complexes, Floats, Complexes]:
        """Means of N conj(E), N' and N' conj(E)^2."""
        m = len(self.means)
        each = np.repeat(z, m) if m > 1 else z
        force, stiffness, twice = np.empty(len(each), complex), np.empty(len(each)), np.empty(len(each), complex)
        run(
            averages, self.pieces.breaks, self.pieces.slopes, np.tile(self.means, len(z)), each.real.copy(),
            each.imag.copy(), float(self.fast), self.lines, self.table, force, stiffness, twice,
        )  # fmt: skip
        if m == 1:
            return force, stiffness, twice
        return force.reshape(-1, m).mean(1), stiffness.reshape(-1, m).mean(1), twice.reshape(-1, m).mean(1)


class FirstOrder:
    """Base of the flows of first order: no small harmonics, and stability by the rates alone."""

    setting: Setting
    at: Callable[[Any], Any]
    balance: Callable[[Any], tuple[Any, Floats]]

    def jacobian(self, z: Complexes | complex) -> Floats:
        """Derivative [1/s] of (Re z', Im z') to (Re z, Im z): shape (..., 2, 2)."""
        return self.balance(z)[1]

    def stability(self, z: Complexes | complex) -> Floats:
        """Matrix [1/s] whose eigenvalues decide on stability: that of the rates."""
        return self.setting.held(self.jacobian(z), z)

    def sound(self, z: Complexes) -> Any:
        """True for states that can be ones of this order: at first order all."""
        return np.isfinite(z)

    def small(self, _: Any) -> list[tuple[Any, Any]]:
        """Return nothing: first order has no small harmonics."""
        return []

    def linearized(self, z: complex) -> tuple[complex, Floats, complex]:
        """The rate at one z, and its derivatives to (Re z, Im z) and to omega."""
        rate, slope = self.balance(z)
        return complex(rate), slope, self._speed_slope(z)

    def _speed_slope(self, z: complex) -> complex:
        """Derivative of the rate at one z to omega, by a central difference."""
        d = SPEED_STEP * self.setting.omega
        up, down = self.at(self.setting.omega + d), self.at(self.setting.omega - d)
        return complex(up.rates(z) - down.rates(z)) / (2.0 * d)


@dataclass(frozen=True, eq=False)
class AveragedFlow(FirstOrder):
    """The slow flow by averaging integrals.

    Attributes
    ----------
    means : Sampled, Exact or LoopAverages
        Form of the averages.
    error : float
        Relative error of the averages: 0 where they are exact or right to rounding.
    """

    setting: Setting
    means: Sampled | Exact | LoopAverages
    error: float = 0.0

    def at(self, omega: Any) -> "AveragedFlow":
        """Return the flow at another speed [rad/s] of the base angle, or without hard lines at many."""
        moved = self.setting.at(omega)
        return AveragedFlow(moved, self.means.at(moved), self.error)

    def mean_force(self, z: Any) -> Any:
        """Average <N/J conj(E)> [rad/s^2] for an array of z [rad]."""
        s = self.setting
        return self.means.force(s, np.ravel(np.asarray(z, complex))).reshape(np.shape(z)) / s.system.J

    @property
    def coarse(self) -> "AveragedFlow":
        """The flow with fewer samples, with which steady states are first looked for."""
        if isinstance(self.means, LoopAverages):
            return replace(self, means=self.means.coarse())
        return self if isinstance(self.means, Exact) else sampled(self.setting, 3 if self.error > 0.0 else 2)

    @property
    def push(self) -> Any:
        """Part of the rate [rad/s] that the soft line takes off."""
        return 0.5j * self.setting.soft / self.setting.omega_0

    @property
    def linear(self) -> Any:
        """Rate over z [1/s] of small free motions."""
        return -(0.5 * self.setting.mu + 1j * self.setting.lag)

    def unforced(self, z: Complexes | complex) -> Any:
        """Rate [rad/s] without the soft line."""
        return self.linear * z + (1j / self.setting.omega_0) * self.mean_force(z)

    def rates(self, z: Any) -> Any:
        """Rate z' [rad/s] for an array of z [rad]."""
        return self.unforced(z) - self.push

    def balance(self, z: Complexes | complex) -> tuple[Any, Floats]:
        """The rate z' [rad/s] for an array of z [rad], and its derivative [1/s] (..., 2, 2) to (Re z, Im z)."""
        s = self.setting
        scale = 1j / (s.omega_0 * s.system.J)
        parts = self.means.linear(s, np.ravel(np.asarray(z, complex)))
        force, to_re, to_im = [scale * part.reshape(np.shape(z)) for part in parts]
        return self.linear * z + force - self.push, real_matrix(self.linear + to_re, 1j * self.linear + to_im)

    def small(self, z: Any) -> list[tuple[Any, Any]]:
        """Return nothing: first order has no small harmonics, but the mean torsion of friction and memory."""
        return self.means.small(self.setting, z) if isinstance(self.means, LoopAverages) else []

    def _speed_slope(self, z: complex) -> complex:
        s = self.setting
        if np.any(s.hard) or s.gap is not None or isinstance(self.means, LoopAverages | Varied):
            return super()._speed_slope(z)
        ratio = float(s.resonance.ratio or 0.0)  # the forced motion, and so the averages, stay
        return complex(-1j * ratio * (z + ratio * s.omega / s.omega_0 * np.sum(s.error_lines[s.on_fast])))

    def phase_matters(self) -> bool:
        """True for a flow that depends on the phase, that is, for a resonance that appears at first order."""
        if self.setting.soft != 0.0:
            return True
        return turns_with_phase(self.mean_force, self.setting, self.error)


def turns_with_phase(force: Callable[[Any], Any], s: Setting, error: float) -> bool:
    """True for a mean force <N/J conj(E)> [rad/s^2] of z [rad] that does more than turn with the phase of z."""
    phases = np.exp(-2j * np.pi * np.arange(16) / 16.3)
    amplitudes = np.unique([size * f for size in s.scales() for f in (0.1, 0.3, 1.0, 3.0, 10.0)])
    with np.errstate(all="ignore"):
        radial = force(amplitudes[:, None] * phases) / phases
        spread = np.max(np.abs(radial - radial[:, :1]), axis=1)
        size = np.max(np.abs(radial), axis=1) + ROUNDING * amplitudes * s.omega_0**2
    return bool(
        np.nanmax(np.where(np.isfinite(spread), spread / size, 0.0)) > max(SAME_FORCE, ERRORS_OF_AVERAGES * error)
    )


def averaged_flow(s: Setting, probes: Complexes | None = None) -> AveragedFlow:
    """Set up the averages: exact ones, or points that are doubled until the averages stand still or are too many.

    They are judged at the states `probes` [rad], by default of the amplitudes that matter.
    """
    probes = probes_of(s) if probes is None else probes
    if remembers(s.system.law):
        return AveragedFlow(s, *loop_averages(s, 1, probes))
    pieces = None if varies(s.system) else pieces_of(s.system.law)
    if pieces is not None:
        return _exact_flow(s, pieces)
    level, flow = 0, sampled(s, 0)
    with np.errstate(all="ignore"):
        coarse = flow.mean_force(probes)
        while True:
            level += 1
            flow = sampled(s, level)
            fine = flow.mean_force(probes)
            error, noise = _change(s, probes, coarse, fine)
            limit = LIMIT_2D if s.resonance.ratio is None else LIMIT
            points = flow.means.forced.size  # type: ignore[union-attr]
            if error <= max(TARGET, noise) or 4 * points > limit:
                return replace(flow, error=error if error > max(TARGET, noise) else 0.0)
            coarse = fine


def probes_of(s: Setting) -> Complexes:
    """States at which the error of the averages is judged."""
    phases = np.exp(1j * np.array([0.3, 1.7, 4.1]))
    return np.concatenate([amplitude * phases for amplitude in s.scales()])


def _change(s: Setting, probes: Complexes, coarse: Complexes, fine: Complexes) -> tuple[float, float]:
    """Largest change of the averages relative to the largest of them, and what rounding alone makes of it."""
    finite = np.isfinite(coarse) & np.isfinite(fine)
    size = float(np.max(np.abs(fine[finite]), initial=0.0))
    if size == 0.0:
        return 0.0, 0.0
    # the size counts against rounding: N is a difference of torques
    noise = 1e-15 * s.omega_0**2 * float(np.max(np.abs(probes), initial=0.0)) / size
    return float(np.max(np.abs(fine - coarse)[finite], initial=0.0)) / size, noise


def _exact_flow(s: Setting, pieces: Pieces) -> AveragedFlow:
    """The flow by exact means; without resonance exact in the fast angle, by the trapezoid rule in the other one."""
    excess = Pieces(pieces.breaks, pieces.slopes - float(s.system.law.stiffness(s.u0)))
    none = np.empty((0, 3))
    if s.resonance.ratio is not None:
        blank = Exact(excess, s.fast_place, s.places, none, none, np.array([s.u0]))
        return AveragedFlow(s, blank.at(s))
    m = ALONG * s.top if s.orders else 1
    table = grid_table(1, (), none)
    fine, coarse = [AveragedFlow(s, Exact(excess, 1, (), none, table, _along(s, k))) for k in (m, -(-m // 2))]
    probes = probes_of(s)
    error, noise = _change(s, probes, coarse.mean_force(probes), fine.mean_force(probes))
    return replace(fine, error=error if error > max(TARGET, noise) else 0.0)


def _along(s: Setting, points: int) -> Floats:
    """U0 + F [rad] at equal steps of the base angle over the common period of the lines."""
    return np.asarray(s.u0 + s.forced(2.0 * np.pi / s.base * np.arange(points) / points))


def sampled(s: Setting, level: int) -> AveragedFlow:
    """The flow on a grid of 16 points per turn of the fastest angle, times 2^level."""
    ratio, points = s.resonance.ratio, FEWEST << level
    if ratio is None:
        n = (points, points * s.top if s.orders else 1)
        eta, theta = np.meshgrid(*(2.0 * np.pi * np.arange(m) / m for m in n), indexing="ij")
        fast, theta = eta.ravel(), theta.ravel() / s.base
    else:
        n_points = s.points(points * s.top)
        theta = (2.0 * np.pi * ratio.denominator / s.base) * np.arange(n_points) / n_points
        fast = float(ratio) * theta
    lines = np.exp(1j * np.array(s.orders, float)[:, None] * theta)
    along = np.exp(1j * fast), lines, s.u0 + (s.hard @ lines).real
    return AveragedFlow(s, Varied(*along, theta) if varies(s.system) else Sampled(*along))
