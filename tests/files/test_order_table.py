"""Order tables: value, other forms, files that read back and C that computes them, and what they refuse."""

import ctypes
import dataclasses
import math
import shutil
import subprocess

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import strainwave as sw
from strainwave.files.yaml_text import FileError

ARCSEC = math.pi / 648_000.0
ANGLES = np.linspace(-7.0, 7.0, 701)
ANGLE = sw.OrderTable(
    (sw.Line(1, 4 * ARCSEC, -1.0), sw.Line(2, 23 * ARCSEC, 0.3), sw.Line(4, 2 * ARCSEC, 2.0)),
    ratio=120.0, zero=0.4, source='rig 3, "slow" */ *) é\nsecond line ??/',
)  # fmt: skip
TWO_WAYS = sw.OrderTable(
    (sw.Line(2, 20 * ARCSEC, 0.3),), backward=(sw.Line(2, 17 * ARCSEC, 0.5), sw.Line(3, 1 * ARCSEC, 0.0)),
    mean=5 * ARCSEC, mean_backward=-5 * ARCSEC, ratio=50.0, zero=-0.2,
)  # fmt: skip
TABLES = {
    "angle": ANGLE,
    "torque": sw.OrderTable((sw.Line(2, 0.01, 0.3), sw.Line(12, 0.005, 2.0)), unit="N*m", turn="output", zero=0.1),
    "two ways": dataclasses.replace(TWO_WAYS, delay=2e-4),
    "forward": dataclasses.replace(ANGLE, direction="forward", delay=1e-3, mean=1e-5, speeds=(1.0, 300.0), load=-20.0),
    "backward": dataclasses.replace(ANGLE, direction="backward"),
    "nothing": sw.OrderTable((), mean=1e-6),
}


def test_value_is_the_sum_of_the_lines_read_ahead():
    table = dataclasses.replace(TWO_WAYS, delay=1e-3)
    led = ANGLES + 0.25
    forward = 5 * ARCSEC + 20 * ARCSEC * np.cos(2 * led + 0.3)
    assert np.allclose(table.value(ANGLES, 250.0), forward, rtol=0.0, atol=1e-18)
    led = ANGLES - 0.25
    backward = -5 * ARCSEC + 17 * ARCSEC * np.cos(2 * led + 0.5) + ARCSEC * np.cos(3 * led)
    assert np.allclose(table.value(ANGLES, -250.0), backward, rtol=0.0, atol=1e-18)
    both = table.value(ANGLES[:, None], np.array([250.0, -250.0]))
    assert both.shape == (701, 2)
    assert isinstance(table.value(0.3), float)
    assert table.value(0.3) == pytest.approx(5 * ARCSEC + 20 * ARCSEC * math.cos(0.9))


def test_a_table_of_one_direction_is_silent_in_the_other():
    assert dataclasses.replace(ANGLE, direction="forward").value(1.0, -1.0) == 0.0
    assert dataclasses.replace(ANGLE, direction="backward").value(1.0, 1.0) == 0.0
    assert dataclasses.replace(ANGLE, direction="backward").value(1.0, -1.0) == ANGLE.value(1.0)


@given(
    speed=st.just(0.0) | st.floats(1e-3, 500.0) | st.floats(-500.0, -1e-3), delay=st.just(0.0) | st.floats(1e-9, 5e-3)
)
def test_the_table_of_one_speed_is_the_table_at_that_speed(speed, delay):
    one_way = [dataclasses.replace(ANGLE, direction=way) for way in ("forward", "backward")]
    for table in (ANGLE, TWO_WAYS, *one_way):
        table = dataclasses.replace(table, delay=delay)
        fixed = table.at_speed(abs(speed))
        assert fixed.delay == 0.0
        got, expected = fixed.value(ANGLES, speed), table.value(ANGLES, speed)
        assert np.allclose(got, expected, rtol=0.0, atol=1e-16)


