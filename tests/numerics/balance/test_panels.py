"""Where a motion meets the kinks of its laws: each place is one, none is missed, by machine code as by NumPy."""

import numpy as np
import pytest

import strainwave as sw
from strainwave.compile.jit import run
from strainwave.numerics.addressed import system_by_address
from strainwave.numerics.balance.fourier import synthesis
from strainwave.numerics.balance.panels import LOOKED, Samples, crossings, distances

KINKED = sw.PiecewiseLinear(1e5, 1.4e5, 1.8e5, 1.0, 3.0)
HYSTERESIS = sw.Parallel(KINKED, sw.BoucWen(5e4, 0.0, 1e-5, 1e5, 0.0, 1.0, 1.0))
COUPLED = sw.Elastic(0.3, 2.0, sw.Backlash(2e5, 1e-5), sw.Elastic(0.4, 2.0, sw.Linear(3e5), sw.Load(1.2)))
ERROR = sw.KinematicError((sw.Line(2, 1e-5, 0.3),))
TRAIN = sw.DriveTrain(sw.Motor(2e-4), 50.0, 20.0, KINKED, sw.Load(1.2), 140.0, ERROR)
SYSTEMS = {
    "oscillator": sw.Oscillator(1.3, 20.0, KINKED, sw.Harmonic(3.0), 140.0, ERROR),
    "hysteresis": sw.Oscillator(1.3, 20.0, HYSTERESIS, sw.Harmonic(3.0), 140.0, ERROR),
    "couplings": TRAIN._replace(load=COUPLED),
    "couplings and hysteresis": TRAIN._replace(load=COUPLED._replace(law=HYSTERESIS), law=HYSTERESIS),
}


def motion(system, harmonics):
    """Random coefficients, of the size of the kinks."""
    states = len(system.state_names())
    return 3e-5 * np.random.default_rng(3).normal(size=(states, 2 * harmonics + 1))


def places(system, y, how=crossings):
    there = y @ synthesis(y.shape[1] // 2, LOOKED * (y.shape[1] // 2 + 1))
    kinks = len(distances(system, np.zeros(1), there[:, :1]))
    found = np.empty(kinks * there.shape[1])
    count = how(system, 1.0, y, there, found)
    return np.sort(found[:count])


def of_states(system, y, psi):
    return distances(system, psi, y @ Samples(psi, psi).basis(y.shape[1] // 2))


@pytest.mark.parametrize("name", SYSTEMS)
def test_each_place_is_a_sign_change_and_none_is_missed(name):
    system = SYSTEMS[name]
    y = motion(system, 5)
    found = places(system, y)
    step = 1e-7
    before, after = of_states(system, y, found - step), of_states(system, y, found + step)
    assert np.all(np.any(before * after < 0.0, axis=0))
    fine = of_states(system, y, np.linspace(0.0, 2.0 * np.pi, 200001))
    assert len(found) == np.count_nonzero(fine[:, 1:] * fine[:, :-1] < 0.0) > 4


def test_a_crossing_on_a_sample_counts_once():
    system = sw.Oscillator(1.0, 0.1, sw.Backlash(1.0, 0.25), sw.Harmonic(1.0), 1.0)
    y = np.zeros((2, 9))
    y[0, 0], y[0, 5] = 0.25, 1.0  # 0.25 + sin psi
    low = np.arcsin(0.5)
    found = np.sort((places(system, y) + 1.0) % (2.0 * np.pi)) - 1.0
    np.testing.assert_allclose(found, [-low, 0.0, np.pi, np.pi + low], atol=1e-9)


@pytest.mark.compiled
@pytest.mark.parametrize("name", SYSTEMS)
def test_machine_code_finds_the_same(name):
    system = SYSTEMS[name]
    y = motion(system, 5)

    def compiled(system, turns, y, there, found):
        kinks = len(found) // there.shape[1]
        return run(crossings, system_by_address(system, len(y), kinks=kinks), turns, y, there, found)

    np.testing.assert_allclose(places(system, y, compiled), places(system, y), rtol=0.0, atol=1e-10)
