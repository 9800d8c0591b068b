"""Gears of one's own: a file with units becomes records, and every problem of a file is one line with its place."""

import json
from pathlib import Path

import pytest
from click.testing import CliRunner
from twelve_projects import PROJECTS

import strainwave as sw
from strainwave.app.commands.cli import cli
from strainwave.files.reading import ProjectError, read_project
from strainwave.files.yaml_text import FileError

YAML = """\
gears:
  - name: MY-40-50
    series: MY
    size: 40
    ratio: 50
    K1: 10e4 N*m/rad
    K2: 14e4 N*m/rad
    K3: 18e4 N*m/rad
    T1: 54 N*m
    T2: 196 N*m
    average_torque: 255 N*m
    repeated_peak_torque: 523 N*m
    max_speed: 4000 rpm
    input_inertia: 4.5 kg*cm^2
    lost_motion: 1 arcmin
    efficiency: 77 %
    pitch_radius: 50.8 mm
    mass: 3500 g
  - {name: MY-40-51, ratio: 51, K1: 1e5 N*m/rad, K2: 1.4e5 N*m/rad, K3: 1.8e5 N*m/rad, T1: 54 N*m, T2: 196 N*m}
"""
CSV = """\
name,ratio,K1 [N*m/rad],K2 [N*m/rad],K3 [N*m/rad],T1 [N*m],T2 [N*m],max_speed,input_inertia [kg*cm^2],source
MY-40-50,50,1e5,1.4e5,1.8e5,54,196,4000 rpm,4.5,"a datasheet, 2024"
MY-40-51,51,1e5,1.4e5,1.8e5,54,196,,,
"""


@pytest.fixture
def written(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)

    def write(text, name="gears.yaml"):
        Path(name).write_text(text, encoding="utf-8")
        return name

    return write


def complaint(path) -> list[str]:
    with pytest.raises(FileError) as refusal:
        sw.read_gears(path)
    return str(refusal.value).splitlines()


def test_a_yaml_file_becomes_records_in_si(written):
    gears = sw.read_gears(written(YAML))
    assert list(gears) == ["MY-40-50", "MY-40-51"]
    gear = gears["MY-40-50"]
    assert gear.law == sw.catalogue.gear("CSG-40-50").law
    assert (gear.series, gear.size, gear.ratio, gear.max_rpm, gear.source) == ("MY", 40, 50, 4000.0, "gears.yaml")
    assert (gear.input_inertia, gear.efficiency, gear.pitch_radius, gear.mass) == (4.5e-4, 0.77, 0.0508, 3.5)
    assert gear.lost_motion == pytest.approx(2.908882e-4, rel=1e-6)
    assert (gears["MY-40-51"].size, gears["MY-40-51"].rated_torque) == (None, None)


