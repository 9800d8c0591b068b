"""A drive whose stiffness and damping vary runs in every verb that takes a general system, and the others say no."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import strainwave as sw
from strainwave.base.quantities import checked

RIPPLES = sw.gears.Variation((sw.gears.Ripple(1, 0.1), sw.gears.Ripple(2, 0.2, 0.5)))
DAMPING = sw.gears.GearDamping(0.1, sw.gears.Variation((sw.gears.Ripple(1, 0.4),)), warming=4.0, fast=0.5, v_fast=0.3)
DRIVE = sw.gears.VaryingOscillator(1.0, DAMPING, sw.Cubic(1.0, 0.1), sw.Harmonic(0.2), 1.3, sw.NoError(), RIPPLES)


def test_the_equation_of_motion_is_the_one_in_the_docstring():
    system = DRIVE._replace(error=sw.KinematicError((sw.Line(2, 0.1),)))
    phase, x, v = 0.7, 0.3, -0.4
    u, du = x - 0.1 * math.cos(2 * phase), v + 1.3 * 0.2 * math.sin(2 * phase)
    b = 0.1 * math.exp(-0.035 * 4.0) * (1 + 0.4 * math.cos(phase)) * (0.5 + 0.5 / (1 + (du / 0.3) ** 2))
    kappa = 1 + 0.1 * math.cos(phase) + 0.2 * math.cos(2 * phase + 0.5)
    force = 0.2 * math.cos(phase) - b * du - kappa * (u + 0.1 * u**3)
    assert system.rhs(phase, (x, v)) == pytest.approx((v, force), rel=1e-14)
    assert system.torsion(phase, (x, v)) == pytest.approx(u, rel=1e-15)
    assert system.orders() == (1, 2)


def test_damping_stays_within_its_bounds():
    rng = np.random.default_rng(3)
    angle, v = rng.uniform(-10, 10, 10_000), rng.standard_cauchy(10_000)
    low, high = DAMPING.bounds()
    b = DAMPING.value(angle, v)
    assert low <= np.min(b) < 1.01 * low
    assert 0.99 * high < np.max(b) <= high


def test_an_orbit_is_the_same_by_balance_by_shooting_and_by_an_independent_integration():
    orbit = sw.find_orbit(DRIVE)
    assert orbit.status
    shot = sw.numerics.shoot(DRIVE, orbit.state(0.0))
    assert shot.amplitude(1) == pytest.approx(orbit.amplitude(1), rel=1e-9)
    np.testing.assert_allclose(shot.multipliers, orbit.multipliers, atol=1e-8)
    period = 2.0 * math.pi / 1.3
    end = solve_ivp(lambda t, y: DRIVE.rhs(1.3 * t, y), (0, period), orbit.state(0.0), "DOP853", rtol=1e-11, atol=1e-13)
    np.testing.assert_allclose(end.y[:, -1], orbit.state(0.0), atol=1e-9)
    start = sw.simulate(DRIVE, orbit.state(0.0), period)
    np.testing.assert_allclose(start.y[:, -1], orbit.state(0.0), atol=1e-8)


def test_without_variation_the_curve_is_that_of_the_plain_oscillator():
    plain = sw.Oscillator(1.0, 0.1, sw.Cubic(1.0, 0.1), sw.Harmonic(0.2), 1.0)
    same = sw.gears.VaryingOscillator(1.0, sw.gears.GearDamping(0.1), sw.Cubic(1.0, 0.1), sw.Harmonic(0.2), 1.0)
    expected, found = (sw.frequency_response(s, (0.8, 1.8), points=60) for s in (plain, same))
    assert [f.omega for f in found.folds] == pytest.approx([f.omega for f in expected.folds], rel=1e-8)
    jumps, plain_jumps = sw.jumps(found), sw.jumps(expected)
    assert jumps.jump_down == pytest.approx(plain_jumps.jump_down, rel=1e-8)
    assert jumps.jump_up == pytest.approx(plain_jumps.jump_up, rel=1e-8)


def test_a_depth_is_a_parameter_that_can_be_swept():
    branch = sw.numerics.parameter_response(DRIVE, "variation.ripples.1.depth", (0.0, 0.3), points=20)
    assert branch.status
    at = sw.find_orbit(sw.replaced(DRIVE, {"variation.ripples.1.depth": 0.3}))
    assert branch.values[-1] == pytest.approx(0.3)
    assert branch.amplitude(1)[-1] == pytest.approx(at.amplitude(1), rel=1e-6)


@pytest.mark.parametrize(
    ("model", "sentence"),
    [
        (
            sw.gears.Variation((sw.gears.Ripple(1, 0.6), sw.gears.Ripple(2, -0.5))),
            "add up to 1.1; they must stay below 1",
        ),
        (sw.gears.Variation((sw.gears.Ripple(0, 0.1),)), "Ripple.order is 0; it must be at least 1"),
        (sw.gears.Variation((sw.gears.Ripple(1.5, 0.1),)), "Ripple.order must be a whole number"),
        (sw.gears.GearDamping(-1.0), "GearDamping.B is -1; it must not be negative"),
        (sw.gears.GearDamping(1.0, fast=-0.1), "GearDamping.fast is -0.1"),
        (sw.gears.GearDamping(1.0, v_fast=0.0), "GearDamping.v_fast is 0 rad/s; it must be positive"),
        (DRIVE._replace(J=0.0), "VaryingOscillator.J is 0"),
    ],
)
def test_what_makes_no_sense_is_refused_in_one_sentence(model, sentence):
    with pytest.raises(ValueError, match=sentence) as complaint:
        checked(model)
    assert "\n" not in str(complaint.value)
