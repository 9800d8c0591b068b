"""Identities of measures: what computes the same is recognised in another process, what does not is not confused."""

import functools
import math
import os
import subprocess
import sys
import threading
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import numpy as np
import pytest
import zarr

import strainwave as sw
from strainwave.base.quantities import checked
from strainwave.sample.identity import digest, identity, installed

pytestmark = pytest.mark.slow

SYSTEM = sw.Oscillator(1.0, 0.1, sw.Cubic(1.0, 0.1), sw.Harmonic(1.0), 1.0)
ALPHA = np.array([0.5, 1.0, 2.0])
GRID = {"law.alpha": ALPHA, "omega": np.linspace(1.0, 2.0, 20)}


def product(system):
    return system.law.alpha * system.omega


def noise(system, rng):
    return system.omega + rng.normal()


@dataclass(frozen=True)
class Fields:
    bad: tuple[float, ...] = ()

    def __call__(self, system):
        return len(self.bad)


def test_same_things_have_the_same_identity_and_others_another():
    assert digest(product, SYSTEM, GRID) == digest(product, SYSTEM, dict(GRID))
    things = [
        1,
        1.0,
        True,
        "1",
        None,
        1j,
        ALPHA,
        ALPHA.astype("f4"),
        SYSTEM,
        SYSTEM.law,
        (1.0,),
        [1.0, 2.0],
        product,
        noise,
        partial(noise, rng=1),
        partial(noise, rng=2),
        Fields(),
        Fields((1.0,)),
        sw.Rk4(steps=30),
        np.sin,
        math.sin,
        sw.sample.Sobol(8, {"J": sw.Uniform(0.0, 1.0)}),
        sw.sample.Sobol(8, {"J": sw.sample.LogUniform(0.5, 1.0)}),
        Fields,
        int,
    ]
    assert len({identity(thing) for thing in things}) == len(things)


K = 2.0
twice, thrice = lambda system: 2.0 * system.J, lambda system: 3.0 * system.J


def made(text, **known):
    """The function f of a text, which has no source to read."""
    exec(text, known)
    return known["f"]


def closing(factor):
    return lambda system: factor * system.J


def uses_global(system):
    return K * system.J


class Gain:
    least = 1.0

    def __init__(self, factor):
        self.factor = factor

    def __call__(self, system):
        return max(self.factor, self.least) * system.J


class Own(NamedTuple):
    K: float

    def torque(self, x):
        return self.K * x


PAIRS = {
    "lambdas on one line": (twice, thrice),
    "constants without source": (made("def f(s): return 2.5 * s.J"), made("def f(s): return 2.6 * s.J")),
    "signs of zero": (made("def f(s): return 0.0 * s.J"), made("def f(s): return -0.0 * s.J")),
    "constants of inner functions": tuple(
        made(f"def f(s):\n def g(x): return {k} * x\n return g(s.J)") for k in (1, 2)
    ),
    "attributes": (made("def f(s): return s.J"), made("def f(s): return s.B")),
    "defaults": (made("def f(s, a=1): return a * s.J"), made("def f(s, a=2): return a * s.J")),
    "defaults by name": (made("def f(s, *, a=1): return a * s.J"), made("def f(s, *, a=2): return a * s.J")),
    "globals": (made("def f(s): return a * s.J", a=1), made("def f(s): return a * s.J", a=2)),
    "globals of inner functions": tuple(made("def f(s): return [a for _ in 'b'][0]", a=a) for a in (1, 2)),
    "functions that are called": tuple(made("def f(s): return g(s)", g=g) for g in (twice, thrice)),
    "closures": (closing(2.0), closing(3.0)),
    "sets closed over": (closing({"a", "b"}), closing({"a", "c"})),
    "partials of functions": (partial(twice, 1), partial(thrice, 1)),
    "methods of objects": (Gain(2.0).__call__, Gain(3.0).__call__),
    "objects with fields": (Gain(2.0), Gain(3.0)),
    "classes without source": tuple(type("C", (), {"f": made(f"def f(self): return {k}")})() for k in (1, 2)),
    "methods written in C": ({"a": 1}.get, {"a": 2}.get),
    "model classes": (Own(1.0), sw.Linear(1.0)),
    "remembered functions": (functools.cache(twice), functools.cache(thrice)),
    "masks": (np.ma.masked_array([1.0, 2.0], [0, 1]), np.ma.masked_array([1.0, 2.0], [0, 0])),
    "numbers of other kinds": (np.float32(1.0), 1.0),
}


