"""The article's Tables 3 and 4 computed again: its formulas as printed and corrected (E1 to E11: errata), integration.

The article's derived quantities do not follow from its own Table 3, so there are three sets: "derived" takes Table 3
(`HDC_40_050` with a motor torque of 10 N*m) at its word, "alpha 1" is the same with the cubic terms as the article
prints them, without alpha (E2), and "printed" takes the printed mu and omega_0 instead.
"""

import math
from collections.abc import Callable
from dataclasses import asdict, dataclass
from decimal import Decimal
from typing import Any, Literal, NamedTuple

import numpy as np

from ..base.results import Floats, Trajectory
from ..base.series import largest_of_samples
from ..base.terminal import silent
from ..model.drive import HDC_40_050
from ..model.excitation import Harmonic
from ..model.laws.springs import Cubic
from ..model.oscillator import Oscillator
from ..numerics.integration.simulate import simulate
from ..numerics.steady import SteadyMotion, settle
from .resonance import NONRESONANT, PRIMARY, SUBHARMONIC, SUPERHARMONIC, Resonance
from .slow_flow.flow import SlowFlow, slow_flow
from .slow_flow.results import SlowResponse

SAMPLES = 512  # of a turn of the fastest component

FORMS = (  # place, what, as printed, correct, number of the erratum
    ("error equation", "F(t)", "(T_m J_l − T_l J_m)/(N J_m J_l)", "T_m/(N J_m) − T_l/J_l", "E1"),
    ("cases 1 to 4", "ω₀a², ω₀C², ω₀C³", "without α", "each with α", "E2"),
    ("case 1", "β′", "3/8 ω₀a² + 3/4 ω₀C²", "αω₀(3/8 a² + 3/4 C²)", "E3"),
    ("case 1", "x(t)", "a₀ exp(−μt/2) cos(ω₀t + β₀) + C cos ωt", "β₀ + ∫β′dt in place of β₀", "E10"),
    ("case 2", "response", "μ²/4 + (σ − 3/8 ω₀C²)² = f²/(4ω₀²C²)", "α before ω₀, a for C; f = A", "E4"),
    ("case 2", "x(t)", "a cos(ω₀t − φ)", "a cos(ωt − φ)", "E9"),
    ("case 3", "response", "right side (ω₀C³/8)²", "right side (αω₀C³/8)²", "E5"),
    ("case 4", "response", "(σ − 9/8 ω₀C² − 9/4 ω₀²a²)²", "(σ − 9/4 αω₀C² − 9/8 αω₀a²)²", "E6"),
    ("stability", "global", "for α > 0", "for α ≥ 0; for α < 0 inside the saddles ±1/√|α|", "E7"),
    ("stability", "stable focus", "always", "for μ < 2ω₀, a node beyond", "E11"),
    ("Table 1", "f(x) = x + αx³", "dimensionless", "rad", "E11"),
)


def without_alpha(system: Oscillator) -> Oscillator:
    """The system whose slow flow is the one that the article prints in cases 1 to 3, cubic terms without alpha (E2)."""
    return system._replace(law=system.law._replace(alpha=1.0))


def _numbers(system: Oscillator) -> tuple[float, float, float]:
    """The article's omega_0 [rad/s], mu [1/s] and C [rad]."""
    omega_0, mu = math.sqrt(system.law.K / system.J), system.B / system.J
    return omega_0, mu, system.excitation.amplitude / system.J / (omega_0**2 - system.omega**2)


def printed_x(system: Oscillator, t: Floats) -> Floats:
    """Motion x(t) [rad] from rest, case 1 as printed: a0 exp(-mu t/2) cos(omega_0 t + beta_0) + C cos(omega t)."""
    omega_0, mu, C = _numbers(system)
    z = complex(-C, 0.5 * mu * C / omega_0)  # a0 exp(i beta_0), by x = x' = 0 at time 0
    free = (z * np.exp((-0.5 * mu + 1j * omega_0) * t)).real
    return np.asarray(free + C * np.cos(system.omega * t))


