"""Variability against closed forms of the linear oscillator, single solutions, and functions of known indices."""

import numpy as np
import pytest
from scipy import stats

import strainwave as sw
from strainwave.sample import result as reductions
from strainwave.sample.quantiles import drawn, natural_frequencies
from strainwave.sample.result import Band, JumpSpread, Variability, ranking, running_quantile
from strainwave.sample.sampling import by_path

LINEAR = sw.Oscillator(1.0, 0.4, sw.Linear(2.0), sw.Harmonic(1.0), 1.0)
CUBIC = sw.Oscillator(1.0, 0.1, sw.Cubic(1.0, 0.05), sw.Harmonic(1.0), 1.0)


@pytest.mark.slow
def test_quantiles_of_a_linear_drive_follow_from_its_gain():
    """The peak is A/|K - J w^2 + i B w|, proportional to A: its quantiles are those of A."""
    spread = {"excitation.amplitude": stats.norm(1.0, 0.1)}
    found = sw.sample.variability(LINEAR, spread, count=1000, seed=3, settle=30)
    at = found.speeds[0]
    wanted = stats.norm(1.0, 0.1).ppf(at.shares) / abs(1.0 + 0.4j)
    assert np.all(np.abs(at.quantiles - wanted) < 4.0 * at.errors)
    assert at.ranking.linear_share == pytest.approx(1.0, abs=1e-9)
    np.testing.assert_allclose(at.peak, found.drives["excitation.amplitude"] / abs(1.0 + 0.4j), rtol=1e-5)
    assert (at.diverged, at.unsettled) == (0, 0)


@pytest.mark.slow
def test_peaks_jumps_and_the_phase_of_cubic_drives():
    spread = {"law.alpha": sw.Uniform(0.03, 0.07), "excitation.phase": sw.Uniform(0.0, 6.28)}
    found = sw.sample.variability(CUBIC, spread, speeds=[0.7], count=64, jump_span=(0.8, 3.0), jump_count=6)
    for i in (0, 20):
        one = sw.replaced(CUBIC, {path: float(v[i]) for path, v in found.drives.items()} | {"omega": 0.7})
        assert found.speeds[0].peak[i] == pytest.approx(sw.find_orbit(one).peak, rel=1e-5)
    first = sw.replaced(CUBIC, {path: float(v[0]) for path, v in found.drives.items()})
    said = sw.jumps(sw.frequency_response(first, (0.8, 3.0)))
    assert found.jumps.down[0] == pytest.approx(said.jump_down, rel=1e-9)
    assert np.all(found.jumps.up < found.jumps.down)
    # the phase of the excitation changes no steady motion
    phase = next(row for row in found.speeds[0].ranking.rows if row.path == "excitation.phase")
    assert abs(phase.index) < 4.0 * phase.index_error + 0.05
    data = found.dataset()
    assert data["peak"].shape == (1, 64)
    assert "jump down: 6 of 6" in str(found)


@pytest.mark.compiled
def test_drives_that_run_away_are_counted():
    soft = sw.Oscillator(1.0, 0.3, sw.Cubic(1.0, -0.3), sw.Harmonic(0.2), 0.5)
    found = sw.sample.variability(soft, {"law.alpha": sw.Uniform(-6.0, -0.3)}, count=160, settle=30, longest=60)
    at = found.speeds[0]
    assert 0 < at.diverged < 128
    assert np.count_nonzero(np.isnan(at.peak)) == at.diverged
    assert f"{at.diverged} drives left every bound" in str(found)


def test_a_factor_scales_its_parameters_together():
    system = sw.Oscillator(1.0, 0.1, sw.PiecewiseLinear(1.0, 1.4, 1.8, 0.5, 1.2), sw.Harmonic(0.1), 0.5)
    together = ("law.K1", "law.K2", "law.K3")
    drives = drawn(system, {together: sw.Normal(1.0, 0.1), "B": sw.Uniform(0.1, 0.2)}, 40, 0)
    assert list(drives) == ["law.K1 & law.K2 & law.K3", "B"]
    apart = by_path(system, drives)
    assert list(apart) == [*together, "B"]
    factor = drives["law.K1 & law.K2 & law.K3"]
    assert np.array_equal(apart["law.K2"], 1.4 * factor)
    natural = natural_frequencies(system, apart)
    np.testing.assert_allclose(natural, np.sqrt(factor))


