"""Scan files: read with explicit units, delimiter and decimal sign, and refused with file, line and remedy."""

import json
import math

import numpy as np
import pytest
from click.testing import CliRunner
from twelve_projects import PROJECTS

from strainwave.app.commands.cli import cli
from strainwave.files.logs.scan_file import read_scan
from strainwave.files.reading import read_project
from strainwave.files.yaml_text import FileError

ARCSEC = math.pi / 648_000.0
DEGREES = np.arange(0.0, 720.0, 2.0)


def error_at(degrees):
    """Order 2 of 23 arcsec at 17 deg, order 1 of 4 arcsec at -60 deg, in arcsec."""
    return 23.0 * np.cos(np.radians(2.0 * degrees + 17.0)) + 4.0 * np.cos(np.radians(degrees - 60.0))


def table(*columns, names, delimiter=",", decimal="."):
    rows = zip(*columns, strict=True)
    lines = [delimiter.join(f"{value:.6f}".replace(".", decimal) for value in row) for row in rows]
    return "\n".join([delimiter.join(names), *lines]) + "\n"


def written(tmp_path, text, name="scan.csv"):
    path = tmp_path / name
    path.write_text(text, encoding="utf-8")
    return path


def standard(noise=0.0):
    rng = np.random.default_rng(0)
    return error_at(DEGREES) + noise * rng.normal(size=len(DEGREES))


def test_a_scan_is_read_in_its_units(tmp_path):
    text = "# rig 3\n\n" + table(DEGREES, standard(), names=["angle [deg]", "error [arcsec]"])
    scan = read_scan(written(tmp_path, text))
    assert np.allclose(scan.angle, np.radians(DEGREES), rtol=1e-12)
    assert np.allclose(scan.error, standard() * ARCSEC, atol=1e-6 * ARCSEC)
    assert scan.backward is None
    assert scan.last == len(DEGREES) + 3


def test_a_german_table_is_read_whether_it_is_said_to_be_one_or_not(tmp_path):
    path = written(tmp_path, table(DEGREES, standard(), names=["Winkel", "Fehler"], delimiter=";", decimal=","))
    scan = read_scan(path, angle="Winkel [deg]", error="Fehler [arcsec]", delimiter=";", decimal=",")
    assert np.allclose(scan.error, standard() * ARCSEC, atol=1e-6 * ARCSEC)
    assert np.array_equal(read_scan(path, angle="Winkel [deg]", error="Fehler [arcsec]").error, scan.error)
    with pytest.raises(FileError, match=r"scan\.csv:1:1: file: names 1 columns .* give delimiter and decimal"):
        read_scan(path, angle="Winkel [deg]", error="Fehler [arcsec]", delimiter=",", decimal=".")


def test_the_vendors_error_has_the_opposite_sign(tmp_path):
    ours = read_scan(written(tmp_path, table(DEGREES, standard(), names=["angle [deg]", "error [arcsec]"])))
    theirs = read_scan(written(tmp_path, table(DEGREES, -standard(), names=["angle [deg]", "ate [arcsec]"])))
    asked = read_scan(
        written(tmp_path, table(DEGREES, -standard(), names=["angle [deg]", "dx"])), error="dx [arcsec]", ate=True
    )
    assert np.array_equal(ours.error, theirs.error)
    assert np.array_equal(ours.error, asked.error)


def test_the_way_back_may_be_a_column_or_a_file_whose_angles_descend(tmp_path):
    names = ["angle [deg]", "error [arcsec]", "backward [arcsec]"]
    both = read_scan(written(tmp_path, table(DEGREES, standard() + 3.0, standard() - 3.0, names=names)))
    back = read_scan(written(tmp_path, table(DEGREES[::-1], (standard() - 3.0)[::-1], names=names[:2])), reverse=True)
    assert np.array_equal(both.backward, back.error)
    assert np.array_equal(both.angle, back.angle)


