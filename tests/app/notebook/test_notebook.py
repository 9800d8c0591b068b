"""Results in notebooks: table and figure of every class, with the numbers of `str`, from the result alone."""

import builtins
import re
from xml.etree import ElementTree

import numpy as np
import pytest
from all_results import RESULTS, WITHOUT_FIGURE, branch
from matplotlib.figure import Figure

import strainwave as sw
from strainwave.app.notebook.axes import MOST, Axes, colour, contours, shades

NO_CONTOUR = ("GeneralValidity", "SlowResponse without states")  # the map, or the response, is empty
SVG = "{http://www.w3.org/2000/svg}"


def parsed(name):
    return ElementTree.fromstring(RESULTS[name]()._repr_html_())


def texts(element):
    return " ".join(" ".join(element.itertext()).split())


@pytest.mark.parametrize("name", RESULTS)
def test_every_result_has_its_summary_in_a_notebook(name):
    page = parsed(name)
    summary = page[0]
    words = re.sub(r"[:=\s]+", " ", str(RESULTS[name]()))
    assert re.sub(r"[:=\s]+", " ", texts(summary)).strip() == words.strip()
    for table in page.iter("table"):
        assert table.find("caption") is not None or table.find("thead") is not None
        widths = {sum(int(cell.get("colspan", 1)) for cell in row) for row in table.iter("tr")}
        assert len(widths) <= 2  # the head of columns may have no name of its rows
        assert all(row[0].get("scope") or row[0].get("colspan") or len(row) == 1 for row in table.iter("tr"))


@pytest.mark.parametrize("name", RESULTS)
def test_a_figure_is_whole_and_comes_from_the_result_alone(name):
    html = RESULTS[name]()._repr_html_()
    assert html == RESULTS[name]()._repr_html_()
    page = ElementTree.fromstring(html)
    figures = list(page.iter(f"{SVG}svg"))
    assert bool(figures) == (name not in (*WITHOUT_FIGURE, *NO_CONTOUR))
    if figures:
        assert figures[0].get("role") == "img"
        assert figures[0].get("aria-label").startswith("figure of")
        drawn = ElementTree.tostring(figures[0], encoding="unicode")
        assert not re.search(r"\b(nan|inf)\b", drawn.split(">", 1)[1], re.IGNORECASE)
        assert page.find("div").get("style").startswith("background:#ffffff")
    assert not re.search(r"<(script|link|img|iframe|style|object)|url\(|href|https?://(?!www\.w3\.org/2000/svg)", html)


@pytest.mark.parametrize("name", [n for n in RESULTS if n not in (*WITHOUT_FIGURE, *NO_CONTOUR)])
def test_the_axes_have_the_names_that_matplotlib_shows(name):
    axes = Figure().add_subplot()
    RESULTS[name]().plot(axes)
    figure = next(parsed(name).iter(f"{SVG}svg"))
    said = [" ".join(text.itertext()) for text in figure.iter(f"{SVG}text")]
    assert axes.get_xlabel() in said
    assert set(axes.get_ylabel().split("\n")) <= set(said)


def test_a_branch_has_its_curve_at_the_places_of_its_numbers():
    axes = Axes()
    sw.draw_branch(axes, branch())
    lines = [c for c in axes.panel.curves if not c.marker]
    assert [c.dash for c in lines] == ["", "6 3", ""]
    np.testing.assert_array_equal(np.concatenate([c.x[:-1] for c in lines]), branch().omega[:-1])


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


def test_a_long_curve_keeps_its_extremes():
    axes, x = Axes(), np.linspace(0.0, 1.0, 100_000)
    y = np.sin(7.0 * x)
    y[[31_234, 77_777]] = 9.0, -9.0
    axes.plot(x, y)
    (drawn,) = axes.panel.curves
    assert len(drawn.x) <= MOST + 2
    assert (np.max(drawn.y), np.min(drawn.y), drawn.x[0], drawn.x[-1]) == (9.0, -9.0, 0.0, 1.0)
    assert np.all(np.diff(drawn.x) > 0.0)


def test_a_line_breaks_where_it_has_no_number():
    axes = Axes()
    axes.plot([0.0, 1.0, 2.0, 3.0, 4.0], [1.0, 2.0, np.nan, 2.0, 1.0])
    assert [list(c.x) for c in axes.panel.curves] == [[0.0, 1.0], [3.0, 4.0]]


def test_lines_of_equal_height_lie_on_it():
    x, y = np.linspace(-1.0, 1.0, 9), np.linspace(0.0, 1.0, 7)
    ends = [(a, b) for xs, ys in contours(x, y, 2.0 * x + 3.0 * y[:, None], [1.1]) for a, b in zip(xs, ys, strict=True)]
    assert len(ends) > 10
    np.testing.assert_allclose([2.0 * a + 3.0 * b for a, b in ends], 1.1, rtol=1e-12)


def test_cells_are_the_darker_the_larger_they_are():
    cells = shades(np.arange(4.0), np.arange(2.0), np.array([[0.0, np.nan, 1.0]]), (None, None))
    assert [(list(c.x), c.colour) for c in cells] == [([0.0, 1.0], "#fafafa"), ([2.0, 3.0], "#505050")]


@pytest.mark.parametrize(("name", "found"), [("0.5", "#808080"), ("C1", "#D55E00"), ("k", "#000000"), ("#123456",) * 2])
def test_colours_have_the_names_of_matplotlib(name, found):
    assert colour(name) == found
