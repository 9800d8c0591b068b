"""The probability of exceeding a limit, against the closed form of a linear drive and exact binomial sums."""

import math
from dataclasses import replace

import numpy as np
import pytest
from linear_drive import LINEAR, SCATTERED, closed_form
from scipy import stats
from twelve_projects import PROJECTS

import strainwave as sw
from strainwave.files import yaml_text
from strainwave.files.reading import ProjectError, from_text
from strainwave.files.variants.names import nominal_of
from strainwave.files.variants.scatter import clopper_pearson, drawn

OMEGA = np.linspace(100.0, 200.0, 4001)


@pytest.fixture
def read(tmp_path):
    return lambda text: from_text(text, tmp_path / "drive.yaml")


@pytest.mark.slow
def test_every_drive_has_the_oscillation_of_the_closed_form_and_the_interval_holds_the_probability(read):
    # resonance peaks fall as 1/B: the limit is exceeded where B is below that of the limit
    limit = float(np.max(closed_form(1.0, 38.0, OMEGA)))
    text = LINEAR + f"limit: {{oscillation: {limit!r} rad}}\nscatter: {{damping.B: 10 %}}\n"
    found = sw.exceedance(read(text), count=48, seed=3)
    B = 40.0 * found.factors["damping.B"]
    exact = np.array([closed_form(1.0, b, at) for b, at in zip(B, found.at, strict=True)])
    np.testing.assert_allclose(found.oscillation, exact, rtol=1e-8)
    tops = np.array([np.max(closed_form(1.0, b, OMEGA)) for b in B])
    np.testing.assert_allclose(found.oscillation, tops, rtol=5e-3)  # the curve has about a hundred points
    below = stats.truncnorm.cdf((38.0 / 40.0 - 1.0) / 0.1, -3.0, 3.0)
    low, high = found.interval
    assert low < below < high
    assert found.exceeding == int(np.sum(found.oscillation > limit))
    assert found.probability == found.exceeding / 48
    assert "95 % confidence (Clopper-Pearson)" in str(found)
    assert found.ranking.rows[0].path == "damping.B"
    exceeding = found.oscillation > limit
    for b, low, high in zip(B[exceeding], found.low[exceeding], found.high[exceeding], strict=True):
        above = OMEGA[closed_form(1.0, b, OMEGA) > limit]
        assert low == pytest.approx(above[0], abs=0.15)  # the ends lie between points of the curve
        assert high == pytest.approx(above[-1], abs=0.15)
    assert np.all(np.isnan(found.low[~exceeding]))
    begin, end = found.ends(0.5)
    assert begin == pytest.approx(np.quantile(found.low[exceeding], (0.25, 0.75)))
    assert end.low > begin.high
    again = sw.exceedance(read(text), count=32, seed=3)
    np.testing.assert_array_equal(again.oscillation, found.oscillation[:32])


@pytest.mark.slow
def test_a_drive_with_gravity_exceeds_its_limit_where_it_does_under_any_torque_of_its_load(read):
    text = """\
gear: CSG-40-50
motor: {mode: held}
load: {inertia: 1.3 kg*m^2, drag: {type: angle_torque, amplitude: 150 N*m}}
damping: {ratio: 4 %}
speed: {from: 1200 rpm, to: 2600 rpm, shaft: motor}
excitation: {kinematic_error: [{order: 2, amplitude: 23 arcsec}]}
limit: {oscillation: 60 arcsec}
scatter: {load.inertia: 1e-6 %}
"""
    project = read(text)
    told = []
    found = sw.exceedance(project, count=32, progress=lambda done, of: told.append((done, of)))
    assert told == [(done, 32) for done in range(1, 33)]
    assert found.loads == pytest.approx((-150.0, -75.0, 0.0, 75.0, 150.0))
    curves = [sw.speed_map(project, loads=[load], search=False) for load in found.loads]
    largest = max(float(np.max(curve.oscillation)) for curve in curves)
    assert found.oscillation == pytest.approx(np.full(32, largest), rel=1e-3)
    assert float(np.max(project.response().oscillation)) < 0.98 * largest
    assert "Each under 5 torques of its load, -150 to 150 N*m." in str(found)


def test_factors_are_normal_cut_off_at_three_deviations_and_the_same_for_the_same_seed():
    factors = drawn((("a", 0.05), ("b", 0.2)), 20_000, 1)
    for name, share in (("a", 0.05), ("b", 0.2)):
        z = (factors[name] - 1.0) / share
        assert np.max(np.abs(z)) <= 3.0
        assert stats.kstest(z, stats.truncnorm(-3.0, 3.0).cdf).pvalue > 0.01
    assert abs(np.corrcoef(factors["a"], factors["b"])[0, 1]) < 0.03
    assert not np.array_equal(drawn((("a", 0.05),), 10, 2)["a"], drawn((("a", 0.05),), 10, 1)["a"])


