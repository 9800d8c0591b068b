"""Load-proportional friction in the project file, and what a response makes of it."""

from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import strainwave as sw
from strainwave.files.reading import ProjectError

FILE = """
gear: {ratio: 50, law: {type: linear, K: 1e5 N*m/rad}}
load_friction: 20 %
motor: {inertia: 6 kg*cm^2, loop: {bandwidth: 20 Hz, damping: 0.6}}
load: {inertia: 1.2 kg*m^2}
damping: {ratio: 3 %}
speed: {from: 1200 rpm, to: 1500 rpm, shaft: motor}
excitation:
  kinematic_error: [{order: 2, amplitude: 20 arcsec}]
  load_torque: {mean: -40 N*m}
"""


def read(tmp_path: Path, text: str) -> sw.Project:
    path = tmp_path / "drive.yaml"
    path.write_text(text, encoding="utf-8")
    return sw.read_project(path)


def test_a_share_of_the_torque_is_read_and_written(tmp_path):
    project = read(tmp_path, FILE)
    assert project.train.friction == sw.laws.LoadFriction(0.2)
    assert read(tmp_path, sw.project_text(project)).train == project.train
    assert read(tmp_path, sw.project_text(project.train, (100.0, 150.0))).train.friction == sw.laws.LoadFriction(0.2)


def test_the_catalogues_efficiency_gives_it(tmp_path):
    own = "gears:\n- {name: RT1, series: own, size: 25, ratio: 50, K1: 2.5e4 N*m/rad, K2: 3.4e4 N*m/rad, "
    own += (
        "K3: 4.4e4 N*m/rad, T1: 14 N*m, T2: 48 N*m, rated_torque: 51 N*m, efficiency: 77 %, running_torque: 0.1 N*m}\n"
    )
    (tmp_path / "mine.yaml").write_text(own, encoding="utf-8")
    text = FILE.replace("{ratio: 50, law: {type: linear, K: 1e5 N*m/rad}}", "{file: mine.yaml, name: RT1}")
    project = read(tmp_path, text.replace("20 %", "catalogue", 1))
    assert project.train.friction.mu == pytest.approx(1.0 / 0.77 - 1.0 - 50.0 * 0.1 / 51.0, rel=1e-12)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("load_friction: 20 %", "load_friction: 120 %", "from 0 up to 1"),
        ("load_friction: 20 %", "load_friction: catalogue", "the efficiency of an explicit gear is unknown"),
        ("load_friction: 20 %", "load_friction: -3 %", "is negative; write zero or more"),
        ("load_friction: 20 %", "load_friction: much", "load_friction"),
        ("shaft: motor", "shaft: forcing", "belongs to a shaft"),
    ],
)
def test_bad_friction_gets_a_sentence(tmp_path, old, new, said):
    with pytest.raises(ProjectError) as caught:
        read(tmp_path, FILE.replace(old, new))
    assert said in str(caught.value)


@pytest.mark.slow
def test_the_response_is_that_of_the_equation_written_by_hand(tmp_path):
    project = read(tmp_path, FILE)
    response = project.response()
    middle = int(np.argmax(response.oscillation))
    omega = float(response.omega[middle])
    train = project.train
    J_m, J_l, N, B, K, mu = train.motor.J, 1.2, 50.0, train.B, 1e5, 0.2
    loop, A = train.motor.control, 20.0 * np.pi / 648000.0

    def rhs(t, y):
        d, dd, theta_l, v_l = y
        theta_m, v_m = omega * t + d, omega + dd
        e, slope = A * np.cos(2.0 * theta_m), -2.0 * A * np.sin(2.0 * theta_m)
        T = K * (theta_m / N - theta_l - e) + B * (v_m / N - v_l - slope * v_m)
        rubs = mu * abs(T) * v_m / np.sqrt(v_m * v_m + 1.0) / N
        a = (-loop.K_p * d - loop.K_d * dd - (1.0 / N - slope) * T - rubs) / J_m
        return [dd, a, v_l, (T - 40.0) / J_l]

    period = 2.0 * np.pi / omega
    start = [-40.0 * 1.2 / N / loop.K_p, 0.0, -40.0 * 1.2 / N / loop.K_p / N - 40.0 / K, omega / N]
    # the equations are those of a train that turns: 120 periods settle it
    end = solve_ivp(rhs, (0.0, 121.0 * period), start, method="DOP853", rtol=1e-11, atol=1e-13,
                    t_eval=np.linspace(120.0 * period, 121.0 * period, 4001))  # fmt: skip
    pointing = omega * end.t / N - end.y[2]
    assert response.oscillation[middle] == pytest.approx(np.max(np.abs(pointing - np.mean(pointing[:-1]))), rel=1e-5)
