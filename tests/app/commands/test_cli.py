"""The command line: exit codes, sentences, JSON, what is written and what is not."""

import errno
import json
import os
import subprocess
import sys
import tempfile
from importlib import import_module
from pathlib import Path

import click
import numpy as np
import pytest
from click.testing import CliRunner
from small_drive import PROJECT
from twelve_projects import PROJECTS

import strainwave as sw
from strainwave.app.commands import cli as command
from strainwave.app.console.output_files import staged
from strainwave.base.facts import data


def invoke(*args):
    return CliRunner().invoke(command.cli, [str(a) for a in args])


def run(*args, **options):
    return subprocess.run(
        [sys.executable, "-m", "strainwave", *map(str, args)], capture_output=True, text=True, check=False, **options
    )


def forbid_constants(text):
    raise AssertionError(f"{text} is not JSON")


def test_help_has_every_command_once_in_a_group_and_cuts_no_line_of_a_terminal_of_80_columns():
    said = CliRunner().invoke(command.cli, ["--help"], terminal_width=80).stdout
    listed = said[said.index("Start:") :].splitlines()
    width = max(map(len, command.COMMANDS)) + 2
    for name, (_, sentence) in command.COMMANDS.items():
        assert [line for line in listed if line.split()[:1] == [name]] == [f"  {name:<{width}}{sentence}"]
    assert max(map(len, said.splitlines())) <= 80
    grouped = [name for names in command.GROUPS.values() for name in names.split()]
    assert sorted(grouped) == list(command.COMMANDS)


def light(*words, **environment):
    """What a call prints that imports nothing heavy."""
    code = (
        f"import sys; sys.argv = ['strainwave', *{words!r}]\n"
        "from strainwave.app.commands.cli import main\n"
        "try: main()\nexcept SystemExit: pass\n"
        "heavy = {'numba', 'numpy', 'scipy', 'matplotlib', 'sympy', 'xarray', 'pydantic', 'rich', 'jinja2'}\n"
        "print(sorted(heavy & set(sys.modules)), file=sys.stderr)"
    )
    how = {"capture_output": True, "text": True, "check": True, "env": os.environ | environment}
    result = subprocess.run([sys.executable, "-c", code], **how)
    assert result.stderr.strip() == "[]"
    return result.stdout


def test_help_imports_nothing_heavy():
    assert "analyze" in light("--help")


def test_completion_of_a_command_imports_nothing_heavy():
    called = {"_STRAINWAVE_COMPLETE": "bash_complete", "COMP_WORDS": "strainwave comp", "COMP_CWORD": "1"}
    names = [line.split(",")[1] for line in light(**called).splitlines()]
    assert names == ["compare", "compensate", "completion"]


@pytest.mark.skipif(not hasattr(click.exceptions, "NoSuchCommand"), reason="an older click compares no names")
def test_a_wrong_command_is_told_the_nearest_one():
    assert "No such command 'analyse'. Did you mean 'analyze'?" in invoke("analyse").output


@pytest.mark.parametrize("name", command.COMMANDS)
def test_sentence_in_the_list_of_commands_is_the_first_of_the_help(name):
    asked = command.cli.get_command(None, name)
    said = " ".join(asked.help.partition("\n\n")[0].split())
    assert asked.name == name
    assert said == command.COMMANDS[name][1] or said.startswith(f"{command.COMMANDS[name][1]} ")


def test_every_command_is_listed_in_the_order_of_its_name():
    folder = Path(command.__file__).parent
    modules = {".".join(path.relative_to(folder).with_suffix("").parts) for path in folder.rglob("*.py")}
    declared = {
        (module, thing.name)
        for module in modules
        for thing in vars(import_module(f"strainwave.app.commands.{module}".removesuffix(".__init__"))).values()
        if isinstance(thing, click.Command) and thing is not command.cli
    }
    assert declared == {(module, name) for name, (module, _) in command.COMMANDS.items()}
    assert list(command.COMMANDS) == sorted(command.COMMANDS)


