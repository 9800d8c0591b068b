"""New project files by options and by questions; the schema and completion as commands."""

import json
import os
import select
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner
from linear_drive import LINEAR

import strainwave as sw
from strainwave.app.commands import cli as command
from strainwave.app.commands.installation.completion import SHELLS
from strainwave.app.commands.new import QUESTIONS, new
from strainwave.base.units import ARCSEC
from strainwave.files.reading import read_project
from strainwave.files.reference import project_schema

GIVEN = ("--gear", "CSG-40-50", "--load-inertia", "10 kg m^2")
SOURCE = str(Path(command.__file__).parents[3])
PROMPTS = tuple(question.prompt for question in QUESTIONS)
CTRL_C = "\x03"
POSIX = pytest.mark.skipif(os.name != "posix", reason="there is no pseudo-terminal")


def invoke(*args):
    return CliRunner().invoke(command.cli, [str(a) for a in args])


def dialogue(folder, answers, *options):
    """What a terminal shows, the exit code, and the answers that are left, with one answer for every prompt."""
    import fcntl
    import pty
    import termios

    terminal, other = pty.openpty()
    environment = {**os.environ, "PYTHONPATH": SOURCE, "TERM": "dumb"}
    command_line = [sys.executable, "-m", "strainwave", "new", *options]
    process = subprocess.Popen(
        command_line, cwd=folder, env=environment, stdin=other, stdout=other, stderr=other, start_new_session=True,
        preexec_fn=lambda: fcntl.ioctl(0, termios.TIOCSCTTY, 0),
    )  # fmt: skip
    os.close(other)
    shown, waiting, last, patience = "", list(answers), "", 6
    while patience:
        if not select.select([terminal], [], [], 5.0)[0]:
            patience -= 1
            if last == CTRL_C:  # one that comes between two checks of the interpreter waits for the next key
                os.write(terminal, last.encode())
            continue
        try:
            shown += os.read(terminal, 4096).decode()
        except OSError:  # the other side is closed
            break
        line = shown.replace("\r", "").rsplit("\n", 1)[-1].lstrip()
        if waiting and line.endswith(": ") and line.startswith(PROMPTS):
            last = waiting.pop(0)
            os.write(terminal, last.encode())
    os.close(terminal)
    return shown.replace("\r", ""), process.wait(30.0), waiting


def test_a_file_by_options_can_be_read_and_explains_its_fields(tmp_path):
    path = tmp_path / "drive.yaml"
    run = invoke("new", *GIVEN, "--gravity", "100", "--loop", "30 Hz", "--budget", "60 arcsec", "-o", path)
    assert run.exit_code == 0, run.output
    project = read_project(path)
    assert (project.gear.name, project.drive.J_l, project.title) == ("CSG-40-50", 10.0, "drive")
    assert project.load_torques == pytest.approx((-100.0, 100.0))
    lines = path.read_text(encoding="utf-8").splitlines()
    fields = [i for i, line in enumerate(lines) if line and not line.lstrip().startswith("#")]
    assert len(fields) > 10
    assert all(lines[i - 1].lstrip().startswith("#") for i in fields)
    assert "# Inertia of the load, on the output side [kg*m^2], above 0." in path.read_text(encoding="utf-8")
    assert invoke("analyze", path, "--check").exit_code == 0


def test_every_question_has_an_option_and_every_option_is_kept(tmp_path):
    assert {q.option for q in QUESTIONS} <= {o for p in new.params for o in p.opts}
    path = tmp_path / "drive.yaml"
    more = ("--title", 'The "axis"', "--motor-inertia", "5 kg*cm^2", "--kinematic-error", "20", "--damping", "2 %")
    run = invoke("new", *GIVEN, *more, "--speed-from", "200", "--speed-to", "60 rev/s", "-o", path)
    assert run.exit_code == 0, run.output
    project = read_project(path)
    assert project.title == 'The "axis"'
    assert project.drive.J_m == pytest.approx(5e-4, rel=1e-12)
    assert project.kinematic_error.lines[0].amplitude == pytest.approx(20.0 * 4.84813681109536e-6, rel=1e-9)
    assert project.damping_ratio == pytest.approx(0.02, rel=1e-12)
    assert project.speeds.limits == pytest.approx((200 * 0.10471975511965977, 60 * 6.283185307179586), rel=1e-9)


