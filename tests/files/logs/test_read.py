"""What reading does to raw channels, and what it doubts; measured files and binary ones."""

import sys
from io import BytesIO
from pathlib import Path
from types import SimpleNamespace
from unittest.mock import Mock

import numpy as np
import pytest
import scipy.io

import strainwave as sw
from strainwave.files.logs import mat_file
from strainwave.files.yaml_text import FileError

KINOVA = Path(__file__).parents[2] / "measured/kinova_gen3"
RNG = np.random.default_rng(16)


def save(path, **columns):
    """A CSV of these columns."""
    table = np.column_stack(list(columns.values()))
    np.savetxt(path, table, delimiter=",", header=",".join(columns), comments="", fmt="%.12g")
    return path


@pytest.mark.parametrize(
    ("joint", "samples", "speed"), [(3, 6535, 0.417), (5, 5854, 0.366), (6, 5832, 0.366), (7, 5825, 0.366)]
)
def test_a_measured_joint_is_read_with_its_units_and_segments(joint, samples, speed):
    log = sw.read_log(KINOVA / f"joint_{joint}.csv", columns={"torque": "torque_from_current_Nm"})
    table = np.loadtxt(KINOVA / f"joint_{joint}.csv", delimiter=",", skiprows=1)
    assert len(log) == samples
    assert log.rate == pytest.approx(1000.0)
    assert log.gaps == log.doubts == ()
    assert log.units == {"torque": "N*m", "load_angle": "rad", "load_speed": "rad/s", "current": "A"}
    assert np.array_equal(log.channels["load_angle"], table[:, 1])
    assert np.array_equal(log.channels["torque"], table[:, 3])
    parts = log.segments()
    (main,) = (part for part in parts if part.kind == "constant speed")
    assert parts[0].kind == "run-up"
    assert parts[-1].kind == "run-down"
    assert main.speed == pytest.approx(speed, abs=2e-3)
    # the angle alone says the same of the speed
    turned = log.channels["load_angle"][main.rows]
    assert (turned[-1] - turned[0]) / (main.stop - main.start) == pytest.approx(main.speed, rel=5e-3)
    run = log.run("torque", part=main)
    assert run.unit == "N*m"
    assert len(run.time) == len(run.angle) == len(run.value) == main.rows.stop - main.rows.start


SEVEN = ["commanded_torque", "load_angle", "load_speed", "torque", "commanded_current", "current", "observer"]


def seven(path, *, speed=0.9, rate=999.0, duration=20.0):
    """Seven columns separated by blanks, without names and time; a start-up, a wrapped angle and rows with inf."""
    t = np.arange(int(duration * rate)) / rate
    v = speed + 0.8 * np.exp(-t / 0.1) * np.cos(40.0 * t) + 1e-3 * RNG.standard_normal(len(t))
    angle = np.cumsum(v) / rate
    torque = 3.0 + 0.04 * np.cos(200.0 * angle)
    table = np.column_stack([torque, np.angle(np.exp(1j * angle)), v, torque, torque / 6.0, torque / 6.1, 0.1 * torque])
    table[[500, 501, 9000], [3, 3, 6]] = [np.inf, np.inf, -np.inf]
    np.savetxt(path, table, fmt="%.9f")
    return t, angle, table


def test_a_file_without_names_and_time_is_read_with_the_columns_that_are_given(tmp_path):
    t, angle, _ = seven(tmp_path / "run.txt")
    with pytest.raises(ValueError, match="has 7 columns without names; give columns="):
        sw.read_log(tmp_path / "run.txt")
    with pytest.raises(ValueError, match=r"ratio is 'x'; it must be a positive finite number"):
        sw.read_log(tmp_path / "run.txt", columns={"load_angle": 1}, rate=1e3, ratio="x")
    with pytest.raises(ValueError, match="has no column of the time"):
        sw.read_log(tmp_path / "run.txt", SEVEN)
    log = sw.read_log(tmp_path / "run.txt", SEVEN, {"commanded_current": "A"}, rate=999.0)
    assert "3 of 19980 rows contain inf or NaN and were omitted" in log.notes
    assert "load_angle wraps at a whole turn and was unwrapped, 3 times" in log.notes
    assert any("are a transient and were removed; trim=0 keeps them" in note for note in log.notes)
    assert 0.1 < log.time[0] < 1.0
    assert log.time[-1] == t[-1]
    place = np.searchsorted(t, log.time)
    assert np.ptp(log.channels["load_angle"] - angle[place]) < 1e-8
    assert [part.kind for part in log.segments()] == ["constant speed"] * (1 + len(log.gaps))
    whole = sw.read_log(tmp_path / "run.txt", SEVEN, rate=999.0, trim=0.0)
    assert len(whole) == 19980 - 3
    assert sw.read_log(tmp_path / "run.txt", SEVEN, rate=999.0, trim=(0.4, 1.0)).time[0] == pytest.approx(0.4, abs=1e-3)