@pytest.mark.slow
def test_a_response_of_a_spring_imports_no_library_that_it_does_not_need(drive):
    code = (
        f"import sys; sys.argv = ['strainwave', 'response', {str(drive)!r}]\n"
        "from strainwave.app.commands.cli import main\n"
        "try: main()\nexcept SystemExit as end: assert not end.code\n"
        "heavy = {'numba', 'scipy', 'matplotlib', 'sympy', 'xarray', 'zarr', 'dask', 'jinja2'}\n"
        "print(sorted(heavy & set(sys.modules)), file=sys.stderr)"
    )
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert "largest oscillation" in result.stdout
    assert result.stderr.splitlines()[-1] == "[]"


@pytest.mark.parametrize("args", [("analyze",), ("nonsense",), ("analyze", "--both"), ("catalogue", "--size", "big")])
def test_wrong_usage_exits_with_2(args):
    assert invoke(*args).exit_code == 2


def test_output_that_is_a_file_is_wrong_usage_and_the_file_is_kept(drive, tmp_path):
    target = tmp_path / "taken"
    target.write_text("mine")
    assert invoke("analyze", drive, "-o", target).exit_code == 2
    assert target.read_text() == "mine"


def test_invalid_project_exits_with_3_names_the_place_and_writes_nothing(tmp_path):
    path = tmp_path / "bad.yaml"
    path.write_text(PROJECT.replace("5 %", "-5 %"))
    result = invoke("analyze", path, "-o", tmp_path / "out")
    assert result.exit_code == 3
    assert f"{path}:5:" in result.stderr
    assert "damping.ratio" in result.stderr
    assert result.stdout == ""
    assert sorted(p.name for p in tmp_path.iterdir()) == ["bad.yaml"]


def test_unexpected_error_is_one_sentence_and_a_traceback_only_on_demand(monkeypatch, drive, tmp_path):
    def broken(*_):
        raise ZeroDivisionError("float division by zero")

    monkeypatch.setattr("strainwave.app.commands.analyze.report_of", broken)
    result = invoke("analyze", drive, "-o", tmp_path / "out")
    assert result.exit_code == 1
    assert result.stderr.count("\n") == 1
    assert "ZeroDivisionError" in result.stderr
    assert isinstance(invoke("--debug", "analyze", drive, "-o", tmp_path / "out").exception, ZeroDivisionError)
    monkeypatch.setenv("STRAINWAVE_DEBUG", "1")
    assert isinstance(invoke("analyze", drive, "-o", tmp_path / "out").exception, ZeroDivisionError)