def test_an_accuracy_takes_the_place_of_the_record_s_in_error_and_budget(tmp_path):
    path = tmp_path / "drive.yaml"
    assert invoke("new", *GIVEN, "--accuracy", "45", "-o", path).exit_code == 0
    project = read_project(path)
    assert sw.gears.peak_to_peak(project.kinematic_error) == pytest.approx(45.0 * ARCSEC, rel=1e-12)
    assert project.limit == pytest.approx(45.0 * ARCSEC, rel=1e-12)
    unknown = ("--gear", "HFUC-90-100", "--load-inertia", "200", "--motor-inertia", "300")
    assert invoke("new", *unknown, "--budget", "none", "-o", path, "--force").exit_code == 0
    bare = read_project(path)
    assert sw.gears.peak_to_peak(bare.kinematic_error) == pytest.approx(60.0 * ARCSEC, rel=1e-12)
    (why,) = (one.why for one in bare.sources if (one.name, one.word) == ("excitation.accuracy", "assumed"))
    assert why.startswith("the accuracy is assumed; ")
    assert any("60 arcsec peak-to-peak (assumed), orders " in note for note in bare.notes)
    assert invoke("new", *unknown, "--accuracy", "1 arcmin", "-o", path, "--force").exit_code == 0
    assert read_project(path).limit == pytest.approx(60.0 * ARCSEC, rel=1e-12)


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        (("--gear", "CSG-40"), "--gear: 'CSG-40' is a part of CSG-40-50"),
        (("--gear", "XYZ-9"), "--gear: the catalogue has no gear 'XYZ-9'"),
        (
            ("--motor-inertia", "7 g*cm^2"),
            "'7 g*cm^2' is less than the inertia of the wave generator of CSG-40-50 alone",
        ),
        (("--speed-from", "4000 rpm"), "--speed-to must be given: '3000 rpm' is not above the lowest speed"),
        (("--loop", "30 rpm"), "--loop: '30 rpm' is a speed of a shaft, not a bandwidth"),
        (("--accuracy", "60 deg"), "--accuracy: '60 deg' is above 1 deg, and catalogues have 0.5 to 3 arcmin"),
        (("--accuracy", "50", "--kinematic-error", "9"), "--kinematic-error: '9 arcsec' and --accuracy both set"),
        (("--title", "x" * 300), "--title: is longer than one line"),
    ],
)
def test_a_bad_value_is_one_sentence_and_nothing_is_written(tmp_path, options, sentence):
    run = invoke("new", *GIVEN, *options, "-o", tmp_path / "drive.yaml")
    assert run.exit_code == 2
    assert sentence in run.output
    assert list(tmp_path.iterdir()) == []


def test_a_file_that_exists_is_kept_without_force(tmp_path):
    path = tmp_path / "drive.yaml"
    path.write_text("mine", encoding="utf-8")
    assert "use --force" in invoke("new", *GIVEN, "-o", path).output
    assert path.read_text(encoding="utf-8") == "mine"
    assert invoke("new", *GIVEN, "-o", path, "--force").exit_code == 0
    assert read_project(path).drive.J_l == 10.0
    assert "there is no folder" in invoke("new", *GIVEN, "-o", tmp_path / "none" / "drive.yaml").output


def test_a_schema_beside_the_file_is_named_in_its_first_line(tmp_path):
    (tmp_path / "strainwave.schema.json").write_text(invoke("schema").output, encoding="utf-8")
    assert invoke("new", *GIVEN, "-o", tmp_path / "drive.yaml").exit_code == 0
    first = (tmp_path / "drive.yaml").read_text(encoding="utf-8").splitlines()[0]
    assert first == "# yaml-language-server: $schema=strainwave.schema.json"


@POSIX
def test_questions_are_asked_until_they_are_answered(tmp_path):
    answers = ["\n", "csg 40\n", "csg-40-50\n", "-3\n", "10\n", *["\n"] * 7, "600\n", "500 rpm\n", "2000\n"]
    shown, code, left = dialogue(tmp_path, answers)
    assert (code, left) == (0, []), shown
    assert "'csg 40' is a part of CSG-40-50, CSG-40-80" in shown
    assert "'-3 kg*m^2' is not positive; write a value above zero" in shown
    assert "'500 rpm' is not above the lowest speed, 600 rpm" in shown
    for question in QUESTIONS:
        assert question.sentence in " ".join(shown.split())
    project = read_project(tmp_path / "drive.yaml")
    assert (project.gear.name, project.drive.J_l) == ("CSG-40-50", 10.0)


