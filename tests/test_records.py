"""Results as labelled arrays, tables and files: everything comes back, equal to the bit."""

import json
import os
import re
from dataclasses import dataclass, fields, is_dataclass, replace
from typing import NamedTuple
from unittest.mock import Mock

import numpy as np
import pytest
import xarray as xr
from all_results import DUFFING, RESULTS, branch, run

import strainwave as sw
from strainwave.base import archive
from strainwave.base.records import Result

pytestmark = pytest.mark.slow


class Doubled(NamedTuple):
    """A user's law."""

    K: float

    def torque(self, x):
        return 2.0 * self.K * x

    def stiffness(self, x):
        return 2.0 * self.K + 0.0 * x

    def energy(self, x):
        return self.K * x * x


def differences(a, b, at="result"):
    """Places where two results differ, in a single bit too."""
    if isinstance(a, np.ndarray):
        same = a.dtype == b.dtype and a.shape == b.shape and a.tobytes() == b.tobytes()
        return [] if same else [at]
    if type(a) is not type(b) and not isinstance(a, str | np.generic):
        return [f"{at}: {type(a)} {type(b)}"]
    if is_dataclass(a):
        return [d for f in fields(a) for d in differences(getattr(a, f.name), getattr(b, f.name), f"{at}.{f.name}")]
    if isinstance(a, dict):
        pairs = [differences(list(a), list(b), at), *(differences(a[k], b[k], f"{at}[{k!r}]") for k in a if k in b)]
        return [d for found in pairs for d in found]
    if isinstance(a, tuple | list):
        if len(a) != len(b):
            return [f"{at}: {len(a)} {len(b)} items"]
        return [d for i, (one, two) in enumerate(zip(a, b, strict=True)) for d in differences(one, two, f"{at}[{i}]")]
    return [] if np.array_equal(a, b, equal_nan=isinstance(a, float)) else [f"{at}: {a} {b}"]


def test_differences_are_found():
    orbit = RESULTS["Orbit"]()
    changed = type(orbit)(
        **{f.name: getattr(orbit, f.name) for f in fields(orbit)} | {"multipliers": 1.0 * orbit.multipliers}
    )
    assert differences(orbit, changed) == []
    changed.multipliers[0] += 1e-16j
    assert differences(orbit, changed) == ["result.multipliers"]
    assert differences(run().train, run().train._replace(N=3.0)) != []


@pytest.mark.parametrize("name", RESULTS)
def test_every_result_comes_back_equal_to_the_bit(name, tmp_path):
    result = RESULTS[name]()
    path = result.save(tmp_path / "found.nc")
    assert os.listdir(tmp_path) == ["found.nc"]
    back = sw.load(path)
    assert type(back) is type(result)
    assert differences(result, back) == []
    assert str(back) == str(result)


def test_a_result_takes_the_place_of_the_old_one(tmp_path):
    path = RESULTS["Orbit"]().save(tmp_path / "found.nc")
    assert branch().save(path) == path
    assert os.listdir(tmp_path) == [path.name]
    assert differences(branch(), sw.load(path)) == []


@pytest.mark.parametrize("value", [np.nan, -np.inf, -0.0, 5e-324, 1.7976931348623157e308, 0.1 + 0.2])
def test_extreme_numbers_come_back(value, tmp_path):
    rest = np.array([[value, 1.0], [0.0, value]])
    saved = sw.Trajectory(np.arange(2.0), rest, rest, sw.Status.DIVERGED, "ä: 'π'", 1, 2, 3)
    back = sw.load(saved.save(tmp_path / "run.nc"))
    assert back.y.tobytes() == rest.tobytes()
    assert (back.status, back.message, back.switches) == (sw.Status.DIVERGED, "ä: 'π'", 3)
    multipliers = np.array([complex(value, 1.0), complex(0.0, value)])
    orbit = sw.Orbit(1.0, 1, rest[:1], value, multipliers, False, value, sw.Status.OK, "")
    again = sw.load(orbit.save(tmp_path / "orbit.nc"))
    assert again.multipliers.tobytes() == multipliers.tobytes()
    assert np.array([again.value, again.peak]).tobytes() == np.array([np.nan, value]).tobytes()