def test_a_kinematic_error_goes_in_and_comes_out():
    error = sw.KinematicError((sw.Line(2, 1e-4, 0.3), sw.Line(1, -2e-5, -1.0), sw.Line(2, 1e-5, 0.0)))
    table = sw.OrderTable.of(error, ratio=50.0, sign="error")
    assert np.allclose(table.value(ANGLES), error.value(ANGLES), rtol=0.0, atol=1e-18)
    assert sw.OrderTable.of(sw.KinematicError(ANGLE.lines)).lines == ANGLE.lines


def test_a_torque_over_the_angle_goes_in_and_is_what_a_controller_adds():
    torque = sw.Harmonics((sw.Harmonic(0.02, 2, 0.3, mean=0.1), sw.Harmonic(-0.01, 12, 1.0)))
    table = sw.OrderTable.of(torque, delay=1e-3)
    assert table.unit == "N*m"
    assert np.allclose(table.value(ANGLES), torque.torque(ANGLES), rtol=0.0, atol=1e-16)
    assert sw.OrderTable.of(torque.terms[0]).lines == (sw.Line(2, 0.02, 0.3),)
    # as a controller adds it: at the angle that the motor reaches a lead later
    loop = sw.controllers.SampledPD(1.0, 0.1, 1e-3)
    controller = sw.controllers.TorqueTable(loop, torque, table.delay)
    for speed in (200.0, -200.0):
        sample = sw.controllers.Measurement(0.7, speed, 0.0, 0.69, math.nan, 0.0, 0.0)
        added = controller.update(controller.start(), sample)[1] - loop.update(loop.start(), sample)[1]
        assert added == pytest.approx(table.value(0.7, speed), abs=1e-15)


def test_error_scans_of_two_directions_make_a_table():
    angle = np.linspace(0.0, 4.0 * math.pi, 720, endpoint=False)
    scans = [sw.error_scan(angle, TWO_WAYS.value(angle, way), orders=[2, 3]) for way in (1.0, -1.0)]
    table = sw.OrderTable.of(scans[0], backward=scans[1], sign="error", source="rig")
    assert table.lines[0].amplitude == pytest.approx(20 * ARCSEC, rel=1e-9)
    assert table.backward[1].amplitude == pytest.approx(ARCSEC, rel=1e-9)


BEATING = (sw.Line(2, 20e-6, 0.3), sw.Line(1.96, 17e-6, -1.0), sw.Line(4, 3e-6, 0.1))


def test_lines_of_both_turns_count_on_the_output_whose_pairs_are_said():
    table = sw.OrderTable.of(BEATING, ratio=50.0)
    assert (table.turn, table.orders, table.pairs) == ("output", (98, 100, 200), ((2, -2), (2, 0), (4, 0)))
    error = sw.KinematicError(BEATING)
    angle = np.linspace(0.0, 400.0, 1001)  # of the motor, more than a turn of the output
    assert table.value(angle / 50.0) == pytest.approx(error.value(angle), abs=1e-17)
    assert sw.OrderTable.of(BEATING[::2], ratio=50.0).turn == "motor"


def test_lines_of_one_pair_are_added_and_pairs_of_no_table_are_refused():
    twice = sw.OrderTable.of((*BEATING, sw.Line(1.96 + 1e-12, 17e-6, -1.0)), ratio=50.0)
    assert twice.orders == (98, 100, 200)
    assert twice.lines[0].amplitude == pytest.approx(34e-6)
    for fields, said in (
        ({}, "order 1.96 is a line of the output's turn; give the ratio of the gear"),
        ({"ratio": 50.0, "turn": "motor"}, "order 1.96 is 1.96 on the turn of the table, not a whole number"),
        ({"ratio": 50.3}, "order 2 is 100.6 on the turn of the table, not a whole number"),
        ({"ratio": -50.0}, "ratio of an order table is -50.0; it must be a positive finite number"),
    ):
        with pytest.raises(ValueError, match=said):
            sw.OrderTable.of(BEATING, **fields)


LINE = sw.Line(2, 1e-4, 0.0)


