"""The four cases of multiple scales of the cubic error equation under one forcing line, derived by SymPy.

x = x_0(T_0, T_1) + epsilon x_1(T_0, T_1) with T_0 = t and T_1 = epsilon t; D_0 and D_1 are the derivatives to them.
The terms of the first order that turn with exp(i omega_0 T_0) would grow with time and must vanish: they give the
amplitude a and the phase. epsilon is book-keeping and 1 in the end, so that mu, sigma and f are the physical ones.

Sources: Nayfeh & Mook 1979, Nonlinear Oscillations, secs. 4.1.1 to 4.1.4. Corrects the source article's cases 1 to 4
(errata E2 to E6, E9 and E10).
"""

from collections import namedtuple
from typing import Any

from ..resonance import NONRESONANT, PRIMARY, SUBHARMONIC, SUPERHARMONIC, Resonance
from . import sp
from .steps import Row, Steps, Symbols


class DerivedCase(
    Steps,
    namedtuple(
        "DerivedCase",
        "symbols resonance equation orders x_0 C secular amplitude_rate phase_rate response jacobian trace determinant "
        "x",
    ),
):
    """One case of multiple scales, p omega = q omega_0 + epsilon sigma, as SymPy expressions in `symbols`.

    With a resonance the phase is phi = sigma T_1 - q beta, the article's, and x_0 = a cos((p omega t - phi)/q) + C cos
    omega t. Rates are derivatives to T_1, which is t for epsilon = 1.

    Attributes
    ----------
    symbols : Symbols
        Symbols of the expressions; `amplitude`, `phase` and `beta` are a, phi and beta.
    resonance : Resonance
        p and q; (0, 0) far from every resonance.
    equation, orders : Eq, tuple of Eq
        The scaled error equation [rad/s^2], and its parts of order 0 and 1 in epsilon.
    x_0 : Expr
        Motion of order 0 [rad].
    C : Expr
        Forced amplitude [rad] at the actual omega; 0 in the primary case, whose forcing is soft, A = epsilon f.
    secular : Expr
        Terms [rad/s^2] of order 1 on exp(i (omega_0 T_0 + beta)), which must vanish.
    amplitude_rate, phase_rate : Expr
        a' [rad/s] and phi' [rad/s], without resonance beta'.
    response : Eq
        Frequency-response equation of the steady states, a' = phi' = 0.
    jacobian : Matrix
        Derivatives of (a', phi') to (a, phi) at a steady state with a > 0; without resonance that of a' to a.
    trace, determinant : Expr
        Of the Jacobian: a steady state is stable where the trace is negative and the determinant positive. Without
        resonance the determinant is None.
    x : Expr
        x(t) [rad] to first order for epsilon = 1; without resonance with beta' integrated along a(t).
    """

    @property
    def title(self) -> str:
        """Number and name of the case."""
        return f"Case {RESONANCES.index(self.resonance) + 1}: {self.resonance}"

    def rows(self) -> list[Row]:
        """Steps to x(t) and to the condition of stability."""
        s, (p, q) = self.symbols, self.resonance
        phase, rate = (s.phase, s.phase_rate) if q else (s.beta, s.beta_rate)
        at_rest = sp.diff(self.amplitude_rate, s.amplitude).subs(s.amplitude, 0)
        rows: list[tuple[bool, Row]] = [
            (True, ("scaled equation", self.equation.lhs, "=", self.equation.rhs)),
            (True, ("slow time", s.T_1, "=", s.epsilon * s.t)),
            (q > 0, ("detuning", p * s.omega, "=", q * s.omega_0 + s.epsilon * s.sigma)),
            (self.C == 0, ("soft forcing", s.A, "=", s.epsilon * s.soft)),
            *((True, (f"order {n}", _marked(o.lhs, s), "=", _marked(o.rhs, s))) for n, o in enumerate(self.orders)),
            (True, ("motion of order 0", sp.Symbol("x_0"), "=", self.x_0)),
            (self.C != 0, ("forced amplitude", s.C, "=", self.C)),
            (True, ("secular terms", self.secular, "=", sp.S.Zero)),
            (q > 0, ("phase", phase, "=", s.sigma * s.T_1 - q * s.beta)),
            (True, ("amplitude", s.amplitude_rate, "=", self.amplitude_rate)),
            (True, ("rate of phase", rate, "=", self.phase_rate)),
            (True, ("frequency response", self.response.lhs, "=", self.response.rhs)),
            (True, ("Jacobian", sp.Symbol("M"), "=", self.jacobian)),
            (True, ("stable: trace", self.trace, "<", sp.S.Zero)),
            (q > 0, ("stable: determinant", self.determinant, ">", sp.S.Zero)),
            (q > 1, ("stable: a = 0", at_rest, "<", sp.S.Zero)),
            (True, ("x(t) for epsilon = 1", s.x, "=", self.x)),
        ]
        return [row for belongs, row in rows if belongs]