def test_a_saved_branch_is_a_dataset_for_xarray_too(tmp_path):
    path = branch().save(tmp_path / "curve.nc")
    with xr.open_dataset(path, engine="scipy") as data:
        np.testing.assert_array_equal(data["omega"].values, branch().omega)
        assert data["omega"].attrs["units"] == "rad/s"
        assert data["amplitude"].dims == ("point", "harmonic")
        np.testing.assert_array_equal(data["amplitude"].sel(harmonic=3).values, branch().amplitude(3))
        assert data.attrs["result"] == "Branch"
        assert data.attrs["version"] == sw.__version__


def test_a_dataset_has_dimensions_units_and_single_numbers():
    data = branch().to_xarray()
    assert dict(data.sizes) == {"point": len(branch()), "harmonic": 5, "coefficient": 11, "multiplier": 2}
    assert list(data["coefficient"].values[:3]) == ["mean", "cos 1", "sin 1"]
    assert {name: data[name].attrs["units"] for name in ("omega", "peak", "oscillation")} == {
        "omega": "rad/s", "peak": "rad", "oscillation": "rad",
    }  # fmt: skip
    assert data.attrs["tail"] == branch().tail
    run_data = run().to_xarray()
    assert list(run_data["state"].values) == list(run().train.state_names())
    np.testing.assert_array_equal(run_data["work"].sel(power="gear law").values, run().work["gear law"])
    assert run_data["torque"].attrs["units"] == "N*m"
    np.testing.assert_array_equal(run_data["pointing"], run().pointing)
    assert run_data["pointing"].attrs["units"] == "rad"


@pytest.mark.parametrize("name", ["DriveResponse", "Branch", "OrderScan"])
def test_a_table_is_saved_as_csv_with_its_units(name, tmp_path):
    result = RESULTS[name]()
    table, data = result.to_dataframe(), result.to_xarray()
    lines = result.save(tmp_path / "r.csv").read_text("utf-8").splitlines()
    header = lines[0].split(",")
    values = np.genfromtxt(lines[1:], delimiter=",", ndmin=2)
    assert values.shape == (len(table), len(table.columns) + 1)
    for i, column in enumerate(table.columns, 1):
        unit = data[column].attrs.get("units", "") if column in data else data[column.split()[0]].attrs["units"]
        assert header[i] == (f"{column} [{unit}]" if unit else column)
        if table[column].dtype.kind in "fib":
            assert np.array_equal(values[:, i], table[column], equal_nan=True)


def test_a_table_has_a_row_for_every_point():
    table = branch().to_dataframe()
    assert len(table) == len(branch())
    np.testing.assert_array_equal(table["amplitude 3"], branch().amplitude(3))
    assert list(table.columns[:3]) == ["omega", "peak", "oscillation"]
    in_time = run().to_dataframe()
    np.testing.assert_array_equal(in_time.index, run().trajectory.t)
    np.testing.assert_array_equal(in_time["work control"], run().work["control"])
    jumps = RESULTS["Jumps"]().to_dataframe()
    assert list(jumps["up"]) == [True, False]
    np.testing.assert_allclose(jumps["omega"], [1.26960196, 1.11570025], rtol=1e-6)
    orbit = RESULTS["Orbit"]().to_dataframe()
    np.testing.assert_allclose(orbit["frequency"], np.arange(6) * branch().folds[0].omega, rtol=1e-15)


def test_the_parameter_of_a_branch_is_a_coordinate():
    other = sw.numerics.parameter_response(DUFFING, "excitation.amplitude", (0.1, 0.15))
    data = other.to_xarray()
    np.testing.assert_array_equal(data["excitation.amplitude"].values, other.values)
    assert np.all(data["omega"] == 1.2)


