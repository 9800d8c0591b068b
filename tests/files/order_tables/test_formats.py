"""Formats of order tables: read back, as the machine plays them, and refused where they cannot hold a table."""

import dataclasses
import math
import re

import numpy as np
import order_machines as machines
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from order_machines import ANGLE, ARCSEC, DEGREE, NO_REMARKS, OPTIONS, TORQUE, TWO_WAYS, table_for
from scipy.interpolate import RegularGridInterpolator

import strainwave as sw
from strainwave.files.order_tables.format import Held
from strainwave.files.order_tables.order_table import FORMATS

TURN = np.linspace(0.0, 2.0 * math.pi, 20_000, endpoint=False)  # of the encoder on the table's shaft
EXACT = ("json", "csv", "c", "st", "hal")
ROUNDED = tuple(name for name in OPTIONS if name not in EXACT)


def written(tmp_path, name, table=None, **changes):
    """Text of a file and its residual."""
    table = table_for(name) if table is None else table
    left = table.write(tmp_path / "table.txt", name, **(OPTIONS[name] | changes))
    return (tmp_path / "table.txt").read_text(encoding="utf-8"), left


def read_back(tmp_path, name, **changes):
    return sw.OrderTable.read(tmp_path / "table.txt", **((OPTIONS[name] | changes) if name in NO_REMARKS else {}))


def test_every_format_is_tested_here():
    assert set(OPTIONS) == set(FORMATS)


@pytest.mark.parametrize("name", EXACT)
def test_files_of_lines_read_back_equal_to_the_bit(tmp_path, name):
    for table in (ANGLE, TWO_WAYS, dataclasses.replace(ANGLE, delay=1e-3, speeds=(1.0, 300.0), load=-20.0)):
        _, left = written(tmp_path, name, table)
        assert read_back(tmp_path, name) == table
        assert left.rms == left.peak == left.quantum == 0.0
    for direction in ("forward", "backward"):
        table = dataclasses.replace(ANGLE, direction=direction, mean=1e-5)
        written(tmp_path, name, table)
        assert read_back(tmp_path, name) == table


@pytest.mark.parametrize("name", ROUNDED)
def test_other_files_read_back_to_their_quantum_and_are_written_again_alike(tmp_path, name):
    table = table_for(name)
    text, left = written(tmp_path, name)
    found = read_back(tmp_path, name)
    assert found.unit == table.unit
    if name not in NO_REMARKS:
        assert found.on_turn(table.turn).zero == pytest.approx(table.zero, abs=1e-15)
        assert found.source == table.source
    kept = found.on_turn(table.turn).keep(table.orders)
    assert kept.orders == table.orders
    # Amplitudes of the right lines: rounding of the values by at most half a quantum, as a square wave at worst.
    for line, back in zip(table.lines, kept.lines, strict=True):
        assert abs(line.amplitude - back.amplitude) <= 0.5 * left.quantum * 4.0 / math.pi + 1e-12 * line.amplitude
    same = {"points": left.points} if name in ("points", "sinumerik", "twincat", "linuxcnc") else {}
    again, second = written(tmp_path, name, found, **same)
    if left.quantum > 0.0:
        assert data_of(again) == data_of(text)
    assert second.quantisation <= 1e-6 * left.quantum or name in ("beckhoff", "linuxcnc")  # 32 bits


def data_of(text):
    """The file without remarks, of which the residual changes when a rounded table is written again."""
    return [line for line in text.splitlines() if not re.match(r"\s*(#|//|;|\(\*)", line)]


