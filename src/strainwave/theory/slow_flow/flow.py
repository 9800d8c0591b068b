"""`slow_flow`: the slow flow of a resonance at first or second order, for any law.

It has steady states, transients, response curves, a certificate and a predictor.

Convention: the component near omega_0 is a cos((p/q) theta - phase) with the 0-to-peak amplitude a; z = a exp(-i
phase). The bookkeeping parameter epsilon is 1, so mu, detuning and forcing are the physical ones. Book: Nayfeh & Mook
1979, Nonlinear Oscillations, ch. 4.
"""

import math
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ...base.law import check_law, repeating
from ...base.protocols import System, with_parts
from ...base.quantities import array_of, complex_number, complex_numbers, interval, numbers, shown
from ...base.results import Floats, SolveError
from ...base.sentences import Sentence, Speed
from ..resonance import Resonance
from . import response as response_curve
from .averages.memory import remembers
from .averages.varying import parts_of, varies
from .averaging import averaged_flow
from .certificate import ORDINAL, certify
from .closed_forms import CubicFlow, free_decay, kind_of
from .fixed_points import Flow, is_stable, is_trivial
from .predictor.build import build_predictor
from .predictor.predictor import Predictor
from .results import Certificate, Evolution, SlowResponse, StatesAtSpeeds, SteadyState
from .second_order import Forms, SecondOrderFlow, second_order
from .setting import LARGEST, setting
from .states import attractor, fixed_points, states
from .transient import evolve, motion, times


