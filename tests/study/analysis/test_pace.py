"""The shares that `analyze` tells: a time goes by between them, and every load of a drive adds to it."""

from dataclasses import replace
from importlib.resources import files

import pytest

import strainwave as sw
from strainwave.drive.postures import Posture
from strainwave.study.analysis.pace import Stage, paced

PROJECT = sw.read_project(str(files("strainwave.app") / "projects" / "antenna.yaml"))


def shares(postures):
    told = []
    report = paced(replace(PROJECT, postures=postures), lambda _, share: told.append(share))
    for stage in (Stage.POINT, Stage.CURVE, Stage.RESONANCES, Stage.IN_TIME, Stage.LOADS, Stage.ADVICE):
        report(stage.text, stage.at())
    report("", Stage.ADVICE.at(1.0))
    return told


def test_shares_of_analyze_rise_to_one_and_every_load_adds_as_much_time():
    one, four = shares(()), shares(tuple(Posture(2.0 + i, name=f"posture {i}") for i in range(3)))
    for told in (one, four):
        assert told == sorted(told)
        assert (told[0], told[1], told[-1]) == (0.0, 0.0, 1.0)  # no estimate before a curve is known
    in_curves = [(told[5] - told[4]) / told[2] for told in (one, four)]
    assert in_curves[1] == pytest.approx(4.0 * in_curves[0])
