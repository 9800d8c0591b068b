"""The report as a file for others: pass or fail, provenance, the same bytes again, several drives side by side."""

import hashlib
import json
import math
import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from strainwave.app.commands.cli import cli

pytestmark = pytest.mark.slow

ROOT = Path(__file__).resolve().parents[3]
PROJECT = """\
title: {title}
gear: {{ratio: 100, law: {{type: linear, K: 3.1e4 N*m/rad}}}}
motor: {{inertia: 1e-4 kg*m^2, mode: held}}
load: {{inertia: 2 kg*m^2}}
damping: {{ratio: 10 %}}
speed: {{from: 300 rpm, to: 1000 rpm, shaft: motor}}
excitation: {{kinematic_error: [{{order: 2, amplitude: 10 arcsec}}]}}
{limit}"""


def project(folder, name, limit=None, title="Table"):
    path = folder / f"{name}.yaml"
    end = "" if limit is None else f"limit: {{oscillation: {limit} arcsec}}\n"
    path.write_text(PROJECT.format(title=title, limit=end), encoding="utf-8")
    return path


def analysed(tmp_path, *paths, options=()):
    folder = tmp_path / "out"
    result = CliRunner().invoke(cli, ["analyze", *map(str, paths), "-o", str(folder), *options])
    assert result.exit_code == 0, result.output
    return folder, result.output


