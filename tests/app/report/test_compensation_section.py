"""The section of the report on compensation: only with a controller in the file, with the numbers of the library."""

from pathlib import Path
from types import SimpleNamespace

import pytest
from twelve_projects import PROJECTS

import strainwave as sw
from strainwave.app.report.section import Part
from strainwave.app.report.sections.controllers import compensation
from strainwave.files.reading import from_text

PROJECT = """\
gear: {{ratio: 50, law: {{type: linear, K: 2e4 N*m/rad}}}}
motor: {{inertia: 2 kg*cm^2, loop: {{bandwidth: {bandwidth}}}, max_torque: 5 N*m}}
{controller}
load: {{inertia: 0.8 kg*m^2}}
damping: {{ratio: 25 %}}
speed: {{from: 600 rpm, to: 700 rpm, shaft: motor}}
excitation: {{kinematic_error: [{{order: 2, amplitude: 20 arcsec}}]}}
"""


def view(controller="controller: {period: 2 ms, delay: 0.5 ms, motor_encoder: 20 bit}", bandwidth="25 Hz"):
    text = PROJECT.format(controller=controller, bandwidth=bandwidth)
    return SimpleNamespace(project=from_text(text, Path("axis.yaml")))


def test_a_file_without_a_controller_has_no_such_section():
    assert compensation(view("")) == Part(data={"compensation": None})


@pytest.mark.slow
def test_the_section_has_the_numbers_of_the_library():
    seen = view()
    part = compensation(seen)
    data = part.data["compensation"]
    one = sw.compensate(seen.project, "inverse")
    (row,) = data["controllers"]  # the file has no encoder on the load
    assert data["motor_speed_rpm"] == pytest.approx(700.0)  # the resonance lies above: the end of the range
    assert data["rms_before_rad"] == pytest.approx(one.before.rms, rel=1e-12)
    assert row["rms_after_rad"] == pytest.approx(one.after.rms, rel=1e-12)
    assert [gear["stiffness"] for gear in row["other_gears"]] == [-0.2, 0.2]
    (line,) = part.lines
    assert line.startswith("controller inverse at 700 rpm: rms pointing error ")
    ((figure, _),) = part.figures
    assert "residual pointing error" in figure


@pytest.mark.slow
def test_speeds_of_a_forcing_are_in_its_own_unit():
    article = from_text(PROJECTS["article"] + "controller: {period: 250 us}\n", Path("article.yaml"))
    part = compensation(SimpleNamespace(project=article))
    data = part.data
    assert data["compensation"]["motor_speed_rpm"] is None
    assert data["compensation"]["omega_rad_per_s"] == pytest.approx(article.omega_0, rel=1e-9)
    assert all(" at 385.5 rad/s: rms pointing error " in line for line in part.lines)


def test_what_cannot_be_computed_is_said_with_the_reason():
    part = compensation(view(bandwidth="150 Hz"))
    data = part.data["compensation"]
    assert "the plain loop is unstable with samples every 2 ms" in data["not_computed"]
    assert data["controllers"] == []
    assert not part.figures
    (line,) = part.lines
    assert line.startswith("compensation was not computed: the plain loop is unstable")