def printed_steady(system: Oscillator, resonance: Resonance) -> tuple[float | None, float | None]:
    """Steady a [rad] by the printed response equation, and the largest |x| [rad]; None where it gives none.

    Case 4 (E6): 9/4 mu^2 + (sigma - 9/8 omega_0 C^2 - 9/4 omega_0^2 a^2)^2 = (9/8 omega_0 C a)^2. The phase between its
    components is not printed.
    """
    if resonance != SUBHARMONIC:
        return steady(slow_flow(without_alpha(system), resonance))
    omega_0, mu, C = _numbers(system)
    shifted, slope = system.omega - 3.0 * omega_0 - 1.125 * omega_0 * C**2, 2.25 * omega_0**2
    linear = 2.0 * shifted * slope + (1.125 * omega_0 * C) ** 2
    squares = np.roots([slope**2, -linear, shifted**2 + 2.25 * mu**2])
    sizes = [math.sqrt(square.real) for square in squares if square.imag == 0.0 < square.real]
    return (max(sizes), None) if sizes else (None, abs(C))


def steady(flow: SlowFlow) -> tuple[float, float]:
    """Largest steady a [rad] of a slow flow, and the largest |x| [rad] of its motion."""
    state, (p, q) = flow.steady_states()[0], flow.resonance
    turn = 2.0 * math.pi * max(q, 1) / flow.system.omega
    return state.amplitude, largest(flow.steady_x(state.z, np.linspace(0.0, turn, SAMPLES * max(p, q, 1), False)))


def largest(x: Floats) -> float:
    """Largest |x| of equidistant samples, at a crest between them."""
    return float(largest_of_samples(x[None])[0])


MOTOR_TORQUE = 10.0  # N*m, Table 3
ALPHA = 0.1  # 1/rad^2, Table 3 ("assumed")
PRINTED_MU, PRINTED_OMEGA_0 = 0.129, 37.2  # 1/s and rad/s, text under Table 3
AMPLITUDE = MOTOR_TORQUE / (HDC_40_050.N * HDC_40_050.J_m)  # A of Table 3 [rad/s^2]

PER_CYCLE = 64  # samples per fastest cycle: the peak between samples is then right to 1e-6
LONG, SHORT = 30.0, 5.0  # windows of the largest |x| and of the RMS difference, in units of 1/mu
STRONG = 400.0  # times the torque, with which a steady subharmonic motion exists

FOLLOWS = "follows from omega_0; the printed 37.2 rad/s and 5.92 Hz agree with each other only (N2)"
MULTIPLE = "the speed of the case is a multiple of omega_0, 385.545 rad/s (N2)"
BEYOND = "the article has only first-order results"
AS_PRINTED = ", formula as printed"
CASE_1_ALONE = "the article prints x(t) from rest for case 1 only, and the steady motion for the other cases"

CLAIMS = {  # of a case and a harmonic: what the article says, what to say of it, and the share of omega that it takes
    ("superharmonic", 3.0): (
        "dominating", "the component at 3 omega is {:.2g} % of that at omega, not dominating (N6)", 1.0,
    ),
    ("subharmonic", 1 / 3): (
        "a steady component",
        "no steady subharmonic exists at this amplitude; the beats come from the decaying free vibration (N7)", 1e-3,
    ),
}  # fmt: skip
GIVEN = "the article's own frequency"
CONSTANT = "the printed x(t) has a constant beta_0, in contradiction to the printed beta' (E10)"
NO_NUMBER = "the article gives no number"
AT_ONE = "0.15 rad is the steady motion with alpha = 1 (E2), 0.1505, and omega_0 near 385 rad/s as in N4 (N5)"
NEARER = "the corrected first order is more accurate than the article claims; the printed formulas lack alpha (E2)"
TOO_LARGE = "with the printed mu and omega_0 the response is too large for first order"
NEAR = ("", "omega", "3 omega", "omega/3")  # of each case, the component near omega_0

Verdict = Literal["reproduced", "not reproducible", "not printed", "given"]


class Case(NamedTuple):
    """One row of Table 4: its regime, omega over omega_0 (0: the fixed 10.47 rad/s) and the printed numbers."""

    name: str
    resonance: Resonance
    multiple: float
    omega: str
    numerical: str
    analytical: str
    rms: str


