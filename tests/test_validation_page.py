"""The page on validation holds what its recipes give: every recipe exists, every number is computed anew."""

import re
from pathlib import Path

import numpy as np
import pytest
from printed import differences
from validated.methods import repeats
from validated.page import TABLES, table, written
from validated.row import Row, as_printed, difference, markdown

from strainwave.app.commands.cli import cli

TESTS = Path(__file__).resolve().parent
ROWS = [row for rows in TABLES.values() for row in rows]


@pytest.mark.slow
@pytest.mark.parametrize("name", TABLES)
def test_numbers_of_the_page_are_those_computed_now(name):
    assert differences(written(name), table(name)) == []  # python tools/validation.py writes them


@pytest.mark.parametrize("row", ROWS, ids=lambda row: f"{row.case}: {row.compared}")
def test_every_recipe_exists(row):
    words = row.recipe.split()
    if words[0] == "strainwave":
        assert words[1] in cli.commands
    elif words[0] == "python":
        assert (TESTS.parent / words[1]).is_file()
    elif words[0].startswith("benchmarks/"):
        assert (TESTS.parent / words[0]).is_file()
    else:
        file, _, name = row.recipe.partition("::")
        assert f"def {name}" in (TESTS / file).read_text(encoding="utf-8")


@pytest.mark.parametrize("name", TABLES)
def test_every_row_is_on_the_page_once(name):
    lines = [line for line in written(name).splitlines() if line.startswith("| **")]
    assert [line.split("**")[1] for line in lines] == [row.case for row in TABLES[name]]


def test_rows_without_a_computed_number_are_on_the_page_as_they_stand():
    for name, rows in TABLES.items():
        assert [row.case for row in rows if not row.found and markdown(row) not in written(name)] == []


def test_a_difference_is_that_of_the_printed_digits():
    assert difference([2.84162459], ["2.8416246"]) == "none in these digits"
    assert difference([2.8416248], ["2.8416246"]) == "+7e-06 %"
    assert difference([5.1e-3, 0.9], ["4.8e-3", "1.0"]) == "-10 %"
    assert [as_printed(value, "4.8e-3") for value in (5.107e-3, 2e-5)] == ["5.1e-3", "2e-05"]
    assert as_printed(-1e-12, "0.000") == "0.000"
    row = Row("a", "b", "c", ("2",), lambda: [3.0], "test_x.py")
    assert markdown(row) == "| **a**<br>b<br>`test_x.py` | c | 2 | 3 | +50 % |"


def test_scipy_repeats_the_orbit_of_example_01():
    amplitude, left = repeats()
    assert np.abs([amplitude, left]).max() < 1e-8


def test_every_command_of_the_comparison_exists():
    page = (TESTS.parent / "docs" / "glossary.md").read_text(encoding="utf-8")
    commands = set(re.findall(r"`(benchmarks/\w+\.py)", page))
    assert commands >= {"benchmarks/response.py", "benchmarks/ensemble.py"}
    assert [command for command in commands if not (TESTS.parent / command).is_file()] == []
