"""Drive trains written as project files: what is read back moves as what was written."""

from dataclasses import fields, replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from twelve_projects import PROJECTS

import strainwave as sw
from strainwave.files.reading import from_text, read_project

ERROR = sw.KinematicError((sw.Line(2, 1e-4, 0.3), sw.Line(4, -1e-5)))
DRIVE = sw.catalogue.gear("CSG-40-50").drive(load_inertia=1.3, B=10.0)
YIELDING = sw.Parallel(DRIVE.law, sw.BoucWen(6e4, 0.0, 8e-5))
LOAD_TORQUE = sw.Harmonics((sw.Harmonic(2.0, 1, 0.1, -50.0), sw.Harmonic(-0.3, 3, 0.2, 0.5)))
WITH_LOOP = DRIVE._replace(law=YIELDING).train(
    kinematic_error=ERROR,
    load_torque=LOAD_TORQUE,
    omega=200.0,
    control=sw.train.SpeedLoop(0.5, 20.0),
    motor_drag=sw.laws.LuGre(1e3, 1.0, 0.01, 0.1, 0.15, 0.5),
    load_drag=sw.train.AngleTorque(40.0, 1, 0.2),
)
TWO_TURNS = sw.KinematicError((sw.Line(2, 1e-4, 0.3), sw.Line(2 - 2 / 50, -1e-5), sw.Line(3 / 50, 2e-5, 0.1)))
TRAINS = {
    "loop": WITH_LOOP,
    "two turns": WITH_LOOP._replace(error=TWO_TURNS),
    "coupling": WITH_LOOP._replace(load=sw.train.Elastic(0.1, 5.0, sw.Cubic(4e5, 0.1), WITH_LOOP.load)),
    "two couplings": WITH_LOOP._replace(
        load=sw.train.Elastic(0.1, 5.0, sw.Cubic(4e5, 0.1), sw.train.Elastic(0.2, 0.0, sw.Linear(1e5), WITH_LOOP.load))
    ),
    "loop with a lag": WITH_LOOP._replace(
        motor=WITH_LOOP.motor._replace(control=sw.train.Lagged(sw.train.PositionLoop(50.0, 0.5), 1e-4))
    ),
    "position loop": WITH_LOOP._replace(motor=WITH_LOOP.motor._replace(control=sw.train.PositionLoop(50.0, 0.5))),
    "free": DRIVE.train(motor_torque=sw.Harmonic(0.2, 2, 0.0, 1.0), kinematic_error=ERROR, omega=150.0),
}


class Constant(NamedTuple):
    """Drag of a user's own, here 1 N*m and more."""

    more: float

    def torque(self, x, v):
        return 1.0 + self.more + 0.0 * x * v


@pytest.mark.parametrize("train", TRAINS.values(), ids=TRAINS.keys())
def test_a_train_survives_its_project_file(train, tmp_path):
    path = tmp_path / "axis.yaml"
    path.write_text(sw.project_text(train, title='Axis "1": left'), encoding="utf-8")
    project = read_project(path)
    assert project.title == 'Axis "1": left'
    assert project.speeds.single == (train.omega,)
    y = tuple(1e-3 * (i + 1) for i in range(len(train.state_names())))
    assert project.train.state_names() == train.state_names()
    for phase in np.linspace(0.0, 7.0, 5):
        assert project.train.rhs(phase, y) == pytest.approx(train.rhs(phase, y), rel=1e-12)


@pytest.mark.parametrize("motor", ["free", "held"])
def test_the_error_equation_of_a_drive_survives_its_project_file(motor, tmp_path):
    torques = {"load_torque": LOAD_TORQUE, "kinematic_error": ERROR}
    torques |= {"motor_torque": sw.Harmonic(0.2, 2, 0.0, 1.0)} if motor == "free" else {}
    equation = DRIVE.error_equation(**torques, omega=150.0, motor=motor)
    path = tmp_path / "axis.yaml"
    control = sw.train.Free() if motor == "free" else sw.train.Held()
    path.write_text(sw.project_text(DRIVE.train(**torques, control=control), (100.0, 200.0)), encoding="utf-8")
    project = read_project(path)
    assert (project.speeds.limits, project.motor, project.drive) == ((100.0, 200.0), motor, DRIVE)
    for phase in np.linspace(0.0, 7.0, 5):
        read = project.system(150.0).rhs(phase, (1e-3, 0.2))
        assert read == pytest.approx(equation.rhs(phase, (1e-3, 0.2)), rel=1e-12)


