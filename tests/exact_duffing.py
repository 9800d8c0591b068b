"""Duffing's equation exactly: its free and its elliptically forced undamped oscillation by Jacobi's elliptic functions.

With (c0, c1, c2, c3) the polynomial of the torsion law, J u'' + c0 + c1 u + c2 u^2 + c3 u^3 = tau.

*Free* (constant tau): energy gives u'^2 = (a - u)(u - b) Q(u) between the turning points a and b, with Q(u) =
[c1 + (2/3) c2 (u + a + b) + (c3/2)(u^2 + (a + b) u + a^2 + a b + b^2)]/J. From a at t = 0, with A^2 = Q(a) and
B^2 = Q(b), u = [a B (1 + cn) + b A (1 - cn)]/[B (1 + cn) + A (1 - cn)], cn = cn(sqrt(A B) t | m),
m = [c3 (a - b)^2/(2 J) - (A - B)^2]/(4 A B) (Byrd & Friedman 1971, Handbook of Elliptic Integrals, 259.00). That is
written for complex roots of Q; it holds for real ones too, where m may be negative. An odd law without mean torque has
b = -a and A = B: u = a cn(r t | m), r^2 = omega_0^2 (1 + alpha a^2), m = alpha a^2/(2 (1 + alpha a^2)).

*Forced*: cn'' = -(1 - 2 m) cn - 2 m cn^3 (DLMF 22.13.14), so u = a cn(r t | m) is exact for the torque P cn(r t | m):
2 m r^2 = c3 a^2/J and P/J = a [c1/J - r^2 (1 - 2 m)]. The idea is that of Hsu 1960, Quart. Appl. Math. 17, 393-407.

Jacobi's elliptic function cn with any parameter m < 1, the modulus squared, and its Fourier series.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import ellipe, ellipj, ellipk, ellipkm1

from strainwave.base.protocols import with_parts
from strainwave.base.quantities import number, numbers, positive_count
from strainwave.base.results import Floats
from strainwave.model.excitation import Harmonic, Harmonics, NoError
from strainwave.model.laws.springs import Cubic, Linear, Polynomial
from strainwave.model.oscillator import Oscillator
from strainwave.numerics.balance.rates import SAME
from strainwave.numerics.roots import bracketed_root

LEAST = 1e-6  # of 1 - m, and of 1/(1 - m): nearer to the limit a period is no longer right to ten digits
SAMPLES = 4096  # of a period, for the Fourier coefficients of a biased motion
ROUNDING = 1e-17  # of the largest line of a waveform


def cn_and_fall(z: Floats, m: float) -> tuple[Floats, Floats]:
    """cn(z | m) and -d cn/dz."""
    if m > 0.0:
        sn, cn, dn, _ = ellipj(z, m)
        return cn, sn * dn
    stretch = math.sqrt(1.0 - m)
    sn, cn, dn, _ = ellipj(z * stretch, -m / (1.0 - m))
    return cn / dn, sn / (stretch * dn * dn)


def nome(m: float) -> float:
    """Nome q = exp(-pi K(1 - m)/K(m)), negative where m is: q(m) = -q(-m/(1 - m)) (DLMF 22.2.1, 20.7.26)."""
    if m < 0.0:
        return -nome(-m / (1.0 - m))
    return math.exp(-math.pi * float(ellipkm1(m) / ellipk(m)))


def cn_lines(m: float, count: int) -> Floats:
    """Amplitudes (count,) of cos x, cos 3x, cos 5x ... in cn(2 K x/pi | m) (DLMF 22.11.2; 22.11.4 for m < 0)."""
    if m == 0.0:
        return np.asarray(np.eye(1, count)[0])
    q, n = nome(m), np.arange(count)
    return np.asarray(2.0 * math.pi / ellipk(m) * math.sqrt(q / m) * q**n / (1.0 + q ** (2 * n + 1)))


@dataclass(frozen=True, repr=False)
class DuffingOscillation:
    """An exact periodic motion of an undamped oscillator with a law up to the third power.

    Attributes
    ----------
    system : Oscillator
        Whose motion it is: with the frequency [rad/s] as `omega` and, where forced, the lines of P cn as excitation.
    start, turn : float
        Torsion [rad] at t = 0, where it rests, and half a period later. A forced one starts negative in antiphase.
    rate : float
        r [rad/s] of the elliptic functions' argument r t.
    m : float
        Their parameter, the modulus squared; 0 for a cosine, negative for a softening law.
    skew : float
        Ratio A/B of the turning points; 1 for a motion that is symmetric about 0.
    """

    system: Oscillator
    start: float
    turn: float
    rate: float
    m: float
    skew: float = 1.0

    def __str__(self) -> str:
        kind = "free" if isinstance(self.system.excitation, Harmonic) else "forced"
        return (
            f"Duffing oscillation, {kind}: from {self.start:.9g} to {self.turn:.9g} rad and back, "
            f"omega {self.omega:.9g} rad/s, m {self.m:.6g}"
        )

    __repr__ = __str__

    @property
    def omega(self) -> float:
        """Frequency [rad/s]: pi r/(2 K(m))."""
        return 0.5 * math.pi * self.rate / float(ellipk(self.m))

    @property
    def period(self) -> float:
        """Period [s]."""
        return 2.0 * math.pi / self.omega

    def torsion(self, t: ArrayLike) -> Any:
        """Torsion u [rad] at times t [s], in their shape."""
        c = cn_and_fall(self.rate * np.asarray(t, float), self.m)[0]
        near, far = 1.0 + c, self.skew * (1.0 - c)
        return (self.start * near + self.turn * far) / (near + far)

    def velocity(self, t: ArrayLike) -> Any:
        """Torsion rate u' [rad/s] at times t [s], in their shape."""
        c, fall = cn_and_fall(self.rate * np.asarray(t, float), self.m)
        total = 1.0 + c + self.skew * (1.0 - c)
        return 2.0 * self.skew * (self.turn - self.start) * self.rate * fall / (total * total)

    def coefficients(self, harmonics: int) -> Floats:
        """Fourier coefficients (2H+1,) of u [rad]: mean, cos 1, sin 1 (0), cos 2, ...; sums of lines in the nome of cn.

        A biased motion has no such series: its coefficients are trapezoid sums over 4096 points of a period.
        """
        h = positive_count("harmonics", harmonics, SAMPLES // 4)
        z = np.zeros(2 * h + 1)
        if self.skew == 1.0 and self.turn == -self.start:
            z[1::4] = self.start * cn_lines(self.m, (h + 1) // 2)
        else:
            lines = np.fft.rfft(self.torsion(self.period / SAMPLES * np.arange(SAMPLES))).real / SAMPLES
            z[0], z[1::2] = lines[0], 2.0 * lines[1 : h + 1]
        return z


def free(system: Any, release: float) -> DuffingOscillation:
    """Free undamped oscillation that is released from rest.

    Parameters
    ----------
    system : Oscillator
        Undamped, with a law `Linear`, `Cubic` or `Polynomial` up to the third power and a constant torque,
        `Harmonic(0.0, mean=...)`. Its `omega` is ignored.
    release : float
        Torsion [rad] at t = 0, where the velocity is 0.

    Raises
    ------
    TypeError, ValueError
        If the system has no closed form, or does not swing back from there: beyond the well of a softening law,
        |u| >= 1/sqrt(-alpha).

    References
    ----------
    Byrd & Friedman 1971, 259.00; DLMF 22.19(ii) for the odd law.
    """
    system, c = _undamped("free", system)
    a = number("release [rad]", release)
    if system.excitation.amplitude != 0.0:
        raise ValueError(f"free takes a constant torque, Harmonic(0.0, mean=...), not {system.excitation}")
    b = _turn(system.law, c, a)
    square = (
        c[1] + 2.0 / 3.0 * c[2] * (2.0 * x + y) + 0.5 * c[3] * (3.0 * x * x + 2.0 * x * y + y * y)
        for x, y in ((a, b), (b, a))
    )
    A, B = (math.sqrt(max(q, 0.0) / system.J) for q in square)
    m = (0.5 * c[3] / system.J * (a - b) ** 2 - (A - B) ** 2) / (4.0 * A * B) if A * B > 0.0 else 1.0
    if not LEAST < 1.0 - m < 1.0 / LEAST:
        raise ValueError(f"release is {a:g} rad, too near a saddle, which the motion never reaches; take another one")
    rate = math.sqrt(A * B)
    return DuffingOscillation(system._replace(omega=math.pi * rate / (2.0 * float(ellipk(m)))), a, b, rate, m, A / B)


def frequency(system: Any, releases: ArrayLike) -> Floats:
    """Frequencies (n,) [rad/s] of the oscillations that `free` gives for releases (n,) [rad]."""
    return np.array([free(system, float(a)).omega for a in numbers("releases [rad]", releases)])


def forced(system: Any) -> tuple[DuffingOscillation, ...]:
    """Steady motions a cn under an elliptic torque P cn of a given peak and frequency; each has its own waveform.

    Parameters
    ----------
    system : Oscillator
        Undamped, with an odd law `Linear`, `Cubic` or `Polynomial` up to the third power. Its excitation
        `Harmonic(P)`, P cos(omega t), gives way to P cn of the same peak and period, which each result's `system` has.

    Returns
    -------
    tuple of DuffingOscillation
        All of them, one or three, from the largest in phase to the largest in antiphase, which starts at a negative
        torsion; none for a linear law at its resonance.

    Raises
    ------
    TypeError, ValueError
        If the system has no such closed form, or the waveform comes too near its limit.

    References
    ----------
    DLMF 22.13.14; Hsu 1960.
    """
    system, (c0, c1, c2, c3) = _undamped("forced", system)
    if system.excitation[1:] != Harmonic(0.0)[1:]:
        raise ValueError(f"forced takes a cosine without phase and mean, Harmonic(P), not {system.excitation}")
    if c0 != 0.0 or c2 != 0.0:
        raise ValueError(f"forced takes an odd law, and {system.law} has even powers; leave them out")
    peak = number("excitation.amplitude [N*m]", system.excitation.amplitude, positive=True)
    omega = number("omega [rad/s]", system.omega, positive=True)
    k1, k3, wanted = c1 / system.J, c3 / system.J, peak / system.J
    if k3 == 0.0:
        a = wanted / (k1 - omega * omega) if k1 != omega * omega else 0.0
        return (_steady(system, peak, a, 0.0),) if a else ()
    curve = _Curve(k1, k3, omega)
    found = [(math.copysign(curve.amplitude(v), curve.stiffness(v)), curve.m(v)) for v in curve.states(wanted)]
    return tuple(_steady(system, peak, a, m) for a, m in sorted(found, reverse=True))


def _steady(system: Any, peak: float, a: float, m: float) -> DuffingOscillation:
    """Motion a cn of the system with P cn as its torque, whose lines stop at rounding."""
    count = 1 if m == 0.0 else 2 + math.ceil(math.log(ROUNDING) / math.log(abs(nome(m))))
    lines = tuple(Harmonic(peak * float(line), 2 * i + 1) for i, line in enumerate(cn_lines(m, count)))
    rate = 2.0 * float(ellipk(m)) * system.omega / math.pi
    return DuffingOscillation(system._replace(excitation=Harmonics(lines)), a, -a, rate, m)


class _Curve(NamedTuple):
    """Forced motions of one frequency [rad/s] over v, 1 - m = exp(-+v^2): 0 at rest; c1/J and c3/J are k1 and k3."""

    k1: float
    k3: float
    omega: float

    def m(self, v: float) -> float:
        return -math.expm1(-math.copysign(v * v, self.k3)) if v > 1e-100 else 0.0

    def amplitude(self, v: float) -> float:
        root = math.sqrt(abs(self.m(v))) if v > 1e-9 else v  # m = +-v^2 underflows
        return self._scale(v) * root * math.sqrt(2.0 / abs(self.k3))

    def stiffness(self, v: float) -> float:
        """P/(J a) = k1 - r^2 (1 - 2 m); one-sided in v, because K(m)^2 (1 - 2 m) falls with m."""
        return self.k1 - self._scale(v) ** 2 * (1.0 - 2.0 * self.m(v))

    def torque(self, v: float) -> float:
        """P/J [rad/s^2], positive in phase."""
        return self.amplitude(v) * self.stiffness(v)

    def growth(self, v: float) -> float:
        """Derivative of the torque times a positive number."""
        m, less = self.m(v), 1.0 - self.m(v)
        K, E, unit = float(ellipk(m)), float(ellipe(m)), 2.0 * self.omega / math.pi
        return self.stiffness(v) * E / (2.0 * less * K) - unit * unit * K * (E * (1.0 - 2.0 * m) / less - K)

    def states(self, wanted: float) -> list[float]:
        """Places v of every motion under a torque P/J."""
        zones, last = [1e-300], math.sqrt(-math.log(LEAST))
        if self.stiffness(0.0) * self.k3 < 0.0 < self.stiffness(last) * self.k3:
            free = _root(self.stiffness, 0.0, last)
            zones += [_root(self.growth, 0.0, free), free]
        zones.append(last)
        torques = [abs(self.torque(v)) for v in zones]
        if not torques[0] < wanted < torques[-1] or (len(zones) == 2 and self.stiffness(0.0) * self.k3 < 0.0):
            raise ValueError(
                f"a torque of {wanted:g} N*m per kg*m**2 at omega = {self.omega:g} rad/s needs elliptic functions of "
                f"1 - m outside {LEAST:g} .. {1.0 / LEAST:g}; take a higher omega or less torque"
            )
        ends = zip(zones, torques, zones[1:], torques[1:], strict=False)
        return [
            math.exp(_root(lambda x: abs(self.torque(math.exp(x))) - wanted, math.log(v), math.log(w)))
            for v, low, w, high in ends
            if (low - wanted) * (high - wanted) < 0.0
        ]

    def _scale(self, v: float) -> float:
        return 2.0 * self.omega / math.pi * float(ellipk(self.m(v)))


def _root(f: Callable[[float], float], a: float, b: float) -> float:
    return bracketed_root(f, a, b, xtol=1e-17)


def _undamped(verb: str, system: Any) -> tuple[Any, tuple[float, ...]]:
    """System, and c0 less the mean torque, c1, c2, c3 of its law; or a sentence on what has no closed form."""
    system = with_parts(verb, system, *SAME)
    c: tuple[float, ...] = ()
    # Compared by class: a user's subclass may change the torque.
    match system.law if type(system.law) in (Linear, Cubic, Polynomial) else None:
        case Linear(K=K):
            c = 0.0, K
        case Cubic(K=K, alpha=alpha):
            c = 0.0, K, 0.0, K * alpha
        case Polynomial(coefficients=powers):
            c = powers
    if not c or any(c[4:]):
        remedy = "backbone and find_orbit take every law"
        raise TypeError(f"{verb} takes Linear, Cubic or Polynomial up to the third power, not {system.law}; {remedy}")
    if system.B != 0.0:
        raise ValueError(f"B is {system.B:g} N*m*s/rad; elliptic functions solve the undamped equation: take B = 0")
    if not isinstance(system.error, NoError):
        raise ValueError(f"{verb} takes no kinematic error, not {system.error}; take NoError()")
    if not isinstance(system.excitation, Harmonic):
        raise TypeError(f"{verb} takes a Harmonic as excitation, not {type(system.excitation).__name__}")
    c0, c1, c2, c3 = (*c, 0.0, 0.0, 0.0)[:4]
    return system, (c0 - system.excitation.mean, c1, c2, c3)


def _turn(law: Any, c: tuple[float, ...], a: float) -> float:
    """The other turning point [rad] of a motion that rests at a, where the energy is the same again."""
    net = np.polynomial.Polynomial(c)
    if net(a) == 0.0:
        raise ValueError(f"release is {a:g} rad, where {law} is in equilibrium; take another one")
    # (V(u) - V(a))/(u - a): what the energy gains from a to u
    quotient = np.polynomial.Polynomial([sum(c[k] * a ** (k - i) / (k + 1) for k in range(i, 4)) for i in range(4)])
    turns = [u for u in _real_roots(quotient) if u != a and (a > u) == (net(a) > 0.0)]
    if not turns:
        rests, slope = _real_roots(net), net.deriv()
        saddles = ", ".join(f"{u:.6g}" for u in rests if slope(u) < 0.0)
        held = any(slope(u) > 0.0 for u in rests)
        remedy = f"a release of less energy than at the saddles, {saddles} rad" if held else "a law with a well"
        raise ValueError(f"{law} released at {a:g} rad does not swing back; take {remedy}")
    b = min(turns, key=lambda u: abs(u - a))
    return -a if c[0] == c[2] == 0.0 and math.isclose(b, -a, rel_tol=1e-9) else b


def _real_roots(polynomial: Any) -> list[float]:
    """Real roots, each with a last step of Newton's method where there is one."""
    roots, slope = polynomial.trim().roots(), polynomial.deriv()
    return [float(u - polynomial(u) / (slope(u) or math.inf)) for u in roots[np.isreal(roots)].real]