RESONANCES = (NONRESONANT, PRIMARY, SUPERHARMONIC, SUBHARMONIC)


def cases(s: Symbols, left: Any) -> tuple[DerivedCase, ...]:
    """Derive the four cases from the left side of the cubic error equation."""
    scaled = left.subs({s.mu: s.epsilon * s.mu, s.alpha: s.epsilon * s.alpha})
    x_0, x_1 = _expansion(s)
    x = x_0 + s.epsilon * x_1

    def rate(motion: Any) -> Any:
        return sp.diff(motion, s.T_0) + s.epsilon * sp.diff(motion, s.T_1)

    in_scales = sp.expand(scaled.subs({s.a: rate(rate(x)), s.v: rate(x), s.x: x}))
    of_zero = in_scales.coeff(s.epsilon, 0)
    source = sp.expand(of_zero.subs(x_0, x_1) - in_scales.coeff(s.epsilon, 1))  # of x_0 alone
    return tuple(_case(s, scaled, of_zero, source, resonance) for resonance in RESONANCES)


def _expansion(s: Symbols) -> tuple[Any, Any]:
    """x_0 and x_1 as functions of both times."""
    return sp.Function("x_0")(s.T_0, s.T_1), sp.Function("x_1")(s.T_0, s.T_1)


def _case(s: Symbols, scaled: Any, of_zero: Any, source: Any, resonance: Resonance) -> DerivedCase:
    (p, q), (x_0, x_1), turn = resonance, _expansion(s), sp.cos(s.omega * s.T_0)
    a, beta = sp.Function("a", positive=True)(s.T_1), sp.Function("beta", real=True)(s.T_1)
    hard, soft = (0, s.soft * turn) if resonance == PRIMARY else (s.A * turn, 0)
    orders = sp.Eq(of_zero, hard), sp.Eq(of_zero.subs(x_0, x_1), source + soft)
    C = hard / turn / sp.expand(of_zero.subs(x_0, turn).doit() / turn)
    fast = s.omega_0 * s.T_0 + beta
    motion = a * sp.cos(fast) + (s.C * turn if C else 0)
    pull = source.subs(x_0, motion).doit() + soft
    if q:  # omega in both times: epsilon T_0 = T_1
        pull = pull.subs(s.omega * s.T_0, (q * s.omega_0 * s.T_0 + s.sigma * s.T_1) / p)
    waves = sp.expand(sp.expand(pull.rewrite(sp.exp)) * sp.exp(-sp.I * fast))
    on_fast = [wave for wave in sp.Add.make_args(sp.powsimp(waves)) if not wave.has(s.T_0)]
    names = {a.diff(s.T_1): s.amplitude_rate, beta.diff(s.T_1): s.beta_rate, a: s.amplitude, beta: s.beta}
    secular = sp.Add(*on_fast).subs(names)
    amplitude_rate, phase_rate = _rates(s, secular, q)
    response, jacobian = _steady(s, amplitude_rate, phase_rate, q)
    angle = p * s.omega * s.t - s.phase
    free = s.amplitude * sp.cos(angle / q) if q else _decay(s, amplitude_rate, phase_rate)
    return DerivedCase(
        s, resonance, sp.Eq(scaled, s.A * sp.cos(s.omega * s.t)), orders, motion.subs(names), C, secular,
        amplitude_rate, phase_rate, response, jacobian, sp.expand(jacobian.trace()),
        _square_completed(jacobian.det(), s.sigma) if q else None,
        free + (s.C * sp.cos(s.omega * s.t) if C else 0),
    )  # fmt: skip


