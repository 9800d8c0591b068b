"""Compiled code: a user's classes, the folder of compiled code, and what is said when something cannot be compiled."""

import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

import pytest
from scipy.special import erf

import strainwave
import strainwave as sw
from strainwave import _dispatch, _jit

PACKAGE = Path(strainwave.__file__).parent

USERS_SCRIPT = """
from typing import NamedTuple
import strainwave as sw
from strainwave.maths import exp

class Tanh(NamedTuple):
    K: float
    s: float
    def torque(self, x):
        e = exp(-2 * x / self.s)
        return self.K * self.s * (1 - e) / (1 + e)

system = sw.Oscillator(1, 0.05, Tanh(1, 0.5), sw.Harmonic(0.18), 0.7)
print(float(sw.simulate(system, (0.3, 0), 20, method=sw.Dopri5(rtol=1e-8)).y[0, -1]))
"""

PACKAGE_SCRIPT = """
import strainwave as sw
from strainwave import _jit

def hits(function):
    return sum(_jit._dispatcher(function, True).stats.cache_hits.values())

def misses(function):
    return sum(_jit._dispatcher(function, True).stats.cache_misses.values())

from strainwave.numerics.integrate import fixed
system = sw.Oscillator(1, 0.05, sw.Cubic(1, 0.1), sw.Harmonic(0.18), 1)
sw.simulate(system, (0, 0), 1, method=sw.Rk4(steps_per_period=64))
system = sw.Oscillator(1.0, 0.05, sw.Cubic(1.0, 0.1), sw.Harmonic(0.18), 1.0)
sw.simulate(system, (0, 0), 1, method=sw.Rk4(steps_per_period=64))
print(hits(fixed), misses(fixed))
"""


def run_script(code, folder, package=PACKAGE, **environment):
    """Run code in a new process with its own folder of compiled code; its output, and the files in that folder."""
    env = os.environ | {"STRAINWAVE_CACHE_DIR": str(folder), "PYTHONPATH": str(package.parent)} | environment
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False, env=env)
    assert run.returncode == 0, run.stderr
    assert run.stderr == ""
    return run.stdout.strip(), files_in(folder)


def files_in(folder):
    if not folder.is_dir():
        return set()
    return {str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file()}


@pytest.mark.compiled
def test_users_law_of_ten_lines_runs_compiled_and_as_python_and_leaves_no_file(tmp_path):
    compiled, files = run_script(USERS_SCRIPT, tmp_path)
    python, _ = run_script(USERS_SCRIPT, tmp_path, STRAINWAVE_JIT="0")
    assert float(compiled) == pytest.approx(float(python), abs=1e-9)
    assert files == set()


@pytest.mark.compiled
def test_second_process_takes_the_package_classes_from_disk_and_int_and_float_parameters_share_them(tmp_path):
    first, files = run_script(PACKAGE_SCRIPT, tmp_path)
    second, files_after = run_script(PACKAGE_SCRIPT, tmp_path)
    assert first == "0 1"
    assert second == "1 0"
    assert files
    assert files_after == files


@pytest.mark.compiled
def test_without_a_folder_to_write_to_compiled_code_stays_in_memory(tmp_path):
    no_folder = tmp_path / "a file, not a folder"
    no_folder.write_text("")
    copy = tmp_path / "strainwave"
    shutil.copytree(PACKAGE, copy, ignore=shutil.ignore_patterns("__pycache__"))
    output, _ = run_script(PACKAGE_SCRIPT, no_folder, package=copy)
    assert output == "0 1"
    assert [path for path in copy.rglob("*.nb[ci]") if path.is_file()] == []


