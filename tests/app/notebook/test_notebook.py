"""Results in notebooks: text and figure of every class, with the numbers of `str`, from the result alone."""

import builtins
import re
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from all_results import RESULTS, WITHOUT_FIGURE, branch
from matplotlib.figure import Figure

import strainwave as sw

pytestmark = pytest.mark.slow

AXES = Path(sw.__file__).parent / "app/projects"
SVG = "{http://www.w3.org/2000/svg}"


def parsed(name):
    return ElementTree.fromstring(RESULTS[name]()._repr_html_())


@pytest.mark.parametrize("name", RESULTS)
def test_every_result_has_its_summary_in_a_notebook(name):
    page = parsed(name)
    assert page.find("pre").text == str(RESULTS[name]())
    for table in page.iter("table"):
        assert table.find("thead") is not None
        widths = {sum(int(cell.get("colspan", 1)) for cell in row) for row in table.iter("tr")}
        assert len(widths) <= 2  # the head of columns may have no name of its rows
        assert all(row[0].get("scope") or row[0].get("colspan") or len(row) == 1 for row in table.iter("tr"))


@pytest.mark.parametrize("name", RESULTS)
def test_a_figure_is_whole_and_comes_from_the_result_alone(name):
    html = RESULTS[name]()._repr_html_()
    assert html == RESULTS[name]()._repr_html_()
    page = ElementTree.fromstring(html)
    figures = list(page.iter(f"{SVG}svg"))
    assert bool(figures) == (name not in WITHOUT_FIGURE)
    if figures:
        assert figures[0].get("role") == "img"
        assert figures[0].get("aria-label").startswith("figure of")
        drawn = ElementTree.tostring(figures[0], encoding="unicode")
        assert not re.search(r"\b(nan|inf)\b", drawn.split(">", 1)[1], re.IGNORECASE)
        assert page.find("div").get("style").startswith("background:#ffffff")
    assert not re.search(r"<(script|link|img|iframe|style|object)|url\(|href|https?://(?!www\.w3\.org/2000/svg)", html)


@pytest.mark.parametrize("name", [n for n in RESULTS if n not in WITHOUT_FIGURE])
def test_the_axes_have_the_names_that_matplotlib_shows(name):
    axes = Figure().add_subplot()
    RESULTS[name]().plot(axes)
    figure = next(parsed(name).iter(f"{SVG}svg"))
    said = [" ".join(text.itertext()) for text in figure.iter(f"{SVG}text")]
    assert axes.get_xlabel() in said
    assert axes.get_ylabel().replace("\n", " ") in " ".join(reversed(said))


def test_a_branch_is_shown_without_matplotlib(monkeypatch):
    whole = builtins.__import__

    def without(name, *rest, **more):
        if name.startswith("matplotlib"):
            raise ModuleNotFoundError(name)
        return whole(name, *rest, **more)

    branch()
    monkeypatch.setattr(builtins, "__import__", without)
    assert "<svg" in branch()._repr_html_()


def test_what_a_summary_says_is_escaped():
    log = sw.Log(np.arange(9.0), {"a<b>&": np.arange(9.0)}, {"a<b>&": "V"}, ("<script>alert(1)</script>",))
    html = log._repr_html_()
    assert "<script" not in html
    assert "a&lt;b&gt;&amp;" in html
    ElementTree.fromstring(html)


CARDS = {
    "Project": (lambda: sw.read_project(AXES / "robot-joint.yaml"), [("load.inertia", "3.5 kg·m²", "yours"),
                                                                     ("motor.loop.bandwidth", "25 Hz", "assumed")]),
    "Gear CSG-40-50": (lambda: sw.catalogue.gear("CSG-40-50"), [("K1", "100000", "N·m/rad"), ("max_rpm", "4000", "rpm"),
                                                                 ("hysteresis_loss", "60", "arcsec")]),
    "Drive": (lambda: sw.HDC_40_050, [("J_m", "0.000526", "kg·m²"), ("law.K", "7160", "N·m/rad")]),
    "Oscillator": (lambda: sw.Oscillator(2.0, 3.0, sw.Linear(5.0), sw.Harmonic(1.0, 1, 0.5), 7.0,
                                         sw.KinematicError((sw.Line(2, np.pi / 648_000.0),))),
                   [("omega", "7", "rad/s"), ("excitation.phase", "0.5", "rad"),
                    ("error.lines.0.amplitude", "1", "arcsec")]),
}  # fmt: skip


@pytest.mark.parametrize("kind", CARDS)
def test_a_card_has_the_numbers_with_the_units_of_figures(kind):
    made, numbers = CARDS[kind]
    page = ElementTree.fromstring(made()._repr_html_())
    assert page.find("pre").text.startswith(kind)
    rows = [tuple(cell.text or "" for cell in row) for row in page.iter("tr")]
    assert set(numbers) < set(rows)
