"""The documentation tells the truth: its scripts run and print what it says, its project files do what it says.

A ```python block runs after those before it on the same page; a ```text block right after it is its output. A ```yaml
block is a whole project file; a ```text block right after it is the complaint about it.
"""

import contextlib
import inspect
import io
import json
import re
import runpy
import shlex
import shutil
import tomllib
from functools import reduce
from operator import attrgetter
from pathlib import Path
from types import SimpleNamespace

import matplotlib
import pytest
from click.testing import CliRunner
from field_examples import examples
from printed import differences, same, says
from public_names import PUBLIC

import strainwave as sw
from strainwave.app.commands.cli import COMMANDS, cli
from strainwave.base.quantities import parse
from strainwave.files import reading
from strainwave.files.fields.rows import law_types
from strainwave.files.fields.schema import ProjectSpec

matplotlib.use("Agg")

ROOT = Path(__file__).resolve().parent.parent
PAGES = {path.name: path for path in [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]}
NO_NAMES = ("index", "changelog", "project-file-reference")  # pages beside those of the library's names
API = sorted(path for path in (ROOT / "docs" / "api").glob("*.md") if path.stem not in NO_NAMES)
SCATTER = "scatter: {load.inertia: 3 %}\n"
FENCE = re.compile(r"^```(\w+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)


def page(name):
    return PAGES[name].read_text(encoding="utf-8")


def blocks(name):
    """(language, text, expected output or None, line) of each block; outputs are joined to what they follow."""
    text = page(name)
    found = []
    for match in FENCE.finditer(text):
        language, body = match.groups()
        between = text[found[-1]["end"] : match.start()].strip() if found else "the beginning"
        if language == "text" and not between and found[-1]["output"] is None:
            found[-1] |= {"output": body, "end": match.end()}
        else:
            line = text[: match.start()].count("\n") + 1
            found.append({"language": language, "body": body, "output": None, "line": line, "end": match.end()})
    return found


def pages_with(language):
    return [name for name in PAGES if any(block["language"] == language for block in blocks(name))]


@pytest.mark.slow
@pytest.mark.parametrize("name", pages_with("python"))
def test_scripts_of_a_page_print_what_the_page_says(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for records in (ROOT / "tests" / "measured").iterdir():
        if records.is_dir() and f"{records.name}/" in page(name):
            shutil.copytree(records, tmp_path / records.name)
    names = {"__name__": "__main__"}
    for block in blocks(name):
        if block["language"] != "python":
            continue
        said = io.StringIO()
        with contextlib.redirect_stdout(said):
            # as many lines before it as on the page, for the line numbers of a traceback
            exec(compile("\n" * block["line"] + block["body"], PAGES[name], "exec"), names)
        if block["output"] is not None:
            assert differences(said.getvalue(), block["output"]) == [], f"{name}:{block['line']}"


@pytest.mark.parametrize("name", pages_with("yaml"))
def test_project_files_of_a_page_do_what_the_page_says(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for block in blocks(name):
        if block["language"] != "yaml":
            continue
        Path("project.yaml").write_text(block["body"], encoding="utf-8")
        if block["output"] is None:
            assert reading.read_project("project.yaml").system(1.0, reduced=True).J > 0.0
        else:
            with pytest.raises(reading.ProjectError) as complaint:
                reading.read_project("project.yaml")
            assert str(complaint.value) == block["output"].rstrip()


def test_these_tests_find_the_blocks():
    assert {"README.md", "tutorial.md", "gears.md"} <= set(pages_with("python"))
    assert {"tutorial.md", "project-file.md"} <= set(pages_with("yaml"))
    assert sum(block["output"] is not None for block in blocks("tutorial.md")) >= 5


def test_the_first_script_of_the_readme_has_at_most_15_lines():
    first = next(block for block in blocks("README.md") if block["language"] == "python")
    assert len([line for line in first["body"].splitlines() if line.strip()]) <= 15


def not_on(name, words):
    return [word for word in sorted(words) if f"`{word}" not in page(name)]


def test_every_public_name_is_on_one_api_page():
    directive = re.compile(r"^\.\. (?:auto\w+|py:data):: strainwave\.([\w.]+)$", re.MULTILINE)
    found = [name for path in API for name in directive.findall(path.read_text(encoding="utf-8"))]
    assert sorted(name for name in found if name in PUBLIC) == sorted(PUBLIC)


def test_every_api_page_begins_with_a_sentence_for_each_of_its_names():
    index = (ROOT / "docs" / "api" / "index.md").read_text(encoding="utf-8")
    assert {path.stem for path in API} == set(re.findall(r"^\w+$", index, re.MULTILINE))
    assert all(path.read_text(encoding="utf-8").count("{{ summary }}") == 1 for path in API)
    described = [thing for name in PUBLIC if callable(thing := attrgetter(name)(sw))]
    assert [thing for thing in described if not inspect.getdoc(thing).split("\n")[0].endswith((".", "?"))] == []


def test_the_table_of_verbs_has_verbs_and_commands():
    questions = page("command-line.md").partition("\n## ")[0]
    rows = re.findall(
        r"^\| [^|]+\? \| `(?:sw\.(?:report\.)?)?([\w.]+)[^|]*` \| (?:`([\w-]+)`)? *\| [\d.]+\N{NO-BREAK SPACE}m?s \|$",
        questions,
        re.MULTILINE,
    )
    assert len(rows) == questions.count("\n| ") - 1 >= 20
    assert {verb for verb, _ in rows} - {*PUBLIC, "project.response", "write"} == set()
    assert {command for _, command in rows if command} - set(COMMANDS) == set()
    assert [verb for verb, _ in rows if f"{verb}`" not in sw.__doc__] == []  # `help(sw)` has them too


@pytest.mark.slow
def test_the_first_project_has_the_answer_that_its_page_says(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    project = next(block for block in blocks("tutorial.md") if block["language"] == "yaml")
    Path("axis.yaml").write_text(project["body"], encoding="utf-8")
    said = "".join(block["body"] for block in blocks("tutorial.md") if block["language"] == "console")
    curve = CliRunner().invoke(cli, ["response", "axis.yaml", "-o", "response.svg"])
    lines = curve.stdout.splitlines()
    first = next(i for i, line in enumerate(lines) if line.split()[:2] == ["assumed", "value"])
    told = [*lines[:4], *lines[first : first + 5]]
    assert [line for line in told if not says(said, line)] == []
    assert "how sure" in told[-1]
    answer = CliRunner().invoke(cli, ["analyze", "axis.yaml", "-o", "axis"]).stdout
    assert "304 to 357 and 491 to 875 rpm" in page("README.md")
    for fact in ("304 to 357 and 491 to 875 rpm", "109 arcsec at 673 rpm", "357 to 491 and 875 to 2000 rpm"):
        assert fact in said
        assert says(answer, fact)
    reduced = json.loads(Path("axis/results.json").read_text(encoding="utf-8"))["reduction"]["sentence"]
    assert says(reduced, "5.09 times the value of the whole drive train")  # docs/limits.md
    assert Path("axis/report.html").is_file()


def test_every_command_is_on_the_command_line_page_and_every_option_there_exists():
    commands = [cli, *(cli.get_command(None, name) for name in COMMANDS)]
    options = {option for command in commands for parameter in command.params for option in parameter.opts}
    assert [name for name in COMMANDS if not re.search(rf"`(?:strainwave )?{name}[` ]", page("command-line.md"))] == []
    assert set(re.findall(r"`(?:strainwave )?(--[\w-]+)", page("command-line.md"))) - options <= {"--help"}


def test_every_file_on_the_ways_through_the_code_exists():
    ways = page("inside.md").partition("## Four ways through the code")[2].partition("\n## ")[0]
    files = re.findall(r"`((?:src|tests)/[\w./]+)`", ways)
    assert ways.count("\n**") == 4
    assert len(files) >= 20
    assert [name for name in files if not (ROOT / name).exists()] == []


ASKED = re.compile(r"^\| [^|]+\? \| `strainwave ([^`|]+)` \| (.+) \|$", re.MULTILINE)


def test_one_text_says_which_command_answers_which_question(tmp_path):
    text = CliRunner().invoke(cli, ["skill"]).stdout
    assert (ROOT / "AGENTS.md").read_text(encoding="utf-8") == text
    pytest.importorskip("sphinx")
    settings = runpy.run_path(str(ROOT / "docs" / "conf.py"))
    settings["write_doors"](SimpleNamespace(outdir=tmp_path), None)
    assert (tmp_path / "llms.txt").read_text(encoding="utf-8") == text
    assert not re.search(r"pytest|CONTRIBUTING|ruff|test suite", text)
    rows = ASKED.findall(text)
    assert len(rows) == text.count("\n| ") - 1 >= 15
    for typed, _ in rows:
        command = cli.get_command(None, typed.split()[0])
        assert "--json" in typed
        assert {word for word in shlex.split(typed) if word.startswith("-")} <= {
            option for parameter in command.params for option in parameter.opts
        }


COMPUTED = ("analyze", "response", "speed-map", "exceedance", "move", "catalogue", "read-log", "export", "doctor")


@pytest.mark.slow
def test_answers_have_the_keys_that_the_text_says(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    text = CliRunner().invoke(cli, ["skill"]).stdout
    for line in re.findall(r"^    strainwave (.+)$", text, re.MULTILINE):
        assert CliRunner().invoke(cli, shlex.split(line)).exit_code == 0
    answers = {}
    Path("log.csv").write_text("time [s],motor_angle [rad]\n" + "".join(f"{0.01 * i},{i}\n" for i in range(100)))
    for typed, keys in ASKED.findall(text):
        words = shlex.split(typed)
        if words[0] not in COMPUTED:
            continue
        Path("axis.yaml").write_text(Path("axis.yaml").read_text() + SCATTER * (words[0] == "exceedance"))
        more = ["--count", "32"] * (words[0] == "exceedance")
        if typed not in answers:  # several questions have one command
            answers[typed] = json.loads(CliRunner().invoke(cli, [*words, *more]).stdout)
        for key in re.findall("`(.+?)`", keys):
            assert reduce(lambda data, part: data[part], key.split("."), answers[typed]) is not None, f"{typed}: {key}"


def test_what_a_run_without_an_installation_leaves_is_ignored():
    ignored = (ROOT / ".gitignore").read_text(encoding="utf-8").splitlines()
    assert {"uv.lock", ".venv/", "*.egg-info/", "__pycache__/"} <= set(ignored)
    needed = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["dependencies"]
    assert not [name for name in needed if name.startswith(("jinja2", "matplotlib"))]  # a report needs no extra


def test_every_group_and_law_of_a_project_file_is_on_its_page():
    groups = {field.split(".")[0].replace("[]", "") for field, _ in examples(ProjectSpec)}
    assert not_on("project-file.md", groups | set(law_types())) == []


def test_every_controller_is_on_the_page_of_compensation():
    rows = re.findall(r"^\| `([a-z-]+)` \|", page("compensation.md"), re.MULTILINE)
    assert rows == list(sw.study.COMPENSATORS)


def test_units_of_the_project_page_are_known():
    measured = {"angle": "rad", "angular speed": "rad/s", "torque": "N*m", "stiffness": "N*m/rad", "inertia": "kg*m**2"}
    for kind, unit in measured.items():
        row = re.search(rf"^\| {kind} \| (.*) \|$", page("project-file.md"), re.MULTILINE).group(1)
        known, _, refused = row.partition("never")
        assert all(parse(f"1 {name}", unit) > 0.0 for name in re.findall("`(.*?)`", known))
        for name in re.findall("`(.*?)`", refused):
            with pytest.raises(ValueError, match="write"):
                parse(f"1 {name}", unit)


def test_the_errata_table_is_complete():
    rows = re.findall(r"^\| ([EN][0-9]+b?) \|", page("theory.md"), re.MULTILINE)
    assert rows == [*(f"E{i}" for i in range(1, 12)), "N1", "N2", "N3", "N4", "N5", "N5b", "N6", "N7"]


def test_printed_text_is_compared_by_what_it_says():
    assert same("at 12.35 rpm in 3 steps", "at   12.34 rpm in 3 steps")
    assert same("J 0.0002, 149 arcsec", "J 0.00019999, 149.1 arcsec")  # formats drop zeros at the end
    assert same("5.00e-05", "4.99e-05")
    assert same("-0.00 rad", "0.00 rad")
    for other in ("at 12.36 rpm in 3 steps", "at 12.34 rpm in 4 steps", "at 12.34 rad/s in 3 steps", "at 12.34 rpm"):
        assert not same("at 12.34 rpm in 3 steps", other)
    assert not same("J 0.0002", "J 0.00022")
    assert not same("5.00e-05", "5.00e-06")
    assert says("it is\n  12.34 rpm, or 5.5", "is\n  12.35 rpm, or")
    assert not says("12.34 rpm, or 5.5 rpm", "5.7 rpm")
    assert differences("a 1.0\nb 2\n", "a 1.1\nb 3") == [("b 2", "b 3")]
    assert differences("a\nb", "a") == [("b", "")]