@pytest.mark.parametrize("name", PAIRS)
def test_what_computes_something_else_has_another_identity(name):
    first, second = PAIRS[name]
    assert identity(first) != identity(second)


def test_a_function_that_changes_has_another_identity(monkeypatch):
    before = identity(uses_global), identity(Gain(2.0)), identity(Own(1.0))
    assert before == (identity(uses_global), identity(Gain(2.0)), identity(Own(1.0)))
    monkeypatch.setattr(sys.modules[__name__], "K", 3.0)
    monkeypatch.setattr(Gain, "least", 1.5)
    monkeypatch.setattr(Own, "torque", lambda self, x: 2.0 * self.K * x)
    after = identity(uses_global), identity(Gain(2.0)), identity(Own(1.0))
    assert all(old != new for old, new in zip(before, after, strict=True))


class Scaled(NamedTuple):
    stiffness_of: float

    def torque(self, x):
        return K * self.stiffness_of * x


def test_a_law_whose_global_number_changes_is_refused_where_machine_code_has_the_old_one(monkeypatch):
    system = sw.Oscillator(1.0, 0.1, Scaled(2.0), sw.Harmonic(1.0), 1.0)
    with monkeypatch.context() as changed:
        changed.setenv("STRAINWAVE_JIT", "1")
        assert checked(checked(system)) == system
        changed.setattr(sys.modules[__name__], "K", 3.0)
        with pytest.raises(ValueError, match="Scaled or a value that it reads has changed since its first use"):
            checked(system)
        changed.setenv("STRAINWAVE_JIT", "0")
        assert checked(system) == system  # Python takes the number of now
    monkeypatch.setenv("STRAINWAVE_JIT", "1")
    assert checked(system) == system


MEASURES = """
import helper
from helper import shifted
NAMES = frozenset({"alpha", "beta", "gamma", "delta"})
def even(n): return n == 0 or odd(n - 1)
def odd(n): return n != 0 and even(n - 1)
def measure(system, names={"law", "omega", "J", "B"}):
    from helper import K
    return K * shifted(system.J) * helper.K * even(4) * (str(system) in {"a", "b", "cc"}) * len(NAMES & names)
"""
HELPER = "K = %s\ndef shifted(x): return x + %s\n"
ASK = "import m; from strainwave.sample.identity import digest; print(digest(m.measure))"


def test_a_new_process_recognises_a_function_and_sees_what_its_helpers_changed(tmp_path):
    def asked(seed, k, shift):
        (tmp_path / "helper.py").write_text(HELPER % (k, shift))
        places = os.pathsep.join([str(tmp_path), *sys.path])
        known = os.environ | {"PYTHONHASHSEED": seed, "PYTHONPATH": places, "PYTHONDONTWRITEBYTECODE": "1"}
        return subprocess.run([sys.executable, "-c", ASK], env=known, capture_output=True, text=True, check=True).stdout

    (tmp_path / "m.py").write_text(MEASURES)
    first = asked("1", 2.0, 1.0)
    assert asked("2", "1.0 + 1.0  # written in another way, and further\n", 1.0) == first
    assert len({first, asked("3", 2.5, 1.0), asked("4", 2.0, 1.5)}) == 3


