"""The second order of multiple scales against true motions: reference cases, order of convergence, transients."""

import cmath
import math
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import minimize_scalar

import strainwave as sw
from strainwave.theory.slow_flow.flow import SlowFlow

T4 = sw.Oscillator(1.0, 0.01, sw.Cubic(1.0, 0.2), sw.Harmonic(0.01), 1.05)
T7 = sw.Oscillator(1.0, 0.01, sw.Cubic(1.0, 0.2), sw.Harmonic(2.0), 3.15)
T18 = sw.Oscillator(1.0, 0.002, sw.Cubic(1.0, 0.05), sw.Harmonic(8.0), 3.4)
SAMPLES = 512
HARMONICS = 24


def true_motion(flow: SlowFlow, z: complex) -> np.ndarray:
    """Coefficients (complex, 0..H of the common period) of the true motion next to a state, by harmonic balance."""
    system, q = flow.system, flow.resonance.q
    t = 2.0 * np.pi * q / system.omega * np.arange(SAMPLES) / SAMPLES
    spectrum = np.fft.rfft(flow.steady_x(z, t))[: HARMONICS + 1] / SAMPLES
    speed = system.omega / q * np.arange(HARMONICS + 1)
    guess = np.empty((2 * HARMONICS + 1, 2))
    for state, s in enumerate((spectrum, 1j * speed * spectrum)):
        guess[0, state] = s[0].real
        guess[1::2, state], guess[2::2, state] = 2.0 * s[1:].real, -2.0 * s[1:].imag
    orbit = sw.find_orbit(system, harmonics=HARMONICS, guess=guess, period=q)
    c = np.array(orbit.coefficients)[:, 0]
    return np.concatenate([[c[0]], c[1::2] - 1j * c[2::2]])


def coefficients(flow: SlowFlow, z: complex) -> np.ndarray:
    """The same of the slow flow's motion."""
    t = 2.0 * np.pi * flow.resonance.q / flow.system.omega * np.arange(SAMPLES) / SAMPLES
    spectrum = np.fft.rfft(flow.steady_x(z, t))[: HARMONICS + 1] / SAMPLES
    return np.concatenate([spectrum[:1], 2.0 * spectrum[1:]])


def largest(flow: SlowFlow) -> complex:
    return flow.steady_states()[0].z


@pytest.mark.parametrize("A", [0.002, 0.005, 0.01, 0.02, 0.05])
def test_the_peak_is_ten_times_closer_than_at_first_order(A: float) -> None:
    """T5, against the highest point of the curve by harmonic balance."""
    system = T4._replace(excitation=sw.Harmonic(A))
    peaks = [sw.slow_flow(system, sw.PRIMARY, order=order).response((0.9, 3.0)).peak for order in (1, 2)]
    curve = sw.frequency_response(system, (0.9, 1.2 * peaks[1][0]), harmonics=15)
    true = float(np.max(curve.amplitude(1)))
    first, second = (abs(amplitude / true - 1.0) for _, amplitude in peaks)
    assert second < 0.1 * first


def test_subharmonic_states_of_t7_and_t18() -> None:
    """T7 to the digits of the reference; T18 nearer than first order."""
    stable, unstable = (state.amplitude for state in sw.slow_flow(T7, sw.SUBHARMONIC, order=2).steady_states()[:2])
    assert (stable, unstable) == (pytest.approx(0.87516, rel=5e-5), pytest.approx(0.66510, rel=5e-4))
    errors = []
    for order in (1, 2):
        flow = sw.slow_flow(T18, sw.SUBHARMONIC, order=order)
        z = largest(flow)
        errors.append(abs(abs(z) / abs(true_motion(flow, z)[1]) - 1.0))
    assert errors[1] < 0.01 * errors[0]


def _polynomial(eps: float, square: float = 0.2, cube: float = 0.1) -> sw.Polynomial:
    return sw.Polynomial((0.0, 1.0, square * eps, cube * eps))


