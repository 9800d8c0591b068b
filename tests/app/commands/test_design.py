"""`strainwave design` and `strainwave compare`: what they print and write, and their complaints."""

import csv
import json

import pytest
from click.testing import CliRunner
from one_joint import SPECIFICATION
from twelve_projects import PROJECTS

import strainwave as sw
from strainwave.app.commands import cli as command


@pytest.fixture
def path(tmp_path):
    path = tmp_path / "joint.yaml"
    path.write_text(SPECIFICATION)
    return path


def invoke(*given):
    return CliRunner().invoke(command.cli, list(map(str, given)))


def rows(path):
    with path.open(newline="") as stream:
        return list(csv.DictReader(stream))


@pytest.mark.slow
def test_the_answer_is_written_and_its_projects_are_compared(path, tmp_path):
    out = tmp_path / "out"
    run = invoke("design", path, "-o", out, "--json")
    assert run.exit_code == 0, run.output
    data, found = json.loads(run.stdout), sw.design(sw.read_specification(path))
    assert [d["gear"] for d in data["feasible"]] == [c.gear for c in found.feasible]
    assert data["rejected"] == found.rejected
    assert json.loads((out / "design.json").read_text()) == data
    assert [row["gear"] for row in rows(out / "designs.csv")] == [c.gear for c in found.feasible]
    assert {row["gear"] for row in rows(out / "rejected.csv")} == set(found.rejected) | set(found.not_judged)
    assert data["not_judged"] == found.not_judged
    assert (out / "designs.svg").read_text().startswith("<svg")
    projects = sorted(out.glob("0*.yaml"))
    assert len(projects) == len(found.pareto) >= 2
    for file, c in zip(projects, found.pareto, strict=True):
        assert sw.read_project(file).gear.name == c.gear

    projects = projects[:2]
    run = invoke("compare", *projects, "-o", tmp_path / "compared", "--json")
    assert run.exit_code == 0, run.output
    drives = json.loads(run.stdout)["drives"]
    assert all("a hysteresis loss of" in note for note in json.loads(run.stdout)["remarks"])
    for drive, c in zip(drives, found.pareto[:2], strict=True):
        assert drive["oscillation_arcsec"] == pytest.approx(c.oscillation * 648000.0 / 3.141592653589793, rel=1e-3)
    assert len(rows(tmp_path / "compared" / "comparison.csv")) == len(projects)
    assert "CSG" in (tmp_path / "compared" / "comparison.svg").read_text()
    page = (tmp_path / "compared" / "comparison.html").read_text(encoding="utf-8")
    assert (tmp_path / "compared" / "comparison.svg").read_text(encoding="utf-8").strip() in page
    least = min(drives, key=lambda drive: drive["oscillation_arcsec"])
    assert f"<th>drive</th><th>{drives.index(least) + 1}: {least['title']}</th>" in page
    assert f"<td>gear</td><td>{least['gear']}</td>" in page
    assert ">limit</text>" in page
    count = len(drives)
    assert f"{count} of {count} drives pass at all their speeds" in page


@pytest.mark.slow
def test_without_a_design_the_summary_names_the_nearest(path, tmp_path):
    path.write_text(SPECIFICATION.replace("200 arcsec", "1 arcsec").replace("[1 kg*cm^2, 5 kg*cm^2]", "[5 kg*cm^2]"))
    run = invoke("design", path, "-o", tmp_path / "out")
    assert run.exit_code == 1, run.output
    assert "No gear meets the specification. The nearest is CSG-" in run.stdout
    assert not (tmp_path / "out" / "designs.svg").exists()


@pytest.mark.slow
def test_gears_of_a_file_are_judged_beside_the_catalogue_and_a_damping_above_one_is_doubted(path, tmp_path):
    gear = sw.catalogue.gear("CSG-40-50")
    numbers = ", ".join(f"{k}: {getattr(gear, k)!r} {'N*m' if k[0] == 'T' else 'N*m/rad'}" for k in gear.law._fields)
    limits = ", ".join(f"{k}: 1000 N*m" for k in ("average_torque", "repeated_peak_torque", "momentary_torque"))
    (tmp_path / "mine.yaml").write_text(
        f"gears: [{{name: MY-40-50, series: CSG, size: 40, ratio: 50, {numbers}, {limits}, max_speed: 4000 rpm, "
        "average_speed: 3000 rpm, input_inertia: 1 kg*cm^2, accuracy: 20 arcsec}]\n"
    )
    path.write_text(SPECIFICATION.replace("ratio: 3 %", "ratio: 3"))
    run = invoke("design", path, "--gears", tmp_path / "mine.yaml", "-o", tmp_path / "out")
    assert run.exit_code == 0, run.output
    assert "note: The damping ratio is 3 (300 % of critical)" in run.stdout
    first = sw.read_project(next((tmp_path / "out").glob("01-*.yaml")))
    assert first.gear.name == "MY-40-50"


@pytest.mark.slow
def test_a_rotor_with_another_unit_is_doubted_where_no_gear_serves_with_it(path, tmp_path):
    text = SPECIFICATION.replace("200 arcsec", "1 arcsec").replace("[1 kg*cm^2, 5 kg*cm^2]", "[1 kg*m^2, 5 kg*cm^2]")
    path.write_text(text)
    run = invoke("design", path, "-o", tmp_path / "out")
    assert run.exit_code == 1, run.output
    (said,) = (line for line in run.stdout.splitlines() if "note: A rotor of" in line)
    name = said.partition("wave generator of ")[2].partition(";")[0]
    times = 1.0 / sw.catalogue.gear(name).input_inertia
    assert (
        said.strip() == f"note: A rotor of 1 kg*m^2 is {times:.3g} times that of the "
        f"wave generator of {name}; check its unit."
    )


def test_a_wrong_specification_ends_with_its_place(path, tmp_path):
    path.write_text(SPECIFICATION.replace("200 arcsec", "200"))
    run = invoke("design", path, "-o", tmp_path / "out")
    assert run.exit_code == command.INVALID_PROJECT
    assert "joint.yaml:4:22: limit.oscillation: " in run.stderr
    assert not (tmp_path / "out").exists()


def test_one_project_is_none_to_compare(tmp_path):
    file = tmp_path / "axis.yaml"
    file.write_text(PROJECTS["catalogue gear, motor not named"])
    run = invoke("compare", file, "-o", tmp_path / "out")
    assert run.exit_code == command.FAILED
    assert "there are 1 projects; give 2 to 20 to compare" in run.stderr
