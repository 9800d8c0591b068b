"""`strainwave sweep` over the numbers of a project file follows the whole drive."""

import json
import math
import subprocess
import sys

import click
import pytest
from click.testing import CliRunner
from twelve_projects import PROJECTS

from strainwave.app.commands import cli as command
from strainwave.app.commands.sweeps.project_sweep import axis
from strainwave.files.reading import read_project
from strainwave.files.variants.replaced import replaced

PROJECT = PROJECTS["catalogue gear, motor not named"]


def invoke(path, *options):
    return CliRunner().invoke(command.cli, ["sweep", str(path), *options, "-o", str(path.parent / "store")])


def test_ranges_and_names_become_values_of_the_file():
    assert axis("load.inertia=1 kg*m^2:2 kg*m^2:3") == ("load.inertia", ["1 kg*m^2", "1.5 kg*m^2", "2 kg*m^2"])
    assert axis("loop.bandwidth = 4 : 9 Hz : 2 : log") == ("loop.bandwidth", ["4 Hz", "9 Hz"])
    assert axis("gear=CSG-40-50, SHG-40-50") == ("gear", ["CSG-40-50", "SHG-40-50"])
    assert axis("damping.ratio=1 %:3 %:2") == ("damping.ratio", ["1 %", "3 %"])


def test_options_of_trajectories_are_refused_before_anything_is_computed(drive):
    run = invoke(
        drive, "--grid", "load.inertia=1 kg*m^2,2 kg*m^2", "--grid", "loop.bandwidth=20 Hz", "--measure", "rms"
    )
    assert run.exit_code == 2
    assert "remove --measure, valid for the error equation only" in " ".join(run.stderr.split())
    assert not (drive.parent / "store").exists()


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("load.inertia", "is not a grid; write for example load.inertia=1 kg"),
        ("load.inertia=1:2", "is no range; write it as load.inertia=LOW:HIGH:COUNT or load.inertia=LOW:HIGH:COUNT:log"),
        ("gear=A:B:2", "is no range of numbers; write the names one by one, with commas"),
        ("speed=1 rpm:2 rad/s:3", "begins in rpm and ends in rad/s; write both ends in one unit"),
        ("load.inertia=1:2:x", "'x' in .* is no count"),
        ("load.inertia=0:2:3:log", "includes 0"),
    ],
)
def test_what_is_no_grid_is_refused(text, said):
    with pytest.raises(click.BadParameter, match=said):
        axis(text)


@pytest.mark.slow
def test_the_largest_error_is_that_of_the_response_of_each_file(drive):
    result = invoke(drive, "--grid", "load.inertia=1 kg*m^2:2 kg*m^2:2", "--grid", "damping.ratio=3 %,4 %", "--json")
    assert result.exit_code == 0, result.stderr
    report = json.loads(result.stdout)
    assert (report["points"], report["failed"]) == (4, 0)
    largest = report["variables"]["peak"]
    peaks = {}
    for inertia in ("1", "2"):
        for ratio in ("3", "4"):
            values = {"load.inertia": f"{inertia}.0 kg*m^2", "damping.ratio": f"{ratio} %"}
            found = replaced(read_project(drive), values).response()
            peaks[f"{inertia} kg·m^2", f"{ratio} %"] = float(found.peak[found.visited()].max())
    top = max(peaks, key=peaks.get)
    assert largest["largest"] == peaks[top]
    assert tuple(largest["largest_at"].values()) == top
    text = invoke(drive, "--grid", "load.inertia=1 kg*m^2:2 kg*m^2:2", "--grid", "damping.ratio=3 %,4 %").stdout
    rpm = largest["largest_speed"] * 30.0 / math.pi
    assert f"(at {rpm:.5g} rpm at the motor)" in text
    assert "rad/s" not in text


def test_numbers_without_a_unit_are_refused_with_an_example(drive):
    result = invoke(drive, "--grid", "motor.inertia=1:2:3")
    assert (result.exit_code, result.stdout) == (2, "")
    assert "motor.inertia: '1' has no unit; write for example" in " ".join(result.stderr.split())
    assert [p.name for p in drive.parent.iterdir()] == ["drive.yaml"]


def test_a_refusal_does_not_import_what_it_does_not_need(drive):
    code = (
        "import sys\nfrom strainwave.app.commands.cli import cli\n"
        f"try: cli(['sweep', {str(drive)!r}, '--grid', 'gear=CSG-40-51', '-o', 'x'])\n"
        "except SystemExit as stop: print(stop.code, *sorted({'xarray', 'pandas', 'zarr'} & set(sys.modules)))"
    )
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert run.stdout.split() == ["2"], run.stderr


@pytest.mark.parametrize(("option", "begin"), [((), "Kept as in"), (("--retune",), "Computed anew")])
def test_the_output_tells_whether_the_drive_is_built_once(drive, option, begin):
    text = drive.read_text(encoding="utf-8")
    drive.write_text(text + "motor: {inertia: 4.5 kg*cm^2, loop: {bandwidth: 30 Hz}}\n", encoding="utf-8")
    run = invoke(drive, "--grid", "load.inertia=1 kg*m^2,2 kg*m^2", "--json", *option)
    found = json.loads(run.stdout)
    assert found["tuning"].startswith(begin)
    assert found["tuning"] in found["remarks"]
    values = found["variables"]["oscillation"]
    file = read_project(drive)
    at = [replaced(file, {"load.inertia": J}, retune=bool(option)).response() for J in ("1 kg*m^2", "2 kg*m^2")]
    tops = [max(one.oscillation[one.visited()]) for one in at]
    assert sorted([values["smallest"], values["largest"]]) == pytest.approx(sorted(tops), rel=1e-9)


def test_ends_of_a_grid_that_no_gear_has_are_doubted(drive):
    run = invoke(drive, "--grid", "damping.ratio=3,5", "--json")
    said = [note for note in json.loads(run.stdout)["remarks"] if note.startswith("damping.ratio = ")]
    assert sorted(note.split(":")[0] for note in said) == ["damping.ratio = 3", "damping.ratio = 5"]
    assert all("is usual. Write 4 % as" in note for note in said)