@pytest.mark.parametrize("name", ROUNDED)
def test_points_read_back_are_the_points_of_the_file(tmp_path, name):
    table = table_for(name)
    _, left = written(tmp_path, name)
    found = read_back(tmp_path, name).on_turn(table.turn)
    count = left.points or 1024
    if name == "linuxcnc":
        angle = table.zero + ANGLE.ratio * DEGREE * (-18.0 + 36.0 * np.arange(255) / 255)
    else:
        angle = table.zero + 2.0 * math.pi * np.arange(count) / count
        if name in ("twincat", "sinumerik"):
            angle = table.zero + 120.0 * 2.0 * math.pi * np.arange(count - 1) / (count - 1)
    shift = table.zero if name in NO_REMARKS else 0.0
    expected, got = table.value(angle), found.value(angle - shift)
    if name == "onstepx":  # a constant has no effect there
        expected, got = expected - np.mean(expected), got - np.mean(got)
    slack = 1e-12 * np.max(np.abs(expected)) + (
        6e-8 * np.max(np.abs(expected)) if name in ("linuxcnc", "beckhoff") else 0
    )
    assert np.max(np.abs(expected - got)) <= (1.0 if name == "onstepx" else 0.5) * left.quantum * 1.0001 + slack


def played(name, text, backward=False):
    """What the machine adds at TURN, in the unit of the table, by the code of the machine."""
    output = TURN / ANGLE.ratio / DEGREE  # degrees of the joint, over one turn of the motor
    if name == "moteus":
        return machines.moteus(text, 0.05, TURN)
    if name == "beckhoff":
        return machines.beckhoff(text, TURN)
    if name == "linuxcnc":
        return machines.linuxcnc(text, output, -1.0 if backward else 1.0) * DEGREE
    if name == "sinumerik":  # what is added to the actual position moves the axis the other way
        return -machines.sinumerik(text, output) * DEGREE
    assert name == "twincat"
    return machines.twincat(text, output) * DEGREE


@pytest.mark.parametrize("name", ["moteus", "beckhoff", "linuxcnc", "sinumerik", "twincat"])
def test_the_machine_adds_the_table_but_for_the_predicted_residual(tmp_path, name):
    table = table_for(name)
    text, left = written(tmp_path, name)
    missing = played(name, text) - table.value(TURN + table.zero)
    # LinuxCNC and the axes on the output turn are looked at over one turn of the motor of many
    assert np.max(np.abs(missing)) == pytest.approx(left.peak, rel=0.03)
    assert np.sqrt(np.mean(missing**2)) == pytest.approx(left.rms, rel=0.03)
    assert 0.0 < left.rms < 0.05 * table.rms


def test_the_mount_adds_the_table_but_for_the_predicted_residual(tmp_path):
    text, left = written(tmp_path, "onstepx")
    seconds, steps = machines.onstepx(text, 25_600.0)
    assert len(seconds) == 86400 // 120 + 1
    assert steps[-1] == 0.0  # the mount does not drift
    position = np.interp(TURN / (2.0 * math.pi) * seconds[-1], seconds, steps) / 25_600.0 * DEGREE
    missing = position - ANGLE.value(TURN + ANGLE.zero)
    missing -= np.mean(missing)
    assert np.max(np.abs(missing)) == pytest.approx(left.peak, rel=0.03)
    assert np.sqrt(np.mean(missing**2)) == pytest.approx(left.rms, rel=0.03)
    assert left.quantum == pytest.approx(DEGREE / 25_600.0)


@pytest.mark.parametrize("name", ["linuxcnc", "sinumerik", "twincat"])
def test_a_gear_with_the_written_error_points_where_it_is_sent(tmp_path, name):
    # theta_l = theta_m/N - e(theta_m): the motor is sent to N (reference + what the control adds).
    error = dataclasses.replace(ANGLE, sign="error")
    text, left = written(tmp_path, name, error)
    reference = TURN / ANGLE.ratio
    motor = ANGLE.ratio * (reference + played(name, text))
    load = motor / ANGLE.ratio - error.value(motor + error.zero)
    slope = ANGLE.ratio * sum(line.order * line.amplitude for line in ANGLE.lines)  # the table is read at the reference
    assert np.max(np.abs(load - reference)) <= left.peak + slope * error.rms * 3.0
    assert np.max(np.abs(load - reference)) < 0.1 * np.max(np.abs(error.value(TURN)))


def test_a_disturbing_torque_is_written_with_the_opposite_sign(tmp_path):
    text, _ = written(tmp_path, "moteus", dataclasses.replace(TORQUE, sign="error"))
    disturbance = TORQUE.value(TURN + TORQUE.zero)
    assert np.max(np.abs(machines.moteus(text, 0.05, TURN) + disturbance)) < 0.01 * np.max(np.abs(disturbance))


