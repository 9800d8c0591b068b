"""Measured response curves: SciPy's integrator with the equation and harmonic balance."""

import math
from functools import cache

import numpy as np
import pytest
from scipy import stats
from scipy.integrate import solve_ivp

import strainwave as sw
from strainwave.base.quantities import parameters
from strainwave.study.identification.response_curve.response_fit import jumps_of, sweeps

pytestmark = pytest.mark.compiled

TRUE = {"B": 0.05, "law.K": 1.0, "law.alpha": 0.1, "excitation.amplitude": 0.18}
SYSTEM = sw.Oscillator(1.0, 0.05, sw.Cubic(1.0, 0.1), sw.Harmonic(0.18), 1.0)
GUESS = sw.Oscillator(1.0, 0.07, sw.Cubic(1.2, 0.07), sw.Harmonic(0.2), 1.0)
FREE = tuple(TRUE)


def reached(system, low, high, points):
    """Frequencies of a sweep up and one down, and the first harmonics of the motions that they reach."""
    curve = sw.frequency_response(system, (0.99 * low, 1.01 * high), harmonics=9)
    omega, found = [], []
    for rising in (True, False):
        forward = rising == (curve.omega[0] < curve.omega[-1])
        for w in np.linspace(low, high, points)[:: 1 if rising else -1]:
            i = np.flatnonzero((curve.omega[:-1] - w) * (curve.omega[1:] - w) <= 0.0)[0 if forward else -1]
            share = (w - curve.omega[i]) / (curve.omega[i + 1] - curve.omega[i])
            guess = (1.0 - share) * curve.coefficients[i] + share * curve.coefficients[i + 1]
            orbit = sw.find_orbit(system._replace(omega=float(w)), harmonics=9, guess=guess, throw=True)
            omega.append(w)
            found.append(complex(orbit.coefficients[1, 0], -orbit.coefficients[2, 0]))
    return np.array(omega), np.array(found)


@cache
def duffing():
    return reached(SYSTEM, 0.8, 1.5, 25)


@cache
def integrated():
    """Sweeps of x'' + 0.05 x' + x + 0.1 x^3 = 0.18 cos(omega t), each frequency held until it settles."""
    omega = np.concatenate([np.linspace(0.9, 1.4, 11), np.linspace(1.4, 0.9, 11)])
    y, phase, found = (0.0, 0.0), np.linspace(0.0, 2.0 * math.pi, 65)[:-1], []
    for w in omega:
        whole = 2.0 * math.pi / w
        t = 60 * whole + phase / w
        run = solve_ivp(
            lambda t, y, w=w: (y[1], 0.18 * math.cos(w * t) - 0.05 * y[1] - y[0] - 0.1 * y[0] ** 3),
            (0.0, 61 * whole), y, "DOP853", np.append(t, 61 * whole), rtol=1e-9, atol=1e-11,
        )  # fmt: skip
        found.append(2.0 * np.mean(run.y[0, :-1] * np.exp(-1j * phase)))
        y = tuple(run.y[:, -1])
    return omega, np.array(found)


def noise(rng, count, size):
    return size * (rng.standard_normal(count) + 1j * rng.standard_normal(count))


@pytest.mark.parametrize("kind", ["complex", "phase", "amplitude alone"])
def test_parameters_of_a_clean_curve_are_found(kind):
    omega, c = duffing()
    options = {"phase": np.angle(c)} if kind == "phase" else {}
    found = sw.fit.fit_response(omega, c if kind == "complex" else np.abs(c), GUESS, free=FREE, harmonics=9, **options)
    assert found.values == pytest.approx([*TRUE.values()], rel=1e-6)
    assert np.all(found.solved)


def test_a_curve_of_another_integrator_gives_the_parameters():
    omega, c = integrated()
    found = sw.fit.fit_response(omega, c, GUESS, free=FREE, harmonics=7)
    assert found.values == pytest.approx([*TRUE.values()], rel=3e-3)
    folds = [1.2696019555, 1.1157002518]  # of frequency_response with 9 harmonics
    assert np.abs(found.folds - folds) == pytest.approx(0.0, abs=3e-3)
    assert np.all((found.jumps[:, 0] < folds) & (found.jumps[:, 1] > folds))


@pytest.mark.parametrize(
    ("system", "guess", "free", "low", "high"),
    [
        (sw.Oscillator(1.0, 0.05, sw.Cubic(1.0, -0.1), sw.Harmonic(0.06), 1.0),
         sw.Oscillator(1.0, 0.07, sw.Cubic(1.2, -0.07), sw.Harmonic(0.06), 1.0),
         ("B", "law.K", "law.alpha"), 0.7, 1.2),
        (sw.Oscillator(0.5, 3.0, sw.Cubic(7160.0, 1e5), sw.Harmonic(0.0), 1.0, sw.KinematicError((sw.Line(1, 1e-4),))),
         sw.Oscillator(0.5, 4.0, sw.Cubic(8e3, 8e4), sw.Harmonic(0.0), 1.0, sw.KinematicError((sw.Line(1, 1.2e-4),))),
         ("B", "law.K", "law.alpha", "error.lines.0.amplitude"), 80.0, 160.0),
        pytest.param(
            sw.Oscillator(1.0, 0.05, sw.PiecewiseLinear(1.0, 1.4, 1.8, 0.5, 1.2), sw.Harmonic(0.18), 1.0),
            sw.Oscillator(1.0, 0.07, sw.PiecewiseLinear(1.1, 1.5, 1.9, 0.6, 1.3), sw.Harmonic(0.18), 1.0),
            ("B", "law.K1", "law.K2", "law.K3", "law.T1", "law.T2"), 0.7, 1.6, marks=pytest.mark.slow,
        ),
    ],
    ids=["softening", "kinematic error", "three slopes"],
)  # fmt: skip
def test_other_laws_and_excitations(system, guess, free, low, high):
    omega, c = reached(system, low, high, 20)
    found = sw.fit.fit_response(omega, c, guess, free=free, harmonics=9)
    values = {path: value for path, value, _ in parameters(system)}
    assert found.values == pytest.approx([values[path] for path in free], rel=2e-4)


