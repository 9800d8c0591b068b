"""Ctrl-C: what a command had finished is written, the exit code is 130, and one sentence says what is kept."""

import csv
import json
import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest
from linear_drive import SCATTERED as PROJECT
from one_joint import SPECIFICATION

import strainwave as sw
from strainwave.base.units import RPM
from strainwave.files.reading import from_text

WINDOWS = sys.platform == "win32"


# A command that stops itself as a user does, when its progress was told so many times, or at a stage.
STOPPED = """\
import signal, sys
from strainwave.app.console import progress
from strainwave.app.commands import cli

count, after = 0, sys.argv.pop(1)
show = progress.Progress.show

def told(self, stage, share):
    global count
    show(self, stage, share)
    hit = share > 0.0 if after.isdecimal() else stage.startswith(after)
    count += hit
    if hit and count == (int(after) if after.isdecimal() else 1):
        signal.raise_signal(signal.SIGINT)

progress.Progress.show = told
cli.main()
"""


# Commands that a signal reaches where their results are printed, and when they have ended.
LATE = """\
import atexit, signal, sys
from strainwave.app.commands import cli

def late(*_, **__):
    signal.raise_signal(signal.SIGINT)

if sys.argv.pop(1) == "printing":
    cli.click.echo, echo = (lambda text, err=False: echo(text, err=True) if err else late()), cli.click.echo
else:
    atexit.register(late)
cli.main()
"""


@pytest.mark.parametrize(("when", "code", "said"), [("printing", 130, "interrupted; written: "), ("ended", 0, "")])
def test_a_signal_after_writing_says_what_is_written_or_interrupts_nothing(drive, tmp_path, when, code, said):
    call = [sys.executable, "-c", LATE, when, "speed-map", str(drive), "-o", str(tmp_path / "map")]
    how = {"text": True, "capture_output": True, "timeout": 300.0, "env": os.environ | {"STRAINWAVE_JIT": "0"}}
    run = subprocess.run(call, **how, check=False)
    assert run.returncode == code, run.stderr
    assert said in run.stderr
    assert ("interrupted" in run.stderr) == (code == 130)
    assert "Traceback" not in run.stderr
    assert (tmp_path / "map" / "cells.csv").is_file()


def stopped(after, *call):
    how = {"text": True, "capture_output": True, "timeout": 300.0, "env": os.environ | {"STRAINWAVE_JIT": "0"}}
    run = subprocess.run([sys.executable, "-c", STOPPED, str(after), *map(str, call)], **how, check=False)
    assert run.returncode == 130, run.stderr
    assert "Traceback" not in run.stderr
    return run


@pytest.mark.slow
def test_exceedance_answers_with_the_drives_that_were_finished(drive):
    run = stopped(40, "exceedance", drive, "--count", "200", "--seed", "4", "--json")
    report, whole = json.loads(run.stdout), sw.exceedance(sw.read_project(drive), count=40, seed=4)
    assert report["drives"] == 40
    assert report["oscillation_rad"] == pytest.approx(whole.oscillation.tolist(), rel=1e-9)
    assert report["interval"] == pytest.approx(whole.interval)
    assert "interrupted; the result is that of the 40 drives that were finished, of 200; the same command" in run.stderr
    few = stopped(5, "exceedance", drive, "--count", "200")
    assert few.stdout == ""
    assert "5 of 200 drives were finished, and an answer needs 32: nothing is kept" in few.stderr