def test_both_directions_reach_the_machines_that_hold_them(tmp_path):
    output = TURN / 50.0 / DEGREE
    text, left = written(tmp_path, "linuxcnc", TWO_WAYS, span=(0.0, 7.2))
    for velocity in (1.0, -1.0):
        missing = machines.linuxcnc(text, output, velocity) * DEGREE - TWO_WAYS.value(TURN - 0.2, velocity)
        assert np.max(np.abs(missing)) <= left.peak * 1.01
    found = sw.OrderTable.read(tmp_path / "table.txt").keep(TWO_WAYS.orders)
    assert found.mean_backward == pytest.approx(-5 * ARCSEC, abs=left.quantum)
    text, left = written(tmp_path, "twincat", TWO_WAYS)
    assert text.count("WorkDirectionPositive") == text.count("WorkDirectionNegative") == 1
    for which, velocity in (("Positive", 1.0), ("Negative", -1.0)):
        missing = machines.twincat(text, output, which) * DEGREE - TWO_WAYS.value(TURN - 0.2, velocity)
        assert np.max(np.abs(missing)) <= left.peak * 1.01
    found = sw.OrderTable.read(tmp_path / "table.txt").on_turn("motor")
    for line, back in zip(TWO_WAYS.backward, found.keep((2, 3)).backward, strict=True):
        assert back.amplitude == pytest.approx(line.amplitude, rel=1e-12)
        assert back.phase == pytest.approx(line.phase, abs=1e-9)


@pytest.mark.parametrize("order", [1, 2, 5, 12])
def test_straight_lines_lose_half_the_square_of_pi_n_over_P(order):
    for points in (24 * order, 48 * order, 96 * order):
        table = sw.OrderTable((sw.Line(order, 1.0, -math.pi * order / points),))  # a crest halfway between two points
        left = table.residual("points", points=points)
        loss = (math.pi * order / points) ** 2 / 2.0
        assert left.peak == pytest.approx(1.0 - math.cos(math.pi * order / points), rel=1e-9)
        # the next term of 1 - cos is a (pi n/P)^2/12 of it
        assert left.peak == pytest.approx(loss, rel=(math.pi * order / points) ** 2 / 10.0)
        # independent: the reading halfway between two equal points of the crest
        crest = np.cos(order * np.array([-1.0, 1.0]) * math.pi / points)
        assert 1.0 - np.mean(crest) == pytest.approx(loss, rel=(math.pi * order / points) ** 2 / 10.0)


def test_rounding_to_a_quantum_leaves_a_twelfth_of_its_square():
    left = TORQUE.residual("moteus", torque_constant=0.05)
    assert left.quantisation == pytest.approx(left.quantum / math.sqrt(12.0) * math.sqrt(2.0 / 3.0), rel=0.05)
    # straight lines between rounded points: their mean square is two thirds of that at the points
    assert left.rms == pytest.approx(math.hypot(left.quantisation, left.interpolation), rel=0.02)


@pytest.mark.parametrize("name", ["linuxcnc", "sinumerik"])
def test_a_table_of_few_quanta_shows_the_rounding_that_is_predicted(tmp_path, name):
    quantum = 1e-9 * DEGREE
    table = sw.OrderTable((sw.Line(1, 30.0 * quantum, 0.7),), turn="output")
    options = {"linuxcnc": {"span": (0.0, 360.0), "points": 256}, "sinumerik": {"points": 2001, "capacity": 2001}}[name]
    left = table.write(tmp_path / "a.txt", name, **options)
    text = (tmp_path / "a.txt").read_text()
    degrees = TURN / DEGREE
    added = machines.linuxcnc(text, degrees, 1.0) if name == "linuxcnc" else -machines.sinumerik(text, degrees)
    missing = added * DEGREE - table.value(TURN)
    assert np.sqrt(np.mean(missing**2)) == pytest.approx(left.rms, rel=0.02)
    # equal chances of every rounding, and straight lines between the points: q^2/12 of which two thirds are left
    assert left.quantisation == pytest.approx(quantum * math.sqrt(2.0 / 36.0), rel=0.15)
    assert left.quantum == pytest.approx(quantum)