@pytest.mark.parametrize(
    ("train", "omega", "said"),
    [
        (DRIVE.train(omega=3.0), None, "cannot hold this train: project.yaml:6:13: excitation: has no periodic"),
        (WITH_LOOP, (3.0, 2.0), r"omega \[rad/s\] is \(3.0, 2.0\); it must be two finite numbers"),
        (WITH_LOOP._replace(reference=sw.train.AtRest()), None, r"constant speeds, but this train follows AtRest\(\)"),
        (
            WITH_LOOP._replace(load=sw.train.Load(1.0, sw.train.TorqueProfile((0.0, 1.0), (0.0, 1.0)))),
            None,
            "holds torques as harmonics, and the load has TorqueProfile",
        ),
        (WITH_LOOP._replace(B=-1.0), None, "B"),
        (  # equal to Linear(0.0), which is no drag, as tuples of numbers are
            WITH_LOOP._replace(motor=WITH_LOOP.motor._replace(drag=Constant(0.0))),
            None,
            "Constant",
        ),
    ],
)
def test_what_a_project_file_does_not_hold_is_said(train, omega, said):
    with pytest.raises(ValueError, match=said):
        sw.project_text(train, omega)


def written(path, text):
    path.write_text(text, encoding="utf-8")
    return read_project(path)


def apart(project, other):
    """Fields in which two projects differ, but for the text and the notes."""
    names = {f.name for f in fields(project) if f.compare} - {"text", "notes"}
    return [name for name in sorted(names) if getattr(project, name) != getattr(other, name)]


@pytest.mark.parametrize("name", PROJECTS)
def test_a_project_survives_its_text(name, tmp_path):
    project = written(tmp_path / "drive.yaml", PROJECTS[name])
    text = sw.project_text(project)
    assert text == PROJECTS[name]
    assert written(tmp_path / "drive.yaml", text) == project


@pytest.mark.parametrize("name", PROJECTS)
def test_a_project_without_its_text_is_written_from_its_parts(name, tmp_path):
    project = written(tmp_path / "drive.yaml", PROJECTS[name])
    text = sw.project_text(replace(project, text=""))
    assert text != PROJECTS[name]
    again = written(tmp_path / "drive.yaml", text)
    assert set(apart(project, again)) <= {"gear"}  # a gear that is not the catalogue's law is written in full
    assert str(again.train) == str(project.train)  # with the classes, which equal numbers hide
    assert str(again.drive) == str(project.drive)


def test_a_changed_project_is_written_with_its_changes(tmp_path):
    project = written(tmp_path / "drive.yaml", PROJECTS["antenna"])
    changed = replace(project, limit=1e-4, subject=project.subject._replace(B=33.0))
    again = written(tmp_path / "drive.yaml", sw.project_text(changed))
    assert (again.limit, again.drive.B, again.gear) == (1e-4, 33.0, project.gear)
    assert apart(changed, again) == []


@pytest.mark.parametrize("torque", [0.0, 7.0])
@pytest.mark.parametrize("name", PROJECTS)
def test_a_project_under_another_torque_is_written(name, torque, tmp_path):
    changed = written(tmp_path / "drive.yaml", PROJECTS[name]).under(torque)
    again = written(tmp_path / "drive.yaml", sw.project_text(changed))
    assert again.mean_load_torque == torque
    assert set(apart(changed, again)) <= {"gear"}


def test_a_gear_of_the_catalogue_keeps_its_record_with_a_measured_law(tmp_path):
    law = "{type: piecewise_linear, K1: 9e4 N*m/rad, K2: 15e4 N*m/rad, K3: 17e4 N*m/rad, T1: 54 N*m, T2: 196 N*m}"
    text = PROJECTS["catalogue gear, motor not named"]
    name = next(line for line in text.splitlines() if line.startswith("gear:")).removeprefix("gear: ")
    project = from_text(text.replace(f"gear: {name}", f"gear: {{name: {name}, law: {law}}}"), tmp_path / "a.yaml")
    assert project.gear == sw.catalogue.gear(name)
    assert project.drive.law == sw.PiecewiseLinear(9e4, 15e4, 17e4, 54.0, 196.0)
    written = sw.project_text(replace(project, title="measured"))
    assert f'name: "{name}"' in written
    again = from_text(written, project.path)
    assert (again.gear, again.drive, again.rated_torque) == (project.gear, project.drive, project.rated_torque)


