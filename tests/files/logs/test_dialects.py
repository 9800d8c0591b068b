"""A log written in any dialect reads back equal; a table that could be two is refused."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import strainwave as sw

UNITS = {"motor_angle": "rad", "load_speed": "rad/s", "current": "A", "hall": "V"}


def written(log, delimiter, decimal, header, encoding, *, thousands=False):
    """Text of a log in a dialect, as bytes."""
    other = "," if decimal == "." else "."

    def cell(value):
        text = f"{value:,.3f}" if thousands else repr(float(value))
        if thousands:
            return text.replace(",", "\0").replace(".", decimal).replace("\0", other)
        return text.replace(".", decimal)

    names = ["time [s]", *(f"{name} [{log.units[name]}]" for name in log.channels)]
    rows = [delimiter.join(map(cell, row)) for row in zip(log.time, *log.channels.values(), strict=True)]
    lines = [*([delimiter.join(names)] if header else []), *rows]
    return ("\n".join(lines) + "\n").encode(encoding)


def equal(found, log):
    assert found.units == log.units
    assert np.array_equal(found.time, log.time)
    for name, values in log.channels.items():
        assert np.array_equal(found.channels[name], values), name


@st.composite
def logs(draw):
    n = draw(st.integers(3, 20))
    step = draw(st.floats(1e-4, 1.0))
    values = st.floats(-3.0, 3.0, allow_subnormal=False)
    channels = {name: np.array(draw(st.lists(values, min_size=n, max_size=n))) for name in UNITS}
    return sw.Log(0.5 * step + step * np.arange(n), channels, dict(UNITS))


@settings(max_examples=150, deadline=None)
@given(
    log=logs(),
    delimiter=st.sampled_from([",", ";", "\t", " "]),
    decimal=st.sampled_from([".", ","]),
    header=st.booleans(),
    encoding=st.sampled_from(["utf-8", "utf-8-sig", "utf-16"]),
)
def test_a_log_in_any_dialect_reads_back_equal(tmp_path_factory, log, delimiter, decimal, header, encoding):
    if delimiter == decimal:
        return
    path = tmp_path_factory.mktemp("dialect") / "log.csv"
    path.write_bytes(written(log, delimiter, decimal, header, encoding))
    columns = None if header else ["time", *log.channels]
    units = None if header else {"hall": "V"}
    equal(sw.read_log(path, columns, units, trim=0.0, unwrap=False), log)


@settings(max_examples=30, deadline=None)
@given(log=logs())
def test_a_saved_log_reads_back_equal(tmp_path_factory, log):
    path = log.save(tmp_path_factory.mktemp("saved") / "log.csv")
    equal(sw.read_log(path, trim=0.0, unwrap=False), log)


def short(**channels):
    n = len(next(iter(channels.values())))
    return sw.Log(np.arange(n) / 8.0, {name: np.asarray(v, float) for name, v in channels.items()})


@pytest.mark.parametrize(("delimiter", "decimal"), [(";", ","), ("\t", ","), (";", "."), (" ", ",")])
def test_signs_between_thousands_are_no_decimals(tmp_path, delimiter, decimal):
    log = short(load_angle=[0.5, 1234.5, 1234567.25], current=[-2.0, 1000.0, 12.0])
    path = tmp_path / "log.csv"
    path.write_bytes(written(log, delimiter, decimal, True, "utf-8", thousands=True))
    found = sw.read_log(path, unwrap=False)
    equal(found, log)
    assert "between thousands" in found.notes[0]


def refused(tmp_path, text, **options):
    path = tmp_path / "log.csv"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(ValueError, match=r"log\.csv:\d+:\d+: ") as complaint:
        sw.read_log(path, **options)
    return str(complaint.value)


AMBIGUOUS = "load_angle;current\n1.234;5.678\n2.345;6.789\n3.456;7.891\n"


def test_a_table_of_points_before_three_digits_is_refused_until_the_decimal_sign_is_given(tmp_path):
    said = refused(tmp_path, AMBIGUOUS, rate=8.0)
    assert "can be read in two ways" in said
    assert "give delimiter and decimal" in said
    path = tmp_path / "log.csv"
    assert sw.read_log(path, rate=8.0, decimal=".").channels["current"][0] == 5.678
    assert sw.read_log(path, rate=8.0, decimal=",").channels["current"][0] == 5678.0


def test_two_columns_of_whole_numbers_between_commas_need_names(tmp_path):
    rows = "1,2\n2,4\n3,8\n"
    assert "can be read in two ways" in refused(tmp_path, rows, rate=8.0, columns={"current": 0})
    path = tmp_path / "log.csv"
    path.write_text("time,current\n" + rows)
    assert np.array_equal(sw.read_log(path).channels["current"], [2.0, 4.0, 8.0])
    path.write_text(rows)
    assert np.array_equal(sw.read_log(path, ["time", "current"]).channels["current"], [2.0, 4.0, 8.0])
    assert np.array_equal(sw.read_log(path, ["current"], rate=8.0).channels["current"], [1.2, 2.4, 3.8])


def test_a_decimal_comma_between_commas_is_refused(tmp_path):
    said = refused(tmp_path, "time,current\n0,001,1,25\n0,002,1,5\n0,003,1,75\n")
    assert said.startswith(str(tmp_path / "log.csv:1:1: "))
    assert "names 2 columns and the lines below have 4 numbers" in said


@pytest.mark.parametrize(
    ("header", "channel"),
    [
        ("time_ms,velocity_rad_per_s", "load_speed"), ("t [ms],speed [rad/s]", "load_speed"),
        ("Zeit / ms,theta_l (rad)", "load_angle"), ("timestamp_ms,motorPosition [rad]", "motor_angle"),
        ("time (ms),omega_m", "motor_speed"), ("# time [ms],tau [N*m]", "torque"),
        ("time_ms,torque_l_Nm", "load_torque"),
        ("time_ms,V1", "V1"), ("time_ms,current_A", "current"), ("time,joint position\nms,rad", "load_angle"),
        ("a recorder, version 3\ntime,twist\n[ms],[rad]", "torsion"),
    ],
)  # fmt: skip
def test_names_and_units_above_the_columns_are_understood(tmp_path, header, channel):
    path = tmp_path / "log.csv"
    path.write_text(header + "\n0.0,1.5\n2.0,2.5\n4.0,2.25\n", encoding="utf-8")
    found = sw.read_log(path)
    assert np.array_equal(found.channels[channel], [1.5, 2.5, 2.25])
    assert np.array_equal(found.time, [0.0, 0.002, 0.004])
    assert found.rate == pytest.approx(500.0)


@pytest.mark.parametrize(
    ("unit", "factor"),
    [("deg", np.pi / 180), ("rev", 2 * np.pi), ("arcmin", np.pi / 10800), ("0.5 deg", np.pi / 360), (0.25, 0.25)],
)
def test_units_that_are_given_count(tmp_path, unit, factor):
    path = tmp_path / "log.csv"
    path.write_text("time [s],load_angle [rad],x\n0.0,1.5,1\n1.0,2.5,2\n")
    found = sw.read_log(path, units={"load_angle": unit}, unwrap=False)
    assert found.channels["load_angle"] == pytest.approx(factor * np.array([1.5, 2.5]), rel=1e-14)


def test_comments_empty_lines_quotes_and_a_separator_at_the_end_are_no_matter(tmp_path):
    path = tmp_path / "log.csv"
    path.write_text('# of a recorder\n\n"time [s]";"current [mA]";\n% more\n0,5;"1,5";\n\n1,5;2,5;\n')
    found = sw.read_log(path)
    assert np.array_equal(found.time, [0.5, 1.5])
    assert found.channels == {"current": pytest.approx([1.5e-3, 2.5e-3])}


def test_a_line_that_was_cut_off_at_the_end_is_left_out_and_one_in_the_middle_refused(tmp_path):
    path = tmp_path / "log.csv"
    path.write_text("time,current\n0.5,1.5\n1.5,2.5\n2.5,3.5\n3.")
    found = sw.read_log(path)
    assert len(found) == 3
    assert "the last line (5) is incomplete and was omitted" in found.notes
    assert "log.csv:3:1: file: has 1 cells" in refused(tmp_path, "time,current\n0.5,1.5\n1.5\n2.5,3.5\n")
    long = "".join(f"{i}.5,1.5\n" for i in range(5000))
    said = refused(tmp_path, f"time,current\n{long}5000.5,1.5,8\n6000.5,1.5\n")
    assert "log.csv:5002:1: file: has 3 cells" in said
    assert "'x'" in refused(tmp_path, f"time,current\n{long}5000.5,x\n6000.5,1.5\n")


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "is empty"),
        ("nothing but words\nand more of them\n", "has no table of numbers"),
        ("0.5,1.5\n1.5,2.5\n", "has 2 columns without names"),
        ("position,current\n0.5,1.5\n1.5,2.5\n", "has no column of the time; the channels are load_angle, current"),
        ("time,current\n0.5,1.5\n", "has 1 sample"),
        ("time,current [kg]\n0.5,1.5\n1.5,2.5\n3.0,3\n", "current: cannot convert 'kg' to 'A'"),
        ("time [kg],load_angle\n0.5,1.5\n1.5,2.5\n", "time: cannot convert 'kg' to 's'"),
    ],
)
def test_what_is_no_log_is_refused_in_one_sentence(tmp_path, text, said):
    assert said in refused(tmp_path, text)


def test_columns_and_units_that_are_not_there_are_named(tmp_path):
    text = "time,current\n0.5,1.5\n1.5,2.5\n"
    assert "has no single column 'x' for torque; it has time, current" in refused(
        tmp_path, text, columns={"torque": "x"}
    )
    assert "none at the place 7" in refused(tmp_path, text, columns={"torque": 7})
    assert "has 2 columns, and columns names 1" in refused(tmp_path, text, columns=["time"], decimal=".")
    assert "cannot convert" in refused(tmp_path, text, units={"current": "rpm"})
    for signs in ({"decimal": ";"}, {"delimiter": ";;"}, {"delimiter": ",", "decimal": ","}):
        assert "the delimiter is one sign, the decimal sign a point or a comma, and they differ" in refused(
            tmp_path, text, **signs
        )
    two = "time,hall,hall\n0,1.5,2\n1,2.5,3\n"
    assert "has two columns 'hall'; name them by place, columns={'hall': 1, 'hall 2': 2}" in refused(tmp_path, two)
    path = tmp_path / "log.csv"
    assert list(sw.read_log(path, {"hall": 1, "hall 2": 2}).channels) == ["hall", "hall 2"]
    with pytest.raises(ValueError, match="units has 'furlong' for 'hall', which is not a unit of a channel"):
        sw.read_log(path, {"hall": 1, "hall 2": 2}, {"hall": "furlong"})
    path.write_text(text)
    with pytest.raises(ValueError, match="units has 'torque', and the channels are time, current"):
        sw.read_log(path, units={"torque": "N*m"})
    with pytest.raises(ValueError, match="remove one of them"):
        sw.read_log(path, rate=8.0)
    with pytest.raises(ValueError, match="does not exist"):
        sw.read_log(tmp_path / "none.csv")