def test_oscillation_is_the_peak_without_the_mean():
    shifted = DUFFING._replace(excitation=sw.Harmonic(0.18, mean=0.4))
    orbit = sw.find_orbit(shifted, harmonics=9)
    x = orbit.state(np.linspace(0.0, 2.0 * np.pi, 200_001))[0]
    assert orbit.oscillation == pytest.approx(np.max(np.abs(x - np.mean(x[:-1]))), rel=1e-8)
    assert orbit.oscillation < 0.95 * orbit.peak
    np.testing.assert_allclose(branch().oscillation, branch().peak, rtol=1e-9)  # an odd system has no mean


def test_a_truncated_file_is_refused_in_one_sentence(tmp_path):
    path = branch().save(tmp_path / "curve.nc")
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    with pytest.raises(ValueError, match=r"save the result again$") as error:
        sw.load(path)
    assert "\n" not in str(error.value)


def test_a_file_with_one_changed_number_is_refused(tmp_path):
    path = branch().save(tmp_path / "curve.nc")
    data = xr.load_dataset(path, engine="scipy")
    data["peak"][3] *= 1.0 + 1e-15
    data.to_netcdf(path, engine="scipy")
    with pytest.raises(ValueError, match="is damaged: its content is not what was saved"):
        sw.load(path)


def test_files_of_others_are_told_apart(tmp_path):
    xr.Dataset({"a": ("b", [1.0])}).to_netcdf(tmp_path / "other.nc", engine="scipy")
    with pytest.raises(ValueError, match="holds no result of strainwave; `save` of a result writes one"):
        sw.load(tmp_path / "other.nc")
    (tmp_path / "text.nc").write_text("t,x\n0,1\n")
    with pytest.raises(ValueError, match="save the result again"):
        sw.load(tmp_path / "text.nc")
    with pytest.raises(FileNotFoundError, match=r"there is no .*none\.nc"):
        sw.load(tmp_path / "none.nc")
    for name in ("a.csv", "a.npz", "a.mat", "a.zarr"):
        with pytest.raises(ValueError, match=rf"cannot load '{name}'; results are saved with names that end in \.nc$"):
            sw.load(name)


def edited(path, change):
    """Change what a saved file says of itself, its checksum included."""
    data, (arrays, text) = xr.load_dataset(path, engine="scipy"), archive._read(path)
    about = json.loads(text)
    change(about)
    held = {name: archive._restored(arrays, *how) for name, how in about["arrays"].items()}
    about["sha256"] = archive._digest(json.dumps(about["content"]), held)
    data.assign_attrs(strainwave=json.dumps(about)).to_netcdf(path, engine="scipy")
    return path


@pytest.mark.parametrize("written", ["0.1.9", "9.1"])
def test_a_file_of_another_version_says_which(written, tmp_path):
    path = edited(RESULTS["Orbit"]().save(tmp_path / "o.nc"), lambda about: about.update(version=written))
    with pytest.raises(ValueError, match=rf"o\.nc was made by strainwave {re.escape(written)}; compute it again$"):
        sw.load(path)


def test_a_file_of_other_fields_is_refused(tmp_path):
    path = edited(RESULTS["Orbit"]().save(tmp_path / "o.nc"), lambda about: about["content"]["of"].update(zone=1))
    with pytest.raises(ValueError, match=r"holds a Orbit of other fields than it has here; compute it again$"):
        sw.load(path)


@pytest.mark.parametrize(
    "name", ["os:system", "strainwave.base.archive:load", "strainwave.nowhere:Orbit", "strainwave"]
)
def test_a_file_names_results_and_models_of_this_package_alone(name, tmp_path):
    path = RESULTS["Orbit"]().save(tmp_path / "o.nc")
    with pytest.raises(ValueError, match=rf"holds a {name}, which strainwave .* does not have; compute it again$"):
        sw.load(edited(path, lambda about: about["content"].update({"class": name})))


