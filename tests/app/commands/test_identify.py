"""`strainwave identify` and `strainwave order-scan`: what they print and write is what the library finds."""

import json
import re
from shutil import copy

import numpy as np
import pytest
from click.testing import CliRunner
from measured_axis import PROJECT, RATE, current, measured

import strainwave as sw
from strainwave.app.commands.cli import cli
from strainwave.base.units import ARCSEC


def invoke(*arguments):
    return CliRunner().invoke(cli, [str(argument) for argument in arguments])


def write(path, header, *columns):
    np.savetxt(path, np.column_stack(columns), delimiter=";", header=header, comments="", fmt="%.12g")
    return path


@pytest.mark.slow
def test_identify_writes_the_project_that_the_library_finds(tmp_path):
    (tmp_path / "axis.yaml").write_text(PROJECT, encoding="utf-8")
    log = measured()
    header = "time [s];current [mA];motor_angle [deg];pos [deg]"
    both = (np.degrees(log[a]) for a in ("motor_angle", "load_angle"))
    file = write(tmp_path / "run.csv", header, log["time"], 1e3 * current(log, 0.12), *both)
    run = invoke("identify", file, tmp_path / "axis.yaml", "-o", tmp_path / "out", "--column", "load_angle=pos")
    assert run.exit_code == 0, run.stderr
    same = sw.read_log(file, {"load_angle": "pos"}, trim=0.0)
    found = sw.identify_log(same, project=sw.read_project(tmp_path / "axis.yaml"))
    written = sw.read_project(tmp_path / "out" / "identified.yaml")
    assert pytest.approx(found.project.subject.law.K1, rel=1e-6) == written.subject.law.K1  # twelve digits in the file
    table = json.loads((tmp_path / "out" / "identified.json").read_text(encoding="utf-8"))
    assert table["numbers"]["B"]["low"] == pytest.approx(found.interval("B").low, rel=1e-5)
    assert "measured − predicted" in (tmp_path / "out" / "identified.svg").read_text(encoding="utf-8")
    assert table["numbers"]["torque_constant"]["value"] == pytest.approx(0.12, rel=0.01)
    assert pytest.approx(found.value("motor_inertia"), rel=1e-6) == written.subject.motor.J
    assert "% of current; " in table["said"][0]
    assert ">current (A)<" in (tmp_path / "out" / "identified.svg").read_text(encoding="utf-8")
    assert dict(written.scatter)["damping.B"] == pytest.approx(found.deviation("B") / found.value("B"), rel=1e-5)
    assert "next: strainwave analyze" in run.stdout
    low, high = map(
        float, re.search(r"within the confidence intervals: ([\d.]+) to ([\d.]+) arcsec", run.stdout).groups()
    )
    assert low <= np.max(written.response().oscillation) / ARCSEC <= high
    assert (table["usable"], table["headline"]) == (True, run.stdout.splitlines()[0])
    assert "coulomb and gravity mean; required: a reversal" in run.stdout


@pytest.mark.slow
def test_identify_writes_no_project_of_a_motion_that_is_not_explained(tmp_path):
    log = measured(line=(1.37, 3e-4))  # of an order that no such gear has
    header = "time [s];motor_angle [rad];load_angle [rad]"
    file = write(tmp_path / "run.csv", header, log["time"], log["motor_angle"], log["load_angle"])
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "identified.yaml").write_text("of another log", encoding="utf-8")
    run = invoke("identify", file, "--gear", "SHG-25-100", "--load-inertia", "2.2 kg*m^2", "-o", tmp_path / "out")
    assert run.exit_code == 1
    assert run.stdout.startswith("The model explains only")
    assert "The log shows a line of order 1.37 of the motor" in run.stdout.splitlines()[0]
    assert {f.name for f in (tmp_path / "out").iterdir()} == {"identified.json", "identified.svg"}
    assert "strainwave: no project file is written" in run.stderr
    assert "next:" not in run.stdout


def test_identify_asks_for_a_gear_and_a_log(tmp_path):
    (tmp_path / "axis.yaml").write_text(PROJECT, encoding="utf-8")
    assert "give one project file (.yaml) or --gear NAME" in invoke("identify", "log.csv").stderr
    assert "give at least one log" in invoke("identify", tmp_path / "axis.yaml").stderr


