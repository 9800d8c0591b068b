"""Free decays: SciPy's integrator with the equations written out here is the measurement."""

import math
from functools import cache

import numpy as np
import pytest
from canonical import CSF_40_50
from scipy import stats
from scipy.integrate import solve_ivp
from scipy.signal import lfilter
from three_slopes import three_slopes

import strainwave as sw
from strainwave.study.identification.decay import vibrations
from strainwave.study.identification.waves import decaying_waves


def system(law, J=1.0, B=0.03):
    return sw.Oscillator(J, B, law, sw.Harmonic(0.0), 1.0)


@cache
def decayed(torque, friction, J, B, start, cycles, per_cycle=40):
    """Times and motion of J x'' + B x' + friction(x') + torque(x) = 0 from rest at `start`."""
    step = 2.0 * math.pi / math.sqrt(torque(start) / start / J) / per_cycle
    t = step * np.arange(cycles * per_cycle)
    found = solve_ivp(
        lambda _, y: (y[1], -(B * y[1] + friction(y[1]) + torque(y[0])) / J), (0.0, t[-1]), (start, 0.0),
        method="DOP853", t_eval=t, rtol=1e-10, atol=1e-13 * start,
    )  # fmt: skip
    return t, found.y[0]


def hardening(x):
    return x + 0.1 * x**3


def smooth(_):
    return 0.0


def cubic(x):
    return 7160.0 * (x + 1e5 * x**3)


def gap(x):
    return math.copysign(max(abs(x) - 0.2, 0.0), x)


def dry(v):
    return 0.005 * v / math.sqrt(v * v + 1e-6)


CASES = {
    "linear": (lambda x: 7160.0 * x, smooth, 0.5, 2.0, 1e-3, 30, sw.Linear(6000.0),
               {"B": 2.0, "law.K": 7160.0}),
    "cubic gear": (cubic, smooth, 0.5, 2.0, 3e-3, 40, sw.Cubic(9000.0, 5e4),
                   {"B": 2.0, "law.K": 7160.0, "law.alpha": 1e5}),
    "three slopes": (lambda x: three_slopes(x, CSF_40_50), smooth, 1.0, 10.0, 2.5e-3, 100,
                     sw.PiecewiseLinear(0.9e5, 1.5e5, 2e5, 60.0, 180.0),
                     {"B": 10.0, "law.K1": 1e5, "law.K2": 1.4e5, "law.K3": 1.8e5, "law.T1": 54.0, "law.T2": 196.0}),
    "backlash": (gap, smooth, 1.0, 0.01, 3.0, 40, sw.Backlash(1.3, 0.15),
                 {"B": 0.01, "law.K": 1.0, "law.half_gap": 0.2}),
    "dry friction": (lambda x: x + 0.1 * x**3, dry, 1.0, 0.01, 1.5, 40,
                     sw.Parallel(sw.Cubic(1.2, 0.07), sw.laws.Coulomb(0.01, 1e-3)),
                     {"B": 0.01, "law.first.K": 1.0, "law.first.alpha": 0.1, "law.second.T_c": 0.005}),
}  # fmt: skip


def fit(name, noise=0.0, seed=0):
    torque, friction, J, B, start, cycles, guess, true = CASES[name]
    t, x = decayed(torque, friction, J, B, start, cycles)
    y = x + noise * start * np.random.default_rng(seed).standard_normal(len(t))
    return sw.fit_decay(t, y, system(guess, J, 1.5 * B), free=tuple(true)), true


@pytest.mark.parametrize("name", CASES)
def test_parameters_of_a_clean_decay_are_found(name):
    found, true = fit(name)
    within = {"linear": 1e-6, "cubic gear": 2e-4, "three slopes": 0.02, "backlash": 2e-5, "dry friction": 6e-3}[name]
    assert [found.value(path) for path in true] == pytest.approx([*true.values()], rel=within)


@pytest.mark.parametrize("name", CASES)
def test_intervals_of_a_noisy_decay_hold_the_parameters(name):
    found, true = fit(name, noise=0.01, seed=3)
    for path, value in true.items():
        low, high = found.interval(path, 0.999)
        assert low < value < high
        assert high - low < 0.15 * value


def test_windows_give_frequency_and_rate_of_a_linear_decay():
    t = 0.05 * np.arange(4000)
    y = 2.0 * np.exp(-0.01 * t) * np.cos(0.9 * t + 0.3) + 0.1
    found = decaying_waves(t, y)
    assert found.omega == pytest.approx(0.9, rel=3e-6)
    assert found.rate == pytest.approx(0.01, rel=2e-3)
    assert found.amplitude == pytest.approx(2.0 * np.exp(-0.01 * found.time), rel=1e-4)
    assert found.offset == pytest.approx(0.1, abs=1e-4)


def test_deviations_of_the_windows_are_their_scatter():
    t = 0.05 * np.arange(3000)
    clean = 2.0 * np.exp(-0.01 * t) * np.cos(0.9 * t + 0.3)
    rng = np.random.default_rng(5)
    off = []
    for _ in range(60):
        w = decaying_waves(t, clean + 0.02 * rng.standard_normal(len(t)))
        off += ((w.omega - 0.9) / w.omega_deviation).tolist() + ((w.rate - 0.01) / w.rate_deviation).tolist()
    assert 0.85 < np.std(off) < 1.15


