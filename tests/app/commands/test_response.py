"""`strainwave response`: the curve as numbers, CSV and figure, on the drive's own shaft."""

import csv
import json
import re
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
import small_drive
from click.testing import CliRunner
from small_drive import at_the_load

import strainwave as sw
from strainwave.app.commands import cli as command
from strainwave.app.commands.response import facts
from strainwave.app.curves import sizes_said
from strainwave.base.facts import data
from strainwave.base.sentences import Sentence, Speed
from strainwave.files.reading import read_project
from strainwave.study.analysis.cautions import not_exact

pytestmark = pytest.mark.slow

PROJECT = at_the_load(small_drive.PROJECT, 24, 38).replace("ratio: 5 %", "ratio: 2 %")


BEYOND = """\
title: A line beyond what the harmonics reach
gear: {ratio: 50, law: {type: cubic, K: 1e5 N*m/rad, alpha: 2e5 1/rad^2}}
motor: {inertia: 4.5 kg*cm^2, mode: held}
load: {inertia: 1.3 kg*m^2}
damping: {ratio: 1 %}
speed: {from: 54 rpm, to: 56 rpm, shaft: motor}
excitation: {kinematic_error: [{order: 62, amplitude: 40 arcsec}]}
"""


def invoke(*args):
    return CliRunner().invoke(command.cli, ["response", *map(str, args)])


def folds_by_fine_balance(path):
    loaded = read_project(path)
    curve = sw.frequency_response(loaded.system(1.0), loaded.speeds.limits, harmonics=31)
    return [fold.omega for fold in curve.folds]


def test_folds_and_jumps_are_told_apart_in_words(drive):
    data, text = json.loads(invoke(drive, "--json").stdout), invoke(drive).stdout
    first, second = (f"{speed:.5g}" for speed in data["fold_speeds"])
    up, down = (f"{data[f'jump_{way}_speed']:.5g}" for way in ("up", "down"))
    assert f"  folds (turning points of the curve): {first}, {second} rpm at the load\n" in text
    rows = [line.split() for line in text.splitlines()]
    ends = rows[next(i for i, row in enumerate(rows) if row[:1] == ["hysteresis"]) + 1]
    assert [float(end) for end in ends[2:4]] == pytest.approx([float(up), float(down)], rel=1e-3)


def test_the_torque_of_a_free_motor_says_whether_the_mean_is_in_it(drive):
    free = PROJECT.replace("mode: held", "mode: free")
    ripple = "{motor_torque: {lines: [{order: 2, amplitude: 1 N*cm}]}}"
    drive.write_text(free.replace("{kinematic_error: [{order: 2, amplitude: 10 arcsec}]}", ripple))
    assert ", motor 0.01 N·m beside the mean that keeps a free motor's speed\n" in invoke(drive).stdout
    drive.write_text(free.replace("kg*m^2}", "kg*m^2, drag: {type: viscous, B: 5 N*m*s/rad}}"))
    assert re.search(r", motor 0\.\d+ N·m \(mean 0\.\d+ N·m\)\n", invoke(drive).stdout)


def test_a_drive_without_a_bistable_range_is_told_so_and_not_that_it_has_no_hysteresis(drive):
    drive.write_text(PROJECT.replace("ratio: 2 %", "ratio: 20 %"), encoding="utf-8")
    text = invoke(drive).stdout
    assert "no jumps" in text
    assert "hysteresis" not in text


@pytest.mark.parametrize(("size", "covered", "said"), [
    (1e-3, True, "within the limit"), (1e-3, False, "the drive leaves them"), (1e-1, False, "rpm"),
])  # fmt: skip
def test_a_limit_is_met_only_where_a_stable_motion_is_known_at_every_speed(drive, size, covered, said):
    drive.write_text(PROJECT + "limit: {oscillation: 1 deg}\n", encoding="utf-8")
    curve = {"omega": np.array([30.0]), "oscillation": np.array([size]), "peak": np.array([size])}
    motions = SimpleNamespace(name="pointing error", top=0, largest_oscillation=lambda: 0, **curve)
    line = sizes_said(read_project(drive), motions, covered)[0]
    assert said in line
    assert ("within" in line) == (said == "within the limit")
    assert ("limit" in line) == (size < 1e-2)  # one that is passed is the failure


def test_a_curve_that_ends_inside_its_range_does_not_cover_it(drive):
    loaded = read_project(drive)
    judged = loaded.judged(loaded.response())
    assert judged.covered
    assert not judged._replace(whole=False).covered
    assert not judged._replace(avoid=None).covered