def test_orders_left_out_are_named_and_counted(tmp_path):
    many = sw.OrderTable(tuple(sw.Line(k, 1e-3 / k, 0.1 * k) for k in range(1, 12)), unit="N*m")
    left = many.write(tmp_path / "a.txt", "beckhoff", drop=True)
    assert left.dropped == (10, 11)
    assert left.dropped_rms == pytest.approx(1e-3 * math.hypot(1 / 10, 1 / 11) / math.sqrt(2.0))
    assert left.rms == pytest.approx(left.dropped_rms, rel=1e-6)
    assert "left out (10, 11)" in (tmp_path / "a.txt").read_text()
    assert sw.OrderTable.read(tmp_path / "a.txt").orders == tuple(range(1, 10))
    high = dataclasses.replace(ANGLE, lines=(*ANGLE.lines, sw.Line(300, ARCSEC, 0.0)))
    left = high.residual("points", points=128, drop=True)
    assert left.dropped == (300,)
    assert left.rms > ARCSEC / math.sqrt(2.0)


BOTH = sw.OrderTable.of((sw.Line(2, 20 * ARCSEC, 0.3), sw.Line(1.96, 17 * ARCSEC, -1.0)), ratio=50.0, source="scan")


@pytest.mark.parametrize(
    ("name", "options", "entries", "width"),
    [("json", {}, 2, 24), ("c", {}, 2, 24), ("hal", {}, 2, 24), ("points", {}, 3200, 8), ("twincat", {}, 3201, 16),
     ("sinumerik", {"capacity": 4000}, 3201, 8), ("linuxcnc", {}, 256, 24)],
)  # fmt: skip
def test_machines_at_the_output_hold_lines_of_both_turns(tmp_path, name, options, entries, width):
    left = BOTH.write(tmp_path / "table.txt", name, **options)
    assert (left.entries, left.size) == (entries, entries * width)
    assert (
        f"{'points' if left.points else 'lines'} in the machine: {entries}, {entries * width} bytes" in left.sentences()
    )
    size = math.hypot(20, 17) * ARCSEC / math.sqrt(2.0)
    assert left.table == pytest.approx(size, rel=1e-12)
    found = sw.OrderTable.read(tmp_path / "table.txt").on_turn("output")
    assert [found.keep((98, 100)).orders, found.turn] == [(98, 100), "output"]
    if name == "linuxcnc":  # 256 points are 2.6 a period: straight lines lose most
        assert 0.3 < left.rms / size < 1.0
    else:
        assert left.rms < 5e-3 * size


def test_a_table_on_two_angles_is_read_by_both_and_refused_where_it_is_too_large(tmp_path):
    table = dataclasses.replace(BOTH, zero=0.3, mean=1e-6, backward=BOTH.lines[:1], mean_backward=-1e-6)
    left = table.write(tmp_path / "grid.csv", "grid", motor_points=40, output_points=24)
    assert (left.points, left.entries, left.size) == (960, 1920, 15_360)
    motor, output, forward, backward = np.loadtxt(tmp_path / "grid.csv", delimiter=",", comments=("#", "m")).T
    angle = np.linspace(-9.0, 9.0, 4001)  # of the output

    def looked_up(values):
        grid = np.pad(values.reshape(40, 24), ((0, 1), (0, 1)), mode="wrap")
        axes = [np.append(axis, 2.0 * math.pi) for axis in (np.unique(motor), np.unique(output))]
        places = [np.mod(turns * (angle - 0.3), 2.0 * math.pi) for turns in (50.0, 1.0)]
        return RegularGridInterpolator(axes, grid)(np.transpose(places))

    for values, rate in ((forward, 1.0), (backward, -1.0)):
        missing = looked_up(values) - table.value(angle, rate)
        assert np.max(np.abs(missing)) == pytest.approx(left.peak, rel=0.02 if rate > 0 else 0.5)
        assert np.max(np.abs(missing)) < 0.08 * BOTH.rms * math.sqrt(2.0)
    found = sw.OrderTable.read(tmp_path / "grid.csv")
    assert found.pairs == ((2, -2), (2, 0))
    for one, other in zip((*found.lines, *found.backward), (*table.lines, *table.backward), strict=True):
        assert one == pytest.approx(other, abs=1e-13)
    assert (found.mean, found.mean_backward) == pytest.approx((1e-6, -1e-6), abs=1e-18)
    assert BOTH.residual("grid").entries == 64 * 64
    for options, said in (
        ({"capacity": 4000}, "a table of 64 by 64 points is more than the 4000 that the controller holds"),
        ({"motor_points": 4}, "motor_points is 4 and a line repeats 2 times a turn; give more points"),
    ):
        with pytest.raises(ValueError, match=said):
            BOTH.residual("grid", **options)
    with pytest.raises(ValueError, match="CSV over two turns needs a whole ratio"):
        dataclasses.replace(BOTH, ratio=None).residual("grid")


