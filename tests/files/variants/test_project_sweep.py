"""Sweeps over the numbers of a project file: every point is the response of the file with that value."""

import numpy as np
import pytest
import xarray as xr
from linear_drive import LINEAR, closed_form
from twelve_projects import PROJECTS

import strainwave as sw
from strainwave.files.reading import from_text


@pytest.fixture
def project(tmp_path):
    return from_text(LINEAR, tmp_path / "drive.yaml")


def test_every_point_has_the_largest_error_of_the_closed_form(project):
    data = sw.sweep(
        sw.sample.largest,
        project,
        {"load.inertia": ["1 kg*m^2", "1.5 kg*m^2"], "damping.B": ["40 N*m*s/rad", "80 N*m*s/rad"]},
    )
    assert data.attrs["failed_points"] == 0
    assert dict(data.sizes) == {"load.inertia": 2, "damping.B": 2}
    np.testing.assert_array_equal(data["load.inertia"], [1.0, 1.5])
    assert data["load.inertia"].attrs["units"] == "kg*m^2"
    omega = np.linspace(100.0, 200.0, 20_001)
    for J in (1.0, 1.5):
        for B in (40.0, 80.0):
            here, exact = data.sel({"load.inertia": J, "damping.B": B}), closed_form(J, B, omega)
            top = np.argmax(exact)
            # the curve is sampled at about a hundred speeds: its top is met from below
            assert exact[top] * 0.99 < float(here["peak"]) <= exact[top] * (1 + 1e-7)
            assert float(here["peak"]) == pytest.approx(closed_form(J, B, float(here["peak_at"])), rel=1e-9)
            assert float(here["oscillation"]) == pytest.approx(float(here["peak"]), rel=1e-9)
            inertia = J * 4.0 * float(here["torque_at"]) ** 2  # the gear carries J x''
            assert float(here["torque"]) == pytest.approx(
                inertia * closed_form(J, B, float(here["torque_at"])), rel=1e-3
            )
            assert (float(here["jumps"]), float(here["truncated"])) == (0.0, 0.0)


def test_a_store_says_what_its_axes_are(project, tmp_path):
    grid = {"damping.B": ["40 N*m*s/rad", "80 N*m*s/rad"], "motor.mode": ["held"]}
    data = sw.sweep(sw.sample.largest, project, grid, store=tmp_path / "s.zarr")
    with xr.open_zarr(tmp_path / "s.zarr", consolidated=False) as stored:
        assert stored["damping.B"].dims == ("numbers.0",)
        assert stored["damping.B"].attrs["units"] == "N*m*s/rad"
        np.testing.assert_array_equal(stored["damping.B"], [40.0, 80.0])
        assert stored["numbers.0"].attrs["values"] == grid["damping.B"]
        assert stored["numbers.1"].attrs["name"] == "motor.mode"
        assert stored["numbers.1"].attrs["values"] == ["held"]
        np.testing.assert_array_equal(stored["peak"], data["peak"])
    xr.testing.assert_identical(
        data.load(), sw.sweep(sw.sample.largest, project, grid, store=tmp_path / "s.zarr").load()
    )
    said = r"s\.zarr holds another sweep \(largest over damping\.B, motor\.mode; "
    with pytest.raises(ValueError, match=said):
        sw.sweep(sw.sample.largest, project, grid | {"damping.B": ["41 N*m*s/rad"]}, store=tmp_path / "s.zarr")


def light(project):
    """The load's inertia [kg*m^2], of light loads alone."""
    if project.drive.J_l > 1.2:
        raise ValueError("too heavy")
    return project.drive.J_l


def test_what_is_wrong_at_a_point_names_its_numbers_as_they_were_written(project):
    grid = {"load.inertia": ["1000 g*m^2", "1500 g*m^2"], "damping.B": ["40 N*m*s/rad"]}
    (said,) = sw.sweep(light, project, grid).attrs["errors"].splitlines()
    assert said.startswith("point 1 (load.inertia = 1500 g*m^2, damping.B = 40 N*m*s/rad): ")
    assert said.endswith("too heavy")


@pytest.mark.slow
def test_names_are_an_axis_and_a_store_goes_on(tmp_path):
    catalogue = from_text(PROJECTS["catalogue gear, motor not named"], tmp_path / "drive.yaml")
    grid = {"gear": ["CSG-40-50", "SHG-40-50"]}
    found = sw.sweep(sw.sample.largest, catalogue, grid, store=tmp_path / "s")
    assert list(found["gear"].values) == ["CSG-40-50", "SHG-40-50"]
    for name in grid["gear"]:
        response = sw.replaced(catalogue, {"gear": name}).response()
        at = response.visited()
        assert float(found["peak"].sel(gear=name)) == float(np.max(response.peak[at]))
        sweep = response.sweep
        assert float(found["jumps"].sel(gear=name)) == len(sweep.on_run_up) + len(sweep.on_run_down)
    before = {path: path.stat().st_mtime_ns for path in (tmp_path / "s").glob("peak/**/*")}
    again = sw.sweep(sw.sample.largest, catalogue, grid, store=tmp_path / "s")
    xr.testing.assert_identical(found.load(), again.load())
    assert {path: path.stat().st_mtime_ns for path in (tmp_path / "s").glob("peak/**/*")} == before


@pytest.mark.parametrize(
    ("grid", "said"),
    [
        ({}, "the grid is {}; give names of the file with their values"),
        ({"load.inertia": []}, "give names of the file with their values"),
        ({"load.inertia": ["1 kg*m^2", "2"]}, r"load\.inertia = 2: load\.inertia: '2' has no unit"),
        ({"load.inertia": ["1 kg*m^2"] * 100_001}, "more than 100000 points"),
        ({"omega": ["3 rad/s"]}, "omega = 3 rad/s: the project file has no 'omega'"),
    ],
)
def test_a_grid_that_the_file_does_not_take_is_refused_before_anything_is_computed(project, grid, said):
    with pytest.raises(ValueError, match=said):
        sw.sweep(sw.sample.largest, project, grid)


def test_any_function_of_a_project_is_a_measure(project):
    data = sw.sweep(
        lambda drive: drive.drive.omega_0, project, {"load.inertia": ["1 kg*m^2", "4 kg*m^2"]}, units={"value": "rad/s"}
    )
    one, four = (sw.replaced(project, {"load.inertia": f"{J} kg*m^2"}).drive.omega_0 for J in (1, 4))
    np.testing.assert_array_equal(data["value"], [one, four])
    assert data["value"].attrs["units"] == "rad/s"
