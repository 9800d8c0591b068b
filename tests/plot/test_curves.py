"""Figures of curves and motions show the numbers of the results, stable and unstable parts apart."""

import builtins
import subprocess
import sys

import matplotlib
import numpy as np
import pytest
from all_results import RESULTS, WITHOUT_FIGURE, branch, run
from matplotlib.figure import Figure

import strainwave as sw

matplotlib.use("Agg")
SLOW = {"Design": [pytest.mark.slow]}
NAMES = [pytest.param(name, marks=SLOW.get(name, ())) for name in RESULTS if name not in WITHOUT_FIGURE]


@pytest.fixture
def axes():
    return Figure().add_subplot()


@pytest.mark.parametrize("name", NAMES)
def test_every_result_draws_itself_on_axes(axes, name):
    assert RESULTS[name]().plot(axes) is axes
    assert axes.get_xlabel()
    assert axes.get_ylabel()
    assert axes.lines or "without" in name
    axes.figure.canvas.draw()


def test_a_branch_is_dashed_where_it_is_unstable(axes):
    found = branch()
    found.plot(axes)
    curves = [line for line in axes.lines if line.get_marker() == "None"]
    assert [line.get_linestyle() for line in curves] == ["-", "--", "-"]
    x = np.concatenate([line.get_xdata()[:-1] for line in curves])
    np.testing.assert_array_equal(x, found.omega[:-1])
    np.testing.assert_allclose(curves[0].get_ydata(), found.peak[: len(curves[0].get_ydata())])
    rings = [line for line in axes.lines if line.get_marker() == "o"]
    assert [list(line.get_xdata()) for line in rings] == [[fold.omega for fold in found.folds]]
    assert axes.get_ylabel() == "peak |x| (rad)"
    assert axes.get_legend_handles_labels()[1] == ["peak |x|", "peak |x|, unstable", "fold"]


def test_a_run_is_drawn_in_the_unit_of_its_size(axes):
    run().plot(axes)
    np.testing.assert_allclose(axes.lines[0].get_ydata() * np.deg2rad(1.0 / 3600.0), run().error, rtol=1e-12)
    assert axes.get_ylabel() == "error between motor and load (arcsec)"


def test_a_figure_is_made_where_no_axes_are_given():
    from matplotlib import pyplot

    axes = branch().plot()
    assert axes.lines
    pyplot.close(axes.figure)


def test_a_thing_without_a_figure_is_told_in_one_sentence(axes):
    with pytest.raises(TypeError, match=r"there is no figure of 3; there is one of each of .*Branch, Jumps, Orbit"):
        sw.draw(3, axes)
    with pytest.raises(TypeError, match="there is no figure of"):
        RESULTS["StateSpace"]().plot(axes)


def test_a_missing_matplotlib_is_told_with_the_remedy(monkeypatch):
    whole = builtins.__import__

    def without(name, *rest, **more):
        if name.startswith("matplotlib"):
            raise ModuleNotFoundError(name)
        return whole(name, *rest, **more)

    branch()
    monkeypatch.setattr(builtins, "__import__", without)
    with pytest.raises(ModuleNotFoundError, match=r"figures need the extra `plot`: pip install 'strainwave\[plot\]'"):
        sw.draw(branch())


def test_a_drive_has_its_torque_below_the_oscillation_over_the_same_speeds(axes):
    found = RESULTS["DriveResponse"]()
    found.plot(axes)
    above, below = axes.figure.axes
    assert above is axes
    assert below.get_position().y1 < above.get_position().y0
    assert below.get_xlim() == above.get_xlim()
    drawn = np.concatenate([line.get_ydata()[:-1] for line in below.lines])
    np.testing.assert_array_equal(drawn, found.torque[:-1])
    assert below.get_ylabel().replace("\n", " ") == "largest torque in the gear (N·m)"
    assert below.get_xlabel() == "speed of the base angle (rpm)"
    stable = [line.get_linestyle() == "-" for line in below.lines]
    assert stable == [bool(part[0]) for part in np.split(found.stable, np.flatnonzero(np.diff(found.stable)) + 1)]


def test_a_report_draws_the_bode_plot_of_a_drive_without_what_other_figures_load():
    code = (
        "import sys, strainwave as sw, strainwave.app.report.report\n"
        "assert len(sw.bode(sw.HDC_40_050.train(), [1.0, 2.0]).panels()) == 2\n"
        "print(sorted({'scipy', 'xarray', 'strainwave.plot.every_figure'} & set(sys.modules)))"
    )
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert run.stdout.strip() == "[]"
