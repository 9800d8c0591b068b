"""Machine code is made for the processor that the environment names, else for this one, with its widest vectors."""

import os
import subprocess
import sys
from pathlib import Path

import machine_code
import numpy as np
import pytest

from strainwave.compile import lanes
from strainwave.compile.numba_import import target_cpu

pytestmark = pytest.mark.slow

SCRIPT = """
import sys
sys.path[:0] = sys.argv[1:]
from test_target import widest
from strainwave.compile.numba_import import target_cpu
print(*target_cpu()[0], target_cpu()[1], widest())
"""
UNITS = {"x86-64-v2": ("sse2",), "x86-64-v3": ("sse2", "avx", "avx2", "fma")}


def doubled(rows):
    for i in range(lanes.LANES):
        lanes.store(2.0 * lanes.load(rows, 0, i), rows, 1, i)


def widest():
    """The widest vector registers in the machine code of a loop over lanes."""
    code = machine_code.assembly(doubled, np.ones((2, lanes.LANES)))
    return next(kind for kind in ("zmm", "ymm", "xmm") if f"%{kind}" in code)


@pytest.mark.slow
@pytest.mark.skipif("'sse2' not in target_cpu()[0]", reason="reads the machine code of x86 processors")
def test_a_loop_over_lanes_has_the_widest_vectors_of_its_processor():
    units = target_cpu()[0]
    assert widest() == ("zmm" if "avx512f" in units else "ymm" if "avx" in units else "xmm")


@pytest.mark.slow
@pytest.mark.parametrize(("level", "registers"), [("x86-64-v2", "xmm"), ("x86-64-v3", "ymm")])
def test_code_for_another_processor_has_its_vector_units_alone(level, registers):
    if not set(UNITS[level]) <= set(target_cpu()[0]):
        pytest.skip(f"this processor runs no code for {level}")
    here = Path(__file__).resolve().parent
    environment = os.environ | {"NUMBA_CPU_NAME": level, "NUMBA_CPU_FEATURES": ""}
    command = [sys.executable, "-c", SCRIPT, str(here), str(here.parent)]
    run = subprocess.run(command, capture_output=True, text=True, env=environment, check=True)
    assert run.stdout.split() == [*UNITS[level], level, registers]
