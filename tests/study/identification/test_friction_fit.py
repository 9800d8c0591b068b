"""Friction identified from runs whose torques follow formulas written out here; LuGre's loop is integrated by SciPy."""

import numpy as np
import pytest
from loop_machines import coloured
from scipy import stats
from scipy.integrate import solve_ivp

import strainwave as sw

LEVELS = np.array([0.5, 1.0, 2.0, 3.0, 5.0, 8.0, 12.0, 20.0, 30.0, 50.0, 80.0, 120.0])  # rad/s
SPEED = np.concatenate([LEVELS, -LEVELS, LEVELS, -LEVELS])
LOAD = np.repeat([0.0, 0.5], 2 * len(LEVELS))  # N*m
TRUE = {"T_c": 0.06, "T_s": 0.09, "v_s": 3.0, "B": 3e-4, "mu": 0.05, "offset": 0.008}


def torque(v=SPEED, load=LOAD, **changes):
    """Stribeck curve with viscous and load-proportional friction, and an offset."""
    p = TRUE | changes
    side = np.sign(v)
    dry = p["T_c"] + (p["T_s"] - p["T_c"]) * np.exp(-((v / p["v_s"]) ** 2)) + p["mu"] * load
    return side * dry + p["B"] * v + p["offset"]


def noise(seed, deviation=1e-3, count=48):
    return deviation * np.random.default_rng(seed).normal(size=count)


def test_runs_without_noise_give_the_friction_back():
    fit = sw.fit_friction(SPEED, torque(), LOAD)
    for name, value in TRUE.items():
        assert fit.value(name) == pytest.approx(value, rel=1e-6)
    assert isinstance(fit.law, sw.Parallel)
    assert fit.law.first.T_s == pytest.approx(0.09)
    assert pytest.approx(3e-4) == fit.law.second.B
    assert fit.load_friction.mu == pytest.approx(0.05)


@pytest.mark.parametrize("seed", range(10))
def test_a_fall_of_friction_in_a_few_slow_runs_is_not_missed(seed):
    speed = np.concatenate([np.arange(5.0, 101.0, 8.0), -np.arange(12.0, 101.0, 8.0)])  # three runs show it
    dry = 2.0 + np.where(seed < 9, 0.8, 0.0) * np.exp(-((speed / 12.0) ** 2))
    fit = sw.fit_friction(speed, np.sign(speed) * dry + 0.03 * speed + noise(seed, 0.01, len(speed)))
    assert ("T_s" in fit.values) == (seed < 9)
    assert fit.value("B") == pytest.approx(0.03, abs=5.0 * fit.deviation("B"))
    assert fit.value("T_c") == pytest.approx(2.0, abs=5.0 * fit.deviation("T_c"))
    assert fit.deviation("T_c") < 0.02


def test_the_law_gives_the_mean_of_both_directions():
    fit = sw.fit_friction(SPEED, torque() + noise(1), LOAD)
    law, v = fit.law, np.array([1.0, 4.0, 60.0])
    found = [law.first.torque(0.0, speed) + law.second.torque(0.0, speed) for speed in v]
    both = 0.5 * (torque(v, 0.0) - torque(-v, 0.0))
    assert found == pytest.approx(both.tolist(), rel=0.03)
    assert fit.value("T_c_forward") - fit.value("T_c_backward") == pytest.approx(2.0 * fit.value("offset"))


@pytest.mark.parametrize(
    ("changes", "terms"),
    [
        ({"T_s": 0.06, "mu": 0.0, "offset": 0.0}, {"T_c", "B"}),
        ({"T_s": 0.06, "B": 0.0, "mu": 0.0, "offset": 0.0}, {"T_c"}),
        ({"T_s": 0.06, "offset": 0.0}, {"T_c", "B", "mu"}),
        ({"mu": 0.0, "offset": 0.0}, {"T_c", "T_s", "v_s", "B"}),
        ({}, {"T_c", "T_s", "v_s", "B", "mu", "offset", "T_c_forward", "T_c_backward"}),
    ],
)
def test_the_runs_say_which_terms_there_are(changes, terms):
    fit = sw.fit_friction(SPEED, torque(**changes) + noise(2), LOAD)
    assert set(fit.values) == terms
    (chosen,) = [row for row in fit.comparison if row.chosen]
    assert chosen.name in fit.reason
    assert chosen.error == pytest.approx(1e-3, rel=0.5)


