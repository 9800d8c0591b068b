"""The report as it is read: on paper, on a telephone, and with its figure, its remedies and its doubts first."""

import json
import re
from types import SimpleNamespace

import numpy as np
import pytest
from click.testing import CliRunner

import strainwave as sw
from strainwave.app.commands.cli import cli
from strainwave.app.view import AngleUnit, View
from strainwave.base.units import ARCSEC
from strainwave.study.analysis.verdict_words import _requirement

pytestmark = pytest.mark.slow

AXIS = """\
title: Azimuth axis
revision: B, 2026-11-26, A. Meier
gear: CSG-40-50
motor: {inertia: 4.5 kg*cm^2, loop: {bandwidth: 30 Hz, damping: 0.7}, max_torque: 3 N*m}
load: {inertia: 1.3 kg*m^2}
damping: {ratio: 3 %}
speed: {from: 500 rpm, to: 1800 rpm, shaft: motor}
limit: {oscillation: 30 arcsec}
excitation: {kinematic_error: [{order: 2, amplitude: 23 arcsec}]}
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("axis")
    (folder / "axis.yaml").write_text(AXIS)
    sw.report.write(folder / "axis.yaml", folder)
    return folder


@pytest.fixture(scope="module")
def results(folder):
    return json.loads((folder / "results.json").read_text(encoding="utf-8"))


def page(folder, name="report.html"):
    return (folder / name).read_text(encoding="utf-8")


def test_the_first_page_has_the_figure_then_what_can_be_ordered_then_the_answers(folder, results):
    first = page(folder)
    answers = [f"<th>{row}</th>" for row in results["verdict"]["answers"]]
    figure = ["<svg", "oscillation limit", "What can be ordered or set"]
    head = ["Azimuth axis</h1>", "revision B, 2026-11-26, A. Meier", results["verdict"]["headline"]]
    places = [first.index(text) for text in (*head, *figure, *answers)]
    assert places == sorted(places)
    assert {"motor", "loop", "how sure"} < results["verdict"]["answers"].keys()
    ordered = first[first.index("What can be ordered") : first.index("</table>")]
    assert "less bandwidth of the loop" in ordered
    assert "kinematic error" not in ordered


def test_what_nothing_excites_is_not_called_the_most_helpful(folder, results):
    cancelled = "cancelled by feed-forward"
    assert cancelled in {remedy["change"] for remedy in results["advice"]["remedies"]}
    assert cancelled not in results["advice"]["remedy_sentence"]
    assert "cancels one order of the kinematic error requires the phase of this order" in page(folder)


def test_how_sure_is_what_other_dampings_give(folder, results):
    project = sw.read_project(folder / "axis.yaml")
    for ratio, end in zip(("2 %", "5 %"), results["how_sure"]["ends"], strict=True):
        other = sw.replaced(project, {"damping.ratio": ratio}).response()
        largest = np.max(other.oscillation[other.visited()])
        assert end["oscillation_arcsec"] == pytest.approx(largest / ARCSEC, rel=0.01)
        assert f"{largest / ARCSEC:.3g} arcsec" in results["how_sure"]["sentence"]
        assert end["above_limit"] == (largest > 30.0 * ARCSEC)
    begin = "Damping 3 % is not marked as measured; 2 to 5 %"
    assert results["how_sure"]["sentence"].startswith(begin)
    assert results["how_sure"]["rows"] == []


@pytest.mark.parametrize(("sources", "ends"), [("", "at the motor."), ("limit: assumed", "The limit is assumed.")])
def test_the_requirement_says_that_its_limit_is_assumed(tmp_path, sources, ends):
    (tmp_path / "axis.yaml").write_text(AXIS + f"sources: {{damping: assumed, {sources}}}\n")
    project, drive = sw.read_project(tmp_path / "axis.yaml"), SimpleNamespace(name="pointing error")
    analysis = SimpleNamespace(drive=drive, speeds=(50.0, 200.0), avoid=None, project=project)
    view = View(project, analysis, AngleUnit("arcsec", ARCSEC))
    assert view.rendered(_requirement(view.analysis)).endswith(ends)


def test_margins_are_those_of_the_loop(folder, results):
    found = sw.margins(sw.read_project(folder / "axis.yaml").train)  # no torque: standstill is where it is linear
    assert results["loop_margins"]["phase_margin_deg"] == pytest.approx(np.degrees(found.phase_margin), rel=1e-3)
    assert results["loop_margins"]["delay_margin_s"] == pytest.approx(found.delay_margin, rel=1e-3)


def test_the_figure_of_the_loop_marks_its_margin_and_stands_behind_its_heading(folder, results):
    section = page(folder).partition("<h2>The whole drive train</h2>")[2]
    assert section.lstrip().startswith("<figure>")
    marked = re.search(r">([\d.]+)° at ([\d.]+) Hz<", section)
    assert float(marked[1]) == pytest.approx(results["loop_margins"]["phase_margin_deg"], abs=0.6)
    for text in (
        "open loop",
        "closed loop",
        "gain crossover",
        "step of the speed reference",
        "step of the load torque",
    ):
        assert f">{text}<" in section


ARM = """\
gear: {ratio: 100, law: {type: piecewise_linear, T1: 14 N*m, T2: 48 N*m, K1: 3.1e4 N*m/rad, K2: 5.0e4 N*m/rad,
  K3: 5.7e4 N*m/rad}}
