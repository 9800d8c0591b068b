"""Bags of ROS 2 in MCAP files, written by the library itself."""

import json
from io import BytesIO

import numpy as np
import pytest

import strainwave as sw

writers = pytest.importorskip("mcap_ros2.writer", reason="mcap-ros2-support (extra `logs`) is not installed")
JOINT_STATE = """std_msgs/Header header
string[] name
float64[] position
float64[] velocity
float64[] effort
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
"""
T = np.arange(50) / 250.0


def bag():
    """Two joints at 250 Hz and a topic of one number at 50 Hz, without a stamp."""
    stream = BytesIO()
    writer = writers.Writer(stream)
    state = writer.register_msgdef("sensor_msgs/msg/JointState", JOINT_STATE)
    heat = writer.register_msgdef("std_msgs/msg/Float64", "float64 data")
    for i, t in enumerate(T):
        nanoseconds = 1_700_000_000_123_456_789 + round(1e9 * t)
        header = {"stamp": {"sec": nanoseconds // 10**9, "nanosec": nanoseconds % 10**9}, "frame_id": "base"}
        message = {"header": header, "name": ["base", "elbow"], "position": [0.0, np.sin(t)]}
        message |= {"velocity": [0.0, np.cos(t)], "effort": [1.0, 2.0 + t]}
        writer.write_message("/joint_states", state, message, log_time=nanoseconds + 7_000_000)
        if i % 5 == 0:
            writer.write_message("/heat", heat, {"data": 20.0 + t}, log_time=nanoseconds)
    writer.finish()
    return stream.getvalue()


def test_a_joint_of_a_bag_is_read_at_the_times_of_its_stamps(tmp_path):
    (tmp_path / "bag.mcap").write_bytes(bag())
    log = sw.read_log(tmp_path / "bag.mcap", joint="elbow")
    common = T[:46]  # up to the last value of the other topic
    assert log.time == pytest.approx(common, abs=1e-12)
    assert log.channels["load_angle"] == pytest.approx(np.sin(common), abs=1e-12)
    assert log.channels["load_speed"] == pytest.approx(np.cos(common), abs=1e-12)
    slow = sw.read_log(tmp_path / "bag.mcap", {"load_angle": "/joint_states/elbow/position", "heat": "/heat/data"})
    assert slow.own["heat"][0] == pytest.approx(T[::5], abs=1e-12)
    assert slow.own["heat"][1] == pytest.approx(20.0 + T[::5], abs=1e-12)


def test_a_bag_that_is_cut_off_is_refused_in_a_sentence(tmp_path):
    whole = bag()
    for length in (0, 4, len(whole) // 2, len(whole) - 9):
        (tmp_path / "cut.mcap").write_bytes(whole[:length])
        with pytest.raises(ValueError, match=r"cut\.mcap:1:1: is not a complete MCAP file \(.+\); `mcap recover`"):
            sw.read_log(tmp_path / "cut.mcap")


def test_messages_in_json_are_read_and_others_named(tmp_path):
    module = pytest.importorskip("mcap.writer")
    with (tmp_path / "own.mcap").open("wb") as file:
        writer = module.Writer(file)
        writer.start()
        schema = writer.register_schema("joint", "jsonschema", b"{}")
        own = writer.register_channel("/joint", "json", schema)
        other = writer.register_channel("/image", "protobuf", schema)
        for t in T:
            content = json.dumps({"motor_angle": 100.0 * t, "load_angle": t}).encode()
            writer.add_message(own, round(1e9 * t), content, round(1e9 * t))
            writer.add_message(other, round(1e9 * t), b"\x01", round(1e9 * t))
        writer.finish()
    log = sw.read_log(tmp_path / "own.mcap")
    assert log.channels["motor_angle"] == pytest.approx(100.0 * T, rel=1e-12)
    assert any("/image" in note for note in log.notes)