def test_a_program_that_runs_the_command_in_its_own_process_goes_on():
    code = (
        "import runpy, sys\nsys.argv = ['strainwave', '--version']\n"
        "try: runpy.run_module('strainwave', run_name='__main__')\nexcept SystemExit as end: print('ended', end.code)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=120)
    assert done.stdout.splitlines()[1:] == ["ended 0"]


def test_interrupt_exits_with_130_and_leaves_nothing(monkeypatch, drive, tmp_path):
    def stopped(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr("strainwave.drive.project.Project.analyze", stopped)
    result = invoke("analyze", drive, "-o", tmp_path / "out")
    assert result.exit_code == 130
    assert "interrupted" in result.stderr
    assert sorted(p.name for p in tmp_path.iterdir()) == ["drive.yaml"]


def test_staged_files_join_an_existing_folder(tmp_path):
    out = tmp_path / "out"
    out.mkdir()
    (out / "notes.txt").write_text("mine")
    with staged(out) as part:
        (part / "report.html").write_text("new")
        assert not (out / "report.html").exists()
    assert sorted(p.name for p in out.iterdir()) == ["notes.txt", "report.html"]
    assert sorted(p.name for p in tmp_path.iterdir()) == ["out"]


def test_where_no_folder_can_be_made_the_file_that_was_asked_for_is_named(tmp_path, monkeypatch):
    def full(*_, dir, **__):
        raise OSError(errno.ENOSPC, "No space left on device", f"{dir}/.strainwave.x")

    monkeypatch.setattr(tempfile, "mkdtemp", full)
    with pytest.raises(OSError, match=r"No space left on device: '[^']*[/\\]x\.csv'"), staged(tmp_path, "x.csv"):
        pass


def test_staged_removes_the_parents_it_made_when_the_block_fails(tmp_path):
    with pytest.raises(RuntimeError), staged(tmp_path / "a" / "b"):
        raise RuntimeError
    assert list(tmp_path.iterdir()) == []


@pytest.mark.skipif(os.name == "nt" or os.geteuid() == 0, reason="needs a folder that this user may not write")
def test_folder_that_cannot_be_written_is_one_sentence(drive, tmp_path):
    closed = tmp_path / "closed"
    closed.mkdir(mode=0o500)
    result = invoke("analyze", drive, "-o", closed / "out")
    assert result.exit_code == 1
    assert "permission denied" in result.stderr


def test_catalogue_lists_filters_and_shows_one_gear():
    listed = json.loads(invoke("catalogue", "--size", "40", "--json").stdout, parse_constant=forbid_constants)["gears"]
    assert {g["size"] for g in listed} == {40}
    record = json.loads(invoke("catalogue", "csg-40-50", "--json").stdout, parse_constant=forbid_constants)["gear"]
    assert (record["K1"], record["T1"], record["mass"]) == (1e5, 54.0, None)
    shown = invoke("catalogue", "CSG-40-50").stdout
    assert (
        "circular spline fixed, flexspline at the output: ratio 50, output turns against the motor (as printed)"
        in shown
    )
    assert "circular spline at the output: ratio 51, output turns with the motor (fixed: flexspline)" in shown
    assert "CSG-40-50" in invoke("catalogue", "--series", "csg", "--ratio", "50").stdout
    table = CliRunner(env={"COLUMNS": "80"}).invoke(command.cli, ["catalogue"]).stdout
    assert max(map(len, map(str.rstrip, table.splitlines()))) <= 80
    assert [name for name in sw.catalogue.names() if f" {name} " not in table] == []
    unknown = invoke("catalogue", "CSG-41-50")
    assert (unknown.exit_code, unknown.stdout) == (1, "")
    assert "CSG-40-50" in unknown.stderr


def test_doctor_reports_cache_cores_and_extras(tmp_path, monkeypatch):
    monkeypatch.setenv("STRAINWAVE_CACHE_DIR", str(tmp_path))
    facts = json.loads(run("doctor", "--json").stdout, parse_constant=forbid_constants)
    assert facts["cache"]["folder"].startswith(str(tmp_path))
    assert facts["cache"]["writable"] is True
    assert facts["cores"]["usable"] >= 1
    assert set(facts["extras"]) >= {"plot", "sym", "logs"}
    assert "cache" in run("doctor").stdout


def test_doctor_tells_of_a_home_that_is_not_readable_why_code_is_not_kept(tmp_path, monkeypatch):
    true_stat = os.stat

    def stat(path, *args, **options):
        if not isinstance(path, int) and tmp_path in Path(os.fsdecode(path)).parents:
            raise PermissionError(errno.EACCES, "Permission denied", str(path))
        return true_stat(path, *args, **options)

    def file(dir):
        raise PermissionError(errno.EACCES, "Permission denied", str(dir))

    doctor = import_module("strainwave.app.commands.installation.doctor")
    monkeypatch.setattr(doctor.cache, "cache_folder", lambda: tmp_path / ".cache" / "strainwave")
    monkeypatch.setattr(doctor.tempfile, "TemporaryFile", file)
    monkeypatch.setattr(os, "stat", stat)
    found = data(doctor.facts())["cache"]
    assert (found["writable"], found["bytes"]) == (False, 0)
    assert found["why"] == f"{tmp_path}: permission denied; set STRAINWAVE_CACHE_DIR to a folder that can be written"


@pytest.mark.parametrize(
    "call", [("derive", "-o", "d.txt"), ("reproduce", "-o", "folder"), ("response", "-o", "c.svg")]
)
def test_a_place_that_cannot_be_written_is_refused_before_anything_is_computed(tmp_path, call):
    file, project = tmp_path / "file", tmp_path / "drive.yaml"
    file.write_text("no folder")
    project.write_text(PROJECT)
    name, option, place = call
    result = CliRunner().invoke(
        command.cli, [name, *([str(project)] * (name == "response")), option, str(file / "in" / place)]
    )
    assert result.exit_code == 1
    assert result.stderr.startswith(f"strainwave: {file / 'in'}")
    assert "has the name of the required folder" in result.stderr
    assert result.stderr.count("\n") == 1  # no progress
    assert set(os.listdir(tmp_path)) == {"file", project.name}


def test_derive_refuses_an_ending_that_it_does_not_write():
    result = CliRunner().invoke(command.cli, ["derive", "-o", "d.pdf"])
    assert result.exit_code == 2
    assert "'d.pdf' must end in .html, .tex or .txt" in result.stderr


@pytest.mark.slow
def test_derive_of_a_train_says_what_its_error_equation_leaves_out(tmp_path):
    train = tmp_path / "train.yaml"
    train.write_text(PROJECTS["position loop, coupling"])
    told = json.loads(invoke("derive", train, "--json").stdout)
    assert (told["subject"], told["left_out"]) == ("the whole drive train", ["the motor's loop", "the coupling"])
    assert told["J_kg_m2"] == 1.3  # 1 behind and .3 before the coupling
    assert told["mu"] == pytest.approx(20.0 / 1.3, rel=1e-12)
    assert [line["order"] for line in told["lines"]] == [2, 4]
    omega, arcsec = 1750.0 * np.pi / 30.0, np.pi / 648000.0  # the middle of 1000 to 2500 rpm
    for line, size in zip(told["lines"], (23.0, 3.0), strict=True):  # of u = x - e: that of -e"
        assert line["A_rad_per_s2"] == pytest.approx((line["order"] * omega) ** 2 * size * arcsec, rel=1e-9)
    assert "neglected in the error equation: the motor's loop and the coupling" in told["text"]
    assert told["latex"].startswith("% ")


@pytest.mark.slow
def test_derive_of_the_article_is_its_error_equation_and_writes_a_page_that_needs_no_network(tmp_path):
    article = tmp_path / "article.yaml"
    article.write_text(PROJECTS["article"])
    told = json.loads(invoke("derive", article, "--json", "-o", tmp_path / "article.html").stdout)
    assert (told["subject"], told["left_out"], told["mean_N_m"]) == ("the error equation", [], 0.0)
    assert told["lines"] == [{"order": 1, "A_rad_per_s2": pytest.approx(10.0 / (50.0 * 5.26e-4), rel=1e-12)}]
    page = (tmp_path / "article.html").read_text(encoding="utf-8")
    assert page.count("<math>") > 70
    assert page.count("<h2>") == 5
    assert "http:" not in page
    assert "src=" not in page
    for ending, begin in (("tex", "\\begin{aligned}"), ("txt", "Error equation")):
        written = tmp_path / f"steps.{ending}"
        assert invoke("derive", "-o", written).stdout == f"written: {written}\n"
        assert written.read_text(encoding="utf-8").startswith(begin)


@pytest.mark.slow
def test_json_on_stdout_is_alone_and_progress_goes_to_stderr(drive, tmp_path):
    result = run("analyze", drive, "-o", tmp_path / "out", "--json")
    assert result.returncode == 0, result.stderr
    parsed = json.loads(result.stdout, parse_constant=forbid_constants)
    assert parsed["title"] == "A small drive"
    assert all(line.startswith("A small drive: ") and " s so far" in line for line in result.stderr.splitlines())
    assert "\x1b" not in result.stderr
    assert Path(tmp_path / "out" / "report.html").exists()


@pytest.mark.slow
@pytest.mark.parametrize("name", ["analyze", "speed-map", "response"])
def test_json_of_a_question_needs_no_folder(drive, monkeypatch, name):
    monkeypatch.chdir(drive.parent)
    answer = json.loads(invoke(name, drive.name, "--json").stdout, parse_constant=forbid_constants)
    assert answer["title"] == "A small drive"
    assert sorted(Path().iterdir()) == [Path("drive.yaml")]


def test_a_report_without_a_folder_is_written_into_one_of_the_name_of_its_file(drive, monkeypatch):
    monkeypatch.chdir(drive.parent)
    monkeypatch.setattr("strainwave.app.commands.analyze._analyzed", lambda *given: str(given[1:]))
    assert invoke("analyze", "drive.yaml").stdout == "(PosixPath('drive-report'), False, False)\n"
    assert "'reports'" in invoke("analyze", "drive.yaml", "drive.yaml", "--compare", "--json").stdout