@pytest.mark.parametrize("encoding", ["utf-8", "utf-16"])
def test_a_scan_is_read_as_instruments_write_it(tmp_path, encoding):
    above = "Rig 3, 2024-05-01\nOperator,,N. N.\nSize: 40 (ratio 50)\n\n"
    text = above + table(DEGREES, standard(), names=["angle (deg)", "error (arcsec)"])
    path = tmp_path / "scan.csv"
    path.write_bytes(text.encode(encoding))
    scan = read_scan(path)
    assert np.allclose(scan.angle, np.radians(DEGREES), rtol=1e-12)
    assert np.allclose(scan.error, standard() * ARCSEC, atol=1e-6 * ARCSEC)


def test_round_brackets_that_hold_no_unit_belong_to_the_name(tmp_path):
    path = written(tmp_path, table(DEGREES, standard(), names=["angle [deg]", "error (mean)"]))
    scan = read_scan(path, error="error (mean) [arcsec]")
    assert np.allclose(scan.error, standard() * ARCSEC, atol=1e-6 * ARCSEC)


def test_a_wrong_number_below_header_lines_has_the_line_of_the_file(tmp_path):
    with pytest.raises(FileError, match=r"scan\.csv:5:2: file: has 'x', which is no number"):
        read_scan(written(tmp_path, "rig,3\nsize\nangle [deg],error [arcsec]\n0,1\n1,x\n"))


GOOD = "angle [deg],error [arcsec]\n0,1\n1,2\n2,3\n"


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("", "1:1: file: is empty; give a scan file with a line for each sample"),
        ("angle [deg],error [arcsec]\n", "1:1: file: has no table of numbers"),
        ("angle,error [arcsec]\n0,1\n", "1:1: angle: column 'angle' has no unit"),
        ("angle [deg],error [Hz]\n0,1\n", "1:2: error: cannot convert 'Hz' to 'rad'"),
        ("angle [deg],error [parsec]\n0,1\n", "1:2: error: unknown unit 'parsec'"),
        (
            "phi [deg],error [arcsec]\n0,1\n",
            "1:1: file: has no single column 'angle' for angle; it has phi [deg], error [arcsec]; name the columns",
        ),
        ("angle [deg],error [arcsec]\n0,1\n", "1:2: error: column 'error' is in arcsec and was requested in arcmin"),
        (GOOD + "3\n", "5:1: file: has 1 cells where the first line of numbers has 2"),
        (GOOD + "3,nan\n", "5:2: error: is not a finite number; correct it or remove the line"),
        (GOOD + "3,0x10\n", "5:2: file: has '0x10', which is no number"),
        (GOOD + "2,4\n", "5:1: angle: 2 stands after 2 of line 4; angles must ascend: average repeated ones"),
    ],
)
def test_wrong_files_are_refused_at_their_line(tmp_path, text, complaint):
    with pytest.raises(FileError) as refusal:
        read_scan(written(tmp_path, text), error="error [arcmin]" if "requested" in complaint else None)
    assert str(refusal.value).startswith(f"{tmp_path / 'scan.csv'}:{complaint}")
    assert len(str(refusal.value).splitlines()) == 1


def test_files_that_are_none_are_refused(tmp_path):
    for name, words in ((".", "is a directory; give the scan file"), ("none.csv", "does not exist")):
        with pytest.raises(FileError, match=words):
            read_scan(tmp_path / name)
    (tmp_path / "binary.csv").write_bytes(b"angle\0error")
    with pytest.raises(FileError, match=r"is binary, not text; give a scan file$"):
        read_scan(tmp_path / "binary.csv")


def run(*arguments):
    return CliRunner().invoke(cli, ["order-scan", *map(str, arguments)])


def test_the_command_prints_lines_that_a_project_file_takes(tmp_path):
    path = written(tmp_path, table(DEGREES, standard(0.5), names=["angle [deg]", "error [arcsec]"]))
    done = run(path)
    assert done.exit_code == 0, done.output
    field = done.output.partition("for a project file:\n")[2]
    project = PROJECTS["catalogue gear, motor not named"].partition("excitation:")[0] + f"excitation:\n{field}"
    lines = read_project(written(tmp_path, project, "project.yaml")).kinematic_error.lines
    assert [line.order for line in lines] == [1, 2]
    assert lines[1].amplitude == pytest.approx(23.0 * ARCSEC, abs=0.2 * ARCSEC)
    assert lines[1].phase == pytest.approx(math.radians(17.0), abs=0.01)


