"""Lyapunov's method for damping and stiffness that change: proved, attacked by sampling, or refused."""

import math
from typing import NamedTuple

import numpy as np
import pytest

import strainwave as sw

STEP = 0.02
LAW = sw.Cubic(1.0, 0.2)


def varying(damping, ripples=(), law=LAW, omega=2.0, mean=0.0):
    variation = sw.gears.Variation(tuple(ripples)) if ripples else sw.gears.NoVariation()
    return sw.gears.VaryingOscillator(1.0, damping, law, sw.Harmonic(0.3, mean=mean), omega, sw.NoError(), variation)


class Locking(NamedTuple):
    """The damping 2 + exp(t), which has a lower bound alone."""

    B: float = 2.0

    def value(self, angle, v):
        return self.B + np.exp(angle) + 0.0 * v

    def slope(self, angle, v):
        return self.value(angle, v)

    def bounds(self):
        return 1.0 + self.B, math.inf


def march(rate, y, steps):
    """Classical Runge-Kutta for many motions at once; rate(step index, share of the step, x, v)."""
    for i in range(steps):
        k1 = rate(i, 0.0, y)
        k2 = rate(i, 0.5, y + 0.5 * STEP * k1)
        k3 = rate(i, 0.5, y + 0.5 * STEP * k2)
        k4 = rate(i, 1.0, y + STEP * k3)
        y = y + STEP / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
        yield i, y


def test_bounded_damping_that_varies_decays_from_everywhere_and_says_why():
    damping = sw.gears.GearDamping(
        0.1, sw.gears.Variation((sw.gears.Ripple(2, 0.5),)), warming=10.0, fast=0.4, v_fast=0.5
    )
    proof = sw.lyapunov(varying(damping))
    b = 0.1 * math.exp(-0.35)
    assert damping.bounds() == pytest.approx((0.5 * 0.4 * b, 1.5 * b), rel=1e-14)
    assert proof.holds
    assert proof.scope == "global"
    assert proof.asymptotic
    assert "Barbalat" in proof.reason
    assert f"{0.2 * b:.6g} <= b <= {1.5 * b:.6g}" in proof.conditions[0]
    assert "condition: " in str(proof)


def test_a_constant_damping_and_stiffness_give_what_the_plain_oscillator_gives():
    plain = sw.lyapunov(sw.Oscillator(1.0, 0.1, sw.Cubic(1.0, -0.1), sw.Harmonic(0.0), 2.0))
    proof = sw.lyapunov(varying(sw.gears.GearDamping(0.1), law=sw.Cubic(1.0, -0.1)))
    assert (proof.scope, proof.region, proof.rest) == (plain.scope, plain.region, plain.rest)
    assert proof.V(0.3, -0.2) == plain.V(0.3, -0.2)
    assert proof.dissipation(0.3, -0.2) == pytest.approx(plain.dissipation(0.3, -0.2), rel=1e-15)
    assert proof.contains(0.3, -0.2)
    assert not proof.contains(3.0, 2.0)


def test_a_lower_bound_alone_is_refused_and_does_not_decay():
    # x = 1 + exp(-t) solves x'' + (2 + exp t) x' + x = 0, by insertion.
    system = varying(Locking(), law=sw.Linear(1.0), omega=1.0)._replace(excitation=sw.Harmonic(0.0))
    proof = sw.lyapunov(system)
    assert not proof.holds
    assert "no upper bound" in proof.reason
    t = np.linspace(0.0, 6.0, 13)
    y = np.array([2.0, -1.0])
    # (x, x') = (1 + w, -w) with w = exp(-t): the rates of the model are those of the solution
    for time in t:
        w = math.exp(-time)
        assert system.rhs(time, (1.0 + w, -w)) == pytest.approx((-w, w), abs=1e-12)
    locked = [end[0] for _, end in march(lambda i, s, y: np.array(system.rhs(STEP * (i + s), y)), y, 200)][-1]
    assert locked == pytest.approx(1.0 + math.exp(-4.0), abs=1e-6)


def test_random_damping_within_its_bounds_always_decays():
    rng = np.random.default_rng(5)
    n, steps = 60, 6000
    low, high = 0.1, 2.0
    damping = rng.uniform(low, high, (steps, n)) ** rng.choice([0.2, 1.0, 3.0], n)
    damping = np.clip(damping, low, high)  # jumps every step, from nearly always low to nearly always high
    x, v = rng.uniform(-3.0, 3.0, (2, n))
    law = LAW
    proof = sw.lyapunov(varying(sw.gears.GearDamping(1.0, sw.gears.Variation((sw.gears.Ripple(1, 0.9),))), law=law))
    assert proof.holds

    def rate(i, _, y):
        return np.array([y[1], -damping[i] * y[1] - law.torque(y[0])])

    before = proof.V(x, v)
    for i, y in march(rate, np.array([x, v]), steps):
        if i % 50 == 49:
            now = proof.V(*y)
            assert np.all(now <= before + 1e-9)
            before = now
    assert np.max(np.abs(y)) < 0.02


