"""Resonances of a drive in its speed range, and their description by multiple scales.

An excitation line of order k resonates at k omega = omega_0 (primary), 3 k omega = omega_0 (superharmonic) and
k omega = 3 omega_0 (subharmonic); a law that is not odd about the operating point, for one under a mean torque, adds
2 k omega = omega_0 and k omega = 2 omega_0 (Nayfeh & Mook 1979, secs. 4.1-4.2).
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ...base.results import Floats, SolveError
from ...drive.drive_response import DriveResponse
from ...drive.equation.gear_torque import no_multiple_scales
from ...theory.resonance import Resonance
from ...theory.slow_flow.flow import slow_flow
from ...theory.slow_flow.results import Certificate, SlowResponse, SteadyState
from ...theory.slow_flow.setting import active_orders
from ..speed_map.error_equation import OperatingPoint
from ..speed_map.size_curve import HALF_POWER

FEWEST_POINTS = 20  # points of the curve in the band of a resonance
PEAK_DISTANCE = 1.6  # relative distance of the maximum from the speed of small oscillations
FAINT_SHARE = 1e-4  # of the largest |x|: a smaller component is no resonance to place

NAMES = {
    (1, 1): "primary",
    (3, 1): "superharmonic 3:1",
    (1, 3): "subharmonic 1:3",
    (2, 1): "superharmonic 2:1",
    (1, 2): "subharmonic 1:2",
}


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
        curved = inside and flow.mu > 0.0 and _has_curve(flow, name, omega, states)
        response = _response(flow, omega) if curved else None
        backbone = _backbone(flow, response)
        first_at_peak = at_peak = _certificate_at_peak(flow, response)
        if response is not None and at_peak is not None and not at_peak.valid:
            flow = slow_flow(system._replace(omega=omega), resonance, order=2)
            second = _response(flow, omega)
            response, at_peak = (second, _certificate_at_peak(flow, second)) if second.branches else (response, at_peak)
        existence = flow.existence
    except (ValueError, SolveError, ArithmeticError) as error:
        reason = str(error) or f"multiple scales stopped with {type(error).__name__}"
        return Regime(*identity, reason=reason)
    return Regime(*identity, states, existence, certificate, first_at_peak, at_peak, response, backbone)


def _certificate_at_peak(flow: Any, response: SlowResponse | None) -> Certificate | None:
    """How far a response curve can be trusted at its peak; None without a curve."""
    if response is None or not response.branches:
        return None
    system = flow.system._replace(omega=response.peak[0])
    certificate: Certificate = slow_flow(system, flow.resonance, order=flow.order).certificate(curve=True)
    return certificate


def _has_curve(flow: Any, name: str, omega: float, states: tuple[SteadyState, ...]) -> bool:
    """True if a curve is likely: always at a primary resonance, else where a state exists at or just above it."""
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


def with_tops(
    all_regimes: tuple[Regime, ...], system: Any, exact: DriveResponse, close: dict[Resonance, DriveResponse]
) -> tuple[Regime, ...]:
    """Add to every resonance p:1 its maximum on the computed curve, or on the one drawn for it alone.

    Looked for between the neighbouring resonances, where a slow run-up or run-down goes; an end of the range is none,
    nor is what lies in the half-power band of a larger maximum of another component.
    """
    omegas = sorted(regime.omega for regime in all_regimes if regime.resonance.q == 1)
    rows = [(regime, close.get(regime.resonance, exact)) for regime in all_regimes]
    tops = [_crest_of(r, omegas, system, curve) if r.resonance.q == 1 else None for r, curve in rows]
    largest = {r.resonance.p: top[1] for r, top in zip(all_regimes, tops, strict=True) if top is not None}
    topped = []
    for (regime, response), top in zip(rows, tops, strict=True):
        crest = None
        if top is not None and not _is_of_larger_component(regime.resonance.p, top, largest, system, response):
            crest = float(response.omega[top[0]]), top[1]
        met = crest is not None and bool(regime.reason)  # the curve is in the range, and such a law is placed by it
        topped.append(replace(regime, top=crest, inside=regime.inside or met))
    return tuple(topped)


def _is_of_larger_component(
    p: int, top: tuple[int, float], largest: dict[int, float], system: Any, response: DriveResponse
) -> bool:
    """True if a maximum of component p lies in the half-power band of another component, which is larger there."""
    others = ((response.torsion_amplitude(system, q)[top[0]], size) for q, size in largest.items() if q != p)
    return any(component > top[1] and component >= HALF_POWER * size for component, size in others)


def _crest_of(regime: Regime, places: list[float], system: Any, response: DriveResponse) -> tuple[int, float] | None:
    """Point of the curve with the largest component of a resonance, and its amplitude [rad]."""
    i = places.index(regime.omega)
    low = max([regime.omega / PEAK_DISTANCE, *((w * regime.omega) ** 0.5 for w in places[:i])])
    high = min([regime.omega * PEAK_DISTANCE, *((w * regime.omega) ** 0.5 for w in places[i + 1 :])])
    visited = response.counted
    omega = response.omega[visited]
    inside = (omega >= low) & (omega <= high)
    if not np.any(inside):
        return None
    indices, omega = visited[inside], omega[inside]
    amplitude = response.torsion_amplitude(system, regime.resonance.p)[indices]
    top = int(np.argmax(amplitude))
    if not np.min(omega) < omega[top] < np.max(omega) or amplitude[top] < FAINT_SHARE * np.max(
        response.curve.peak[visited]
    ):
        return None
    return int(indices[top]), float(amplitude[top])


def is_narrow(regime: Regime, exact: DriveResponse) -> bool:
    """True if a resonance of the main branch has too few points of the response curve in its band."""
    if regime.response is None or not regime.response.branches or regime.resonance.q != 1:
        return False
    low, high = regime.band()
    return int(np.sum((exact.curve.omega > low) & (exact.curve.omega < high))) < FEWEST_POINTS
