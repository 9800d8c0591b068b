"""Progress on stderr; numbers as text."""

import time

import pytest

from strainwave.app import console


def test_a_stage_that_lasts_is_told_again(monkeypatch, capsys):
    monkeypatch.setattr(console, "EVERY", 0.05)
    with console.Progress("Drive") as progress:
        progress.show("exact response", 0.0)
        progress.show("exact response", 0.5)
        time.sleep(0.3)
    told = capsys.readouterr().err.splitlines()
    assert told[0] == "Drive: exact response"
    assert told[1] == "Drive: exact response, 0 s so far"
    assert len(told) >= 3
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
    ],
)
def test_a_number_that_rounds_up_to_a_power_of_ten_is_written_out(value, digits, text):
    assert console.number(value, digits) == text
