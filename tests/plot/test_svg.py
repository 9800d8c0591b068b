"""Figures as SVG: round ticks, curves that keep their shape, well-formed text."""

import xml.etree.ElementTree as ET

import numpy as np
import pytest

from strainwave.plot.panels import Axis, Cells, Note, Panel
from strainwave.plot.svg import ACROSS, ROW, _path, beside, figure, log_ticks, thin, ticks


@pytest.mark.parametrize(
    ("low", "high", "labels"),
    [
        (0.0, 10.0, ["0", "2", "4", "6", "8", "10"]),
        (-0.55, 0.55, ["−0.50", "−0.25", "0.00", "0.25", "0.50"]),
        (1180.0, 1920.0, ["1200", "1400", "1600", "1800"]),
    ],
)
def test_ticks_are_round_numbers_inside_the_limits(low, high, labels):
    values, names = ticks(low, high, 5)
    assert names == labels
    assert [float(name.replace("−", "-")) for name in names] == pytest.approx(values)


def test_ticks_of_a_phase_are_multiples_of_a_quarter_turn():
    assert ticks(-95.0, 95.0, 5, 90.0) == ([-90.0, 0.0, 90.0], ["−90", "0", "90"])
    assert ticks(-390.0, 100.0, 4, 90.0) == ([-360.0, -180.0, 0.0], ["−360", "−180", "0"])


def test_ticks_of_a_tiny_range_do_not_read_alike():
    _, names = ticks(0.0, 1e-7, 4)
    assert len(set(names)) == len(names) > 2


def test_log_ticks_step_by_decades_or_by_one_two_five():
    assert log_ticks(0.5, 2e5)[1] == ["1", "10", "100", "1000", "10000", "100000"]
    assert log_ticks(4.0, 300.0)[1] == ["5", "10", "20", "50", "100", "200"]


def test_path_leaves_out_points_that_do_not_show():
    x = np.linspace(0.0, 300.0, 5001)
    y = 100.0 * np.sin(x / 30.0)
    points = np.array([pair.split() for pair in _path(x, y)[1:].split("L")], float)
    assert len(points) < 0.1 * len(x)
    # four passes of at most 0.08 px, and a decimal that is cut at 0.05
    assert np.max(np.abs(np.interp(x, points[:, 0], points[:, 1]) - y)) < 0.4


def panel():
    shown = Panel("a < b & c", Axis("speed", "rpm"), Axis("|x|", "arcsec"), notes=[Note(1.0, 2.0, "1.5")])
    shown.line([0.0, 1.0, 2.0], [1.0, 3.0, 2.0], "#0072B2", "stable")
    shown.line([1.0, 1.0], [-np.inf, np.inf], "#222222", "limit", "2 2")
    shown.points([0.5], [2.0], "#222222", "measured", "^", "#ffffff")
    return shown


def test_figure_is_well_formed_and_the_same_every_time():
    text = figure([[panel(), panel()], [panel()]], 200.0, 'what "it" shows')
    root = ET.fromstring(text)
    words = [element.text for element in root.iter("{http://www.w3.org/2000/svg}text")]
    assert words.count("a < b & c") == 3
    assert [words.count(name) for name in ("stable", "limit", "measured")] == [1, 1, 1]  # one legend for all
    assert "nan" not in text
    assert "inf" not in text
    assert text == figure([[panel(), panel()], [panel()]], 200.0, 'what "it" shows')


def test_a_logarithmic_panel_shows_values_that_span_decades():
    shown = Panel("", Axis("x"), Axis("y"), log=True)
    shown.line([0.0, 1.0, 2.0], [1.0, 100.0, 10000.0], "#0072B2", "law")
    path = next(e for e in ET.fromstring(figure([[shown]], 200.0, "")).iter() if e.get("stroke-linejoin"))
    x, y = np.array([pair.split() for pair in path.get("d")[1:].split("L")], float).T
    assert np.diff(y)[0] == pytest.approx(np.diff(y)[1], abs=0.11)
    assert np.diff(x)[0] == pytest.approx(np.diff(x)[1], abs=0.11)


def test_a_label_stands_on_the_side_of_its_point_that_no_line_crosses():
    x = np.linspace(0.0, 200.0, 21)
    level, upright = (x, 0.0 * x + 50.0), (np.array([100.0, 100.0]), np.array([0.0, 50.0]))
    assert beside(100.0, 50.0, 30.0, [])[2] == "start"
    # a line through the point from left to right, and one from above: below is free
    u, v, anchor = beside(100.0, 50.0, 30.0, [level, upright])
    assert (u, anchor) == (100.0, "middle")
    assert v - ROW > 50.0
    right = (x[10:], 0.0 * x[10:] + 50.0)
    assert beside(100.0, 50.0, 30.0, [right])[2] == "end"


def drawn(shown):
    return ET.fromstring(figure([[shown]], 200.0, ""))


def test_numbers_are_shown_in_the_unit_of_their_axis():
    shown = Panel("", Axis("time", "ms", 1e-3), Axis("torque", "N*m"))
    shown.line([0.0, 0.008], [1.0, 3.0])
    words = [element.text for element in drawn(shown).iter("{http://www.w3.org/2000/svg}text")]
    assert {"time (ms)", "torque (N·m)", "0", "2", "4", "6", "8"} <= set(words)


def test_a_long_curve_keeps_its_extremes():
    x = np.linspace(0.0, 1.0, 100_000)
    y = np.sin(7.0 * x)
    y[[31_234, 77_777]] = 9.0, -9.0
    across, up = thin(x, y)
    assert len(across) <= 2 * ACROSS + 2
    assert (np.max(up), np.min(up), across[0], across[-1]) == (9.0, -9.0, 0.0, 1.0)
    assert np.all(np.diff(across) > 0.0)


def test_a_line_breaks_where_it_has_no_number():
    shown = Panel("", Axis("x"), Axis("y"))
    shown.line([0.0, 1.0, 2.0, 3.0, 4.0], [1.0, 2.0, np.nan, 2.0, 1.0])
    (path,) = (e.get("d") for e in drawn(shown).iter() if e.get("stroke-linejoin"))
    assert [part.count("L") for part in path.split("M")[1:]] == [1, 1]


def test_neighbouring_cells_of_one_colour_are_one_rectangle():
    shown = Panel("", Axis("x"), Axis("y"))
    shown.cells = Cells(np.arange(5.0), np.arange(2.0), np.array([[0, 0, -1, 1]]), ("#fafafa", "#505050"))
    ground, *boxes = [e for e in drawn(shown).iter() if e.tag.endswith("rect")]
    assert ground.get("fill") == "#ffffff"
    assert [box.get("fill") for box in boxes] == ["#fafafa", "#505050"]
    widths = [float(box.get("width")) for box in boxes]
    assert widths[0] == pytest.approx(2.0 * widths[1], rel=0.01)


def test_texts_above_a_panel_do_not_meet_and_stay_inside():
    shown = Panel("", Axis("x"), Axis("y"))
    shown.line([0.0, 10.0], [0.0, 1.0])
    shown.notes = [Note(x, 0.0, "constant speed", above=True) for x in (0.0, 0.1, 0.2, 9.9)]
    texts = [e for e in drawn(shown).iter() if e.text == "constant speed"]
    assert len({(text.get("x"), text.get("y")) for text in texts}) == len(texts) == 3
    assert len({text.get("y") for text in texts}) == 2