def random_ripples(rng):
    orders = rng.choice([1, 2, 3, 5], size=rng.integers(1, 4), replace=False)
    shares = rng.dirichlet(np.ones(len(orders))) * rng.uniform(0.1, 0.8)
    return [
        sw.gears.Ripple(int(o), float(d), float(p))
        for o, d, p in zip(orders, shares, rng.uniform(0, 6, len(orders)), strict=True)
    ]


@pytest.mark.slow
def test_random_stiffness_within_the_condition_always_decays():
    rng = np.random.default_rng(6)
    law = LAW
    for _ in range(6):
        ripples, omega = random_ripples(rng), float(rng.uniform(0.5, 3.0))
        angles = np.linspace(0.0, 2.0 * np.pi, 20001)
        variation = sw.gears.Variation(tuple(ripples))
        asked = 0.5 * omega * np.max(-variation.slope(angles) / variation.value(angles))
        least = 1.05 * float(asked)
        system = varying(sw.gears.GearDamping(least), ripples, law, omega)
        proof = sw.lyapunov(system)
        assert proof.holds, proof.reason
        assert proof.scope == "global"
        x, v, start = rng.uniform(-3, 3, 40), rng.uniform(-3, 3, 40), rng.uniform(0, 2 * np.pi, 40)

        def rate(i, share, y, system=system, start=start):
            phase = start + system.omega * STEP * (i + share)
            return np.array(system._replace(excitation=sw.Harmonic(0.0)).rhs(phase, tuple(y)))

        before = proof.V(x, v, start)
        for i, y in march(rate, np.array([x, v]), 1500):
            if i % 100 == 99:
                now = proof.V(*y, start + omega * STEP * (i + 1))
                assert np.all(now <= before + 1e-9)
                before = now
        assert np.max(before) < 0.5 * np.max(proof.V(x, v, start))
        assert not sw.lyapunov(varying(sw.gears.GearDamping(0.95 * float(asked)), ripples, law, omega)).holds


def test_the_rate_of_v_along_a_motion_is_its_dissipation():
    system = varying(sw.gears.GearDamping(0.3, fast=0.5, v_fast=0.4), [sw.gears.Ripple(1, 0.2, 0.3)], omega=1.3)
    free = system._replace(excitation=sw.Harmonic(0.0))
    proof = sw.lyapunov(system)
    assert proof.holds
    phase, x, v, h = 0.7, 0.4, -0.6, 1e-5

    def along(d):
        dx, dv = free.rhs(phase, (x, v))
        return proof.V(x + d * dx, v + d * dv, phase + d * free.omega)

    assert (along(h) - along(-h)) / (2 * h) == pytest.approx(proof.dissipation(x, v, phase), rel=1e-8)


def test_outside_the_condition_motions_can_grow():
    # At omega = 2 omega_0 a stiffness of depth 0.3 grows by 0.075 - B/(2 J) (theory.small_signal).
    system = varying(sw.gears.GearDamping(0.05), [sw.gears.Ripple(1, 0.3)], sw.Linear(1.0), 2.0)
    proof = sw.lyapunov(system)
    assert not proof.holds
    assert "parametric_resonances" in proof.reason
    free = system._replace(excitation=sw.Harmonic(0.0))

    def rate(i, share, y):
        return np.array(free.rhs(2.0 * STEP * (i + share), tuple(y)))

    *_, (_, y) = march(rate, np.array([0.1, 0.0]), 4000)
    assert np.max(np.abs(y)) > 2.0  # exp(0.05 * 80) = 55 times the start at most


@pytest.mark.parametrize(
    ("system", "sentence"),
    [
        (varying(sw.gears.GearDamping(0.5), [sw.gears.Ripple(1, 0.1)], mean=0.2), "the mean torque 0.2 N"),
        (varying(Locking(-2.0)._replace(B=-3.0)), "no upper bound"),
        (varying(sw.gears.GearDamping(0.01), [sw.gears.Ripple(2, 0.5)]), "needs a damping of"),
    ],
)
def test_what_is_not_proved_is_refused_with_its_reason(system, sentence):
    proof = sw.lyapunov(system)
    assert not proof.holds
    assert proof.scope == "none"
    assert sentence in proof.reason


def test_no_damping_at_all_is_stable_but_not_asymptotically():
    proof = sw.lyapunov(varying(sw.gears.GearDamping(0.0)))
    assert proof.holds
    assert not proof.asymptotic
    assert "never gains energy" in proof.claim