# a system of every kind whose damping, nonlinearity, soft forcing and detuning are eps times as large
SCALED: dict[str, tuple[Any, sw.Resonance]] = {
    "superharmonic": (
        lambda e: sw.Oscillator(1.0, 0.2 * e, sw.Cubic(1.0, 0.1 * e), sw.Harmonic(1.0), (1.0 + 0.2 * e) / 3.0),
        sw.SUPERHARMONIC,
    ),
    "subharmonic": (
        lambda e: sw.Oscillator(1.0, 0.02 * e, sw.Cubic(1.0, 0.4 * e), sw.Harmonic(2.0), 3.0 + 0.3 * e),
        sw.SUBHARMONIC,
    ),
    "biased primary": (
        lambda e: sw.Oscillator(1.0, 0.4 * e, _polynomial(e, 0.4), sw.Harmonic(0.2 * e), 1.0 - 0.1 * e),
        sw.PRIMARY,
    ),
    "2:1": (
        lambda e: sw.Oscillator(1.0, 0.3 * e, _polynomial(e), sw.Harmonic(0.5), 0.5 * (1.0 + 0.3 * e)),
        sw.Resonance(2, 1),
    ),
    "1:2": (
        lambda e: sw.Oscillator(1.0, 0.02 * e, _polynomial(e, 0.5, 0.3), sw.Harmonic(1.0), 2.0 * (1.0 + 0.15 * e)),
        sw.Resonance(1, 2),
    ),
    "two orders": (
        lambda e: sw.Oscillator(
            1.0, 0.3 * e, _polynomial(e), sw.Harmonics((sw.Harmonic(0.3), sw.Harmonic(0.2 * e, 3, 0.7))),
            (1.0 + 0.2 * e) / 3.0,
        ),
        sw.SUPERHARMONIC,
    ),
    "kinematic error": (
        lambda e: sw.Oscillator(
            1.0, 0.3 * e, sw.Cubic(1.0, 0.4 * e), sw.Harmonic(0.0), 0.5 + 0.1 * e,
            sw.KinematicError((sw.Line(2, 0.2 * e, 0.4), sw.Line(1, 0.3))),
        ),
        sw.Resonance(2, 1),
    ),
    "fifth power": (
        lambda e: sw.Oscillator(
            1.0, 0.3 * e, sw.Polynomial((0.0, 1.0, 0.3 * e, 0.1 * e, 0.0, 0.1 * e)), sw.Harmonic(0.2 * e), 1.0 + 0.1 * e
        ),
        sw.PRIMARY,
    ),
}  # fmt: skip
SCALES = (0.08, 0.04, 0.02, 0.008)


@pytest.mark.parametrize("kind", SCALED)
def test_halving_the_small_quantities_divides_the_error_by_two_and_by_four(kind: str) -> None:
    """Slope of the error of the amplitude, of the complex amplitude and of the waveform: 1 and 2, within 15 %."""
    make, resonance = SCALED[kind]
    found: dict[int, list[tuple[float, float]]] = {1: [], 2: []}
    for eps in SCALES:
        flows = {order: sw.slow_flow(make(eps), resonance, order=order) for order in (1, 2)}
        second = largest(flows[2])
        true = true_motion(flows[2], second)
        fast = resonance.p
        for order, flow in flows.items():
            z = min((s.z for s in flow.steady_states()), key=lambda z: abs(z - second))
            wave = coefficients(flow, z)
            found[order].append((abs(wave[fast] - true[fast]), float(np.linalg.norm(wave - true))))
    for order in (1, 2):
        for error in np.log(np.array(found[order])).T:
            slope = np.polyfit(np.log(SCALES), error, 1)[0]
            assert slope == pytest.approx(order, rel=0.15)


