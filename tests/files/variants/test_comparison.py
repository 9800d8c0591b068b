"""A comparison has the numbers of the analysis of each drive: all torques of its load, gravity among them."""

import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from assumed_axis import axis
from click.testing import CliRunner
from one_joint import JOINT

import strainwave as sw
from strainwave.app.commands.cli import cli
from strainwave.app.report.comparison import comparison_page
from strainwave.base.facts import data, lines
from strainwave.base.units import ARCSEC, RPM
from strainwave.files.reading import from_text
from strainwave.files.variants.comparison import compared
from strainwave.plot.comparison import comparison_panels

PLAIN = JOINT.replace("title: joint", "title: plain").replace("hysteresis:", "#").replace("limit:", "# ")


@pytest.mark.slow
def test_a_comparison_has_the_numbers_of_the_report(tmp_path):
    files = [tmp_path / f"{name}.yaml" for name in ("joint", "plain")]
    for file, text in zip(files, (JOINT, PLAIN), strict=True):
        file.write_text(text, encoding="utf-8")
    run = CliRunner().invoke(cli, ["compare", *map(str, files), "-o", str(tmp_path / "compared"), "--json"])
    assert run.exit_code == 0, run.output
    rows = json.loads(run.stdout)["drives"]
    run = CliRunner().invoke(cli, ["analyze", *map(str, files), "-o", str(tmp_path / "out"), "--compare", "--json"])
    assert run.exit_code == 0, run.output
    results = json.loads(run.stdout)
    for row, found in zip(rows, results.values(), strict=True):
        worst = found["largest_oscillation"]
        assert row["oscillation_arcsec"] == pytest.approx(worst["oscillation_arcsec"], rel=1e-9)
        assert row["speed_rpm"] == pytest.approx(worst["motor_speed_rpm"], rel=1e-9)
        assert row["torque_N_m"] == pytest.approx(found["largest_torque"]["torque_Nm"], rel=1e-9)
        assert row["verdict"] == found["verdict"]["answer"]
        assert (row["lowest_load_torque_N_m"], row["highest_load_torque_N_m"]) == pytest.approx((-80.0, 40.0))
        speeds = found["verdict"]["speeds_to_keep_out_of"]
        bands = [f"{band['from_rpm']:.5g} to {band['to_rpm']:.5g} rpm" for band in speeds]
        assert row["keep_out_of"] == (", ".join(bands) or "none")
    page = (tmp_path / "compared" / "comparison.html").read_text(encoding="utf-8")
    assert all(row["keep_out_of"] in page for row in rows)
    assert "gravity included" in page


@pytest.mark.slow
def test_the_torque_of_a_comparison_is_at_least_that_of_gravity():
    project = from_text(PLAIN.replace(", {order: 4, amplitude: 5 arcsec}", ""), Path("plain.yaml"))
    other = sw.replaced(project, {"load.drag.amplitude": "100 N*m", "motor.max_torque": "0.5 N*m"})
    found = sw.compare([project, other])
    assert found.failures[0] == ""
    assert "above its limit of 0.5 N*m" in found.failures[1]
    assert np.all(found.torque > [80.0, 120.0])  # gravity and the mean, and the vibration
    assert "gear torque" in " ".join(str(found).split())
    tops = [response.oscillation[response.visited()] for response in found.responses]
    assert found.oscillation / ARCSEC == pytest.approx([np.max(sizes) / ARCSEC for sizes in tops])
    assert found.keep_out_of(0).endswith("rpm")
    low, high = project.speeds.limits
    assert all(low / RPM <= float(band.split(" to ")[0]) <= high / RPM for band in found.keep_out_of(0).split(", "))


@pytest.mark.slow
def test_a_drive_without_a_stable_motion_has_no_size_of_the_error_equation():
    found = axis().analyze(advice=False)
    both = compared([axis(), axis()], [replace(found, train=replace(found.train, curve=None)), found])
    lost, known = data(both.facts())["drives"]
    sizes = ("oscillation_arcsec", "speed_rpm", "load_torque_N_m", "torque_N_m", "folds")
    assert [lost[key] for key in sizes] == [None] * 5
    assert known["oscillation_arcsec"] == pytest.approx(found.largest_oscillation().peak / ARCSEC)
    told = {line[:32].strip(): line.split()[-2:] for line in lines(both.facts()) if line.startswith("  ")}
    assert told["gear torque [N·m]"][1] == "–"  # the second column is that of the lost one
    panels = comparison_panels(both, axis().speeds)
    names = {curve.label for curve in panels[0].curves}
    assert {"1: axis (error equation alone)", "2: axis"} <= names
    page = comparison_page(both, "")
    assert "<th>drive</th><th>2: axis</th><th>1: axis</th>" in page
    assert re.search(r'<td>gear torque \[N·m\]</td><td class="n">[\d.]+</td><td class="n">–</td>', page)