def test_breakaway_tells_the_static_torque():
    v = np.concatenate([LEVELS[3:], -LEVELS[3:]])  # from v_s on: the rise alone is hardly seen
    t = torque(v, 0.0, offset=0.0) + noise(3, 1e-3, len(v))
    fit = sw.fit_friction(v, t, breakaway=[0.0905, 0.0895, -0.091, -0.089, 0.09])
    assert fit.value("T_s") == pytest.approx(0.09, abs=1e-3)
    assert fit.deviation("T_s") < 1e-3


def test_samples_of_each_run_are_averaged_with_their_colour():
    rng = np.random.default_rng(4)
    runs = [level + coloured(rng, 300, 0.01, 0.9) for level in torque()]
    fit = sw.fit_friction(SPEED, runs, LOAD)
    assert fit.torque == pytest.approx([np.mean(run) for run in runs])
    assert fit.value("T_c") == pytest.approx(0.06, abs=4.0 * fit.deviation("T_c"))


def presliding_loop(sigma_0, T_s, reach, samples=800):
    """Quasi-static LuGre (sigma_1 = sigma_2 = 0) along a sine: dz/dx = 1 - sigma_0 |z| sign(v) ... /T_s."""
    t = np.linspace(0.0, 3.0, samples)

    def rate(time, z):
        v = 2.0 * np.pi * reach * np.cos(2.0 * np.pi * time)
        return v - sigma_0 * np.abs(v) * z / T_s

    run = solve_ivp(rate, (0.0, 3.0), [0.0], t_eval=t, rtol=1e-10, atol=1e-18, max_step=0.01)
    return reach * np.sin(2.0 * np.pi * t), sigma_0 * run.y[0]


@pytest.mark.parametrize("share", [0.3, 2.0])
def test_the_stiffness_of_the_bristles_comes_from_a_presliding_loop(share):
    sigma_0 = 900.0
    angle, pull = presliding_loop(sigma_0, 0.09, share * 0.09 / sigma_0)
    pull = pull + noise(5, 2e-4, len(pull))
    fit = sw.fit_friction(SPEED, torque(offset=0.0) + noise(6, 2e-4), LOAD, presliding=(angle, pull))
    assert isinstance(fit.law, sw.laws.LuGre)
    assert fit.law.sigma_0 == pytest.approx(sigma_0, rel=0.02)
    assert fit.law.T_s == pytest.approx(0.09, rel=0.02)
    assert fit.law.sigma_2 == fit.value("B") == fit.value("second.sigma_2")
    assert fit.interval("sigma_0").low < fit.law.sigma_0 < fit.interval("sigma_0").high
    assert "sigma_1 is 0" in str(fit)


@pytest.mark.parametrize(
    ("given", "sentence"),
    [
        ((SPEED[:4], torque()[:4]), "there are 4 runs; measure at least 6"),
        ((np.full(8, 10.0), np.full(8, 0.06)), r"all runs are at 10 rad/s: .* only T_c \+ 10 B is identifiable"),
        ((np.where(SPEED == 0.5, 0.0, SPEED), torque()), "run 0 stands still; give torques .* as breakaway"),
        ((60.0 * SPEED, torque()), "beyond any motor; is it in rpm"),
        ((SPEED, -torque()), "the torque has the opposite sign of the speed"),
        ((SPEED, torque()[:9]), r"torque \[N\*m\] has the shape \(9,\)"),
        ((SPEED, np.where(SPEED == 20.0, np.nan, torque())), "torque .* of run 7 is nan; remove the run"),
        ((SPEED, torque(), LOAD[:3]), r"load \[N\*m\] has the shape \(3,\)"),
        ((SPEED, "x"), "must be an array of numbers"),
    ],
)
def test_what_are_no_runs_is_refused_in_one_sentence(given, sentence):
    with pytest.raises(ValueError, match=sentence) as refusal:
        sw.fit_friction(*given)
    assert "\n" not in str(refusal.value)


def test_other_inputs_are_refused_in_one_sentence():
    with pytest.raises(ValueError, match="a deviation is not positive"):
        sw.fit_friction(SPEED, torque(), deviation=np.zeros(len(SPEED)))
    with pytest.raises(ValueError, match="stays below"):
        sw.fit_friction(SPEED, torque(), LOAD, presliding=presliding_loop(900.0, 0.3, 1e-3))
    with pytest.raises(ValueError, match="presliding is 3; give a pair"):
        sw.fit_friction(SPEED, torque(), LOAD, presliding=3)
    angle, pull = presliding_loop(900.0, 0.09, 1e-5)
    with pytest.raises(ValueError, match="the torque falls with the torsion"):
        sw.fit_friction(SPEED, torque(), LOAD, presliding=(angle, -pull))
    with pytest.raises(ValueError, match="run 0 has 3 samples"):
        sw.fit_friction(SPEED, [np.zeros(3)] * len(SPEED))