@pytest.mark.slow
def test_the_speed_of_the_peak_is_of_second_and_of_third_order() -> None:
    errors = {1: [], 2: []}
    for eps in (0.4, 0.2, 0.1, 0.04):
        system = sw.Oscillator(1.0, 0.1 * eps, sw.Cubic(1.0, 0.2 * eps), sw.Harmonic(0.1 * eps), 1.0)
        peaks = {o: sw.slow_flow(system, sw.PRIMARY, order=o).response((0.9, 1.3)).peak for o in (1, 2)}
        flow = sw.slow_flow(system._replace(omega=peaks[2][0]), sw.PRIMARY, order=2)

        def height(omega: float, flow: SlowFlow = flow) -> float:
            moved = sw.slow_flow(flow.system._replace(omega=omega), sw.PRIMARY, order=2)
            return -abs(true_motion(moved, largest(moved))[1])

        width = 0.02 * eps
        true = minimize_scalar(height, bracket=(peaks[2][0] - width, peaks[2][0], peaks[2][0] + width), tol=1e-9).x
        for order in (1, 2):
            errors[order].append(abs(peaks[order][0] - true))
    for order in (1, 2):
        slope = np.polyfit(np.log((0.4, 0.2, 0.1, 0.04)), np.log(errors[order]), 1)[0]
        assert slope > (order + 1) * 0.85


def test_transients_follow_the_equation_a_hundred_times_closer() -> None:
    """From rest through the beats to the steady motion, against DOP853 with an equation of its own."""
    system = sw.Oscillator(1.0, 0.05, sw.Cubic(1.0, 0.2), sw.Harmonic(0.05), 1.05)
    t = np.linspace(0.0, 200.0, 2001)
    exact = solve_ivp(
        lambda t, y: (y[1], 0.05 * math.cos(1.05 * t) - 0.05 * y[1] - y[0] - 0.2 * y[0] ** 3),
        (0.0, 200.0), (0.5, 0.2), method="DOP853", rtol=1e-11, atol=1e-12, t_eval=t,
    )  # fmt: skip
    errors = []
    for order in (1, 2):
        found = sw.slow_flow(system, sw.PRIMARY, order=order).evolve((0.5, 0.2), t)
        assert found.x[0] == pytest.approx(0.5, abs=1e-9)
        assert found.rate[0] == pytest.approx(0.2, abs=1e-6)
        errors.append(float(np.sqrt(np.mean((found.x - exact.y[0]) ** 2) / np.mean(exact.y[0] ** 2))))
    assert errors[1] < 0.01 * errors[0]


def test_a_linear_drive_is_exact_at_second_order() -> None:
    """The damping and the detuning are not expanded: the steady state is the linear response to rounding."""
    system = sw.Oscillator(2.0, 0.6, sw.Linear(8.0), sw.Harmonic(0.3, phase=0.4), 1.4)
    state = sw.slow_flow(system, sw.PRIMARY, order=2).steady_states()[0]
    true = 0.3 * cmath.exp(0.4j) / (8.0 - 2.0 * 1.4**2 + 0.6j * 1.4)
    assert state.z == pytest.approx(true, rel=1e-12)
    assert state.stable


def test_the_second_order_knows_a_fifth_superharmonic() -> None:
    """5 omega = omega_0 of a cubic law: first order does not know it, the true motion has it."""
    system = sw.Oscillator(1.0, 0.02, sw.Cubic(1.0, 0.05), sw.Harmonic(0.5), 0.201)
    with pytest.raises(ValueError, match="does not appear at first order"):
        sw.slow_flow(system, sw.Resonance(5, 1))
    flow = sw.slow_flow(system, sw.Resonance(5, 1), order=2)
    z = largest(flow)
    assert abs(z) == pytest.approx(abs(true_motion(flow, z)[5]), rel=0.2)


