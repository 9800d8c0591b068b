"""The source article's four cases, integrated: what its Table 4 should have said, and by SciPy, sampled densely."""

import math
from functools import cache

import numpy as np
import pytest
from article_cases import CASES, A, derived, half_digit
from scipy.integrate import solve_ivp

import strainwave as sw

TIGHT = sw.Dopri5(rtol=1e-11, atol=1e-16)
each_case = pytest.mark.parametrize("case", CASES.values(), ids=CASES.keys())


def to_its_digits(text):
    """The number, and half a unit of its last digit as the tolerance."""
    return pytest.approx(float(text), abs=half_digit(text))


def largest_by_scipy(system, near):
    """Largest |x| within a period of the free vibration around a time, by DOP853 from rest."""
    around = 2.0 * math.pi / max(system.omega, math.sqrt(system.law.K / system.J))
    times = np.linspace(max(0.0, near - around), near + around, 20001)
    motion = solve_ivp(
        lambda t, y: system.rhs(system.omega * t, (y[0], y[1])),
        (0.0, times[-1]), (0.0, 0.0), method="DOP853", rtol=1e-11, atol=1e-15, t_eval=times,
    )  # fmt: skip
    return np.max(np.abs(motion.y[0]))


@cache
def steady(system):
    """Peak of the steady motion and amplitudes at multiples of omega/3, over three periods after 60/mu."""
    period = 2.0 * math.pi / system.omega
    decayed = math.ceil(60.0 * system.J / system.B / period) * period
    y = sw.simulate(system, (0.0, 0.0), [0.0, 0.5 * decayed, decayed], method=TIGHT).y[:, -1]
    peak = sw.simulate(system, y, 3.0 * period, method=TIGHT).peak()
    n = 6000
    x = sw.simulate(system, y, np.arange(n + 1) * 3.0 * period / n, method=TIGHT).y[0, :-1]
    return peak, 2.0 * np.abs(np.fft.rfft(x)) / n


@pytest.mark.slow
@each_case
def test_largest_error_from_rest(case):
    system = case.system
    run = sw.simulate(system, (0.0, 0.0), 30.0 * system.J / system.B)
    assert run.status
    assert 0.9999 * float(case.largest) < run.peak() < 1.0003 * float(case.largest)
    assert run.peak() == pytest.approx(largest_by_scipy(system, run.t[np.argmax(np.abs(run.y[0]))]), rel=1e-7)


@pytest.mark.slow
@each_case
def test_steady_peak_and_harmonics(case):
    peak, amplitudes = steady(case.system)
    assert peak == pytest.approx(float(case.peak), rel=3e-5)  # taken at output times as well
    assert amplitudes[3] == to_its_digits(case.at_omega)
    if case.at_3_omega:
        assert amplitudes[9] == to_its_digits(case.at_3_omega)


@pytest.mark.slow
@pytest.mark.parametrize(("name", "bound"), [("derived, subharmonic", 1e-9), ("printed, subharmonic", 1e-7)])
def test_no_steady_subharmonic_is_left(name, bound):
    # The article speaks of a steady component at omega/3; it is a transient.
    _, amplitudes = steady(CASES[name].system)
    assert amplitudes[1] < bound


def test_parameters_that_follow_from_the_articles_table_3():
    # The article prints 0.129 1/s, 37.2 rad/s (5.92 Hz), and "varies with omega".
    drive = sw.HDC_40_050
    assert drive.mu == to_its_digits("0.352928")
    assert drive.omega_0 == to_its_digits("385.545")
    assert drive.omega_0 / (2.0 * math.pi) == to_its_digits("61.36")
    system = derived(10.47)
    assert system.excitation.amplitude / system.J == to_its_digits("380.228")
    assert A / drive.omega_0**2 == to_its_digits("2.558e-3")


def test_torque_of_the_error_equation_is_corrected():
    # x'' = theta_m''/N - theta_l'': F = T_m/(N J_m) - T_l/J_l. The article has (T_m J_l - T_l J_m)/(N J_m J_l).
    drive = sw.HDC_40_050
    system = drive.error_equation(motor_torque=sw.Harmonic(10.0), load_torque=sw.Harmonic(3.0))
    F = system.excitation.torque(0.0) / system.J
    assert pytest.approx(10.0 / (drive.N * drive.J_m) - 3.0 / drive.J_l, rel=1e-14) == F


@pytest.mark.slow
def test_the_articles_non_resonant_value_shows_which_parameters_its_authors_used():
    # Table 4 prints 4.8e-3 rad at 10.47 rad/s: 6 % from the derived set, a hundredth of what the printed set gives.
    largest = {name: sw.simulate(case.system, (0, 0), 30.0).peak() for name, case in CASES.items()}
    assert abs(4.8e-3 / largest["derived, non-resonant"] - 1.0) < 0.065
    assert largest["printed, non-resonant"] > 100 * 4.8e-3