@pytest.mark.slow
def test_a_shared_factor_is_ranked_under_the_names_of_its_parameters():
    """Below resonance a gear of any slopes answers with torque over stiffness: the factor is all that matters."""
    system = sw.Oscillator(1.0, 0.5, sw.PiecewiseLinear(1.0, 1.4, 1.8, 0.5, 1.2), sw.Harmonic(0.1), 0.05)
    found = sw.sample.variability(
        system, {("law.K1", "law.K2", "law.K3"): sw.Normal(1.0, 0.1), "B": sw.Uniform(0.45, 0.55)}, count=200
    )
    first = found.speeds[0].ranking.rows[0]
    assert first.path == "law.K1 & law.K2 & law.K3"
    assert first.index > 0.9
    assert "law.K1 & law.K2 & law.K3: " in str(found)
    assert "law.K1 & law.K2 & law.K3" in found.dataset()


@pytest.mark.parametrize("count", [40, 80])
def test_drives_are_reproducible_and_a_larger_sample_begins_with_the_smaller(count):
    spread = {"J": sw.Normal(1.0, 0.1, low=0.1), "law.K": sw.Uniform(1.0, 3.0)}
    small, large = drawn(LINEAR, spread, 40, 7), drawn(LINEAR, spread, count, 7)
    for path in spread:
        assert np.array_equal(large[path][:40], small[path])
    assert not np.array_equal(drawn(LINEAR, spread, 40, 8)["J"], small["J"])


def test_first_order_indices_of_the_ishigami_function():
    """Ishigami & Homma 1990: a = 7, b = 0.1 gives S1 = 0.3139, S2 = 0.4424, S3 = 0 (Saltelli et al. 2008)."""
    rng = np.random.default_rng(0)
    x = rng.uniform(-np.pi, np.pi, (3, 8000))
    y = ishigami(x)
    rows = {row.path: row for row in ranking(dict(zip("abc", x, strict=True)), y, rng).rows}
    for path, wanted in (("a", 0.3139), ("b", 0.4424), ("c", 0.0)):
        assert abs(rows[path].index - wanted) < max(0.015, 3.0 * rows[path].index_error)
        assert rows[path].index_error < 0.02


def ishigami(x):
    return np.sin(x[0]) + 7.0 * np.sin(x[1]) ** 2 + 0.1 * x[2] ** 4 * np.sin(x[0])


def linear(x):
    return np.sqrt([0.75, 0.2, 0.05]) @ stats.norm.ppf(stats.uniform.cdf(x, -np.pi, 2.0 * np.pi))


@pytest.mark.parametrize(("count", "shift"), [(32, 0.04), (64, 0.02), (200, 0.01)])
@pytest.mark.parametrize(("function", "wanted"), [(ishigami, [0.3139, 0.4424, 0.0]), (linear, [0.75, 0.2, 0.05])])
def test_intervals_of_first_order_indices_cover(function, wanted, count, shift):
    """400 samples each: exact indices (Saltelli et al. 2008, and the shares of a sum) inside 1.96 standard errors."""
    errors, covered = [], []
    for seed in range(400):
        x = np.random.default_rng(seed).uniform(-np.pi, np.pi, (3, count))
        inputs = stats.norm.ppf(stats.uniform.cdf(x, -np.pi, 2.0 * np.pi)) if function is linear else x
        found = [reductions._first_order(values, function(x)) for values in inputs]
        errors.append([index - exact for (index, _), exact in zip(found, wanted, strict=True)])
        covered.append([abs(index - w) < 1.96 * sigma for (index, sigma), w in zip(found, wanted, strict=True)])
    assert np.max(np.abs(np.mean(errors, axis=0))) < shift
    assert np.min(np.mean(covered, axis=0)) > 0.91
    assert 0.94 < np.mean(covered) < 0.99