CASES = (
    Case("non-resonant", NONRESONANT, 0.0, "10.47", "4.8e-3", "4.7e-3", "2.1"),
    Case("primary", PRIMARY, 1.0, "37.2", "0.15", "0.14", "4.8"),
    Case("superharmonic", SUPERHARMONIC, 1 / 3, "12.4", "0.08", "0.077", "3.5"),
    Case("subharmonic", SUBHARMONIC, 3.0, "111.6", "0.06", "0.058", "4.2"),
)


@dataclass(frozen=True)
class Cell:
    """One compared number.

    Attributes
    ----------
    table, case, parameters, quantity, unit : str
        Place in the article: "Table 3" or "Table 4", the regime, the parameter set, the quantity and its unit.
    value : float or None
        Computed value in `unit`; None where there is none, `why` then says why.
    printed : float or str or None
        Value that the article prints (a number in `unit`, or a claim in words), or None.
    verdict : str
        "reproduced", "not reproducible", "not printed" (no number, or no formula), or "given": an input of the run.
    why : str
        One sentence.
    """

    table: str
    case: str
    parameters: str
    quantity: str
    unit: str
    value: float | None
    printed: float | str | None
    verdict: Verdict
    why: str


class Run(NamedTuple):
    """A case from rest over 0 to 5/mu: its system, times [s], x [rad] by both methods, and their RMS difference [%]."""

    case: Case
    system: Oscillator
    t: Floats
    integration: Floats
    multiple_scales: Floats
    rms: float


@dataclass(frozen=True, eq=False)
class Reproduction:
    """All compared cells of the article's Tables 3 and 4.

    Attributes
    ----------
    cells : tuple of Cell
        In the order of the tables.
    runs : tuple of Run
        The four cases of the derived set in time.
    rule : str
        Condition under which a printed number counts as reproduced.
    """

    cells: tuple[Cell, ...]
    runs: tuple[Run, ...]
    rule: str = "reproduced: agrees within half the last printed digit; all amplitudes are 0-to-peak"

    def as_dict(self) -> dict[str, Any]:
        """Plain data for JSON; every number is finite or None."""
        return {"rule": self.rule, "cells": [asdict(cell) for cell in self.cells]}


def derived_system(omega: float = 1.0) -> Oscillator:
    """The article's drive from its Table 3, T_m = 10 N*m cos(omega t): mu 0.352928 1/s, omega_0 385.545 rad/s."""
    return HDC_40_050.error_equation(motor_torque=Harmonic(MOTOR_TORQUE), omega=omega)


def printed_system(omega: float = 1.0) -> Oscillator:
    """The article's printed mu and omega_0 per unit of inertia, with the amplitude A that Table 3 gives (ERRATA N3)."""
    return Oscillator(1.0, PRINTED_MU, Cubic(PRINTED_OMEGA_0**2, ALPHA), Harmonic(AMPLITUDE), omega)


def reproduce(*, progress: Callable[[str, float], None] = silent) -> Reproduction:
    """Compute the article's Tables 3 and 4, with mu and omega_0 derived and printed, and with alpha = 1.

    Parameters
    ----------
    progress : callable
        Called with the case and the share that is computed.

    Returns
    -------
    Reproduction
        Cells with the computed value, the printed one, a verdict and its reason.

    References
    ----------
    The article's Tables 3 and 4, and the errata list of the documentation (E1-E11, N1-N7).
    """
    cells, runs = _table_3(), list[Run]()
    derived = derived_system()
    systems = (("derived", derived), ("alpha 1", without_alpha(derived)), ("printed", printed_system()))
    rows = [(*both, case) for both in systems for case in CASES]
    for i, (parameters, system, case) in enumerate(rows):
        progress(f"{case.name}, {parameters} parameters", i / len(rows))
        row, run = _row(parameters, system, case)
        cells += row
        runs += [run] if parameters == "derived" else []
    return Reproduction(tuple(cells), tuple(runs))


