"""`strainwave compensate-move`, `compensate-run-up` and `--load-angle`: the numbers of the library's calls."""

import csv
import json
import math

import numpy as np
import pytest
from click.testing import CliRunner
from turntable import PROJECT

import strainwave as sw
from strainwave.app.commands import cli as command

RPM, ARCSEC = math.pi / 30.0, math.pi / 648_000.0
MOVE = "trapezoid, angle: 2 deg, time: 0.1 s"


@pytest.fixture
def path(tmp_path):
    path = tmp_path / "table.yaml"
    path.write_text(PROJECT)
    return path


def invoke(*given):
    return CliRunner().invoke(command.cli, list(map(str, given)))


def table_of(path):
    """Columns of a CSV file by name."""
    header, *rows = csv.reader(path.read_text().splitlines())
    return dict(zip(header, np.array(rows, float).T, strict=True))


def test_a_move_is_that_of_the_library(path, tmp_path):
    out = tmp_path / "out"
    asked = ("--controller", "loop", "--controller", "inverse", "--shaping", "ZV", "--window", "10 arcsec")
    run = invoke("compensate-move", path, MOVE, *asked, "-o", out, "--json")
    assert run.exit_code == 0, run.output
    own = sw.compensate_move(
        sw.read_project(path), sw.Trapezoid(math.radians(2.0), 0.1), ("loop", "inverse"), shaping=("ZV",),
        window=10.0 * ARCSEC,
    )  # fmt: skip
    data = json.loads(run.stdout)
    assert json.loads((out / "move.json").read_text()) == data
    assert [row["controller"] for row in data["controllers"]] == own.names == ["loop", "inverse", "loop, ZV"]
    for row, score in zip(data["controllers"], own.scores, strict=True):
        assert row["rms_arcsec"] * ARCSEC == pytest.approx(score.rms, rel=1e-9)
        assert row["peak_arcsec"] * ARCSEC == pytest.approx(score.peak, rel=1e-9)
        assert row["motor_torque_peak_N_m"] == pytest.approx(score.torque, rel=1e-9)
        assert row["settling_time_s"] == pytest.approx(score.settling_time, rel=1e-9)
    columns = table_of(out / "move.csv")
    np.testing.assert_allclose(columns["time_s"], own.time, rtol=1e-7)
    np.testing.assert_allclose(columns["error_arcsec loop, ZV"] * ARCSEC, own.error[2], rtol=1e-7, atol=1e-15)
    np.testing.assert_allclose(columns["motor_torque_N_m inverse"], own.torque[1], rtol=1e-7, atol=1e-12)
    assert (out / "move.svg").read_text().startswith("<svg")


def test_without_a_profile_the_move_of_the_file_is_taken(path):
    path.write_text(PROJECT + f"move: {{profile: [{{type: {MOVE}}}]}}\n")
    of_file = invoke("compensate-move", path, "--controller", "loop", "--json")
    assert of_file.exit_code == 0, of_file.output
    assert of_file.stdout == invoke("compensate-move", path, MOVE, "--controller", "loop", "--json").stdout


def test_a_run_up_is_that_of_the_library(path, tmp_path):
    out = tmp_path / "out"
    asked = ("--controller", "loop", "--from", "1100 rpm", "--to", "1200 rpm", "--time", "0.4 s")
    run = invoke("compensate-run-up", path, *asked, "-o", out, "--json")
    assert run.exit_code == 0, run.output
    project = sw.read_project(path)
    own = sw.compensate_run_up(project, (1100.0 * RPM, 1200.0 * RPM), 0.4, ("loop",))
    data = json.loads(run.stdout)
    assert json.loads((out / "run-up.json").read_text()) == data
    (row,) = data["controllers"]
    assert row["largest_up_arcsec"] * ARCSEC == pytest.approx(np.max(own.up), rel=1e-9)
    assert row["largest_down_arcsec"] * ARCSEC == pytest.approx(np.max(own.down), rel=1e-9)
    assert row["jumps"] is bool(np.isfinite(own.jump[0]))
    assert data["acceleration_rpm_per_s"] == pytest.approx(250.0)
    columns = table_of(out / "run-up.csv")
    np.testing.assert_allclose(columns["motor_speed_rpm"] * RPM, own.speed, rtol=1e-7)
    np.testing.assert_allclose(columns["down_arcsec loop"] * ARCSEC, own.down[0], rtol=1e-7)
    assert (out / "run-up.svg").read_text().startswith("<svg")


