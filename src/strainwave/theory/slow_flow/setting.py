"""The linear problem that multiple scales start from: operating point, lines of the forcing, forced motion.

The mean torque sets the operating point u0, T(u0) = mean; omega_0 = sqrt(T'(u0)/J) and mu = B/J refer to it. The lines
of tau - J omega^2 e'' are found by sampling, so any periodic excitation will do. A line with k = p/q is soft and drives
the slow flow; all others are hard: F(theta) = sum C_k cos(k theta + phi_k), C_k = (P_k/J)/(omega_0^2 - k^2 omega^2) at
the actual omega (some texts freeze it at the resonance: a different number).

A law without stiffness at u0, as a gap without preload, has no omega_0: its frequency is that of the amplitude. There
omega_0 stands for Omega, the speed of the line that drives the motion, and the whole torque is nonlinear.
"""

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ...base.law import breakpoints_of, depends, spring_stiffness, torque_of
from ...base.protocols import Law, System, joint_orders, lacking
from ...base.quantities import Reals
from ...base.results import Booleans, Complexes, Floats
from ...base.sentences import Angle, Sentence, Speed
from ...model.oscillator import NoVariation
from ...numerics.balance.harmonics import highest_order
from ...numerics.operating_point import loaded_state
from ..equilibria import reach
from ..resonance import NONRESONANT, Resonance
from .averages.varying import mean_damping, pulling_lines, varied_orders, varies

LARGEST, SMALLEST = 1e30, 1e-30  # of what the slow flow takes powers of
HIGHEST = 2000  # harmonic of the common period: the averages sample it 16 times and more
NEAR_RESONANCE = 1e-6  # of omega_0: a hard line that is nearer sits on it
SMALLEST_LINE = 1e-13  # relative to the largest: what sampling and rounding leave behind


