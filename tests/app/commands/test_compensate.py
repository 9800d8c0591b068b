"""`strainwave compensate`: the numbers of the library as tables, files and JSON; speeds, names, and being stopped."""

import csv
import json
import math
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from turntable import PROJECT

import strainwave as sw
from strainwave.app.commands import cli as command
from strainwave.app.commands.compensation import compensate as module
from strainwave.app.commands.compensation.order_tables import tables_of
from strainwave.study.compensation.gains import amplitudes_of

RPM, ARCSEC = math.pi / 30.0, math.pi / 648_000.0


def invoke(*given):
    return CliRunner().invoke(command.cli, ["compensate", *map(str, given)])


@pytest.mark.slow
def test_the_command_writes_and_prints_the_numbers_of_the_library(drive, tmp_path):
    out = tmp_path / "out"
    run = invoke(drive, "--controller", "inverse", "--speed", "600 rpm", "--units", 2, "-o", out, "--json")
    assert run.exit_code == 0, run.output
    data = json.loads(run.stdout)
    one = sw.compensate(sw.read_project(drive), "inverse", speed=600.0 * RPM, units=2)
    row = data["results"][1]
    assert row["controller"] == "inverse"
    assert row["motor_speed_rpm"] == pytest.approx(600.0)
    assert row["rms_before_arcsec"] * ARCSEC == pytest.approx(one.before.rms, rel=1e-9)
    assert row["rms_after_arcsec"] * ARCSEC == pytest.approx(one.after.rms, rel=1e-9)
    assert row["reduction_dB"] == pytest.approx(20.0 * math.log10(one.before.rms / one.after.rms), rel=1e-9)
    assert row["motor_torque_peak_N_m"] == pytest.approx(one.torque.peak, rel=1e-9)
    gears = [(r["stiffness"], r["rms_after_arcsec"] * ARCSEC) for r in data["details"][0]["other_gears"]]
    assert gears == [(r.stiffness, pytest.approx(r.after, rel=1e-9)) for r in one.robustness]
    assert data["details"][0]["units"]["rms_after_arcsec"][1] * ARCSEC == pytest.approx(
        np.median(one.units.after.rms), rel=1e-9
    )
    assert data["sampling"]["torque_limit_N_m"] == 5.0
    assert json.loads((out / "compensation.json").read_text()) == data
    table = list(csv.DictReader((out / "compensation.csv").read_text().splitlines()))
    assert [line["controller"] for line in table] == ["loop", "inverse"]
    assert float(table[1]["rms_after_arcsec"]) == pytest.approx(row["rms_after_arcsec"], rel=1e-6)
    for name in ("speeds", "error", "orders", "units"):
        assert (out / f"{name}.svg").read_text().startswith("<svg")
    written = sw.OrderTable.read(out / "order-table-angle.json")  # what `inverse` adds is the error itself
    assert [(line.order, line.amplitude) for line in written.lines] == [
        (1, pytest.approx(2.0 * ARCSEC)), (2, pytest.approx(20.0 * ARCSEC)),
    ]  # fmt: skip
    assert written.unit == "rad"
    assert not (out / "speeds-load-encoder.svg").exists()  # no controller of these measures the load


@pytest.mark.slow
def test_the_tables_fit_a_terminal_of_80_columns_and_name_the_best(drive):
    run = invoke(drive, "--controller", "inverse", "--controller", "angle", "--speed", "600 rpm", "--softer", "20 %")
    assert run.exit_code == 0, run.output
    lines = run.stdout.splitlines()
    assert max(map(len, lines)) <= 80
    assert lines[0] == "Turntable: rms pointing error about its mean, at the sampling times [arcsec]"
    assert [line.split()[0] for line in lines[1:5]] == ["motor", "loop", "inverse", "angle"]
    assert any(line.split()[:2] == ["inverse", "600"] for line in lines)
    assert "drive.yaml" not in run.stderr


def test_five_speeds_are_about_the_resonance_and_within_those_of_the_file(drive):
    project = sw.read_project(drive)
    resonance = math.sqrt(2e4 / 0.8) / 2.0  # order 2, motor held
    wanted = np.array([0.9, 1.0, 1.1]) * resonance
    np.testing.assert_allclose(module.speeds_of(project), [300.0 * RPM, *wanted, 1200.0 * RPM], rtol=1e-12)
    np.testing.assert_allclose(module.speeds_of(project, ["9 rad/s", "60 rpm"]), [60.0 * RPM, 9.0], rtol=1e-12)


def test_without_an_encoder_on_the_load_its_controllers_are_left_out(drive):
    project = sw.read_project(drive)
    bench = module.bench_of(project, sampling=project.sampling._replace(load_encoder=0))
    names, said = module.names_of(bench, ["all"])
    assert names == [name for name, design in sw.study.COMPENSATORS.items() if not design.load_encoder]
    assert said == (
        "Omitted, because the load has no encoder: measured-table, adaptive, adaptive-inverse, repetitive.",
    )
    with pytest.raises(ValueError, match=r"adaptive requires an encoder on the load, and the project has none"):
        module.names_of(bench, ["adaptive"])
    assert module.names_of(bench, ["inverse", "inverse"]) == (["loop", "inverse"], ())


def test_a_softer_drive_has_less_torque_at_every_torsion(drive):
    plant = module.plant_of(sw.read_project(drive), None, "20 %")
    assert plant.law == sw.Linear(pytest.approx(1.6e4, rel=1e-12))
    assert module.plant_of(sw.read_project(drive), drive, None).law == sw.Linear(2e4)


