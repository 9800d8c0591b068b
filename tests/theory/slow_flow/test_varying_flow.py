"""Slow flow of a stiffness and a damping that vary: its averages, its tongue, its certificate."""

import math

import numpy as np
import pytest
from averaged import integrated, with_varying

import strainwave as sw
from strainwave.theory.slow_flow.balance import balance_of

TONGUE = sw.Resonance(1, 2)
MATHIEU = sw.gears.VaryingOscillator(
    1.0, sw.gears.GearDamping(0.02), sw.Cubic(1.0, 0.1), sw.Harmonic(0.0), 2.0,
    variation=sw.gears.Variation((sw.gears.Ripple(1, 0.1, 0.7),)),
)  # fmt: skip
LOADED = sw.gears.VaryingOscillator(
    1.3,
    sw.gears.GearDamping(0.05, sw.gears.Variation((sw.gears.Ripple(2, 0.3, 1.0),)), fast=0.4, v_fast=0.3),
    sw.Polynomial((0.0, 1.0, 0.1, 0.2)),
    sw.Harmonic(0.1, 1, 0.4, mean=0.3),
    0.9,
    sw.KinematicError((sw.Line(2, 0.05, 0.3),)),
    sw.gears.Variation((sw.gears.Ripple(1, 0.05, 0.2), sw.gears.Ripple(2, 0.08))),
)


def with_depth(k, mu=0.0, omega=2.0, law=MATHIEU.law):
    stiffness = sw.gears.Variation((sw.gears.Ripple(1, k),))
    return MATHIEU._replace(damping=sw.gears.GearDamping(mu), variation=stiffness, omega=omega, law=law)


def test_a_line_of_the_stiffness_turns_with_the_conjugate():
    """z' = -(mu/2 + i (Omega - omega_0)) z + i omega_0 (k/4) exp(i phi) conj(z), Nayfeh & Mook 1979, sec. 5.2."""
    z = np.array([0.3 + 0.1j, -0.7j, 2.0])
    flow = sw.slow_flow(MATHIEU._replace(law=sw.Linear(1.0), omega=2.1), TONGUE)
    expected = -(0.01 + 0.05j) * z + 0.025j * np.exp(0.7j) * z.conj()
    np.testing.assert_allclose(flow.rates(z), expected, rtol=1e-12)


def test_rates_are_the_averages_of_the_equation_itself():
    """What the system's own acceleration has beyond the linear drive and its lines, averaged over a turn."""
    flow, system = sw.slow_flow(LOADED, sw.PRIMARY), LOADED
    theta, u0, z = 2.0 * np.pi * np.arange(4096) / 4096, flow.mean_torsion, 0.4 - 0.3j
    k0 = float(system.law.stiffness(u0))
    e, pull = np.exp(1j * theta), system.variation.value(theta) * system.law.torque(u0)
    lines = system.excitation.torque(theta) - pull + system.J * 0.9**2 * 4 * 0.05 * np.cos(2.0 * theta + 0.3)
    hard = 2.0 * np.mean(lines * np.exp(-2j * theta)) / system.J / (flow.omega_0**2 - (2 * 0.9) ** 2)
    w, rate = (z * e + hard * e**2).real, (0.9j * z * e + 1.8j * hard * e**2).real
    error = system.error.value(theta), 0.9 * system.error.slope(theta)
    acceleration = system.rhs(theta, (u0 + w + error[0], rate + error[1]))[1]
    beyond = system.excitation.torque(theta) - pull - system.J * acceleration - k0 * w - flow.mu * system.J * rate
    soft = 2.0 * np.mean(lines / e) / system.J
    forced = np.mean(beyond / e) / system.J - 0.5 * soft
    expected = -(0.5 * flow.mu + 1j * (0.9 - flow.omega_0)) * z + 1j / flow.omega_0 * forced
    assert flow.rates(z) == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("resonance", [sw.PRIMARY, sw.SUPERHARMONIC, sw.NONRESONANT])
def test_what_does_not_vary_has_the_flow_of_the_plain_oscillator(resonance):
    error, z = sw.KinematicError((sw.Line(2, 0.1),)), np.array([0.3 + 0.1j, -0.7j])
    plain = sw.Oscillator(1.0, 0.05, sw.Polynomial((0.0, 1.0, 0.1, 0.2)), sw.Harmonic(0.2), 0.45, error)
    same = sw.gears.VaryingOscillator(1.0, sw.gears.GearDamping(0.05), *plain[2:])
    np.testing.assert_allclose(
        sw.slow_flow(same, resonance).rates(z), sw.slow_flow(plain, resonance).rates(z), rtol=1e-11
    )


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_rest_loses_its_stability_at_the_edges_of_the_tongue(side):
    """Omega/2 = omega_0 -+ sqrt((k omega_0/4)^2 - mu^2/4), by hand."""
    edge = 2.0 + side * math.sqrt(0.05**2 - 0.02**2)
    for step in (-1e-6, 1e-6):
        (*_, rest) = sw.slow_flow(MATHIEU._replace(omega=edge + step), TONGUE).steady_states()
        assert rest.amplitude == 0.0
        assert rest.stable == (step * side > 0.0)


