"""Laws with friction and memory, of the library and of a user, in every verb: integration, orbits, curves."""

from typing import NamedTuple

import numpy as np
import pytest
from canonical import DISSIPATIVE
from maxwell import Maxwell
from scipy.integrate import solve_ivp

import strainwave as sw

FORCED = sw.Oscillator(1.0, 0.05, sw.Parallel(sw.Cubic(1.0, 0.1), DISSIPATIVE["BoucWen"]), sw.Harmonic(0.4), 1.2)


class Quadratic(NamedTuple):
    """A user's law: a spring with drag c |v| v."""

    K: float
    c: float

    def torque(self, x, v):
        return self.K * x + self.c * abs(v) * v


MAXWELL = sw.Oscillator(2.0, 0.1, Maxwell(3.0, 1.5, 0.7), sw.Harmonic(0.4), 1.3)


def receptance(system, omega):
    """x/tau of the linear oscillator with a `Maxwell` law: its complex stiffness is K + G i omega r/(1 + i omega r)."""
    law, i = system.law, 1j * omega * system.law.r
    return 1.0 / (law.K + law.G * i / (1.0 + i) - system.J * omega**2 + 1j * system.B * omega)


def test_orbit_of_a_users_law_with_memory_is_its_closed_form():
    orbit = sw.find_orbit(MAXWELL)
    assert orbit.amplitude(1) == pytest.approx(0.4 * abs(receptance(MAXWELL, 1.3)), rel=1e-12)
    assert len(orbit.multipliers) == 3


def test_curve_of_a_users_law_with_memory_is_its_closed_form():
    branch = sw.frequency_response(MAXWELL, (0.5, 3.0), points=40)
    expected = [0.4 * abs(receptance(MAXWELL, omega)) for omega in branch.omega]
    np.testing.assert_allclose(branch.amplitude(1), expected, rtol=1e-7)  # where the steps along a curve stop


def test_motion_of_a_users_law_with_memory_settles_on_its_orbit():
    period = 2.0 * np.pi / 1.3
    run = sw.simulate(MAXWELL, (0.0, 0.0, 0.0), 40 * period)
    np.testing.assert_allclose(run.y[:, -1], sw.find_orbit(MAXWELL).state(0.0), atol=1e-7)


def test_friction_without_memory_keeps_two_states():
    system = sw.Oscillator(1.0, 0.0, Quadratic(1.0, 0.2), sw.Harmonic(0.3), 1.0)
    assert system.state_names() == ("x", "x'")
    orbit = sw.find_orbit(system, harmonics=9)
    # at resonance the drag balances the torque: 8/(3 pi) c (omega a)^2 = A (one harmonic; the drag has a third one)
    assert orbit.amplitude(1) == pytest.approx(np.sqrt(0.3 * 3.0 * np.pi / (8.0 * 0.2)), rel=5e-3)


def test_integration_agrees_with_scipy():
    run = sw.simulate(FORCED, (0.1, 0.2, 0.0), 20.0)
    other = solve_ivp(
        lambda t, y: FORCED.rhs(1.2 * t, tuple(y)), (0.0, 20.0), [0.1, 0.2, 0.0], "DOP853", rtol=1e-11, atol=1e-12
    )
    np.testing.assert_allclose(run.y[:, -1], other.y[:, -1], atol=1e-7)


@pytest.mark.slow
def test_harmonic_balance_with_hysteresis_approaches_the_orbit_by_shooting():
    few, more = (sw.find_orbit(FORCED, harmonics=h) for h in (9, 27))
    exact = sw.numerics.shoot(FORCED, more.state(0.0))
    assert exact.status is sw.Status.OK
    # corners in z' make the coefficients of x fall as 1/k^4 or faster
    assert abs(few.peak - exact.peak) < 3e-4
    assert abs(more.peak - exact.peak) < 3e-5
    assert abs(more.peak - exact.peak) < 0.2 * abs(few.peak - exact.peak)
    np.testing.assert_allclose(abs(more.multipliers[:2]), abs(exact.multipliers[:2]), rtol=2e-3)


@pytest.mark.slow
def test_parameter_response_takes_laws_with_memory():
    branch = sw.numerics.parameter_response(FORCED, "excitation.amplitude", (0.2, 0.6), harmonics=7, points=20)
    assert branch.status is sw.Status.OK
    at = np.argmin(np.abs(branch.values - 0.4))
    value = float(branch.values[at])
    orbit = sw.find_orbit(sw.replaced(FORCED, {"excitation.amplitude": value}), harmonics=7)
    assert branch.amplitude(1)[at] == pytest.approx(orbit.amplitude(1), rel=1e-6)
    both_ways = sw.numerics.parameter_response(FORCED, "law.second.K", (0.5, 1.5), harmonics=7, points=20, start=orbit)
    assert both_ways.values.min() == 0.5
    assert both_ways.values.max() == 1.5


@pytest.mark.parametrize(
    "verb",
    [
        lambda s: sw.lyapunov(s),
        lambda s: sw.numerics.backbone(s, [1.0]),
        lambda s: sw.isolas(s, (0.5, 2.0)),
        lambda s: sw.study.compare_with_integration(s, sw.PRIMARY),
    ],
    ids=["lyapunov", "backbone", "isolas", "compare"],
)
def test_theory_of_springs_refuses_memory_in_one_sentence(verb):
    with pytest.raises(TypeError, match=r"takes a law torque\(x\) and Parallel has torque\(x, v, z\); use find_orbit"):
        verb(FORCED)


class TooFew(NamedTuple):
    K: float
    states = 2

    def torque(self, x, v, z):
        return self.K * z[0]

    def z_rate(self, x, v, z):
        return (v,)


class Forgetful(NamedTuple):
    K: float

    def torque(self, x, v, z):
        return self.K * z[0]


@pytest.mark.parametrize(
    ("law", "sentence"),
    [
        (TooFew(1.0), "TooFew has 2 internal states but z_rate does not give as many rates"),
        (Forgetful(1.0), r"Forgetful has torque\(x, v, z\); torque\(x, v, z\) and z_rate\(x, v, z\) need each other"),
    ],
)
def test_law_whose_methods_do_not_fit_together_is_refused(law, sentence):
    with pytest.raises(TypeError, match=sentence):
        sw.simulate(FORCED._replace(law=law), (0.0, 0.0, 0.0, 0.0), 1.0)
