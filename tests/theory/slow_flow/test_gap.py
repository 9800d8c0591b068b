"""Slow flow about the centre of a gap without preload: its describing function, its region and its certificate."""

import math

import numpy as np
import pytest
from averaged import integrated, with_gap
from scipy.integrate import quad

import strainwave as sw

HALF_GAP = 0.5
PLAY = sw.Oscillator(1.0, 0.1, sw.Backlash(1.0, HALF_GAP), sw.Harmonic(0.6), 0.8)


def describing(a, b=HALF_GAP):
    """Stiffness of a gap of unit slope at amplitude a (Gelb & Vander Velde 1968, app. B: 1 less that of saturation)."""
    share = min(1.0, b / a)
    return 1.0 - 2.0 / math.pi * (math.asin(share) + share * math.sqrt(1.0 - share * share))


def test_its_frequency_is_the_root_of_the_describing_function():
    amplitudes = np.array([0.2, 0.5, 0.51, 1.0, 3.0, 40.0])
    found = sw.slow_flow(PLAY, sw.PRIMARY).backbone(amplitudes)
    assert found == pytest.approx([math.sqrt(describing(a)) for a in amplitudes], abs=1e-9)
    mean = quad(lambda angle: PLAY.law.torque(math.cos(angle)) * math.cos(angle), 0.0, math.pi, points=[math.pi / 3])[0]
    assert found[3] == pytest.approx(math.sqrt(2.0 / math.pi * mean), rel=1e-9)


def test_its_steady_state_is_the_balance_of_one_harmonic():
    """(w^2(a) - Omega^2 + i mu Omega) z = S."""
    (state,) = sw.slow_flow(PLAY, sw.PRIMARY).steady_states()
    pull = describing(state.amplitude) - PLAY.omega**2 + 1j * PLAY.B * PLAY.omega
    assert pull * state.z == pytest.approx(0.6, rel=1e-9)


@pytest.mark.parametrize(("order", "error"), [(1, 4.2e-4), (2, 4.6e-5)])
def test_it_is_near_the_exact_flow_of_the_pieces(order, error):
    """3.260846925 rad is that of the exact flow of the pieces (`published/test_response_curves.py`)."""
    (state,) = sw.slow_flow(PLAY, sw.PRIMARY, order=order).steady_states()
    assert state.stable
    assert 0.0 < state.amplitude / 3.260846925 - 1.0 < error


@pytest.mark.slow
@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("seed", [1, 7, 10, 12])
def test_its_error_against_integration_is_that_of_the_certificate(seed, order):
    """To a tenth, and to the 1e-4 that the seven harmonics of the certificate leave out."""
    system = with_gap(np.random.default_rng(seed))
    flow = sw.slow_flow(system, sw.PRIMARY, order=order)
    state, certificate = flow.steady_states()[0], flow.certificate()
    assert certificate.valid
    error = abs(state.amplitude / integrated(flow, state.z, system.B) - 1.0)
    assert error == pytest.approx(certificate.amplitude_at_speed, rel=0.1, abs=1e-4)


def test_speeds_at_once_have_the_states_of_each_speed():
    speeds = np.linspace(0.3, 1.15, 8)
    weak = PLAY._replace(B=0.02, excitation=sw.Harmonic(0.2, phase=0.7))
    for order in (1, 2):
        many = sw.slow_flow(weak, sw.PRIMARY, order=order).states_at(speeds)
        each = [sw.slow_flow(weak._replace(omega=w), sw.PRIMARY, order=order).steady_states() for w in speeds.tolist()]
        listed = [(s.amplitude, s.stable) for states in each for s in states]
        assert len(listed) > len(speeds)
        assert many.amplitude == pytest.approx([a for a, _ in listed], rel=1e-6)
        assert many.stable.tolist() == [stable for _, stable in listed]


@pytest.mark.parametrize("order", [1, 2])
def test_a_motion_inside_the_gap_attracts_nothing_and_says_why(order):
    flow = sw.slow_flow(PLAY._replace(omega=1.3), sw.PRIMARY, order=order)
    (state,) = flow.steady_states()
    assert state.amplitude == pytest.approx(0.6 / (1.3 * math.hypot(1.3, 0.1)), rel=1e-9)  # x'' + mu x' = A cos
    assert not state.stable
    certificate = flow.certificate()
    assert not certificate.valid
    assert "inside the gap of 0.5 rad to both sides, where nothing holds its mean" in certificate.sentence
    assert "use harmonic balance or integration instead" in certificate.sentence


@pytest.mark.parametrize("resonance", [sw.NONRESONANT, sw.SUPERHARMONIC, sw.SUBHARMONIC])
def test_other_resonances_lead_to_the_harmonic_balance(resonance):
    words = r"frequency is that of the amplitude.*Resonance\(k, 1\); use that, frequency_response or find_orbit"
    with pytest.raises(ValueError, match=words):
        sw.slow_flow(PLAY, resonance)


def test_a_law_that_never_pushes_back_is_refused_and_so_is_a_predictor():
    with pytest.raises(ValueError, match="omega_0 is undefined"):
        sw.slow_flow(PLAY._replace(law=sw.Polynomial((0.0, 0.0))), sw.PRIMARY)
    with pytest.raises(ValueError, match="a predictor needs omega_0; give the drive a mean torque"):
        sw.slow_flow(PLAY, sw.PRIMARY).predictor()


def test_a_pure_cube_has_its_describing_function_too():
    """K x^3 has 3/4 K a^2, by hand."""
    flow = sw.slow_flow(PLAY._replace(law=sw.Polynomial((0.0, 0.0, 0.0, 2.0))), sw.PRIMARY)
    assert flow.backbone([0.7]) == pytest.approx([math.sqrt(1.5 * 0.7**2)], rel=1e-12)