def test_machines_at_the_motor_say_what_they_leave_of_lines_of_both_turns(tmp_path):
    torque = dataclasses.replace(BOTH, unit="N*m")
    for name, options, entries, size in (("beckhoff", {}, 1, 12), ("moteus", {"torque_constant": 0.05}, 1024, 1024)):
        with pytest.raises(
            ValueError, match=r"order 98 is 1.96 on the motor turn .* leave it out with keep\(...\) or drop"
        ):
            torque.write(tmp_path / "table.txt", name, **options)
        left = torque.write(tmp_path / "table.txt", name, drop=True, **options)
        assert (left.dropped, left.entries, left.size) == ((1.96,), entries, size)
        assert left.dropped_rms == pytest.approx(17 * ARCSEC / math.sqrt(2.0))
        assert left.rms == pytest.approx(left.dropped_rms, rel=1e-4)
        assert "of it by orders left out (1.96)" in str(left)
    with pytest.raises(ValueError, match=r"would leave .* and so correct nothing"):
        torque.keep((98,)).write(tmp_path / "table.txt", "beckhoff", drop=True)
    with pytest.raises(ValueError, match=r"order 100 of the table is above 99, .*set MD38000"):
        BOTH.write(tmp_path / "table.txt", "sinumerik")


def test_remarks_state_the_residual_where_the_format_has_remarks(tmp_path):
    for name in set(OPTIONS) - set(NO_REMARKS) - {"json"}:
        text, left = written(tmp_path, name)
        assert str(left).splitlines()[0] in text
        assert text.isascii()


