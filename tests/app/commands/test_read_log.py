"""`strainwave read-log`: what was read as a table, as JSON, as CSV and as a figure; its complaints."""

import json
import xml.etree.ElementTree as ET
from pathlib import Path
from shutil import copy

import numpy as np
import pytest
from click.testing import CliRunner

import strainwave as sw
from strainwave.app.commands import cli as command
from strainwave.app.console.library_words import in_options
from strainwave.drive.train_curve import NO_MOTION
from strainwave.drive.two_turns import NONE_STABLE, REMEDY, VARIATION_TEXT
from strainwave.numerics.curves.separate_motions import BY_HAND, FROM_STARTS

JOINT = Path(__file__).parents[2] / "measured/kinova_gen3/joint_5.csv"


def invoke(*given):
    return CliRunner().invoke(command.cli, ["read-log", *map(str, given)])


def test_the_command_tells_channels_segments_and_notes_and_writes_what_it_read(tmp_path):
    path = Path(copy(JOINT, tmp_path))
    run = invoke(path, "-o", tmp_path / "out", "--column", "torque=torque_from_current_Nm")
    assert run.exit_code == 0, run.output
    for text in (
        "5854 samples, 0 to 5.853 s, 1000 Hz",
        "load_speed",
        "N·m",
        "constant speed",
        "run-down",
        "note: channels",
    ):
        assert text in run.stdout
    log = sw.read_log(JOINT, {"torque": "torque_from_current_Nm"})
    again = sw.read_log(tmp_path / "out/log.csv")
    assert all(np.array_equal(again.channels[name], values) for name, values in log.channels.items())
    figure = ET.parse(tmp_path / "out/log.svg").getroot()
    texts = ["".join(node.itertext()) for node in figure.iter() if node.tag.endswith("text")]
    for text in ("load angle (rad)", "torque (N·m)", "time (s)", "run-up", "constant speed, 0.366 rad/s"):
        assert text in texts
    bands = [node for node in figure.iter() if node.get("fill-opacity") and node.tag.endswith("path")]
    assert len(bands) == 2 * len(log.channels)  # run-up and run-down in every panel


def test_the_choice_of_columns_is_kept_beside_the_log_for_every_face(tmp_path):
    path = tmp_path / "run.csv"
    path.write_text("\n".join(f"{0.002 * k},{0.36 * k},7" for k in range(3000)))
    chosen = invoke(path, "--columns", "time,load_angle,-", "--unit", "load_angle=deg")
    assert chosen.exit_code == 0, chosen.output
    assert "note: the choice of columns is saved in run.csv.columns.json" in chosen.stdout
    again = invoke(path)
    assert again.exit_code == 0, again.output
    assert "note: columns and units were read from run.csv.columns.json" in again.stdout
    assert sw.read_log(path).channels["load_angle"][-1] == pytest.approx(np.radians(0.36 * 2999), rel=1e-12)
    unit = invoke(path, "--unit", "load_angle=arcmin")  # of the columns that are kept
    assert unit.exit_code == 0, unit.output
    assert sw.read_log(path).channels["load_angle"][-1] == pytest.approx(np.radians(0.36 * 2999 / 60.0), rel=1e-12)
    copy(path.with_name("run.csv.columns.json"), tmp_path / "named.csv.columns.json")
    (tmp_path / "named.csv").write_text("t [s],q [rad]\n" + "\n".join(f"{0.002 * k},{0.1 * k}" for k in range(30)))
    with pytest.raises(ValueError, match=r"named.csv.columns.json.* does not match the columns of named.csv"):
        sw.read_log(tmp_path / "named.csv")
    other = invoke(path, "--columns", "time,-,load_angle")  # options come first, and are kept in turn
    assert other.exit_code == 0, other.output
    assert np.all(sw.read_log(path).channels["load_angle"] == 7.0)
    (tmp_path / "run.csv.columns.json").write_text("{half")
    refused = invoke(path)
    assert refused.exit_code != 0
    assert "run.csv.columns.json" in refused.stderr
    assert "delete it" in refused.stderr