LAW = """
from typing import NamedTuple

GAIN = {}

def raised(x): return GAIN * x

class Gained(NamedTuple):
    K: float
    def torque(self, x): return self.K * raised(x)
    def stiffness(self, x): return GAIN * self.K + 0.0 * x
"""
SWEPT = """
import sys
import laws
import strainwave as sw
from strainwave.compile.cache_key import key

def kernel(law, x): return law.torque(x)
def measure(system): return system.law.torque(1.0)

print(key(kernel, (laws.Gained,)))
system = sw.Oscillator(1.0, 0.1, laws.Gained(2.0), sw.Harmonic(1.0), 1.0)
try:
    print(sw.sweep(measure, system, {"J": [1.0, 2.0]}, store=sys.argv[1])["value"].values.tolist())
except ValueError as error:
    print(error)
"""


def test_a_changed_number_in_the_file_of_a_law_is_noticed_by_a_store_and_by_machine_code(tmp_path):
    def asked(law):
        (tmp_path / "laws.py").write_text(law)
        places = os.pathsep.join([str(tmp_path), *sys.path])
        known = os.environ | {"PYTHONPATH": places, "PYTHONDONTWRITEBYTECODE": "1", "STRAINWAVE_JIT": "0"}
        command = [sys.executable, "-c", SWEPT, str(tmp_path / "s")]
        return subprocess.run(command, env=known, capture_output=True, text=True, check=True).stdout.splitlines()

    code, values = asked(LAW.format(2))
    assert values == "[4.0, 4.0]"
    assert asked("# a comment\n" + LAW.format(2)) == [code, values]
    other, refusal = asked(LAW.format(3))
    assert other != code
    assert "holds another sweep (measure over J" in refusal


def test_a_store_is_not_handed_back_for_another_lambda_of_the_same_line(tmp_path):
    assert sw.sweep(twice, SYSTEM, GRID, store=tmp_path / "s")["value"].sum() == 120.0
    with pytest.raises(ValueError, match="holds another sweep"):
        sw.sweep(thrice, SYSTEM, GRID, store=tmp_path / "s")


def test_what_has_no_bytecode_of_its_own_is_recognised_in_every_python():
    assert installed(sw.EnsembleMeasure((0.0, 0.0), 10), SYSTEM, GRID) == []
    versions = installed(partial(np.interp, xp=(0.0, 1.0)), twice)
    assert versions == ["Python {}.{}".format(*sys.version_info), f"numpy {np.__version__}"]


def test_a_sweep_begun_with_another_python_is_told(tmp_path):
    sw.sweep(twice, SYSTEM, GRID, store=tmp_path / "s")
    group = zarr.open_group(tmp_path / "s")
    assert group.attrs["installed"] == ["Python {}.{}".format(*sys.version_info)]
    group.attrs.update({"installed": ["Python 3.10"], "spec": "0" * 64})
    with pytest.raises(ValueError, match=r"begun with Python 3.10, this is Python 3.*with different functions"):
        sw.sweep(twice, SYSTEM, GRID, store=tmp_path / "s")


@pytest.mark.parametrize(
    ("held", "words"),
    [
        (object(), "closed-over variable 'factor' of closing.<locals>.<lambda> holds <object"),
        (sys.stderr, "closed-over variable 'factor' of .* holds .*; that cannot be recognised in the next run"),
        (threading.Lock(), "holds <unlocked"),
        (iter([1.0]), "holds <list_iterator"),
        (np.frompyfunc(twice, 1, 1), "holds <ufunc '<lambda> "),
    ],
)
def test_what_cannot_be_known_again_cannot_be_resumed(tmp_path, held, words):
    with pytest.raises(TypeError, match=words + ".* cannot be resumed"):
        sw.sweep(closing(held), SYSTEM, GRID, store=tmp_path / "s")
    assert sw.sweep(lambda system: bool(held) * system.J, SYSTEM, GRID)["value"].sum() == 60.0
