"""What a user's section gives is looked at where it is asked: a wrong kind is one sentence, and nothing is written."""

from types import SimpleNamespace

import pytest

from strainwave.app.report.report import page, write
from strainwave.app.report.section import asked, sections_of
from strainwave.app.view import AngleUnit, View
from strainwave.base.units import Speeds

ANALYSIS = SimpleNamespace(exact=SimpleNamespace(method="harmonic balance"))
PROJECT = SimpleNamespace(title="a drive", text="", speeds=Speeds((60.0, 200.0)))
VIEW = View(PROJECT, ANALYSIS, AngleUnit("rad", 1.0))
SVG = '<?xml version="1.0"?>\n<svg xmlns="http://www.w3.org/2000/svg"/>'


class Mine:
    def __init__(self, data=(), heading="Mine", **texts):
        self.given, self.heading = data, heading
        for name, value in texts.items():
            setattr(self, name, lambda _, value=value: value)

    def data(self, _):
        return dict(self.given) if self.given == () else self.given


def test_a_sentence_of_the_page_has_units_as_they_are_printed():
    section = Mine(sentences=("0.3 N*m*s/rad on 2 kg*m^2, `--loads -4:4`",))
    assert asked(section, VIEW).sentences == ["0.3 N·m·s/rad on 2 kg·m², `--loads -4:4`"]


@pytest.mark.parametrize(
    ("sections", "sentence"),
    [
        (None, "sections are None; give a tuple of sections"),
        ("Mine", "sections are 'Mine'; give a tuple"),
        ((Mine,), "a section of the report is the class Mine; give an object of it"),
        ((3,), "a section of the report is 3; it must be an object with a method heading"),
        ((Mine(heading=None),), "Mine.heading is None; it must be a text"),
    ],
)
def test_what_is_no_section_is_refused_before_the_analysis(sections, sentence, tmp_path):
    with pytest.raises(TypeError, match=sentence):
        sections_of(sections)
    with pytest.raises(TypeError, match=sentence):
        write(tmp_path / "no such file.yaml", tmp_path / "out", sections=sections)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("section", "sentence"),
    [
        (Mine(data=None), "Mine.data gives None; it must be a dictionary with texts as keys"),
        (Mine(data=[("a", 1)]), "Mine.data gives .*; it must be a dictionary"),
        (Mine(data={1: 2}), "Mine.data gives {1: 2}; it must be a dictionary"),
        (Mine(sentences="abc"), "Mine.sentences gives 'abc'; it must be a list of texts"),
        (Mine(sentences=[3]), r"Mine.sentences gives \[3\]; it must be a list of texts"),
        (Mine(figures=None), "Mine.figures gives None; it must be a list of texts of SVG"),
        (Mine(figures=["<b>"]), "Mine.figures gives .*; it must be a list of texts of SVG"),
    ],
)
def test_what_a_section_must_not_give_is_one_sentence(section, sentence):
    with pytest.raises(TypeError, match=sentence) as error:
        asked(section, VIEW)
    assert "\n" not in str(error.value)


def test_names_of_the_page_may_be_keys_of_a_section_and_its_texts_are_escaped():
    data = {name: "<script>" for name in ("rows", "template", "view", "heading", "unit")}
    section = Mine(data, "<b>", sentences=("a & b",), figures=iter([SVG]))
    html = page(VIEW, [asked(section, VIEW)])
    assert html.count("&lt;script&gt;") == len(data)
    assert "<h2>&lt;b&gt;</h2>" in html
    assert "<p>a &amp; b</p>" in html
    assert html.count("<svg") == 1
    assert "<script" not in html
