"""Dates of ISO 8601 are seconds since the first, and texts that are not UTF-8 are read as Windows-1252."""

from datetime import UTC, datetime, timedelta, timezone

import numpy as np
import pytest

import strainwave as sw

FIRST = datetime(2024, 2, 29, 23, 59, 59, 250_000, UTC)  # a leap day, before midnight
LATER = np.array([0.0, 0.5, 1.0, 1.75, 86400.0])


def read(tmp_path, text, encoding="utf-8", **options):
    path = tmp_path / "log.csv"
    path.write_bytes(text.encode(encoding))
    return sw.read_log(path, trim=0.0, **options)


def table(delimiter, separator, zone, fraction=".", quote="", names=("timestamp", "current")):
    """Rows of a date, in a zone that is so many hours ahead or None, and a current of 0.5, 1.5, ... A."""
    rows = [delimiter.join(names)]
    for i, after in enumerate(LATER):
        date = FIRST + timedelta(seconds=after)
        if zone is not None:
            date = date.astimezone(timezone(timedelta(hours=zone)))
        text = date.replace(tzinfo=None).isoformat(separator, "milliseconds").replace(".", fraction)
        text += "" if zone is None else "Z" if zone == 0 else f"{zone:+03d}:00"
        current = f"{i}{'.' if delimiter == ',' else fraction}5"
        rows.append(delimiter.join([f"{quote}{text}{quote}", current]))
    return "\n".join(rows) + "\n"


@pytest.mark.parametrize("delimiter", [",", ";", "\t", " "])
@pytest.mark.parametrize("separator", ["T", " "])
@pytest.mark.parametrize("zone", [None, 0, 1, -5])
def test_dates_are_seconds_since_the_first(tmp_path, delimiter, separator, zone):
    log = read(tmp_path, table(delimiter, separator, zone))
    assert log.time.tolist() == LATER.tolist()
    assert log.channels["current"].tolist() == [0.5, 1.5, 2.5, 3.5, 4.5]
    assert any(note.startswith("dates were read as seconds since 2024-0") for note in log.notes)


@pytest.mark.parametrize(("delimiter", "quote"), [(";", ""), ("\t", ""), (",", '"')])
def test_a_comma_before_fractions_of_seconds_parts_no_columns(tmp_path, delimiter, quote):
    log = read(tmp_path, table(delimiter, " ", None, ",", quote))
    assert log.time.tolist() == LATER.tolist()
    assert log.channels["current"].tolist() == [0.5, 1.5, 2.5, 3.5, 4.5]


def test_a_date_may_stand_in_any_column_and_one_above_the_table_does_not_count(tmp_path):
    rows = "".join(f"{i},2026-11-23T13:37:0{i}.000000{i},2026-11-23T13:37:0{i},{i}.5\n" for i in range(4))
    log = read(tmp_path, "Recorded 2020-01-01 10:00\nn,Datum [UTC],stop,current\n" + rows)
    assert log.time == pytest.approx(np.arange(4.0) * 1.0000001, rel=1e-15)
    assert log.channels["stop"].tolist() == [0.0, 1.0, 2.0, 3.0]
    assert log.units["stop"] == "s"
    assert "dates were read as seconds since 2026-11-23T13:37:00.0000000" in log.notes


@pytest.mark.parametrize(
    ("rows", "said"),
    [
        (["2026-11-31T10:00:00,1", "2026-12-01T10:00:00,2"], "2:1: file: has 2026-11-31T10:00:00, which is no date"),
        (["2026-11-30T10:00:00Z,1", "2026-11-30T10:00:01,2"], "3:1: file: has the date 2026-11-30T10:00:01, and not"),
        (["2026-10-25T02:59:59,1", "2026-10-25T02:00:00,2"], "time: runs backwards"),
        (["2026-11-30 10:00:00,250,1.5", "2026-11-30 10:00:00,500,2.5"], "names 2 columns and the lines below have 3"),
        (["30.11.2026 10:00:00,1", "30.11.2026 10:00:01,2"], "write dates as 2026-11-23T13:37:38"),
    ],
)
def test_a_date_that_is_none_is_refused_in_one_sentence(tmp_path, rows, said):
    with pytest.raises(ValueError, match=r"log\.csv") as complaint:
        read(tmp_path, "\n".join(["time,current", *rows, rows[-1]]) + "\n")
    assert said in str(complaint.value)
    assert "\n" not in str(complaint.value)


def test_dates_and_durations_of_numpy_are_seconds(tmp_path):
    times = np.datetime64("2026-11-23T13:37:00.5") + np.arange(5) * np.timedelta64(1500, "us")
    for given in (times, times - times[0]):
        np.savez(tmp_path / "log.npz", time=given, current=np.arange(5.0))
        assert sw.read_log(tmp_path / "log.npz").time == pytest.approx(1.5e-3 * np.arange(5), rel=1e-12)
    times[0] = np.datetime64("NaT")
    np.savez(tmp_path / "log.npz", time=times, current=np.arange(5.0))
    log = sw.read_log(tmp_path / "log.npz")
    assert log.time == pytest.approx(1.5e-3 * np.arange(4), rel=1e-12)
    assert log.channels["current"].tolist() == [1.0, 2.0, 3.0, 4.0]


def test_arrays_that_are_no_channels_are_named_and_times_of_another_length_refused(tmp_path):
    channels = {"time": np.arange(5.0), "current": np.arange(5.0)}
    np.savez(tmp_path / "log.npz", **channels, torque=np.ones((5, 2)), position=np.ones((5, 3)), gain=1j * np.ones(5))
    log = sw.read_log(tmp_path / "log.npz", trim=0.0)
    assert list(log.channels) == ["current", "gain_real", "gain_imaginary"]
    assert "torque, position are not vectors of real numbers and were omitted" in log.notes
    np.savez(tmp_path / "log.npz", **channels, current_time=np.arange(3.0))
    with pytest.raises(
        ValueError, match=r"log\.npz:1:1: file: current has 5 values and current_time 3; give equally many"
    ):
        sw.read_log(tmp_path / "log.npz")


@pytest.mark.parametrize("encoding", ["cp1252", "latin-1"])
def test_a_text_that_is_not_utf_8_is_read_as_windows_1252_and_a_note_says_so(tmp_path, encoding):
    text = "Zeit;Winkel [°];Moment Prüfling [N·m]\n0,5;90,0;1,25\n1,5;180,0;2,25\n"
    log = read(tmp_path, text, encoding)
    assert log.channels["load_angle"] == pytest.approx([0.5 * np.pi, np.pi])
    assert log.channels["Moment Prüfling"].tolist() == [1.25, 2.25]
    assert log.notes[0] == "the file is not UTF-8 and was read as Windows-1252 (Latin-1)"
    assert not any("1252" in note for note in read(tmp_path, text, "utf-8").notes)


def test_bytes_of_no_text_are_refused(tmp_path):
    (tmp_path / "log.csv").write_bytes(b"time,curr\x81nt\n0.5,1.5\n1.5,2.5\n")
    with pytest.raises(ValueError, match="has the byte 0x81, not UTF-8"):
        sw.read_log(tmp_path / "log.csv")