def test_an_output_or_an_input_that_stays_has_no_index():
    x = np.random.default_rng(0).uniform(size=(2, 100))
    assert reductions._first_order(x[0], np.ones(100)) == (0.0, 0.0)
    index, error = reductions._first_order(np.ones(100), x[1])
    assert abs(index) < 2.0 * error
    index, error = reductions._first_order(x[0], 3.0 * x[0] - 1.0)
    assert index == pytest.approx(1.0, abs=1e-9)
    assert error < 1e-9


def test_indices_and_coefficients_of_a_sum_are_shares_of_its_variance():
    rng = np.random.default_rng(1)
    x = rng.normal(size=(2, 4000))
    found = ranking({"a": x[0], "b": x[1]}, 3.0 * x[0] - x[1], rng)
    (first, second) = found.rows
    assert (first.path, second.path) == ("a", "b")
    assert abs(first.index - 0.9) < 4.0 * first.index_error + 0.01
    assert first.coefficient == pytest.approx(np.sqrt(0.9), abs=4.0 * first.coefficient_error)
    assert second.coefficient == pytest.approx(-np.sqrt(0.1), abs=4.0 * second.coefficient_error)
    assert found.linear_share == pytest.approx(1.0)


def test_running_quantiles_settle_as_their_errors_say():
    rng = np.random.default_rng(2)
    found = running_quantile(rng.normal(size=4000), np.array([0.5]), rng)
    assert found.counts[-1] == 4000
    assert found.errors[-1, 0] == pytest.approx(np.sqrt(np.pi / 2.0 / 4000), rel=0.25)
    assert np.all(np.abs(found.values[:, 0]) < 4.0 * found.errors[:, 0])


def test_jump_speeds_have_a_standard_error():
    """The median of n normal numbers has sigma sqrt(pi / 2n)."""
    speeds = np.random.default_rng(1).normal(100.0, 2.0, 400)
    found = JumpSpread((50.0, 150.0), np.array([0.5]), speeds, np.where(np.arange(400) < 1, speeds, np.nan), 0)
    up, down = found.errors()
    assert up[0] == pytest.approx(2.0 * np.sqrt(np.pi / 800), rel=0.3)
    assert np.isnan(down[0])
    result = Variability({"J": np.ones(400)}, (), found, None, 0)
    assert f"jump up: 400 of 400 drives, at [rad/s] 50%: {found.quantiles()[0][0]:.6g} +- 0.1" in str(result)
    assert "+- nan" not in str(result)


def test_the_probability_of_a_resonance_in_a_band():
    """sqrt(K/J)/2 is uniform in sqrt(K): between 0.6 and 0.7 for K from 1.44 to 1.96."""
    held = LINEAR._replace(excitation=sw.Harmonic(0.0, order=1), error=sw.KinematicError((sw.Line(2, 0.1),)))
    drives = drawn(held, {"law.K": sw.Uniform(1.0, 3.0)}, 4000, 0)
    natural = natural_frequencies(held, drives)
    np.testing.assert_allclose(natural, np.sqrt(drives["law.K"]), rtol=1e-12)
    share = np.mean((natural > 1.2) & (natural < 1.4))
    assert share == pytest.approx(0.26, abs=4.0 * np.sqrt(0.26 * 0.74 / 4000))


@pytest.mark.slow
def test_the_band_counts_driven_orders_only():
    held = LINEAR._replace(excitation=sw.Harmonic(0.0, order=1), error=sw.KinematicError((sw.Line(2, 0.1),)))
    spread = {"law.K": sw.Uniform(1.0, 3.0)}
    band = sw.sample.variability(held, spread, count=400, settle=20, speed_band=(0.6, 0.7)).band
    assert set(band.inside) == {2}
    p, error = band.probability()
    assert p == pytest.approx(0.26, abs=4.0 * error)


