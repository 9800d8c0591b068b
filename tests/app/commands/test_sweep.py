"""`strainwave sweep`: what its options mean, what it prints, and how it is interrupted and resumed."""

import json
import os
import signal
import subprocess
import sys
import time
from functools import partial

import click
import numpy as np
import pytest
import small_drive
import zarr
from click.testing import CliRunner
from small_drive import at_the_load

import strainwave as sw
from strainwave.app.commands import cli as command
from strainwave.app.commands.sweeps.project_sweep import summary
from strainwave.app.commands.sweeps.sweep import axis, in_equation, named, placed, typed_unit
from strainwave.base.quantities import parameters
from strainwave.files.reading import read_project

PROJECT = at_the_load(small_drive.PROJECT, 200, 400).replace("small", "small 100%")
KNOWN = parameters(sw.Oscillator(1.0, 0.1, sw.Cubic(1.0, 0.1), sw.Harmonic(1.0), 1.0))


@pytest.mark.parametrize(
    ("text", "own"),
    [
        ("gear.law.alpha=1,2", "law.alpha=1,2"),
        ("load.inertia = 1,2", "J= 1,2"),
        ("damping.B=1,2", "B=1,2"),
        ("excitation.kinematic_error.0.amplitude=1:2:3", "error.lines.0.amplitude=1:2:3"),
        ("omega=1,2", "omega=1,2"),
        ("gear.law.K1&gear.law.K2 = 0.9,1.1", "law.K1 & law.K2= 0.9,1.1"),
    ],
)
def test_names_of_the_project_file_are_those_of_the_equation(drive, text, own):
    assert in_equation(text, read_project(drive)) == own


def test_the_load_is_not_the_inertia_of_a_free_motors_equation(drive):
    drive.write_text(PROJECT.replace("held", "free"))
    assert in_equation("load.inertia=1,2", read_project(drive)) == "load.inertia=1,2"


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("omega=1:2:3", [1.0, 1.5, 2.0]),
        ("omega = 10 : 1000 : 3 : log", [10.0, 100.0, 1000.0]),
        ("omega=1,2, 7.5", [1.0, 2.0, 7.5]),
        ("omega=60 rpm,1 rad/s", [2.0 * np.pi, 1.0]),
        ("omega=60 rpm:120 rpm:2", [2.0 * np.pi, 4.0 * np.pi]),
    ],
)
def test_a_grid_is_read_in_si_units_or_in_its_own(text, values):
    path, found = axis(text, KNOWN)
    assert path == "omega"
    assert found == pytest.approx(values, rel=1e-14)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("omega", "is not a grid"),
        ("speeed=1", "'speeed' is not a parameter of this drive; it has J, B, law.K"),
        ("load.inertia=1,2", "'load.inertia' is not a parameter of this drive"),
        ("law.K & law.beta=1,2", "'law.beta' is not a parameter"),
        ("omega=1:2", "is no range"),
        ("omega=1:2:0", "no count"),
        ("omega=-1:2:3:log", "includes 0"),
        ("omega=nan", "not finite"),
        ("omega=20 Hz", "20 Hz"),
    ],
)
def test_what_is_no_grid_is_refused(text, words):
    with pytest.raises(click.BadParameter, match=words):
        axis(text, KNOWN)


@pytest.mark.parametrize(
    ("text", "given"),
    [
        ("omega=1:2:3", "rad/s"),
        ("omega=800 rpm:1000 rpm:5:log", "rpm"),
        ("omega = 8e2rpm, 90 rad/s", "rpm"),
        ("law.K & law.alpha=0.9,1.1", ""),
    ],
)
def test_the_unit_that_was_typed_is_known(text, given):
    own = "" if "&" in text else "rad/s"
    assert typed_unit(text, KNOWN)[1] == (own, given)


def test_what_was_found_is_told_in_the_units_that_were_typed_and_angles_in_arcsec():
    peak = {"unit": "rad", "smallest": 1e-5, "largest": 2e-3, "largest_at": {"omega": 30.0 * np.pi, "B": 2.0}}
    report = {"title": "A drive", "points": 6, "over": {"omega": 3, "B": 2}, "variables": {"peak": peak}}
    report |= {"units": {"omega": ("rad/s", "rpm"), "B": ("N*m*s/rad", "N*m*s/rad")}, "errors": [], "store": "s"}
    report["remarks"] = ["All points are at one speed."]
    where = partial(placed, report["units"])
    told = summary(report | dict.fromkeys(("diverged", "failed"), 0), where, ["diverged"])
    assert "largest |error|: 2.0626 to 412.53 arcsec, the largest at omega = 900 rpm, B = 2 N·m·s/rad" in told
    assert "note: All points are at one speed." in told


