"""Logs as recorders write them: text beside numbers, stamps in two parts, a time for each channel, several joints."""

import gzip

import numpy as np
import pytest

import strainwave as sw
from strainwave.files.logs.scan_file import read_scan

T = np.arange(500) / 250.0
Q = 0.4 * T


def write(path, *lines):
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def test_columns_of_text_beside_numbers_cost_nothing(tmp_path):
    names = "%time,field.header.frame_id,field.name0,field.name1,field.position0,field.position1,field.effort1"
    rows = [f"{1.7e18 + t * 1e9:.0f},,elbow,wrist,{0.1:.6f},{q:.6f},{3 * q:.6f}" for t, q in zip(T, Q, strict=True)]
    path = write(tmp_path / "joint_states.csv", names, *rows)
    log = sw.read_log(path, joint="wrist", trim=0)
    assert log.channels == {"load_angle": pytest.approx(Q, abs=1e-6), "torque": pytest.approx(3 * Q, abs=1e-6)}
    assert log.rate == pytest.approx(250.0, rel=1e-6)
    assert "elbow/position, wrist/position may each be load_angle" in " ".join(sw.read_log(path).notes)
    with pytest.raises(ValueError, match="has no column of the joint 'knee'; it has time, "):
        sw.read_log(path, joint="knee")
    with pytest.raises(ValueError, match="column 2 of torque holds text, 'elbow'; name another"):
        sw.read_log(path, {"torque": 2})
    german = [f"{t:.3f};fährt;{q:.6f}".replace(".", ",") for t, q in zip(T, Q, strict=True)]
    found = sw.read_log(write(tmp_path / "german.csv", "Zeit [s];Modus;Winkel [rad]", *german), trim=0)
    assert found.channels["load_angle"] == pytest.approx(Q, abs=1e-6)
    packed = tmp_path / "german.csv.gz"
    packed.write_bytes(gzip.compress((tmp_path / "german.csv").read_bytes()))
    assert np.array_equal(sw.read_log(packed, trim=0).channels["load_angle"], found.channels["load_angle"])
    packed.write_bytes(packed.read_bytes()[:-20])
    with pytest.raises(ValueError, match=r"csv\.gz:1:1: file: cannot be read"):
        sw.read_log(packed)


def test_seconds_and_nanoseconds_are_one_time_and_an_index_is_no_unit(tmp_path):
    ns = np.round(T * 1e9).astype(int)
    rows = [f"{1700000000 + n // 10**9} {n % 10**9} {0.1:.6f} {q:.6f}" for n, q in zip(ns, Q, strict=True)]
    path = write(tmp_path / "iiwa.log", "ZeitInSec ZeitInNanoSec axis_position[0] axis_position[1]", *rows)
    log = sw.read_log(path, joint="1", columns={"load_angle": "axis_position"}, trim=0)
    assert log.time == pytest.approx(T, abs=1e-12)
    assert log.channels["load_angle"] == pytest.approx(Q, abs=1e-6)
    with pytest.raises(ValueError, match=r"time: has 11 times for 500 samples; name another column, or give rate"):
        sw.read_log(write(tmp_path / "coarse.csv", "t,x", *[f"{t:.1f},{q}" for t, q in zip(T / 2, Q, strict=True)]))
    echo = [f"{1700000000 + n // 10**9},{n % 10**9},,a,b,0.5,{q:.6f},0,0.4" for n, q in zip(ns, Q, strict=True)]
    found = sw.read_log(write(tmp_path / "echo.csv", *echo), joint="b", trim=0)
    assert found.channels == {"load_angle": pytest.approx(Q, abs=1e-6), "load_speed": pytest.approx(0.4)}


def test_each_channel_of_a_scope_keeps_its_time_where_others_have_ended(tmp_path):
    head = [
        "Name\tScope", "\tx", "Name\tActPos\tName\tActTorque", "SampleTime[ms]\t4\tSampleTime[ms]\t20",
        "Unit\tdeg\tUnit\t(None)", "Unit Offset\t0\tUnit Offset\t0",
    ]  # fmt: skip
    rows = []
    for i, (t, q) in enumerate(zip(T, Q, strict=True)):
        at, value = {7: (120, "14.000"), 50: (1000, "nan")}.get(i, (20 * i, f"{2.0 * i:.3f}"))
        slow = f"\t{at}\t{value}" if i < 100 else ""
        rows.append((f"{1e3 * t:.0f}\t{np.degrees(q):.6f}" + slow).replace(".", ","))
    log = sw.read_log(write(tmp_path / "scope.csv", *head, *rows), trim=0)
    known = log.time <= 1.98
    assert log.channels["load_angle"][known] == pytest.approx(Q[: len(log)][known], abs=1e-7)
    assert {
        "1 sample of torque with inf or NaN omitted",
        "1 sample of torque at the time of the one before left out",
    } <= {*log.notes}
    torque = log.channels["torque"]
    assert torque[known & np.isfinite(torque)] == pytest.approx(100.0 * log.time[known & np.isfinite(torque)], abs=1e-3)


