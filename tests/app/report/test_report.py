"""The report folder: complete, self-contained, reproducible, without NaN, and right in its energy balance."""

import csv
import json
import math
import re
from types import SimpleNamespace

import pytest
from small_drive import CUBIC, PROJECT

import strainwave as sw
from strainwave.app.commands.analyze import report_of
from strainwave.app.console import number, plain
from strainwave.app.report.report import page
from strainwave.app.report.section import rendered_part
from strainwave.app.report.sections.gear_torsion import parametric_resonances
from strainwave.app.view import AngleUnit, View
from strainwave.files.reading import read_project

pytestmark = pytest.mark.slow


def drive(law=CUBIC, damping="ratio: 5 %"):
    text = PROJECT.replace("A small drive", "A drive & its <error>")
    return text.replace(CUBIC, law).replace("ratio: 5 %", damping)


def written(folder, law=CUBIC, damping="ratio: 5 %", name="out"):
    path = folder / "drive.yaml"
    path.write_text(drive(law, damping))
    found = report_of(read_project(path), folder / name)
    return found.results, folder / name, found.summary


@pytest.fixture(scope="module")
def report(tmp_path_factory):
    return written(tmp_path_factory.mktemp("report"))


@pytest.mark.slow
def test_every_file_named_in_the_results_is_there_and_nothing_else(report):
    results, folder, _ = report
    assert sorted(results["files"]) == sorted(p.name for p in folder.iterdir())


@pytest.mark.slow
def test_page_loads_nothing_from_outside_and_escapes_the_title(report):
    pages = [(report[1] / name).read_text(encoding="utf-8") for name in ("report.html", "appendix.html")]
    page = "".join(pages)
    links = re.findall(r"""(?:src|href|url)\s*[=(]\s*["']?(?!#|data:)[^"'>\s)]+""", page)
    assert set(links) == {'href="appendix.html', 'href="report.html'}
    assert "<script" not in page
    assert all("A drive &amp; its &lt;error&gt;" in page for page in pages)
    assert page.count("<svg") >= 3
    assert not re.search(r"\b(nan|inf|None)\b", re.sub(r"<style>.*?</style>", "", page, flags=re.DOTALL))


@pytest.mark.slow
def test_numbers_are_finite_everywhere(report):
    def forbid(text):
        raise AssertionError(text)

    json.loads((report[1] / "results.json").read_text(encoding="utf-8"), parse_constant=forbid)
    for path in report[1].glob("*.csv"):
        header, *rows = csv.reader(path.read_text(encoding="utf-8").splitlines())
        assert all(re.search(r"_(s|rad|rpm|Nm|rad_per_s)$|^(stable|periodic)$", name) for name in header), header
        assert rows
        assert not any("nan" in cell or "inf" in cell for row in rows for cell in row)


@pytest.mark.slow
def test_damping_takes_what_the_excitation_gives(report):
    for case in report[0]["cases"]:
        assert case["dissipated_J_per_turn"] > 0.0
        # both integrals are sums over samples of a closed orbit, closed to about 1e-9
        assert case["work_J_per_turn"] == pytest.approx(case["dissipated_J_per_turn"], rel=1e-5)


@pytest.mark.slow
def test_primary_resonance_sits_at_the_vendors_speed(report):
    primary = next(r for r in report[0]["resonances"] if r["name"] == "primary")
    # 60 f/2 with f = sqrt(K/J_l)/(2 pi): sqrt(1e5)/2 rad/s
    assert primary["motor_speed_rpm"] == pytest.approx(1509.876, abs=5e-3)
    assert primary["inside_range"]


@pytest.mark.slow
def test_a_report_has_one_unit_of_angle_and_a_verdict_beside_multiple_scales(report):
    page = re.sub(r"<pre>.*?</pre>", "", (report[1] / "report.html").read_text(encoding="utf-8"), flags=re.DOTALL)
    words = re.sub(r"<[^>]*>", " ", page)
    assert "arcsec" in words
    assert not re.search(r"[0-9] (mrad|rad)\b(?!/)", words)
    appendix = (report[1] / "appendix.html").read_text(encoding="utf-8")
    assert re.search(
        r"Multiple scales put the peak at .* arcsec and .*: relative to the computed curve, the amplitude is .* % too "
        r"(large|small)",
        appendix,
    )
    torque = report[0]["largest_torque"]["torque_Nm"]
    assert f"gear torque up to {torque:.4g} N·m" in report[2]


