"""`strainwave export`: what it writes and says."""

import json

import pytest
from click.testing import CliRunner
from small_drive import LINEAR, at_the_load

import strainwave as sw
from strainwave.app.commands import cli as command

PROJECT = at_the_load(LINEAR, 24, 38).replace("mode: held", "loop: {bandwidth: 20 Hz}")


def invoke(*given):
    return CliRunner().invoke(command.cli, ["export", *map(str, given)])


@pytest.mark.parametrize(("to", "name"), [("c", "axis.c"), ("mjcf", "axis.xml"), ("fmu3", "a.fmu")])
def test_the_command_writes_what_the_verb_writes(to, name, drive, tmp_path):
    (tmp_path / "own").mkdir()
    run = invoke(drive, "--to", to, "-o", tmp_path / name, "--step", "100 us", "--json")
    assert run.exit_code == 0, run.output
    assert json.loads(run.stdout)["format"] == to
    own = sw.export(sw.read_project(drive), tmp_path / "own" / name, to=to, step=1e-4)
    assert own.path.read_bytes() == (tmp_path / name).read_bytes()
    told = invoke(drive, "--to", to, "-o", tmp_path / name, "--step", "100 us").stdout
    assert told.splitlines()[1:] == json.loads(run.stdout)["notes"] == list(own.notes)
    left = "the control loop of the motor" if to == "mjcf" else "the motor's control loop is omitted"
    assert left in told
