"""Margins of a measured loop, against its own two masses: a dense Nyquist plot and roots of polynomials."""

import numpy as np
import pytest

import strainwave as sw

J_M, J_L, N, K, B = 4.5e-4, 1.3, 100.0, 1e5, 20.0
LOAD = np.poly1d([J_L, B, K])
DEN = np.poly1d([J_M, B / N**2, K / N**2]) * LOAD - np.poly1d([B, K]) ** 2 * (1.0 / N**2)
HZ = np.geomspace(3.0, 2000.0, 900)
WIDE = np.geomspace(0.003, 3000.0, 4000)


def loop(hz, gain=0.12, T_n=0.016, delay=2e-4, more=0):
    """A PI loop of the motor's speed, with more integrators."""
    s = 2j * np.pi * np.asarray(hz)
    pi = (1.0 + 1.0 / (T_n * s)) ** (1 + more) * gain
    return pi * s * LOAD(s) / DEN(s) * np.exp(-s * delay)


def measured(value, quantity="open loop", hz=HZ):
    return sw.fit.measured_bode(2.0 * np.pi * hz, value, quantity=quantity)


def dense(**loop_of):
    """Gain crossings [Hz] with phase margins [deg], phase crossings [Hz] with gain margins, peak sensitivity."""
    hz = np.geomspace(HZ[0], HZ[-1], 2_000_001)
    L = loop(hz, **loop_of)
    gain = np.flatnonzero((np.abs(L[1:]) - 1.0) * (np.abs(L[:-1]) - 1.0) < 0.0)
    phase = np.flatnonzero((L.imag[1:] * L.imag[:-1] < 0.0) & (L.real[:-1] < 0.0))
    return hz[gain], np.degrees(np.angle(-L[gain])), hz[phase], 1.0 / np.abs(L[phase]), np.max(1.0 / np.abs(1.0 + L))


@pytest.mark.parametrize("loop_of", [{}, {"gain": 0.4}, {"delay": 1e-3}, {"T_n": 0.005}, {"gain": 0.02}])
@pytest.mark.parametrize("quantity", ["open loop", "closed loop"])
def test_margins_of_a_measured_loop_are_those_of_a_dense_nyquist_plot(loop_of, quantity):
    L = loop(HZ, **loop_of)
    judged = measured(L if quantity == "open loop" else L / (1.0 + L), quantity).margins()
    found, (gain, phases, crossing, factors, peak) = judged.margins, dense(**loop_of)
    assert found.gain_crossings / (2.0 * np.pi) == pytest.approx(gain, rel=1e-4)
    assert np.degrees(found.phase_margins) == pytest.approx(phases, abs=0.1)
    assert found.phase_crossings / (2.0 * np.pi) == pytest.approx(crossing, rel=1e-4)
    assert found.gain_margins == pytest.approx(factors, rel=1e-3)
    assert found.peak_sensitivity == pytest.approx(peak, rel=1e-3)
    assert not judged.doubts


@pytest.mark.parametrize("more", [0, 1])
def test_a_measured_loop_is_stable_where_its_polynomial_is(more):
    stable, answers = [], []
    for gain in np.geomspace(1e-3, 1.0, 13):
        for T_n in (0.003, 0.02, 0.1):
            pi = (np.poly1d([T_n, 1.0]) ** (1 + more)) * gain
            closed = np.poly1d([T_n, 0.0]) ** (1 + more) * DEN + pi * np.poly1d([1.0, 0.0]) * LOAD
            roots = closed.roots[np.abs(closed.roots) > 1e-6]  # the zero at 0 is that of the integrator
            stable.append(bool(np.all(roots.real < 0.0)))
            answers.append(measured(loop(WIDE, gain, T_n, 0.0, more), hz=WIDE).margins().margins.stable)
    assert answers == stable
    assert {*stable} == ({True, False} if more else {True})


def test_small_margins_and_coarse_frequencies_are_told():
    judged = measured(loop(HZ, gain=0.4, delay=1.5e-3)).margins()
    assert judged.margins.stable
    assert judged.weak.startswith(
        "The loop is close to instability: peak sensitivity 12.6 (at most 2), phase margin 7.6°"
    )
    assert not measured(loop(HZ)).margins().weak
    few = np.geomspace(3.0, 1000.0, 140)
    coarse = sw.fit.measured_bode(2.0 * np.pi * few, loop(few), quantity="open loop").margins()
    (doubt,) = coarse.doubts  # at the antiresonance of the load, where the phase turns within a hertz
    assert "47.4" in doubt
    with pytest.raises(ValueError, match="it is that of the plant alone"):
        measured(loop(HZ), "plant").margins()
    with pytest.raises(ValueError, match="it has no phase"):
        sw.fit.measured_bode(HZ, np.abs(loop(HZ)), quantity="open loop", phased=False).margins()