@dataclass(frozen=True, eq=False)
class Setting:
    """The linear problem about the operating point, at one speed of the base angle.

    Attributes
    ----------
    u0 : float
        Torsion [rad] under the mean torque; of a law with memory the one that a slow load from rest leads to.
    omega_0, mu : float
        sqrt(T'(u0)/J) [rad/s], before anything yields or slips, and B/J [1/s]; omega_0 is Omega where T'(u0) is 0.
    orders : tuple of int
        Orders of all lines of the forcing, and of a stiffness and a damping that vary.
    torque_lines, error_lines : (lines,) complex arrays
        Amplitudes times exp(i phase) of the torque [N*m] and of the kinematic error [rad].
    on_fast : (lines,) bool array
        True for the soft line, at Omega.
    omega, fast : float
        Speed of the base angle and Omega (omega_0 without resonance) [rad/s].
    hard : (lines,) complex array
        C_k exp(i phi_k) [rad]; 0 for the soft line.
    soft : complex
        P_k/J exp(i phi_k) [rad/s^2] of the line at Omega.
    mean : float
        Mean torque [N*m].
    gap : float or None
        Torsion [rad] from u0 up to which a law without stiffness at u0 stays without torque; None of other laws.
    reach : float
        Torsion [rad] from u0 to the nearest saddle, where a softening law turns over; infinite of other laws.
    """

    system: Any
    resonance: Resonance
    u0: float
    omega_0: float
    mu: float
    orders: tuple[int, ...]
    torque_lines: Complexes
    error_lines: Complexes
    on_fast: Booleans
    omega: float
    fast: float
    hard: Complexes
    soft: complex
    mean: float = 0.0
    gap: float | None = None
    reach: float = math.inf

    def at(self, omega: Any) -> "Setting":
        """Return the same problem at another speed [rad/s] of the base angle; arrays of speeds give arrays of lines."""
        k = np.multiply.outer(omega, np.array(self.orders, float))
        # J u'' + B u' + T(u) = tau - J omega^2 e'', and e'' of a line is -k^2 e_k
        forcing = self.torque_lines / self.system.J + k**2 * self.error_lines
        p, q = self.resonance
        fast = p / q * omega if q else self.omega_0
        omega_0 = self.omega_0 if self.gap is None else fast
        square = np.asarray(omega_0)[..., None] ** 2
        gap, least = square - k**2, 2.0 * NEAR_RESONANCE * square
        if (close := np.abs(gap) < least).any():
            gap = np.where(close, np.copysign(least, gap), gap)  # see `sits_on`
        hard, soft = forcing / gap, forcing[..., self.on_fast].sum(axis=-1)
        hard[..., self.on_fast] = 0.0
        system, soft = self.system._replace(omega=omega), complex(soft) if np.ndim(soft) == 0 else soft
        return replace(self, system=system, omega=omega, omega_0=omega_0, fast=fast, hard=hard, soft=soft)

    @property
    def B(self) -> float:
        """Damping [N*m*s/rad], its mean where it varies."""
        return self.mu * float(self.system.J)

    @property
    def lag(self) -> Any:
        """Rate [rad/s] at which free linear motions fall behind E: Omega - omega_0, or Omega/2 without stiffness."""
        return self.fast - self.omega_0 if self.gap is None else 0.5 * self.fast

    def inside(self, z: Any) -> Any:
        """True for motions that stay inside the gap, where nothing holds their mean."""
        return np.abs(z) + np.sum(np.abs(self.hard), axis=-1) <= (-1.0 if self.gap is None else self.gap)

    def held(self, matrix: Floats, z: Any) -> Floats:
        """Matrices [1/s] (..., n, n) next to states z [rad]; 0 inside the gap or past a saddle: none attracts there."""
        if self.gap is None and self.reach == math.inf:
            return matrix
        return np.where((self.inside(z) | self.beyond(z))[..., None, None], 0.0, matrix)

    def beyond(self, z: Any) -> Any:
        """True for motions that pass a saddle of the law, from where they do not come back."""
        return np.abs(z) + np.sum(np.abs(self.hard), axis=-1) >= self.reach

    def unforced(self) -> "Setting":
        """Return the free vibration about the same operating point."""
        none = np.zeros(0, complex)
        free = replace(self, resonance=NONRESONANT, orders=(), on_fast=np.zeros(0, bool), fast=self.omega_0)
        if varies(self.system):
            free = replace(free, system=self.system._replace(variation=NoVariation()))
        return replace(free, torque_lines=none, error_lines=none, hard=none, soft=0j)

    def of(self, places: Any) -> "Setting":
        """Return the problems at some of many speeds; the same where there is one."""
        if np.ndim(self.omega) == 0:
            return self
        names = ["omega", "hard", "soft", *(["fast"] if self.resonance.ratio else [])]
        names += [] if self.gap is None else ["omega_0"]
        system = self.system._replace(omega=self.omega[places])  # type: ignore[index]
        return replace(self, system=system, **{name: getattr(self, name)[places] for name in names})

    def sits_on(self, omega: float) -> int | None:
        """Order of a hard line on omega_0 at a speed [rad/s], where its forced amplitude is infinite at first order."""
        if self.gap is not None:
            return None
        close = (abs(self.omega_0 - k * omega) < NEAR_RESONANCE * self.omega_0 for k in self.orders)
        hard = ~self.on_fast & ((self.torque_lines != 0.0) | (self.error_lines != 0.0))
        return next((k for k, hot, counts in zip(self.orders, close, hard, strict=True) if hot and counts), None)

    def refuse_on_resonance(self, omega: float) -> None:
        """Refuse a speed [rad/s] at which a hard line sits on omega_0 (ValueError)."""
        if k := self.sits_on(omega):
            raise ValueError(
                Sentence(
                    f"the line of order {k} sits on omega_0 = {self.omega_0:.6g} rad/s at omega = {{}}, "
                    f"where its forced amplitude is infinite at first order; use Resonance({k}, 1)",
                    Speed(omega),
                )
            )

    @property
    def copies(self) -> int:
        """Number of equal states that differ by whole periods of the forcing."""
        if self.resonance.ratio is None or not self.orders:
            return 1
        return int((self.resonance.ratio / math.gcd(*self.orders)).denominator)

    @property
    def base(self) -> int:
        """Turns of the common angle of all components in q turns of the base angle (in one without resonance)."""
        q = max(self.resonance.q, 1)
        return math.gcd(self.resonance.p, *(q * k for k in self.orders)) or 1

    @property
    def fast_place(self) -> int:
        """Multiple of the common angle on the fast angle; 0 without resonance."""
        return self.resonance.p // self.base

    @property
    def places(self) -> tuple[int, ...]:
        """Multiples of the common angle on the lines."""
        return tuple(max(self.resonance.q, 1) * k // self.base for k in self.orders)

    @property
    def top(self) -> int:
        """Largest of these multiples, 1 at least."""
        return max(self.fast_place, *self.places, 1)

    def points(self, least: int) -> int:
        """Sample points of the common period, at least so many, with each point's place in every copy and half.

        A mean that vanishes by symmetry then vanishes in the samples too, whatever kinks the law has.
        """
        part = 4 * self.copies
        return part * math.ceil(least / part)

    def forced(self, theta: Any) -> Any:
        """Forced motion F [rad] of the hard lines at base angles [rad]."""
        lines = zip(self.orders, self.hard, strict=True)
        return sum((abs(c) * np.cos(k * theta + np.angle(c)) for k, c in lines), 0.0 * theta)

    def forced_slope(self, theta: Reals) -> Any:
        """Derivative dF/dtheta [rad/rad] at base angles [rad]."""
        lines = zip(self.orders, self.hard, strict=True)
        return sum((-k * abs(c) * np.sin(k * theta + np.angle(c)) for k, c in lines), 0.0 * theta)

    def scales(self) -> list[float]:
        """Amplitudes [rad] that matter: forced, at resonance, off resonance, at the law's breakpoints."""
        f, detuning = np.abs(self.soft), np.abs(self.fast - self.omega_0)
        with np.errstate(all="ignore"):
            sizes = [
                f / self.omega_0**2,
                np.sum(np.abs(self.hard), axis=-1),
                f / (self.mu * self.omega_0),
                np.where(detuning > 1e-9 * self.omega_0, f / (2.0 * self.omega_0 * detuning), 0.0),
                np.array([abs(b - self.u0) for b in breakpoints_of(self.system.law)]),
            ]
            flat = np.concatenate([np.ravel(part) for part in sizes])
        return [float(s) for s in flat[(flat > 0.0) & (flat < math.inf)]] or [1.0]


def real_matrix(by_re: Any, by_im: Any) -> Floats:
    """Matrices (..., 2, 2) of a complex rate's derivatives to the real and the imaginary part of its argument."""
    matrix = np.empty((*np.shape(by_re), 2, 2))
    matrix[..., 0, 0], matrix[..., 0, 1] = by_re.real, by_im.real
    matrix[..., 1, 0], matrix[..., 1, 1] = by_re.imag, by_im.imag
    return matrix


def forcing_lines(system: Any) -> tuple[float, tuple[int, ...], Complexes, Complexes]:
    """Mean torque [N*m], orders and complex amplitudes of torque and kinematic error, from samples of one turn."""
    declared = all(not part or not lacking(part, "orders") for part in (system.excitation, system.error))
    highest = highest_order(system) if declared else 500
    n = 1 << math.ceil(math.log2(8 * highest + 64))
    theta = 2.0 * np.pi * np.arange(n) / n
    torque = np.fft.rfft(np.broadcast_to(system.excitation.torque(theta), n)) / n
    error = np.fft.rfft(np.broadcast_to(system.error.value(theta), n)) / n
    mean, torque, error = float(torque[0].real), 2.0 * torque[1:-1], 2.0 * error[1:-1]
    torques, errors = np.abs(torque), np.abs(error)
    largest = max(abs(mean), float(np.max(torques)))
    mean = mean if abs(mean) > SMALLEST_LINE * largest else 0.0
    alive = (torques > SMALLEST_LINE * largest) | (errors > SMALLEST_LINE * float(np.max(errors)))
    if declared:  # sampling a high order leaves a trace of rounding at every other one
        alive &= np.isin(np.arange(len(alive)) + 1, joint_orders(system.excitation, system.error))
    torque, error = np.where(alive, torque, 0.0), np.where(alive, error, 0.0)
    index = np.flatnonzero(alive | np.isin(np.arange(len(alive)) + 1, varied_orders(system)))
    return mean, tuple(int(k) + 1 for k in index), torque[index], error[index]


def active_orders(system: System) -> tuple[int, ...]:
    """Whole orders above 0 of the torque and the kinematic error whose amplitude is not 0."""
    return forcing_lines(system)[1]


def setting(system: Any, resonance: Resonance) -> Setting:
    """Find the operating point and the lines of a system.

    Raises
    ------
    ValueError
        If J or omega is not positive, if the stiffness at the operating point is negative, if it is 0 and no line
        drives the resonance, or if a hard line sits on omega_0.
    """
    for name in ("J", "omega"):
        if not 0.0 < getattr(system, name) < math.inf:
            raise ValueError(f"{name} = {getattr(system, name)!r} must be positive and finite for multiple scales")
    mean, orders, torque, error = forcing_lines(system)
    u0, *z0 = loaded_state(system.law, mean)
    _refuse_drift(system.law, mean, u0)
    if varies(system):
        torque = torque - pulling_lines(system, orders, float(system.law.torque(u0)))
    stiffness, on_fast = float(system.law.stiffness(u0)), np.array([resonance.ratio == k for k in orders], bool)
    gap = _gap(system.law, u0) if stiffness == 0.0 else None
    if gap is not None and not np.any(((torque != 0.0) | (error != 0.0))[on_fast]):
        raise ValueError(
            Sentence(
                f"{type(system.law).__name__} has no stiffness at the operating torsion {{}}: its frequency is that of "
                "the amplitude, and without omega_0 averaging serves only where a line of order k drives the motion, "
                "at Resonance(k, 1); use that, frequency_response or find_orbit, or add a mean torque",
                Angle(u0),
            )
        )
    if gap is None and not 0.0 < stiffness < math.inf:
        raise ValueError(
            Sentence(
                f"omega_0 is undefined: the stiffness of {type(system.law).__name__} is {stiffness:.6g} N*m/rad at the "
                "operating torsion {}; add a mean torque that brings it to a place with positive stiffness, or "
                "integrate",
                Angle(u0),
            )
        )
    omega_0 = math.sqrt(stiffness / system.J) if gap is None else float(resonance.ratio or 1) * system.omega
    blank = Setting(
        system, resonance, u0, omega_0, mean_damping(system) / system.J, orders, torque, error,
        on_fast, 0.0, 0.0, np.zeros(0, complex), 0j, mean, gap, reach(system.law, mean, u0),
    )  # fmt: skip
    blank.refuse_on_resonance(system.omega)
    s = blank.at(system.omega)
    _refuse_extremes(s, tuple(z0))
    return s


def _gap(law: Law, u0: float) -> float | None:
    """Torsion [rad] up to which a spring without stiffness at u0 has no torque; None where it does not push back."""
    edges = [abs(b - u0) for b in breakpoints_of(law)]
    beyond = 2.0 * max(edges, default=0.5)
    pushes = depends(law) == 1 and law.torque(u0 - beyond) < law.torque(u0) < law.torque(u0 + beyond)
    return min(edges, default=0.0) if pushes else None


def _refuse_drift(law: Law, mean: float, u0: float) -> None:
    """Refuse a mean torque that friction or memory alone holds (ValueError): a vibration lets it slip ever further."""
    if depends(law) > 1 and mean != 0.0 and not spring_stiffness(law, u0) > 0.0:
        raise ValueError(
            f"{type(law).__name__} holds the mean torque {mean:.6g} N*m by friction or memory alone, and under a "
            "vibration the torsion drifts without end; put a spring in parallel, or take no mean torque"
        )


def _refuse_extremes(s: Setting, z0: tuple[float, ...]) -> None:
    """Refuse what would overflow or exhaust the memory further on (ValueError): sizes, and a very high harmonic."""
    law, forced = s.system.law, float(np.sum(np.abs(s.hard)))
    sizes = {"omega_0 [rad/s]": s.omega_0, "omega [rad/s]": s.omega, "the forced amplitude [rad]": forced}
    sizes["the soft line over omega_0^2 [rad]"] = abs(s.soft) / s.omega_0**2
    for a in list(sizes.values())[2:]:
        if a > 0.0:
            pull = abs(float(torque_of(law, s.u0 + a, 0.0, z0)) - float(torque_of(law, s.u0, 0.0, z0)))
            sizes[f"the torque at {a:.3g} rad over its linear part"] = pull / (s.system.J * s.omega_0**2 * a)
    for name, size in sizes.items():
        if size != 0.0 and not (size <= LARGEST and (size >= SMALLEST or "torque" in name)):
            raise ValueError(
                f"{name} is {size:.3g}, outside the supported range; check the units of J, law, torque and omega"
            )
    if s.resonance.ratio is not None:
        p, q = s.resonance
        if s.top > HIGHEST:
            raise ValueError(
                f"the resonance {p}:{q} has the harmonic {s.top} of the common period of all lines; multiple scales "
                f"goes up to {HIGHEST}: take a lower p and q, or integrate"
            )
