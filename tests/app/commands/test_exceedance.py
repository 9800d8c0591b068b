"""`strainwave exceedance` prints the probability with its interval."""

import itertools
import json

import numpy as np
import pytest
from click.testing import CliRunner
from linear_drive import SCATTERED as PROJECT

import strainwave as sw
from strainwave.app.commands import cli as command
from strainwave.files.reading import read_project

pytestmark = pytest.mark.slow


def invoke(path, *options):
    return CliRunner().invoke(command.cli, ["exceedance", str(path), *options])


def test_it_prints_what_python_computes(drive):
    run = invoke(drive, "--count", "32", "--seed", "4", "--json")
    assert run.exit_code == 0, run.stderr
    report = json.loads(run.stdout)
    found = sw.exceedance(read_project(drive), count=32, seed=4)
    assert report["oscillation_rad"] == found.oscillation.tolist()
    assert (report["exceeding"], report["interval"]) == (found.exceeding, list(found.interval))
    assert 0 < found.exceeding < 32
    assert set(report["first_order_index"]) == {"damping.B", "load.inertia"}
    told = invoke(drive, "--count", "32", "--seed", "4", "--limit", "1 deg").stdout
    assert "0 of 32 drives exceed 17.45 mrad somewhere in the range" in told
    assert "95 % confidence (Clopper-Pearson) 0 % to 10.9 %" in told  # 1 - 0.025^(1/32)
    assert "seed 4" in told


def test_bad_input_is_one_sentence(drive):
    run = invoke(drive, "--limit", "3 N*m")
    assert run.exit_code == 2
    assert "--limit: '3 N*m'" in run.stderr
    for verb, limit in itertools.product(("exceedance", "speed-map"), ("-60 arcsec", "0 arcsec")):
        run = CliRunner().invoke(command.cli, [verb, str(drive), "--limit", limit])
        assert (run.exit_code, run.stdout) == (2, "")
        assert f"--limit: '{limit}' is not positive; write a value above zero" in run.stderr
        assert "motions" not in run.stderr  # nothing has begun
    drive.write_text(PROJECT.replace("scatter:", "# scatter:"), encoding="utf-8")
    run = invoke(drive)
    assert (run.exit_code, run.stdout) == (1, "")
    assert "drive.yaml has no scatter" in run.stderr


def test_drives_without_a_curve_are_counted_once_with_their_reasons():
    sizes = np.array([1e-3, np.nan, np.nan])
    found = sw.results.Exceedance(
        5e-4, {}, *[sizes] * 4, 0, None, ("no motion is found", "the law carries no such torque")
    )
    told = [line for line in str(found).splitlines() if "curve" in line]
    assert told == ["2 of the drives have no response curve: no motion is found; the law carries no such torque"]