def test_turns_and_steps_of_an_encoder_are_asked_and_milliseconds_doubted(tmp_path):
    rows = [f"{1000 * t:.0f},{q:.6f},{100 * q / 6.2831853 * 2**24:.0f}" for t, q in zip(T, Q, strict=True)]
    path = write(tmp_path / "lara.csv", "Timestamp,encoder_pos_1,encoder_motorinc_1", *rows)
    with pytest.raises(
        ValueError, match=r"motor_angle: 'encoder_motorinc' counts turns or steps.*units={'motor_angle'"
    ):
        sw.read_log(path, joint="1")
    log = sw.read_log(path, joint="1", units={"motor_angle": f"{360 / 2**24!r} deg"}, trim=0)
    assert log.ratio == pytest.approx(100.0, rel=1e-6)
    (doubt,) = log.doubts
    assert doubt == "time goes on by 4 a sample and has no unit: is it in ms? units={'time': 'ms'}"
    path = write(
        tmp_path / "odrive.csv", "time [ms],axis0.encoder.pos_estimate", *[row.rsplit(",", 1)[0] for row in rows]
    )
    with pytest.raises(ValueError, match=r"counts turns or steps of an encoder, and no unit says which; give units="):
        sw.read_log(path)
    turns = sw.read_log(path, units={"load_angle": "rev"}, trim=0).channels["load_angle"]
    assert turns == pytest.approx(2 * np.pi * Q, abs=1e-5)


def test_a_guide_log_is_a_scan_of_the_axis_without_what_the_pulses_took_out(tmp_path):
    t = np.arange(600) * 2.0
    true = 15.0 * np.cos(2.0 * np.pi * t / 430.8)  # arcsec
    seen, pulse, place = [], [], 0.0
    for error in true / 3.2:  # px; each pulse takes half of what is seen out of all that follows
        seen.append(error - place)
        pulse.append(0.5 * seen[-1])
        place += pulse[-1]
    head = [
        "PHD2 version 2.6.13, Log version 2.5.", "", "Guiding Begins at 2026-06-05 22:01:10",
        "Pixel scale = 3.20 arc-sec/px, Binning = 1",
        "Frame,Time,mount,dx,dy,RARawDistance,DECRawDistance,RAGuideDistance,RADirection",
    ]  # fmt: skip
    rows = [
        f'{i},{a:.3f},"Mount",0,0,{b:.6f},0,{c:.6f},W' for i, (a, b, c) in enumerate(zip(t, seen, pulse, strict=True))
    ]
    rows[7] = '7,14.0,"DROP",,,,,,'
    path = write(tmp_path / "PHD2_GuideLog.txt", *head, *rows[:300], "INFO: dither", *rows[300:], "Guiding Ends at x")
    log = sw.read_log(path, trim=0)
    kept = np.delete(np.arange(600), 7)
    assert log.channels["load_angle"] == pytest.approx(2 * np.pi * t[kept] / 86_164.0905, rel=1e-9)
    off = np.degrees(log.channels["error"]) * 3600.0 - true[kept]
    # the pulse beside the frame that was lost is not known
    assert np.ptp(off[7:]) < 1e-3
    assert np.array_equal(read_scan(path).error, log.channels["error"])
    with pytest.raises(ValueError, match="is a guide log without a guided stretch"):
        sw.read_log(write(tmp_path / "empty.txt", *head))


def test_one_long_line_is_refused(tmp_path):
    with pytest.raises(
        ValueError, match=r"long\.csv:2:1: file: has 2000000 characters in one line; give a log with a line"
    ):
        sw.read_log(write(tmp_path / "long.csv", "time,torque", "1," * 1_000_000))


def test_the_number_of_the_only_joint_is_no_part_of_a_channel(tmp_path):
    rows = "".join(f"{0.01 * i},{0.5 * i},{50 * i},{i}\n" for i in range(40))
    (tmp_path / "one.csv").write_text("time,encoder_loadinc_1,encoder_motorinc_1,target_2\n" + rows)
    log = sw.read_log(tmp_path / "one.csv", units={"load_angle": "deg", "motor_angle": "deg"})
    assert np.ptp(log.channel("motor_angle")) == pytest.approx(100.0 * np.ptp(log.channel("load_angle")))
    assert "target_2" in log.channels