def test_an_angle_in_degrees_that_wraps_is_unwrapped(tmp_path):
    t = np.arange(400) / 100.0
    path = save(tmp_path / "log.csv", **{"time": t, "motor_angle [deg]": np.mod(300.0 * t, 360.0)})
    log = sw.read_log(path)
    assert log.channels["motor_angle"] == pytest.approx(np.radians(300.0 * t), abs=1e-9)
    wrapped = sw.read_log(path, unwrap=False)
    assert np.max(wrapped.channels["motor_angle"]) < 2 * np.pi
    # read as radians it cannot be unwrapped, and the jumps say why
    (doubt,) = sw.read_log(path, units={"motor_angle": "rad"}).doubts
    assert "jumps by 357 rad: it is probably in deg" in doubt


def test_repeated_times_are_averaged(tmp_path):
    path = save(
        tmp_path / "log.csv", time=[0.0, 1.0, 1.0, 2.0, 2.0, 2.0, 3.0], torque=[1.0, 2.0, 4.0, 1.0, 2.0, 6.0, 5.0]
    )
    log = sw.read_log(path)
    assert np.array_equal(log.time, [0.0, 1.0, 2.0, 3.0])
    assert np.array_equal(log.channels["torque"], [1.0, 3.0, 3.0, 5.0])
    assert "3 samples at the time of the one before: averaged with it" in log.notes


def test_one_sample_is_not_samples(tmp_path):
    with pytest.raises(FileError, match="has 1 sample; a log has two"):
        sw.read_log(save(tmp_path / "log.csv", time=[0.0], torque=[1.0]))


def test_gaps_and_jitter_are_found(tmp_path):
    t = np.delete(np.arange(1000) / 500.0, np.s_[300:350])
    log = sw.read_log(save(tmp_path / "log.csv", time=t, torque=np.sin(t)))
    (gap,) = log.gaps
    assert gap == pytest.approx((299 / 500, 350 / 500))
    assert log.rate == pytest.approx(500.0)
    assert log.jitter < 1e-9
    assert any(note.startswith("1 gap, the longest of 0.102 s") for note in log.notes)
    shaken = t + 2e-4 * RNG.uniform(-0.5, 0.5, len(t))
    log = sw.read_log(save(tmp_path / "log.csv", time=shaken, torque=np.sin(t)))
    assert log.jitter == pytest.approx(2e-4 / np.sqrt(6.0), rel=0.1)
    assert any(note.startswith("steps of the time vary by 4") for note in log.notes)
    assert not any("rounded" in note for note in log.notes)
    rounded = np.round(np.arange(1000) * 2.175e-3, 3)  # every step is 2 or 3 ms
    log = sw.read_log(save(tmp_path / "log.csv", time=rounded, torque=np.sin(rounded)))
    assert any(note.startswith("stamps are rounded to 1 ms, 4") for note in log.notes)


def test_a_log_at_rest_has_no_ratio(tmp_path):
    t = np.arange(1000) / 500.0
    angles = {"motor_angle": 1e-5 * RNG.standard_normal(1000), "load_angle": 1e-5 * RNG.standard_normal(1000)}
    assert sw.read_log(save(tmp_path / "log.csv", time=t, **angles)).ratio is None
    turning = {"motor_angle": 50.0 * t + angles["motor_angle"], "load_angle": t + angles["load_angle"]}
    assert sw.read_log(save(tmp_path / "log.csv", time=t, **turning)).ratio == pytest.approx(50.0, rel=1e-5)


def test_a_channel_with_empty_cells_is_interpolated(tmp_path):
    path = tmp_path / "log.csv"
    rows = [f"{i / 8},{i * i / 8},{3 * i if i % 4 == 0 else ''}" for i in range(33)]
    path.write_text("\n".join(["time,torque,current", *rows]))
    log = sw.read_log(path)
    assert len(log) == 33
    assert log.channels["current"] == pytest.approx(3.0 * np.arange(33))
    assert any(note.startswith("current had times of their own") for note in log.notes)


