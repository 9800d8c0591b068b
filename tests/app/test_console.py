"""Progress on stderr; numbers as text."""

import time
from itertools import count

import pytest

from strainwave.app.console import progress as told_progress
from strainwave.base.number_text import number
from strainwave.compile.cache import Compilation


@pytest.mark.parametrize("every", [0.05, 60.0])
def test_a_stage_that_lasts_is_told_once_in_a_while(monkeypatch, capsys, every):
    monkeypatch.setattr(told_progress, "FIRST_LINE_S", 0.05)
    monkeypatch.setattr(told_progress, "NEXT_LINE_S", every)
    with told_progress.Progress("Drive") as progress:
        progress.show("exact response", 0.0)
        progress.show("exact response", 0.5)
        time.sleep(0.3)
    told = capsys.readouterr().err.splitlines()
    assert set(told) == {"Drive: exact response, 0 s so far"}
    assert (len(told) == 1) == (every > 1.0)
    time.sleep(0.2)
    assert capsys.readouterr().err == ""  # the run is over


@pytest.mark.parametrize(
    ("value", "digits", "text"),
    [
        (99.996, 2, "100"),
        (-99.996, 2, "−100"),
        (9999.96, 4, "10000"),
        (-0.0, 4, "0"),
        (12345.6, 4, "12346"),
        (0.00012345, 3, "0.000123"),
        (1.5e7, 4, "1.5×10⁷"),
        (2.56e-7, 4, "2.56×10⁻⁷"),
        (456.71, 4, "456.7"),
        (1e5, 4, "100000"),
        (None, 4, "–"),
        (float("nan"), 4, "–"),
        (True, 4, "yes"),
        ("x", 4, "x"),
    ],
)
def test_numbers_are_written_for_people(value, digits, text):
    assert number(value, digits) == text


def test_the_time_left_follows_from_the_share_and_leaves_out_what_was_compiled(monkeypatch):
    clock = [100.0]
    monkeypatch.setattr(told_progress, "monotonic", lambda: clock[0])
    progress = told_progress.Progress("Drive")
    assert progress.time_left(100.0) == ""
    clock[0] = 130.0
    progress.compiled = 20.0
    progress.show("motions", 0.25)  # 10 s for a quarter
    assert progress.time_left(130.0) == ", about 30 s left"
    assert progress.time_left(140.0) == ", about 20 s left"
    assert progress.time_left(161.0) == ""  # longer than expected: nobody knows
    progress.show("motions", 0.2)  # a share that falls is no progress
    assert progress.time_left(140.0) == ", about 20 s left"


def test_what_is_compiled_is_told_in_a_file_too(monkeypatch, capsys):
    monkeypatch.setattr(told_progress, "FIRST_LINE_S", 0.02)
    kernels, looks = [Compilation(name, kept=True) for name in ("follow", "march_one")], count()
    monkeypatch.setattr(told_progress, "compiling", lambda: ([], kernels[:1], kernels[1:])[next(looks) % 3])
    with told_progress.Progress("Drive"):
        time.sleep(0.3)
    told = capsys.readouterr()
    assert next(looks) > 6
    assert told.err == "Drive: preparing machine code, once per machine, 0 s so far\n"
    assert told.out == ""


def test_durations_are_rounded_up():
    assert [told_progress.duration(t) for t in (0.2, 119.5, 120.5, 7199.0, 7201.0)] == [
        "1 s", "120 s", "3 min", "120 min", "3 h",
    ]  # fmt: skip
