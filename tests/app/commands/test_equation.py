"""Commands that follow the error equation refuse a drive that has more, and name what does not enter."""

import json
import math
import re

import numpy as np
import pytest
import small_drive
from click.testing import CliRunner
from direct_project import project_of
from small_drive import at_the_load

import strainwave as sw
from strainwave.app.commands import cli as command
from strainwave.app.web.views import sureness
from strainwave.files.reading import read_project
from strainwave.plot.drive import HELD

ARCSEC = math.pi / 648000.0
PROJECT = at_the_load(small_drive.PROJECT, 20, 24)
SPEED_LOOP = ("mode: held", "loop: {type: speed_loop, K_p: 0.5 N*m*s/rad, K_i: 20 N*m/rad}")
POSITION_LOOP = ("mode: held", "loop: {type: position_loop, K_p: 30 N*m/rad, K_d: 0.5 N*m*s/rad}")
FREE = ("mode: held", "mode: free")
MOTOR_DRAG = ("inertia: 5 kg*cm^2", "inertia: 5 kg*cm^2, drag: {type: viscous, B: 2e-4 N*m*s/rad}")
GRAVITY = ("inertia: 1 kg*m^2", "inertia: 1 kg*m^2, drag: {type: angle_torque, amplitude: 40 N*m}")
FRICTION = (
    "inertia: 1 kg*m^2",
    "inertia: 1 kg*m^2, drag: {type: quadratic_damping, D: 4 N*m*s^2/rad^2}",
)
COUPLING = (
    "inertia: 1 kg*m^2",
    "inertia: 1 kg*m^2, coupling: {inertia: 0.1 kg*m^2, law: {type: linear, K: 4e5 N*m/rad}}",
)
BEAT = ("{order: 2, amplitude: 10 arcsec}", "{order: {wave_generator: 2, output: 2}, amplitude: 10 arcsec}")


@pytest.fixture
def written(tmp_path):
    def write(*changes):
        text = PROJECT
        for old, new in changes:
            assert old in text
            text = text.replace(old, new)
        (tmp_path / "elbow.yaml").write_text(text)
        return tmp_path / "elbow.yaml"

    return write


def invoke(name, path, *options):
    store = ("-o", str(path.parent / "store")) if name == "sweep" else ()
    return CliRunner().invoke(command.cli, [name, str(path), *options, *store])


@pytest.mark.parametrize(
    "changes", [[SPEED_LOOP], [POSITION_LOOP], [GRAVITY], [COUPLING], [SPEED_LOOP, MOTOR_DRAG, COUPLING]]
)
def test_a_drive_that_has_more_than_its_error_equation_is_swept_by_the_names_of_its_file(written, changes):
    path = written(*changes)
    result = invoke("sweep", path, "--grid", "B=10,20")
    assert (result.exit_code, result.stdout) == (2, "")
    assert "B = 10: the project file has no 'B'; its numbers are gear.ratio, gear.law.K, " in " ".join(
        result.stderr.split()
    )
    assert [p.name for p in path.parent.iterdir()] == ["elbow.yaml"]


def test_a_free_motor_with_more_is_refused_before_anything_is_computed(written):
    result = invoke("sweep", written(FREE, FRICTION), "--grid", "load.inertia=1 kg*m^2,2 kg*m^2")
    assert (result.exit_code, result.stdout) == (1, "")
    assert "uses the error equation, which neglects the load's drag; give the motor a loop" in result.stderr


def pointing_error_of_a_linear_drive(omega, K_i, K_p):
    """Amplitude at order 2 of reference/N - theta_l, motor in a PI speed loop: linear algebra in (delta, y)."""
    N, J_m, J_l, K, A = 50.0, 5e-4, 1.0, 1e5, 10.0 * ARCSEC
    B, s = 2.0 * 0.05 * math.sqrt(K * J_l), 2j * omega
    gear = K + B * s  # terms of order N e' are dropped
    loop = J_m * s * s + K_p * s + K_i
    # load: J s^2 y + gear (y + delta/N - e) = 0; motor: loop delta + (1/N) gear (y + delta/N - e) = 0
    matrix = np.array([[J_l * s * s + gear, gear / N], [gear / N, loop + gear / N**2]])
    return abs(np.linalg.solve(matrix, np.array([gear * A, gear * A / N]))[0])


def test_the_response_is_of_the_whole_drive(written):
    """A linear gear: the curve is that of linear algebra."""
    path = written(
        SPEED_LOOP, ("{type: cubic, K: 1e5 N*m/rad, alpha: 6.9e4 1/rad^2}", "{type: linear, K: 1e5 N*m/rad}")
    )
    found = read_project(path).response()
    exact = [pointing_error_of_a_linear_drive(omega, 20.0, 0.5) for omega in found.omega]
    np.testing.assert_allclose(found.curve.amplitude(2), exact, rtol=0.02)  # of order N e', 0.5 %
    told = invoke("response", path)
    assert told.exit_code == 0, told.stderr
    assert "pointing error, largest oscillation" in told.stdout


