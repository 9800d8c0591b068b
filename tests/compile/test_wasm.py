"""Kernels and laws as WebAssembly: what Numba gives, and modules that compute in node what Python does."""

import base64
import json
import os
import shutil
import subprocess

import numba
import numpy as np
import pytest
from test_extension import Dogleg, Relaxing

import strainwave as sw
from strainwave.compile import wasm
from strainwave.compile.address import VECTOR, words_of
from strainwave.compile.wasm import TRIED, Wanted, beside, compiled
from strainwave.numerics.addressed import _breakpoints, _stiffnesses, _torques

TWO = VECTOR, VECTOR
PAGE = """
const memory = new WebAssembly.Memory({ initial: 64 }), start = 2 ** 20;
const __indirect_function_table = new WebAssembly.Table({ element: "anyfunc", initial: 8 });
const __stack_pointer = new WebAssembly.Global({ value: "i32", mutable: true }, start);
const env = { __linear_memory: memory, __indirect_function_table, __stack_pointer, NRT_MemInfo_call_dtor() {} };
const { torques } = new WebAssembly.Instance(new WebAssembly.Module(Buffer.from(CODE, "base64")), { env }).exports;
new BigInt64Array(memory.buffer, start, WORDS.length).set(WORDS.map(BigInt));
const u = new Float64Array(memory.buffer, start + 1024, TWISTS.length), n = BigInt(u.length);
u.set(TWISTS);
const array = (place) => [0, 0, n, 8n, place, n, 8n];
const code = torques(start + 8192, start + 8200, start, ...array(start + 1024), ...array(start + 4096));
console.log(JSON.stringify([code, ...new Float64Array(memory.buffer, start + 4096, u.length)]));
"""


def of_law(law):
    return compiled(Wanted("torques", _torques, (law,), TWO), Wanted("stiffnesses", _stiffnesses, (law,), TWO))


def test_numba_gives_code_and_arguments_as_in_the_versions_tried():
    law = Dogleg(100.0, 50.0, 0.2)
    made = compiled(Wanted("torques", _torques, (law,), TWO), Wanted("breakpoints", _breakpoints, (law,), (2,)))
    assert made.code[:4] == b"\0asm"
    assert made.arguments == {"torques": ["address", "array1", "array1"], "breakpoints": ["address", "address"]}
    assert {"strainwave.numerics.addressed:_torques", "strainwave.numerics.addressed:_breakpoints"} <= {*made.sources}

    version = tuple(map(int, numba.__version__.split(".")[:2]))
    if version > TRIED[1]:
        pytest.xfail(f"Numba {numba.__version__} gives them, and TRIED ends before it")
    assert version >= TRIED[0]


@pytest.mark.parametrize(
    ("child", "words"),
    [
        ("import os; os.kill(os.getpid(), 9)", "the compiler ended with -9"),
        ("import sys; sys.exit('no room')", "^no room$"),
    ],
)
@pytest.mark.skipif(os.name == "nt", reason="no signal 9 there")
def test_a_compiler_that_ends_by_itself_is_told(child, words, monkeypatch):
    monkeypatch.setattr(wasm, "CHILD", child)
    with pytest.raises(TypeError, match=words):
        compiled()


def test_a_law_that_cannot_be_compiled_is_refused_by_its_name():
    with pytest.raises(TypeError, match=r"^Relaxing cannot be compiled: .*; write its methods with arithmetic"):
        of_law(Relaxing(1.0, 1.0, 1.0))  # its torque is one of three numbers


@pytest.mark.skipif(shutil.which("node") is None, reason="node is not installed")
@pytest.mark.parametrize(
    "law",
    [Dogleg(100.0, 50.0, 0.2), sw.Cubic(3.0, 0.7), sw.Polynomial((0.1, 2.0, 0.0, 0.4))],
    ids=lambda law: type(law).__name__,
)
def test_a_law_in_a_browser_has_the_torques_of_python(law):
    twists = np.linspace(-1.0, 1.0, 41)
    values = {"CODE": "", "WORDS": [str(word) for word in words_of(law)], "TWISTS": twists.tolist()}
    values["CODE"] = base64.b64encode(beside(of_law(law).code)).decode()
    script = "".join(f"const {name} = {json.dumps(value)};\n" for name, value in values.items()) + PAGE
    done = subprocess.run(["node", "-e", script], capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    code, *torques = json.loads(done.stdout)
    assert code == 0
    np.testing.assert_allclose(torques, law.torque(twists), rtol=1e-14, atol=1e-15)
