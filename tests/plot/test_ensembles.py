"""Pictures of ensembles show what is in the results."""

import numpy as np
import pytest
from matplotlib.figure import Figure

import strainwave as sw
from strainwave.numerics.attractors.basins import CHAOTIC, DIVERGED
from strainwave.plot import curves, panels_of

QUIET = sw.results.Attractor(1, -1.0, 1.0, np.array([[0.2, -0.3]]), 0.5, True)
THIRD = sw.results.Attractor(3, -2.0, 2.0, np.array([[1.0, 0.0], [-0.5, 0.9], [-0.5, -0.9]]), 0.7, True)


@pytest.fixture
def axes():
    return Figure().add_subplot()


@pytest.mark.parametrize("shape", [(2, 3), None])
def test_basins_show_attractors_and_what_is_left(axes, shape):
    x, v = np.meshgrid([-1.0, 0.0, 1.0], [-1.0, 1.0])
    label = np.array([0, 0, 0, 1, DIVERGED, CHAOTIC])
    found = sw.results.Basins(x.ravel(), v.ravel(), label, (QUIET, THIRD), shape, ((-1.5, 1.5), (-2.0, 2.0)))
    sw.draw(found, axes)
    words = [text.get_text() for text in axes.get_legend().get_texts()]
    assert [word.partition(":")[0].split(",")[0] for word in words] == ["period 1", "period 3", "diverged", "chaotic"]
    assert "0.500 ± 0.204" in words[0]
    assert [len(line.get_xdata()) for line in axes.lines if line.get_label() == words[1]] == [3]
    if shape:
        picture = np.asarray(axes.collections[0].get_array())
        assert picture.shape == (2, 3)
        assert picture[0, 0] == picture[0, 2] != picture[1, 0]


def test_neighbouring_basins_differ_without_colour():
    rgb = [[int(colour[i : i + 2], 16) / 255.0 for i in (1, 3, 5)] for colour in curves.BASIN]
    grey = np.array(rgb) @ (0.299, 0.587, 0.114)
    assert np.all(np.abs(np.diff(grey)) > 0.1)
    assert abs(grey[0] - grey[1]) > 0.3


@pytest.mark.parametrize(("largest", "unit"), [(0.0, "arcsec"), (0.5, "rad"), (0.05, "mrad"), (5e-4, "arcsec")])
def test_small_angles_are_in_small_units(largest, unit):
    name, size = curves.angle_unit([np.nan, 0.0, -largest])
    assert name == unit
    assert size == pytest.approx({"rad": 1.0, "mrad": 1e-3, "arcsec": np.deg2rad(1.0 / 3600.0)}[unit])


def test_a_line_parts_basins_that_are_no_dust(axes):
    x, v = np.meshgrid(np.linspace(-1e-4, 1e-4, 20), np.linspace(-1.0, 1.0, 20))
    spans = ((-1e-4, 1e-4), (-1.0, 1.0))
    halves, dust = (x > 0.0).astype(int).ravel(), np.random.default_rng(0).integers(0, 2, 400)
    for label, count in ((dust, 0), (halves, 20)):
        (panel,) = panels_of(sw.results.Basins(x.ravel(), v.ravel(), label, (QUIET, THIRD), (20, 20), spans))
        border = next(curve for curve in panel.curves if not curve.marker)
        assert np.sum(np.isfinite(border.x)) == 2 * count  # an end below and above each cell
        np.testing.assert_allclose(border.x[np.isfinite(border.x)], 0.0, atol=1e-18)
    sw.draw(sw.results.Basins(x.ravel(), v.ravel(), halves, (QUIET, THIRD), (20, 20), spans), axes)
    assert axes.get_xlabel() == "initial x (arcsec)"
    assert axes.get_ylabel() == "initial x' (rad/s)"
