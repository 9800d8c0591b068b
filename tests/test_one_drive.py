"""One drive, one answer: command line, sweep, Python and report give the same numbers for twelve project files."""

import json

import numpy as np
import pytest
from click.testing import CliRunner
from twelve_projects import PROJECTS

from strainwave.app.commands import cli as command
from strainwave.files.reading import read_project
from strainwave.files.variants.project_sweep import largest

ARCSEC = np.pi / 648000.0


@pytest.fixture
def path(request, tmp_path):
    file = tmp_path / "drive.yaml"
    file.write_text(PROJECTS[request.param], encoding="utf-8")
    return file


@pytest.mark.slow
@pytest.mark.parametrize("path", PROJECTS, indirect=True)
def test_command_line_sweep_report_and_python_agree(path):
    project = read_project(path)
    found = project.response()
    at = found.visited()[int(np.argmax(found.oscillation[found.visited()]))]
    result = CliRunner().invoke(command.cli, ["response", str(path), "--json"])
    assert result.exit_code == 0, result.stderr
    told = json.loads(result.stdout)
    assert told["oscillation"]["oscillation_arcsec"] == pytest.approx(found.oscillation[at] / ARCSEC, rel=1e-9)
    assert told["oscillation"]["speed"] == pytest.approx(project.speeds.own(float(found.omega[at])), rel=1e-9)
    swept = largest(project)
    assert swept["oscillation"] == pytest.approx(found.oscillation[at], rel=1e-9)
    assert swept["torque"] == pytest.approx(found.usage.peak_torque, rel=1e-9)
    assert swept["peak"] == pytest.approx(np.max(found.peak[found.visited()]), rel=1e-9)
    drive = project.analyze().drive  # of the report
    here = drive.visited()[int(np.argmax(drive.oscillation[drive.visited()]))]
    assert drive.oscillation[here] == pytest.approx(found.oscillation[at], rel=1e-9)
    assert drive.omega[here] == pytest.approx(found.omega[at], rel=1e-9)