def _rates(s: Symbols, secular: Any, q: int) -> tuple[Any, Any]:
    """Rates of a and phi, without resonance of beta, from both parts of the secular terms."""
    beta = (s.sigma * s.T_1 - s.phase) / q if q else s.beta
    both = sp.expand_complex(sp.simplify(secular.subs(s.beta, beta))).as_real_imag()
    rates = sp.solve(both, [s.amplitude_rate, s.beta_rate])
    phase_rate = s.sigma - q * rates[s.beta_rate] if q else rates[s.beta_rate]
    return sp.expand(rates[s.amplitude_rate]), sp.expand(phase_rate)


def _steady(s: Symbols, amplitude_rate: Any, phase_rate: Any, q: int) -> tuple[Any, Any]:
    """Frequency-response equation, from sin^2 + cos^2 = 1 of the phase at rest, and the Jacobian there."""
    a = s.amplitude
    if not q:
        return sp.Eq(a, 0, evaluate=False), sp.Matrix([amplitude_rate]).jacobian([a])
    rates, (sine, cosine) = sp.Matrix([amplitude_rate, phase_rate]), (sp.sin(s.phase), sp.cos(s.phase))
    steady = sp.solve(rates, [sine, cosine])
    scale = q * amplitude_rate.coeff(sine) / a
    factor = a**2 if q == 1 else 1
    squares = [sp.expand(scale * steady[part]) ** 2 for part in (sine, cosine)]
    response = sp.Eq(factor * sp.Add(*squares), sp.cancel(factor * scale**2))
    return response, sp.simplify(rates.jacobian([a, s.phase]).subs(steady))


def _square_completed(quadratic: Any, unknown: Any) -> Any:
    """Write a quadratic as c (unknown + b)^2 and the rest."""
    c, linear, constant = sp.Poly(sp.expand(quadratic), unknown).all_coeffs()
    shift = sp.expand(linear / (2 * c))
    return c * (unknown + shift) ** 2 + sp.expand(constant - c * shift**2)


def _decay(s: Symbols, amplitude_rate: Any, beta_rate: Any) -> Any:
    """The free part without resonance: beta' integrated along a(t)."""
    a = s.a_0 * sp.exp(sp.integrate(sp.expand(amplitude_rate / s.amplitude), (s.t, 0, s.t)))
    turned = sp.integrate(sp.expand(beta_rate.subs(s.amplitude, a)), (s.t, 0, s.t))
    return a * sp.cos(s.omega_0 * s.t + s.beta_0 + turned)


def _marked(expression: Any, s: Symbols) -> Any:
    """Write the derivatives to T_0 and T_1 as operators D_0 and D_1, and x_0 and x_1 without their arguments."""
    names = {f: sp.Symbol(f.func.__name__, commutative=False) for f in _expansion(s)}
    signs = {time: sp.Symbol(f"D{time.name[1:]}", commutative=False) for time in (s.T_0, s.T_1)}

    def operators(derivative: Any) -> Any:
        return sp.Mul(*(signs[time] ** count for time, count in derivative.variable_count), names[derivative.expr])

    return expression.replace(lambda part: isinstance(part, sp.Derivative), operators).xreplace(names)
