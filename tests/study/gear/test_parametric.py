"""Parametric resonance: Mathieu's characteristic values, the damped tongue, and the steady motion inside it."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.special import mathieu_a, mathieu_b

import strainwave as sw

pytestmark = pytest.mark.slow


def drive(depth, ratio=0.0, law=sw.Linear(1.0), orders=(1,), torque=sw.Harmonic(0.0)):  # noqa: B008
    ripples = tuple(sw.gears.Ripple(order, depth) for order in orders)
    return sw.gears.VaryingOscillator(
        1.0, sw.gears.GearDamping(2.0 * ratio), law, torque, 1.0, sw.NoError(), sw.gears.Variation(ripples)
    )


def test_edges_of_the_tongues_are_the_characteristic_values_of_mathieus_equation():
    # With tau = omega t/2: a = 4/omega^2 and q = 2 k/omega^2 in x'' + (a - 2 q cos 2 tau) x = 0 (DLMF 28.2).
    depth = 0.4
    found = sw.study.parametric_resonances(drive(depth), (0.6, 2.5))
    assert [r.m for r in found] == [3, 2, 1]
    for r in found:
        edges = [4.0 / w**2 for w in (r.low, r.high)]
        for a in edges:
            nearest = min((mathieu_a(r.m, depth * a / 2), mathieu_b(r.m, depth * a / 2)), key=lambda c, a=a: abs(c - a))
            assert a == pytest.approx(nearest, abs=1e-9)
        assert edges[0] - edges[1] > 0.01  # two different ones
        assert r.unstable
        assert r.turns == 1 + r.m % 2


def test_one_harmonic_gives_the_edges_of_the_tongue_to_second_order_in_the_depth():
    wrong, mu = [], 0.01
    for depth in (0.2, 0.1, 0.05):
        (found,) = sw.study.parametric_resonances(drive(depth, 0.5 * mu), (1.8, 2.2))
        half = math.sqrt(
            0.25 * depth**2 - mu**2 + 0.25 * mu**4
        )  # Nayfeh & Mook 1979, sec. 5.7: w^2 = 1 - mu^2/2 +- half
        edges = [2.0 * math.sqrt(1.0 - 0.5 * mu**2 + side * half) for side in (-1.0, 1.0)]
        wrong.append([abs(found.low - edges[0]), abs(found.high - edges[1])])
        assert found.growth == pytest.approx(0.25 * depth - 0.5 * mu, rel=depth**2)
    slope = np.log2(np.array(wrong[:-1]) / np.array(wrong[1:]))
    np.testing.assert_allclose(slope, 2.0, atol=0.15)


@pytest.mark.parametrize(("share", "unstable"), [(0.99, False), (1.01, True)])
def test_the_threshold_in_the_depth_divides_decay_from_growth(share, unstable):
    depth = share * 4.0 * 0.01 * math.sqrt(1.0 - 0.01**2)  # of one harmonic
    (found,) = sw.study.parametric_resonances(drive(depth, 0.01), (1.8, 2.2))
    assert found.unstable is unstable
    assert (found.growth > 0.0) is unstable
    assert math.isnan(found.low) is not unstable


@pytest.mark.parametrize("m", [1, 2])
def test_the_damping_needed_divides_too(m):
    def at(ratio):
        return next(r for r in sw.study.parametric_resonances(drive(0.3, ratio), (0.8, 2.2)) if r.m == m)

    needed = at(0.001).damping_needed
    assert at(0.995 * needed).unstable
    assert not at(1.005 * needed).unstable


def test_motions_grow_at_the_rate_given():
    system = drive(0.3, 0.02)
    (found,) = sw.study.parametric_resonances(system, (1.8, 2.2))
    turns, period = 20, 4.0 * math.pi / found.omega
    motion = solve_ivp(
        lambda t, y: system.rhs(found.omega * t, y), (0.0, turns * period), (1e-3, 0.0), "DOP853",
        t_eval=period * np.array([turns - 5, turns]), rtol=1e-10, atol=1e-14,
    )  # fmt: skip
    grown = math.log(abs(motion.y[0, 1] / motion.y[0, 0])) / (5 * period)
    assert grown == pytest.approx(found.growth, rel=1e-6)


def test_two_lines_of_the_stiffness_meet_in_their_sum():
    found = sw.study.parametric_resonances(drive(0.2, 0.0001, orders=(2, 5)), (2 / 7.3, 2 / 6.7))
    assert [r.m for r in found] == [7]
    assert found[0].cause == "orders 5 + 2 of the stiffness meet 2 omega_0"
    assert found[0].unstable
    alone = sw.study.parametric_resonances(drive(0.2, 0.0001, orders=(5,)), (2 / 7.3, 2 / 6.7))
    assert alone == []


def test_a_mean_torque_moves_the_resonance_with_the_stiffness_at_its_operating_point():
    law = sw.Cubic(1.0, 0.1)
    loaded = drive(0.05, 0.001, law, torque=sw.Harmonic(0.0, mean=1.5))
    (found,) = sw.study.parametric_resonances(loaded, (1.5, 3.0))[-1:]
    ratio = sw.small_signal(law, 1.5).frequency_ratio
    assert ratio > 1.1
    assert found.omega == pytest.approx(2.0 * ratio, rel=1e-3)


def test_on_a_forced_orbit_the_doublings_are_the_edges_of_the_tongue():
    system = drive(0.1, 0.01, sw.Cubic(1.0, 0.1), torque=sw.Harmonic(1e-3))
    (found,) = sw.study.parametric_resonances(system, (1.8, 2.2))
    curve = sw.frequency_response(system, (1.8, 2.2), points=60)
    assert sorted(o.omega for o in curve.doublings) == pytest.approx([found.low, found.high], rel=1e-5)


def test_with_even_orders_the_edges_are_branch_points_of_the_forced_orbit():
    system = drive(0.1, 0.01, sw.Cubic(1.0, 0.1), orders=(2,), torque=sw.Harmonic(1e-3, order=2))
    (found,) = sw.study.parametric_resonances(system, (0.9, 1.1))
    assert found.turns == 1
    curve = sw.frequency_response(system, (0.9, 1.1), points=60)
    assert curve.doublings == []
    assert sorted(o.omega for o in curve.branch_points) == pytest.approx([found.low, found.high], rel=1e-5)


def test_the_steady_motion_has_twice_the_period_and_the_amplitude_of_the_average():
    depth, mu, alpha = 0.1, 0.02, 0.1
    system = drive(depth, mu / 2.0, sw.Cubic(1.0, alpha))._replace(omega=2.0)
    # One harmonic at w = 1: (3/4 alpha a^2)^2 + mu^2 = (depth/2)^2, phase from the cosine and sine balances.
    stiffening = math.sqrt(depth**2 / 4.0 - mu**2)
    a = math.sqrt(stiffening / (0.75 * alpha))
    angle = math.atan2(-(stiffening + depth / 2.0), mu)
    p, q = a * math.cos(angle), a * math.sin(angle)
    orbit = sw.find_orbit(system, period=2, guess=np.array([[0.0, 0.0], [p, q], [q, -p]]))
    assert orbit.status
    assert orbit.stable
    assert orbit.amplitude(1) == pytest.approx(a, rel=0.5 * depth)
    branch = sw.numerics.parameter_response(system, "omega", (1.8, 2.4), start=orbit, points=60)
    (found,) = sw.study.parametric_resonances(system, (1.8, 2.2))
    assert np.min(branch.values) == pytest.approx(found.low, abs=1e-5)  # there it leaves the rest


def test_from_a_doubling_of_the_forced_orbit_the_branch_is_that_of_the_steady_motion():
    system = drive(0.1, 0.01, sw.Cubic(1.0, 0.1), torque=sw.Harmonic(0.01))
    curve = sw.frequency_response(system, (1.8, 2.2), points=60)
    assert len(curve.doublings) == 2
    first, second = (sw.numerics.switch_branch(system, o, (1.8, 2.2), points=60) for o in curve.doublings)
    assert first.period == 2
    assert np.all(first.stable[1:])  # born at the lower edge, with the law hardening: over the tongue and beyond
    assert not np.any(second.stable)
    at = system._replace(omega=float(first.values[20]))
    settled = sw.simulate(at, (0.5, 0.0), np.linspace(0.0, 400.0 * math.pi / at.omega, 201))
    x, v = settled.y[:, -1]
    orbit = sw.find_orbit(at, period=2, guess=np.array([[0.0, 0.0], [x, v], [2 * v / at.omega, -x * at.omega / 2]]))
    assert orbit.amplitude(1) == pytest.approx(first.amplitude(1)[20], rel=1e-6)


def test_a_branch_cannot_leave_rest_itself():
    system = drive(0.1, 0.01, sw.Cubic(1.0, 0.1))
    rest = sw.frequency_response(system, (1.8, 2.2), points=40)
    assert len(rest.doublings) == 2
    with pytest.raises(ValueError, match="rest itself, which has no size to step by"):
        sw.numerics.switch_branch(system, rest.doublings[0])


def test_a_constant_stiffness_has_none():
    assert sw.study.parametric_resonances(drive(0.1)._replace(variation=sw.gears.NoVariation()), (0.1, 5.0)) == []


def test_what_cannot_be_asked_is_refused_in_one_sentence():
    plain = sw.Oscillator(1.0, 0.1, sw.Linear(1.0), sw.Harmonic(0.1), 1.0)
    with pytest.raises(TypeError, match="Oscillator has no damping"):
        sw.study.parametric_resonances(plain, (0.1, 1.0))
    with pytest.raises(ValueError, match="must be 0 < low < high"):
        sw.study.parametric_resonances(drive(0.1), (0.0, 1.0))
    with pytest.raises(ValueError, match="it takes a positive one"):
        sw.study.parametric_resonances(drive(0.1, law=sw.Backlash(1.0, 0.5)), (0.1, 1.0))


@pytest.mark.parametrize("ratio", [0.2, 0.5])
def test_heavy_damping_only_takes_its_share_from_the_growth(ratio):
    # x = exp(-ratio t) z makes of 1 and the damping ratio an undamped drive of 1 - ratio^2, in which k weighs more
    free = math.sqrt(1.0 - ratio**2)
    systems = drive(0.3, ratio), drive(0.3 / free**2, law=sw.Linear(free**2))
    found, other = ({r.m: r for r in sw.study.parametric_resonances(system, (0.2, 3.0))} for system in systems)
    assert found.keys() == other.keys() == {1, 2, 3, 4}
    for m, resonance in found.items():
        assert resonance.omega == pytest.approx(other[m].omega, rel=1e-6)
        assert resonance.growth == pytest.approx(other[m].growth - ratio, abs=1e-9)
        assert not resonance.unstable
        assert resonance.damping_ratio == pytest.approx(ratio, rel=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("ratio", [0.98, 0.99, 1e3])
def test_a_drive_at_the_edge_of_vibrating_gives_finite_numbers_or_none(ratio):
    found = sw.study.parametric_resonances(drive(0.3, ratio, orders=(1, 24)), (0.01, 10.0))
    assert bool(found) == (ratio < 0.99)
    assert all(math.isfinite(r.growth) and r.growth < 0.0 and not r.unstable for r in found)


def test_a_tongue_of_a_high_order_is_that_of_the_first_order_at_a_slower_turn():
    def tongue(order):
        ripples = sw.gears.Variation((sw.gears.Ripple(order, 0.3),))
        system = sw.gears.VaryingOscillator(
            2.0, sw.gears.GearDamping(5.0), sw.Linear(8e4), sw.Harmonic(0.0), 100.0, variation=ripples
        )
        (found,) = (r for r in sw.study.parametric_resonances(system, (300.0 / order, 600.0 / order)) if r.m == order)
        return order * np.array([found.low, found.omega, found.high])

    assert tongue(24) == pytest.approx(tongue(1), rel=1e-7)
