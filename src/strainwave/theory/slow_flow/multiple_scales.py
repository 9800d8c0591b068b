"""Multiple scales of first and second order for any law: `slow_flow` makes the slow flow of a resonance."""

from numbers import Integral
from typing import Any

from ...base.law import check_law
from ...base.protocols import with_parts
from ...base.quantities import shown
from ...numerics.integration.corners import repeating
from .averaging import averaged_flow
from .certificate.certificate import ORDINAL
from .cubic import CubicFlow, kind_of
from .fixed_points import Flow
from .flow import SlowFlow
from .second_order import Forms, SecondOrderFlow, second_order
from .setting import Resonance, setting


def slow_flow(system: Any, resonance: Resonance, *, order: int = 1) -> SlowFlow:
    """Reduce a system to the slow flow of one resonance by multiple scales.

    Parameters
    ----------
    system : Oscillator
        J x'' + B u' + T(u) = tau(theta), u = x - e(theta), theta = omega t. The law needs `torque` and `stiffness` on
        arrays; `breakpoints` help where it has some. One with friction or memory stands for its settled loop.
    resonance : Resonance
        p omega ~ q omega_0 on the base angle, or `NONRESONANT`. Lines with k q = p are soft, all others hard.
    order : int
        1: the modulation equations of first order. 2: those of second order, solved unexpanded, with the small
        harmonics of the waveform (the mean, 3 omega, 5 omega, ...) and the exact damping and detuning of the linear
        drive.

    Returns
    -------
    SlowFlow
        First order: closed forms for the cubic law under one line without mean torque, averaging integrals for
        everything else. Second order: formulas for any cubic polynomial under one line, samples for everything else.
        A law with friction or memory is averaged along its closed loops at both orders: `stiffness(x)` at rest gives
        omega_0, and what yields or slips is in the averages.

    Raises
    ------
    ValueError
        If omega_0 is undefined, a hard line sits on omega_0, the resonance does not appear at first order, or `order`
        is neither 1 nor 2; for friction or memory also under a forcing without resonance, and where nothing else holds
        the mean torque.

    References
    ----------
    Nayfeh & Mook 1979, Nonlinear Oscillations, secs. 2.3.3 and 4.1.1-4.1.4.
    """
    if not isinstance(order, Integral) or isinstance(order, bool) or order not in (1, 2):
        raise ValueError(f"order is {shown(order)}; multiple scales are there at first and second order: give 1 or 2")
    if not (isinstance(resonance, tuple) and len(resonance) == 2):
        raise TypeError(f"resonance is {shown(resonance)}; it must be a Resonance(p, q) such as PRIMARY")
    resonance = Resonance(*resonance).checked()
    system = repeating("slow_flow", with_parts("slow_flow", system, "J", "B", "law", "excitation", "omega", "error"))
    check_law("law", system.law)
    order = int(order)
    flow = _flow(system, resonance, order)
    s = flow.setting
    if s.resonance.ratio is not None and not flow.phase_matters():
        raise ValueError(_absent(flow, order))
    closed = isinstance(flow.force, Forms) if isinstance(flow, SecondOrderFlow) else isinstance(flow, CubicFlow)
    return SlowFlow(system, resonance, s.omega_0, s.mu, s.u0, order, closed, flow)


def _flow(system: Any, resonance: Resonance, order: int) -> Flow:
    s = setting(system, resonance)
    if order == 2:
        return second_order(s)
    kind = kind_of(s)
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
    known = []
    for p, q in {(k * m, n): None for k in s.orders[:3] for m, n in ((1, 1), (2, 1), (3, 1), (1, 2), (1, 3))}:
        candidate = Resonance(p, q).checked()
        at_exact = s.system._replace(omega=s.omega_0 * q / p)
        if candidate not in known and _flow(at_exact, candidate, order).phase_matters():
            known.append(candidate)
    names = ", ".join(f"Resonance({r.p}, {r.q})" for r in known) or "none with p, q up to 3"
    return (
        f"{fact}: with lines of order {', '.join(map(str, s.orders))} the averaging integral does not depend on the "
        f"phase; {ORDINAL[order]} order knows {names}; use one of them or NONRESONANT, or integrate"
    )
