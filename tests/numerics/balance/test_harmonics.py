"""The number of harmonics reaches every line of the excitation, by choice or by refusal."""

import math

import pytest

import strainwave as sw

pytestmark = pytest.mark.slow

B, AMPLITUDE, BELOW = 0.05, 0.1, 0.8  # BELOW: speed of the line over omega_0


def linear(order, speed=BELOW):
    return sw.Oscillator(1.0, B, sw.Linear(1.0), sw.Harmonic(AMPLITUDE, order=order), speed / order)


@pytest.mark.parametrize("order", [8, 20, 32, 64, 130])
def test_orbit_of_a_linear_system_is_exact_at_any_order(order):
    orbit = sw.find_orbit(linear(order))
    exact = AMPLITUDE / math.hypot(1.0 - BELOW**2, B * BELOW)
    assert orbit.status
    assert orbit.amplitude(order) == pytest.approx(exact, rel=1e-9)
    assert orbit.peak == pytest.approx(exact, rel=1e-6)


def test_curve_of_a_linear_system_peaks_at_the_line_of_a_high_order():
    curve = sw.frequency_response(linear(32), (0.6 / 32, 1.3 / 32), points=40)
    assert curve.status
    assert curve.peak.max() == pytest.approx(AMPLITUDE / (B * math.sqrt(1.0 - B * B / 4.0)), rel=1e-3)


def test_backbone_is_not_moved_by_a_line_of_high_order():
    """Order 32 sampled at 32 points would be a mean torque, under which a hardening law vibrates faster."""
    curve = sw.numerics.backbone(
        linear(32)._replace(law=sw.Cubic(1.0, 0.5), excitation=sw.Harmonic(1.0, order=32)), [0.1]
    )
    assert curve.omega[0] == pytest.approx(1.0 + 0.375 * 0.5 * 0.01, rel=1e-5)


@pytest.mark.parametrize(
    ("verb", "sentence"),
    [
        (lambda: sw.find_orbit(linear(20), harmonics=7), "harmonics is 7, but a line of order 20 is harmonic 20"),
        (lambda: sw.find_orbit(linear(4), harmonics=7, period=2), "a line of order 4 is harmonic 8 of the orbit; take"),
        (lambda: sw.frequency_response(linear(20), (0.01, 0.1), harmonics=7), "take at least 20"),
        (lambda: sw.numerics.parameter_response(linear(20), "B", (0.01, 0.1), harmonics=7), "take at least 20"),
        (lambda: sw.find_orbit(linear(2000)), "a line of order 2000 over 1 turns takes 2002 harmonics; at most 1000"),
        (lambda: sw.find_orbit(linear(1), harmonics=10**6), "harmonics is 1000000; it must be at most 1000"),
        (lambda: sw.isolas(linear(1), (0.5, 0.6), harmonics=1.5), "harmonics is 1.5; it must be a whole number"),
        (
            lambda: sw.numerics.parameter_response(linear(1), "B", (0.01, 0.1), points=0),
            "points is 0; it must be a whole",
        ),
        (lambda: sw.numerics.shoot(linear(1), (0.0, 0.0), period=0), "period is 0; it must be a whole number"),
    ],
)
def test_too_few_or_too_many_harmonics_are_refused(verb, sentence):
    with pytest.raises(ValueError, match=sentence):
        verb()


HARDENING = sw.Oscillator(1.0, 0.05, sw.Cubic(1.0, 0.1), sw.Harmonic(0.18), 1.2)  # NLvib example 01, converged values


@pytest.mark.parametrize("order", [4, 6, 10])
def test_a_line_of_a_higher_order_on_an_odd_law_takes_the_harmonics_that_order_one_takes(order):
    """It moves orders k, 3k, 5k, ...: those between are zero and tell nothing of what is left out."""
    system = HARDENING._replace(excitation=sw.Harmonic(0.18, order=order), omega=1.2 / order)
    curve = sw.frequency_response(system, (0.5 / order, 1.6 / order), points=60)
    assert curve.status
    assert curve.peak.max() == pytest.approx(2.877112, rel=1e-5)
    assert [order * fold.omega for fold in curve.folds] == pytest.approx([1.269602, 1.115700], abs=1e-6)


def test_an_orbit_of_a_high_order_is_as_exact_as_that_of_order_one():
    high = HARDENING._replace(excitation=sw.Harmonic(0.18, order=6), omega=0.2)
    assert sw.find_orbit(high).peak == pytest.approx(sw.find_orbit(HARDENING).peak, rel=1e-9)


def cut_short():
    """Results of one harmonic, of which the third holds more than 1 %."""
    few = {"harmonics": 1}
    yield sw.find_orbit(HARDENING._replace(omega=1.0), **few)
    yield sw.frequency_response(HARDENING, (0.5, 1.6), **few)
    yield sw.frequency_response(HARDENING, (0.5, 1.6), **few).folds[0]
    yield sw.numerics.parameter_response(HARDENING, "excitation.amplitude", (0.1, 0.5), **few)
    yield sw.numerics.response_family(HARDENING, (0.5, 1.6), {"B": [0.05]}, **few, threads=1)[0]
    yield sw.numerics.backbone(HARDENING, [2.8], harmonics=2)


def test_every_verb_says_that_the_harmonics_left_out_matter():
    for found in cut_short():
        assert found.tail > 1e-3
        assert found.status is sw.Status.TRUNCATED
        assert not found.status
        assert found.status.found
        assert "the harmonics left out hold about" in found.message
        assert "take more than" in found.message


def test_a_whole_curve_of_few_harmonics_is_returned_though_failures_are_to_be_raised():
    curve = sw.frequency_response(HARDENING, (0.5, 1.6), harmonics=1, throw=True)
    assert curve.status is sw.Status.TRUNCATED


def test_the_tail_is_the_share_of_what_is_left_out():
    coarse = sw.find_orbit(HARDENING, harmonics=1)
    fine = sw.find_orbit(HARDENING).coefficients[:, 0]
    assert coarse.tail == pytest.approx(math.sqrt(sum(fine[3:] ** 2) / sum(fine**2)), rel=0.3)
