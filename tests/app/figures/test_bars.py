"""The bar chart: well-formed, every text inside, bars as long as their values."""

import xml.etree.ElementTree as ET

import pytest

from strainwave.app.report.remedies import Bar, bars
from strainwave.plot.svg import LETTER, WIDTH

SVG = "{http://www.w3.org/2000/svg}"
ROWS = [
    Bar("kinematic error of order 2 cancelled by feed-forward", -0.98, "−98 %"),
    Bar("10 % less bandwidth of the loop", -0.13, "−13 %"),
    Bar("30 % more damping of the coupling", -0.006, "−0.6 %"),
    Bar("next size of the gear, <CSG-45-50> & more", -0.1, "−10 %"),
]


def drawn(rows):
    return ET.fromstring(bars(rows, "change of the largest oscillation", "what helps"))


@pytest.mark.parametrize("rows", [ROWS, ROWS[:1], ROWS[-1:], ROWS[:2], [Bar("word " * 30, -0.5, "−50 %")]])
def test_every_text_lies_inside_the_figure(rows):
    root = drawn(rows)
    _, _, width, height = map(float, root.get("viewBox").split())
    assert width == WIDTH
    for text in root.iter(f"{SVG}text"):
        x, y, long = float(text.get("x")), float(text.get("y")), LETTER * len(text.text)
        start = x - long if text.get("text-anchor") == "end" else x
        assert start >= 0.0, text.text
        assert start + long <= width, text.text
        assert 8.0 < y < height


def test_names_end_before_the_bars_and_their_values_begin():
    root = drawn(ROWS)
    names = [t for t in root.iter(f"{SVG}text") if t.get("text-anchor") == "end" and "%" not in t.text[-1:]]
    edge = max(float(t.get("x")) for t in names)
    assert min(float(r.get("x")) for r in root.iter(f"{SVG}rect")) > edge
    values = [t for t in root.iter(f"{SVG}text") if t.text in {row.value for row in ROWS}]
    for text in values:
        if text.get("text-anchor") == "end":
            assert float(text.get("x")) - LETTER * len(text.text) > edge


def test_bars_are_as_long_as_their_values_in_their_order_and_end_at_the_axis():
    rects = list(drawn(ROWS).iter(f"{SVG}rect"))
    widths = [float(rect.get("width")) for rect in rects]
    assert widths[0] / widths[1] == pytest.approx(0.98 / 0.13, rel=0.01)
    assert widths[3] / widths[1] == pytest.approx(0.10 / 0.13, rel=0.01)
    tops = [float(rect.get("y")) for rect in rects]
    assert tops == sorted(tops)
    ends = [float(rect.get("x")) + float(rect.get("width")) for rect in rects]
    assert ends == pytest.approx([ends[0]] * len(ends), abs=0.11)