@pytest.mark.parametrize(
    ("fields", "said"),
    [
        ({"lines": (3.0,)}, "lines of an order table are .*; give lines, each an order, amplitude and phase"),
        ({"lines": (LINE, LINE)}, "order 2 appears twice in the lines of an order table; add both lines"),
        ({"lines": (sw.Line(0, 1e-4),)}, "an order of an order table is 0; it must be a whole number of at least 1"),
        ({"lines": (sw.Line(20_000, 1e-4),)}, "at most 10000"),
        ({"lines": (sw.Line(2, -1e-4),)}, "amplitude of order 2 is -0.0001; use a positive one"),
        ({"lines": (sw.Line(2, math.nan),)}, "amplitude of order 2 is nan; it must be a finite number"),
        ({"unit": "deg"}, "unit of an order table is 'deg'; it must be 'rad' or 'N.m'"),
        ({"ratio": 0.0}, "ratio of an order table is 0.0; it must be a positive finite number"),
        ({"delay": -1e-3}, "delay of an order table is -0.001 s; it must not be negative"),
        ({"speeds": (3.0, 1.0)}, "speeds of an order table are 3 .. 1 rad/s"),
        ({"speeds": 3.0}, "give the lowest and the highest"),
        ({"mean_backward": 1.0}, "has mean_backward and no backward lines"),
        ({"backward": (LINE,), "direction": "forward"}, "with backward lines has the direction 'forward'"),
        ({"source": "x" * 2001}, "source of an order table is .*; give up to 2000 letters"),
        ({"zero": "0"}, "zero of an order table is '0'; it must be a finite number"),
    ],
)
def test_a_wrong_table_is_refused_in_one_sentence(fields, said):
    with pytest.raises((ValueError, TypeError), match=said) as refusal:
        sw.OrderTable(**{"lines": (LINE,)} | fields)
    assert "\n" not in str(refusal.value)


def test_a_value_that_is_not_finite_is_refused():
    with pytest.raises(ValueError, match="not finite; hold the last value"):
        ANGLE.value(np.array([0.0, math.nan]))
    with pytest.raises(ValueError, match=r"speed \[rad/s\] is inf"):
        ANGLE.value(0.0, math.inf)


def taken(low, high):
    """Numbers that models take: 0, or none next to it."""
    return st.floats(low, high).map(lambda value: value if abs(value) > 1e-59 else 0.0)