def test_time_that_runs_backwards_or_stands_still_is_refused(tmp_path):
    path = save(tmp_path / "log.csv", time=[0.0, 1.0, 2.0, 1.5], torque=[1.0, 2.0, 4.0, 1.0])
    with pytest.raises(ValueError, match=r"log.csv:1:1: time: runs backwards, from 2 to 1.5 s after sample 3; sort"):
        sw.read_log(path)
    path = save(tmp_path / "log.csv", time=[1.0, 1.0, 1.0], torque=[1.0, 2.0, 4.0])
    with pytest.raises(ValueError, match="stands still at 1 s"):
        sw.read_log(path)


def trapezoid(t):
    v = np.interp(t, [0.0, 1.0, 3.0, 4.0], [0.0, 2.0, 2.0, 0.0])
    return v, np.concatenate([[0.0], np.cumsum(0.5 * (v[1:] + v[:-1]) * np.diff(t))])


@pytest.mark.parametrize(
    ("angle", "speed", "time", "said"),
    [
        (180 / np.pi, 1.0, 1.0, "load_angle is probably in deg, units={'load_angle': 'deg'}"),
        (1.0, 180 / np.pi, 1.0, "load_speed is probably in deg/s, units={'load_speed': 'deg/s'}"),
        (1.0, 30 / np.pi, 1.0, "load_speed is probably in rpm, units={'load_speed': 'rpm'}"),
        (1.0, np.pi / 30, 1.0, "load_speed is probably in rad/s"),
        (0.5 / np.pi, 1.0, 1.0, "load_angle is probably in rev"),
        (1.0, 0.5 / np.pi, 1.0, "load_speed is probably in rev/s"),
        (180 / np.pi, 30 / np.pi, 1.0, "load_angle is probably in deg"),
        (1.0, 1.0, 1e3, "time is probably in ms, units={'time': 'ms'}"),
        (-1.0, 1.0, 1.0, "their directions differ"),
        (1.0, 100.0, 1.0, "both sides of a gear of ratio 100"),
        (1.0, 2.0, 1.0, "check their units and columns"),
        (1.0, 0.0, 1.0, "load_speed is 0 throughout"),
        (0.0, 1.0, 1.0, "nothing moves"),
        (1.0, 1.0, 1.0, None),
    ],
)  # fmt: skip
def test_an_angle_that_does_not_grow_as_its_speed_says_is_doubted(tmp_path, angle, speed, time, said):
    t = np.arange(2001) / 500.0
    v, x = trapezoid(t)
    noise = 1.0 + 0.01 * RNG.standard_normal(len(t))
    log = sw.read_log(save(tmp_path / "log.csv", time=time * t, position=angle * x, velocity=speed * v * noise), trim=0)
    assert (log.doubts == ()) if said is None else (said in log.doubts[0])


@pytest.mark.parametrize("suffix", [".csv", ".npz"])
@pytest.mark.parametrize(
    ("name", "first", "factor", "unit"),
    [
        ("timestamp", 1.7e9, 1.0, ""),
        ("timestamp", 1.7e9, 1e3, "ms"),
        ("timestamp", 1.7e9, 1e6, "us"),
        ("timestamp", 1.7e9, 1e9, "ns"),
        ("timestamp_ns", 1.7e9, 1e9, None),
        ("time", 3200.0, 1e9, None),  # ns since a computer was started have the size of ms since 1970
    ],
)
def test_times_since_1970_are_read_in_their_unit(tmp_path, suffix, name, first, factor, unit):
    t = np.arange(2001) / 500.0
    v, x = trapezoid(t)
    columns = {name: (first + t) * factor, "load_angle": x, "load_speed": v}
    path = tmp_path / f"log{suffix}"
    if suffix == ".csv":
        table = np.column_stack(list(columns.values()))
        np.savetxt(path, table, "%.20g", header=",".join(columns), delimiter=",", comments="")
    else:
        np.savez(path, **columns)
    log = sw.read_log(path, trim=0)
    said = [note for note in log.notes if "since 1970" in note]
    if name == "time":
        assert "is it in ms, us or ns? units={'time': 'ms'}" in log.doubts[0]
        log = sw.read_log(path, trim=0, units={"time": "ns"})
    assert log.rate == pytest.approx(500.0, rel=1e-6)
    assert log.doubts == ()
    assert len(said) == (1 if unit else 0)
    assert all(f"read as {unit} since 1970" in note for note in said)


def test_a_saturated_channel_is_doubted_and_a_quantised_one_is_not(tmp_path):
    t = np.arange(4000) / 1000.0
    torque = 2.0 * np.sin(7.0 * t) + 0.02 * RNG.standard_normal(len(t))
    clipped = np.clip(torque, -9.0, 1.5)
    path = save(tmp_path / "log.csv", time=t, torque=clipped, current=np.round(torque, 1), load_torque=torque)
    (doubt,) = sw.read_log(path).doubts
    assert doubt.startswith("torque has its largest value, 1.5 N*m, in ")
    assert doubt.endswith("% of the samples: saturated?")