@pytest.mark.slow
def test_play_without_bias_is_reported_from_integration_with_the_reason(tmp_path):
    law = "{type: backlash, K: 1e5 N*m/rad, half_gap: 0.2 arcmin}"
    results, *_ = written(tmp_path, law=law, damping="B: 20 N*m*s/rad")
    assert results["resonances"] == []
    assert any("(backlash)" in sentence for sentence in results["warnings"])
    assert all(case["reason"] and case["peak_rad"] > 0.0 for case in results["cases"])


@pytest.mark.slow
def test_zero_damping_is_said_and_nothing_is_nan(tmp_path):
    results, *_ = written(tmp_path, damping="B: 0 N*m*s/rad")
    assert any(sentence.startswith("The damping is 0: no vibration decays") for sentence in results["warnings"])
    assert results["verdict"]["headline"].startswith("Fail; the damping is 0")
    assert "is stable" not in results["verdict"]["sentence"]
    assert [row["peak"] for row in results["resonances"]] == [None] * len(results["resonances"])


@pytest.mark.slow
def test_softening_escape_is_a_sentence(tmp_path):
    law = "{type: cubic, K: 1e5 N*m/rad, alpha: -4e7 1/rad^2}"
    results, *_ = written(tmp_path, law=law, damping="ratio: 1 %")
    assert results["stability"]["scope"] == "local"
    failed = [case for case in results["cases"] if case["peak_rad"] is None]
    assert failed  # from rest at the resonance; the run-up follows a motion that stays
    assert all("left every bound" in case["status"] for case in failed)
    assert any("left every bound" in sentence for sentence in results["warnings"])


def test_plain_data_has_no_nan():
    assert plain({"a": (1.0, float("inf")), 2: float("nan")}) == {"a": [1.0, None], "2": None}


MEMORY = (
    "{type: parallel, first: {type: linear, K: 1e5 N*m/rad}, "
    "second: {type: bouc_wen, K: 6e4 N*m/rad, ratio: 0, yield_twist: 0.08 mrad}}"
)


@pytest.mark.slow
def test_a_law_with_memory_is_reported_with_its_loop_and_closed_energies_and_without_multiple_scales(tmp_path):
    results, folder, _ = written(tmp_path, law=f"{MEMORY}, rated_torque: 178 N*m", damping="B: 15 N*m*s/rad")
    assert results["exact_response"]["method"] == results["largest_error"]["method"] == "harmonic balance"
    assert results["stability"]["scope"] == "none"
    primary = next(row for row in results["resonances"] if row["name"] == "primary")
    # once it slips the law is softer: the curve is largest below the speed of small oscillations, and the case is there
    assert primary["top"]["motor_speed_rpm"] < 0.9 * primary["motor_speed_rpm"]
    (band,) = results["advice"]["bands"]
    assert band["from_rpm"] < primary["top"]["motor_speed_rpm"] < band["to_rpm"]
    assert results["cases"][1]["motor_speed_rpm"] == primary["top"]["motor_speed_rpm"]
    assert {row["reason"] for row in results["resonances"]} == {
        "first-order multiple scales requires a spring, but this torsion law has friction or hysteresis"
    }
    for case in results["cases"]:
        # sums over 512 samples a turn; the losses have corners, so that they converge with the square of the step alone
        assert case["work_J_per_turn"] == pytest.approx(case["dissipated_J_per_turn"], rel=1e-4)
    loop = results["hysteresis"]
    # on the way from full load to zero torque the element yields the other way: at zero the spring carries its limit,
    # K yield_twist = 4.8 N*m, on both branches
    assert loop["hysteresis_loss_rad"] == pytest.approx(2.0 * 4.8 / 1e5, rel=0.01)
    assert loop["full_load_is_rated"]
    damping = results["damping"]
    assert damping["B_Nms_per_rad"] == 15.0
    held = next(mode for mode in damping["modes"] if mode["of"] == "error equation, motor held")
    assert held["damping_ratio"] == pytest.approx(15.0 / (2.0 * 1e5**0.5), rel=1e-9)
    # elastic and ideally plastic, beside the spring: 4 T_y (a - x_y), a = (T - T_y)/K; the smooth knee loses a bit less
    assert damping["hysteresis_loss"]["J_per_cycle"] == pytest.approx(4.0 * 4.8 * (173.2e-5 - 8e-5), rel=0.03)
    page = (folder / "appendix.html").read_text(encoding="utf-8")
    assert "Hysteresis of the gear" in page
    assert "No claim." in page
    assert "response: harmonic balance" in page