@pytest.mark.parametrize("law", [sw.Cubic(2.0, 0.3), sw.Cubic(2.0, -0.1), sw.Polynomial((0.0, 1.0, 0.2, 0.1))])
def test_undamped_vibrations_are_those_of_harmonic_balance(law):
    found = vibrations(system(law), np.array([0.3, 0.8, 1.2]))
    balanced = sw.numerics.backbone(system(law), np.abs(found.coefficients[1]))
    assert found.omega == pytest.approx(balanced.omega, rel=1e-9)
    assert found.coefficients[2] == pytest.approx(balanced.coefficients[:, 3], abs=1e-9)


def test_the_fitted_curves_go_through_the_windows():
    found, _ = fit("cubic gear", noise=0.002)
    assert np.all(np.abs(found.fitted_omega - found.omega) < 5.0 * found.omega_deviation + 1e-3 * found.omega)
    assert np.all(np.abs(found.fitted_rate - found.rate) < 5.0 * found.rate_deviation + 1e-3 * found.omega)
    assert found.omega[0] > 1.1 * found.omega[-1]


def drag(v):
    return 0.01 * abs(v) * v


@pytest.mark.parametrize(("friction", "missing", "coefficient"), [(drag, "|v| v", 0.01), (dry, "sign v", 0.005)])
def test_a_missing_damping_is_named_with_its_coefficient(friction, missing, coefficient):
    t, x = decayed(hardening, friction, 1.0, 0.01, 1.5, 30)
    y = x + 0.01 * np.random.default_rng(8).standard_normal(len(t))
    found = sw.fit_decay(t, y, system(sw.Cubic(1.1, 0.08)), free=("B", "law.K", "law.alpha"))
    assert missing in found.discrepancy.flagged
    assert found.discrepancy.missing[missing].coefficient == pytest.approx(coefficient, rel=0.25)
    assert found.discrepancy.missing["x^3"].probability == 1.0


@pytest.mark.slow
def test_nothing_is_missing_in_the_right_law():
    t, x = decayed(hardening, smooth, 1.0, 0.02, 1.5, 30, 20)
    rng, alarms = np.random.default_rng(9), 0
    for _ in range(20):
        found = sw.fit_decay(t, measured("white", x, rng), system(sw.Cubic(1.1, 0.08)), free=tuple(TRUE))
        alarms += bool(found.discrepancy.flagged)
    assert alarms <= stats.binom.ppf(0.999, 20, 0.05)


def test_only_ratios_to_the_inertia_are_told():
    torque, friction, J, B, start, cycles, guess, _ = CASES["cubic gear"]
    t, x = decayed(torque, friction, J, B, start, cycles)
    with pytest.raises(ValueError, match=r"the data tell J, B and law\.K up to a common factor only"):
        sw.fit_decay(t, x, system(guess, J, B), free=("J", "B", "law.K", "law.alpha"))


T = 0.05 * np.arange(3000)
FADING = np.exp(-0.01 * T)
BAD = {
    "there is no motion": 0.0 * T + 1.0,
    "fades to": np.random.default_rng(0).standard_normal(len(T)),
    "has 0 cycles": FADING,
    "does not decay": np.cos(T),
    "two frequencies beat": FADING * (np.cos(T) + 0.7 * np.cos(1.15 * T)),
    "is not a vibration of one frequency": FADING * (np.cos(T) + 0.7 * np.cos(3.15 * T)),
    "1.5 cycles": FADING * np.cos(0.1 * T),
    "samples a cycle": FADING * np.cos(2.0 * math.pi / 0.05 / 5.3 * T),
}


@pytest.mark.parametrize("said", BAD)
def test_what_is_no_free_decay_is_said_in_one_sentence(said):
    with pytest.raises((ValueError, sw.SolveError), match=said) as caught:
        sw.fit_decay(T, BAD[said], system(sw.Linear(1.0)))
    assert "\n" not in str(caught.value)


def test_bad_arguments_are_said():
    y = FADING * np.cos(T)
    for said, arguments, options in (
        ("sample 1 stands after .*; times must ascend", (T[::-1], y), {}),
        ("3000 times and 5 values", (T, y[:5]), {}),
        ("no continuous parameter 'law.alpha'", (T, y), {"free": ("B", "law.alpha")}),
        ("excitation.amplitude: it changes nothing", (T, y), {"free": ("B", "excitation.amplitude")}),
    ):
        with pytest.raises(ValueError, match=said):
            sw.fit_decay(*arguments, system(sw.Linear(1.0)), **options)
    with pytest.raises(TypeError, match="BoucWen has memory"):
        sw.fit_decay(T, y, system(sw.BoucWen(1.0, 0.3, 0.4)))


TRUE = {"B": 0.02, "law.K": 1.0, "law.alpha": 0.1}
SETS = 60


def measured(kind, x, rng):
    noise = rng.standard_normal(len(x) + 500)
    if kind == "coloured":
        return x + 0.005 * lfilter([1.0], [1.0, -0.9], noise)[500:]
    return x + 0.01 * noise[500:] if kind == "white" else 0.03 * np.round((x + 0.01 * noise[500:]) / 0.03)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["white", "coloured", "quantised"])
def test_intervals_cover(kind):
    t, x = decayed(hardening, smooth, 1.0, 0.02, 1.5, 30, 20)
    rng, hits = np.random.default_rng(11), dict.fromkeys(TRUE, 0)
    for _ in range(SETS):
        found = sw.fit_decay(t, measured(kind, x, rng), system(sw.Cubic(1.1, 0.08)), free=tuple(TRUE))
        for path, value in TRUE.items():
            low, high = found.interval(path)
            hits[path] += low <= value <= high
    assert all(count >= stats.binom.ppf(0.001, SETS, 0.95) for count in hits.values()), hits
