"""Largest Lyapunov exponents: closed forms, Floquet multipliers, and chaos by two independent methods."""

from typing import NamedTuple

import numpy as np
import pytest

import strainwave as sw
from strainwave.numerics.attractors import settle
from strainwave.numerics.attractors.settle import stretching

UEDA = sw.Oscillator(1.0, 0.05, sw.Polynomial((0.0, 0.0, 0.0, 1.0)), sw.Harmonic(7.5), 1.0)


@pytest.mark.slow
def test_a_damped_linear_oscillator_has_half_its_damping():
    """Both exponents of J x'' + B x' + K x are -B/(2J) below critical damping, the larger root above."""
    under = sw.Oscillator(2.0, 0.3, sw.Linear(5.0), sw.Harmonic(1.0), 1.3)
    found = sw.numerics.lyapunov_exponent(under, (0.0, 0.0), turns=400)
    assert abs(found.value + 0.075) < 2e-5
    assert abs(found.value + 0.075) < 4.0 * found.standard_error
    over = under._replace(B=20.0)
    root = (-20.0 + np.sqrt(400.0 - 40.0)) / 4.0
    assert sw.numerics.lyapunov_exponent(over, (0.0, 0.0), turns=40).value == pytest.approx(root, rel=1e-7)


@pytest.mark.slow
def test_of_a_periodic_orbit_it_is_the_logarithm_of_the_largest_multiplier():
    system = sw.Oscillator(1.0, 0.1, sw.Cubic(1.0, 0.05), sw.Harmonic(1.0), 1.0)
    branch = sw.frequency_response(system, (0.6, 2.0))
    real = np.max(np.abs(branch.multipliers.imag), axis=1) < 1e-9
    place = int(np.flatnonzero(real & branch.stable & (np.abs(branch.multipliers[:, 0]) < 0.99))[0])
    near = system._replace(omega=float(branch.omega[place]))
    orbit = sw.find_orbit(near, guess=branch.coefficients[place])
    assert orbit.stable
    assert abs(orbit.multipliers[0].imag) < 1e-9
    found = sw.numerics.lyapunov_exponent(near, orbit.state(0.0), turns=40, settle=100)
    wanted = np.log(abs(orbit.multipliers[0])) * near.omega / (2.0 * np.pi)
    assert found.value == pytest.approx(wanted, rel=1e-5)


@pytest.mark.slow
def test_a_disturbance_that_turns_in_step_with_the_blocks_is_in_the_standard_error():
    """Multipliers exp((-B/(2J) +- i w) T): after five turns the disturbance points almost as before."""
    law = sw.PiecewiseLinear(67000.0, 110000.0, 120000.0, 29.0, 108.0)
    lines = sw.KinematicError((sw.Line(1, 1.94e-5, 0.698), sw.Line(2, 8.24e-5), sw.Line(4, 1.45e-5, 1.571)))
    system = sw.Oscillator(2.4, 20.05, law, sw.Harmonic(0.0), 97.39, error=lines)
    found = sw.numerics.lyapunov_exponent(system, (2e-3, 0.0), turns=100, settle=100)
    assert abs(found.value + 20.05 / 4.8) < 2.0 * found.standard_error
    assert found.standard_error < 0.1


@pytest.mark.slow
def test_chaos_by_the_variational_equation_and_by_two_trajectories():
    tangent = sw.numerics.lyapunov_exponent(UEDA, (2.5, 0.0), turns=6000)
    starts = np.array([[2.5], [0.0]]) + 0.01 * np.random.default_rng(0).normal(size=(2, 64))
    rates, _ = stretching(UEDA, {}, starts, stretches=200)
    means = np.mean(rates[50:], axis=0)
    error = np.hypot(tangent.standard_error, np.std(means, ddof=1) / 8.0)
    assert tangent.value > 20.0 * tangent.standard_error
    assert abs(tangent.value - np.mean(means)) < 3.0 * error
    assert error < 0.03 * tangent.value
    assert "chaotic" in str(tangent)


class Lorenz(NamedTuple):
    """Three states, no jacobian, no base frequency."""

    sigma: float
    rho: float
    beta: float

    def rhs(self, phase, y):
        a, b, c = y
        return self.sigma * (b - a), a * (self.rho - c) - b, a * b - self.beta * c


@pytest.mark.slow
def test_a_system_without_jacobian_takes_a_neighbour():
    """Viswanath 1998, thesis, Cornell: Lorenz's system has the exponent 0.905630."""
    found = sw.numerics.lyapunov_exponent(Lorenz(10.0, 28.0, 8.0 / 3.0), (1.0, 1.0, 20.0), turns=300, settle=10)
    assert found.standard_error < 0.01
    assert abs(found.value - 0.90563) < 3.0 * found.standard_error


@pytest.mark.parametrize(
    ("change", "sentence"),
    [({"turns": 5}, "at least 20"), ({"settle": 0}, "settle is 0"), ({"y0": (np.nan, 0.0)}, "finite")],
)
def test_bad_input_is_one_sentence(change, sentence):
    arguments = {"y0": (0.0, 0.0)} | change
    with pytest.raises(ValueError, match=sentence):
        sw.numerics.lyapunov_exponent(UEDA, **arguments)


@pytest.mark.compiled
def test_a_motion_that_runs_away_is_an_error_with_a_sentence():
    soft = sw.Oscillator(1.0, 0.1, sw.Cubic(1.0, -1.0), sw.Harmonic(0.1), 1.0)
    with pytest.raises(sw.SolveError, match="the motion ended"):
        sw.numerics.lyapunov_exponent(soft, (3.0, 0.0), turns=20)


@pytest.mark.interpreted
@pytest.mark.parametrize(
    ("turns", "most", "sentence"),
    [
        (
            1_000_000,
            45_000,
            "1000010 turns of [0-9]+ steps, .* are too many: at most 0 steps a turn; .* take fewer turns",
        ),
        (100, 10, "110 turns of [0-9]+ steps, .* are too many: at most 10 steps a turn; start closer"),
    ],
)
def test_turns_that_take_minutes_are_refused_before_they_are_marched(turns, most, sentence, monkeypatch):
    monkeypatch.setattr(settle, "MOST_STRETCHED", most)
    system = sw.Oscillator(1.0, 0.05, sw.Cubic(1.0, 0.1), sw.Harmonic(0.5), 1.2)
    with pytest.raises(sw.SolveError, match=sentence):
        stretching(system, {}, np.array([[0.1], [0.0]]), stretches=turns)
