"""Ensembles on a graphics processor, checked without one: what it would run gives the processor's answer.

The kernels are run in Numba's simulator of a device, and once more from the code made for a device, in its LLVM form.
Their PTX is read. benchmarks/gpu.py does the rest where there is a device.
"""

import json
import os
import re
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest
from canonical import DISSIPATIVE, SYSTEMS

import strainwave as sw

TESTS = Path(__file__).resolve().parents[2]
FEW = {"omega": np.array([0.8, 1.0, 1.2, 0.9, 0.7])}
MEASURES = (
    sw.Peak(),
    sw.numerics.Extremes(),
    sw.Rms(),
    sw.numerics.Mean(),
    sw.Amplitude(1),
    sw.Final(),
    sw.numerics.Poincare(),
)
SOFT = sw.Oscillator(1.0, 0.1, sw.Cubic(1.0, -1.0), sw.Harmonic(0.1), 1.0)
FORCED = sw.KinematicError((sw.Line(2, 0.02, 0.7),))
CASES = {
    "Rk4, four lanes of a thread": (SYSTEMS["Duffing"], sw.Rk4(steps_per_period=32), (sw.Peak(), sw.Rms())),
    "Rk4, memory": (SOFT._replace(law=DISSIPATIVE["BoucWen"]), sw.Rk4(steps_per_period=32), MEASURES),
    "Dop8, steps chosen, one lane lost": (SOFT._replace(error=FORCED), None, MEASURES),
    "Dopri5": (SYSTEMS["Duffing"], sw.Dopri5(rtol=1e-8, atol=1e-8), MEASURES),
}
# Bytes of a thread: the largest system has its cosines computed beforehand, by the eighth-order method for all stages.
SPILLED = {("everything", "Dop8"): 4000, ("everything", "Rk4"): 16}
INSTALLED = find_spec("numba_cuda") is not None
needs_compiler = pytest.mark.skipif(not INSTALLED, reason="numba-cuda is not installed (extra cuda)")


def ensemble_of(name, run, **more):
    """The ensemble of a case, its last lane pushed far out."""
    system, method, measures = CASES[name]
    y0 = (np.array([0.0, 0.1, 0.0, -0.1, 1.2]), *(0.05 for _ in system.state_names()[1:]))
    return run(system, FEW, y0, periods=2, settle=1, measures=measures, method=method, **more)


def differences(name, run, **more):
    """Largest difference by variable between an ensemble run somehow and the processor's, by the latter's size."""
    found, wanted = ensemble_of(name, run, **more), ensemble_of(name, sw.ensemble)
    assert found.attrs["device"] == "gpu"
    assert set(found) == set(wanted)
    for variable in ("status", "ended", "period"):
        np.testing.assert_array_equal(found[variable], wanted[variable])
    scale = {v: float(np.nanmax(np.abs(wanted[v].values))) or 1.0 for v in wanted}
    for v in wanted:
        np.testing.assert_array_equal(np.isnan(found[v].values), np.isnan(wanted[v].values))
    return {v: float(np.nanmax(np.abs(found[v].values - wanted[v].values))) / scale[v] for v in wanted}


def in_process(code, **env):
    """What Python code that knows this module as `gpu` prints in a process of its own, from JSON."""
    start = (
        f"import sys; sys.path[:0] = [{str(TESTS)!r}, {str(Path(__file__).parent)!r}]; import test_gpu as gpu, json; "
    )
    run = subprocess.run(
        [sys.executable, "-c", start + code], env=os.environ | env, capture_output=True, text=True, check=False
    )
    assert run.returncode == 0, run.stderr
    return json.loads(run.stdout)


@pytest.mark.slow
def test_simulated_device_gives_the_same_bits():
    code = (
        "import strainwave.compile.cuda as c, strainwave as sw; c.THREADS = 2; "
        "print(json.dumps({name: gpu.differences(name, sw.ensemble, device='gpu') for name in gpu.CASES}))"
    )
    found = in_process(code, NUMBA_ENABLE_CUDASIM="1", STRAINWAVE_JIT="0")
    different = {name: {v: d for v, d in of.items() if d != 0.0} for name, of in found.items()}
    assert different == {name: {} for name in CASES}


@pytest.mark.slow
@needs_compiler
@pytest.mark.parametrize("name", CASES)
def test_code_of_the_device_gives_the_answer_of_the_processor_to_rounding(name):
    code = (
        "import device_code as d; d.cuda.THREADS = 2; "
        f"print(json.dumps(gpu.differences({name!r}, lambda *a, **k: d.ensemble_by(d.run_on_processor, *a, **k))))"
    )
    found = in_process(code, LLVMLITE_ENABLE_IR_LAYER_TYPED_POINTERS="0")
    assert max(found.values()) < 1e-12, found


@pytest.mark.slow
@needs_compiler
@pytest.mark.parametrize("name", SYSTEMS)
@pytest.mark.parametrize("method", [sw.Rk4(steps_per_period=64), sw.Dop8(steps_per_period=32)], ids=["Rk4", "Dop8"])
def test_ptx_keeps_the_state_in_registers_and_calls_nothing(name, method):
    import device_code

    made, _ = device_code.code(SYSTEMS[name], method, ((8, 0), (9, 0)))
    for (major, minor), ptx in made.items():
        assert f".target sm_{major}{minor}" in ptx
        assert ptx.count("fma.rn.f64") > 100
        assert re.findall(r"^\s+(?:ld|st)\.local.*|^\s+call.*|^\.extern.*", ptx, re.MULTILINE) == []
    used = device_code.registers(made[9, 0], (9, 0))
    if used is not None:
        assert used[2] <= SPILLED.get((name, type(method).__name__), 0)


@pytest.mark.skipif(INSTALLED, reason="numba-cuda is installed")
def test_without_numba_cuda_a_warning_says_so_and_the_processor_does_it():
    options = {"periods": 1, "method": sw.Rk4(steps_per_period=8)}
    with pytest.warns(UserWarning, match=r"numba-cuda is not installed .*runs on the processor|compilation is off"):
        found = sw.ensemble(SYSTEMS["Duffing"], FEW, (0.0, 0.0), device="gpu", **options)
    assert found.attrs["device"] == "cpu"
    assert found.equals(sw.ensemble(SYSTEMS["Duffing"], FEW, (0.0, 0.0), **options))


def test_unknown_device_is_refused():
    with pytest.raises(ValueError, match=r"device is 'tpu'; it must be 'cpu' or 'gpu'"):
        sw.ensemble(SYSTEMS["Duffing"], FEW, (0.0, 0.0), periods=1, device="tpu")


@pytest.mark.parametrize("error", ["CudaAPIError('[2] Call to cuMemAlloc results in CUDA_ERROR_OUT_OF_MEMORY')", "0"])
def test_a_device_without_memory_left_is_one_sentence(error):
    """A driver that allocates nothing: the simulator's allocation raises what numba-cuda's does, or NumPy's error."""
    code = (
        "import strainwave as sw, strainwave.compile.cuda as c; cuda = c.load()\n"
        "class CudaAPIError(RuntimeError): pass\n"
        f"def full(shape): raise ({error} or MemoryError('Unable to allocate 1 TiB'))\n"
        "cuda.device_array = full\n"
        "try: gpu.ensemble_of('Dopri5', sw.ensemble, device='gpu')\n"
        "except MemoryError as error: print(json.dumps(str(error)))"
    )
    said = in_process(code, NUMBA_ENABLE_CUDASIM="1", STRAINWAVE_JIT="0")
    assert said.startswith("the graphics processor has no memory left for 5 trajectories at a time; make several")