MANY = tuple(sw.Line(k, 1e-3, 0.0) for k in range(1, 11))
REFUSED = [
    ("beckhoff", dataclasses.replace(TORQUE, lines=MANY), {}, "has 10 orders and Beckhoff 0x32CB holds 9"),
    (
        "beckhoff",
        dataclasses.replace(TORQUE, lines=(sw.Line(201, 1e-3, 0.0),)),
        {},
        "order 201 .*n goes from 0 to 200",
    ),
    ("beckhoff", dataclasses.replace(TORQUE, lines=(sw.Line(2, 1e39, 0.0),)), {}, "REAL32 ends at 3.4e"),
    ("beckhoff", dataclasses.replace(TORQUE, mean=0.1), {}, "constant part of 0.1 N.m and Beckhoff 0x32CB holds none"),
    ("beckhoff", ANGLE, {}, "an angle in rad and Beckhoff 0x32CB holds a torque in N.m; take a format for angles"),
    ("moteus", dataclasses.replace(TORQUE, lines=(sw.Line(513, 1e-3, 0.0),)), {}, "order 513 .* 1024 points a period"),
    ("moteus", dataclasses.replace(TORQUE, delay=1e-3), {}, "delay of 0.001 s, .* moteus knows no speed; choose one"),
    ("moteus", dataclasses.replace(TORQUE, direction="forward"), {}, "differs between forward and backward .* one_way"),
    ("linuxcnc", ANGLE, {"span": (0.0, 360.0)}, "order 4 .* 256 points a period; take a shorter span, or .* hal"),
    ("linuxcnc", ANGLE, {"points": 257}, "points is 257; LinuxCNC's COMP_FILE holds 3 to 256, beyond .* format hal"),
    ("linuxcnc", ANGLE, {"span": (0.0, 4.0)}, "is 1.33333 turns of the motor; take whole ones, 3 degrees each"),
    ("linuxcnc", TORQUE, {}, "a torque in N.m and LinuxCNC's COMP_FILE holds an angle"),
    ("hal", dataclasses.replace(ANGLE, ratio=None), {}, "give the table its ratio"),
    ("twincat", ANGLE, {"points": 64}, "order 480 .* above 31, .* 64 points a period; give more points"),
    ("twincat", TORQUE, {}, "a torque in N.m"),
    ("sinumerik", ANGLE, {"capacity": 200}, "order 480 .* above 99, .* MD38000"),
    ("sinumerik", ANGLE, {"points": 361, "capacity": 200}, "points is 361; the control holds 3 to 200: set MD38000"),
    ("sinumerik", TWO_WAYS, {}, "one_way"),
    ("sinumerik", dataclasses.replace(ANGLE, ratio=50.5, lines=(sw.Line(1, 1e-5, 0.0),)), {}, "order 1 is 50.5 on the"),
    ("sinumerik", sw.OrderTable((sw.Line(1, 1e-12, 0.0),), turn="output"), {}, "and so correct nothing .its step is"),
    ("onstepx", dataclasses.replace(ANGLE, ratio=101.0), {}, "takes 855.446 sidereal seconds; OnStepX counts whole"),
    ("onstepx", dataclasses.replace(ANGLE, ratio=100.0), {}, "takes 864 .* holds 61 to 720: set PEC_BUFFER_SIZE_LIMIT"),
    ("onstepx", dataclasses.replace(ANGLE, ratio=1600.0), {}, "takes 54 sidereal seconds; OnStepX holds 61 to 720"),
    (
        "onstepx",
        dataclasses.replace(ANGLE, lines=(sw.Line(9, 0.01, 0.0),)),
        {},
        "steps in one sidereal second; .* most 106",
    ),
    ("onstepx", dataclasses.replace(ANGLE, lines=(sw.Line(361, 1e-5, 0.0),)), {}, "order 361 .* above 360"),
    ("points", ANGLE, {"points": 7}, "order 4 of the table is above 3, .* 7 points a period; give more points"),
    ("c", ANGLE, {"points": 7}, "two of its 7 points a period; give more points"),
    ("st", ANGLE, {"points": 7}, "two of its 7 points a period; give more points"),
    ("st", ANGLE, {"points": 40_000}, "points is 40000; it must be at most 20000"),
    ("c", ANGLE, {"prefix": "2bad"}, "prefix is '2bad'; give a name of C"),
    ("c", ANGLE, {"point": 8}, "a C header has no option 'point'; it has prefix, points"),
    ("hal", ANGLE, {"component": "Up"}, "give a name of small letters"),
    ("st", ANGLE, {"function": "a b"}, "give a name of letters"),
    ("twincat", ANGLE, {"variable": "x;y"}, "give a name of letters"),
    ("twincat", ANGLE, {"added_to": "both"}, "added_to is 'both'; it must be 'command' or 'actual'"),
    ("sinumerik", ANGLE, {"axis": "a b"}, "name of a machine axis"),
    ("beckhoff", TORQUE, {"wave": "tan"}, "take A or B, and cos or sin"),
    ("moteus", TORQUE, {"torque_constant": 0.0}, "torque_constant is 0.0; it must be a positive"),
]


@pytest.mark.parametrize(("name", "table", "changes", "said"), REFUSED)
def test_what_a_format_cannot_hold_is_refused_in_one_sentence(tmp_path, name, table, changes, said):
    with pytest.raises(ValueError, match=said) as refusal:
        table.write(tmp_path / "table.txt", name, **(OPTIONS[name] | changes))
    assert "\n" not in str(refusal.value)
    assert list(tmp_path.iterdir()) == []


