"""`strainwave fit-loop`: what it prints and writes, with the numbers of the library, and its complaints."""

import json
import math

import numpy as np
import pytest
from click.testing import CliRunner
from loop_machines import loop

import strainwave as sw
from strainwave.app.commands.cli import cli
from strainwave.app.commands.identification.scans import project_lines
from strainwave.files.reading import from_text

ARCMIN = math.pi / 10800.0
X, T = loop(samples=500)
T = T + 0.2 * np.random.default_rng(0).normal(size=len(T))


def invoke(*given):
    return CliRunner().invoke(cli, ["fit-loop", *map(str, given)])


def write(path, head="torsion [arcmin],torque [N*m]", x=X / ARCMIN, t=T, form="{:.9g},{:.9g}"):
    rows = [form.format(a, b) for a, b in zip(x, t, strict=True)]
    path.write_text("\n".join([head, *rows]) + "\n", encoding="utf-8")
    return path


def test_the_command_prints_and_writes_the_numbers_of_the_library(tmp_path):
    file, out = write(tmp_path / "loop.csv"), tmp_path / "out"
    run = invoke(file, "--rated-torque", "87 N*m", "--ratio", "100", "-o", out, "--json")
    assert run.exit_code == 0, run.output
    data = json.loads(run.stdout)
    fit = sw.fit_loop(X, T, rated_torque=87.0, ratio=100)
    for name, value in fit.values.items():
        assert data["numbers"][name]["value"] == pytest.approx(value, rel=1e-4, abs=1e-9)
    assert {path.name for path in out.iterdir()} == {"loop.svg", "loop.csv", "loop.json", "gear.yaml"}
    assert json.loads((out / "loop.json").read_text()) == data
    assert (out / "gear.yaml").read_text() == data["project"]
    assert len((out / "loop.csv").read_text().splitlines()) == 501
    assert "<svg" in (out / "loop.svg").read_text()


def test_the_block_calls_its_numbers_measured_in_a_project_file(tmp_path):
    block = sw.fit_loop(X, T, rated_torque=87.0, ratio=100).yaml
    rest = "title: x\nmotor: {inertia: 1 kg*cm^2, mode: held}\nload: {inertia: 1 kg*m^2}\ndamping: {ratio: 3 %}\n"
    rest += "speed: {from: 500 rpm, to: 900 rpm, shaft: motor}\nexcitation:\n"
    rest += project_lines([sw.Line(2, 1e-4, 0.3)]).replace("sources: {", (measured := "sources: {")) + "\n"
    text = rest.replace(measured, block[block.index(measured) : -2] + ", ") + block[: block.index(measured)]
    words = {one.name: one.word for one in from_text(text, tmp_path / "project.yaml").sources}
    numbers = [name for name in words if name.startswith(("gear.law", "hysteresis", "excitation.kinematic_error"))]
    assert len(numbers) > 8
    assert {words[name] for name in numbers} == {"measured"}
    assert words["load.inertia"] == "yours"


def test_the_text_has_the_numbers_the_candidates_and_the_block(tmp_path):
    run = invoke(write(tmp_path / "loop.csv"))
    assert run.exit_code == 0, run.output
    for part in (
        "K1",
        "N·m/rad",
        "95 % intervals",
        "three slopes, Bouc-Wen n = 1",
        "taken",
        "gear: {law:",
        "dissipate",
    ):
        assert part in run.stdout
    assert "give rated_torque for those of a datasheet" in run.stdout


def test_columns_and_signs_can_be_named(tmp_path):
    file = write(tmp_path / "messung.csv", "Moment [N*m];Winkel [mrad]", T, 1e3 * X, "{:.9g};{:.9g}")
    file.write_text(file.read_text().replace(".", ","))
    run = invoke(file, "--torsion", "Winkel", "--torque", "Moment", "--delimiter", ";", "--decimal", ",", "--json")
    assert run.exit_code == 0, run.output
    assert json.loads(run.stdout)["numbers"]["K1"]["value"] == pytest.approx(sw.fit_loop(X, T).value("K1"), rel=1e-4)


def test_lack_of_fit_comes_first_and_is_in_the_numbers(tmp_path):
    torque = np.where(T < 0.0, 0.9 * T, T)
    file = write(tmp_path / "loop.csv", t=torque)
    run, plain = invoke(file, "--json"), invoke(file)
    lack, expected = json.loads(run.stdout)["lack_of_fit"], sw.fit_loop(X, torque).lack_of_fit
    assert lack["found"] is True
    assert lack["missed_N_m"] == pytest.approx(expected.missed, rel=1e-3)
    assert plain.stdout.startswith("loop.csv\nthe law does not fit: it misses the torque along the loop by")
    right = json.loads(invoke(write(tmp_path / "right.csv"), "--json").stdout)["lack_of_fit"]
    assert right["found"] is False
    assert right["noise_N_m"] == pytest.approx(0.2, rel=0.15)


@pytest.mark.parametrize(
    ("head", "x", "t", "sentence"),
    [
        ("angle [deg],torque [N*m]", X, T, "torsion"),
        ("torsion [N],torque [N*m]", X, T, "'N'"),
        ("torsion [rad],torque [N*m]", X[:30], T[:30], "give one column of at least 40 samples"),
        ("torsion [rad],torque [N*m]", np.degrees(X), T, "likely in degrees"),
        ("torsion [rad],torque [N*m]", X, -T, "the torque falls with the torsion"),
    ],
)
def test_a_wrong_file_is_refused_in_one_sentence(tmp_path, head, x, t, sentence):
    file, out = write(tmp_path / "loop.csv", head, x, t), tmp_path / "out"
    run = invoke(file, "-o", out)
    assert run.exit_code == 3
    assert sentence in run.stderr
    assert "loop.csv:" in run.stderr
    assert "Traceback" not in run.stderr
    assert not out.exists()


def test_the_figure_has_both_loops_and_the_residual_below():
    upper, lower = sw.fit_loop(X, T).panels()
    assert [curve.label for curve in (*upper.curves, *lower.curves)] == ["measured", "fitted", "residual"]
    assert upper.curves[0].y - upper.curves[1].y == pytest.approx(lower.curves[0].y)
    assert "N·m rms" in lower.title


def test_a_time_and_a_missing_value_are_no_hindrance(tmp_path):
    rows = [f"{0.01 * i:.9g};{x:.9g};{t:.9g}" for i, (x, t) in enumerate(zip(X, T, strict=True))]
    rows[7] = rows[7].rpartition(";")[0] + ";nan"
    file = tmp_path / "loop.csv"
    file.write_text("\n".join(["time [s];torsion [rad];torque [N*m]", *rows]) + "\n")
    run = invoke(file, "--json")
    assert run.exit_code == 0, run.output
    data = json.loads(run.stdout)
    assert data["samples"] == 499
    assert any("semicolons" in remark for remark in data["remarks"])
