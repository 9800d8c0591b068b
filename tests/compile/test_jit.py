"""Compiled code: a user's classes, and what is said when something cannot be compiled."""

import os
import subprocess
import sys
from typing import NamedTuple

import pytest

import strainwave as sw
from strainwave.base.law import torsion

pytestmark = pytest.mark.slow


class Tabulated(NamedTuple):
    """A law that Python runs and a compiler cannot: it imports a library inside a method."""

    K: float

    def torque(self, x):
        import numpy.polynomial

        return self.K * numpy.polynomial.Polynomial((0.0, 1.0))(x)


def test_law_that_cannot_be_compiled_is_said_in_one_sentence():
    system = sw.Oscillator(1.0, 0.1, Tabulated(1.0), sw.Harmonic(0.1), 1.0)
    with pytest.raises(TypeError, match=r"^Tabulated cannot be compiled: [^\n]*; write its methods[^\n]*$"):
        sw.simulate(system, (0.0, 0.0), 1.0)


def law_with(factor):
    class Cubic(NamedTuple):
        """A law with the name and the fields of one of the package."""

        K: float
        alpha: float

        def torque(self, x):
            return factor * self.K * x

    return Cubic(1.0, 0.1)


def test_classes_of_one_name_have_code_of_their_own():
    """As in a notebook, where a cell with an edited law is run again."""

    def end_of(law):
        system = sw.Oscillator(1.0, 0.05, law, sw.Harmonic(0.18), 0.7)
        return sw.simulate(system, (0.3, 0.0), 20.0, method=sw.Rk4(steps_per_period=64)).y[0, -1]

    laws = sw.Cubic(1.0, 0.1), law_with(1.0), law_with(4.0), sw.Linear(1.0), sw.Linear(4.0)
    package, first, second, soft, stiff = map(end_of, laws)
    assert first == pytest.approx(soft, abs=1e-12)
    assert second == pytest.approx(stiff, abs=1e-12)
    assert package != pytest.approx(soft, abs=1e-3)


def test_law_that_cannot_be_compiled_runs_as_python(monkeypatch):
    monkeypatch.setenv("STRAINWAVE_JIT", "0")
    system = sw.Oscillator(1.0, 0.1, Tabulated(1.0), sw.Harmonic(0.1), 1.0)
    same = sw.Oscillator(1.0, 0.1, sw.Linear(1.0), sw.Harmonic(0.1), 1.0)
    assert sw.simulate(system, (0, 0), 1.0).y == pytest.approx(sw.simulate(same, (0, 0), 1.0).y, abs=1e-15)


def test_torsion_is_the_first_state_where_the_system_defines_none():
    class Free(NamedTuple):
        def rhs(self, phase, y):
            return (0.0 * phase, *y[:1])

    assert torsion(Free(), 0.0, (3.0, 4.0)) == 3.0


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


@pytest.mark.parametrize("said", ["'torsion', x", "x"])
def test_law_that_prints_does_so_in_code_made_now_and_in_code_from_disk(tmp_path, said):
    """What a function inside a kernel has of Python is given to the kernel, with and without a text that it prints."""
    law = tmp_path / "loud.py"
    law.write_text(
        "from typing import NamedTuple\n"
        "import strainwave as sw\n"
        "class Loud(NamedTuple):\n"
        "    K: float\n"
        "    def torque(self, x):\n"
        "        if x > 0.5:\n"
        f"            print({said})\n"
        "        return self.K * x\n"
        "system = sw.Oscillator(1.0, 0.1, Loud(1.0), sw.Harmonic(0.1), 1.0)\n"
        "assert sw.simulate(system, (1.0, 0.0), 1e-3, method=sw.Rk4(steps_per_period=4)).status\n"
    )
    for _ in range(2):
        env = os.environ | {"STRAINWAVE_CACHE_DIR": str(tmp_path)}
        done = subprocess.run(
            [sys.executable, law], capture_output=True, text=True, check=False, env=env, cwd=tmp_path, timeout=300
        )
        assert done.returncode == 0, done.stderr[-500:]
        assert done.stdout.count("1.0\n") > 1
        assert not done.stderr


def test_threads_may_ask_for_their_first_kernels_at_once():
    # numba is set up once: with imports that take a moment, threads that come at once would do it side by side
    code = (
        "import time, threading; from strainwave.compile import jit, numba_import; from strainwave.maths import cos\n"
        "load, failed = jit.import_module, []\n"
        "def slowly(name): time.sleep(0.02); return load(name)\n"
        "jit.import_module = numba_import.import_module = slowly\n"
        "def ask():\n"
        "    try: numba_import.numba_module(), jit.expose(), jit.dispatcher_of(cos, ())\n"
        "    except Exception as error: failed.append(error)\n"
        "threads = [threading.Thread(target=ask) for _ in range(4)]\n"
        "[t.start() for t in threads]; [t.join() for t in threads]\n"
        "assert not failed, failed\n"
    )
    subprocess.run([sys.executable, "-c", code], check=True)