@pytest.mark.parametrize("more", [GRAVITY, COUPLING, MOTOR_DRAG], ids=["gravity", "coupling", "drag"])
def test_the_figure_of_a_beat_is_without_the_error_equation_which_has_no_such_line(written, more):
    path = written(more, BEAT)
    told = invoke("response", path, "-o", str(path.parent / "curve.svg"))
    assert told.exit_code == 0, told.stderr
    assert HELD not in (path.parent / "curve.svg").read_text()
    assert sureness(read_project(path))["held"] is None


@pytest.mark.parametrize(
    "changes", [[], [FREE], [MOTOR_DRAG]], ids=["held", "free", "drag of a motor that keeps its speed"]
)
def test_the_error_equation_of_a_drive_that_has_no_more_is_given_as_it_is(written, changes):
    project = read_project(written(*changes))
    assert project.left_out == ()
    assert project.system().omega == pytest.approx(50.0 * 22.0 * math.pi / 30.0, rel=1e-14)
    assert project.system() == project.system(project.system().omega, reduced=True)


def test_the_error_equation_of_a_drive_that_has_more_is_given_to_who_says_so(written):
    project = read_project(written(SPEED_LOOP, COUPLING))
    assert project.left_out == ("the motor's loop", "the coupling")
    with pytest.raises(ValueError, match=r"neglects the motor's loop and the coupling of this drive; "):
        project.system(100.0)
    reduced = project.system(100.0, reduced=True)
    assert (reduced.J, reduced.omega) == (pytest.approx(1.1), 100.0)  # both inertias in one


def test_a_free_motor_with_friction_behind_it_is_refused_by_the_analysis_too(written):
    path = written(FREE, FRICTION)
    result = invoke("analyze", path, "-o", str(path.parent / "out"))
    assert (result.exit_code, result.stdout) == (1, "")
    assert "an analysis uses the error equation, which neglects the load's drag" in result.stderr
    drive = sw.Drive(5e-4, 1.0, 50.0, 20.0, sw.Linear(1e5))
    with pytest.raises(ValueError, match=r"neglects the load's drag"):
        project_of(drive, (90.0, 100.0), motor="free", load_drag=sw.laws.QuadraticDamping(4.0)).analyze()


def test_what_does_not_enter_or_is_approximate_is_named_in_text_and_json(written):
    data = json.loads(invoke("response", written(MOTOR_DRAG), "--json").stdout)
    assert data["motor"] == "held"
    assert data["remarks"] == ["motor.drag has no effect: an ideally held motor keeps its speed under any torque."]
    told = invoke("response", written(FREE)).stdout
    slope = 50.0 * 2.0 * 10.0 * ARCSEC  # N times order times amplitude of the one line
    assert f"the motor's reaction to the varying ratio, N e' up to {slope:.2g};" in told
    assert json.loads(invoke("response", written(), "--json").stdout)["remarks"] == []


def test_single_speeds_and_doubts_about_the_file_are_named_in_text_and_figure(written):
    path = written(("{from: 20 rpm, to: 24 rpm, shaft: load}", "{at: [1000 rpm, 1200 rpm], shaft: motor}"))
    path.write_text(
        path.read_text().replace("kinematic_error: [{order: 2, amplitude: 10 arcsec}]", "accuracy: 1 arcmin")
    )
    result = invoke("response", path, "-o", str(path.parent / "curve.svg"))
    assert result.exit_code == 0, result.stderr
    figure = " ".join(re.findall("<text[^>]*>([^<]*)</text>", (path.parent / "curve.svg").read_text(encoding="utf-8")))
    for words in ("1 : 4 : 1, all phases zero", "the curve covers 800 to 1440 rpm at the motor"):
        assert words in result.stdout
        assert words in figure


def test_a_sweep_at_one_speed_says_which(written):
    path = written()
    options = ("--grid", "B=100,200", "--settle", "1", "--periods", "1")
    told = invoke("sweep", path, *options).stdout
    assert "All points are computed at 115.192 rad/s (1100 rpm) at the motor, the middle of the speed range" in told
    swept = CliRunner().invoke(
        command.cli,
        ["sweep", str(path), "--grid", "omega=100,110", *options[2:], "-o", str(path.parent / "b"), "--json"],
    )
    assert json.loads(swept.stdout)["remarks"] == [
        "omega has no unit in 'omega=100,110': its values are read in rad/s."
    ]