def test_a_whole_number_is_neither_swept_nor_offered(drive):
    known = parameters(read_project(drive).system(1.0))
    with pytest.raises(
        click.BadParameter, match=r"'error.lines.0.order' is a whole number, .* sweep J, B, law.K"
    ) as no:
        axis("error.lines.0.order=2,4", known)
    assert no.value.message.count("order") == 1
    with pytest.raises(click.BadParameter) as no:
        axis("speeed=1", known)
    assert "order" not in no.value.message


def test_a_factor_of_several_parameters_is_a_plain_number():
    path, found = axis("law.K & law.alpha=0.9:1.1:3", KNOWN)
    assert path == "law.K & law.alpha"
    assert found == pytest.approx([0.9, 1.0, 1.1])


def test_measures_have_names():
    assert [named(text) for text in ("peak", "rms", "amplitude:3")] == [sw.Peak(), sw.Rms(), sw.Amplitude(3)]
    for wrong in ("peek", "amplitude", "amplitude:0", "amplitude:x"):
        with pytest.raises(click.BadParameter, match="not a measure"):
            named(wrong)


def test_wrong_usage_is_told_before_a_store_is_made(drive, tmp_path):
    store = tmp_path / "s"
    run = CliRunner().invoke(command.cli, ["sweep", str(drive), "--grid", "law.beta=1:2:3", "-o", str(store)])
    assert run.exit_code == 2
    assert "is not a parameter of this drive" in run.stderr
    assert sorted(path.name for path in tmp_path.iterdir()) == ["drive.yaml"]


def test_a_sweep_of_impossible_points_is_one_sentence(drive, tmp_path):
    call = [
        "sweep",
        str(drive),
        "--grid",
        "J=-1000 kg*cm^2,-2 kg*m^2",
        "--periods",
        "1",
        "--settle",
        "0",
        "-o",
        str(tmp_path / "s"),
    ]
    run = CliRunner().invoke(command.cli, call)
    assert run.exit_code == 1
    said = run.stderr.splitlines()[-1]
    assert said.startswith(
        "strainwave: none of 2 points could be computed: point 0 (J = −1000 kg·cm^2): Oscillator.J is -0.1"
    )


@pytest.mark.slow
def test_a_sweep_prints_what_it_found_and_computes_nothing_twice(drive, tmp_path):
    store = tmp_path / "s"
    call = ["sweep", str(drive), "--grid", "law.alpha=5e4,6e4", "--grid", "omega=100:120:5", "-o", str(store)]
    call += ["--settle", "40", "--periods", "1", "--chunk", "5"]
    run = CliRunner().invoke(command.cli, [*call, "--json"])
    assert run.exit_code == 0, run.stderr
    report = json.loads(run.stdout)
    assert report["points"] == 10
    assert zarr.open_array(store / "done", mode="r").size == 2
    assert (report["failed"], report["diverged"]) == (0, 0)
    # order 2 runs towards the resonance at 316 rad/s from below: the largest error is that of the highest speed
    place = report["variables"]["peak"]["largest_at"]
    assert place["omega"] == 120.0
    steady = sw.find_orbit(sw.replaced(read_project(drive).system(1.0), place))
    assert report["variables"]["peak"]["largest"] == pytest.approx(steady.peak, rel=1e-6)
    before = {path: path.stat().st_mtime_ns for path in store.glob("peak/**/*")}
    again = CliRunner().invoke(command.cli, call)
    assert again.exit_code == 0
    assert "10 points over law.alpha (2), omega (5)" in again.stdout
    assert {path: path.stat().st_mtime_ns for path in store.glob("peak/**/*")} == before


@pytest.mark.slow
def test_ctrl_c_keeps_what_is_done_and_the_same_command_goes_on_to_the_same_result(drive, tmp_path):
    store, quiet = tmp_path / "s", tmp_path / "quiet"
    call = ["sweep", drive, "--grid", "law.alpha=5e4:6e4:13", "--grid", "omega=100:120:1000"]
    call += ["--chunk", "1000"]
    call = [sys.executable, "-m", "strainwave", *map(str, call), "--settle", "10", "--periods", "1", "-o"]
    how = {"text": True, "env": os.environ | {"STRAINWAVE_JIT": "1"}, "stdout": subprocess.PIPE}
    run = subprocess.Popen([*call, str(store)], stderr=subprocess.PIPE, **how)
    for _ in range(6000):
        if (store / "done" / "c").exists():
            break
        time.sleep(0.01)
    run.send_signal(signal.SIGINT)
    out, told = run.communicate()
    assert run.returncode == 130
    assert out == ""
    done = int(zarr.open_array(store / "done", mode="r")[:].sum())
    assert f"interrupted; {done} of 13 chunks are kept in {store}: run the same sweep again to continue" in told
    assert 1 <= done < 13
    assert "Traceback" not in told
    assert "Exception" not in told
    for path in (store, quiet):
        subprocess.run([*call, str(path)], check=True, **how)
    files = [{p.relative_to(s): p.read_bytes() for p in s.rglob("*") if p.is_file()} for s in (store, quiet)]
    assert files[0] == files[1]