@pytest.mark.slow
def test_the_worst_angle_of_the_load_counts(path):
    gravity = "load: {inertia: 0.8 kg*m^2, drag: {type: angle_torque, amplitude: 12 N*m}}"
    path.write_text(PROJECT.replace("load: {inertia: 0.8 kg*m^2}", gravity).replace("linear, K: 2e4", "cubic, K: 2e4")
                    .replace("N*m/rad}}", "N*m/rad, alpha: 5e5 1/rad^2}}"))  # fmt: skip
    asked = ("--controller", "inverse", "--speed", "600 rpm", "--load-angle", "0 deg", "--load-angle", "90 deg")
    run = invoke("compensate", path, *asked, "--json")
    assert run.exit_code == 0, run.output
    own = sw.compensate(
        sw.read_project(path), "inverse", speed=600.0 * RPM, load_angles=(0.0, math.pi / 2.0), robust=False
    )
    row = json.loads(run.stdout)["results"][1]
    assert row["rms_after_arcsec"] * ARCSEC == pytest.approx(own.after.rms, rel=1e-9)


def test_a_move_at_the_limit_of_the_torque_says_so(path):
    run = invoke("compensate-move", path, "trapezoid, angle: 20 deg, time: 0.02 s", "--controller", "loop")
    assert run.exit_code == 0, run.output
    assert "loop: the torque is at its limit in" in run.stdout


WRONG = [
    ("compensate-move", (), "has no move; write 'trapezoid, angle: 20 deg, time: 0.4 s' after it"),
    ("compensate-move", ("trapezoid, angle: 20 deg",), "time"),
    ("compensate-move", ("trapezoid, angle: 20 deg, time: 1 ns",), "the profile lasts 1e-09 s and samples are taken"),
    ("compensate-run-up", ("--time", "1 us"), "time is 1e-06 s and a period of order 1 lasts 0.2 s at 300 rpm"),
    ("compensate-move", (MOVE, "--controller", "adaptive"), "is designed for one speed"),
    ("compensate-move", (MOVE, "--window", "0 arcsec"), "--window: '0 arcsec' is not positive"),
    ("compensate-move", (MOVE, "--window", "3 rpm"), "--window"),
    ("compensate-move", (MOVE, "--shaping", "XY"), "'XY' is not one of"),
    ("compensate-run-up", ("--time", "-1 s"), "--time: '-1 s' is not positive"),
    ("compensate-run-up", ("--from", "1200 rpm", "--to", "300 rpm"), "--from is 1200 rpm and --to 300 rpm; give"),
    ("compensate-run-up", ("--from", "9000 rpm"), "--from is 9000 rpm and the file's highest speed"),
    ("compensate-run-up", ("--controller", "magic"), "'magic' is designed for one speed, or is none"),
    ("compensate-run-up", ("--load-angle", "ninety"), "--load-angle"),
    ("compensate-run-up", ("--softer", "120 %"), "is not between -100 % and 100 %"),
]


@pytest.mark.parametrize(("name", "given", "said"), WRONG)
def test_a_wrong_command_ends_with_one_sentence_and_writes_nothing(path, tmp_path, name, given, said):
    run = invoke(name, path, *given, "-o", tmp_path / "out")
    assert run.exit_code in (1, 2)
    assert said in " ".join(run.stderr.replace("│", " ").split())
    assert "Traceback" not in run.output
    assert not (tmp_path / "out").exists()