def test_its_tongue_nears_that_of_the_floquet_multipliers_as_the_square_of_the_depth():
    off = []
    for k in (0.05, 0.1, 0.2):
        (tongue,) = [
            r
            for r in sw.study.parametric_resonances(with_depth(k, 0.2 * k, law=sw.Linear(1.0)), (1.7, 2.3))
            if r.m == 1
        ]
        half = math.sqrt((0.5 * k) ** 2 - (0.2 * k) ** 2)
        off.append(abs(tongue.low - (2.0 - half)) + abs(tongue.high - (2.0 + half)))
    assert [a / b for a, b in zip(off[1:], off, strict=False)] == pytest.approx([4.0, 4.0], rel=0.1)
    assert off[1] < 2e-3


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, 1, 3, 5])
def test_its_error_against_integration_is_that_of_the_certificate(seed):
    """Inside the tongue alone (3, 5) and forced at half the frequency of the stiffness (0, 1)."""
    system, resonance = with_varying(np.random.default_rng(seed))
    flow = sw.slow_flow(system, resonance)
    state, certificate = flow.steady_states()[0], flow.certificate()
    assert certificate.valid
    assert state.stable
    error = abs(state.amplitude / integrated(flow, state.z, system.damping.B) - 1.0)
    assert error == pytest.approx(certificate.amplitude_at_speed, rel=0.02, abs=2e-5)


def test_the_slopes_of_the_certificate_are_those_of_its_residual():
    flow = sw.slow_flow(LOADED, sw.PRIMARY)
    balance, rng = balance_of(flow._flow.setting), np.random.default_rng(3)
    h = balance.harmonics
    c = (rng.normal(size=(1, h + 1)) + 1j * rng.normal(size=(1, h + 1))) * 0.3 / (1.0 + np.arange(h + 1)) ** 2
    c[:, 0] = c[:, 0].real
    matrix, _ = balance.slopes(c, np.array([0.9]))
    for place, unit in ((0, 1.0), (2, 1.0), (3, 1j)):
        step = np.zeros_like(c)
        step[0, place] = 1e-6 * unit
        rise = (balance.residual(c + step, np.array([0.9])) - balance.residual(c - step, np.array([0.9])))[0] / 2e-6
        column = matrix[0, :, place if unit == 1.0 else h + place]
        np.testing.assert_allclose(column, np.concatenate([rise.real, rise.imag[1:]]), atol=1e-7)
    faster, slower = (balance.torque(c, np.array([0.9 + d])) for d in (1e-6, -1e-6))
    np.testing.assert_allclose(balance.torque_slopes(c, np.array([0.9]))[1], (faster - slower) / 2e-6, atol=1e-7)


def test_a_forced_motion_whose_period_doubles_is_not_valid():
    """The forced motion lies inside the tongue of the stiffness, where half its order grows."""
    forced = MATHIEU._replace(excitation=sw.Harmonic(0.01))
    assert sw.find_orbit(forced, guess=np.zeros((3, 2))).stable is False
    certificate = sw.slow_flow(forced, sw.NONRESONANT).certificate()
    assert not certificate.valid
    assert "its period doubles" in certificate.sentence
    outside = sw.slow_flow(forced._replace(omega=2.3), sw.NONRESONANT).certificate()
    assert outside.valid


def test_a_transient_follows_the_integration():
    flow = sw.slow_flow(MATHIEU, TONGUE)
    found = flow.evolve((0.05, 0.0), 120.0)
    assert found.valid
    true = sw.simulate(MATHIEU, (0.05, 0.0), found.t).y[0]
    assert np.sqrt(np.mean((found.x - true) ** 2) / np.mean(true**2)) < 0.05
    assert flow.backbone([2.0]) == pytest.approx([1.0 + 0.375 * 0.1 * 4.0], rel=1e-9)


def test_what_constant_stiffness_alone_has_is_refused_in_a_sentence():
    with pytest.raises(ValueError, match="vary have a slow flow of first order; give order=1"):
        sw.slow_flow(MATHIEU, TONGUE, order=2)
    with pytest.raises(ValueError, match="a predictor takes a constant stiffness and damping"):
        sw.slow_flow(MATHIEU, TONGUE).predictor()
    with pytest.raises(ValueError, match=r"1:3 resonance does not appear at first order.*Resonance\(1, 2\)"):
        sw.slow_flow(MATHIEU, sw.SUBHARMONIC)
