"""Progress on stderr."""

import time

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