def test_the_log_of_another_gear_is_refused(tmp_path):
    t = np.arange(2001) / 500.0
    _, x = trapezoid(t)
    path = save(tmp_path / "log.csv", time=t, motor_angle=-100.0 * x + 3.0, load_angle=x + 1e-4 * np.cos(200.0 * x))
    log = sw.read_log(path, ratio=100)
    assert log.ratio == pytest.approx(100.0, rel=1e-3)
    with pytest.raises(
        ValueError, match=r"ratio: is the log of another gear: its motor turns 100 times as far as its load"
    ):
        sw.read_log(path, ratio=50)
    one = sw.read_log(path, trim=0.0).cut(0.0, 1.0)
    assert one.ratio == pytest.approx(100.0, rel=1e-2)
    alone = sw.read_log(save(tmp_path / "one.csv", time=t, load_angle=x), ratio=50)
    assert alone.ratio is None
    assert "the ratio 50 cannot be checked: the check needs the motion of both shafts" in alone.notes


def test_numpy_and_matlab_files_are_read_each_channel_at_its_own_times(tmp_path):
    t, slow = np.arange(101) / 100.0, np.arange(21) / 20.0
    arrays = {"time": t, "motor_angle_deg": 90.0 * t, "current": 2.0 * slow, "current_time": slow, "serial": 7.0}
    np.savez(tmp_path / "log.npz", **arrays)
    scipy.io.savemat(tmp_path / "log.mat", {"run": arrays})
    for name in ("log.npz", "log.mat"):
        columns = None if name == "log.npz" else {
            "time": "run.time", "motor_angle": "run.motor_angle_deg", "current": "run.current",
        }  # fmt: skip
        log = sw.read_log(tmp_path / name, columns)
        assert log.channels["motor_angle"] == pytest.approx(np.radians(90.0 * t), rel=1e-12)
        assert log.channels["current"] == pytest.approx(2.0 * t, abs=1e-12)
        assert any("interpolated linearly" in note for note in log.notes)
        assert np.array_equal(log.own["current"], (slow, 2.0 * slow))
    (tmp_path / "broken.npz").write_bytes(b"nothing")
    with pytest.raises(ValueError, match=r"broken.npz:1:1: file: is not a complete .npz file"):
        sw.read_log(tmp_path / "broken.npz")
    np.savez(tmp_path / "none.npz", a=1.0)
    with pytest.raises(ValueError, match="has no vectors of numbers"):
        sw.read_log(tmp_path / "none.npz")


def test_mdf_and_parquet_take_their_libraries_or_name_the_extra(tmp_path, monkeypatch):
    for name in ("log.parquet", "log.mf4"):
        (tmp_path / name).write_bytes(b"nothing")
    monkeypatch.setitem(sys.modules, "asammdf", None)
    with pytest.raises(ModuleNotFoundError, match=r"MDF needs the extra `logs`: pip install 'strainwave\[logs\]'"):
        sw.read_log(tmp_path / "log.mf4")
    t, slow = np.arange(101) / 100.0, np.arange(21) / 20.0

    class Recorded:
        def __init__(self, _path):
            pass

        def __enter__(self):
            return self

        def __exit__(self, *_):
            return None

        def iter_channels(self):
            yield SimpleNamespace(name="t", unit="s", samples=t, timestamps=t)
            yield SimpleNamespace(name="motor_pos", unit="deg", samples=90.0 * t, timestamps=t)
            yield SimpleNamespace(name="current", unit="mA", samples=2.0 * slow, timestamps=slow)
            yield SimpleNamespace(name="state", unit="", samples=np.array(["on"] * 101), timestamps=t)

    monkeypatch.setitem(sys.modules, "asammdf", SimpleNamespace(MDF=Recorded))
    log = sw.read_log(tmp_path / "log.mf4")
    assert log.channels["motor_angle"] == pytest.approx(np.radians(90.0 * t), rel=1e-12)
    assert log.channels["current"] == pytest.approx(2e-3 * t, abs=1e-12)
    with pytest.raises((ModuleNotFoundError, ValueError), match=r"extra `logs`|is not a complete .parquet file"):
        sw.read_log(tmp_path / "log.parquet")