def test_json_has_the_same():
    data = json.loads(invoke(JOINT, "--json", "--trim", 0.5).stdout)
    log = sw.read_log(JOINT, trim=0.5)
    assert data["samples"] == len(log)
    assert data["start_s"] == 0.5
    assert data["channels"]["current"]["rms"] == np.sqrt(np.mean(log.channels["current"] ** 2))
    assert [part["kind"] for part in data["segments"]] == [part.kind for part in log.segments()]
    assert data["notes"] == list(log.notes)
    assert data["doubts"] == data["gaps"] == []


def test_columns_and_units_without_names_in_the_file(tmp_path):
    path = tmp_path / "run.txt"
    np.savetxt(path, np.column_stack([np.arange(50.0), 3.0 * np.arange(50.0), np.ones(50)]))
    options = ("--columns", "torque,load_angle,-", "--unit", "load_angle=deg", "--rate", 100)
    data = json.loads(invoke(path, *options, "--json").stdout)
    assert list(data["channels"]) == ["torque", "load_angle"]
    assert data["channels"]["load_angle"]["largest"] == np.radians(147.0)
    assert data["stop_s"] == 0.49


def test_complaints_are_one_sentence_and_nothing_is_written(tmp_path):
    (tmp_path / "log.csv").write_text("time;current\n1.234;5.678\n2.345;6.789\n3.456;7.891\n")
    run = invoke(tmp_path / "log.csv", "-o", tmp_path / "out")
    assert run.exit_code == 3
    assert run.stderr.count("\n") == 1
    assert "can be read in two ways" in run.stderr
    assert not (tmp_path / "out").exists()
    run = invoke(JOINT, "--unit", "load_angle")
    assert run.exit_code == 2
    assert "'load_angle' is not CHANNEL=UNIT" in run.stderr
    run = invoke(JOINT, "--columns", "a,b,c,d,e", "--column", "a=1")
    assert run.exit_code == 2
    assert "use only one of the two" in run.stderr


@pytest.mark.parametrize(
    ("sentence", "typed"),
    [
        ("give columns=['time', 'load_angle', ...], a", "give --columns time,load_angle,..., a"),
        ("give columns={'time': ...}, or rate", "give --column time=..., or --rate"),
        ("place, columns={'torque': 3, 'torque 2': 4}", "place, --column torque=3 --column 'torque 2=4'"),
        ("units={'load_angle': 'deg/s'} if", "--unit load_angle=deg/s if"),
        ("load_angle in rad: units= says what", "load_angle in rad: --unit says what"),
        ("trim=0 keeps them", "--trim 0 keeps them"),
        ("the units are rad", "the units are rad"),
        *(
            (f"more: {text}", "more: strainwave speed-map looks for them from random starts")
            for text in (BY_HAND, FROM_STARTS)
        ),
        (NO_MOTION, NO_MOTION.split(", drive_run")[0]),
        (NONE_STABLE, "no steady motion of this drive is stable in this range"),
        (f"{VARIATION_TEXT}.", VARIATION_TEXT.replace(", or integrate with simulate", ".")),
        (
            f"control: {REMEDY}",
            "control: remove the error orders of the output turn; strainwave move integrates the drive in time",
        ),
        ("give the motor a loop, or use find_orbit(SteadyTrain(train, omega))", "give the motor a loop"),
        ("know no speed; choose one with at_speed(...)", "know no speed; choose one with --speed"),
    ],
)
def test_sentences_name_options_in_place_of_calls(sentence, typed):
    assert in_options(sentence) == typed


def test_complaints_and_doubts_name_options(tmp_path):
    path = tmp_path / "log.csv"
    t = 0.01 * np.arange(200.0)
    np.savetxt(path, np.column_stack([t, t]), header="position,velocity", comments="", delimiter=",")
    assert "give --column time=..., or --rate" in invoke(path).stderr
    np.savetxt(
        path, np.column_stack([t, 0.0 * t + 57.3, t]), header="time,velocity,position", comments="", delimiter=","
    )
    assert "in deg/s, --unit load_speed=deg/s" in invoke(path).stdout
    np.savetxt(path, np.column_stack([t, t]))
    assert "give --columns time,load_angle,..." in invoke(path).stderr