def test_factors_have_the_correlation_of_the_file(read):
    text = LINEAR + "scatter: {load.inertia: 5 %, gear.K: 10 %}\nscatter_correlation: [[1, -0.9], [-0.9, 1]]\n"
    project = read(text)
    factors = drawn(project.scatter, 20_000, 1, project.correlation)
    assert np.corrcoef(factors["load.inertia"], factors["gear.K"])[0, 1] == pytest.approx(-0.9, abs=0.01)
    assert np.std(factors["gear.K"]) == pytest.approx(0.1, rel=0.03)
    J, K = np.array([(one.drive.J_l, one.drive.law.K) for one in sw.sample.scattered(project, 200, 1)]).T
    nominal = project.drive
    np.testing.assert_allclose(J / nominal.J_l, drawn(project.scatter, 200, 1, project.correlation)["load.inertia"])
    assert np.corrcoef(J, K)[0, 1] < -0.85
    assert from_text(sw.project_text(replace(project, title="written")), project.path).correlation == (
        (1, -0.9),
        (-0.9, 1),
    )


@pytest.mark.parametrize(
    ("rows", "said"),
    [
        ("[[1, 0.5], [0.4, 1]]", "is not the same on both sides"),
        ("[[1, 0.5, 0], [0.5, 1]]", "has 2 rows, not all with 2 numbers"),
        ("[[1]]", "has 1 rows and scatter 2 numbers"),
        ("5", "is no list of rows"),
        ("[[1, 2], [2, 1]]", "below zero; write smaller correlations"),
    ],
)
def test_a_table_that_is_no_correlation_is_refused(read, rows, said):
    with pytest.raises(ProjectError, match=said):
        read(LINEAR + f"scatter: {{load.inertia: 5 %, gear.K: 10 %}}\nscatter_correlation: {rows}\n")


@pytest.mark.parametrize(("hits", "count"), [(0, 20), (20, 20), (3, 20), (57, 200)])
def test_the_interval_is_where_binomial_tails_reach_their_share(hits, count):
    low, high = clopper_pearson(hits, count)

    def below(p, k):
        return sum(math.comb(count, i) * p**i * (1.0 - p) ** (count - i) for i in range(k + 1))

    assert low == 0.0 if hits == 0 else 1.0 - below(low, hits - 1) == pytest.approx(0.025, rel=1e-9)
    assert high == 1.0 if hits == count else below(high, hits) == pytest.approx(0.025, rel=1e-9)
    exact = stats.binomtest(hits, count).proportion_ci(0.95, "exact")
    assert (low, high) == pytest.approx((exact.low, exact.high), rel=1e-6)


def test_a_catalogue_gear_scatters_about_its_record(read):
    project = read(PROJECTS["catalogue gear, motor not named"])
    content = yaml_text.read(project.text).content
    assert nominal_of(content, project.gear, "gear.K1") == (project.gear.law.K1, "N*m/rad")
    assert nominal_of(content, project.gear, "gear.T2") == (project.gear.law.T2, "N*m")
    assert nominal_of(content, project.gear, "load.inertia") == (1.3, "kg*m^2")
    assert nominal_of(content, project.gear, "kinematic_error.1.amplitude") == (3.0, "arcsec")


def test_the_file_holds_the_scatter(read):
    project = read(LINEAR + "scatter: {load.inertia: 5 %, gear.K: 0.1}\n")
    assert project.scatter == (("load.inertia", 0.05), ("gear.K", 0.1))
    for wrong, said in (("0 %", "is not positive"), ("40 %", "is more than 30 %"), ("5 rad", "scatter")):
        with pytest.raises(ProjectError, match=said):
            read(LINEAR + f"scatter: {{load.inertia: {wrong}}}\n")


def test_a_phase_scatters_by_an_angle_whatever_its_value(read):
    """About a phase of 0, where a share of it is nothing, and through a file that is written and read again."""
    text = LINEAR.replace("order: 2,", "order: 2, phase: 0 deg,")
    assert text != LINEAR
    project = read(text + "scatter: {kinematic_error.0.phase: 2 deg, gear.K: 3 %}\n")
    for same in (project, read(sw.project_text(project))):
        assert dict(same.scatter) == {"kinematic_error.0.phase": pytest.approx(math.radians(2.0)), "gear.K": 0.03}
        phases = [one.kinematic_error.lines[0].phase for one in sw.sample.scattered(same, 400, 1)]
        assert np.mean(phases) == pytest.approx(0.0, abs=4.0 * math.radians(2.0) / math.sqrt(400.0))
        assert np.std(phases) == pytest.approx(math.radians(2.0), rel=0.15)
    for wrong, said in (("90 deg", "is more than 1 rad"), ("0 deg", "is not positive")):
        with pytest.raises(ProjectError, match=said):
            read(text + f"scatter: {{kinematic_error.0.phase: {wrong}}}\n")
    with pytest.raises(ProjectError, match="is an angle, but the number is no phase"):
        read(text + "scatter: {gear.K: 2 deg}\n")