@pytest.mark.slow
def test_speed_map_is_that_of_the_loads_and_units_that_were_finished(drive, tmp_path):
    call = ["speed-map", drive, "--load-inertias", "0.8 kg*m^2:1.2 kg*m^2:5", "-o", tmp_path / "map", "--json"]
    run = stopped(1, *call)
    report = json.loads(run.stdout)
    assert len(report["loads"]) == 1
    assert "the map covers 1 of 5 loads and 0 of 0 units; the same" in run.stderr
    with (tmp_path / "map" / "cells.csv").open(encoding="utf-8") as table:
        assert {float(row["load_kg_m2"]) for row in csv.DictReader(table)} == {0.8}
    whole = sw.speed_map(from_text(PROJECT, drive), load_inertias=[0.8])
    np.testing.assert_allclose(report["loads"][0]["allowed_rpm"], whole.allowed[0] / RPM, rtol=1e-3)
    run = stopped(4, "speed-map", drive, "--units", "6", "-o", tmp_path / "units", "--json")
    assert json.loads(run.stdout)["units"] == 3
    assert "1 of 1 loads and 3 of 6 units" in run.stderr


@pytest.mark.slow
def test_a_comparison_is_that_of_the_projects_that_were_finished(drive, tmp_path):
    call = ["compare", drive, drive, drive, drive, "-o", tmp_path / "out", "--json"]
    run = stopped(2, *call)
    assert len(json.loads(run.stdout)["drives"]) == 2
    assert "the comparison covers the first 2 of 4 projects; the same command computes all again" in run.stderr
    assert (tmp_path / "out" / "comparison.html").is_file()
    run = stopped(1, *call[:-3], "-o", tmp_path / "none")
    assert "interrupted; nothing was written; run it again" in run.stderr
    assert not (tmp_path / "none").exists()


@pytest.mark.slow
def test_a_search_falls_back_on_averaging_for_what_harmonic_balance_had_not_reached(tmp_path):
    path = tmp_path / "joint.yaml"
    path.write_text(SPECIFICATION, encoding="utf-8")
    run = stopped("harmonic balance", "design", path, "-o", tmp_path / "out", "--json")
    data, whole = json.loads(run.stdout), sw.design(sw.read_specification(path))
    assert data["balanced"] < whole.balanced
    assert {d["method"] for d in data["feasible"]} >= {"averaging"}
    assert {d["gear"] for d in data["feasible"]} <= {c.gear for c in whole.feasible} | set(whole.rejected)
    assert any(remark.startswith("Interrupted: ") for remark in data["remarks"])
    assert "by harmonic balance, the others by averaging; the same command computes all again" in run.stderr
    assert json.loads((tmp_path / "out" / "design.json").read_text(encoding="utf-8")) == data


@pytest.mark.slow
@pytest.mark.skipif(WINDOWS, reason="no SIGINT can be sent to one other process there; raise_signal is used above")
def test_a_signal_from_outside_ends_a_long_command(drive):
    call = [sys.executable, "-m", "strainwave", "exceedance", str(drive), "--count", "5000"]
    env = os.environ | {"STRAINWAVE_JIT": "0"}
    run = subprocess.Popen(call, env=env, text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    assert "5000 drives" in run.stderr.readline()
    time.sleep(1.0)
    run.send_signal(signal.SIGINT)
    out, told = run.communicate(timeout=300.0)  # on a busy machine an answer of the finished drives takes minutes
    assert run.returncode == 130, told
    assert told.count("interrupted;") == 1
    assert ("drives exceed" in out) == ("the result is that of" in told)
    assert "Traceback" not in told


WRITING = """\
import sys, time
from pathlib import Path
from strainwave import __main__
from strainwave.app.commands import cli
from strainwave.app.console import staged

def writing():
    with staged(Path(sys.argv[1])) as part:
        (part / "half.txt").write_text("half", encoding="utf-8")
        print("writing", flush=True)
        time.sleep(60.0)

cli.main = writing
__main__.main()
"""


@pytest.mark.skipif(WINDOWS, reason="Windows ends a process without telling it")
def test_what_is_asked_to_end_leaves_no_half_written_folder(tmp_path):
    folder = tmp_path / "axis"
    with subprocess.Popen(
        [sys.executable, "-c", WRITING, str(folder)], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True
    ) as process:
        assert process.stdout.readline() == "writing\n"
        assert folder.is_dir()
        process.send_signal(signal.SIGTERM)
        process.wait(30.0)
    assert process.returncode != 0
    assert not folder.exists()