def curves() -> list[tuple[SlowFlow, SlowResponse]]:
    """Slow flows of cases 2 to 4 of the derived set, the last one forced harder, and their states over omega."""
    drive, traced = HDC_40_050, []
    wide, least = 0.375 * ALPHA * AMPLITUDE**2 / (drive.mu**2 * drive.omega_0), math.sqrt(15.75) * drive.mu
    bands = (  # of sigma: around its value at the peak, a narrow peak, from the least of existence
        (PRIMARY, 1.0, (-0.5 * wide, 1.7 * wide)),
        (SUPERHARMONIC, 1.0, (-10.0 * drive.mu, 10.0 * drive.mu)),
        (SUBHARMONIC, STRONG, (0.1 * least, 10.0 * least)),
    )
    for resonance, torque, band in bands:
        p, q = resonance
        low, high = ((q * drive.omega_0 + sigma) / p for sigma in band)
        forcing = Harmonic(torque * MOTOR_TORQUE)
        flow = slow_flow(drive.error_equation(motor_torque=forcing, omega=0.5 * (low + high)), resonance)
        traced.append((flow, flow.response((low, high))))
    return traced


def _table_3() -> list[Cell]:
    drive, labels = HDC_40_050, ("Table 3", "", "derived")
    rows = (
        ("mu", "1/s", drive.mu, "0.129", "B/J of Table 3 is 2.7 times the printed value (N1)"),
        ("omega_0", "rad/s", drive.omega_0, "37.2", "sqrt(K/J) of Table 3 is 10.4 times the printed value (N2)"),
        ("omega_0 as a frequency", "Hz", drive.omega_0 / (2.0 * math.pi), "5.92", FOLLOWS),
    )
    fact = "A = T_m/(N J_m) from Table 3 does not depend on the frequency (N3)"
    none = "static error A/omega_0^2; the article gives no value (N3)"
    return [
        *(_compared(labels, name, unit, value, text, reason) for name, unit, value, text, reason in rows),
        Cell(*labels, "A", "rad/s^2", AMPLITUDE, "varies with omega", "not reproducible", fact),
        Cell(*labels, "static error", "rad", AMPLITUDE / drive.omega_0**2, None, "not printed", none),
    ]


def _compared(
    labels: tuple[str, str, str], quantity: str, unit: str, value: float | None, printed: str | None, reason: str
) -> Cell:
    """Apply the rule to one number."""
    number = None if printed is None else float(printed)
    verdict: Verdict = "not printed"
    if value is not None and printed is not None and number is not None:
        half_digit = 0.5 * 10.0 ** int(Decimal(printed).as_tuple().exponent)
        verdict = "reproduced" if abs(value - number) <= half_digit * (1.0 + 1e-9) else "not reproducible"
    return Cell(*labels, quantity, unit, value, number, verdict, reason)