@dataclass(frozen=True, eq=False)
class SlowFlow:
    """The slow flow of a system near one resonance; made by `slow_flow`.

    Attributes
    ----------
    system : Oscillator
        The system, at its own omega.
    resonance : Resonance
        In lowest terms.
    omega_0, mu, mean_torsion : float
        sqrt(T'(u0)/J) [rad/s], B/J [1/s], and the torsion u0 [rad] under the mean torque. Without stiffness at u0, as
        in a gap, omega_0 is the speed of the line that drives the motion.
    order : int
        1 or 2, the order of the expansion.
    closed_form : bool
        True if closed forms serve (cubic law, one forcing line; at second order any cubic polynomial); otherwise
        averaging integrals.
    """

    system: Any
    resonance: Resonance
    omega_0: float
    mu: float
    mean_torsion: float
    order: int
    closed_form: bool
    _flow: Flow = field(repr=False)

    def __str__(self) -> str:
        form = "closed forms" if self.closed_form else "averaging integrals"
        gap = self._flow.setting.gap
        frequency = f"omega_0 = {self.omega_0:.6g} rad/s" if gap is None else f"gap of {gap:.6g} rad to both sides"
        return (
            f"Slow flow of {self.resonance}, order {self.order}, by {form}: {frequency}, mu = {self.mu:.6g} 1/s, mean "
            f"torsion {self.mean_torsion:.6g} rad"
        )

    __repr__ = __str__

    @cached_property
    def _points(self) -> list[complex]:
        """Every nontrivial fixed point [rad]."""
        return fixed_points(self._flow)

    def rates(self, z: ArrayLike) -> Any:
        """Rate z' [rad/s, complex] of z = a exp(-i phase) [rad, complex; any shape].

        Without resonance the phase refers to omega_0 t, otherwise to (p/q) theta.

        Raises
        ------
        ValueError
            If z is not finite, or so large that its rate is not.
        """
        with np.errstate(all="ignore"):
            rate = self._flow.rates(complex_numbers("z [rad]", z))
        if not np.all(np.isfinite(rate)):
            raise ValueError(f"z [rad] is {shown(z)}, where the rate is not finite; give smaller amplitudes")
        return rate

    def steady_states(self) -> list[SteadyState]:
        """Every fixed point of the slow flow at the system's omega, by descending amplitude.

        a = 0 is listed where it is one. States that differ by whole periods of the forcing are one state, listed once.

        Raises
        ------
        SolveError
            If there is none, as without damping at a linear resonance.
        """
        roots = [SteadyState(abs(z), -math.atan2(z.imag, z.real) + 0.0, is_stable(self._flow, z)) for z in self._points]
        if is_trivial(self._flow):
            roots.append(SteadyState(0.0, 0.0, is_stable(self._flow, 0j)))
        if not roots:
            undamped = "without damping the amplitude grows without bound; give B"
            cause = undamped if self.mu <= 0.0 else "none was found; integrate"
            text, speed = "the slow flow ({}) has no steady state at omega = {}: {}", Speed(self.system.omega)
            raise SolveError(Sentence(text, self.resonance, speed, cause))
        return roots

    def states_at(self, omega: ArrayLike) -> StatesAtSpeeds:
        """Every fixed point of the slow flow at many speeds at once: what `steady_states` lists, for each of them.

        Parameters
        ----------
        omega : (n,) array_like
            Speeds [rad/s] of the base angle, positive, in any order. All are searched together; with friction or
            memory, or with hard lines at first order by averages, each is searched by itself.

        Raises
        ------
        ValueError
            If a speed is not positive and finite, or a hard line sits on omega_0 there.
        """
        speeds = numbers("omega [rad/s]", omega)
        if not np.all(speeds > 0.0):
            raise ValueError(f"omega [rad/s] is {shown(omega)}; every speed must be positive")
        for w in speeds.tolist():
            self._flow.setting.refuse_on_resonance(w)
        table = states(self._flow, speeds)
        finite = np.isfinite(table.z.T)
        z = table.z.T[finite]
        omega = np.repeat(speeds, np.sum(finite, axis=1))
        return StatesAtSpeeds(omega, np.abs(z), -np.angle(z) + 0.0, table.stable.T[finite])

    def exists(self) -> bool:
        """True if a steady state with a > 0 exists at the system's omega."""
        return len(self._points) > 0

    @property
    def existence(self) -> str:
        """Existence condition of steady states with a > 0, in one sentence with its numbers."""
        if isinstance(self._flow, CubicFlow):
            return self._flow.existence()
        if self._flow.setting.resonance.ratio is None:
            more = ", faster by the friction or memory of the law" if remembers(self.system.law) else ""
            return free_decay(self._flow.setting) + more
        amplitudes = ", ".join(f"{abs(z):.6g}" for z in self._points)
        verdict = (
            f"steady states exist with a = {amplitudes} rad" if amplitudes else "no steady state with a > 0 exists"
        )
        return (
            f"{verdict} at omega = {self.system.omega:.6g} rad/s ({self.resonance} of {type(self.system.law).__name__})"
        )

    def evolve(self, y0: ArrayLike, t: ArrayLike) -> Evolution:
        """Transient from a physical start.

        Parameters
        ----------
        y0 : (2,) array_like
            Dynamic error x [rad] and x' [rad/s] at t[0]; internal states are those of the settled loop at every time.
        t : float or (n,) array_like
            Increasing times [s], or an end time (from 0, with 32 samples per period of the fastest component).

        Raises
        ------
        ValueError
            If y0 is not two finite numbers, or t does not increase.
        SolveError
            If the slow flow has no start at y0, or leaves every finite amplitude; at second order below 0.5 omega_0.
        """
        start = numbers("y0 = (x [rad], x' [rad/s])", y0, count=2)
        return evolve(self._flow, (float(start[0]), float(start[1])), times(self._flow, t))

    def x(self, t: ArrayLike, y0: ArrayLike = (0.0, 0.0)) -> Floats:
        """Dynamic error x(t) [rad] of the transient that starts from y0 = (x, x') at time 0; default from rest.

        Parameters
        ----------
        t : float or (n,) array_like
            Increasing times [s], not negative. `evolve` says too whether the transient is valid.
        """
        asked, start = numbers("t [s]", t), numbers("y0 = (x [rad], x' [rad/s])", y0, count=2)
        if not asked[0] >= 0.0:
            raise ValueError(f"t is {shown(t)}; it must be increasing times from 0 on [s]")
        from_start = asked if asked[0] == 0.0 else np.concatenate([[0.0], asked])
        values = self.evolve(start, from_start).x if from_start.size > 1 else start[:1]
        return np.asarray(values[from_start.size - asked.size :].reshape(np.shape(t)))

    def steady_x(self, z: complex, t: ArrayLike) -> Floats:
        """Dynamic error x(t) [rad] of a steady z = a exp(-i phase) [rad] at times t [s]; base angle 0 at time 0.

        At second order with the small harmonics of the waveform: the mean, 2, 3, 5 times the fast angle, and so on.
        """
        asked = numbers("t [s]", np.ravel(t)).reshape(np.shape(t))
        with np.errstate(all="ignore"):
            x = motion(self._flow, complex_number("z [rad]", z), asked)
        if not np.all(np.isfinite(x)):
            raise ValueError(f"z is {shown(z)} rad, whose motion is not finite; give a smaller amplitude")
        return x

    def attractor(self, z: complex) -> complex | None:
        """Steady z [rad] on which a transient ends that has come to `z`; None where two are about equally near."""
        return attractor(self._flow, complex_number("z [rad]", z))

    def response(self, band: tuple[float, float]) -> SlowResponse:
        """Steady amplitude over a range of speeds of the base angle, with stability and jump frequencies.

        Parameters
        ----------
        band : (float, float)
            Lowest and highest omega [rad/s].

        Raises
        ------
        ValueError
            If the band is not two finite numbers with 0 < lo < hi.
        """
        lo, hi = interval("the band [rad/s]", band, positive=True)
        return response_curve.response(self._flow, lo, hi)

    def backbone(self, amplitudes: ArrayLike) -> Floats:
        """Frequency Omega(a) [rad/s] of the motion near omega_0 without damping and forcing.

        The excitation meets it at omega = q Omega/p. For the cubic law omega_0 (1 + 3/8 alpha a^2). Of friction and
        memory the equivalent stiffness of the loop counts, not its loss. Without stiffness at rest it is the root of
        the describing function over J, 0 inside a gap.

        Parameters
        ----------
        amplitudes : array_like
            a [rad], 0-to-peak, not negative.
        """
        a = array_of("amplitudes [rad]", amplitudes)
        if not np.all((a >= 0.0) & (a <= LARGEST)):
            raise ValueError(f"amplitudes [rad] are {shown(amplitudes)}; they must be from 0 to {LARGEST:g}")
        s = self._flow.setting
        pull = averaged_flow(s.unforced(), a.ravel().astype(complex)).mean_force(a).real
        share = np.divide(pull, a, out=np.zeros_like(a), where=a > 0.0)
        frequency = np.sqrt(2.0 * np.maximum(share, 0.0))
        return frequency if s.gap is not None else np.asarray(s.omega_0 + share / s.omega_0)

    def certificate(self, *, curve: bool = False) -> Certificate:
        """Errors of the steady state with the largest amplitude, from a harmonic correction of it.

        Parameters
        ----------
        curve : bool
            True for a state that is a point of a response curve, as its peak, which the true curve may have at another
            speed. Otherwise a state is valid only where a true one is near at its own speed.

        Raises
        ------
        SolveError
            If there is no steady state.
        """
        states = self.steady_states()
        return certify(self._flow, states[0].z, self.order, curve=curve)

    def predictor(
        self,
        sample: float | None = None,
        *,
        speeds: tuple[float, float] | None = None,
        amplitudes: tuple[float, float] = (0.0, 1.0),
    ) -> Predictor:
        """Make the slow flow ready for a controller: a small model whose `update` predicts the next sample.

        Formulas serve wherever this flow has them; every other law is sampled along its motion, which for a law with
        kinks is right to 1 % of the rates.

        Parameters
        ----------
        sample : float
            Time from one call to the next [s]. Default: 32 samples per period of the fastest component.
        speeds : (float, float)
            Lowest and highest speed of the base angle [rad/s]. Default: half and one and a half times the system's.
        amplitudes : (float, float)
            Lowest and highest factor on the torque lines of the excitation; the mean torque and the kinematic error
            keep theirs.

        Raises
        ------
        ValueError
            If the drive has no damping, no state of the range is valid, the sample is too long for the range, or the
            law cannot be sampled in bounded time: without resonance, and where the samples do not give the rates.
        """
        if self._flow.setting.gap is not None:
            raise ValueError(
                f"{type(self.system.law).__name__} has no stiffness at rest, and a predictor needs omega_0; give the "
                "drive a mean torque, or integrate"
            )
        if varies(self.system):
            raise ValueError("a predictor takes a constant stiffness and damping; give an Oscillator, or use evolve")
        return build_predictor(self._flow, self.order, sample, speeds, amplitudes)


