"""What a user's section gives is on the page as text."""

from types import SimpleNamespace

from strainwave.app.report.report import page
from strainwave.app.report.section import Part, Table, rendered_part
from strainwave.app.view import AngleUnit, View
from strainwave.drive.speeds import Speeds

ANALYSIS = SimpleNamespace(exact=SimpleNamespace(method="harmonic balance"))
PROJECT = SimpleNamespace(title="a drive", text="", speeds=Speeds((60.0, 200.0)))
VIEW = View(PROJECT, ANALYSIS, AngleUnit("rad", 1.0))
SVG = '<?xml version="1.0"?>\n<svg xmlns="http://www.w3.org/2000/svg"/>'


def mine(data=(), heading="Mine", **texts):
    """A section with data, a heading and texts."""
    given = dict(data)
    return lambda _: Part(heading, given, tables=[Table(given)], **texts)


def test_a_sentence_of_the_page_has_units_as_they_are_printed():
    section = mine(sentences=("0.3 N*m*s/rad on 2 kg*m^2, `--loads -4:4`",))
    assert rendered_part(section, VIEW).sentences == ["0.3 N·m·s/rad on 2 kg·m², `--loads -4:4`"]


def test_names_of_the_page_may_be_keys_of_a_section_and_its_texts_are_escaped():
    data = {name: "<script>" for name in ("rows", "template", "view", "heading", "unit")}
    section = mine(data, "<b>", sentences=("a & b",), figures=[SVG])
    html = page(VIEW, [rendered_part(section, VIEW)])
    assert html.count("&lt;script&gt;") == len(data)
    assert "<h2>&lt;b&gt;</h2>" in html
    assert "<p>a &amp; b</p>" in html
    assert html.count("<svg") == 1
    assert "<script" not in html