@POSIX
def test_ctrl_c_writes_nothing(tmp_path):
    shown, code, _ = dialogue(tmp_path, ["\n", "CSG-40-50\n", CTRL_C])
    assert (code, list(tmp_path.iterdir())) == (130, []), shown
    assert "interrupted; nothing was written" in shown


def test_the_schema_command_prints_the_schema():
    assert json.loads(invoke("schema").output) == project_schema()


@pytest.mark.parametrize("shell", SHELLS)
def test_completion_has_a_script_for_every_shell(shell):
    assert "strainwave" in invoke("completion", shell).output


@pytest.mark.skipif(shutil.which("bash") is None, reason="there is no bash")
@pytest.mark.parametrize(
    ("words", "found"),
    [
        (["an"], ["analyze"]),
        (["export", "--st"], ["--step"]),
        (["export", "--to", "fm"], ["fmu2", "fmu3"]),
        (["new", "--gear", "CSG-40-5"], ["CSG-40-50"]),
        (["catalogue", "csg-40-5"], ["CSG-40-50"]),
        (["completion", ""], list(SHELLS)),
    ],
)
def test_bash_completes(tmp_path, words, found):
    program = tmp_path / "strainwave"
    program.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m strainwave "$@"\n', encoding="utf-8")
    program.chmod(0o755)
    environment = {**os.environ, "PATH": f"{tmp_path}{os.pathsep}{os.environ['PATH']}"}
    environment["PYTHONPATH"] = SOURCE
    listed = " ".join(f"'{word}'" for word in ["strainwave", *words])
    script = (
        'eval "$(strainwave completion bash)"\n'
        f"COMP_WORDS=({listed}); COMP_CWORD={len(words)}\n"
        "_strainwave_completion strainwave 2>/dev/null\n"
        'printf "%s\\n" "${COMPREPLY[@]}"\n'
    )
    run = subprocess.run(
        ["bash", "--norc", "-c", script], capture_output=True, text=True, check=False, env=environment, cwd=tmp_path
    )
    assert run.stdout.split() == found, run.stderr


@pytest.mark.slow
@pytest.mark.skipif(sys.platform in ("win32", "darwin"), reason="names of files are text there")
@pytest.mark.parametrize("name", [b"ax\xff", "größe".encode()])
def test_a_report_of_a_file_with_any_name_is_whole_where_the_locale_has_no_letters_for_it(tmp_path, name):
    (tmp_path / os.fsdecode(name + b".yaml")).write_text(LINEAR, encoding="utf-8")
    call = [sys.executable, "-m", "strainwave", "analyze", name + b".yaml", "-o", "out"]
    environment = os.environ | {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONPATH": SOURCE, "STRAINWAVE_JIT": "0"}
    run = subprocess.run(call, cwd=tmp_path, env=environment, capture_output=True, check=False)
    assert run.returncode == 0, run.stderr
    assert {"report.html", "results.json"} < {path.name for path in (tmp_path / "out").iterdir()}
    results = json.loads((tmp_path / "out" / "results.json").read_text(encoding="utf-8"))
    assert results["title"] == name.decode("ascii", "surrogateescape").encode(errors="backslashreplace").decode()
    assert "</html>" in (tmp_path / "out" / "report.html").read_text(encoding="utf-8")


def test_a_name_that_is_no_gear_is_refused_and_the_nearest_are_named(tmp_path):
    known = [sw.catalogue.gear(name) for name in sw.catalogue.names()]
    series, sizes, ratios = [sorted({getattr(g, key) for g in known}) for key in ("series", "size", "ratio")]
    absent = [
        f"{a}-{b}-{c}" for a in series for b in sizes for c in ratios if f"{a}-{b}-{c}" not in sw.catalogue.names()
    ]
    some = [*absent[:: max(1, len(absent) // 480)], *(g.name[:-1] for g in known[::9])][:500]
    assert {"HFUC-20-80", "CSG-80-50", "CSG-8-100", "HFUC-50-80"} - set(sw.catalogue.names())
    for name in ("HFUC-20-80", "CSG-80-50", "CSG-8-100", *some):
        run = invoke("new", "--gear", name, *GIVEN[2:], "-o", tmp_path / "drive.yaml")
        assert run.exit_code == 2, name
        assert (
            "; the nearest are " in run.output or "is a part of " in run.output or "write the whole name" in run.output
        )
        assert list(tmp_path.iterdir()) == []
