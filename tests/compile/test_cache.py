"""The folder of compiled code: what a later process takes from it, and what it must not."""

import ast
import os
import platform
import shutil
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

import strainwave
from strainwave.compile import cache

PACKAGE = Path(strainwave.__file__).parent

COUNTS = """
import strainwave as sw
from strainwave.compile import jit
from strainwave.base.quantities import checked

def torque(law, x):
    return law.torque(x)

def end_of(law):
    return jit.run(torque, checked(law), 0.3)

def moved(law):
    system = sw.Oscillator(1.0, 0.05, law, sw.Harmonic(0.18), 0.7)
    return sw.simulate(system, (0.3, 0.0), 20.0, method=sw.Rk4(steps_per_period=64)).y[0, -1]

made_before = jit._made
dispatchers = set()

def made_and_kept(*args):
    dispatchers.add(made_before(*args))
    return made_before(*args)

jit._made = made_and_kept

def counts():
    stats = [dispatcher.stats for dispatcher in dispatchers]
    return [sum(sum(of.values()) for of in some) for some in zip(*((s.cache_hits, s.cache_misses) for s in stats))]

"""

PACKAGES = COUNTS + "end_of(sw.Cubic(1, 0.1)); end_of(sw.Cubic(1.0, 0.1)); print(*counts())"

USERS = (
    COUNTS
    + """
from typing import NamedTuple
from strainwave.maths import exp
{before}

class Tanh(NamedTuple):
    K: float
    s: float
    def torque(self, x):
        e = exp(-2 * x / self.s)
        return self.K * self.s * (1 - e) / (1 + e){after}

print(float(end_of(Tanh(1.0, 0.5)))); print(*counts())
"""
)


def script(before="", after=""):
    return USERS.replace("{before}", before).replace("{after}", after)


def run_script(code, folder, package=PACKAGE, **environment):
    """Run code in a new process with its own folder of compiled code; the words that it prints."""
    env = os.environ | {"STRAINWAVE_CACHE_DIR": str(folder), "PYTHONPATH": str(package.parent)} | environment
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False, env=env)
    assert run.returncode == 0, run.stderr
    assert run.stderr == ""
    return run.stdout.split()


def files_in(folder):
    return {str(path.relative_to(folder)) for path in folder.rglob("*.code")}


def test_second_process_takes_the_package_classes_from_disk_and_int_and_float_parameters_share_them(tmp_path):
    assert run_script(PACKAGES, tmp_path) == ["0", "1"]
    files = files_in(tmp_path)
    assert run_script(PACKAGES, tmp_path) == ["1", "0"]
    assert files
    assert files_in(tmp_path) == files


def test_second_process_takes_a_users_class_from_disk_and_an_edited_one_not(tmp_path):
    """The law is that of a script, so its class is another object in every process."""
    first, hits, misses = run_script(script(), tmp_path)
    assert (hits, misses) == ("0", "1")
    second, hits, misses = run_script("\n\n# moved down by three lines" + script(), tmp_path)
    assert (second, hits, misses) == (first, "1", "0")
    edited, hits, misses = run_script(script(after=" * 1.5"), tmp_path)
    assert edited != first
    assert (hits, misses) == ("0", "1")
    python, *_ = run_script(script(after=" * 1.5"), tmp_path, STRAINWAVE_JIT="0")
    assert float(edited) == pytest.approx(float(python), abs=1e-9)


def test_functions_that_kernels_call_by_address_follow_a_users_class(tmp_path):
    moving = script().replace("end_of(Tanh", "moved(Tanh")
    first, hits, misses = run_script(moving, tmp_path)
    assert (hits, int(misses) > 1) == ("0", True)
    assert run_script("\n" + moving, tmp_path) == [first, misses, "0"]
    edited, hits, again = run_script(moving.replace("(1 + e)", "(1 + e) * 1.5"), tmp_path)
    assert edited != first
    assert int(hits) > 0  # the kernel itself knows no law
    assert int(hits) + int(again) == int(misses)


def test_code_follows_the_global_variables_that_a_users_class_reads(tmp_path):
    """Numba takes a global number for a constant of the code."""
    ends = [run_script(script(f"FACTOR = {f}", " * FACTOR"), tmp_path)[0] for f in (1.0, 1.5)]
    assert ends[0] != ends[1]


def test_classes_of_one_name_from_other_processes_keep_their_own_code(tmp_path):
    """Both codes are on disk under the same names of functions, and one process loads both."""
    law = "class Law(NamedTuple):\n    K: float\n    def torque(self, x): return {} * x\nprint(end_of(Law(1.0)))\n"
    head, one, two = COUNTS + "from typing import NamedTuple\n", law.format(1.0), law.format(4.0)
    ends = [run_script(head + code, tmp_path)[0] for code in (one, two)]
    assert ends[0] != ends[1]
    assert run_script(head + one + two + "print(*counts())", tmp_path) == [*ends, "2", "0"]