def varying(folder, depth):
    """Project of a stiffness that varies four times a turn, about the speed at which it may make motions grow."""
    path = folder / "drive.yaml"
    text = drive("{type: linear, K: 1e5 N*m/rad}", "ratio: 1 %, ripples: [{order: 1, depth: 5 %}]")
    text = text.replace("from: 1200 rpm, to: 1900 rpm", "from: 1450 rpm, to: 1560 rpm")
    path.write_text(text + f"stiffness: {{ripples: [{{order: 4, depth: {depth}}}]}}\n")
    return read_project(path)


@pytest.mark.slow
def test_a_varying_stiffness_is_reported_with_its_parametric_resonance(tmp_path):
    results = report_of(varying(tmp_path, "3 %"), tmp_path / "out").results
    (row,) = results["parametric_resonances"]
    # 4 omega = 2 omega_0, omega_0 = sqrt(1e5): grows only where the depth exceeds four times the damping ratio
    assert row["motor_speed_rpm"] == pytest.approx(1509.876, rel=2e-3)
    assert not row["unstable"]


def test_speeds_at_which_a_varying_stiffness_makes_motions_grow_are_on_the_page(tmp_path):
    project = varying(tmp_path, "10 %")
    found = SimpleNamespace(
        exact=SimpleNamespace(method="harmonic balance"),
        parametric=sw.study.parametric_resonances(project.system(1.0), project.speeds.limits),
    )
    view = View(project, found, AngleUnit("rad", 1.0))
    (row,) = parametric_resonances(view).data["parametric_resonances"]
    assert row["motor_speed_rpm"] == pytest.approx(1509.876, rel=2e-3)
    assert row["unstable"]
    # motions at the edges neither grow nor decay (Mathieu): |omega/omega_c - 1| = sqrt((depth/4)^2 - ratio^2)
    half = math.sqrt(0.025**2 - 0.01**2)
    assert row["low_rpm"] == pytest.approx(1509.876 * (1.0 - half), rel=2e-3)
    assert row["high_rpm"] == pytest.approx(1509.876 * (1.0 + half), rel=2e-3)
    html = page(view, [rendered_part(parametric_resonances, view)])
    assert f">{number(row['growth_per_s'])}</td>" in html


@pytest.mark.slow
def test_a_loop_and_a_coupling_are_reported_with_bode_plot_and_run_up(tmp_path):
    path = tmp_path / "drive.yaml"
    text = drive("{type: linear, K: 1e5 N*m/rad}")
    text = text.replace("mode: held", "loop: {type: speed_loop, K_p: 0.5 N*m*s/rad, K_i: 20 N*m/rad}")
    coupling = "coupling: {inertia: 0.1 kg*m^2, law: {type: linear, K: 4e5 N*m/rad}}"
    path.write_text(text.replace("inertia: 1 kg*m^2", "inertia: 0.9 kg*m^2, " + coupling))
    results = report_of(read_project(path), tmp_path / "out").results
    train, largest = results["train"], results["largest_error"]
    assert train["gains"] == {"K_p": 0.5, "K_i": 20.0, "K_d": 0.0}
    assert train["run_up"]["imbalance"] < 1e-6
    assert train["run_up"]["heat_J"]["gear damping"] > 0.0
    # what the page begins with is the train: the loop gives way, so that its error is below that of the equation
    assert largest["of"] == "whole drive train"
    assert largest["peak_rad"] == max(row["peak_train_rad"] for row in train["steady"])
    reduced = results["reduction"]["oscillation_rad"]
    assert largest["peak_rad"] < max(row["peak_equation_rad"] for row in train["steady"])
    assert reduced == pytest.approx(
        max(row["peak_equation_rad"] for row in train["steady"]), rel=1e-6
    )  # no mean torque
    # a slow pass meets the steady curve, beside what the integral of the loop takes to accelerate motor and load
    low, high = results["speed_range_rad_per_s"]
    inertia, rate = 5e-4 + 1.0 / 50.0**2, (high - low) / train["run_up"]["seconds"]
    lag = inertia * rate / (20.0 * 50.0)
    assert lag > 0.2 * largest["peak_rad"]
    assert train["run_up"]["largest_pointing_error_rad"] == pytest.approx(largest["peak_rad"] + lag, rel=0.1)
    (band,) = results["advice"]["bands"]
    assert band["from_rpm"] < largest["motor_speed_rpm"] < band["to_rpm"]
    assert "(error equation) the oscillation would reach" in results["reduction"]["sentence"]