def test_missing_options_and_unknown_formats_are_told(tmp_path):
    with pytest.raises(ValueError, match="moteus needs the option torque_constant; give it"):
        TORQUE.residual("moteus")
    with pytest.raises(ValueError, match="'mtoeus' is no format of order tables; known are json, csv"):
        TORQUE.residual("mtoeus")
    with pytest.raises(ValueError, match=r"'a\.txt' does not tell the format"):
        TORQUE.write(tmp_path / "a.txt")
    with pytest.raises(FileNotFoundError, match="there is no folder"):
        TORQUE.write(tmp_path / "no" / "a.json")


def test_what_a_format_cannot_hold_goes_where_the_refusal_says(tmp_path):
    delayed = dataclasses.replace(TWO_WAYS, delay=1e-3)
    text, left = written(tmp_path, "sinumerik", delayed.at_speed(100.0).one_way("backward"))
    output = TURN / 50.0 / DEGREE
    missing = -machines.sinumerik(text, output) * DEGREE - delayed.value(TURN - 0.2, -100.0)
    assert np.max(np.abs(missing)) <= 1.01 * left.peak
    assert left.peak < 0.02 * delayed.rms


def test_a_drive_that_takes_the_sine_gets_the_same_torque(tmp_path):
    text, _ = written(tmp_path, "beckhoff", wave="sin", channel="B")
    assert "0x36CB:08" in text
    rows = re.findall(r"0x36CB:(..) +\S+ +(\S+)", text)
    value = {int(sub, 16): float(number) for sub, number in rows}
    total = sum(value[9 + 3 * k] * np.sin(value[7 + 3 * k] * TURN + DEGREE * value[8 + 3 * k]) for k in range(9))
    assert np.max(np.abs(total - TORQUE.value(TURN + TORQUE.zero))) < 1e-8
    assert read_back(tmp_path, "beckhoff").keep((2, 12)).lines[1].phase == pytest.approx(2.0, abs=1e-6)


class Halved(sw.results.OrderFormat, name="halved", title="halved lines"):
    """A user's own format: half the amplitudes, order by order."""

    def store(self, table):
        lines = tuple(line._replace(amplitude=0.5 * line.amplitude) for line in table.lines)
        half = dataclasses.replace(table, lines=lines)
        held = sw.OrderTable(lines, zero=table.zero, ratio=table.ratio)
        return Held(held.one_direction, table.one_direction, half)

    def text(self, table, held, said):
        return "\n".join(f"{line.order} {line.amplitude!r} {line.phase!r}" for line in held.numbers.lines)

    def parse(self, text):
        rows = [line.split() for line in text.splitlines()]
        return sw.OrderTable(tuple(sw.Line(int(k), float(a), float(p)) for k, a, p in rows))

    @classmethod
    def recognises(cls, text):
        return text == "halved"


def test_an_axis_that_adds_to_the_actual_position_gets_the_opposite_sign(tmp_path):
    both = [written(tmp_path, "twincat", points=2001, added_to=which)[0] for which in ("command", "actual")]
    assert read_back(tmp_path, "twincat").on_turn("motor").keep([2]).lines[0].phase == pytest.approx(0.3, abs=1e-9)
    command, actual = (machines.twincat(text, TURN / DEGREE) for text in both)
    assert np.array_equal(command, -actual)


def test_a_users_own_format_is_one_class(tmp_path):
    left = ANGLE.write(tmp_path / "a.txt", Halved())
    assert left.rms == pytest.approx(0.5 * ANGLE.rms, rel=1e-9)
    found = sw.OrderTable.read(tmp_path / "a.txt", Halved())
    assert [line.amplitude for line in found.lines] == [0.5 * line.amplitude for line in ANGLE.lines]
    with pytest.raises(TypeError, match=r"Typo has no attribute both_way; a format has begin, both_ways, .*width"):

        class Typo(sw.results.OrderFormat, both_way=True):
            pass


