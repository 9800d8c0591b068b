"""The inner loop of ensembles is vector code for every law, torque and kinematic error that the package has."""

import re

import machine_code
import numpy as np
import pytest
from canonical import DISSIPATIVE, ERRORS, EXCITATIONS, LAWS

import strainwave as sw
from strainwave.base.law import states_of
from strainwave.compile import lanes
from strainwave.numerics.ensemble import fixed_step
from strainwave.numerics.ensemble.pieces import General
from strainwave.numerics.integration.steps import Classical

pytestmark = pytest.mark.slow

SCALAR: set[str] = set()  # laws whose loop is known to stay scalar, with the reason in docs/sweeps.md
TORQUE = sw.Harmonic(0.3)
CASES = {
    **{name: sw.Oscillator(1.0, 0.1, law, TORQUE, 1.1) for name, law in (LAWS | DISSIPATIVE).items()},
    **{name: sw.Oscillator(1.0, 0.1, sw.Linear(1.0), torque, 1.1) for name, torque in EXCITATIONS.items()},
    **{f"{name}, error": sw.Oscillator(1.0, 0.1, sw.Linear(1.0), TORQUE, 1.1, error) for name, error in ERRORS.items()},
}


def two_steps(scheme, model, rows, turn):
    for j in range(lanes.LANES):
        fixed_step.take_two_steps(scheme, model, rows, 20, 20, 0.3, turn, j)


def packed_and_calls(system):
    """Numbers of packed multiply-adds in the loop over lanes, and of calls."""
    y0 = (0.0,) * (2 + states_of(system.law))
    model = fixed_step.LaneModel(system.prepared(), y0, General(), (), ((0.0,),))
    code = machine_code.instructions(two_steps, Classical(), model, np.ones((100, lanes.LANES)), 0.1)
    return tuple(sum(bool(re.fullmatch(pattern, i)) for i in code) for pattern in (r"vfn?m\w+pd", r"call\w*"))


@pytest.mark.slow
@pytest.mark.skipif("not machine_code.has_fma()", reason="reads the machine code of x86 processors with FMA")
@pytest.mark.parametrize("name", sorted(CASES.keys() - SCALAR))
def test_steps_over_lanes_are_vector_code(name):
    packed, calls = packed_and_calls(CASES[name])
    assert packed >= 16, f"{packed} packed multiply-adds"
    assert calls == 0
