"""The linear train of python-control against the transfer functions of two inertias, and against `bode`."""

import sys

import numpy as np
import pytest

import strainwave as sw

control = pytest.importorskip("control", reason="python-control (extra `control`) is not installed")

DRIVE = sw.Drive(J_m=5.26e-4, J_l=0.05, N=50.0, B=0.5, law=sw.Cubic(7160.0, 1e4))
OMEGA = np.linspace(50.0, 900.0, 18)
COUPLED = sw.DriveTrain(
    sw.train.Motor(DRIVE.J_m, control=sw.train.Lagged(sw.train.PositionLoop(40.0, 0.4), 1e-3)),
    50.0,
    0.5,
    sw.Linear(7160.0),
    sw.train.Elastic(0.02, 0.1, sw.Linear(3e4), sw.train.Load(0.03)),
)
TRAINS = {
    "free": DRIVE.train(),
    "loop": DRIVE.train(control=sw.train.SpeedLoop(0.3, 4.0)),
    "coupled": COUPLED,
    "held": DRIVE.train(control=sw.train.Held()),
}


def test_the_free_drive_has_the_transfer_functions_of_two_inertias():
    system = DRIVE.to_control()
    assert isinstance(system, control.StateSpace)
    assert (system.input_labels, system.output_labels) == (
        ["motor_torque", "load_torque"],
        ["motor_angle", "load_angle"],
    )
    for s in 1j * OMEGA:
        z = 7160.0 + 0.5 * s
        matrix = [[DRIVE.J_m * s * s + z / 2500, -z / 50], [-z / 50, DRIVE.J_l * s * s + z]]
        np.testing.assert_allclose(system(s), np.linalg.inv(matrix), rtol=1e-9)


@pytest.mark.parametrize("name", TRAINS)
def test_speeds_are_those_of_bode(name):
    train = TRAINS[name]
    system = train.to_control()
    for column, source in enumerate(label.removesuffix("_torque") for label in system.input_labels):
        found, exact = system(1j * OMEGA)[:, column] * 1j * OMEGA, sw.bode(train, OMEGA, source=source)
        np.testing.assert_allclose(found, [exact.motor, exact.load], rtol=1e-9)
    np.testing.assert_allclose(np.sort_complex(system.poles()), np.sort_complex(exact.poles), rtol=1e-9, atol=1e-6)


def test_a_mean_torsion_stiffens_it():
    x = 5e-3
    natural = np.max(DRIVE._replace(B=0.0).to_control(at=(x, 0.0, 0.0, 0.0)).poles().imag)
    assert natural == pytest.approx(np.sqrt(DRIVE.law.stiffness(x) / DRIVE.J), rel=1e-8)


def test_without_python_control_a_sentence_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "control", None)
    with pytest.raises(ModuleNotFoundError, match=r"needs python-control; pip install 'strainwave\[control\]'"):
        DRIVE.to_control()
