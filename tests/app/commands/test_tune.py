"""`strainwave tune`: what it prints and writes, with the numbers of the library, and its complaints."""

import csv
import json

import pytest
from click.testing import CliRunner

import strainwave as sw
from strainwave.app.commands import cli as command

PROJECT = """\
title: Level axis
gear: {ratio: 50, law: {type: linear, K: 3e4 N*m/rad}}
motor: {inertia: 4.5 kg*cm^2, loop: {type: speed_loop, K_p: 0.2 N*m*s/rad, K_i: 5 N*m/rad, lag: 0.5 ms},
  drive_units: {K_p: 250 uN*m*s/rad, K_i: 0.02 N*m/rad, K_v: 0.1 1/s}}
load: {inertia: 1.2 kg*m^2}
damping: {B: 11 N*m*s/rad}
speed: {from: 500 rpm, to: 3000 rpm, shaft: motor}
excitation: {kinematic_error: [{order: 2, amplitude: 20 arcsec}]}
"""


@pytest.fixture
def moving(drive):
    drive.write_text(PROJECT + "move: {profile: [{type: angle_profile, file: turn.csv}]}\n")
    (drive.parent / "turn.csv").write_text("time [s],angle [deg]\n0,0\n0.1,1\n0.2,4\n0.3,5\n")
    return drive


def invoke(*given):
    return CliRunner().invoke(command.cli, ["tune", *map(str, given)])


@pytest.mark.slow
def test_the_command_writes_and_prints_the_numbers_of_the_library(moving, tmp_path):
    run = invoke(moving, "--gain", "K_p", "--goal", "pointing", "-o", tmp_path / "out", "--json")
    assert run.exit_code == 0, run.output
    found, data = sw.tune(sw.read_project(moving), goals=("pointing",), gains=("K_p",)), json.loads(run.stdout)
    best = data["points"][2]
    assert (best["gains"], best["K_p"]) == ("recommended", pytest.approx(found.recommended.gains[0]))
    assert json.loads((tmp_path / "out/tune.json").read_text()) == data
    assert data["in_drive_units"] == {"K_p": pytest.approx(found.recommended.gains[0] / 2.5e-4, rel=1e-9)}
    assert f"in the drive's own units: K_p {found.recommended.gains[0] / 2.5e-4:.4g}" in str(found).replace("\n  ", " ")
    rows = list(csv.DictReader((tmp_path / "out/tune.csv").read_text().splitlines()))
    assert list(rows[0]) == ["K_p_N_m_s_per_rad", "pointing_rad", "peak_sensitivity"]
    assert len(rows) == len(found.front)
    written = sw.read_project(tmp_path / "out/tuned.yaml")
    assert written.whole.motor.control == found.control
    assert written.move.profile == sw.read_project(moving).move.profile  # its table was copied
    assert (tmp_path / "out/tune.svg").read_text().startswith("<svg")


@pytest.mark.parametrize(
    ("given", "code", "said"),
    [
        (["--goal", "settling"], 1, "needs a move, and the project has none"),
        (["--gain", "K_v"], 1, "there is no gain 'K_v'"),
        (["--phase-margin", "45"], 2, "--phase-margin"),
        (["--units", "5"], 1, "scatter"),
    ],
)
def test_a_wrong_command_ends_with_one_sentence(drive, given, code, said):
    run = invoke(drive, *given)
    assert run.exit_code == code
    assert said in run.output


def test_a_profile_that_a_file_of_the_results_would_replace_is_refused(moving, tmp_path):
    moving.write_text(moving.read_text().replace("turn.csv", "tune.csv"))
    (moving.parent / "turn.csv").rename(moving.parent / "tune.csv")
    run = invoke(moving, "-o", tmp_path / "out")
    assert (run.exit_code, (tmp_path / "out").exists()) == (1, False)
    assert "the profile 'tune.csv' has the name of an output file of this command" in run.output


@pytest.mark.slow
def test_a_loop_that_is_unstable_is_tuned_and_has_dashes(moving):
    moving.write_text(moving.read_text() + "controller: {period: 4 ms, delay: 8 ms}\n")
    run = invoke(moving)
    assert run.exit_code == 0, run.output
    assert "those of the symmetric optimum (the present loop is unstable)" in " ".join(run.output.split())
    assert next(line for line in run.output.splitlines() if line.lstrip().startswith("file")).count("–") >= 4