def spin(speed, delay, seconds=6.0, growth=1.0):
    """Two lines of a torsion at constant speed; a third stays with the time; order 2 grows."""
    t = np.arange(int(seconds * RATE)) / RATE
    angle, late = speed * t, speed * (t - delay)
    noise = 1e-6 * np.random.default_rng(int(speed)).standard_normal(len(t))
    x = (
        growth * 2e-4 * np.cos(2.0 * late + 0.3)
        + 5e-5 * np.cos(4.0 * late - 1.0)
        + 3e-5 * np.cos(2.0 * np.pi * 17.0 * t)
    )
    return t, angle, angle / 50.0 - x - noise


def test_order_scan_tells_lines_of_two_speeds(tmp_path):
    files = [
        write(tmp_path / f"{speed}.csv", "time [s];motor_angle [rad];load_angle [rad]", *spin(speed, 1e-3))
        for speed in (20.0, 33.0)
    ]
    options = ("--ratio", "50", "--angle", "motor_angle", "--trim", "0", "--highest", "20")
    run = invoke("order-scan", *files, *options, "--json")
    assert run.exit_code == 0, run.stderr
    found = json.loads(run.stdout)
    lines = {round(line["order"], 2): line for line in found["lines"]}
    assert {2.0, 4.0} <= set(lines)
    for order, amplitude, phase in ((2.0, 2e-4, 0.3), (4.0, 5e-5, -1.0)):
        low, high = lines[order]["amplitude_low"], lines[order]["amplitude_high"]
        assert abs(amplitude - 0.5 * (low + high)) < high - low  # four deviations
        assert abs(lines[order]["phase_rad"] - phase) < 4.0 * lines[order]["phase_error_rad"]
        assert lines[order]["kind"] == "order"
    (other,) = [line for line in found["lines"] if line["kind"] == "frequency"]
    assert other["frequency_hz"] == pytest.approx(17.0, abs=0.1)
    assert found["delay_s"] == pytest.approx(1e-3, abs=3.0 * found["delay_error_s"])
    run = invoke("order-scan", *files, *options, "-o", tmp_path / "out")
    assert "{order: 2, amplitude: 41.2" in run.stdout  # 2e-4 rad
    assert re.search(r"  17 Hz .* constant in time", run.stdout.replace("\n", " "))
    assert {f.name for f in (tmp_path / "out").iterdir()} == {"orders.csv", "orders.json", "orders.svg"}
    names = "time [s];motor_angle [rad];load_angle [rad]"
    files[1] = write(tmp_path / "grown.csv", names, *spin(33.0, 1e-3, growth=1.5))
    text = invoke("order-scan", *files, *options).stdout
    assert "no lines for a project file: the amplitude differs between the runs" in text
    assert "kinematic_error" not in text
    assert "of the orders 2: towards a resonance" in " ".join(text.split())


def test_order_scan_without_a_known_channel_names_those_there_are(tmp_path):
    t, angle, load = spin(20.0, 0.0, 1.0)
    file = write(tmp_path / "a.csv", "time [s];motor_angle [rad];load_angle [rad]", t, angle, load)
    run = invoke("order-scan", file)
    assert (run.exit_code, run.stdout) == (1, "")
    assert "a.csv has motor_angle, load_angle; name one of these with --channel, or give --ratio" in run.stderr
    assert "is no list of orders" in invoke("order-scan", file, "--orders", "1;2").stderr