@pytest.mark.parametrize(
    ("more", "options", "said"),
    [
        ("", {}, r"drive\.yaml has no scatter; write for example 'scatter: \{load\.inertia: 5 %\}'"),
        ("scatter: {load.inertia: 5 %}\n", {}, "has no limit; write for example"),
        ("scatter: {load.inertia: 5 %}\n", {"limit": 1e-4, "count": 31}, "count is 31; it must be at least 32"),
    ],
)
def test_what_is_missing_is_told_in_one_sentence(read, more, options, said):
    with pytest.raises(ValueError, match=said):
        sw.exceedance(read(LINEAR + more), **options)


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("load.inertias", "load.inertias is no number of this file, which gives load.inertia; let that scatter, or"),
        ("damping.ratio", "damping.ratio is no number of this file, which gives damping.B; let that scatter, or"),
        ("limit.oscillation", "limit.oscillation is no number of this file; write the number it scatters about, too"),
        ("nothing", "the project file has no 'nothing'; its numbers are gear.ratio"),
    ],
)
def test_a_name_of_the_scatter_that_the_file_does_not_have_is_refused_when_it_is_read(read, name, said):
    with pytest.raises(ProjectError) as refusal:
        read(LINEAR + f"scatter: {{{name}: 5 %, load.inertia: 3 %}}\n")
    (line,) = str(refusal.value).splitlines()
    assert f": scatter.{name}: {said}" in line


def test_a_ratio_and_a_bandwidth_scatter_as_the_numbers_that_they_stand_for(read):
    said = """
gear: SHG-32-100
motor: {inertia: 4.5 kg*cm^2, loop: %s}
load: {inertia: 5 kg*m^2}
damping: %s
speed: {from: 400 rpm, to: 600 rpm, shaft: motor}
excitation: {kinematic_error: [{order: 2, amplitude: 25 arcsec}]}
limit: {oscillation: 100 arcsec}
scatter: {load.inertia: 25 %%}
"""
    J, w, B = 4.5e-4 + 5e-4, 80.0 * math.pi, 2.0 * 0.025 * math.sqrt(sw.catalogue.gear("SHG-32-100").K1 * 5.0)
    notation = read(said % ("{type: speed, bandwidth: 40 Hz, damping: 1}", "{ratio: 2.5 %}"))
    gains = f"{{type: speed_loop, K_p: {J * w!r} N*m*s/rad, K_i: {J * w * w / 4.0!r} N*m/rad}}"
    numbers = read(said % (gains, f"{{B: {B!r} N*m*s/rad}}"))
    for one, other in zip(sw.sample.scattered(notation, 3), sw.sample.scattered(numbers, 3), strict=True):
        assert pytest.approx(other.drive.B, rel=1e-12) == one.drive.B
        assert one.drive.J_l == other.drive.J_l
        assert one.train.motor.control == pytest.approx(other.train.motor.control, rel=1e-12)
    anew = next(iter(sw.sample.scattered(notation, 3, retune=True)))
    assert pytest.approx(B * math.sqrt(anew.drive.J_l / 5.0), rel=1e-12) == anew.drive.B


@pytest.mark.slow
def test_drives_in_a_store_and_in_processes_are_those_in_memory(tmp_path, monkeypatch):
    monkeypatch.setenv("STRAINWAVE_JIT", "0")  # of the processes
    (tmp_path / "drive.yaml").write_text(SCATTERED, encoding="utf-8")
    project = sw.read_project(tmp_path / "drive.yaml")
    plain = sw.exceedance(project, count=32, seed=4)
    kept = {"store": tmp_path / "drives.zarr", "processes": True, "workers": 2}
    first = sw.exceedance(project, count=32, seed=4, **kept)
    told = []
    again = sw.exceedance(project, count=32, seed=4, **kept, progress=lambda *done: told.append(done))
    assert told == []  # all drives were there
    for found in (first, again):
        np.testing.assert_array_equal(found.oscillation, plain.oscillation)
        assert str(found) == str(plain)
    with pytest.raises(ValueError, match="holds another sweep"):
        sw.exceedance(project, count=32, seed=5, **kept)
