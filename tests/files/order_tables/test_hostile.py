"""Files that are no order tables, or damaged ones, get one sentence with their place."""

import json
import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from order_machines import NO_REMARKS, OPTIONS, TWO_WAYS, table_for

import strainwave as sw
from strainwave.files.yaml_text import FileError


def small(name):
    """A short file of each format."""
    few = {
        "sinumerik": {"points": 33},
        "twincat": {"points": 33},
        "linuxcnc": {"points": 33},
        "onstepx": {"capacity": 720},
    }
    table = table_for(name)
    if name in ("sinumerik", "twincat", "linuxcnc"):
        table = sw.OrderTable(table.lines, turn="output", zero=0.4)
    options = OPTIONS[name] | few.get(name, {})
    if name == "linuxcnc":
        options["span"] = (0.0, 360.0)
    return table, options


def given_back(path, name):
    return sw.OrderTable.read(path, name, **(OPTIONS[name] if name in NO_REMARKS else {}))


def text_of(tmp_path, name):
    table, options = small(name)
    table.write(tmp_path / "good.txt", name, **options)
    return (tmp_path / "good.txt").read_text(encoding="utf-8")


def complained(path, name):
    """The complaint about a file, or None where it is read; anything else is a failure."""
    try:
        table = given_back(path, name)
    except FileError as error:
        said = str(error)
        assert said.startswith(f"{path}:")
        assert "\n" not in said
        assert len(said) < 600
        return said
    assert all(math.isfinite(line.amplitude) for line in table.lines)
    return None