def slow_flow(system: Any, resonance: Resonance, *, order: int = 1) -> SlowFlow:
    """Reduce a system to the slow flow of one resonance by multiple scales.

    Parameters
    ----------
    system : Oscillator or VaryingOscillator
        J x'' + B u' + T(u) = tau(theta), u = x - e(theta), theta = omega t; at first order also with a stiffness and
        a damping that vary, where order n of the stiffness meets 2 omega_0 at Resonance(n, 2). The law needs `torque`
        and `stiffness` on arrays; `breakpoints` help where it has some. One with friction or memory stands for its
        settled loop.
    resonance : Resonance
        p omega ~ q omega_0 on the base angle, or `NONRESONANT`. Lines with k q = p are soft, all others hard. A law
        without stiffness at rest, as a gap without preload, takes Resonance(k, 1) of a line of order k.
    order : int
        1: the modulation equations of first order. 2: those of second order, solved unexpanded, with the small
        harmonics of the waveform (the mean, 3 omega, 5 omega, ...) and the exact damping and detuning of the linear
        drive.

    Returns
    -------
    SlowFlow
        `steady_states()` and `response((lo, hi))`: amplitudes [rad, 0-to-peak] near omega_0; `x(t)` [rad];
        `certificate()` says how wrong they are. First order: closed forms for the cubic law under one line
        without mean torque, averaging integrals for everything else. Second order: formulas for any cubic
        polynomial under one line, samples for everything else. A law with friction or memory is averaged along
        its closed loops at both orders: `stiffness(x)` at rest gives omega_0, and what yields or slips is in
        the averages.

    Raises
    ------
    ValueError
        If omega_0 is undefined and no line drives the resonance, a hard line sits on omega_0, the resonance does not
        appear at first order, or `order` is neither 1 nor 2; for friction or memory also under a forcing without
        resonance, and where nothing else holds the mean torque.



    References
    ----------
    Nayfeh & Mook 1979, Nonlinear Oscillations, secs. 2.3.3 and 4.1.1-4.1.4.
    """
    if order not in (1, 2):
        raise ValueError(f"order is {shown(order)}; multiple scales are there at first and second order: give 1 or 2")
    resonance = Resonance.of(resonance)
    system = repeating("slow_flow", with_parts("slow_flow", system, *parts_of(system)))
    check_law("law", system.law)
    order = int(order)
    flow = _flow(system, resonance, order)
    s = flow.setting
    if s.resonance.ratio is not None and not flow.phase_matters():
        raise ValueError(_absent(flow, order))
    closed = isinstance(flow.force, Forms) if isinstance(flow, SecondOrderFlow) else isinstance(flow, CubicFlow)
    return SlowFlow(system, resonance, s.omega_0, s.mu, s.u0, order, closed, flow)