def test_natural_frequencies_at_an_amplitude_and_a_mean_torque():
    """Nayfeh & Mook 1979, sec. 2.3.4: omega^2 = K (1 + 3/4 alpha a^2) with one harmonic."""
    drives = {"law.alpha": np.array([0.05, 0.2])}
    found = natural_frequencies(CUBIC, drives, 1.0)
    np.testing.assert_allclose(found, np.sqrt(1.0 + 0.75 * drives["law.alpha"]), rtol=1e-12)
    exact = sw.numerics.backbone(CUBIC._replace(law=sw.Cubic(1.0, 0.2)), [1.0]).omega[0]
    assert found[1] == pytest.approx(exact, rel=1e-3)
    biased = CUBIC._replace(excitation=sw.Harmonic(1.0, mean=1.5))
    u = np.array([np.roots([a, 0.0, 1.0, -1.5])[-1].real for a in drives["law.alpha"]])
    wanted = np.sqrt(1.0 + 3.0 * drives["law.alpha"] * u**2)
    np.testing.assert_allclose(natural_frequencies(biased, drives), wanted, rtol=1e-9)


SOFT = sw.Oscillator(1.3, 10.0, sw.Cubic(1e5, -1e6), sw.Harmonic(5.0, mean=30.0), 150.0)


def test_natural_frequencies_of_a_softening_law_near_its_largest_torque():
    """Cubic(K, -1/a^2) carries 2 K a/(3 sqrt 3) at most, and a share s of it at 2 a/sqrt 3 sin(asin(s)/3)."""
    rng = np.random.default_rng(1)
    a, share = rng.uniform(1e-3, 3e-3, 300), rng.uniform(0.7, 0.95, 300)
    mean = share * 2.0 * 1e5 * a / (3.0 * np.sqrt(3.0))
    found = natural_frequencies(SOFT, {"law.alpha": -1.0 / a**2, "excitation.mean": mean})
    u = 2.0 / np.sqrt(3.0) * np.sin(np.arcsin(share) / 3.0)
    np.testing.assert_allclose(found, np.sqrt(1e5 * (1.0 - 3.0 * u**2) / 1.3), rtol=1e-12)


def test_drives_that_cannot_carry_their_mean_torque_are_counted():
    # they carry 2/3 K/sqrt(3e6): 30 N*m from K = 77942 N*m/rad on
    K = np.linspace(6e4, 1e5, 41)
    natural = natural_frequencies(SOFT, {"law.K": K})
    assert np.array_equal(np.isnan(natural), 2.0 / 3.0 * K / np.sqrt(3e6) < 30.0)
    band = Band(100.0, 200.0, 0.0, natural, {1: natural > 0.0})
    assert band.without == 18
    drives = {"law.K": K}
    assert "18 drives have no natural frequency and count as without" in str(Variability(drives, (), None, band, 0))


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"distributions": {}}, "give a dict"),
        ({"distributions": {"law.k": sw.Uniform(1.0, 2.0)}}, "no parameter 'law.k'"),
        ({"distributions": {"law.K": 3.0}}, "distribution of 'law.K' is 3.0"),
        ({"distributions": {"J": sw.Uniform(-1.0, 2.0)}}, "is impossible: .*inertia"),
        ({"distributions": {"omega": sw.Uniform(1.0, 2.0)}, "speeds": [1.0]}, "leave one of them out"),
        ({"count": 5}, "at least 32"),
        ({"quantiles": [0.0, 0.5]}, "between 0 and 1"),
        ({"speeds": [-1.0]}, "must be positive"),
        ({"seed": 1.5}, "seed is 1.5"),
        ({"jump_count": 0}, "jump_count is 0"),
        ({"settle": 9, "longest": 1}, r"longest is 1 turns; it must be at least settle \+ 8 = 17"),
    ],
)
def test_bad_input_is_one_sentence(change, sentence):
    arguments = {"distributions": {"law.K": sw.Uniform(1.0, 3.0)}, "count": 32} | change
    with pytest.raises((ValueError, TypeError), match=sentence):
        sw.sample.variability(LINEAR, arguments.pop("distributions"), **arguments)