def test_an_invalid_superharmonic_is_flagged_and_the_balance_is_the_answer() -> None:
    """B .01, alpha .2, A .5: first order puts .9833 at .3744; the second order and the balance do not."""
    system = sw.Oscillator(1.0, 0.01, sw.Cubic(1.0, 0.2), sw.Harmonic(0.5), 0.3744)
    first = sw.slow_flow(system, sw.SUPERHARMONIC)
    assert first.steady_states()[0].amplitude == pytest.approx(0.9833, abs=2e-4)
    assert not first.certificate().valid
    second = sw.slow_flow(system, sw.SUPERHARMONIC, order=2)
    assert second.certificate().valid
    orbit = sw.find_orbit(system, harmonics=15)
    assert second.steady_states()[0].amplitude == pytest.approx(orbit.amplitude(3), rel=0.06)


@pytest.mark.parametrize("omega", [0.05, 0.2, 0.38, 0.9, 1.7])
def test_a_linear_drive_is_stable_at_every_speed(omega: float) -> None:
    """Its exact eigenvalues are -mu/2 +- i omega_0, whatever the forcing does."""
    system = sw.Oscillator(1.0, 0.05, sw.Linear(1.0), sw.Harmonic(0.1), omega)
    assert all(state.stable for state in sw.slow_flow(system, sw.PRIMARY, order=2).steady_states())
    assert sw.slow_flow(system, sw.PRIMARY, order=2).states_at([omega]).stable.all()


def test_a_linear_transient_is_right_beside_resonance_and_refused_far_from_it() -> None:
    """What z'' leaves out turns the free part by t sigma (sigma/(2 omega_0))^2 = 4e-4 rad in 60 s."""
    system = sw.Oscillator(1.0, 0.05, sw.Linear(1.0), sw.Harmonic(0.1), 0.97)
    t = np.linspace(0.0, 60.0, 601)
    exact = solve_ivp(
        lambda t, y: (y[1], 0.1 * math.cos(0.97 * t) - 0.05 * y[1] - y[0]), (0.0, 60.0), (0.0, 0.0),
        method="DOP853", rtol=1e-11, atol=1e-13, t_eval=t,
    )  # fmt: skip
    found = sw.slow_flow(system, sw.PRIMARY, order=2).evolve((0.0, 0.0), t)
    assert np.max(np.abs(found.x - exact.y[0])) < 1e-3 * np.max(np.abs(exact.y[0]))
    with pytest.raises(sw.SolveError, match="too far from resonance"):
        sw.slow_flow(system._replace(omega=0.1), sw.PRIMARY, order=2).evolve((0.0, 0.0), t)


def test_states_whose_small_harmonics_are_larger_than_they_are_none() -> None:
    """Far below resonance one state of 0.05 rad: the polynomial of second order has two more near 5 rad."""
    system = sw.Oscillator(1.0, 0.02, sw.Cubic(1.0, 0.2), sw.Harmonic(0.05), 0.03)
    flow = sw.slow_flow(system, sw.PRIMARY, order=2)
    assert [state.amplitude for state in flow.steady_states()] == [pytest.approx(0.05, rel=0.01)]
    assert flow.certificate().valid


def test_orders_that_need_too_many_samples_are_refused() -> None:
    system = sw.Oscillator(
        1.0, 0.02, sw.Cubic(1.0, 0.2), sw.Harmonic(0.05), 1.1, sw.KinematicError((sw.Line(2000, 1e-9),))
    )
    with pytest.raises(ValueError, match=r"2000 harmonics of their common period.*take order=1"):
        sw.slow_flow(system, sw.PRIMARY, order=2)


def test_a_stable_subharmonic_is_stable_though_the_fast_duplicate_of_its_motion_is_not():
    # the multipliers of the true orbit have the size .9645; DOP853 stays on it for 180 periods of the forcing
    law = sw.Polynomial((0.0, 1.0, 0.0, 0.08359100781854155, 0.0, 0.030775370095585154))
    torque = sw.Harmonic(2.9164640023532273, mean=0.9159086888861673)
    system = sw.Oscillator(1.0, 0.01599702477791857, law, torque, 4.173223153619007)
    state = sw.slow_flow(system, sw.SUBHARMONIC, order=2).steady_states()[0]
    assert state.amplitude == pytest.approx(2.1378, rel=1e-3)
    assert state.stable
