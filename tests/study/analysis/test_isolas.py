"""Isolas: what is found, what is left out, and what is said about it."""

import re

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import strainwave as sw
from strainwave.study.analysis.isolas import has_period, speeds

DUFFING = sw.Oscillator(1.0, 0.01, sw.Cubic(1.0, 0.2), sw.Harmonic(2.0), 3.15)
TWO_WELLS = sw.Oscillator(1.0, 0.15, sw.Cubic(-1.0, -1.0), sw.Harmonic(0.2), 1.4)  # every stable motion is in a well


def settled_wave(omega, start, turns, n):
    """TWO_WELLS by SciPy's DOP853: 64 samples a turn of the last n turns of x."""
    t = 2.0 * np.pi / omega * (turns + np.arange(64 * n) / 64)

    def rates(t, y):
        return y[1], 0.2 * np.cos(omega * t) - 0.15 * y[1] + y[0] - y[0] ** 3

    return solve_ivp(rates, (0.0, t[-1]), start, "DOP853", t_eval=t, rtol=1e-10, atol=1e-12).y[0]


def waves_at(branch, omega):
    """Samples of x like those of `settled_wave` of every point of a branch at a frequency."""
    theta = 2.0 * np.pi * np.arange(64 * branch.period) / 64 / branch.period
    k = np.arange(1, branch.coefficients.shape[1] // 2 + 1)
    rows = branch.coefficients[branch.omega == omega]
    return rows[:, :1] + rows[:, 1::2] @ np.cos(np.outer(k, theta)) + rows[:, 2::2] @ np.sin(np.outer(k, theta))


def is_among(wave, waves, n):
    """Whether a motion of n turns, or a copy shifted by turns or mirrored half a turn later, is among waves."""
    copies = [sign * np.roll(wave, 64 * i + 32 * (sign < 0)) for i in range(n) for sign in (1, -1)]
    return any(np.max(np.abs(copy - w)) < 1e-5 for copy in copies for w in waves)


@pytest.mark.slow
@pytest.mark.parametrize("span", [(0.5, 2.0), (0.3, 3.0)])
def test_motions_in_the_wells_are_found_whatever_the_range(span):
    loops = sw.isolas(TWO_WELLS, span, resonance=sw.PRIMARY)
    wave = settled_wave(1.4, (1.0, 0.0), 60, 1)
    assert is_among(wave, [w for b in loops for w in waves_at(b, 1.4)], 1)
    assert not is_among(wave, waves_at(sw.frequency_response(TWO_WELLS, span), 1.4), 1)
    folds = [f.omega for b in loops for f in b.folds]
    assert min(abs(f - 1.06666265) for f in folds) < 1e-6  # the band of the in-well branch does not depend on the range


@pytest.mark.slow
def test_random_starts_alone_lead_to_motions_of_three_turns(monkeypatch):
    """From rest between the wells the motion settles on one of three turns; the slow flow seeds none of these."""
    monkeypatch.setattr("strainwave.study.analysis.isolas.free_seeds", lambda *_: iter(()))
    omega = 2.0 ** (5 / 8)
    here = TWO_WELLS._replace(omega=omega)
    loops = sw.isolas(here, (1.0, 2.0))
    wave = settled_wave(omega, (0.0, 0.0), 120, 3)
    assert np.max(np.abs(wave - np.roll(wave, 64))) > 0.1
    assert is_among(wave, [v for b in loops for v in waves_at(b, omega)], 3)
    assert all(b.origin.startswith("reached from random initial states") for b in loops)


@pytest.mark.slow
def test_a_sentence_says_what_was_searched():
    loops = sw.isolas(TWO_WELLS, (1.0, 2.0), resonance=sw.PRIMARY)
    assert "searched at 10 speeds, omega = 1 .. 2 rad/s" in loops.message
    assert "100 random starts" in loops.message
    assert "motions of 3 turns" in loops.message
    assert re.search(
        r"\d+ starts, at omega = 1.0905\d* rad/s, did not settle on a period of up to 8 turns", loops.message
    )
    assert str(loops).endswith(loops.message)
    again = sw.isolas(TWO_WELLS, (1.0, 2.0), resonance=sw.PRIMARY)
    assert again.message == loops.message
    assert all(np.array_equal(a.coefficients, b.coefficients) for a, b in zip(loops, again, strict=True))


def test_a_wider_range_is_searched_at_the_same_speeds_and_more():
    wide, narrow = speeds(1.4, 0.3, 3.0), speeds(1.4, 1.1, 2.7)
    assert set(narrow[1:-1]) <= set(wide)
    assert 1.4 in narrow
    assert len(speeds(9.0, 1.0, 1.01)) >= 8


def test_an_orbit_of_two_turns_is_none_of_four():
    point = np.zeros(2 * 8 + 2)  # mean, cosines and sines of eight harmonics, and the frequency
    point[4], point[2] = 1.0, 0.1  # of the base angle, and of half of it
    assert not has_period(point, 4)
    point[1] = 0.1
    assert has_period(point, 4)


@pytest.mark.slow
def test_the_loop_does_not_depend_on_the_range_asked_for():
    wide, narrow = (sw.isolas(DUFFING, span)[0] for span in ((3.0, 10.0), (3.1, 3.3)))
    assert wide.closed
    assert narrow.closed
    assert sorted(f.omega for f in narrow.folds) == pytest.approx(sorted(f.omega for f in wide.folds), rel=1e-8)


@pytest.mark.slow
def test_orbits_of_the_loop_take_three_turns():
    loop = sw.isolas(DUFFING, (3.0, 4.0))[0]
    at = int(np.flatnonzero((loop.omega == 3.15) & loop.stable)[0])
    x = np.stack([loop.coefficients[at], 0.0 * loop.coefficients[at]], axis=1)
    orbit = sw.find_orbit(DUFFING, guess=x, period=3)
    assert orbit.amplitude(1) == pytest.approx(loop.amplitude(1)[at], rel=1e-6)
    assert orbit.amplitude(3) == pytest.approx(0.22434, rel=0.1)  # the forced part, much as in the trivial motion


@pytest.mark.slow
def test_strong_damping_leaves_no_loop():
    assert sw.isolas(DUFFING._replace(B=0.5), (2.9, 4.0)) == []


@pytest.mark.slow
def test_a_superharmonic_resonance_is_part_of_the_main_branch():
    assert sw.isolas(DUFFING._replace(B=0.1), (0.25, 0.5), resonance=sw.SUPERHARMONIC) == []


@pytest.mark.slow
def test_a_resonance_unknown_to_first_order_is_seeded_by_free_vibration():
    # 1:2 of an odd law appears at second order only
    loops = sw.isolas(DUFFING, (1.8, 2.5), resonance=sw.Resonance(1, 2))
    assert len(loops) == 1
    assert loops[0].closed
    assert loops[0].period == 2
    assert "free vibration" in loops[0].origin
    assert loops[0].amplitude(1).min() > 0.1


@pytest.mark.slow
@pytest.mark.parametrize("points", [150, 200])  # where its steps meet the crossing is chance
def test_a_branch_born_at_period_doublings_says_where_it_begins(points):
    biased = sw.Oscillator(1.0, 0.02, sw.Cubic(1.0, 0.2), sw.Harmonic(2.0, mean=0.5), 2.0)
    (branch,) = sw.isolas(biased, (1.8, 3.0), resonance=sw.Resonance(1, 2), points=points)
    main = sw.frequency_response(biased, (1.8, 3.0))
    assert not branch.closed
    assert "meets the response of one turn" in branch.message
    doublings = [d.omega for d in main.doublings]
    for end in (branch.omega[0], branch.omega[-1]):
        assert min(abs(end - d) for d in doublings) < 1e-6
    assert [fold.omega for fold in branch.folds] == [pytest.approx(3.08569033, abs=1e-8)]  # none of the crossing


def test_a_range_through_zero_is_refused():
    with pytest.raises(ValueError, match="0 < low < high"):
        sw.isolas(DUFFING, (0.0, 1.0))