def test_a_project_that_contradicts_itself_is_refused(tmp_path):
    project = written(tmp_path / "drive.yaml", PROJECTS["position loop, coupling"])
    with pytest.raises(ValueError, match=r"project 'drive' cannot be written as a project file: its parts contradict"):
        sw.project_text(replace(project, limit=-1.0))


def test_a_variation_of_ones_own_is_in_no_project_file(tmp_path):
    class Own(NamedTuple):
        share: float

        def factor(self, phase):
            return 1.0 + self.share

    project = written(tmp_path / "drive.yaml", PROJECTS["varying stiffness and damping"])
    with pytest.raises(ValueError, match="no project file says what Own holds; it has ripples of a Variation"):
        sw.project_text(replace(project, stiffness=Own(0.1)))


AUTHORS = """\
# azimuth of the dish
title: azimuth
gear: CSG-32-100   # from the shelf
motor:
  inertia: 4.5 kg*cm^2
  loop:            # set in May
    type: cascade
{gains}    lag: 0.5 ms      # drive manual
load: {{inertia: 5 kg*m^2}}
damping: {{ratio: 3 %}}
speed: {{from: 500 rpm, to: 3000 rpm, shaft: motor}}
excitation: {{kinematic_error: [{{order: 2, amplitude: 23 arcsec}}]}}
scatter: {{damping.ratio: 20 %}}
"""
FLOW = AUTHORS.replace("loop:            # set in May\n    type: cascade\n", "loop: {{type: cascade, ").replace(
    "    lag: 0.5 ms      #", "lag: 0.5 ms}}      #"
)


@pytest.mark.parametrize(
    ("text", "before", "after"),
    [
        (
            AUTHORS, "    bandwidth: 30 Hz  # old\n    # asked\n    damping: 0.8  # soft\n",
            "    K_v: 40.5 1/s\n    K_p: 0.15 N*m*s/rad  # old\n    # asked\n    T_n: 0.02 s  # soft\n",
        ),
        (
            AUTHORS.replace("\n", "\r\n"), "    bandwidth: 30 Hz\r\n",
            "    K_v: 40.5 1/s\r\n    K_p: 0.15 N*m*s/rad\r\n    T_n: 0.02 s\r\n",
        ),
        (
            AUTHORS, "    K_v: 50 1/s\n    K_p: 200 mN*m*s/rad  # soft\n    T_n: 18 ms\n",
            "    K_v: 40.5 1/s\n    K_p: 150 mN*m*s/rad  # soft\n    T_n: 20 ms\n",
        ),
        (
            FLOW, "bandwidth: 30 Hz, damping: 0.8, ",
            "K_v: 40.5 1/s, K_p: 0.15 N*m*s/rad, T_n: 0.02 s, ",
        ),
        (
            FLOW, "damping: 0.8, bandwidth: 30 Hz, ",
            "K_v: 40.5 1/s, K_p: 0.15 N*m*s/rad, T_n: 0.02 s, ",
        ),
    ],
)  # fmt: skip
def test_another_loop_changes_the_gains_alone_in_the_authors_file(text, before, after):
    read = from_text(text.format(gains=before), Path("axis.yaml"))
    control = sw.train.Lagged(sw.train.CascadeLoop(40.5, 0.15, 0.02), 5e-4)
    train = read.train.with_motor(control=control)
    assert sw.project_text(replace(read, subject=train)) == text.format(gains=after)


def test_a_loop_without_a_type_gets_one_with_its_gains():
    text = AUTHORS.replace("    type: cascade\n", "")
    read = from_text(text.format(gains="    bandwidth: 30 Hz\n"), Path("axis.yaml"))
    train = read.train.with_motor(control=sw.train.Lagged(sw.train.PositionLoop(20.0, 0.25), 5e-4))
    gains = "    type: position_loop\n    K_p: 20.0 N*m/rad\n    K_d: 0.25 N*m*s/rad\n"
    assert sw.project_text(replace(read, subject=train)) == text.format(gains=gains)


def test_a_changed_drive_with_a_scattering_damping_ratio_is_written():
    read = from_text(AUTHORS.format(gains="    bandwidth: 30 Hz\n"), Path("axis.yaml"))
    read = replace(read, scatter=(*read.scatter, ("loop.bandwidth", 0.1)))
    train = read.train._replace(B=2.0 * read.drive.B)
    changed = replace(read, subject=train)
    again = from_text(sw.project_text(changed), Path("axis.yaml"))
    assert (again.drive.B, again.scatter) == (train.B, (("damping.B", 0.2),))
