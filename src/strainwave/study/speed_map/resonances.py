"""Resonances of a drive in its speed range, and their description by multiple scales.

An excitation line of order k resonates at k omega = omega_0 (primary), 3 k omega = omega_0 (superharmonic) and
k omega = 3 omega_0 (subharmonic); a law that is not odd about the operating point, for one under a mean torque, adds
2 k omega = omega_0 and k omega = 2 omega_0 (Nayfeh & Mook 1979, secs. 4.1-4.2).
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...base.law import is_spring
from ...base.protocols import lines_of
from ...base.results import Floats, SolveError
from ...drive.equation.gear_torque import no_multiple_scales
from ...model.excitation import KinematicError, NoError, mean_torque
from ...numerics.operating_point import loaded_state
from ...theory.resonance import Resonance
from ...theory.slow_flow.flow import slow_flow
from ...theory.slow_flow.results import Certificate, SlowResponse, SteadyState
from ...theory.slow_flow.setting import active_orders as active_orders

NAMES = {
    (1, 1): "primary",
    (3, 1): "superharmonic 3:1",
    (1, 3): "subharmonic 1:3",
    (2, 1): "superharmonic 2:1",
    (1, 2): "subharmonic 1:2",
}


@dataclass(frozen=True)
class OperatingPoint:
    """Equilibrium of the drive under its mean torque.

    Attributes
    ----------
    mean_torque : float
        Mean of the excitation [N*m, output side].
    x : float
        Static dynamic error [rad] under the mean torque.
    stiffness : float
        Small-signal stiffness T'(x) [N*m/rad].
    omega_0 : float
        Small-signal natural frequency [rad/s]; 0 where the law has no stiffness there (backlash).
    odd : bool
        Whether the law is odd about the operating point, so that no even terms arise.
    z : tuple of float
        Internal states of a law with memory that was loaded slowly from rest.
    """

    mean_torque: float
    x: float
    stiffness: float
    omega_0: float
    odd: bool
    z: tuple[float, ...] = ()

    @property
    def start(self) -> tuple[float, ...]:
        """State of the error equation at rest there."""
        return (self.x, 0.0, *self.z)


@dataclass(frozen=True, eq=False)
class Regime:
    """One resonance of one excitation line.

    Attributes
    ----------
    name : str
        "primary", "superharmonic 3:1", "subharmonic 1:3", "superharmonic 2:1" or "subharmonic 1:2".
    order : int
        Order of the excitation line on the base angle.
    resonance : Resonance
        p omega ~ q omega_0 on the base angle.
    omega : float
        Speed of the base angle [rad/s] at p omega = q omega_0, of small oscillations.
    inside : bool
        Whether that speed, or `place`, lies in the speed range.
    states : tuple of SteadyState
        Steady states of the slow flow there; empty where it does not apply.
    existence : str
        Existence condition with its numbers.
    certificate, first_at_peak : Certificate or None
        How far first order can be trusted at `omega`, and at the peak of its response curve; None where multiple scales
        does not apply, or there is no curve.
    at_peak : Certificate or None
        The same of `response` at its peak; its `order` is the order of the curve.
    response : SlowResponse or None
        Response curve near the resonance, for those inside the range: of first order where its certificate is valid at
        the peak, else of second order.
    backbone : (2, n) array or None
        Speed of the base angle [rad/s] and amplitude [rad] of the undamped, unforced motion up to the curve's peak.
    reason : str
        Why multiple scales does not apply, empty where it does.
    top : (float, float) or None
        Speed of the base angle [rad/s] and amplitude [rad] where the torsion's component near omega_0 is largest on
        the computed curve; None where that has no such maximum.
    """

    name: str
    order: int
    resonance: Resonance
    omega: float
    inside: bool
    states: tuple[SteadyState, ...] = ()
    existence: str = ""
    certificate: Certificate | None = None
    first_at_peak: Certificate | None = None
    at_peak: Certificate | None = None
    response: SlowResponse | None = None
    backbone: Floats | None = None
    reason: str = ""
    top: tuple[float, float] | None = None

    @property
    def place(self) -> float:
        """Speed [rad/s] to look at: where the curve is largest for a law that multiple scales does not describe."""
        return self.top[0] if self.reason and self.top is not None else self.omega

    @property
    def label(self) -> str:
        """Name with the order of the line, for tables and figures."""
        return f"{self.name}, order {self.order}"

    def band(self) -> tuple[float, float]:
        """Speeds [rad/s] between which the response curve stands above a twelfth of its peak, with a margin."""
        if self.response is None or not self.response.branches:
            return 0.95 * self.omega, 1.05 * self.omega
        omega = np.concatenate([branch.omega for branch in self.response.branches])
        amplitude = np.concatenate([branch.amplitude for branch in self.response.branches])
        high = omega[amplitude > self.response.peak[1] / 12.0]
        margin = 0.12 * float(np.ptp(high)) + 1e-5 * float(np.mean(high))
        low, top = float(np.min(high)) - margin, float(np.max(high)) + margin
        return max(low, float(np.min(omega))), min(top, float(np.max(omega)))


def equation_orders(equation: Any) -> tuple[float, ...]:
    """Orders that the error equation excites, those of two turns included."""
    lines = [line for line in lines_of(equation.error) if line.amplitude]
    slow = tuple(line.order for line in lines if line.order % 1)
    if slow:
        once = tuple(line for line in lines if not line.order % 1)
        equation = equation._replace(error=KinematicError(once) if once else NoError())
    return (*active_orders(equation), *slow)


def operating_point(system: Any) -> OperatingPoint:
    """Find the equilibrium under the mean torque; of a law with memory the one that a slow load from rest leads to.

    Raises
    ------
    SolveError
        If the law cannot carry the mean torque.
    """
    mean, law = mean_torque(system.excitation), system.law
    try:
        x, *z = loaded_state(law, mean)
    except ValueError as error:
        raise SolveError(str(error)) from None
    odd = _is_odd(system.law, x, mean) if is_spring(system) else mean == 0.0
    stiffness = float(system.law.stiffness(x))
    return OperatingPoint(mean, x, stiffness, math.sqrt(max(stiffness, 0.0) / system.J), odd, tuple(z))


def _is_odd(law: Any, x: float, mean: float) -> bool:
    """True if a spring is odd about its torsion x [rad] under the mean torque [N*m]."""
    steps = np.geomspace(1e-6, 1.0, 25) * max(abs(x), 1e-2)
    around = law.torque(x + steps) + law.torque(x - steps) - 2.0 * mean
    size = np.abs(law.torque(x + steps)) + np.abs(law.torque(x - steps)) + abs(mean) + 1e-300
    return bool(np.all(np.abs(around) <= 1e-9 * size))


def regimes(system: Any, point: OperatingPoint, speeds: tuple[float, float]) -> tuple[Regime, ...]:
    """List the resonances of every excitation line, those inside the speed range with their response curves.

    Parameters
    ----------
    system : Oscillator
        The error equation; its omega is not used.
    point : OperatingPoint
        Equilibrium under the mean torque.
    speeds : (float, float)
        Range of the base-angle speed [rad/s].

    Returns
    -------
    tuple of Regime
        By ascending speed, one per distinct p:q; a line's primary resonance wins over another line's harmonic
        at the same speed.
    """
    if point.omega_0 == 0.0:
        return ()
    kinds = [(1, 1), (3, 1), (1, 3)] + ([] if point.odd else [(2, 1), (1, 2)])
    by_resonance: dict[Resonance, Regime] = {}
    for p, q in kinds:
        for order in active_orders(system):
            resonance = Resonance.of((order * p, q))
            if resonance not in by_resonance:
                by_resonance[resonance] = _regime(system, point, speeds, NAMES[p, q], order, resonance)
    return tuple(sorted(by_resonance.values(), key=lambda regime: regime.omega))


def _regime(
    system: Any, point: OperatingPoint, speeds: tuple[float, float], name: str, order: int, resonance: Resonance
) -> Regime:
    omega = resonance.q * point.omega_0 / resonance.p
    inside = speeds[0] <= omega <= speeds[1]
    identity = (name, order, resonance, omega, inside)
    if reason := no_multiple_scales(system):
        return Regime(*identity, reason=reason)
    try:
        flow = slow_flow(system._replace(omega=omega), resonance)
        states = tuple(flow.steady_states())
        certificate = flow.certificate()
        response = _response(flow, omega) if inside and flow.mu > 0.0 and _worth(flow, name, omega, states) else None
        backbone = _backbone(flow, response)
        first_at_peak = at_peak = _at_peak(flow, response)
        if response is not None and at_peak is not None and not at_peak.valid:
            flow = slow_flow(system._replace(omega=omega), resonance, order=2)
            second = _response(flow, omega)
            response, at_peak = (second, _at_peak(flow, second)) if second.branches else (response, at_peak)
        existence = flow.existence
    except (ValueError, SolveError, ArithmeticError) as error:
        reason = str(error) or f"multiple scales stopped with {type(error).__name__}"
        return Regime(*identity, reason=reason)
    return Regime(*identity, states, existence, certificate, first_at_peak, at_peak, response, backbone)


def _at_peak(flow: Any, response: SlowResponse | None) -> Certificate | None:
    """The certificate of a response curve at its peak."""
    if response is None or not response.branches:
        return None
    system = flow.system._replace(omega=response.peak[0])
    certificate: Certificate = slow_flow(system, flow.resonance, order=flow.order).certificate(curve=True)
    return certificate


def _worth(flow: Any, name: str, omega: float, states: tuple[SteadyState, ...]) -> bool:
    """True if a curve can be expected: always at a primary resonance, else where a state exists at or just above it."""
    if name == "primary" or any(state.amplitude > 0.0 for state in states):
        return True
    return bool(slow_flow(flow.system._replace(omega=1.05 * omega), flow.resonance).exists())


def _response(flow: Any, omega: float) -> SlowResponse:
    """Response curve over a band that holds the peak, wherever the nonlinearity has moved it."""
    system, ratio = flow.system, float(flow.resonance.ratio)
    mu = system.B / system.J
    low, high = 0.95 * omega, 1.05 * omega
    push = abs(complex(flow.rates(0j)))
    if push == 0.0:
        high = 1.2 * omega
    else:
        # z' = 0 at the peak of the curve: mu a/2 is the push, to first order whatever the law (E4 at the vertex)
        top = float(flow.backbone(np.array([2.0 * push / mu]))[0]) / ratio
        margin = 0.3 * abs(top - omega) + 4.0 * mu / ratio
        low, high = max(0.2 * omega, min(omega, top) - margin), min(3.0 * omega, max(omega, top) + margin)
    response: SlowResponse = flow.response((low, high))
    return response


def _backbone(flow: Any, response: SlowResponse | None) -> Floats | None:
    """Backbone up to a tenth above the peak, as speeds of the base angle: the fast frequency Omega is (p/q) omega."""
    if response is None or not response.branches or not response.peak[1] > 0.0:
        return None
    amplitudes = np.linspace(0.0, 1.1 * response.peak[1], 81)[1:]
    return np.array([flow.backbone(amplitudes) / float(flow.resonance.ratio), amplitudes])