motor: {inertia: 3 kg*cm^2, loop: {type: cascade, bandwidth: 30 Hz, damping: 0.7}}
load: {inertia: 1.2 kg*m^2, drag: {type: angle_torque, amplitude: 40 N*m}}
damping: {ratio: 3 %}
speed: {from: 300 rpm, to: 2000 rpm, shaft: motor}
limit: {oscillation: 60 arcsec}
sources: {motor.loop: assumed, damping: assumed}
excitation: {accuracy: 60 arcsec}
"""


SAMPLED = AXIS + "controller: {period: 0.25 ms, delay: 0.25 ms}\n"


@pytest.mark.parametrize("text", [AXIS, ARM, SAMPLED], ids=["axis", "arm", "sampled"])
def test_the_report_of_a_drive_with_a_loop_has_at_most_three_pages_of_paper(tmp_path, folder, browser, text):
    if text is not AXIS:
        folder = tmp_path
        (folder / "axis.yaml").write_text(text)
        sw.report.write(folder / "axis.yaml", folder)
    sheet = browser.new_page()
    sheet.goto((folder / "report.html").as_uri())
    assert 2 <= len(re.findall(rb"/Type\s*/Page\b", sheet.pdf(prefer_css_page_size=True))) <= 3
    sheet.close()


@pytest.mark.parametrize("name", ["report.html", "appendix.html"])
def test_a_telephone_shows_all_with_text_that_can_be_read(folder, browser, name):
    phone = browser.new_page(viewport={"width": 375, "height": 812})
    phone.goto((folder / name).as_uri())
    assert phone.evaluate("document.documentElement.scrollWidth") == 375
    cut = "[...document.querySelectorAll('.scroll, figure')].filter((one) => one.scrollWidth > one.clientWidth)"
    edges = phone.evaluate(f"{cut}.map((one) => getComputedStyle(one).backgroundAttachment)")
    assert edges
    assert {*edges} == {"local, local, scroll, scroll"}  # shadows at the edges, and paper that scrolls over them
    letters = """Array.from(document.querySelectorAll("svg[viewBox]"), (svg) =>
        parseFloat(svg.getAttribute("font-size")) * svg.getBoundingClientRect().width / svg.viewBox.baseVal.width)"""
    assert min(phone.evaluate(letters)) >= 8.5
    phone.close()


def test_a_figure_in_a_file_has_the_name_of_its_drive_and_is_white(folder):
    for words in (["response", "-o", str(folder / "figure.svg")], ["speed-map", "-o", str(folder)]):
        assert CliRunner().invoke(cli, [words[0], str(folder / "axis.yaml"), *words[1:]]).exit_code == 0
    for name in ("figure.svg", "speed-map.svg"):
        drawn = page(folder, name)
        assert ">Azimuth axis" in drawn
        assert '<rect width="100%" height="100%" fill="#ffffff"/>' in drawn