numbers = taken(-1e60, 1e60)
some_lines = st.dictionaries(st.integers(1, 500), st.tuples(taken(0.0, 1e60), taken(-1e3, 1e3)), max_size=4).map(
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


@pytest.mark.parametrize("name", ["json", "c"])
@settings(max_examples=40)
@given(table=anything)
def test_files_of_lines_read_back_equal_to_the_bit(tmp_path_factory, name, table):
    path = tmp_path_factory.mktemp("exact") / "table"
    table.write(path, name)
    found = sw.OrderTable.read(path)
    assert repr(found) == repr(table)  # -0.0 too


@pytest.mark.parametrize("name", [name for name in TABLES if not TABLES[name].delay])
def test_points_are_values_of_the_table_and_give_its_lines_back(tmp_path, name):
    table = TABLES[name]
    table.write(tmp_path / "a.csv")
    angle, *values = np.loadtxt(tmp_path / "a.csv", delimiter=",", comments=("#", "a")).T
    assert len(angle) == max(64, 32 * max(table.orders, default=1))
    for row, way in zip(values, (1.0, -1.0), strict=False):
        assert row == pytest.approx(table.value(angle + table.zero, way), abs=1e-17)
    found = sw.OrderTable.read(tmp_path / "a.csv")
    assert (found.unit, found.turn, found.direction) == (table.unit, table.turn, table.direction)
    assert (found.ratio, found.zero, found.source) == (table.ratio, table.zero, table.source)
    assert found.orders == table.orders
    for way in (1.0, -1.0):
        assert np.allclose(found.value(ANGLES, way), table.value(ANGLES, way), rtol=0.0, atol=1e-15)


def test_points_of_both_directions_and_of_another_program_are_read(tmp_path):
    TWO_WAYS.write(tmp_path / "a.csv", points=8)
    found = sw.OrderTable.read(tmp_path / "a.csv")
    assert np.allclose(found.value(ANGLES, -1.0), TWO_WAYS.value(ANGLES, -1.0), rtol=0.0, atol=1e-15)
    assert (found.mean, found.mean_backward) == pytest.approx((5 * ARCSEC, -5 * ARCSEC))
    (tmp_path / "b.csv").write_text(
        "# by hand\n# unit = N*m\n# ratio = 50\nangle_rad,value\n"
        + "".join(f"{math.pi / 4 * i}, {math.cos(2 * math.pi / 4 * i + 0.3):.17g}\r\n" for i in range(8))
    )
    found = sw.OrderTable.read(tmp_path / "b.csv")
    assert (found.unit, found.ratio, found.orders) == ("N*m", 50.0, (2,))
    assert found.lines[0] == pytest.approx((2, 1.0, 0.3))


COMPILER = shutil.which("cc")


def compiled(tmp_path, source):
    """Functions `value` and `lookup` (double, double) -> double of a C source."""
    (tmp_path / "table.c").write_text(source)
    flags = ["-std=c99", "-O2", "-Wall", "-Wextra", "-Werror", "-shared", "-fPIC"]
    subprocess.run([COMPILER, *flags, "table.c", "-o", "t.so", "-lm"], cwd=tmp_path, check=True)
    library = ctypes.CDLL(str(tmp_path / "t.so"))
    for function in (library.value, library.lookup):
        function.restype, function.argtypes = ctypes.c_double, [ctypes.c_double] * 2
    return library.value, library.lookup


@pytest.mark.skipif(COMPILER is None, reason="no C compiler")
@pytest.mark.parametrize("prefix", ["order_table", "MY_NAME_FORWARD_BACKWARD"])
@pytest.mark.parametrize("name", TABLES)
def test_the_c_header_compiles_without_warnings_and_equals_value(tmp_path, name, prefix):
    table = TABLES[name]
    table.write(tmp_path / "table.h", points=96, prefix=prefix)
    value, lookup = compiled(
        tmp_path,
        f'#include "table.h"\ndouble value(double a, double s) {{ return {prefix}_value(a, s); }}\n'
        f"double lookup(double a, double s) {{ return {prefix}_lookup(a, s); }}\n",
    )
    rng, places = np.random.default_rng(3), np.linspace(0.0, 2.0 * math.pi, 97)
    for angle, speed in zip(rng.uniform(-20.0, 20.0, 2000), rng.uniform(-400.0, 400.0, 2000), strict=True):
        assert value(angle, speed) == pytest.approx(table.value(angle, speed), abs=1e-16)
        led = (angle + table.delay * speed - table.zero) % (2.0 * math.pi)
        still = dataclasses.replace(table, delay=0.0).value(places + table.zero, speed)
        assert lookup(angle, speed) == pytest.approx(np.interp(led, places, still), abs=1e-15)


def test_what_a_file_cannot_hold_is_refused_in_one_sentence(tmp_path):
    for name, given_options, said in (
        ("a.csv", {"points": 8}, "8 points a turn hold no order 4, which takes more than two a period"),
        ("a.h", {"points": 8}, "8 points a turn hold no order 4"),
        ("a.csv", {"points": 40_000}, "points is 40000; it must be at most 20000"),
        ("a.h", {"prefix": "2bad"}, "prefix is '2bad'; give a name of C"),
        ("a.txt", {}, "'.txt' is not a format of order tables; formats: json, csv, c"),
        ("a.csv", {"format": "beckhoff"}, "'beckhoff' is not a format of order tables; formats: json, csv, c"),
    ):
        with pytest.raises(ValueError, match=said):
            ANGLE.write(tmp_path / name, **given_options)
    with pytest.raises(ValueError, match=r"has a delay of 0.001 s, whose phase depends on the speed, .* at_speed\("):
        dataclasses.replace(ANGLE, delay=1e-3).write(tmp_path / "a.csv")
    assert list(tmp_path.iterdir()) == []
    with pytest.raises(FileNotFoundError, match="there is no folder"):
        ANGLE.write(tmp_path / "no" / "a.json")


HEAD = '{"format": "strainwave order table", "version": 1'
HOSTILE = [
    ("[1, 2]", "is not an order table: neither JSON of lines, nor a C header, nor CSV with the columns angle_rad"),
    ("", "is empty|is not an order table"),
    ("{" * 100_000, "is not complete JSON"),
    (HEAD, "is not complete JSON .*; save the table again"),
    (HEAD.replace("1", "9") + "}", "version: is 9 and must be 1"),
    ("{}", "format: is None and must be 'strainwave order table'"),
    (HEAD + ', "zzz": 1}', "zzz: is not a field of an order table"),
    (HEAD + ', "lines": NaN}', "lines of an order table are nan"),
    (HEAD + ', "lines": [3]}', "lines of an order table are .*; give lines"),
    (HEAD + "}", "lines of an order table are None"),
    ("angle_rad,value\n0,1\n1,2\n2,1\n4,1\n5,1\n", "the 5 angles are not equidistant from 0 over one turn"),
    ("angle_rad,value\n0,1\n", "has 1 points; a turn needs 4 to 20000"),
    ("angle_rad,value\n0,1,3\n", "2:1: file: has 3 cells where the head names 2"),
    ("angle_rad,value\n0,1\n1,1e999\n", "3:1: value: '1e999' is not a finite number"),
    ("# turn = sideways\nangle_rad,value\n0,1\n1.5707963267948966,1\n3.141592653589793,1\n4.71238898038469,1\n",
     "turn of an order table is 'sideways'"),
    ("// lines = [[2]]\n", "lines of an order table are"),
]  # fmt: skip


@pytest.mark.parametrize(("text", "said"), HOSTILE)
def test_what_is_wrong_with_a_file_is_said(tmp_path, text, said):
    path = tmp_path / "bad.txt"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(FileError, match=said) as refusal:
        sw.OrderTable.read(path)
    assert str(refusal.value).startswith(f"{path}:")
    assert "\n" not in str(refusal.value)
    assert len(str(refusal.value)) < 600


def complained(path):
    """The complaint about a file, or None where it is read; anything else is a failure."""
    try:
        table = sw.OrderTable.read(path)
    except FileError as error:
        return str(error)
    assert all(math.isfinite(line.amplitude) for line in table.lines)
    return None


@pytest.mark.parametrize("name", ["json", "csv", "c"])
@settings(max_examples=15)
@given(text=st.text(max_size=300), place=st.integers(0, 100_000), length=st.integers(0, 40))
def test_any_change_of_a_file_gives_a_table_or_a_sentence(tmp_path_factory, name, text, place, length):
    path = tmp_path_factory.mktemp("hostile") / "changed.txt"
    ANGLE.write(path, name)
    good = path.read_text(encoding="utf-8")
    start = place % len(good)
    for changed in (good[:start] + text + good[start + length :], good[:start], text):
        path.write_text(changed, encoding="utf-8", errors="replace")
        complaint = complained(path)
        assert complaint is None or (complaint.startswith(f"{path}:") and "\n" not in complaint)
        assert len(complaint or "") < 600


def test_other_encodings_missing_folders_and_huge_files(tmp_path):
    path = tmp_path / "a"
    for name in ("json", "csv", "c"):
        ANGLE.write(path, name)
        text, whole = path.read_text(encoding="utf-8"), sw.OrderTable.read(path)
        for data in (text.encode("utf-16"), text.encode("utf-8-sig"), text.replace("\n", "\r\n").encode()):
            path.write_bytes(data)
            assert sw.OrderTable.read(path) == whole
        path.write_bytes(text.encode() + b"\xff\xfe\x80")
        with pytest.raises(FileError):
            sw.OrderTable.read(path)
    with pytest.raises(FileError, match="does not exist; check the name and the folder"):
        sw.OrderTable.read(tmp_path / "none.json")
    with pytest.raises(FileError, match="is a directory"):
        sw.OrderTable.read(tmp_path)
    path.write_bytes(b"#" * (16 * 1024 * 1024 + 1))
    with pytest.raises(FileError, match="a table of orders has at most"):
        sw.OrderTable.read(path)