@pytest.mark.parametrize(
    ("text", "arguments", "words"),
    [
        (GOOD.replace(",", ";").replace("2;3", "2;3,5"), [], "give delimiter and decimal"),
        (GOOD.replace("angle", "phi"), [], "or give --angle"),
        (GOOD, ["--backward", "way back [deg]"], "or give --angle, --error, --backward"),
        (GOOD + "1,2\n", [], "the way back is a file of its own (--back)"),
    ],
)
def test_complaints_of_the_command_name_its_options(tmp_path, text, arguments, words):
    done = run(written(tmp_path, text), *arguments)
    assert done.exit_code in (1, 3)
    assert words in done.stderr


def test_the_command_counts_on_the_turn_asked_for(tmp_path):
    # An output angle over 3.6 deg of a gear with ratio 100 is one turn of its wave generator.
    path = written(tmp_path, table(DEGREES / 100.0, standard(0.5), names=["angle [deg]", "error [arcsec]"]))
    done = run(path, "--shaft", "output", "--turn", "motor", "--ratio", 100, "--json")
    assert done.exit_code == 0, done.output
    data = json.loads(done.output)
    assert [line["order"] for line in data["lines"]] == [1, 2]
    assert data["turns"] == pytest.approx(2.0, rel=1e-6)
    short = run(path, "--shaft", "output")
    assert short.exit_code == 3
    assert f"scan.csv:{len(DEGREES) + 1}:1: angle: the angles reach over 0.02 turns" in short.stderr
    assert "add --ratio" in run(path, "--shaft", "output", "--turn", "motor").stderr


def test_the_command_gives_the_lost_motion_of_two_files(tmp_path):
    names = ["angle [deg]", "error [arcsec]"]
    forth = written(tmp_path, table(DEGREES, standard(0.5) + 3.0, names=names), "forth.csv")
    back = written(tmp_path, table(DEGREES[::-1], standard(0.5)[::-1] - 3.0, names=names), "back.csv")
    done = run(forth, "--back", back, "--orders", "1,2", "--json")
    assert done.exit_code == 0, done.output
    assert json.loads(done.output)["reversal"]["lost_motion"] == pytest.approx(6.0 * ARCSEC, rel=0.02)
    assert "lost motion" in run(forth, "--back", back).output


@pytest.mark.parametrize(
    ("arguments", "code", "words"),
    [
        (["--orders", "1;2"], 2, "write for example 100,200,202.5"),
        (["--orders", "400"], 3, "order 400 is too high for these samples"),
        (["--false-alarm", "2"], 3, "probability between 0 and 1"),
        (["--shaft", "load"], 2, "'load' is not one of"),
        (
            ["--rate", "100", "--shaft", "motor"],
            1,
            "--rate is for logs; a scan (angle and error without time)",
        ),
        (["other.csv", "--ate"], 1, "2 files are given; a scan (angle and error without time) is one file"),
    ],
)
def test_wrong_options_are_refused(tmp_path, arguments, code, words):
    path = written(tmp_path, table(DEGREES, standard(0.5), names=["angle [deg]", "error [arcsec]"]))
    done = run(path, *arguments)
    assert done.exit_code == code, done.output
    assert words in done.stderr


def test_columns_may_be_named_by_their_places(tmp_path):
    whole = written(tmp_path, table(DEGREES, standard(), names=["angle [deg]", "error [arcsec]"]))
    scan = read_scan(whole)
    bare = tmp_path / "bare.csv"
    bare.write_text("\n".join(whole.read_text().splitlines()[1:]))
    assert np.array_equal(read_scan(bare, angle="0 [deg]", error="1 [arcsec]").error, scan.error)