def test_what_the_runs_do_not_tell_is_said():
    fit = sw.fit_friction(LEVELS, torque(LEVELS, 0.5), np.full(len(LEVELS), 0.5))
    with pytest.raises(ValueError, match=r"mu is not identifiable: .* only T_c \+ 0.5 mu is"):
        fit.interval("mu")
    with pytest.raises(ValueError, match="all runs go in one direction"):
        fit.interval("offset")
    with pytest.raises(ValueError, match="the fit has no 'K1'; it has T_c"):
        fit.interval("K1")


@pytest.mark.slow
@pytest.mark.interpreted
@pytest.mark.parametrize("kind", ["white", "coloured", "quantised"])
def test_intervals_cover(kind):
    """Hits of 100 intervals at 95 % lie from 88 to 100 with a probability of 99.6 % (binomial)."""
    hits = dict.fromkeys(TRUE, 0)
    for seed in range(100):
        rng = np.random.default_rng(seed)
        t = torque() + 1e-3 * rng.normal(size=len(SPEED))
        if kind == "quantised":
            t = 2e-3 * np.round(t / 2e-3)
        runs = [level + coloured(rng, 200, 0.01, 0.9) for level in torque()] if kind == "coloured" else t
        fit = sw.fit_friction(SPEED, runs, LOAD)
        for name, value in TRUE.items():
            hits[name] += name in fit.values and fit.interval(name).low <= value <= fit.interval(name).high
    assert min(hits.values()) >= 88, hits


FAN = {"T_c": 0.06, "T_s": 0.06, "mu": 0.0, "offset": 0.0}
TWICE = np.tile(np.concatenate([LEVELS, -LEVELS]), 2)


@pytest.mark.parametrize("seed", range(4))
def test_a_fan_is_told_from_viscous_and_stribeck_friction(seed):
    fit = sw.fit_friction(TWICE, torque(TWICE, 0.0, **FAN) + 4e-6 * TWICE * np.abs(TWICE) + noise(seed))
    assert set(fit.values) == {"T_c", "B", "D"}
    for name, value in (("T_c", 0.06), ("B", 3e-4), ("D", 4e-6)):
        low, high = fit.interval(name, 0.999)
        assert low <= value <= high
    assert fit.law.second == sw.laws.QuadraticDamping(fit.value("D"))
    assert not fit.lack_of_fit.found


def test_friction_that_drifts_is_that_of_the_first_run():
    drifting = torque(TWICE, 0.0, **FAN) - 0.009 * np.sign(TWICE) * np.linspace(0.0, 1.0, 48) + noise(5)
    fit = sw.fit_friction(TWICE, drifting)
    for name, value in (("T_c", 0.06), ("drift", -0.009)):
        low, high = fit.interval(name, 0.999)
        assert low <= value <= high
    assert "from the first run to the last" in str(fit)


def test_a_law_that_misses_repeated_runs_is_said_first_and_its_intervals_are_wider():
    """A hump that no term has; the ratio is that of the two mean squares, and its tail SciPy's."""
    hump = 0.01 * np.sign(TWICE) * np.exp(-(np.log(np.abs(TWICE) / 15.0) ** 2) / 0.2)
    t = torque(TWICE, 0.0, **FAN) + hump + noise(6)
    fit = sw.fit_friction(TWICE, t)
    rest = (t - fit.fitted).reshape(2, 24)
    pure = np.sum((rest - rest.mean(axis=0)) ** 2) / 24.0
    unknowns = sum(name not in ("T_c_forward", "T_c_backward") for name in fit.values)
    missed = 2.0 * np.sum(rest.mean(axis=0) ** 2) / (24.0 - unknowns)
    lack = fit.lack_of_fit
    assert lack.found
    if "drift" not in fit.values:  # which runs at one speed do not share
        assert (lack.pure**2, lack.missed**2) == pytest.approx((pure, missed))
    assert lack.probability == pytest.approx(stats.f.sf(lack.ratio, 24 - unknowns, 24), rel=1e-9)
    assert str(fit).splitlines()[1].startswith("  the law does not fit: it misses the runs by")
    (single,) = [sw.fit_friction(TWICE[:24], t[:24])]
    assert single.lack_of_fit is None
    assert "whether the law fits is not known" in str(single)
    known = sw.fit_friction(TWICE, t, deviation=np.full(48, 1e-3))
    assert known.lack_of_fit.found
    assert known.lack_of_fit.probability == pytest.approx(
        stats.chi2.sf(np.sum(((t - known.fitted) / 1e-3) ** 2), 48 - unknowns), rel=1e-6
    )
