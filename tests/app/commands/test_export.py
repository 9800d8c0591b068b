"""`strainwave export`: what it writes and says."""

import json
import os

import pytest
from click.testing import CliRunner

import strainwave as sw
from strainwave.app.commands import cli as command

PROJECT = """\
title: Level axis
gear: {ratio: 50, law: {type: linear, K: 1e5 N*m/rad}}
motor: {inertia: 5 kg*cm^2, loop: {bandwidth: 20 Hz}}
load: {inertia: 1 kg*m^2}
damping: {ratio: 5 %}
speed: {from: 24 rpm, to: 38 rpm, shaft: load}
excitation: {kinematic_error: [{order: 2, amplitude: 10 arcsec}]}
"""


@pytest.fixture
def path(tmp_path):
    path = tmp_path / "axis.yaml"
    path.write_text(PROJECT)
    return path


def invoke(*given):
    return CliRunner().invoke(command.cli, ["export", *map(str, given)])


@pytest.mark.parametrize(("to", "name"), [("c", "axis.c"), ("mjcf", "axis.xml"), ("fmu3", "a.fmu")])
def test_the_command_writes_what_the_verb_writes(to, name, path, tmp_path):
    (tmp_path / "own").mkdir()
    run = invoke(path, "--to", to, "-o", tmp_path / name, "--step", "100 us", "--json")
    assert run.exit_code == 0, run.output
    assert json.loads(run.stdout)["format"] == to
    own = sw.export(sw.read_project(path), tmp_path / "own" / name, to=to, step=1e-4)
    assert own.path.read_bytes() == (tmp_path / name).read_bytes()


LAW = """\
from typing import Annotated, NamedTuple

import numpy as np


class Bent(NamedTuple):
    K: Annotated[float, "N*m/rad"]

    def torque(self, x):
        return np.array([self.torque(u) for u in x]) if isinstance(x, np.ndarray) else self.K * max(x, 0.5 * x)

    def stiffness(self, x):
        return self.K * (0.75 + 0.25 * np.sign(x))
"""


def test_a_law_of_the_project_that_branches_is_one_sentence(tmp_path):
    (tmp_path / "own.py").write_text(LAW)
    (tmp_path / "axis.yaml").write_text(PROJECT.replace("{type: linear,", '{python: "own.py:Bent",'))
    before = sorted(os.listdir(tmp_path))
    run = invoke(tmp_path / "axis.yaml", "--to", "fmu2", "-o", tmp_path / "axis.fmu")
    assert run.exit_code == 1
    assert run.stderr.startswith(
        "strainwave: Bent.torque branches on a value (if, and, or, min or max) in line 10: it is"
    )
    assert run.stderr.count("\n") == 1
    assert sorted(os.listdir(tmp_path)) == before


@pytest.mark.parametrize(
    ("given", "sentence"),
    [
        (("--to", "c", "-o", "a.fmu"), "strainwave: the file is 'a.fmu'; give it a name that ends in .c\n"),
        (("--to", "fmu2", "-o", "none/a.fmu"), "strainwave: there is no folder none; make it, or save elsewhere\n"),
        (("--to", "c", "-o", "a.c", "--step", "1 s"), "give a shorter one\n"),
    ],
)
def test_bad_input_is_one_sentence(given, sentence, path, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    run = invoke(path, *given)
    assert run.exit_code == 1
    assert run.stderr.endswith(sentence)
    assert run.stderr.count("\n") == 1
    assert os.listdir(tmp_path) == ["axis.yaml"]


def test_a_format_that_there_is_not_is_refused_with_those_that_there_are(path, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    run = invoke(path, "--to", "html", "-o", "a.html")
    assert run.exit_code == 2
    assert "'html' is not one of 'c', 'fmu2', 'fmu3', 'mjcf'" in run.stderr
    assert os.listdir(tmp_path) == ["axis.yaml"]
