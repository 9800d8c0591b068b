"""The folder of compiled code: what a later process takes from it, and what it must not."""

import lzma
import os
import pickle
import shutil
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

import strainwave as sw
from strainwave.compile import cache, cache_key

pytestmark = pytest.mark.slow

PACKAGE = Path(sw.__file__).parent

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

made_before = jit._new_dispatcher
dispatchers = set()

def made_and_kept(*args):
    dispatchers.add(made_before(*args))
    return made_before(*args)

jit._new_dispatcher = made_and_kept

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


@pytest.mark.skipif(sys.platform == "win32", reason="a C library has another name there")
def test_class_that_no_other_process_would_recognise_stays_in_memory(tmp_path):
    before = (
        "import ctypes\nCOS = ctypes.CDLL(None).cos\nCOS.restype, COS.argtypes = ctypes.c_double, [ctypes.c_double]"
    )
    after = " * COS(x)"
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


KEYS = """
import importlib, sys
from strainwave.compile import cache_key
import strainwave as sw
for name in sys.argv[1:]:
    module, path = name.split(":")
    thing = importlib.import_module("strainwave." + module)
    for part in path.split("."):
        thing = getattr(thing, part)
    print(cache_key.key(thing, (sw.Cubic,)))
"""
KERNELS = ("numerics.continuation.arc_length:follow", "numerics.addressed:_torques", "base.series:highest_in")


def keys(package):
    """Keys of some kernels of a copy of the package, for the law Cubic."""
    # Bytecode that Python kept is taken for that of a file of the same size and second.
    own = {"PYTHONPATH": str(package.parent), "PYTHONDONTWRITEBYTECODE": "1"}
    command, env = [sys.executable, "-c", KEYS, *KERNELS], os.environ | own
    return subprocess.run(command, capture_output=True, text=True, check=True, env=env).stdout.split()


def test_key_changes_with_what_the_kernel_reads_and_with_nothing_else(tmp_path):
    copy = tmp_path / "strainwave"
    shutil.copytree(PACKAGE, copy, ignore=shutil.ignore_patterns("__pycache__"))
    before = keys(copy)
    edits = [
        ("model/laws/springs.py", "return self.K * (x + self.alpha * x * x * x)", "return self.K * x", {1}),
        ("model/laws/springs.py", "return self.K * xx * (0.5", "return self.K * xx * (0.6", set()),
        ("model/laws/springs.py", '"""Hardening', '"""Any text. Hardening', set()),
        ("numerics/continuation/arc_length.py", "import numpy as np\n", "import numpy as np\n\n# moved\n", set()),
        ("numerics/continuation/arc_length.py", "= -0.5, 1.5, 5e-10", "= -0.5, 1.5, 6e-10", {0}),
        ("compile/tree.py", "LONGEST_VALUE = 60", "LONGEST_VALUE = 61", set()),  # it is in the name of the folder
    ]
    for file, old, new, changed in edits:
        text = (copy / file).read_text(encoding="utf-8")
        assert old in text, (file, old)
        (copy / file).write_text(text.replace(old, new), encoding="utf-8")
        assert {i for i, (a, b) in enumerate(zip(before, keys(copy), strict=True)) if a != b} == changed, (file, new)
        (copy / file).write_text(text, encoding="utf-8")


def test_key_changes_with_defaults_and_closed_over_values_at_any_depth():
    def kernel_of(table, step=0.5):
        def inner(x, h=step):
            return table[1][0] * x + h

        def outer(x):
            return inner(x)

        return outer

    texts = [
        cache_key.key(kernel_of(*given), ()) for given in (((1.0, (2.0,)),), ((1.0, (2.5,)),), ((1.0, (2.0,)), 0.25))
    ]
    assert len(set(texts)) == 3
    assert cache_key.key(kernel_of((1.0, (2.0,))), ()) == texts[0]


TOGETHER = """
from strainwave.compile import cache
keep, kept = cache.write, []
cache.write = lambda *given: kept.append(given) or keep(*given)
"""


@pytest.mark.skipif(sys.platform == "win32", reason="no locks of files there: both compile")
def test_two_processes_that_begin_together_compile_a_kernel_once(tmp_path):
    code = TOGETHER + PACKAGES + "\nprint(end_of(sw.Cubic(1.0, 0.1)), len(kept))"
    env = os.environ | {"STRAINWAVE_CACHE_DIR": str(tmp_path), "STRAINWAVE_JIT": "1"}
    both = [subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True, env=env) for _ in "12"]
    (*_, first, one), (*_, second, other) = [process.communicate()[0].split() for process in both]
    assert float(first) == float(second) == pytest.approx(sw.Cubic(1.0, 0.1).torque(0.3), rel=1e-15)
    assert int(one) + int(other) == 1


def test_code_that_nobody_has_used_for_a_month_is_removed(tmp_path):
    """That of an older version of the package is in a folder of another name."""
    old, mixed = "0123456789abcdef", "fedcba9876543210"
    ages = {old: {"used": 31, "follow-1.code": 31}, mixed: {"used": 29, "follow-1.code": 31, "follow-2.code": 29}}
    for name, files in (ages | {"thesis": {"used": 31}}).items():
        (tmp_path / name).mkdir()
        for file, days in files.items():
            (tmp_path / name / file).write_text("")
            stamp = time.time() - days * cache.DAY
            os.utime(tmp_path / name / file, (stamp, stamp))
    code = "from strainwave.compile import cache; print(cache.cache_writable())"
    assert run_script(code, tmp_path) == ["True"]
    assert {path.name for path in tmp_path.iterdir()} == {mixed, "thesis", cache_key.folder_hash()}
    assert files_in(tmp_path) == {f"{mixed}/follow-2.code"}


def test_folder_of_compiled_code_is_the_users_own_unless_the_environment_says_otherwise(monkeypatch):
    monkeypatch.delenv("STRAINWAVE_CACHE_DIR", raising=False)
    folder = cache.cache_folder.__wrapped__()
    assert folder.name == cache_key.folder_hash()
    assert Path.home() in folder.parents or "XDG_CACHE_HOME" in os.environ


@pytest.mark.skipif(sys.platform == "win32", reason="a user of Windows has a folder of his own")
def test_a_user_without_a_home_keeps_code_where_the_environment_says_or_in_memory(monkeypatch, tmp_path):
    def homeless(uid):
        raise KeyError(uid)

    monkeypatch.delenv("STRAINWAVE_CACHE_DIR", raising=False)
    monkeypatch.delenv("HOME")
    monkeypatch.setattr("pwd.getpwuid", homeless)
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


def test_code_that_a_wheel_brings_for_other_libraries_or_that_is_damaged_is_not_taken(tmp_path, monkeypatch):
    triple = "x86_64-unknown-linux-gnu"
    monkeypatch.setattr(cache, "SHIPPED", tmp_path / "kernels.xz")
    assert cache.shipped.__wrapped__(triple) == {}
    first, content = cache.stamp(triple).encode(), lzma.compress(pickle.dumps({"a": b"code"}))
    cache.SHIPPED.write_bytes(first + b"\n" + content)
    assert cache.shipped.__wrapped__(triple) == {"a": b"code"}
    assert cache.shipped.__wrapped__("arm64-apple-darwin") == {}
    for wrong in (b"x" + first + b"\n" + content, first + b"\n" + content[:-10], first + b"\n", b"\xff\n"):
        cache.SHIPPED.write_bytes(wrong)
        assert cache.shipped.__wrapped__(triple) == {}
