"""Order tables of `strainwave compensate`: what each leaves when it is used alone, by an integration of its own."""

import json
import math

import numpy as np
import pytest
from click.testing import CliRunner
from scipy.integrate import solve_ivp
from turntable import PROJECT

import strainwave as sw
from strainwave.app.commands import cli as command

RPM, ARCSEC = math.pi / 30.0, math.pi / 648_000.0
K, N, J_M, J_L, PERIOD, DELAY = 2e4, 50.0, 2e-4, 0.8, 2e-3, 0.5e-3
LINES = ((1, 2.0 * ARCSEC), (2, 20.0 * ARCSEC))


def own_rms(loop, damping, added, omega, turns=12, measured=5):
    """Rms [rad] of the pointing error about its mean, an angle of the output being added to the command."""

    def rhs(_t, y, torque):
        motor, fast, load, slow = y.tolist()
        e = sum(a * math.cos(k * motor) for k, a in LINES)
        slope = -sum(a * k * math.sin(k * motor) for k, a in LINES)
        gear = K * (motor / N - e - load) + damping * ((1.0 / N - slope) * fast - slow)
        return fast, (torque - (1.0 / N - slope) * gear) / J_M, slow, gear / J_L

    y, last, held, error, step = np.array([0.0, omega, 0.0, omega / N]), None, 0.0, [], 2.0 * math.pi / 2**20
    samples = round(turns * 2.0 * math.pi / abs(omega) / PERIOD)
    for i in range(samples):
        wanted = omega * i * PERIOD
        error.append(wanted / N - y[2])
        deviation = round(y[0] / step) * step - wanted - N * added(wanted)
        last = deviation if last is None else last
        torque = -loop.K_p * deviation - loop.K_d * (deviation - last) / PERIOD
        last = deviation
        for span, acting in ((DELAY, held), (PERIOD - DELAY, torque)):
            y = solve_ivp(rhs, (0.0, span), y, args=(acting,), rtol=1e-9, atol=1e-13).y[:, -1]
        held = torque
    return float(np.std(error[-round(measured * 2.0 * math.pi / abs(omega) / PERIOD) :]))


def written(tmp_path, *given, project=PROJECT):
    """What the command printed, and the folder that it wrote."""
    path, out = tmp_path / "table.yaml", tmp_path / "out"
    path.write_text(project)
    run = CliRunner().invoke(command.cli, ["compensate", str(path), *given, "-o", str(out)])
    assert run.exit_code == 0, run.output
    return run.stdout, path, out


@pytest.mark.slow
def test_a_table_of_angles_leaves_alone_what_it_says_forward_and_backward(tmp_path):
    said, path, out = written(tmp_path, "--controller", "inverse", "--speed", "-600 rpm")
    table = sw.OrderTable.read(out / "order-table-angle.json")
    data = json.loads((out / "compensation.json").read_text())
    project = sw.read_project(path)
    told = data["order_tables"]["angle"]
    assert table.delay == told["delay_s"] == pytest.approx(DELAY + 0.5 * PERIOD)
    omega, loop = -600.0 * RPM, project.whole.motor.control
    own = own_rms(loop, project.whole.B, lambda angle: table.value(angle, omega), omega)
    assert told["rms_alone_arcsec"] * ARCSEC == pytest.approx(own, rel=0.005)
    both = data["results"][1]["rms_after_arcsec"]
    assert told["rms_alone_arcsec"] > 3.0 * both  # without the torque of the motor's inertia
    without_delay = own_rms(loop, project.whole.B, lambda angle: table.value(angle), omega)
    assert abs(own - without_delay) > 0.02 * own  # its delay counts
    assert told["source"] == table.source
    assert f" to {told['rms_alone_arcsec']:.3g} arcsec" in table.source
    assert "angle: inverse at -600 rpm; this table alone reduces the rms pointing error" in " ".join(said.split())


@pytest.mark.slow
def test_backward_motion_has_all_files_and_figures(tmp_path):
    _, _, out = written(tmp_path, "--controller", "inverse", "--speed", "-600 rpm", "--speed", "600 rpm")
    figure = (out / "speeds.svg").read_text()
    assert ">−500<" in figure
    assert ">500<" in figure
    assert (out / "compensation.csv").exists()


@pytest.mark.slow
def test_both_tables_of_a_controller_take_away_what_it_does(tmp_path):
    _, _, out = written(tmp_path, "--controller", "adaptive-inverse", "--speed", "600 rpm")
    data = json.loads((out / "compensation.json").read_text())
    assert set(data["order_tables"]) == {"angle", "torque"}
    after = data["results"][1]["rms_after_arcsec"]
    before = data["results"][1]["rms_before_arcsec"]
    for name, other in (("angle", "torque"), ("torque", "angle")):
        told = data["order_tables"][name]
        both = float(told["source"].split(f"with order-table-{other}.json to ")[1].split()[0])
        assert both < 0.05 * before  # as the controller, to what its adaptation still moves
        assert told["rms_alone_arcsec"] > 3.0 * both
    assert after < 0.05 * before


@pytest.mark.slow
def test_the_note_on_gravity_offers_an_angle_only_where_none_was_given(tmp_path):
    heavy = PROJECT.replace("0.8 kg*m^2", "0.8 kg*m^2, drag: {type: angle_torque, amplitude: 5 N*m}")
    given = "--controller", "inverse", "--speed", "600 rpm"
    said = " ".join(written(tmp_path, *given, project=heavy)[0].split())
    assert "constant gravity torque of 0 N*m, at a load angle of 0 deg. --load-angle sets others." in said
    angles = "--load-angle", "0 deg", "--load-angle", "90 deg"
    said = " ".join(written(tmp_path, *given, *angles, project=heavy)[0].split())
    assert "sets others" not in said
    assert "constant gravity torque of 0 N*m, at a load angle of 0 deg." in said
    assert "constant gravity torque of -5 N*m, at a load angle of 90 deg." in said
