"""Results on a terminal: prose wraps at its width, tables and JSON stay; a progress line keeps its stage."""

import io
import sys

import pytest

from strainwave.app.console import fitted
from strainwave.app.console.terminal import echo

PROSE = "  note: " + "a lag of up to 30 arcsec after a reversal, and its damping, " * 6 + "are left out"
TABLE = "  gains    " + "  ".join(f"{i:>12}" for i in range(9))


class Terminal(io.StringIO):
    def isatty(self):
        return True


def printed(monkeypatch, stream, text):
    monkeypatch.setenv("COLUMNS", "60")
    monkeypatch.setattr(sys, "stdout", stream)
    echo(text)
    return stream.getvalue().splitlines()


def test_prose_wraps_at_the_width_of_a_terminal_two_letters_below_its_indent(monkeypatch):
    lines = printed(monkeypatch, Terminal(), f"title\n{PROSE}\n{TABLE}")
    assert (lines[0], lines[-1]) == ("title", TABLE)
    assert len(lines) == 9  # 376 letters in lines of 56 to 60
    assert all(len(line) <= 60 for line in lines[:-1])
    assert all(line.startswith("    ") and line[4] != " " for line in lines[2:-1])
    assert " ".join(" ".join(lines[1:-1]).split()) == PROSE.strip()


@pytest.mark.parametrize(("stream", "text"), [(io.StringIO(), PROSE), (Terminal(), '{"note": "' + PROSE + '"}')])
def test_a_pipe_and_json_have_one_line_a_fact(monkeypatch, stream, text):
    assert printed(monkeypatch, stream, text) == [text]


@pytest.mark.parametrize(
    ("room", "line"),
    [
        (40, "Index table: response curve"), (26, "Index tab…: response curve"), (20, "Ind…: response curve"),
        (14, "response curve"), (8, "response"),
    ],
)  # fmt: skip
def test_the_title_is_cut_before_the_stage(room, line):
    assert fitted("Index table", "response curve", room) == line