@pytest.mark.slow
def test_a_run_that_is_stopped_keeps_the_controllers_that_are_finished(drive, tmp_path, monkeypatch):
    done = []

    def stopped(project, names, **given):
        if names == ["inverse"]:
            raise KeyboardInterrupt
        done.append(names[0])
        return sw.study.compensation_bench(project, names, **given)

    monkeypatch.setattr(module, "compensation_bench", stopped)
    out = tmp_path / "out"
    asked = ("--controller", "angle", "--controller", "inverse", "--speed", "600 rpm")
    run = invoke(drive, *asked, "-o", out)
    assert run.exit_code == 130
    assert done == ["loop", "angle"]
    assert "interrupted; kept: loop, angle" in run.stderr
    rows = csv.DictReader((out / "compensation.csv").read_text().splitlines())
    assert [row["controller"] for row in rows] == ["loop", "angle"]
    monkeypatch.setattr(module, "compensation_bench", lambda *_, **__: (_ for _ in ()).throw(KeyboardInterrupt))
    run = invoke(drive, *asked, "-o", tmp_path / "none")
    assert run.exit_code == 130
    assert "interrupted; nothing was finished" in run.stderr
    assert not (tmp_path / "none").exists()


@pytest.mark.slow
@pytest.mark.parametrize("way", [1.0, -1.0])
def test_the_order_table_of_what_adapts_is_the_torque_that_cancels_the_error(drive, tmp_path, way):
    drive.write_text(PROJECT.replace("excitation: {", "excitation: {load_torque: {mean: -3 N*m}, "))
    project, speed = sw.read_project(drive), 600.0 * RPM
    bench = module.bench_of(project)
    found = sw.compensate(project, "adaptive", speed=way * speed, robust=False)
    assert found.reduction > 20.0
    tables_of(bench, found)["torque"].write(tmp_path / "torque.json")
    table = sw.OrderTable.read(tmp_path / "torque.json")
    assert table.speeds == (speed, speed)
    assert table.direction == ("forward" if way > 0 else "backward")
    assert table.load == -3.0
    # Independent of any adaptation: the measured error over the loop's linear response, which turns the other way round
    # along the angle in backward motion
    G = bench.response(way * speed).error_of_torque
    lines = -amplitudes_of(bench, way * speed, model=True) / (G if way > 0 else G.conj())
    back = table.value(np.array([0.1, 0.7]), -way * speed)
    assert np.all(back == 0.0)
    assert [line.order for line in table.lines] == [1, 2]
    for line, torque in zip(table.lines, lines, strict=True):
        assert line.amplitude * np.exp(1j * line.phase) == pytest.approx(torque, rel=0.02)


@pytest.mark.slow
def test_the_worst_angle_of_the_load_counts(drive):
    gravity = "load: {inertia: 0.8 kg*m^2, drag: {type: angle_torque, amplitude: 12 N*m}}"
    drive.write_text(PROJECT.replace("load: {inertia: 0.8 kg*m^2}", gravity).replace("linear, K: 2e4", "cubic, K: 2e4")
                    .replace("N*m/rad}}", "N*m/rad, alpha: 5e5 1/rad^2}}"))  # fmt: skip
    asked = ("--controller", "inverse", "--speed", "600 rpm", "--load-angle", "0 deg", "--load-angle", "90 deg")
    run = invoke(drive, *asked, "--json")
    assert run.exit_code == 0, run.output
    own = sw.compensate(
        sw.read_project(drive), "inverse", speed=600.0 * RPM, load_angles=(0.0, math.pi / 2.0), robust=False
    )
    row = json.loads(run.stdout)["results"][1]
    assert row["rms_after_arcsec"] * ARCSEC == pytest.approx(own.after.rms, rel=1e-9)


WRONG = [
    (("--controller", "magic"), 1, "there is no controller 'magic'; there are loop, angle, inverse"),
    (("--speed", "450"), 1, "'450' has no unit"),
    (("--speed", "8000 rpm"), 1, "samples every 2 ms are too slow for order 2 at 8000 rpm"),
    (("--softer", "120 %"), 2, "is not between -100 % and 100 %"),
    (("--softer", "20 %", "--plant", "drive.yaml"), 2, "use one of them"),
    (("--plant", "gone.yaml"), 3, "gone.yaml:1:1: file: does not exist"),
]


@pytest.mark.parametrize(("given", "code", "said"), WRONG)
def test_a_wrong_command_ends_with_one_sentence_and_writes_nothing(drive, tmp_path, monkeypatch, given, code, said):
    monkeypatch.chdir(tmp_path)
    run = invoke(drive, *given, "-o", tmp_path / "out")
    assert run.exit_code == code
    assert said in " ".join(run.stderr.replace("│", " ").split())
    assert "Traceback" not in run.output
    assert not (tmp_path / "out").exists()


def test_an_error_equation_whose_motor_is_held_is_refused(tmp_path):
    drive = tmp_path / "held.yaml"
    article = Path(__file__).parents[3] / "examples/projects/article.yaml"
    drive.write_text(article.read_text().replace("mode: free", "mode: held").replace("motor_torque", "load_torque"))
    run = invoke(drive)
    assert run.exit_code == 1
    assert "is held: motor torque does not change the error; write 'mode: free'" in run.stderr