def test_a_csv_file_takes_its_units_from_the_cell_or_the_column(written):
    gears = sw.read_gears(written(CSV, "gears.csv"))
    gear = gears["MY-40-50"]
    assert gear.law == sw.catalogue.gear("CSG-40-50").law
    assert (gear.max_rpm, gear.input_inertia, gear.source) == (4000.0, 4.5e-4, "a datasheet, 2024")
    assert (gears["MY-40-51"].max_rpm, gears["MY-40-51"].source) == (None, "gears.csv")


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("54 N*m\n", "540 N*m\n", "9:9: gears[0].T1: T1 is 540 and T2 is 196 N*m; the first slope must end below"),
        ("K3: 18e4 N*m/rad", "K3: -18e4 N*m/rad", "8:9: gears[0].K3: K3 is -180000 N*m/rad; it must be positive"),
        (
            "255 N*m",
            "600 N*m",
            "11:21: gears[0].average_torque: average_torque is 600 N*m, above repeated_peak_torque, 523",
        ),
        (
            "MY-40-51,",
            "MY-40-50,",
            "19:12: gears[1].name: 'MY-40-50' appears twice, first in line 2; remove one or rename it",
        ),
        ("    K1: 10e4 N*m/rad\n", "", "2:5: gears[0].K1: is missing; write it, for example 7160 N*m/rad"),
        ("77 %", "1.2", "16:17: gears[0].efficiency: efficiency is 1.2; it must be at most 1 (100 %)"),
        ("series: MY", "serie: MY", "3:5: gears[0].serie: unknown field; did you mean 'series'?"),
        ("series: MY", "series: " + "M" * 61, "3:13: gears[0].series: 'MMM"),
    ],
)
def test_what_is_wrong_with_a_gear_is_one_line_with_its_place(written, old, new, said):
    assert old in YAML
    (line,) = complaint(written(YAML.replace(old, new, 1)))
    assert line.startswith(f"gears.yaml:{said}")


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("1e5", "-1e5", "gears.csv:2:3: K1: K1 is -100000 N*m/rad; it must be positive"),
        (
            "MY-40-51",
            "MY-40-50",
            "gears.csv:3:1: name: 'MY-40-50' appears twice, first in line 2; remove one or rename it",
        ),
        (
            "1e5",
            "1e5 N*m/rad",
            "gears.csv:2:3: K1: '1e5 N*m/rad' has a unit, and line 1 gives the unit N*m/rad for the column",
        ),
        (",,,", ",,", "gears.csv:3:1: file: has 9 cells where line 1 names 10 columns"),
        (",ratio", ",name", "gears.csv:1:1: name: is the name of two columns; remove one"),
        ('"a', 'a"', "gears.csv:2:1: file: has 11 cells"),
    ],
)
def test_what_is_wrong_with_a_line_of_csv_is_said_with_its_place(written, old, new, said):
    lines = complaint(written(CSV.replace(old, new, 1), "gears.csv"))
    assert any(line.startswith(said) for line in lines), lines


@pytest.mark.parametrize(
    ("name", "text", "said"),
    [
        ("gears.yaml", "", "is empty; begin with a line such as 'gears: [{name: MY-40-50"),
        ("gears.yaml", "gears: []", "has 0 items; write at least 1"),
        ("gears.yaml", "gears: [50]", "gears[0]: '50' is not a group of fields; write for example {name: MY-40-50"),
        ("gears.yaml", "gears: 3", "gears: '3' is not a list; write for example 'gears: [{name: MY-40-50"),
        ("gears.yaml", "gears: *x", "is an alias"),
        ("gears.csv", "", "has 0 lines"),
        ("gears.csv", "name;ratio\nA;50\n", "has one column; separate the columns by commas"),
        ("gears.csv", 'name,ratio\n"A,50\n', "is not CSV"),
    ],
)
def test_a_file_without_gears_is_refused(written, name, text, said):
    assert any(said in line for line in complaint(written(text, name)))


def test_a_file_that_is_not_there_is_said():
    assert "does not exist" in complaint("no/such.yaml")[0]


OWN = "{file: gears.yaml, name: MY-40-50}"
PROJECT = PROJECTS["catalogue gear, motor not named"].replace("CSG-40-50", OWN)


def test_a_project_may_take_a_gear_of_ones_own(written):
    written(YAML)
    project = read_project(written(PROJECT, "project.yaml"))
    assert project.gear == sw.read_gears("gears.yaml")["MY-40-50"]
    assert (project.drive.N, project.drive.J_m) == (50.0, 4.5e-4)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("-50}", "-52}", "project.yaml:1:32: gear.name: gears.yaml has no gear 'MY-40-52'; it has MY-40-50"),
        ("-50}", "-51}", "project.yaml:1:1: motor.inertia: is missing, and MY-40-51 has no known value"),
        ("gears.yaml", "../gears.yaml", "project.yaml:1:14: gear.file: '../gears.yaml' is no plain file name"),
        (", name: MY-40-50", "", "project.yaml:1:7: gear.name: is missing"),
        ("gears.yaml", "wrong.yaml", "wrong.yaml:9:9: gears[0].T1: '54 N' is not a torque"),
        ("gears.yaml", "absent.yaml", "absent.yaml:1:1: file: does not exist"),
        (OWN, "RT1-H-CS-14-100", "project.yaml:1:7: gear: RT1-H-CS-14-100 has no"),
    ],
)
def test_a_project_with_a_gear_that_does_not_serve_says_why(written, old, new, said):
    written(YAML)
    written(YAML.replace("54 N*m", "54 N", 1), "wrong.yaml")
    with pytest.raises(ProjectError) as refusal:
        read_project(written(PROJECT.replace(old, new), "project.yaml"))
    assert str(refusal.value).startswith(said)


