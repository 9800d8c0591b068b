"""A measured Bode plot against a sampled loop by matrix exponentials: estimate, bias of H1, fit, comparison."""

from dataclasses import replace

import numpy as np
import pytest
from bode_machine import BANDWIDTH, TRUE, H, N, plant, records, steps

import strainwave as sw

START = sw.Drive(6e-4, 3.5, N, 60.0, sw.Linear(4e4)).train()
OMEGA = np.geomspace(20.0, 1500.0, 60)
SEEDS = range(12)


def held(omega):
    """The plant under a torque that is constant from sample to sample, with the delay."""
    A, b = steps()
    z = np.exp(1j * omega * H)
    return np.array([np.linalg.solve(q * np.eye(3) - A, b[:, 0])[0] / q for q in z])


def test_without_noise_the_estimate_is_the_plant_of_the_samples():
    t, r, u, y = records([0], noise=0.0, load=0.0)
    measured = sw.fit.bode_of_records(t, r, u[:, 0], y[:, 0])
    below = measured.omega < 2.0 * np.pi * 300.0
    np.testing.assert_allclose(measured.value[below], held(measured.omega[below]), rtol=1e-6)
    assert measured.hold == pytest.approx(H)


def test_the_instrument_is_not_biased_where_plain_h1_is_and_a_note_says_by_how_much():
    t, r, u, y = records(SEEDS, noise=2.0, load=20.0, periods=17)
    found = [sw.fit.bode_of_records(t, r, *rows) for rows in zip(u.T, y.T, strict=True)]
    common = set.intersection(*(set(bode.omega.tolist()) for bode in found))
    omega = np.array(sorted(common & set(found[0].omega[found[0].omega > 200.0].tolist())))  # above the locked load's
    lines = np.round(omega * t[1] / (2.0 * np.pi) * round(1.0 / H)).astype(int)

    def off(values):
        return abs(np.mean(np.array(values) / held(omega) - 1.0))

    U, Y = (np.fft.rfft(rows.T[:, round(1.0 / H) :].reshape(len(SEEDS), 16, -1))[:, :, lines] for rows in (u, y))
    plain = np.sum(U.conj() * Y, axis=1) / np.sum(np.abs(U) ** 2, axis=1)
    assert len(omega) > 50
    assert off(plain) > 5.0 * off([bode.value[np.searchsorted(bode.omega, omega)] for bode in found])
    assert any("biased by noise" in note for note in found[0].notes)


def test_the_numbers_of_the_machine_are_in_the_intervals_from_starts_that_are_off_by_half():
    t, r, u, y = records([3])
    fit = sw.fit.fit_bode(sw.fit.bode_of_records(t, r, u[:, 0], y[:, 0]), START)
    for name, value in TRUE.items():
        low, high = fit.interval(name, 0.999)
        assert low < value < high
        assert high - low < 0.4 * value or name == "B"
    assert 0.8 < fit.missed < 1.2
    assert "J_m" in str(fit)
    assert fit.start["K"] == pytest.approx(4e4, rel=1e-4)
    assert len(fit.panels()) == 2


@pytest.mark.slow
def test_a_start_from_which_the_sizes_lead_astray_is_left_for_another():
    t, r, u, y = records([1])
    fit = sw.fit.fit_bode(sw.fit.bode_of_records(t, r, u[:, 0], y[:, 0]), START)
    assert fit.missed < 1.2
    assert fit.values["K"] == pytest.approx(TRUE["K"], rel=0.15)


@pytest.mark.parametrize("delay", [0.4e-3, 7e-3])
def test_a_delay_of_many_radians_is_found(delay):
    value = plant(OMEGA) * np.exp(-1j * OMEGA * delay)
    fit = sw.fit.fit_bode(sw.fit.measured_bode(OMEGA, value, deviation=1e-3 * np.abs(value)), START)
    without = sw.fit.fit_bode(sw.fit.measured_bode(OMEGA, plant(OMEGA), deviation=1e-3 * np.abs(value)), START)
    assert fit.values["delay"] - without.values["delay"] == pytest.approx(delay, rel=1e-4)


def test_a_model_that_lacks_a_resonance_is_said_to_leave_more_than_the_noise():
    measured = sw.fit.measured_bode(OMEGA, plant(OMEGA), deviation=1e-3 * np.abs(plant(OMEGA)))
    fit = sw.fit.fit_bode(measured, START, free=("J_m", "delay"))
    assert fit.missed > 10.0
    assert "times the noise" in str(fit)


