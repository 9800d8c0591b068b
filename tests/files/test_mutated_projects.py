"""Spoilt project files: each is refused with a sentence at its place, or is valid; never a traceback."""

import random

import pytest
from click.testing import CliRunner
from mutated_projects import CHANGES, fault, mutated
from twelve_projects import PROJECTS

from strainwave.app.commands.cli import cli

EACH = 50


@pytest.mark.parametrize("block", range(5))
def test_a_spoilt_file_is_refused_with_a_sentence(tmp_path, block):
    path, codes = tmp_path / "drive.yaml", []
    for seed in range(EACH * block, EACH * (block + 1)):
        path.write_bytes(mutated(seed))
        run = CliRunner().invoke(cli, ["analyze", str(path), "--check"])
        assert fault(run.exit_code, run.output.replace(f"{tmp_path}/", "")) == "", seed
        codes.append(run.exit_code)
    assert codes.count(3) > EACH // 2
    assert [p.name for p in tmp_path.iterdir()] == ["drive.yaml"]


def test_every_change_spoils_a_file_and_the_same_seed_the_same_way():
    text = PROJECTS["catalogue gear, motor not named"] + "\n"
    for change in CHANGES:
        assert any(change(text, random.Random(seed)) != text for seed in range(20)), change.__name__
    assert [mutated(seed) for seed in range(50)] == [mutated(seed) for seed in range(50)]


@pytest.mark.parametrize(
    ("code", "output"),
    [
        (1, "strainwave: KeyError: 'x' (unexpected error; --debug shows the traceback)"), (3, ""),
        (3, "something is wrong"), (3, "drive.yaml:1:1: gear: is wrong"),
        (0, "drive.yaml: valid\n  J nan kg*m^2"), (2, "Usage: ..."),
    ],
)  # fmt: skip
def test_the_judge_sees_what_is_no_sentence(code, output):
    assert fault(code, output)
