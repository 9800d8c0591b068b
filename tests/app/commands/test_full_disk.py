"""A disk that is full, a path that is too long, a file in a folder's place: one sentence, and the old file intact."""

import errno
import os
import subprocess
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner
from linear_drive import LINEAR

from strainwave.app.commands.cli import cli
from strainwave.base.archive import atomic

pytest.importorskip("resource")  # Windows cannot limit the size of a file

PROJECT = f"title: Linear\n{LINEAR}"
# No file may be longer than so many bytes: what a disk says that is full, but for the word.
LIMITED = """\
import resource, signal, sys
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
size = int(sys.argv.pop(1))
resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))
from strainwave.app.commands.cli import main
main()
"""


def complaint(size, *call):
    """The last line on stderr of a command that may write `size` bytes to a file."""
    env = os.environ | {"STRAINWAVE_JIT": "0", "PYTHONDONTWRITEBYTECODE": "1"}  # Python would keep half a file of it
    call = [sys.executable, "-c", LIMITED, str(size), *map(str, call)]
    run = subprocess.run(call, env=env, text=True, capture_output=True, timeout=300.0, check=False)
    assert run.returncode == 1, run.stderr
    assert "Traceback" not in run.stderr
    return run.stderr.splitlines()[-1]


FULL = "file too large; free some space or choose another place; existing files are unchanged"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("call", "name"),
    [
        (("export", "--to", "c"), "drive.c"),
        (("export", "--to", "fmu2"), "drive.fmu"),
        (("response",), "curve.csv"),
        (("response",), "curve.svg"),
    ],
)
def test_a_full_disk_is_one_sentence_and_the_old_file_stays(drive, tmp_path, call, name):
    folder = tmp_path / "out"
    folder.mkdir()
    (folder / name).write_text("old", encoding="utf-8")
    told = complaint(512, call[0], drive, *call[1:], "-o", folder / name)
    draft = "a file that was being written" if name.endswith(".fmu") else str(folder)  # its sources are elsewhere
    assert told.startswith(f"strainwave: {draft}")
    assert told.endswith(FULL)
    assert [path.name for path in folder.iterdir()] == [name]
    assert (folder / name).read_text(encoding="utf-8") == "old"


@pytest.mark.slow
def test_folders_too(drive, tmp_path):
    for call in (("analyze",), ("speed-map",)):
        folder = tmp_path / call[0]
        folder.mkdir()
        (folder / "report.html").write_text("old", encoding="utf-8")
        told = complaint(2048, *call, drive, "-o", folder)
        assert told == f"strainwave: {folder}: {FULL}"
        assert [path.name for path in folder.iterdir()] == ["report.html"]
        assert (folder / "report.html").read_text(encoding="utf-8") == "old"


@pytest.mark.slow
def test_a_sweep_keeps_what_was_finished_and_goes_on(drive, tmp_path):
    store = tmp_path / "store"
    call = ["sweep", drive, "--grid", "omega=100:200:2000", "--chunk", "1000", "--settle", "1", "--periods", "1"]
    told = complaint(4096, *call, "-o", store)
    assert told.count("strainwave:") == 1
    assert str(store) in told
    how = {"env": os.environ | {"STRAINWAVE_JIT": "0"}, "capture_output": True, "text": True, "check": True}
    again = subprocess.run([sys.executable, "-m", "strainwave", *map(str, call), "-o", str(store)], **how)
    assert "2000 points" in again.stdout


@pytest.mark.slow
def test_long_paths_and_files_in_a_folders_place(drive, tmp_path):
    assert complaint(10**9, "export", drive, "--to", "c", "-o", tmp_path / ("x" * 300 + ".c")).endswith(
        ": file name too long; choose a shorter path"
    )
    (tmp_path / "file").write_text("old", encoding="utf-8")
    told = complaint(10**9, "response", drive, "-o", tmp_path / "file" / "curve.csv")
    assert told.endswith(": file exists; a file has the name of the required folder; choose another place")
    assert (tmp_path / "file").read_text(encoding="utf-8") == "old"


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="the system has no device that is always full")
@pytest.mark.parametrize(
    ("verb", "output", "file"),
    [("response", "c.csv", "c.csv"), pytest.param("analyze", "out", "out/report.html", marks=pytest.mark.slow)],
)
def test_a_full_standard_output_is_named_and_the_files_are_there(drive, tmp_path, verb, output, file):
    call = [sys.executable, "-m", "strainwave", verb, str(drive), "-o", str(tmp_path / output)]
    with open("/dev/full", "w", encoding="utf-8") as full:
        run = subprocess.run(call, stdout=full, stderr=subprocess.PIPE, text=True, check=False)
    assert run.returncode == 1
    assert run.stderr.splitlines()[-1].startswith("strainwave: standard output: no space left on device; files")
    assert (tmp_path / file).is_file()


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="the system has no device that is always full")
@pytest.mark.parametrize("call", ["--help", "--version", "response --help"])
def test_help_on_a_full_standard_output_is_one_sentence(call):
    with open("/dev/full", "w", encoding="utf-8") as full:
        line = [sys.executable, "-m", "strainwave", *call.split()]
        run = subprocess.run(line, stdout=full, stderr=subprocess.PIPE, text=True, check=False)
    assert run.returncode == 1
    (told,) = run.stderr.splitlines()
    assert told.startswith("strainwave: standard output: no space left on device; files")


def test_a_disk_that_takes_no_file_is_named_by_what_was_asked(tmp_path, monkeypatch):
    def refuse(path, *_, **__):
        raise OSError(errno.EROFS, "Read-only file system", str(path))

    monkeypatch.setattr(Path, "unlink", refuse)
    monkeypatch.setattr(Path, "write_text", refuse)
    outer, inner = tmp_path / "x.h", tmp_path / "x.c"
    with pytest.raises(OSError, match="Read-only") as told, atomic(outer) as header, atomic(inner):
        Path(header).write_text("", encoding="utf-8")
    assert told.value.filename == str(outer)
    monkeypatch.setattr(os, "replace", lambda old, _: refuse(old))
    with pytest.raises(OSError, match="Read-only") as told, atomic(outer):
        pass
    assert told.value.filename == str(outer)


@pytest.mark.parametrize(
    ("call", "name"),
    [
        ("response {} -o {}", "me.csv"),
        ("export {} --to c -o {}", "me.c"),
        ("tune {} -o {folder}", "tuned.yaml"),
        ("read-log {} -o {folder}", "log.csv"),
        ("order-table {} {}", "table.json"),
    ],
)
def test_an_output_that_is_an_input_is_refused_before_anything_is_computed(tmp_path, call, name):
    path = tmp_path / name
    path.write_text(PROJECT, encoding="utf-8")
    run = CliRunner().invoke(cli, call.format(path, path, folder=tmp_path).split())
    assert run.exit_code == 1
    assert run.output == (f"strainwave: {path} is an input of this command and would be replaced; write elsewhere\n")
    assert path.read_text(encoding="utf-8") == PROJECT


@pytest.mark.skipif(sys.platform == "win32", reason="its shell closes no streams")
def test_streams_that_the_shell_has_closed_are_empty(drive, tmp_path):
    def run(call):
        call = f'"{sys.executable}" -m strainwave {call}'
        return subprocess.run(call, shell=True, capture_output=True, text=True, check=False)

    curve = run(f'response "{drive}" 2>&-')
    assert (curve.returncode, "pointing error" in curve.stdout) == (0, True)
    new = run(f'new -o "{tmp_path}/n.yaml" <&-')
    assert new.returncode == 2
    assert new.stderr.endswith("must be given when the command does not run on a terminal\n")