def test_what_no_file_gives_back_is_refused_before_anything_is_written(tmp_path):
    train = sw.HDC_40_050._replace(law=Doubled(7160.0)).train(control=sw.train.Held())
    mine = sw.drive_run(train, (1e-4, 0.0), (0.0, 1e-3), method=sw.Dopri5(rtol=1e-3))
    with pytest.raises(ValueError, match=r"train\.law is a Doubled of your own .*; pickle the result, or save its"):
        mine.save(tmp_path / "run.nc")
    with pytest.raises(
        ValueError,
        match=r"cannot save a Branch as 'b\.xls'; use a name that ends in \.nc or \.csv$",
    ):
        branch().save(tmp_path / "b.xls")
    with pytest.raises(ValueError, match=r"a Silent has no table that CSV can hold; use a name that ends in \.nc$"):
        Silent().save(tmp_path / "b.csv")
    (tmp_path / "folder.nc").mkdir()
    with pytest.raises(ValueError, match=r"folder\.nc', a folder; give the name of a file$"):
        branch().save(tmp_path / "folder.nc")
    assert os.listdir(tmp_path) == ["folder.nc"]


NAMES = (
    *("file", "version", "result", "time", "strainwave", "sample", "x_real", "load %"),
    *("a/b", "a%2Fb", "", ".", "..", "a\0b", "a\nb", "x\\y", "Δφ", "µ"),
)


def test_a_channel_of_any_name_comes_back(tmp_path):
    values = np.random.default_rng(2).normal(size=(len(NAMES), 5))
    log = sw.Log(0.01 * np.arange(5), dict(zip(NAMES, values, strict=True)))
    assert differences(sw.load(log.save(tmp_path / "log.nc")), log) == []


@pytest.mark.parametrize("seed", [2**31, 2**63, 10**30])
def test_a_large_whole_number_comes_back(seed, tmp_path):
    result = replace(RESULTS["Exceedance"](), seed=seed)
    assert differences(sw.load(result.save(tmp_path / "result.nc")), result) == []


def test_whole_numbers_are_kept_or_refused_on_saving(tmp_path):
    path, none = tmp_path / "result.nc", np.zeros((2, 2))
    large = sw.Trajectory(np.array([2**40, 2**53]), none, none, sw.Status.OK, "", 1, 2, 3)
    assert differences(sw.load(large.save(path)), large) == []
    with pytest.raises(ValueError, match=r"beyond 2\^53"):
        replace(large, t=np.array([2**53, 2**53 + 1])).save(path)
    with pytest.raises(ValueError, match="does not give back"):
        replace(large, t=np.array(["1", "2"])).save(path)
    assert differences(sw.load(path), large) == []


def test_a_failed_save_leaves_the_old_file(tmp_path, monkeypatch):
    path = branch().save(tmp_path / "curve.nc")
    monkeypatch.setattr(archive, "_read", Mock(side_effect=OSError("disk full")))
    with pytest.raises(OSError, match="disk full"):
        branch().save(path)
    monkeypatch.undo()
    assert os.listdir(tmp_path) == ["curve.nc"]
    assert differences(sw.load(path), branch()) == []


@pytest.mark.parametrize("name", RESULTS)
def test_every_result_prints_on_a_screen(name):
    lines = str(RESULTS[name]()).splitlines()
    assert len(lines) <= 25
    assert max(map(len, lines)) <= 120
    assert repr(RESULTS[name]()) == str(RESULTS[name]())


def test_a_long_text_is_wrapped_and_its_end_counted():
    found = branch()
    many = replace(found, folds=found.folds * 200, message="word " * 400)
    lines = str(many).splitlines()
    assert len(lines) == 25
    assert max(map(len, lines)) <= 120
    assert lines[-1].startswith("  ... and ")
    assert lines[0].startswith("Branch in omega")


@pytest.mark.parametrize("ending", [".nc", ".csv"])
def test_a_missing_folder_is_said_by_save(tmp_path, ending):
    with pytest.raises(FileNotFoundError, match=r"^there is no folder .*none; make it, or save elsewhere$"):
        RESULTS["Trajectory"]().save(tmp_path / "none" / f"run{ending}")
    assert os.listdir(tmp_path) == []


@dataclass(frozen=True)
class Silent(Result):
    """A result of one's own that has nothing to say yet."""

    def facts(self):
        return ()
