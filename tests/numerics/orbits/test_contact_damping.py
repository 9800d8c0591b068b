"""Backlash whose damping acts in contact alone, without other damping, against SciPy."""

import math
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import strainwave as sw
from strainwave.base.units import ARCSEC
from strainwave.files.reading import from_text

GAP, RISE, B, OMEGA = 0.1, 0.02, 0.1, 1.3


def settled(mean, turns=120):
    """Largest |x| of x'' + contact(x) (x - gap sign x) + damping(x) x' = mean + 0.3 cos(omega t), after its turns."""

    def rates(t, y):
        beyond = max(abs(y[0]) - GAP, 0.0)
        torque = math.copysign(beyond, y[0]) + B * min(beyond / RISE, 1.0) * y[1]
        return y[1], mean + 0.3 * math.cos(OMEGA * t) - torque

    turn = 2.0 * math.pi / OMEGA
    times = np.linspace((turns - 1) * turn, turns * turn, 4001)
    found = solve_ivp(rates, (0.0, times[-1]), (0.3, 0.0), "DOP853", times, rtol=1e-9, atol=1e-11, max_step=turn / 60)
    return float(np.max(np.abs(found.y[0])))


@pytest.mark.parametrize("mean", [0.0, 0.2])
def test_an_orbit_is_found_with_damping_in_contact_alone(mean):
    law = sw.Parallel(sw.Backlash(1.0, GAP), sw.laws.ContactDamping(B, GAP, RISE))
    system = sw.Oscillator(1.0, 0.0, law, sw.Harmonic(0.3, mean=mean), OMEGA)
    orbit = sw.find_orbit(system)
    assert (orbit.status, orbit.stable) == (sw.Status.OK, True)
    assert orbit.peak == pytest.approx(settled(mean), rel=1e-6)


FILE = """
gear: {ratio: 100, law: {type: linear, K: 3.1e4 N*m/rad}}
motor: {inertia: 3 kg*cm^2, mode: held}
load: {inertia: 1.2 kg*m^2}
backlash: {half_gap: 10 arcsec}
damping: {B: 20 N*m*s/rad}
speed: {from: 500 rpm, to: 1200 rpm, shaft: motor}
excitation: {kinematic_error: [{order: 2, amplitude: 20 arcsec}], load_torque: {mean: -5 N*m}}
"""
CONTACT = FILE.replace("{B: 20 N*m*s/rad}", "{B: 0 N*m*s/rad}") + (
    "hysteresis: {type: contact_damping, B: 20 N*m*s/rad, half_gap: 10 arcsec, rise: 2 arcsec}\n"
)


def test_a_project_says_that_its_damping_acts_in_the_gap_and_takes_one_that_does_not():
    across, contact = (from_text(text, Path("axis.yaml")) for text in (FILE, CONTACT))
    said = [any("within the backlash gap too" in note for note in project.notes) for project in (across, contact)]
    assert said == [True, False]
    law = contact.drive.law
    assert law.second == sw.laws.ContactDamping(20.0, 10.0 * ARCSEC, 2.0 * ARCSEC)
    assert law.torque(5.0 * ARCSEC, 1.0, ()) == 0.0