def _row(parameters: str, system: Oscillator, case: Case) -> tuple[list[Cell], Run]:
    """Compute the cells of one case, maxima from rest, their difference and the steady motion, and its run."""
    omega_0, mu = math.sqrt(system.law.K / system.J), system.B / system.J
    omega = float(case.omega)
    system = system._replace(omega=case.multiple * omega_0 or omega)
    labels = ("Table 4", case.name, parameters)
    run = _from_rest(system)
    window = run.t <= SHORT / mu
    exact = run.y[0, window]

    def rms(x: Floats) -> float:
        return 100.0 * math.sqrt(float(np.mean((x[window] - exact) ** 2)) / float(np.mean(exact**2)))

    first, second = (slow_flow(system, case.resonance, order=order).x(run.t, (0.0, 0.0)) for order in (1, 2))
    printed = printed_x(system, run.t) if case.resonance == NONRESONANT else None
    settled = settle(system, (0.0, 0.0), time=LONG / mu, period=case.resonance.q or 1)
    a, peak = steady(slow_flow(system, case.resonance))
    printed_a, printed_peak = printed_steady(system, case.resonance)
    from_rest, printed_rms, alone = None, None, CASE_1_ALONE
    if printed is not None:
        from_rest, printed_rms, alone = largest(printed), rms(printed), ""
    as_given = abs(system.omega / omega - 1.0) < 1e-9
    reason, difference = _why(parameters, case), _why_rms(parameters, case, rms(first))
    component = NEAR[CASES.index(case)]
    name = f"steady amplitude at {component}"
    certificate = slow_flow(system, case.resonance, order=2).certificate()
    worth = f"second order is certified {'valid' if certificate.valid else 'not valid'} for the steady motion here"
    rows: tuple[tuple[str, str, float | None, str | None, str], ...] = (
        ("largest |x|, integration", "rad", run.peak(), case.numerical, reason),
        ("largest |x|, multiple scales", "rad", largest(first), case.analytical, reason),
        ("largest |x|" + AS_PRINTED, "rad", from_rest, case.analytical, alone or reason),
        ("normalised RMS difference", "%", rms(first), case.rms, difference),
        ("normalised RMS difference" + AS_PRINTED, "%", printed_rms, case.rms, alone or CONSTANT),
        ("largest |x|, multiple scales of second order", "rad", largest(second), None, BEYOND),
        ("normalised RMS difference, second order", "%", rms(second), None, f"{BEYOND}; {worth}"),
        ("steady peak", "rad", settled.peak, case.numerical, reason),
        ("steady peak, multiple scales", "rad", peak, case.analytical, reason),
        ("steady peak" + AS_PRINTED, "rad", printed_peak, case.analytical, reason),
        (name + ", multiple scales", "rad", a, None, NO_NUMBER),
        (name + AS_PRINTED, "rad", printed_a, None, NO_NUMBER),
    )
    cells = [
        Cell(*labels, "omega", "rad/s", system.omega, omega, "given", GIVEN if as_given else MULTIPLE),
        *(_compared(labels, *row) for row in (rows if component else rows[:-2])),
        *_harmonics(labels, settled, case),
    ]
    return cells, Run(case, system, run.t[window], exact, first[window], rms(first))


def _from_rest(system: Oscillator) -> Trajectory:
    """The motion from rest to 30/mu by integration."""
    end, fastest = LONG * system.J / system.B, max(system.omega, math.sqrt(system.law.K / system.J))
    t = np.linspace(0.0, end, PER_CYCLE * math.ceil(end * fastest / (2.0 * math.pi)) + 1)
    return simulate(system, (0.0, 0.0), t)


def _harmonics(labels: tuple[str, str, str], settled: SteadyMotion, case: Case) -> list[Cell]:
    """Steady harmonics at omega, 3 omega and omega/3, by integration and shooting."""
    cells = []
    for quantity, k in (("omega", 1.0), ("3 omega", 3.0), ("omega/3", 1 / 3)):
        value = None if k < 1.0 and settled.period == 1 else settled.amplitude(k)
        claim, reason, least = CLAIMS.get((case.name, k), (None, NO_NUMBER, 0.0))
        verdict: Verdict = "not printed"
        if value is None:
            claim, reason = None, "the steady motion has the period of the forcing, so this component does not exist"
        elif claim is not None:
            share = value / settled.amplitude(1)
            verdict, reason = "reproduced" if share > least else "not reproducible", reason.format(100.0 * share)
        cells.append(Cell(*labels, f"steady amplitude at {quantity}", "rad", value, claim, verdict, reason))
    return cells


def _why(parameters: str, case: Case) -> str:
    """Reason in words when a printed maximum is not met (ERRATA N4, N5)."""
    if case.name == "non-resonant":
        if parameters == "printed":
            return "the printed mu and omega_0 give an error over 100 times larger; the authors did not use them (N4)"
        return "from rest within 6.0 %: the authors seem to have computed with an omega_0 near 385 rad/s (N4)"
    if case.name == "primary" and parameters != "printed":
        return AT_ONE
    return "the value follows neither from Table 3 nor from the printed mu and omega_0, with alpha = 0.1 or 1 (N5b)"


def _why_rms(parameters: str, case: Case, rms: float) -> str:
    """Reason in words when the printed RMS difference is not met (E2-E6)."""
    if rms < float(case.rms):
        return NEARER
    return TOO_LARGE if parameters == "printed" else "first order is less accurate here than the article claims"
