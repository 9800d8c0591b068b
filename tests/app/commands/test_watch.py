"""`strainwave watch`: saves, a file that is gone, half written or wrong, and the end by Ctrl-C."""

import re

import pytest
from click.testing import CliRunner

from strainwave.app.commands import watch
from strainwave.app.commands.cli import cli

PROJECT = """\
title: Watched
gear: {ratio: 50, law: {type: linear, K: 3e4 N*m/rad}}
motor: {inertia: 5 kg*cm^2, mode: held}
load: {inertia: 1.3 kg*m^2}
damping: {B: 20 N*m*s/rad}
speed: {from: 300 rpm, to: 500 rpm, shaft: motor}
excitation: {kinematic_error: [{order: 2, amplitude: 10 arcsec}]}
limit: {oscillation: 30 arcsec}
"""


@pytest.mark.slow
def test_each_save_is_judged_and_no_file_ends_it(tmp_path, monkeypatch):
    path, looks = tmp_path / "drive.yaml", []
    path.write_text(PROJECT, encoding="utf-8")
    saves = {
        4: lambda: path.write_text(PROJECT.replace("30 arcsec", "5 arcsec"), encoding="utf-8"),
        5: lambda: path.write_text(PROJECT[:90], encoding="utf-8"),  # half of a save, whole at the next look
        6: lambda: path.write_text(PROJECT.replace("30 arcsec", "5 arcsec"), encoding="utf-8"),
        10: path.unlink,
        14: lambda: path.write_text(PROJECT.replace("load: {inertia", "load: {inertai"), encoding="utf-8"),
        18: lambda: path.write_text(PROJECT, encoding="utf-8"),
    }

    def pause(_seconds):
        looks.append(len(looks))
        if looks[-1] == 24:
            raise KeyboardInterrupt
        saves.get(looks[-1], str)()

    monkeypatch.setattr(watch, "sleep", pause)
    run = CliRunner().invoke(cli, ["watch", str(path)])
    assert run.exit_code == 0, run.output
    said = re.split(r"^\d\d:\d\d:\d\d ", run.stdout, flags=re.MULTILINE)[1:]
    assert [one.startswith("Watched: ") for one in said] == [True, True, False, False, True]
    assert said[0].startswith("Watched: Pass; ")
    assert said[1].startswith("Watched: Fail")
    assert "drive.yaml" in said[2]
    assert "does not exist" in said[2]
    assert "inertai" in said[3]
    assert said[4] == said[0]
    assert max(map(str.count, said, "\n" * 5)) <= 3
