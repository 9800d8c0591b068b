"""A log: its rate, gaps, stretches of motion, parts and files."""

import numpy as np
import pytest

import strainwave as sw
from strainwave.study.identification.channels import with_torsion

RNG = np.random.default_rng(7)


def motion(times, speeds, *, rate=500.0, noise=0.0):
    """A log of load angle and speed whose speed goes through these points by straight lines."""
    t = np.arange(int(times[-1] * rate) + 1) / rate
    v = np.interp(t, times, speeds)
    angle = np.concatenate([[0.0], np.cumsum(0.5 * (v[1:] + v[:-1]) / rate)])
    speed = v + noise * RNG.standard_normal(len(t))
    return sw.Log(t, {"load_angle": angle, "load_speed": speed, "torque": 3.0 + v})


STAIRS = ([0, 1, 1.5, 3, 3.5, 5, 6, 7], [0, 0, 0.5, 0.5, 2.0, 2.0, 0.0, 0.0])


@pytest.mark.parametrize("noise", [0.0, 0.05])
@pytest.mark.parametrize("drop", [(), ("load_speed",), ("load_angle",)])
def test_stretches_of_rest_constant_speed_and_ramps_are_found(noise, drop):
    log = motion(*STAIRS, noise=noise)
    log = sw.Log(log.time, {name: v for name, v in log.channels.items() if name not in drop})
    parts = log.segments(0.08)
    assert [part.kind for part in parts] == [
        "still", "run-up", "constant speed", "run-up", "constant speed", "run-down", "still"
    ]  # fmt: skip
    starts = np.array([part.start for part in parts])
    assert starts == pytest.approx(STAIRS[0][:-1], abs=0.15)
    assert parts[2].speed == pytest.approx(0.5, abs=0.05)
    assert parts[4].speed == pytest.approx(2.0, abs=0.05)
    assert parts[5].acceleration == pytest.approx(-2.0, rel=0.1)
    # whole and without overlap
    rows = [part.rows for part in parts]
    assert [rows[0].start, *(r.stop for r in rows)] == [*(r.start for r in rows), len(log)]


def test_the_way_back_is_a_run_up_too():
    log = motion([0, 1, 2, 4, 5, 6], [1.0, 1.0, -1.0, -1.0, 0.0, 0.0])
    assert [(part.kind, np.sign(part.speed).item()) for part in log.segments()[:4]] == [
        ("constant speed", 1.0), ("run-down", 1.0), ("run-up", -1.0), ("constant speed", -1.0)
    ]  # fmt: skip


def test_a_vibration_is_neither_constant_nor_a_ramp_and_rest_is_rest():
    t = np.arange(4001) / 500.0
    shaken = sw.Log(t, {"load_speed": np.sin(2 * np.pi * 40.0 * t / 8.0 * 4.0)})
    assert {part.kind for part in shaken.segments()} == {"other"}
    rest = sw.Log(t, {"motor_angle": 1e-6 * RNG.standard_normal(len(t))})
    (part,) = rest.segments()
    assert part.kind == "still"
    with pytest.raises(ValueError, match=r"segments need the angle or the speed of a shaft.*the channels are torque"):
        sw.Log(t, {"torque": t}).segments()
    with pytest.raises(ValueError, match="the tolerance is 2"):
        shaken.segments(2.0)


def test_no_stretch_goes_across_a_gap():
    whole = motion([0, 8], [1.0, 1.0])
    keep = (whole.time < 3.0) | (whole.time > 4.0)
    log = sw.Log(whole.time[keep], {name: v[keep] for name, v in whole.channels.items()})
    (gap,) = log.gaps
    assert gap == pytest.approx((2.998, 4.002))
    first, second = log.segments()
    assert (first.stop, second.start) == gap
    assert log.rate == pytest.approx(500.0)
    assert [r.stop - r.start for r in log.unbroken()] == [1500, 2000]


def test_a_part_of_a_log_is_a_run():
    log = motion(*STAIRS)
    part = log.segments()[2]
    run = log.run("torque", part=part)
    assert np.array_equal(run.angle, log.channels["load_angle"][part.rows])
    assert np.array_equal(run.value, log.channels["torque"][part.rows])
    assert run.unit == "N*m"
    cut = log.cut(part.start, part.stop)
    assert np.array_equal(cut.time, run.time)
    assert cut.channel("torque") is cut.channels["torque"]
    with pytest.raises(ValueError, match="no channel 'current'; it has load_angle, load_speed, torque"):
        log.run("current")
    with pytest.raises(ValueError, match=r"fewer than two samples are within 8 \.\. 9 s; the log has 0 \.\. 7 s"):
        log.cut(8.0, 9.0)


def test_a_log_that_cannot_be_is_refused():
    t = np.arange(3.0)
    with pytest.raises(ValueError, match="finite and ascending"):
        sw.Log(t[::-1], {})
    with pytest.raises(ValueError, match=r"channel 'torque' has the shape \(2,\); give 3 finite values"):
        sw.Log(t, {"torque": t[:2]})
    with pytest.raises(ValueError, match="give 3 finite values"):
        sw.Log(t, {"torque": t * np.nan})


def test_angles_that_no_gear_of_the_ratio_has_are_refused():
    motor = np.linspace(0.0, 100.0, 200)
    angles = {"motor_angle": motor, "load_angle": -motor / 50.0 + 1e-3 * np.sin(motor)}
    assert with_torsion(angles, 50.0)["torsion"] == pytest.approx(1e-3 * np.sin(motor), abs=1e-12)
    with pytest.raises(ValueError, match=r"turns 100 rad and load_angle 2\.\d* rad: the ratio is not 60; use"):
        with_torsion(angles, 60.0)


def test_units_of_canonical_channels_are_known_and_ratio_is_that_of_the_motions():
    log = motion(*STAIRS)
    assert log.units == {"load_angle": "rad", "load_speed": "rad/s", "torque": "N*m"}
    assert log.ratio is None
    both = sw.Log(log.time, log.channels | {"motor_angle": 7.0 - 101.0 * log.channels["load_angle"]})
    assert both.ratio == pytest.approx(101.0)
    speeds = sw.Log(
        log.time, {"load_speed": log.channels["load_speed"], "motor_speed": 50 * log.channels["load_speed"]}
    )
    assert speeds.ratio == pytest.approx(50.0)
    data = log.to_xarray()
    assert data["torque"].attrs["units"] == "N*m"
    assert np.array_equal(data["time"], log.time)


def test_a_log_reads_back_from_its_files(tmp_path):
    log = motion(*STAIRS, noise=0.1)
    found = sw.load(log.save(tmp_path / "log.nc"))
    assert found.units == log.units
    assert all(np.array_equal(found.channels[key], values) for key, values in log.channels.items())
    with pytest.raises(ValueError, match=r"use a name that ends in .* or \.csv"):
        log.save(tmp_path / "log.txt")
    again = sw.read_log(log.save(tmp_path / "log.csv"), trim=0.0)
    assert np.array_equal(again.channels["torque"], log.channels["torque"])


def test_slow_steps_of_a_staircase_are_told_from_each_other():
    speeds = [0.02, 0.05, 0.1, 0.3, 0.9]
    times, values = [0.0], [0.0]
    for i, speed in enumerate(speeds):
        times += [4.0 * i + 1.0, 4.0 * i + 4.0]
        values += [speed, speed]
    parts = motion(times, values, noise=1e-3).segments()
    found = [part.speed for part in parts if part.kind == "constant speed"]
    assert found == pytest.approx(speeds, rel=0.03)