def test_sweeps_are_told_by_the_direction_of_the_frequency():
    assert sweeps(np.array([1.0, 2.0, 3.0, 3.0, 2.0, 1.0, 2.0, 3.0])) == [slice(0, 3), slice(3, 6), slice(6, 8)]
    assert sweeps(np.array([1.0, 2.0, 3.0, 1.0, 2.0, 3.0])) == [slice(0, 3), slice(3, 6)]


def test_jumps_are_found_where_they_are():
    omega, c = duffing()
    found = jumps_of(omega, np.abs(c), sweeps(omega))
    assert [(jump.low < fold < jump.high) for jump, fold in zip(found, (1.26960, 1.11570), strict=True)] == [True] * 2


def test_intervals_and_folds_of_a_noisy_curve():
    omega, c = duffing()
    found = sw.fit.fit_response(omega, c + noise(np.random.default_rng(2), len(c), 0.02), GUESS, free=FREE)
    for path, value in TRUE.items():
        low, high = found.interval(path, 0.999)
        assert low < value < high
        assert high - low < 0.2 * value
    assert np.abs(found.folds - [1.26960, 1.11570]) == pytest.approx(0.0, abs=0.005)
    assert np.all(np.abs(found.folds - [1.26960, 1.11570]) < 4.0 * found.fold_deviation)
    assert found.discrepancy.white > 1e-3


def test_a_missing_term_colours_the_residual():
    omega, c = duffing()
    rng = np.random.default_rng(3)
    linear = GUESS._replace(law=sw.Cubic(1.0, 0.1))
    right = sw.fit.fit_response(omega, c + noise(rng, len(c), 0.01), linear, free=("B", "law.K", "law.alpha"))
    below = omega < 1.05
    wrong = sw.fit.fit_response(
        omega[below],
        c[below] + noise(rng, int(below.sum()), 0.01),
        GUESS._replace(law=sw.Linear(1.2)),
        free=("B", "law.K"),
    )
    assert wrong.discrepancy.white < 1e-3
    assert wrong.discrepancy.rms > 2.0 * right.discrepancy.rms


def test_only_ratios_to_the_force_are_told():
    omega, c = duffing()
    said = r"the data tell J, B, law\.K and excitation\.amplitude up to a common factor only"
    with pytest.raises(ValueError, match=said):
        sw.fit.fit_response(omega, c, GUESS, free=("J", *FREE))


def test_bad_input_is_one_sentence():
    omega, c = duffing()
    with_error = GUESS._replace(error=sw.KinematicError((sw.Line(1, 1e-3),)))
    for said, error, arguments, options in (
        ("all points are at 1 rad/s", ValueError, (np.ones(8), c[:8], GUESS), {}),
        ("there is no motion", ValueError, (omega, 0.0 * c, GUESS), {}),
        ("there are 3 points", ValueError, (omega[:3], c[:3], GUESS), {}),
        ("give one amplitude for each", ValueError, (omega, c[:5], GUESS), {}),
        ("frequencies must be positive", ValueError, (omega - 1.0, c, GUESS), {}),
        ("no continuous parameter 'law.K9'", ValueError, (omega, c, GUESS), {"free": ("law.K9",)}),
        ("free is empty", ValueError, (omega, c, GUESS), {"free": ()}),
        ("a kinematic error takes phases", TypeError, (omega, np.abs(c), with_error), {}),
        ("takes a law torque", TypeError, (omega, c, GUESS._replace(law=sw.BoucWen(1.0, 0.3, 0.4))), {"free": ("B",)}),
        ("away from the measured curve", sw.SolveError, (omega, np.roll(c, 9), GUESS), {}),
    ):
        with pytest.raises(error, match=said) as caught:
            sw.fit.fit_response(*arguments, **{"free": FREE, **options})
        assert "\n" not in str(caught.value)


SETS = 30


@pytest.mark.slow
@pytest.mark.parametrize("quantised", [False, True])
def test_intervals_cover(quantised):
    omega, c = duffing()
    rng, hits = np.random.default_rng(11), dict.fromkeys(TRUE, 0)
    for _ in range(SETS):
        y = c + noise(rng, len(c), 0.02)
        if quantised:
            y = 0.06 * (np.round(y.real / 0.06) + 1j * np.round(y.imag / 0.06))
        found = sw.fit.fit_response(omega, y, GUESS, free=FREE, harmonics=5)
        for path, value in TRUE.items():
            low, high = found.interval(path)
            hits[path] += low <= value <= high
    assert all(count >= stats.binom.ppf(0.001, SETS, 0.95) for count in hits.values()), hits


def test_without_phases_the_damping_keeps_its_sign():
    # amplitudes are the same for B and for -B: from this start the nearest was -B
    omega = np.linspace(0.7, 1.3, 36)
    amplitude = 1.0 / np.abs(1.0 - omega**2 + 0.0136j * omega)
    start = sw.Oscillator(1.0, 0.02175, sw.Linear(0.867), sw.Harmonic(1.0), 1.0)
    fit = sw.fit.fit_response(omega, amplitude, start, free=("B", "law.K"))
    np.testing.assert_allclose(fit.values, [0.0136, 1.0], rtol=1e-6)