def taken(low, high):
    """Numbers that models take: 0, or none next to it."""
    return st.floats(low, high).map(lambda value: value if abs(value) > 1e-59 else 0.0)


sizes = st.floats(1e-6, 1e-3)
tables = st.builds(
    lambda lines, zero, mean: sw.OrderTable(
        tuple(sw.Line(k, a, p) for k, (a, p) in sorted(lines.items())), zero=zero, mean=mean, ratio=120.0
    ),
    st.dictionaries(st.integers(1, 12), st.tuples(sizes, taken(-3.1, 3.1)), min_size=1, max_size=6),
    taken(-3.0, 3.0),
    st.sampled_from([0.0, 1e-5]),
)


@pytest.mark.parametrize("name", sorted(set(OPTIONS) - {"onstepx"}))
@settings(max_examples=15)
@given(table=tables)
def test_any_table_comes_back_within_the_residual(tmp_path_factory, name, table):
    path = tmp_path_factory.mktemp("order") / "table.txt"
    if name in ("beckhoff", "moteus"):
        table = dataclasses.replace(table, unit="N*m", mean=0.0)
    if name in ("sinumerik", "twincat", "grid"):
        table = dataclasses.replace(table, turn="output")
    options = OPTIONS[name] | ({"span": (0.0, 3.0)} if name == "linuxcnc" else {})
    left = table.write(path, name, **options)
    found = sw.OrderTable.read(path, **(options if name in NO_REMARKS else {})).keep(table.orders)
    angle = np.linspace(0.0, 6.0, 300)
    shift = table.zero if name in NO_REMARKS else 0.0
    missing = np.max(np.abs(found.value(angle - shift) - table.value(angle)))
    # of the lines that are kept, rounding may hide at most what a square wave of half a quantum holds in each
    assert missing <= (len(table.lines) + 1) * left.quantum + 1e-7 * table.rms


numbers = taken(-1e60, 1e60)
phases = taken(-1e3, 1e3)
some_lines = st.dictionaries(st.integers(1, 10_000), st.tuples(taken(0.0, 1e60), phases), max_size=4).map(
    lambda lines: tuple(sw.Line(k, a, p) for k, (a, p) in lines.items())
)
anything = st.builds(
    lambda back, **fields: sw.OrderTable(**fields | back),
    st.one_of(
        st.builds(lambda direction: {"direction": direction}, st.sampled_from(["both", "forward", "backward"])),
        st.builds(lambda lines, mean: {"backward": lines, "mean_backward": mean}, some_lines, numbers),
    ),
    lines=some_lines,
    unit=st.sampled_from(["rad", "N*m"]),
    turn=st.sampled_from(["motor", "output"]),
    ratio=st.none() | st.floats(1e-3, 1e3),
    zero=numbers,
    sign=st.sampled_from(["correction", "error"]),
    mean=numbers,
    delay=taken(0.0, 1.0),
    speeds=st.none() | st.tuples(taken(0.0, 10.0), st.floats(10.0, 1e3)),
    load=st.none() | numbers,
    source=st.text(max_size=60),
)


@pytest.mark.parametrize("name", ["json", "csv"])
@settings(max_examples=40)
@given(table=anything)
def test_canonical_files_are_exact_for_any_table(tmp_path_factory, name, table):
    path = tmp_path_factory.mktemp("exact") / "table"
    table.write(path, name)
    found = sw.OrderTable.read(path)
    assert repr(vars(found)) == repr(vars(table))  # -0.0 too


@pytest.mark.parametrize("name", ["points", "linuxcnc", "twincat"])
@pytest.mark.parametrize("direction", ["forward", "backward"])
def test_a_table_of_one_direction_acts_in_that_one_alone(tmp_path, name, direction):
    table = dataclasses.replace(ANGLE, direction=direction)
    _, left = written(tmp_path, name, table)
    found = read_back(tmp_path, name).on_turn("motor")
    assert found.direction == direction
    for line, back in zip(table.lines, found.keep(table.orders).lines, strict=True):
        assert back.amplitude == pytest.approx(line.amplitude, abs=left.quantum, rel=1e-9)
    assert left.rms < 0.05 * table.rms
