"""`strainwave order-table`: one format to another, what is lost, and its complaints."""

import dataclasses
import json

import pytest
from click.testing import CliRunner
from order_machines import ANGLE, ARCSEC, TORQUE, TWO_WAYS

import strainwave as sw
from strainwave.app.commands import cli as command


def invoke(*given):
    return CliRunner().invoke(command.cli, ["order-table", *map(str, given)])


@pytest.fixture
def source(tmp_path):
    ANGLE.write(tmp_path / "table.json")
    return tmp_path / "table.json"


def test_the_command_writes_what_the_library_writes(source, tmp_path):
    out = tmp_path / "joint.comp"
    run = invoke(source, out, "--format", "linuxcnc", "--option", "span=0,36", "--option", "points=200")
    assert run.exit_code == 0, run.output
    left = ANGLE.write(tmp_path / "same.comp", "linuxcnc", span=(0.0, 36.0), points=200)
    assert out.read_bytes() == (tmp_path / "same.comp").read_bytes()
    assert "table.json: 3 orders per turn of the motor, correction in rad" in run.stdout
    assert str(left).splitlines()[0] in run.stdout
    assert f"that is {left.rms / ARCSEC:.3g} arcsec rms" in run.stdout
    assert f"written: {out} (LinuxCNC's COMP_FILE)" in run.stdout


def test_json_has_the_residual(source, tmp_path):
    run = invoke(source, tmp_path / "t.txt", "--format", "points", "--json")
    data = json.loads(run.stdout)
    left = ANGLE.residual("points")
    assert data["residual"]["rms"] == left.rms
    assert data["residual"]["points"] == 128
    assert data["orders"] == [1, 2, 4]
    assert data["format"] == "points"


def test_there_and_back(tmp_path):
    first, middle, last = (tmp_path / name for name in ("a.csv", "conf.txt", "b.json"))
    TORQUE.write(first)
    constant = "torque_constant=0.05"
    assert invoke(first, middle, "--format", "moteus", "--option", constant).exit_code == 0
    run = invoke(middle, last, "--format", "json", "--from", "moteus", "--from-option", constant)
    assert run.exit_code == 0, run.output
    found = sw.OrderTable.read(last).keep((2, 12))
    for line, back in zip(TORQUE.lines, found.lines, strict=True):
        assert back.amplitude == pytest.approx(line.amplitude, rel=1e-3)


def test_speed_direction_and_ratio_are_changed_on_the_way(tmp_path):
    table = dataclasses.replace(TWO_WAYS, delay=1e-3, ratio=None)
    table.write(tmp_path / "t.json")
    given = (tmp_path / "t.json", tmp_path / "t.mpf", "--format", "sinumerik", "--option", "capacity=5000")
    assert "whose phase depends on the speed" in invoke(*given, "--one-way", "forward").output
    assert "--one-way forward, --one-way backward or --one-way mean" in invoke(*given, "--speed", "300 rpm").output
    assert "choose one with --speed" in invoke(*given, "--one-way", "forward").output
    assert "give the table its ratio" in invoke(*given, "--speed", "300 rpm", "--one-way", "backward").output
    run = invoke(*given, "--speed", "300 rpm", "--one-way", "backward", "--ratio", 50)
    assert run.exit_code == 0, run.output
    speed = 300.0 * 3.141592653589793 / 30.0
    found = sw.OrderTable.read(tmp_path / "t.mpf").on_turn("motor")
    assert found.value(1.0) == pytest.approx(table.value(1.0, -speed), abs=1e-2 * table.rms)


def test_dropped_orders_are_said(tmp_path):
    many = dataclasses.replace(TORQUE, lines=tuple(sw.Line(k, 1e-3, 0.0) for k in range(1, 12)))
    many.write(tmp_path / "t.json")
    given = (tmp_path / "t.json", tmp_path / "t.txt", "--format", "beckhoff")
    run = invoke(*given)
    assert run.exit_code == 1
    assert "has 11 orders and Beckhoff 0x32CB holds 9" in run.stderr
    assert "--drop" in run.stderr
    assert not (tmp_path / "t.txt").exists()
    assert "orders left out (10, 11)" in invoke(*given, "--drop").stdout


def test_wrong_files_formats_and_options_get_a_sentence(source, tmp_path):
    out = tmp_path / "o.txt"
    (tmp_path / "bad.json").write_text("{")
    run = invoke(tmp_path / "bad.json", out, "--format", "csv")
    assert run.exit_code == command.INVALID_PROJECT
    assert f"{tmp_path / 'bad.json'}:1:1: file: is no whole JSON" in run.stderr
    for given, said in (
        (("--format", "xml"), "'xml' is no format of order tables; known are json, csv"),
        (("--format", "points", "--option", "points=many"), "option points is 'many'; write a number"),
        (("--format", "points", "--option", "dots=3"), "has no option 'dots'; it has points"),
        (("--format", "points", "--ratio", "-1"), "--ratio is -1.0; it must be a positive"),
        (("--format", "points", "--speed", "3 m"), "3 m"),
    ):
        run = invoke(source, out, *given)
        assert run.exit_code == 1, run.output
        assert said in run.stderr
        assert not out.exists()
    run = invoke(source, out, "--format", "points", "--option", "points")
    assert run.exit_code == 2, run.output
    assert "'points' is not KEY=VALUE; write for example points=360" in " ".join(run.stderr.replace("│", " ").split())
    assert not out.exists()