def test_order_scan_takes_columns_by_place_and_prints_a_block_on_the_motors_turn(tmp_path):
    t = np.arange(5000) / 250.0
    angle = 0.5 * t + 0.3
    error = 1e-4 * np.cos(200.0 * angle + 0.4) + 1e-7 * np.random.default_rng(4).standard_normal(len(t))
    file = tmp_path / "data.log"
    np.savetxt(file, np.column_stack([np.arange(5000), t, angle, error]), fmt="%.9f")
    options = ("--channel", "error", "--columns", "-,time,load_angle,error", "--unit", "error=rad", "--trim", "0")
    text = invoke("order-scan", file, *options).stdout
    assert re.search(r"order 200 \+- 0", text)
    assert "a project file counts orders per motor turn: add --ratio to print its lines" in text
    assert "{order: 2, amplitude: 20.6" in invoke("order-scan", file, *options, "--ratio", "100").stdout
    places = [f"--column={channel}={i}" for channel, i in (("time", 1), ("load_angle", 2), ("error", 3))]
    assert invoke("order-scan", file, *places, *options[:2], *options[4:]).stdout == text
    assert "use only one of the two" in invoke("order-scan", file, *options, places[0]).stderr
    said = invoke("read-log", copy(file, tmp_path / "other.log")).stderr  # without the choice that is kept
    assert (
        "has 4 columns without names; give --columns time,load_angle,..., a name for each in its order, - for" in said
    )


def test_order_scan_prints_no_block_of_orders_that_the_angles_do_not_tell(tmp_path):
    angle = np.arange(72) * 5.0
    error = 12.0 * np.cos(200.0 * np.radians(angle)) + 0.3 * np.random.default_rng(5).standard_normal(72)
    file = write(tmp_path / "targets.csv", "angle [deg];error [arcsec]", angle, error)
    text = invoke("order-scan", file, "--shaft", "output", "--ratio", "100").stdout
    assert "order 16 may be order 200, 304, 704" in text
    assert "no lines for a project file" in text
    assert "kinematic_error" not in text
    assert (
        "too far to resolve any order"
        in invoke("order-scan", file, "--shaft", "output", "--turn", "motor", "--ratio", 100).stderr
    )


def test_the_torsion_of_a_slow_load_encoder_counts_at_its_samples(tmp_path):
    """A line at 32 Hz under 200 samples a second would lose 9 % between straight lines, sinc(32/200)^2."""
    t = np.arange(6000) / 1000.0
    load = t - 1e-4 * np.cos(200.0 * t)
    rows = [
        f"{a:.3f},{100.0 * a:.7f},{b:.9f}" if i % 5 == 0 else f"{a:.3f},{100.0 * a:.7f},"
        for i, (a, b) in enumerate(zip(t, load, strict=True))
    ]
    file = tmp_path / "slow.csv"
    file.write_text("\n".join(["time [s],motor_angle [rad],load_angle [rad]", *rows]))
    run = invoke("order-scan", file, "--ratio", 100, "--angle", "motor_angle", "--trim", 0, "--json")
    (line,) = json.loads(run.stdout)["lines"]
    assert line["order"] == pytest.approx(2.0, abs=0.01)
    assert 0.5 * (line["amplitude_low"] + line["amplitude_high"]) == pytest.approx(1e-4, rel=2e-3)


def test_order_scan_writes_a_sideband_of_the_output_as_a_line_of_both_turns(tmp_path):
    """Between angles of a gear of ratio 80 over 1.5 output turns at three speeds: 10 and 4 arcsec, by hand."""
    for i, speed in enumerate((80.0, 136.0, 200.0)):
        t = np.arange(int(1.5 * 2.0 * np.pi * 80.0 / speed * 500.0)) / 500.0
        motor = speed * t
        error = ARCSEC * (10.0 * np.cos(2.0 * motor + 0.4) + 4.0 * np.cos(2.0 * motor + motor / 80.0 - 1.0))
        noise = ARCSEC * np.random.default_rng(i).standard_normal(len(t))
        write(
            tmp_path / f"{i}.csv", "time [s];motor_angle [rad];load_angle [rad]", t, motor, motor / 80.0 - error - noise
        )
    text = invoke("order-scan", *(tmp_path / f"{i}.csv" for i in range(3)), "--ratio", "80", "--trim", "0").stdout
    rows = dict(re.findall(r"- \{order: (.+?), amplitude: ([\d.]+) arcsec", text))
    assert {order: round(float(size), 1) for order, size in rows.items()} == {
        "2": 10.0, "{wave_generator: 2, output: 1}": 4.0,
    }  # fmt: skip
