"""The subharmonic of order 1/3 of the Duffing oscillator (Nayfeh & Mook 1979, Nonlinear Oscillations, sec. 4.1.4).

x'' + B x' + x + alpha x^3 = A cos(omega t) with B = .01, alpha = .2, A = 2. The book's first-order formulas give .86502
(stable) and .65905 at omega = 3.15; the true amplitudes beside them were found by tight shooting and printed to five
digits, as were the Floquet multipliers over the three forcing periods of the orbit.
"""

import numpy as np
import pytest

import strainwave as sw

OMEGA = 3.15
DUFFING = sw.Oscillator(1.0, 0.01, sw.Cubic(1.0, 0.2), sw.Harmonic(2.0), OMEGA)
HALF_DIGIT = 0.5e-5


def test_first_order_gives_the_printed_subharmonics():
    states = [s for s in sw.slow_flow(DUFFING, sw.SUBHARMONIC).steady_states() if s.amplitude > 0.0]
    assert [s.amplitude for s in states] == pytest.approx([0.86502, 0.65905], abs=HALF_DIGIT)
    assert [s.stable for s in states] == [True, False]


@pytest.mark.slow
def test_the_isola_is_closed_and_holds_both_printed_subharmonics():
    loops = sw.isolas(DUFFING, (3.0, 10.0))
    assert len(loops) == 1
    loop = loops[0]
    assert loop.closed
    assert loop.period == 3
    assert "slow flow" in loop.origin
    assert len(loop.folds) == 2
    here = np.flatnonzero(loop.omega == OMEGA)
    here = here[np.argsort(-loop.amplitude(1)[here])]
    largest = np.abs(loop.multipliers[:, 0])
    _, first = np.unique(np.round(loop.amplitude(1)[here], 9), return_index=True)
    low, high = here[first]
    assert loop.amplitude(1)[high] == pytest.approx(0.87516, abs=HALF_DIGIT)
    assert loop.amplitude(1)[low] == pytest.approx(0.66510, abs=HALF_DIGIT)
    assert loop.stable[high]
    assert not loop.stable[low]
    assert largest[high] == pytest.approx(0.9705, abs=0.5e-4)
    assert largest[low] == pytest.approx(1.2843, abs=0.5e-4)


@pytest.mark.slow
def test_the_loop_has_a_stable_and_an_unstable_half():
    loop = sw.isolas(DUFFING, (3.0, 10.0))[0]
    low, high = sorted(f.omega for f in loop.folds)
    assert loop.omega.min() == pytest.approx(low, rel=1e-12)
    assert loop.omega.max() == pytest.approx(high, rel=1e-12)
    inside = (loop.omega > low) & (loop.omega < high)
    changes = np.count_nonzero(np.diff(loop.stable[inside].astype(int)))
    assert changes in (1, 2)
    assert 0.2 < np.mean(loop.stable) < 0.8


def test_the_sweep_misses_the_loop():
    main = sw.frequency_response(DUFFING, (3.0, 4.0))
    assert main.period == 1
    assert main.doublings == main.branch_points == []  # nothing leads from it to the loop
    quiet = (main.omega > 3.0) & (main.omega < 4.0) & (main.amplitude(1) < 0.5)
    assert main.stable[quiet].all()
    ascending = np.argsort(main.omega[quiet])
    there = np.interp(OMEGA, main.omega[quiet][ascending], main.amplitude(1)[quiet][ascending])
    assert there == pytest.approx(0.22434, abs=1e-4)  # linear between points


def test_the_range_lies_in_the_bistable_band_of_the_primary_resonance():
    main = sw.frequency_response(DUFFING, (3.0, 4.0))
    # the damping is small, so that the loud motion lies near the backbone of one harmonic, w^2 = 1 + 3/4 alpha a^2
    loud = (np.abs(main.omega - OMEGA) < 0.02) & main.stable & (main.amplitude(1) > 1.0)
    backbone = np.sqrt((OMEGA**2 - 1.0) / 0.15)
    assert np.mean(main.amplitude(1)[loud]) == pytest.approx(backbone, rel=0.03)
    assert len(main.folds) == 2


def test_the_trivial_motion_has_the_printed_amplitude():
    orbit = sw.find_orbit(DUFFING)
    assert orbit.amplitude(1) == pytest.approx(0.22434, abs=HALF_DIGIT)
    assert orbit.stable