def test_files_of_the_libraries_themselves_are_read(tmp_path):
    asammdf = pytest.importorskip("asammdf", reason="asammdf (extra `logs`) is not installed")
    pandas = pytest.importorskip("pandas")
    t, slow = np.arange(101) / 100.0, np.arange(21) / 20.0
    with asammdf.MDF(version="4.10") as file:
        file.append([asammdf.Signal(90.0 * t, t, unit="deg", name="motor_pos")])
        file.append([asammdf.Signal(2000.0 * slow, slow, unit="mA", name="current")])
        file.save(tmp_path / "log.mf4")
    log = sw.read_log(tmp_path / "log.mf4")
    assert log.channels["motor_angle"] == pytest.approx(np.radians(90.0 * t), rel=1e-12)
    assert log.channels["current"] == pytest.approx(2.0 * t, abs=1e-12)
    pytest.importorskip("pyarrow", reason="pyarrow (extra `logs`) is not installed")
    table = {"time_ms": 1e3 * t, "motor_pos [deg]": 90.0 * t, "state": ["on"] * 101}
    pandas.DataFrame(table).to_parquet(tmp_path / "log.parquet")
    log = sw.read_log(tmp_path / "log.parquet")
    assert log.channels == {"motor_angle": pytest.approx(np.radians(90.0 * t), rel=1e-12)}
    assert log.time == pytest.approx(t)
    lists = {"timestamp": t, "observation.state": [[value, 2.0 * value] for value in t]}  # as LeRobot writes them
    pandas.DataFrame(lists).to_parquet(tmp_path / "episode.parquet")
    log = sw.read_log(tmp_path / "episode.parquet", {"load_angle": "observation.state[1]"})
    assert log.channels["load_angle"] == pytest.approx(2.0 * t)
    assert log.channels["observation.state[0]"] == pytest.approx(t)


@pytest.mark.parametrize("name", ["none.npz", "none.mat", "none.mf4", "none.parquet", "none.csv"])
def test_a_file_that_is_not_there_is_said(tmp_path, name):
    with pytest.raises(ValueError, match=rf"{name}:1:1: file: does not exist"):
        sw.read_log(tmp_path / name)


def test_a_mat_file_that_is_damaged_is_refused(tmp_path, monkeypatch):
    """A wrong type of an array's name, in byte 177, ends the process of SciPy's reader by a signal."""
    monkeypatch.chdir(tmp_path)
    Path("pickle.py").write_text("raise SystemExit")  # no module of the folder is taken
    stream = BytesIO()
    scipy.io.savemat(stream, {"time": 0.1 * np.arange(9.0), "torque": np.ones(9)})
    whole = stream.getvalue()
    for content in (whole[:177] + b"\xad" + whole[178:], whole[:177] + b"\x94" + whole[178:], whole[:150], b"text"):
        Path("damaged.mat").write_bytes(content)
        with pytest.raises(ValueError, match=r"damaged\.mat:1:1: file: is not a complete \.mat file"):
            sw.read_log("damaged.mat")


@pytest.mark.parametrize("cause", ["no program", "no memory", "no SciPy"])
def test_a_mat_file_that_no_process_can_read_is_not_called_damaged(cause, tmp_path, monkeypatch):
    scipy.io.savemat(tmp_path / "log.mat", {"time": 0.1 * np.arange(9.0), "torque": np.ones(9)})
    if cause == "no program":
        monkeypatch.setattr(mat_file.sys, "executable", str(tmp_path / "none"))
        words = "No such file"
    elif cause == "no SciPy":
        (tmp_path / "child.py").write_text("import scipy_that_nobody_has")
        monkeypatch.setattr(mat_file, "CHILD", tmp_path / "child.py")
        words = "No module named"
    else:
        words = "Cannot allocate memory"
        monkeypatch.setattr(mat_file.subprocess, "run", Mock(side_effect=OSError(12, words)))
    with pytest.raises(RuntimeError, match=rf"log\.mat is read by .*, which does not run \(.*{words}.*; let "):
        sw.read_log(tmp_path / "log.mat")


def test_a_mat_file_whose_reader_was_ended_is_not_called_damaged(tmp_path, monkeypatch):
    scipy.io.savemat(tmp_path / "log.mat", {"time": 0.1 * np.arange(9.0), "torque": np.ones(9)})
    (tmp_path / "child.py").write_text("import os, signal; os.kill(os.getpid(), signal.SIGKILL)")  # as for memory
    monkeypatch.setattr(mat_file, "CHILD", tmp_path / "child.py")
    with pytest.raises(RuntimeError, match=r"log\.mat is read by .*ended from outside \(signal 9\).*memory"):
        sw.read_log(tmp_path / "log.mat")
