"""Figures as SVG: round ticks, curves that keep their shape, well-formed text."""

import xml.etree.ElementTree as ET

import numpy as np
import pytest

from strainwave.app.figures.svg import ROW, Note, Panel, _path, beside, figure, log_ticks, ticks


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
    shown = Panel("a < b & c", "speed (rpm)", "|x|\n(arcsec)", notes=[Note(1.0, 2.0, "1.5")])
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
    shown = Panel("", "x", "y", log=True)
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
