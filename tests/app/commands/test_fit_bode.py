"""`strainwave fit-bode`: what it prints and writes, with the numbers of the library, and what it asks."""

import json
import re
from dataclasses import replace

import numpy as np
import pytest
from bode_machine import TRUE, plant
from click.testing import CliRunner

import strainwave as sw
from strainwave.app.commands.cli import cli

HZ = np.geomspace(3.0, 300.0, 60)
PROJECT = """
gear: {ratio: 100, law: {type: linear, K: 4e4 N*m/rad}}
motor: {inertia: 6 kg*cm^2, loop: {type: speed, bandwidth: 20 Hz, damping: 1}}
load: {inertia: 3.5 kg*m^2}
damping: {B: 60 N*m*s/rad}
speed: {from: 100 rad/s, to: 180 rad/s, shaft: motor}
excitation: {kinematic_error: [{order: 2, amplitude: 23 arcsec}]}
"""


@pytest.fixture
def files(tmp_path):
    value = plant(2.0 * np.pi * HZ)
    rows = np.column_stack([HZ, 20.0 * np.log10(np.abs(value)), np.degrees(np.angle(value))])
    names = {"units": "f [Hz],size [dB],phase [deg]", "none": "f,size [dB],phase [deg]"}
    for name, head in names.items():
        np.savetxt(tmp_path / f"{name}.csv", rows, delimiter=",", header=head, comments="")
    (tmp_path / "axis.yaml").write_text(PROJECT, encoding="utf-8")
    return tmp_path


def invoke(*given):
    return CliRunner().invoke(cli, ["fit-bode", *map(str, given)])


def test_the_command_prints_and_writes_the_numbers_of_the_library(files):
    run = invoke(files / "axis.yaml", files / "units.csv", "-o", files / "out", "--json")
    assert run.exit_code == 0, run.output
    data = json.loads(run.stdout)
    fit = sw.fit.fit_bode(sw.read_frd(files / "units.csv"), sw.read_project(files / "axis.yaml"))
    assert {row["name"]: row["value"] for row in data["numbers"]} == pytest.approx(fit.values)
    assert fit.values["K"] == pytest.approx(TRUE["K"], rel=1e-6)
    assert json.loads((files / "out" / "bode.json").read_text()) == data
    assert len((files / "out" / "bode.csv").read_text().splitlines()) == 61
    assert "<svg" in (files / "out" / "bode.svg").read_text()


def test_a_comparison_alone_and_what_is_not_clear_in_options(files):
    run = invoke(files / "axis.yaml", files / "none.csv", "--unit", "frequency=Hz", "--free", "")
    assert run.exit_code == 0, run.output
    assert "drive: off by" in run.stdout
    assert "number " not in run.stdout
    run = invoke(files / "axis.yaml", files / "none.csv")
    assert run.exit_code == 3
    assert "is it Hz or rad/s? --unit frequency=Hz" in run.output


def test_the_measured_loop_is_judged_beside_the_fit(files):
    s = 2j * np.pi * HZ
    loop = 0.2 * (1.0 + 1.0 / (0.016 * s)) * plant(2.0 * np.pi * HZ)
    rows = np.column_stack([HZ, 20.0 * np.log10(np.abs(loop)), np.degrees(np.angle(loop))])
    np.savetxt(files / "loop.csv", rows, delimiter=",", header="f [Hz],size [dB],phase [deg]", comments="")
    given = files / "axis.yaml", files / "loop.csv", "--quantity", "open loop", "--free", "", "--margins"
    data = json.loads(invoke(*given, "--json").stdout)["margins"]
    own = sw.read_frd(files / "loop.csv", quantity="open loop").margins()
    assert data["phase_margin_deg"] == pytest.approx(np.degrees(own.margins.phase_margin))
    assert data["peak_sensitivity"] == pytest.approx(own.margins.peak_sensitivity)
    said = invoke(*given).stdout
    assert f"peak sensitivity: {own.margins.peak_sensitivity:.4g} at " in said
    assert f"the measured loop is {'stable' if own.margins.stable else 'unstable'}, if" in said
    refused = invoke(files / "axis.yaml", files / "units.csv", "--margins")
    assert refused.exit_code == 1
    assert "it is that of the plant alone" in refused.output


def test_the_blocks_to_paste_are_the_numbers_fitted_with_their_source(files):
    run = invoke(files / "axis.yaml", files / "units.csv")
    blocks = run.stdout.partition("lines for the groups of a project file:\n")[2]
    blocks = blocks.replace("kg*m^2}", "kg*m^2, loop: {type: speed, bandwidth: 20 Hz, damping: 1}}", 1)  # of the motor
    kept = [line for line in PROJECT.splitlines() if line.split(":")[0] in ("speed", "excitation")]
    (files / "pasted.yaml").write_text("\n".join([*kept, blocks]), encoding="utf-8")
    pasted = sw.read_project(files / "pasted.yaml")
    fit = sw.fit.fit_bode(sw.read_frd(files / "units.csv"), sw.read_project(files / "axis.yaml"))
    train = pasted.train
    found = {"J_m": train.motor.J, "J_l": train.load.J, "K": train.law.K, "B": train.B}
    assert train.N == 100.0
    assert found == {name: fit.values[name] for name in found}
    words = {source.name: source.word for source in pasted.sources}
    ratio = re.search(r"ratio: ([\d.]+)", replace(fit, ratio=1102 / 7).yaml)  # of 1102 and 7 teeth
    assert float(ratio[1]) == pytest.approx(1102 / 7, rel=1e-14)
    assert {words[name] for name in ("motor.inertia", "load.inertia", "gear.law.K", "damping.B")} == {"measured"}