def results(folder):
    return json.loads((folder / "results.json").read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def judged(tmp_path_factory):
    """Reports of one drive without a limit, with one that it keeps and with one that it does not."""
    home = tmp_path_factory.mktemp("judged")
    files = [project(home, "free"), project(home, "kept", 100), project(home, "passed", 20)]
    return home, *analysed(home, *files, options=["--compare"])


def test_the_first_lines_say_pass_or_fail_and_by_how_much(judged):
    _, folder, _ = judged
    verdicts = {name: results(folder / name)["verdict"] for name in ("free", "kept", "passed")}
    r, zeta = np.linspace(0.5, 1.7, 100_001), 0.1
    largest = 10.0 * np.max(np.abs((1 + 2j * zeta * r) / (1 - r * r + 2j * zeta * r)))  # transmissibility [arcsec]
    assert verdicts["kept"]["headline"].startswith("Pass; the oscillation is ")
    assert verdicts["kept"]["largest_over_limit"] == pytest.approx(largest / 100, rel=1e-5)
    assert verdicts["passed"]["headline"].startswith(("Fail; the oscillation is ", "Fail at some speeds; the osc"))
    assert verdicts["passed"]["largest_over_limit"] == pytest.approx(largest / 20, rel=1e-5)
    assert verdicts["free"]["largest_over_limit"] is None
    assert "limit: {oscillation: 60 arcsec}" in verdicts["free"]["what_to_do"]
    for name, verdict in verdicts.items():
        page = (folder / name / "report.html").read_text(encoding="utf-8")
        assert page.index(verdict["headline"]) < page.index("<svg")


def test_the_smallest_change_is_the_whole_percent_of_the_line_that_a_linear_drive_needs(judged):
    _, folder, _ = judged
    verdict = results(folder / "passed")["verdict"]
    percent = math.ceil(100.0 * (1.0 - 0.99 / verdict["largest_over_limit"]))  # the oscillation goes with the line
    after = 10.0 * (1.0 - percent / 100.0)
    change, said = verdict["smallest_change"], verdict["answers"]["smallest change"]
    assert (change["from"], change["to"]) == pytest.approx((10.0, after), rel=1e-9)
    assert change["oscillation_arcsec"] == pytest.approx(20.0 * verdict["largest_over_limit"] * after / 10.0, rel=1e-3)
    assert f"{percent} % less kinematic error of order 2 (10 to {after:.4g} arcsec); oscillation then " in said


def test_the_first_page_answers_a_question_a_line(judged):
    _, folder, _ = judged
    free, kept, passed = (results(folder / name)["verdict"]["answers"] for name in ("free", "kept", "passed"))
    assert kept["requirement"].endswith("must not exceed 100 arcsec at 300 to 1000 rpm at the motor.")
    assert kept["smallest change"] == "No change is needed."
    assert "without a change" not in kept
    assert kept["margin"].endswith("below its limit.")
    assert passed["margin"].endswith("above its limit.")
    assert "limit: {oscillation: 60 arcsec}" in free["requirement"]
    assert "margin" not in free
    page = (folder / "passed" / "report.html").read_text(encoding="utf-8")
    for what, answer in passed.items():
        assert f"<tr><th>{what}</th><td>{answer}</td></tr>" in page


def test_the_named_limit_is_one_that_the_file_takes(judged):
    home, folder, _ = judged
    line = re.search(r"limit: \{.*?\}", results(folder / "free")["verdict"]["what_to_do"])[0]
    path = home / "with_limit.yaml"
    path.write_text((home / "free.yaml").read_text(encoding="utf-8") + line + "\n", encoding="utf-8")
    result = CliRunner().invoke(cli, ["analyze", "--check", str(path)])
    assert result.exit_code == 0
    assert result.output.startswith(f"{path}: valid\n")


def test_the_report_says_where_it_comes_from(judged):
    home, folder, _ = judged
    found = results(folder / "kept")["provenance"]
    assert found["project_sha256"] == hashlib.sha256((home / "kept.yaml").read_bytes()).hexdigest()
    assert set(found["versions"]) == {"strainwave", "python", "numpy", "scipy", "numba"}
    assert found["command"] == "strainwave analyze kept.yaml -o kept"
    page = (folder / "kept" / "appendix.html").read_text(encoding="utf-8")
    assert found["project_sha256"] in page


def test_proofs_and_closed_forms_stand_in_the_appendix(judged):
    _, folder, _ = judged
    pages = [(folder / "kept" / name).read_text(encoding="utf-8") for name in ("report.html", "appendix.html")]
    report, appendix = (re.findall(r"<h2>(.*?)</h2>", page) for page in pages)
    last = ["D. Resonances", "E. Single speeds in time", "F. Stability without excitation"]
    assert appendix == ["A. Derived quantities", "B. Assumptions and certificates", "C. Project and provenance", *last]
    assert not {name[3:] for name in appendix} & set(report)


def test_the_certificate_of_the_curve_is_its_distance_from_integration(judged):
    _, folder, _ = judged
    found = results(folder / "kept")
    row = next(row for row in found["certificates"] if "integration" in row["held_against"])
    motions = [m for m in found["run_up"] if m["periodic"] and m["exact_peak_rad"]]
    assert row["relative_difference"] == max(abs(m["peak_rad"] / m["exact_peak_rad"] - 1.0) for m in motions) < 1e-4


def test_drives_are_compared_with_the_numbers_of_their_reports(judged):
    _, folder, output = judged
    page = (folder / "verdicts.html").read_text(encoding="utf-8")
    assert "1 of 3 drives pass at all their speeds" in page
    for name in ("free", "kept", "passed"):
        assert f'href="{name}/report.html"' in page
        verdict = results(folder / name)["verdict"]
        assert verdict["headline"] in page
        for what in ("largest oscillation", "margin", "jumps", "torque", "smallest change"):
            assert f">{verdict['answers'].get(what, '–')}</td>" in page
    assert "http:" not in re.sub(r'xmlns="http://www.w3.org/2000/svg"', "", page)
    assert output.endswith(f"comparison: {folder / 'verdicts.html'}\n")


def test_a_comparison_says_which_load_has_the_largest_oscillation(tmp_path):
    files = [project(tmp_path, "plain", 100), project(tmp_path, "arm", 100)]
    text = files[1].read_text(encoding="utf-8")
    ranged = text.replace("excitation: {", "excitation: {load_torque: {mean: {from: -20 N*m, to: 60 N*m}}, ")
    files[1].write_text(ranged, encoding="utf-8")
    folder, _ = analysed(tmp_path, *files, options=["--compare"])
    page = (folder / "verdicts.html").read_text(encoding="utf-8")
    results = json.loads((folder / files[1].stem / "results.json").read_text(encoding="utf-8"))
    torque = results["largest_oscillation"]["load_torque_Nm"]
    assert torque > 20.0  # the middle of the range, which has not the largest oscillation
    assert f" under a load torque of {torque:g} N·m." in page


@pytest.mark.slow
def test_two_processes_write_the_same_bytes(tmp_path):
    path = project(tmp_path, "table", 20)
    law = "type: cubic, alpha: 6.9e4 1/rad^2"
    path.write_text(path.read_text(encoding="utf-8").replace("type: linear", law), encoding="utf-8")
    written = []
    for seed in ("1", "77"):
        folder = tmp_path / f"out-of-{seed}"
        env = os.environ | {"PYTHONHASHSEED": seed, "PYTHONPATH": str(ROOT / "src")}
        command = [sys.executable, "-m", "strainwave", "analyze", str(path), "-o", str(folder)]
        subprocess.run(command, env=env, check=True, capture_output=True, cwd=folder.parent)
        written.append({file.name: file.read_bytes() for file in folder.iterdir()})
    assert written[0] == written[1]
    assert {"report.html", "results.json"} < written[0].keys()


def test_what_cannot_be_compared_is_said_in_a_sentence_before_anything_is_computed(tmp_path):
    good, bad = project(tmp_path, "good"), tmp_path / "bad.yaml"
    (tmp_path / "other").mkdir()
    twin = project(tmp_path / "other", "good")
    bad.write_text("gear: CSG-40-50\n", encoding="utf-8")
    out = ["-o", str(tmp_path / "out")]
    for paths, code, said in (
        ([good], 1, "--compare needs two project files or more, but 1 is given"),
        ([good, twin], 1, "two project files have the name 'good'"),
        ([good, bad], 3, f"{bad}:1:1: "),
    ):
        result = CliRunner().invoke(cli, ["analyze", *map(str, paths), "--compare", *out])
        assert result.exit_code == code
        assert said in result.output
        assert "Traceback" not in result.output
    assert not (tmp_path / "out").exists()


def test_a_check_reads_every_file_and_writes_nothing(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    good, bad = project(tmp_path, "good"), tmp_path / "bad.yaml"
    bad.write_text("gear: CSG-40-50\n", encoding="utf-8")
    before = sorted(tmp_path.iterdir())
    result = CliRunner().invoke(cli, ["analyze", "--check", str(good), str(bad), str(tmp_path / "absent.yaml")])
    assert result.exit_code == 3
    assert f"{bad}:1:1: damping: is missing" in result.output
    assert "absent.yaml" in result.output
    assert sorted(tmp_path.iterdir()) == before


@pytest.mark.parametrize("name", ["..", ".", "verdicts.html"])
def test_a_file_whose_report_would_have_no_folder_of_its_own_is_refused(tmp_path, name):
    result = CliRunner().invoke(
        cli,
        [
            "analyze",
            str(project(tmp_path, name)),
            str(project(tmp_path, "b")),
            "--compare",
            "-o",
            str(tmp_path / "out"),
        ],
    )
    assert result.exit_code == 1
    assert f"a report folder cannot have the name of '{name}.yaml'" in result.output
    assert not (tmp_path / "out").exists()


def test_the_command_that_makes_the_report_again_is_one_for_a_shell(tmp_path):
    path = project(tmp_path, "-a b $(touch c)")
    folder, _ = analysed(tmp_path, tmp_path / "." / path.name)
    words = shlex.split(results(folder)["provenance"]["command"])
    assert words == ["strainwave", "analyze", "./-a b $(touch c).yaml", "-o", "./-a b $(touch c)"]
