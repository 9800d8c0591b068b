"""`strainwave order-table`: from one format to another, and its complaints."""

import dataclasses
import json
import math

import numpy as np
import pytest
from click.testing import CliRunner

import strainwave as sw
from strainwave.app.commands import cli as command

TABLE = sw.OrderTable((sw.Line(1, 2e-5, -1.0), sw.Line(4, 1e-4, 0.3)), ratio=50.0, zero=0.4, delay=1e-3, source="rig")


def invoke(*given):
    return CliRunner().invoke(command.cli, ["order-table", *map(str, given)])


@pytest.fixture
def source(tmp_path):
    TABLE.write(tmp_path / "table.json")
    return tmp_path / "table.json"


def test_a_table_goes_through_all_formats_and_comes_back(source, tmp_path):
    header, points, back = (tmp_path / name for name in ("t.h", "t.csv", "back.json"))
    run = invoke(source, header, "--prefix", "joint", "--points", 200)
    assert run.exit_code == 0, run.output
    assert "table.json: 2 orders per turn of the motor, correction in rad" in run.stdout
    assert f"written: {header}" in run.stdout
    TABLE.write(tmp_path / "same.h", prefix="joint", points=200)
    assert header.read_bytes() == (tmp_path / "same.h").read_bytes()
    assert invoke(header, points, "--speed", "300 rpm").exit_code == 0
    run = invoke(points, back, "--json")
    assert json.loads(run.stdout) == {"file": "t.csv", "written": str(back), "format": "json", "orders": [1, 4]}
    angle, speed = np.linspace(0.0, 7.0, 99), 300.0 * math.pi / 30.0
    found = sw.OrderTable.read(back)
    for way in (speed, -speed):
        assert found.value(angle, way) == pytest.approx(TABLE.value(angle, way), abs=1e-16)
    assert dataclasses.replace(found, lines=(), backward=None) == dataclasses.replace(TABLE, lines=(), delay=0.0)


def test_wrong_files_and_formats_get_a_sentence(source, tmp_path):
    out = tmp_path / "o.txt"
    (tmp_path / "bad.json").write_text("{")
    run = invoke(tmp_path / "bad.json", out, "--format", "csv")
    assert run.exit_code == command.INVALID_PROJECT
    assert f"{tmp_path / 'bad.json'}:1:1: file: is not complete JSON" in run.stderr
    for given, said in (
        ((), "'.txt' is not a format of order tables; formats: json, csv, c"),
        (("--format", "csv"), "choose one with --speed"),
        (("--format", "csv", "--speed", "3 m"), "3 m"),
    ):
        run = invoke(source, out, *given)
        assert run.exit_code == 1, run.output
        assert said in run.stderr
        assert not out.exists()