def test_class_that_no_other_process_would_recognise_stays_in_memory(tmp_path):
    before = "import io\nSTREAM = io.StringIO()"
    after = "\n    def note(self):\n        STREAM.write('torque')"
    *_, hits, misses = run_script(script(before, after), tmp_path)
    assert (hits, misses) == ("0", "1")
    assert files_in(tmp_path) == set()


def test_damaged_file_is_replaced(tmp_path):
    run_script(PACKAGES, tmp_path)
    (name,) = files_in(tmp_path)
    whole = (tmp_path / name).read_bytes()
    (tmp_path / name).write_bytes(whole[: len(whole) // 2])
    assert run_script(PACKAGES, tmp_path) == ["0", "1"]
    assert len((tmp_path / name).read_bytes()) > len(whole) // 2


@pytest.mark.parametrize("seed", range(3))
def test_a_file_with_one_changed_bit_is_replaced(seed, tmp_path):
    run_script(PACKAGES, tmp_path)
    (name,) = files_in(tmp_path)
    whole = (tmp_path / name).read_bytes()
    changed, place = bytearray(whole), np.random.default_rng(seed).integers(len(whole))
    changed[place] ^= 1
    (tmp_path / name).write_bytes(changed)
    assert run_script(PACKAGES, tmp_path) == ["0", "1"]
    assert (tmp_path / name).read_bytes() != bytes(changed)


def test_without_a_folder_to_write_to_compiled_code_stays_in_memory(tmp_path):
    no_folder = tmp_path / "a file, not a folder"
    no_folder.write_text("")
    copy = tmp_path / "strainwave"
    shutil.copytree(PACKAGE, copy, ignore=shutil.ignore_patterns("__pycache__"))
    assert run_script(PACKAGES, no_folder, package=copy) == ["0", "1"]
    assert [*copy.rglob("*.nb[ci]"), *files_in(copy)] == []


def test_a_draft_that_cannot_take_its_place_is_removed(tmp_path):
    run_script(PACKAGES, tmp_path)
    (name,) = files_in(tmp_path)
    (tmp_path / name).unlink()
    (tmp_path / name).mkdir()
    assert run_script(PACKAGES, tmp_path) == ["0", "1"]
    assert not list(tmp_path.rglob("*.part"))


def test_an_edit_that_a_kernel_may_read_moves_the_folder_of_compiled_code_and_another_not(tmp_path):
    copy = tmp_path / "strainwave"
    shutil.copytree(PACKAGE, copy, ignore=shutil.ignore_patterns("__pycache__"))
    before = cache.hash_of(copy)
    first_of = {path.parent: path for path in sorted(copy.rglob("*.py"), reverse=True)}
    assert len(first_of) > 50
    for path in first_of.values():
        text = path.read_bytes()
        path.write_bytes(text + b"CONSTANT = 2.0\n")
        room = path.relative_to(copy).parts[0]
        assert (cache.hash_of(copy) == before) == (room in {"app", "archive", "files", "plot"}), path
        path.write_bytes(text)
    assert cache.hash_of(copy) == before


@pytest.mark.compiled
def test_code_of_a_class_in_a_room_that_no_key_covers_stays_in_memory(tmp_path):
    code = PACKAGES.replace(
        "import strainwave as sw", "import strainwave as sw; sw.Cubic.__module__ = 'strainwave.app.laws'"
    )
    assert code != PACKAGES
    run_script(code, tmp_path)
    assert files_in(tmp_path) == set()


def test_models_of_the_package_are_in_rooms_that_a_key_covers():
    """Else every process would compile them anew."""
    needs, outside = ({"rhs"}, {"update"}, {"value", "slope"}, {"torque", "stiffness"}), []
    for path in PACKAGE.rglob("*.py"):
        if path.relative_to(PACKAGE).parts[0] not in cache.ROOMS:
            classes = [node for node in ast.walk(ast.parse(path.read_text("utf-8"))) if isinstance(node, ast.ClassDef)]
            tuples = [one for one in classes if "NamedTuple" in map(ast.unparse, one.bases)]
            methods = [{part.name for part in one.body if isinstance(part, ast.FunctionDef)} for one in tuples]
            outside += [path.name for names in methods if any(need <= names for need in needs)]
    assert outside == []


def test_folders_that_nobody_has_used_for_a_month_are_removed(tmp_path):
    old, young = "0123456789abcdef", "fedcba9876543210"
    for name, days in ((old, 31), (young, 29), ("thesis", 31)):
        (tmp_path / name).mkdir()
        for file in ("used", "follow-1.code"):
            (tmp_path / name / file).write_text("")
        stamp = time.time() - days * cache.DAY
        os.utime(tmp_path / name / "used", (stamp, stamp))
    (tmp_path / "of somebody else").mkdir()
    code = "from strainwave.compile import cache; print(cache.cache_writable())"
    assert run_script(code, tmp_path) == ["True"]
    assert {path.name for path in tmp_path.iterdir()} == {young, "thesis", "of somebody else", cache.source_hash()}


def test_folder_of_compiled_code_is_the_users_own_unless_the_environment_says_otherwise(monkeypatch):
    monkeypatch.delenv("STRAINWAVE_CACHE_DIR", raising=False)
    folder = cache.cache_folder.__wrapped__()
    assert folder.name == cache.source_hash()
    assert Path.home() in folder.parents or "XDG_CACHE_HOME" in os.environ


@pytest.mark.skipif(sys.platform in ("win32", "darwin"), reason="these have no XDG_CACHE_HOME")
@pytest.mark.parametrize("place", ["", "relative/folder"])
def test_a_cache_folder_that_is_empty_or_relative_is_ignored(monkeypatch, tmp_path, place):
    monkeypatch.delenv("STRAINWAVE_CACHE_DIR", raising=False)
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.setenv("XDG_CACHE_HOME", place)
    assert cache.cache_folder.__wrapped__().parent == tmp_path / ".cache" / "strainwave"


def test_a_user_without_a_home_keeps_code_where_the_environment_says_or_in_memory(monkeypatch, tmp_path):
    def homeless():
        raise RuntimeError("Could not determine home directory.")

    monkeypatch.delenv("STRAINWAVE_CACHE_DIR", raising=False)
    monkeypatch.setattr(Path, "home", homeless)
    monkeypatch.setattr(sys, "platform", "linux")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert cache.cache_folder.__wrapped__().parent == tmp_path / "strainwave"
    monkeypatch.delenv("XDG_CACHE_HOME")
    nowhere = cache.cache_folder.__wrapped__()
    monkeypatch.setattr(cache, "cache_folder", lambda: nowhere)
    assert not cache.cache_writable.__wrapped__()


def test_code_of_another_version_of_the_compiler_is_not_taken(tmp_path):
    run_script(PACKAGES, tmp_path)
    other = "import numba; numba.__version__ += '.1'\n" + PACKAGES
    assert run_script(other, tmp_path) == ["0", "1"]
    assert run_script(other, tmp_path) == run_script(PACKAGES, tmp_path) == ["1", "0"]


SHIPPED = """
import sys
import strainwave as sw
from numba.core import event
from pathlib import Path
from strainwave.compile import cache
if sys.argv[1] == "none":
    cache.SHIPPED = Path("none")
with event.install_recorder("numba:compile") as recorder:
    drive = sw.read_project(sys.argv[2])
    response = drive.response()
    print(*(value.hex() for value in (*response.omega, *response.oscillation)))
print(len([1 for _, one in recorder.buffer if one.is_start]))
"""


@pytest.mark.skipif((sys.platform, platform.machine()) != ("linux", "x86_64"), reason="kernels for another machine")
def test_kernels_that_the_package_brings_give_the_bits_of_those_compiled_here(tmp_path):
    """A cascade's curve with an empty folder of code, from the package's LLVM code and without it."""
    path = tmp_path / "drive.yaml"
    path.write_text((PACKAGE.parents[1] / "benchmarks" / "readme_drive.yaml").read_text(encoding="utf-8"))
    printed = {}
    for brings in ("all", "none"):
        folder = {"STRAINWAVE_CACHE_DIR": str(tmp_path / brings), "STRAINWAVE_JIT": "1"}
        command = [sys.executable, "-c", SHIPPED, brings, str(path)]
        done = subprocess.run(command, env=os.environ | folder, capture_output=True, text=True, check=True)
        *lines, compiled = done.stdout.splitlines()
        printed[brings] = lines, int(compiled)
    assert printed["all"][0] == printed["none"][0]
    assert printed["all"][1] < printed["none"][1] / 10


def test_kernels_of_other_sources_or_a_damaged_file_are_not_taken(tmp_path, monkeypatch):
    triple = "x86_64-unknown-linux-gnu"
    assert len(cache.shipped.__wrapped__(triple)) > 50
    assert cache.shipped.__wrapped__("arm64-apple-darwin") == {}
    first, content = cache.SHIPPED.read_bytes().split(b"\n", 1)
    monkeypatch.setattr(cache, "SHIPPED", tmp_path / "kernels.xz")
    assert cache.shipped.__wrapped__(triple) == {}
    for wrong in (b"x" + first + b"\n" + content, first + b"\n" + content[:-100], first + b"\n", b"\xff\n"):
        cache.SHIPPED.write_bytes(wrong)
        assert cache.shipped.__wrapped__(triple) == {}
