"""Isolas: what is found, what is left out, and what is said about it."""

import numpy as np
import pytest

import strainwave as sw

DUFFING = sw.Oscillator(1.0, 0.01, sw.Cubic(1.0, 0.2), sw.Harmonic(2.0), 3.15)


@pytest.mark.compiled
def test_the_loop_does_not_depend_on_the_range_asked_for():
    wide, narrow = (sw.isolas(DUFFING, span)[0] for span in ((3.0, 10.0), (3.1, 3.3)))
    assert wide.closed
    assert narrow.closed
    assert sorted(f.omega for f in narrow.folds) == pytest.approx(sorted(f.omega for f in wide.folds), rel=1e-8)


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
def test_a_branch_born_at_period_doublings_says_where_it_begins():
    biased = sw.Oscillator(1.0, 0.02, sw.Cubic(1.0, 0.2), sw.Harmonic(2.0, mean=0.5), 2.0)
    (branch,) = sw.isolas(biased, (1.8, 3.0), resonance=sw.Resonance(1, 2))
    main = sw.frequency_response(biased, (1.8, 3.0))
    assert not branch.closed
    assert "meets the response of one turn" in branch.message
    doublings = [d.omega for d in main.doublings]
    for end in (branch.omega[0], branch.omega[-1]):
        assert min(abs(end - d) for d in doublings) < 1e-2


def test_a_range_through_zero_is_refused():
    with pytest.raises(ValueError, match="0 < low < high"):
        sw.isolas(DUFFING, (0.0, 1.0))