def test_edit_of_a_source_moves_the_folder_of_compiled_code(tmp_path):
    copy = tmp_path / "strainwave"
    shutil.copytree(PACKAGE, copy, ignore=shutil.ignore_patterns("__pycache__"))
    code = "from strainwave import _jit; print(_jit.cache_folder())"
    before, _ = run_script(code, tmp_path / "cache", package=copy)
    same, _ = run_script(code, tmp_path / "cache", package=copy)
    with open(copy / "model" / "laws.py", "a", encoding="utf-8") as stream:
        stream.write("# edited\n")
    after, _ = run_script(code, tmp_path / "cache", package=copy)
    assert before == same == str(tmp_path / "cache" / Path(before).name)
    assert after != before


def test_folder_of_compiled_code_is_the_users_own_unless_the_environment_says_otherwise(monkeypatch):
    monkeypatch.delenv("STRAINWAVE_CACHE_DIR", raising=False)
    folder = _jit.cache_folder.__wrapped__()
    assert folder.name == _jit.source_hash()
    assert Path.home() in folder.parents or "XDG_CACHE_HOME" in os.environ


class Tabulated(NamedTuple):
    """A law that Python runs and a compiler cannot: it imports a library inside a method."""

    K: float

    def torque(self, x):
        import numpy.polynomial

        return self.K * numpy.polynomial.Polynomial((0.0, 1.0))(x)


@pytest.mark.compiled
def test_law_that_cannot_be_compiled_is_said_in_one_sentence():
    system = sw.Oscillator(1.0, 0.1, Tabulated(1.0), sw.Harmonic(0.1), 1.0)
    with pytest.raises(TypeError, match=r"^Tabulated cannot be compiled: [^\n]*; write its methods[^\n]*$"):
        sw.simulate(system, (0.0, 0.0), 1.0)


class Special(NamedTuple):
    """A law that calls a function which the compiler does not know."""

    K: float

    def torque(self, x):
        return self.K * erf(x)


@pytest.mark.compiled
def test_what_cannot_be_compiled_is_named_as_the_user_wrote_it():
    system = sw.Oscillator(1.0, 0.1, Special(1.0), sw.Harmonic(0.1), 1.0)
    with pytest.raises(TypeError, match=r"^Special cannot be compiled: Untyped global name 'erf'"):
        sw.simulate(system, (0.0, 0.0), 1.0)


def test_law_that_cannot_be_compiled_runs_as_python(monkeypatch):
    monkeypatch.setenv("STRAINWAVE_JIT", "0")
    system = sw.Oscillator(1.0, 0.1, Tabulated(1.0), sw.Harmonic(0.1), 1.0)
    same = sw.Oscillator(1.0, 0.1, sw.Linear(1.0), sw.Harmonic(0.1), 1.0)
    assert sw.simulate(system, (0, 0), 1.0).y == pytest.approx(sw.simulate(same, (0, 0), 1.0).y, abs=1e-15)


def test_axpy_works_on_tuples():
    assert _jit.axpy((1.0, 2.0), 0.5, (4.0, -2.0)) == (3.0, 1.0)
    with pytest.raises(ValueError, match="zip"):
        _jit.axpy((1.0, 2.0, 3.0), 0.5, (4.0, 5.0))


def test_torsion_is_the_first_state_where_the_system_defines_none():
    class Free(NamedTuple):
        def rhs(self, phase, y):
            return (0.0 * phase, *y[:1])

    assert _dispatch.torsion(Free(), 0.0, (3.0, 4.0)) == 3.0


@pytest.mark.compiled
def test_kernels_of_a_module_that_is_imported_later_are_known_to_code_made_before():
    """A law of another module, first used after the same verb has compiled without it."""
    program = (
        "import strainwave as sw\n"
        "system = sw.Oscillator(1.0, 0.1, sw.Linear(1.0), sw.Harmonic(0.3), 1.0)\n"
        "assert sw.simulate(system, (0.0, 0.0), 1.0).status\n"
        "system = system._replace(law=sw.BoucWen(1.0, 0.4, 0.3))\n"
        "assert sw.simulate(system, (0.0, 0.0, 0.0), 1.0).status\n"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[-500:]
