"""Loops over lanes are vector code: the functions of `maths` in them are packed arithmetic, without a call."""

import re

import machine_code
import numpy as np
import pytest

from strainwave import maths
from strainwave.compile import lanes

pytestmark = pytest.mark.slow


def one_of(name):
    """Return a loop over lanes that applies the function to row 0 (and row 2) and writes row 1."""
    function = getattr(maths, name)
    if name == "power":

        def loop(rows):
            for i in range(lanes.LANES):
                lanes.store(function(lanes.load(rows, 0, i), lanes.load(rows, 2, i)), rows, 1, i)

        return loop

    def loop(rows):
        for i in range(lanes.LANES):
            lanes.store(function(lanes.load(rows, 0, i)), rows, 1, i)

    return loop


def shared_phase(rows, phase, order):
    for i in range(lanes.LANES):
        value = maths.cos(order * phase) * lanes.load(rows, 0, i) + maths.sin(order * phase) * lanes.load(rows, 1, i)
        lanes.store(value, rows, 1, i)


@pytest.mark.slow
@pytest.mark.skipif("not machine_code.has_fma()", reason="reads the machine code of x86 processors with FMA")
@pytest.mark.parametrize("name", ["cos", "sin", "exp", "log", "tanh", "power", "sqrt", "sign"])
def test_loop_over_lanes_is_vector_code(name):
    code = machine_code.instructions(one_of(name), np.ones((3, lanes.LANES)))
    assert [i for i in code if i.startswith("call")] == []
    assert [i for i in code if re.fullmatch(r"v(fn?m\w+|add|sub|mul|div|sqrt|u?comi|cvt\w+)sd", i)] == []
    assert any(re.fullmatch(r"v(fn?m\w+|add|sub|mul|div|sqrt)pd", i) for i in code)


@pytest.mark.slow
@pytest.mark.skipif("not machine_code.has_fma()", reason="reads the machine code of x86 processors with FMA")
def test_cosine_and_sine_of_a_phase_that_lanes_share_are_computed_once():
    code = machine_code.instructions(shared_phase, np.ones((3, lanes.LANES)), 0.3, 2.0)
    scalar = [i for i in code if re.fullmatch(r"v(fn?m\w+|add|sub|mul)sd", i)]
    assert 20 < len(scalar) < 40  # one reduction and two polynomials take 29
    packed = [i for i in code if re.fullmatch(r"v(fn?m\w+|add|sub|mul)pd", i)]
    assert len(packed) <= 2 * lanes.LANES / 4  # two for each vector of four lanes or more: no cosine among them