def _flow(system: System, resonance: Resonance, order: int) -> Flow:
    s = setting(system, resonance)
    if order == 2 and varies(system):
        raise ValueError("a stiffness and a damping that vary have a slow flow of first order; give order=1")
    if order == 2:
        return second_order(s)
    kind = None if varies(system) else kind_of(s)
    return CubicFlow(s, kind) if kind is not None else averaged_flow(s)


def _absent(flow: Flow, order: int) -> str:
    """Sentence that refuses a resonance which first order does not know, with those that it does."""
    s = flow.setting
    p, q = s.resonance
    fact = (
        f"the {p}:{q} resonance does not appear at {ORDINAL[order]} order for this law ({type(s.system.law).__name__})"
    )
    if not s.orders:
        return f"{fact}: the excitation has no line; use NONRESONANT for the free vibration"
    available = []
    for p, q in {(k * m, n): None for k in s.orders[:3] for m, n in ((1, 1), (2, 1), (3, 1), (1, 2), (1, 3))}:
        candidate = Resonance.of((p, q))
        at_exact = s.system._replace(omega=s.omega_0 * q / p)
        if candidate not in available and _flow(at_exact, candidate, order).phase_matters():
            available.append(candidate)
    names = ", ".join(f"Resonance({r.p}, {r.q})" for r in available) or "none with p, q up to 3"
    return (
        f"{fact}: with lines of order {', '.join(map(str, s.orders))} the averaging integral does not depend on the "
        f"phase; {ORDINAL[order]} order knows {names}; use one of them or NONRESONANT, or integrate"
    )