def test_folds_and_jumps_are_told_at_the_shaft_of_the_project(drive):
    result = invoke(drive, "--json")
    assert result.exit_code == 0, result.stderr
    data = json.loads(result.stdout)
    exact = folds_by_fine_balance(drive)
    assert len(exact) == 2
    at_load = [omega / 50.0 * 60.0 / (2.0 * np.pi) for omega in exact]
    assert data["unit"] == "rpm at the load"
    assert data["fold_speeds"] == pytest.approx(at_load, rel=1e-7)
    # a hardening law: the run-up drops at the upper fold, the run-down rises at the lower one
    assert data["jump_down_speed"] == pytest.approx(max(at_load), rel=1e-7)
    assert data["jump_up_speed"] == pytest.approx(min(at_load), rel=1e-7)
    assert [fold["omega_rad_per_s"] for fold in data["folds"]] == pytest.approx(exact, rel=1e-7)


def test_speeds_of_the_curve_s_message_are_those_of_the_project_s_own_shaft(drive):
    loaded = read_project(drive)
    text = Sentence("at omega = {} it was cut short", Speed(loaded.speeds.limits[1]))
    curve = replace(loaded.response(coexisting=False), rounding=text)
    (said,) = (fact.value for fact in facts(loaded, curve) if fact.words == "curve: {}")
    assert said.endswith("at 38 rpm at the load it was cut short")
    assert data(facts(loaded, curve))["message"].endswith("at 38 rpm at the load it was cut short")


def test_csv_holds_the_whole_curve_with_its_unstable_part(drive, tmp_path):
    result = invoke(drive, "-o", tmp_path / "curve.csv")
    assert result.exit_code == 0, result.stderr
    assert "rpm at the load" in result.stdout
    with open(tmp_path / "curve.csv", encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))
    omega = np.array([float(row["omega_rad_per_s"]) for row in rows])
    stable = np.array([float(row["stable"]) for row in rows])
    lo, hi = folds_by_fine_balance(drive)[::-1]
    inside = (omega > 1.001 * lo) & (omega < 0.999 * hi)
    falling = np.gradient(omega) < 0.0
    assert np.array_equal(stable[inside] == 0.0, falling[inside])
    assert 0 < np.sum(falling[inside]) < np.sum(inside)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["curve.csv", "drive.yaml"]


@pytest.mark.parametrize(("suffix", "start"), [("svg", b"<svg"), ("png", b"\x89PNG")])
def test_figure_shows_error_and_torque(drive, tmp_path, suffix, start):
    target = tmp_path / f"curve.{suffix}"
    assert invoke(drive, "-o", target).exit_code == 0
    content = target.read_bytes()
    assert content.startswith(start)
    if suffix == "svg":
        for words in (b"harmonic balance, stable", b"harmonic balance, unstable", b"pointing error", b"N\xc2\xb7m"):
            assert words in content


def test_file_of_an_unknown_kind_is_wrong_usage(drive, tmp_path):
    result = invoke(drive, "-o", tmp_path / "curve.pdf")
    assert result.exit_code == 2
    assert ".csv, .svg or .png" in result.stderr
    assert not (tmp_path / "curve.pdf").exists()


def test_curve_without_a_stable_motion_is_told_so(drive):
    """A softening law bears at most 2/3 K/sqrt(3 |alpha|) = 6.1 N*m; only on its falling side it balances 30."""
    text = PROJECT.replace("6.9e4", "-4e7").replace("{kinematic_error", "{load_torque: {mean: 30 N*m}, kinematic_error")
    drive.write_text(text)
    result = invoke(drive)
    assert result.exit_code == 0, result.stderr
    assert "no motion on the curve is stable" in result.stdout
    data = json.loads(invoke(drive, "--json").stdout)
    assert (data["largest"], data["jump_up_speed"], data["jump_down_speed"]) == (None, None, None)


def test_a_png_asks_for_matplotlib_before_anything_is_computed(drive, tmp_path, monkeypatch):
    monkeypatch.setattr("strainwave.plot.axes.find_spec", lambda _: None)
    monkeypatch.setattr("strainwave.drive.project.Project.response", lambda *_: pytest.fail("it was computed"))
    result = invoke(drive, "-o", tmp_path / "curve.png")
    assert result.exit_code == 1
    assert "a PNG needs matplotlib" in result.stderr


@pytest.mark.slow
def test_a_curve_whose_left_out_harmonics_matter_says_so(tmp_path):
    """Its third harmonic, order 186, holds more than 0.1 %, and the exact response has at most 64 harmonics."""
    path = tmp_path / "beyond.yaml"
    path.write_text(BEYOND)
    result = invoke(path)
    assert result.exit_code == 0, result.stderr
    assert "the harmonics left out hold about" in result.stdout
    assert "take more than 64 harmonics" in result.stdout


def test_the_report_warns_of_a_rough_curve():
    duffing = sw.Oscillator(1.0, 0.05, sw.Cubic(1.0, 0.1), sw.Harmonic(0.18), 1.2)
    rough, fine = (sw.frequency_response(duffing, (0.5, 1.6), harmonics=h, points=60) for h in (1, 7))
    assert not_exact("The curve", fine) == []
    (said,) = not_exact("The curve", rough)
    assert said.startswith("The curve is inaccurate: reached both ends; at omega = ")