def test_the_command_lists_and_shows_ones_own_gears(written):
    file = written(YAML)
    run = CliRunner().invoke
    none = run(cli, ["catalogue", "--file", file, "--torque", "1 N*m", "--json"])  # no rated torque is given
    assert (none.exit_code, none.stdout) == (1, "")
    assert "no gear of gears.yaml meets all conditions; searched: 2 gears" in none.stderr
    listed = json.loads(run(cli, ["catalogue", "--file", file, "--stiffness", "9e4 N*m/rad", "--json"]).output)
    assert [g["name"] for g in listed["gears"]] == ["MY-40-50", "MY-40-51"]
    assert "lost_motion" in run(cli, ["catalogue", "MY-40-50", "--file", file]).output
    unknown = run(cli, ["catalogue", "MY-1", "--file", file])
    assert (unknown.exit_code, unknown.stdout) == (1, "")
    wrong = run(cli, ["catalogue", "--file", written(YAML.replace("54 N*m", "54 m"), "bad.yaml")])
    assert (wrong.exit_code, wrong.stdout, len(wrong.stderr.splitlines())) == (3, "", 2)


def test_the_command_filters_by_quantities_with_units():
    run = CliRunner().invoke
    options = ["catalogue", "--torque", "300 N*m", "--speed", "4000 rpm", "--json"]
    found = json.loads(run(cli, options).output)["gears"]
    assert {g["size"] for g in found} == {40}
    assert all(g["rated_torque"] >= 300.0 and g["max_rpm"] >= 4000.0 for g in found)
    wrong = run(cli, ["catalogue", "--stiffness", "1e5 N*m"])
    assert (wrong.exit_code, wrong.stdout) == (2, "")
    assert "--stiffness: '1e5 N*m' is not per radian" in wrong.stderr


def test_numbers_far_from_those_of_the_catalogue_are_doubted_wherever_the_gear_is_used(tmp_path):
    assert [slip for name in sw.catalogue.names() for slip in sw.catalogue.gear(name).slips()] == []
    path = tmp_path / "gears.yaml"
    law = "K2: 5e4 N*m/rad, T1: 14 N*m, T2: 48 N*m, ratio: 100"
    rows = (
        "name: A, K1: 9.2 N*m/rad, K3: 57 kN*m/rad, accuracy: 60 arcmin, hysteresis_loss: 1 deg",
        "name: B, K1: 3.1e4 N*m/rad, K3: 57e4 N*m/rad, input_inertia: 0.413 kg*m^2",
        "name: C, K1: 3.1e4 N*m/rad, K3: 57 kN*m/rad, input_inertia: 0.413 kg*cm^2, accuracy: 1 arcmin",
    )
    path.write_text("gears:\n" + "".join(f"  - {{{row}, {law}}}\n" for row in rows))
    gears = sw.read_gears(path)
    doubtful = {name: [field for field, _ in gear.doubts] for name, gear in gears.items()}
    assert doubtful == {"A": ["K1", "K2", "accuracy", "hysteresis_loss"], "B": ["K3", "input_inertia"], "C": []}
    said = "A: accuracy is 0.01745 rad (3600 arcsec), 30.1 times the largest that gears of the catalogue have beside "
    assert gears["A"].doubts[2][1] == f"{said}their other numbers; check its unit."
    text = PROJECTS["catalogue gear, motor not named"].replace("gear: CSG-40-50", "gear: {file: gears.yaml, name: B}")
    (tmp_path / "axis.yaml").write_text(text)
    assert any("K3 is 5.7e+05 N*m/rad" in note for note in read_project(tmp_path / "axis.yaml").notes)