@pytest.mark.parametrize("name", OPTIONS)
def test_a_file_that_is_cut_off_is_refused_or_has_lost_remarks_alone(tmp_path, name):
    text = text_of(tmp_path, name)
    whole = given_back(tmp_path / "good.txt", name)
    path = tmp_path / "cut.txt"
    lines = text.splitlines(keepends=True)
    for kept in [*range(0, len(lines) - 1, max(1, len(lines) // 40)), len(lines) - 2]:
        path.write_text("".join(lines[:kept]), encoding="utf-8")
        if complained(path, name) is None:
            assert given_back(path, name).orders == whole.orders


@pytest.mark.parametrize("name", OPTIONS)
@pytest.mark.parametrize("bad", ["nan", "inf", "1e999", "", "0x10", "1,5", "--1", "9" * 400])
def test_numbers_that_are_none_are_refused(tmp_path, name, bad):
    text = text_of(tmp_path, name)
    number = {
        "json": '"amplitude": ', "csv": "both,2,", "points": "0.0,", "grid": "0.0,0.0,", "c": "amplitude[] = {\n    ",
        "st": "amplitudeForward : ARRAY[1..3] OF LREAL := [", "hal": "{2.0, ", "linuxcnc": "0.000000000 ",
        "twincat": "Compensation := ", "sinumerik": "[0,3,AX1]=", "onstepx": ":WR7,", "beckhoff": "REAL32 ",
        "moteus": "comp.5 ",
    }[name]  # fmt: skip
    place = text.index(number) + len(number)
    end = next(i for i in range(place, len(text)) if text[i] in " ,\n})#]")
    path = tmp_path / "bad.txt"
    path.write_text(text[:place] + bad + text[end:], encoding="utf-8")
    assert complained(path, name) is not None


@pytest.mark.parametrize("name", OPTIONS)
def test_other_encodings_and_line_ends(tmp_path, name):
    text = text_of(tmp_path, name)
    whole = given_back(tmp_path / "good.txt", name)
    path = tmp_path / "other.txt"
    for data in (text.encode("utf-16"), text.encode("utf-8-sig"), text.replace("\n", "\r\n").encode()):
        path.write_bytes(data)
        assert given_back(path, name) == whole
    for data in (text.encode() + b"\xff\xfe\x80", b"\0\1\2" + text.encode(), "Maß é".encode("latin-1")):
        path.write_bytes(data)
        assert complained(path, name) is not None


@pytest.mark.parametrize("name", OPTIONS)
@settings(max_examples=15)
@given(text=st.text(max_size=300), place=st.integers(0, 100_000), length=st.integers(0, 40))
def test_any_change_of_a_file_gives_a_table_or_a_sentence(tmp_path_factory, name, text, place, length):
    folder = tmp_path_factory.mktemp("hostile")
    good = text_of(folder, name)
    start = place % len(good)
    path = folder / "changed.txt"
    path.write_text(good[:start] + text + good[start + length :], encoding="utf-8", errors="replace")
    complained(path, name)
    path.write_text(text, encoding="utf-8", errors="replace")
    assert complained(path, name) is not None


HOSTILE = [
    ("json", "[1, 2]", "is not 'strainwave order table'"),
    ("json", "{" * 100_000, "is no whole JSON|is no order table"),
    ("json", '{"format": "strainwave order table", "version": 9}', "version: is 9; this version of strainwave reads 1"),
    ("json", '{"format": "strainwave order table", "version": 1, "zzz": 1}', "zzz: is not a field of an order table"),
    ("json", '{"format": "strainwave order table", "version": 1, "lines": NaN}', "NaN is no finite number"),
    ("json", '{"format": "strainwave order table", "version": 1, "lines": 3}', "lines: are 3; write a list"),
    ("json", '{"format": "strainwave order table", "version": 1, "lines": [3]}', "lines: hold 3; write order"),
    ("csv", "a,b\n1,2\n", "has the columns 'a,b'; they must be direction,order"),
    ("csv", "direction,order,amplitude,phase\nboth,1,1,0\nforward,1,1,0\n", "write both, or forward and backward"),
    ("csv", "direction,order,amplitude,phase\nboth,1,1,0\nboth,1,1,0\n", "order 1 is twice"),
    ("csv", "direction,order,amplitude,phase\nup,1,1,0\n", "is no row of"),
    ("csv", "direction,order,amplitude,phase\n", "has no rows; it may be cut off"),
    ("csv", "# ratio = -3\ndirection,order,amplitude,phase\nboth,1,1,0\n", "ratio of an order table is -3.0"),
    ("csv", "# turn = sideways\ndirection,order,amplitude,phase\nboth,1,1,0\n", "turn: 'sideways' is not known"),
    ("csv", "# source = x\ndirection,order,amplitude,phase\nboth,1,1,0\n", "source: 'x' is no text in double quotes"),
    ("points", "angle_rad,value\n0,1\n1,2\n2,1\n4,1\n5,1\n", "4 angles|5 angles are not equidistant"),
    ("points", "angle_rad,value\n0,1\n", "has 1 points; a turn needs 4"),
    ("points", "angle_rad,value\n0,1,3\n", "has 3 cells where the head names 2"),
    ("moteus", "conf set motor.cogging_dq_scale 0.1\n", "has not 1024 of 1024 values; it may be cut off"),
    ("moteus", "conf set motor.cogging_dq_comp.3 200\n", "'200' is no whole number from -128 to 127"),
    ("moteus", "conf set motor.cogging_dq_comp.2000 2\n", "'2000' is no whole number from 0 to 1023"),
    ("moteus", "conf set motor.cogging_dq_comp.3 2\nconf set motor.cogging_dq_comp.3 2\n", "is there twice"),
    ("beckhoff", "0x32CB:07 UINT32 300 2C010000\n", "subindex 07: is 300; it must be from 0 to 200"),
    ("beckhoff", "0x32CB:09 REAL32 1.0 00000000\n", "subindex 09: is 1 and its bytes are 00000000; write both alike"),
    ("beckhoff", "0x32CB:07 UINT32 3 03000000\n", "coefficient 0: is not whole in the list; it may be cut off"),
    ("beckhoff", "0x32CB:07 UINT32 3 03000000\n" * 2, "subindex 07: is there twice; leave one out"),
    ("beckhoff", "0x32CB:FF REAL32 1.0 0000803F\n", "subindex FF"),
    ("linuxcnc", "0 0 0\n1 1 1\n1 2 2\n", "nominal: '1' does not increase; LinuxCNC refuses it"),
    ("linuxcnc", "0 0 0\n1 1 1\n", "begins with 2 lines of three numbers"),
    ("linuxcnc", "0 0 0\n100 1 1\n360 360 360\n", "is not equidistant"),
    ("linuxcnc", "0 0 0\n100 100 100\n200 200 200\n", "ends after 0.555556 turns; only whole turns"),
    ("linuxcnc", "0 0 0\n180 180 180\n360 359 360\n", "ends with another correction than it begins with"),
    ("linuxcnc", "".join(f"{i} {i} {i}\n" for i in range(300)), "has more than 256 points"),
    ("sinumerik", "$AA_ENC_COMP[0,0,AX1]=0\n", "has not all of _STEP, _MIN, _MAX and _IS_MODULO"),
    ("sinumerik", "$AA_ENC_COMP(0)=3\n", "is no assignment of"),
    ("onstepx", ":WR0,1#\n:WR0,1#\n", "entry 0: is there twice"),
    ("onstepx", ":WR0,200#\n", "'200' is no whole number from -128 to 127"),
    ("onstepx", ":WR0,1#\n:$QZ!#\n", "has 1 entries that do not follow each other from 0"),
    ("onstepx", "".join(f":WR{i},1#\n" for i in range(720)), "adds up to 720 steps a turn; it must return to 0"),
    ("onstepx", "rm -rf\n", "'rm -rf' is no command of the table"),
    (
        "twincat",
        "OrderTable : ARRAY[0..2] OF ST_PositionCompensationTableElement := [\n(Position := 0.0)\n",
        "no element",
    ),
    (
        "twincat",
        "OrderTable : ARRAY[0..2] OF ST_PositionCompensationTableElement := [\n",
        "has 0 elements where it names 3",
    ),
    ("c", "int main(void) { return 0; }\n#endif\n", "has no lines of an order table"),
    ("st", "END_FUNCTION END_FUNCTION", "has no lines of an order table"),
    ("hal", "component x;", "is no whole component"),
]


@pytest.mark.parametrize(("name", "text", "said"), HOSTILE)
def test_what_is_wrong_is_said(tmp_path, name, text, said):
    path = tmp_path / "bad.txt"
    path.write_text(text, encoding="utf-8")
    complaint = complained(path, name)
    with pytest.raises(FileError, match=said):
        given_back(path, name)
    assert complaint is not None


def test_files_are_recognised_by_their_content(tmp_path):
    for name in OPTIONS:
        table, options = small(name)
        table.write(tmp_path / "file", name, **options)
        needed = OPTIONS[name] if name in NO_REMARKS else {}
        assert sw.OrderTable.read(tmp_path / "file", **needed) == given_back(tmp_path / "file", name)
    (tmp_path / "file").write_text("something else\n")
    with pytest.raises(FileError, match=r"is no order table that is recognised; give format, one of json, csv"):
        sw.OrderTable.read(tmp_path / "file")


def test_missing_folders_and_huge_files_are_told(tmp_path):
    with pytest.raises(FileError, match="does not exist; check the name and the folder"):
        sw.OrderTable.read(tmp_path / "none.json")
    with pytest.raises(FileError, match="is a directory"):
        sw.OrderTable.read(tmp_path)
    (tmp_path / "huge").write_bytes(b"#" * (16 * 1024 * 1024 + 1))
    with pytest.raises(FileError, match="a table of orders has at most"):
        sw.OrderTable.read(tmp_path / "huge")


def test_a_file_without_its_option_says_which(tmp_path):
    table, options = small("moteus")
    table.write(tmp_path / "conf.txt", "moteus", **options)
    with pytest.raises(FileError, match="moteus needs the option torque_constant; give it"):
        sw.OrderTable.read(tmp_path / "conf.txt")


def test_a_failing_write_leaves_the_old_file(tmp_path):
    path = tmp_path / "table.json"
    TWO_WAYS.write(path)
    before = path.read_text()
    with pytest.raises(ValueError, match="one_way"):
        TWO_WAYS.write(path, "sinumerik")
    assert path.read_text() == before
    assert json.loads(before)["backward"][0]["order"] == 2
    assert [file.name for file in tmp_path.iterdir()] == ["table.json"]
