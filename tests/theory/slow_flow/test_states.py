"""Steady states at many speeds at once: those that are found speed by speed, none lost and none added."""

import numpy as np
import pytest

import strainwave as sw

pytestmark = pytest.mark.slow

DUFFING = sw.Oscillator(1.0, 0.01, sw.Cubic(1.0, 0.2), sw.Harmonic(0.01), 1.05)
GEAR = sw.Oscillator(
    0.6030927835, 9.82317898446, sw.PiecewiseLinear(1e5, 1.4e5, 1.8e5, 54.0, 196.0), sw.Harmonic(0.0), 235.0,
    sw.KinematicError((sw.Line(2, 1.1e-4),)),
)  # fmt: skip
SUPER = sw.Oscillator(1.0, 0.02, sw.Cubic(1.0, 0.3), sw.Harmonic(0.6, phase=0.4), 0.345)
SUB = sw.Oscillator(1.0, 0.01, sw.Cubic(1.0, 0.2), sw.Harmonic(2.0), 3.15)
KINDS = ("cubic", "square and cube", "three slopes", "backlash", "fifth power")


def drawn(kind, rng):
    """A random drive of a kind, near its primary resonance: forced by a torque or by a kinematic error."""
    K, J = 10 ** rng.uniform(-1.0, 4.0), 10 ** rng.uniform(-2.0, 1.0)
    zeta, A, alpha = 10 ** rng.uniform(-2.3, -1.3), 10 ** rng.uniform(-1.5, -0.3), 10 ** rng.uniform(-0.5, 1.0)
    law = {
        "cubic": sw.Cubic(K, float(rng.choice([1.0, -0.3])) * alpha),
        "square and cube": sw.Polynomial((0.0, K, K * rng.uniform(-0.3, 0.3), K * alpha)),
        "three slopes": sw.PiecewiseLinear(K, 1.4 * K, 1.8 * K, 0.3 * K, K),
        "backlash": sw.Backlash(K, 0.1),
        "fifth power": sw.Polynomial((0.0, K, 0.0, 0.2 * K * alpha, 0.0, 0.1 * K)),
    }[kind]
    mean = 0.5 * K if kind == "backlash" else K * rng.uniform(0.0, 0.3) * float(rng.choice([0.0, 1.0]))
    by_torque = bool(rng.integers(2))
    torque = sw.Harmonic(6.0 * zeta * A * K if by_torque else 0.0, 1, 0.3, mean)
    error = sw.NoError() if by_torque else sw.KinematicError((sw.Line(1, 6.0 * zeta * A),))
    return sw.Oscillator(J, 2.0 * zeta * np.sqrt(K * J), law, torque, np.sqrt(K / J), error)


def one_by_one(system, resonance, order, omega):
    """Amplitude, phase and stability of every state, from a slow flow of each speed."""
    each = [sw.slow_flow(system._replace(omega=float(w)), resonance, order=order).steady_states() for w in omega]
    return [[(s.amplitude * np.exp(-1j * s.phase), s.stable) for s in states] for states in each]


def at_once(found, omega):
    z = found.amplitude * np.exp(-1j * found.phase)
    return [list(zip(z[found.omega == w], found.stable[found.omega == w], strict=True)) for w in omega]


def assert_same(many, single):
    for here, there in zip(many, single, strict=True):
        assert len(here) == len(there)
        for (z, stable), (other, other_stable) in zip(here, there, strict=True):
            assert abs(z - other) <= 1e-6 * abs(other)
            assert stable == other_stable


@pytest.mark.slow
@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("kind", KINDS)
def test_no_state_is_lost_or_added_in_random_drives(kind, order):
    rng = np.random.default_rng(KINDS.index(kind) + 10 * order)
    many, single = [], []
    kinked = kind in ("three slopes", "backlash")
    for _ in range(4 if kinked and order == 2 else 12):
        system = drawn(kind, rng)
        flow = sw.slow_flow(system, sw.PRIMARY, order=order)
        omega = flow.omega_0 * np.sort(rng.uniform(0.5, 1.8, 40))
        looked_at = omega[:: 2 if order == 1 or kind in KINDS[:2] else 13]
        many += at_once(flow.states_at(omega), looked_at)
        single += one_by_one(system, sw.PRIMARY, order, looked_at)
    assert_same(many, single)
    assert kinked or any(len(some) > 1 for some in single)  # jumps are among them


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize(
    ("system", "resonance", "band"),
    [
        (SUPER, sw.SUPERHARMONIC, (0.3, 0.4)),
        (SUB, sw.SUBHARMONIC, (2.9, 3.6)),
        (GEAR, sw.Resonance(2, 1), (150.0, 260.0)),
    ],
    ids=["superharmonic", "subharmonic with a = 0", "gear"],
)  # fmt: skip
def test_other_resonances_have_the_same_states_too(system, resonance, band, order):
    omega = np.linspace(*band, 7)
    found = sw.slow_flow(system, resonance, order=order).states_at(omega)
    assert_same(at_once(found, omega), one_by_one(system, resonance, order, omega))


def test_first_order_states_are_the_roots_of_the_polynomial_whatever_the_damping():
    """E4 in s = a^2, at many decades of damping and hardening."""
    rng = np.random.default_rng(5)
    for _ in range(300):
        mu, alpha, A = 10.0 ** rng.uniform((-6, -9, -4), (-1, 1, -1))
        flow = sw.slow_flow(sw.Oscillator(1.0, mu, sw.Cubic(1.0, alpha), sw.Harmonic(A), 1.0), sw.PRIMARY)
        top = 0.375 * alpha * (A / mu) ** 2
        omega = 1.0 + np.array([-0.5, -0.01, 0.0, 0.3, 0.9, 1.1]) * min(top, 1.0)
        found = flow.states_at(omega)
        for w in omega:
            a = found.amplitude[found.omega == w]
            k, sigma = 0.375 * alpha, w - 1.0
            terms = np.array([0.25 * mu**2 * a**2, (sigma - k * a**2) ** 2 * a**2, -np.full(len(a), 0.25 * A**2)])
            slope = (0.25 * mu**2 + (sigma - k * a**2) * (sigma - 3.0 * k * a**2)) * 2.0 * a**2
            # what the residual moves the amplitude by, relative
            assert np.max(np.abs(np.sum(terms, axis=0)) / np.maximum(np.abs(slope), 1e-7 * 0.25 * A**2)) < 1e-6
            assert len(a) % 2 == 1


def test_speeds_keep_their_order_and_states_fall_in_amplitude():
    omega = np.array([1.05, 0.9, 1.05, 1.2])
    found = sw.slow_flow(DUFFING, sw.PRIMARY).states_at(omega)
    assert found.omega.tolist() == [1.05] * 3 + [0.9] + [1.05] * 3 + [1.2]
    assert np.all(np.diff(found.amplitude[:3]) < 0.0)
    assert np.array_equal(found.amplitude[:3], found.amplitude[4:7])
    assert found.stable.tolist() == [True, False, True, True, True, False, True, True]


def test_bad_speeds_are_refused_in_one_sentence():
    flow = sw.slow_flow(DUFFING, sw.PRIMARY)
    with pytest.raises(ValueError, match=r"every speed must be positive"):
        flow.states_at([1.0, -0.5])
    with pytest.raises(ValueError, match=r"must be one or more finite numbers"):
        flow.states_at([1.0, np.nan])
    with pytest.raises(ValueError, match=r"sits on omega_0 = 1 rad/s at omega = 1 rad/s"):
        sw.slow_flow(SUPER, sw.SUPERHARMONIC).states_at([0.34, 1.0])
