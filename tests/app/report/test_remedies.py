"""What would help, in results.json, in the sentence, in the table and in the figure of a report."""

import json

import pytest

from strainwave.app.report.report import write
from strainwave.files.reading import read_project
from strainwave.study.analysis.remedies import Remedy

FILE = """
gear: CSG-40-50
motor: {inertia: 4.5 kg*cm^2, mode: held}
load: {inertia: 1.3125 kg*m^2}
damping: {ratio: 8 %}
speed: {from: 1000 rpm, to: 2000 rpm, shaft: motor}
excitation:
  kinematic_error: [{order: 2, amplitude: 4 arcsec}, {order: 4, amplitude: 1 arcsec}]
  load_torque: {mean: MEAN}
limit: {oscillation: 25 arcsec}
sources: {damping: assumed}
"""


def report(tmp_path, mean):
    path = tmp_path / "drive.yaml"
    path.write_text(FILE.replace("MEAN", mean), encoding="utf-8")
    project = read_project(path)
    write(project, tmp_path / "out")
    results = json.loads((tmp_path / "out" / "results.json").read_text(encoding="utf-8"))
    return project, results, (tmp_path / "out" / "report.html").read_text(encoding="utf-8")


@pytest.mark.slow
def test_every_remedy_has_its_numbers_its_row_and_its_bar(tmp_path):
    _, results, page = report(tmp_path, "0 N*m")
    advice = results["advice"]
    rows = advice["remedies"]
    assert [row["relative_oscillation"] for row in rows] == sorted(row["relative_oscillation"] for row in rows)
    for row in rows:
        assert row["oscillation_rad"] == pytest.approx(row["relative_oscillation"] * advice["largest_oscillation_rad"])
        assert row["above_limit"] is (row["oscillation_rad"] > advice["limit_rad"])
        assert row["helps"] is (row["relative_oscillation"] < 0.995)
        assert (f"<td>{row['what']}</td><td>{row['change']}</td>" in page) is row["helps"]
    what = {row["what"]: row for row in rows}
    assert (what["next size of the gear"]["to"], what["inertia of the load"]["from"]) == ("CSG-45-50", 1.3125)
    assert ">1.3125</td>" in page  # as the file has it
    assert {row["above_limit"] for row in rows} == {True, False}
    best = next(row for row in rows if row["change"] != "cancelled by feed-forward")
    left = f"{100.0 * best['relative_oscillation']:.3g} %"
    assert f'style="background: linear-gradient(90deg, #cfe3f1 {left[:-2]}%, #fff0 0)">{left}</td>' in page
    assert f"{best['oscillation_arcsec']:.3g} arcsec" in page  # beside the figure of the first page, too
    assert f"{best['oscillation_arcsec']:.4g} arcsec" not in page
    said = advice["remedy_sentence"]
    assert f"Most helpful: {best['what']}, {best['to']}." in said or f"Most helpful: {best['change']}" in said


@pytest.mark.slow
def test_where_the_load_has_a_range_of_torques_remedies_are_for_the_one_of_the_largest_oscillation(tmp_path):
    project, results, _ = report(tmp_path, "{from: 0 N*m, to: 30 N*m}")
    analysis = project.analyze()
    worst = max(analysis.load_cases, key=lambda case: case.avoid.largest)
    advice = results["advice"]
    assert worst.avoid.largest == advice["largest_oscillation_rad"]
    lighter = next(row for row in advice["remedies"] if row["what"] == "inertia of the load")
    text = FILE.replace("MEAN", f"{worst.torque} N*m").replace("1.3125 kg", f"{lighter['to']} kg")
    # the same damping B, which follows the inertia where the file gives a ratio
    path = tmp_path / "changed.yaml"
    path.write_text(text.replace("ratio: 8 %", f"B: {project.drive.B} N*m*s/rad"), encoding="utf-8")
    changed = read_project(path).response()
    assert lighter["oscillation_rad"] == pytest.approx(max(changed.oscillation[changed.visited()]), rel=2e-3)
    assert f"under a load torque of {worst.torque:g} N·m" in advice["remedy_sentence"]
    assert "preload" not in {row["what"] for row in advice["remedies"]}


def test_changes_are_named_as_engineers_do():
    assert str(Remedy("bandwidth of the loop", -0.3, 0.0, 0.9, 1.0)) == "30 % less bandwidth of the loop"
    assert str(Remedy("next size of the gear", 0.0, 0.0, 0.9, 1.0, gear="CSG-45-50")) == (
        "next size of the gear, CSG-45-50"
    )
    assert str(Remedy("kinematic error of order 2", -1.0, 0.0, 0.1, 1.0)) == (
        "kinematic error of order 2 cancelled by feed-forward"
    )
