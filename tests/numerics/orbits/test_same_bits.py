"""No bit of an orbit depends on what the process computed before."""

import subprocess
import sys

import pytest

SCRIPT = """
import numpy as np
import strainwave as sw

def bits(orbit):
    return orbit.coefficients.tobytes().hex() + orbit.multipliers.tobytes().hex() + float(orbit.peak).hex()

def drives():
    base = sw.Oscillator(1.0, 0.05, sw.Cubic(1.0, 0.1), sw.Harmonic(0.3), 1.0)
    yield base._replace(omega=0.5), 5
    yield base._replace(law=sw.PiecewiseLinear(1.0, 2.0, 3.0, 0.2, 0.5), omega=0.9), 15

first = [bits(sw.find_orbit(one, harmonics=h)) for one, h in drives()]
for k in range(60):
    for one, h in drives():
        sw.find_orbit(one._replace(omega=0.5 + 0.02 * k), harmonics=h)
    if k % 20 == 0:
        sw.frequency_response(one, (0.5, 1.5), harmonics=5)
again = [bits(sw.find_orbit(one, harmonics=h)) for one, h in drives()]
print(*(a == b for a, b in zip(first, again, strict=True)))
print(*first)
"""
FIRST = """
import strainwave as sw
sw.frequency_response(sw.Oscillator(1.0, 0.05, sw.Linear(1.0), sw.Harmonic(0.3), 1.0), (0.5, 2.0))
"""


@pytest.mark.slow
def test_an_orbit_is_the_same_to_the_bit_after_others_in_a_new_process_and_after_a_curve():
    alone, behind = (
        subprocess.run([sys.executable, "-c", text], capture_output=True, text=True, check=True).stdout.splitlines()
        for text in (SCRIPT, FIRST + SCRIPT)
    )
    assert alone[0] == behind[0] == "True True"
    assert alone[1] == behind[1]