@pytest.mark.parametrize("quantity", ["open loop", "closed loop"])
def test_a_loop_is_compared_with_the_textbooks_and_fitted(quantity):
    K_p, lead = 0.05, 0.05 * BANDWIDTH / 4.0
    L = (K_p + lead / (1j * OMEGA)) * plant(OMEGA)
    measured = sw.fit.measured_bode(OMEGA, L if quantity == "open loop" else L / (1.0 + L), quantity=quantity)
    loop = sw.train.SpeedLoop(K_p, lead)
    right = sw.Drive(TRUE["J_m"], TRUE["J_l"], N, TRUE["B"], sw.Linear(TRUE["K"])).train(control=loop)
    compared = sw.fit.fit_bode(measured, right, free=())
    late = np.exp(-1j * OMEGA * TRUE["delay"])
    L = L / late
    np.testing.assert_allclose(compared.model, L if quantity == "open loop" else L / (1.0 + L), rtol=1e-6)
    assert compared.values == {}
    assert "speed loop of" in compared.loop
    fit = sw.fit.fit_bode(measured, START._replace(motor=START.motor._replace(control=loop)))
    for name, value in TRUE.items():
        assert fit.values[name] == pytest.approx(value, rel=1e-5)


def test_without_a_phase_the_sizes_are_fitted_and_the_delay_is_said_to_be_unknown():
    measured = sw.fit.measured_bode(OMEGA, np.abs(plant(OMEGA)), phased=False)
    fit = sw.fit.fit_bode(measured, START)
    assert set(fit.values) == {"J_m", "J_l", "K", "B"}
    assert fit.values["K"] == pytest.approx(TRUE["K"], rel=1e-5)
    assert "no phase was measured" in str(fit)
    with pytest.raises(ValueError, match="delay is not identifiable"):
        fit.interval("delay")
    with pytest.raises(ValueError, match="delay is not identifiable"):
        sw.fit.fit_bode(measured, START, free=("K", "delay"))


def test_an_unknown_scale_leaves_ratios_alone():
    measured = sw.fit.measured_bode(OMEGA, 9.55 * plant(OMEGA))
    fit = sw.fit.fit_bode(
        measured, START._replace(motor=START.motor._replace(J=TRUE["J_m"])), free=("gain", "J_l", "K", "B", "delay")
    )
    assert fit.values["gain"] == pytest.approx(9.55, rel=1e-6)
    assert fit.values["J_l"] == pytest.approx(TRUE["J_l"], rel=1e-6)
    with pytest.raises(ValueError, match="up to a common factor only"):
        sw.fit.fit_bode(measured, START, free=("gain", "J_m", "J_l", "K", "B", "delay"))


def test_two_amplitudes_name_backlash_and_dry_friction(monkeypatch):
    small = sw.fit.measured_bode(OMEGA, 0.8 * plant(OMEGA), amplitude=0.1)  # 1 - 4 T_c/(pi T) of a describing function
    large = sw.fit.measured_bode(OMEGA, plant(OMEGA), amplitude=1.0)
    (sentence,) = sw.fit.fit_bode((large, small), START, free=()).dependence
    assert "factor 1.25: dry friction" in sentence
    monkeypatch.setitem(TRUE, "K", 0.6 * TRUE["K"])
    small = replace(small, value=plant(OMEGA))
    (sentence,) = sw.fit.fit_bode((large, small), START, free=()).dependence
    assert "resonance rises" in sentence
    assert "backlash" in sentence
    swapped = sw.fit.fit_bode((replace(large, amplitude=0.01), small), START, free=())
    assert "friction inside the gear" in swapped.dependence[0]


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"estimator": "H1"}, "it is the plain H1"),
        ({}, "the estimator is unknown"),
    ],
)
def test_a_response_of_a_closed_loop_is_said_to_be_biased_or_that_it_may_be(given, words):
    assert words in str(sw.fit.measured_bode(OMEGA, plant(OMEGA), **given))
    assert words not in str(sw.fit.measured_bode(OMEGA, plant(OMEGA), quantity="closed loop", **given))


@pytest.mark.parametrize(
    ("given", "words"),
    [
        (lambda: sw.fit.measured_bode(OMEGA[:3], np.ones(3)), "give 8 or more"),
        (lambda: sw.fit.measured_bode(np.append(OMEGA, OMEGA[0]), np.ones(61)), "each there once"),
        (lambda: sw.fit.measured_bode(OMEGA, 0.0 * OMEGA), "leave the frequency out"),
        (lambda: sw.fit.bode_of_records(H * np.arange(99), np.zeros(99), np.ones(99), np.ones(99)), "excites 0"),
        (lambda: sw.fit.bode_of_records(np.geomspace(1, 2, 99), OMEGA, OMEGA, OMEGA), "shape|length|99"),
        (lambda: sw.fit.fit_bode(sw.fit.measured_bode(OMEGA, plant(OMEGA)), START, free=("J",)), "of J_m, J_l"),
        (
            lambda: sw.fit.fit_bode(sw.fit.measured_bode(OMEGA, plant(OMEGA), quantity="open loop"), START),
            "has no loop; add a loop",
        ),
        (lambda: sw.fit.fit_bode([sw.fit.measured_bode(OMEGA, plant(OMEGA))] * 2, START), "different amplitudes"),
    ],
)  # fmt: skip
def test_what_makes_no_sense_is_refused_in_a_sentence(given, words):
    with pytest.raises(ValueError, match=words):
        given()
