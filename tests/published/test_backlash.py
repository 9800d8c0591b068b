"""Forced play: x'' + 0.1 x' + T(x) = 0.6 cos(omega t), T = 0 for |x| <= 0.5, x - 0.5 sign x outside.

Solved twice independently, by the exact flow of the pieces and by DOP853 with located switches, which agree to 7e-10.
"""

import math

import numpy as np
import pytest

import strainwave as sw

TIGHT = sw.Dopri5(rtol=1e-13, atol=1e-15)
HALF_GAP = 0.5


def system(omega):
    return sw.Oscillator(1.0, 0.1, sw.Backlash(1.0, HALF_GAP), sw.Harmonic(0.6), omega)


def after(omega, y, periods):
    return sw.simulate(system(omega), y, periods * 2.0 * math.pi / omega, method=TIGHT).y[:, -1]


@pytest.mark.slow
def test_orbit_from_rest_at_0_8_has_the_reference_values():
    omega, period = 0.8, 2.0 * math.pi / 0.8
    y = after(omega, (0.0, 0.0), 100)
    np.testing.assert_allclose(after(omega, y, 1), y, rtol=0, atol=1e-11)  # period 1

    steps = sw.simulate(system(omega), y, period, method=TIGHT)
    assert steps.peak() == pytest.approx(3.297722874, abs=1e-9)

    n = 4096
    x = sw.simulate(system(omega), y, np.arange(n + 1) * period / n, method=TIGHT).y[0, :-1]
    amplitudes = 2.0 * np.abs(np.fft.rfft(x)) / n
    assert amplitudes[1] == pytest.approx(3.260846925, abs=1e-9)
    assert amplitudes[3] == pytest.approx(0.042768294, abs=1e-9)


@pytest.mark.slow
def test_multipliers_of_the_orbit_are_those_of_the_period_map():
    omega, d = 0.8, 1e-4
    y = after(omega, (0.0, 0.0), 100)
    columns = [(after(omega, y + step, 1) - after(omega, y - step, 1)) / (2.0 * d) for step in d * np.eye(2)]
    multipliers = np.linalg.eigvals(np.array(columns).T)
    assert multipliers[0].real == pytest.approx(0.317168, abs=0.5e-6)
    assert abs(multipliers[0].imag) == pytest.approx(0.596106, abs=0.5e-6)
    assert abs(multipliers[0]) == pytest.approx(0.675231907, abs=1e-7)
    # Liouville: their product is exp(-B T/J), whatever the law.
    assert np.prod(multipliers).real == pytest.approx(math.exp(-0.1 * 2.0 * math.pi / omega), rel=1e-7)


@pytest.mark.slow
def test_above_1_0931653_orbits_float_inside_the_gap():
    # In the gap x'' + B x' = A cos(omega t): amplitude A/(omega sqrt(omega^2 + B^2)), which equals the half gap there.
    def floating_amplitude(omega):
        return 0.6 / (omega * math.hypot(omega, 0.1))

    assert floating_amplitude(1.0931653) == pytest.approx(HALF_GAP, abs=1e-7)

    omega = 1.2
    slack = HALF_GAP - floating_amplitude(omega)
    assert slack > 0.05
    for mean in (0.0, 0.04, -0.04):
        forced = 0.6 / (-omega * omega + 0.1j * omega)
        y = (mean + forced.real, (1j * omega * forced).real)
        run = sw.simulate(system(omega), y, 20.0 * 2.0 * math.pi / omega, method=TIGHT)
        assert run.switches == 0
        np.testing.assert_allclose(run.y[:, -1], y, rtol=0, atol=1e-11)  # every mean is kept: a multiplier of 1

    # Just below, it touches.
    omega = 1.09
    forced = 0.6 / (-omega * omega + 0.1j * omega)
    touching = sw.simulate(system(omega), (forced.real, (1j * omega * forced).real), 20.0, method=TIGHT)
    assert touching.switches > 0
