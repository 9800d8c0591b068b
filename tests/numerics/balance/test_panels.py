"""Where a motion meets the kinks of its laws: each place is one, none is missed; machine code does as NumPy."""

import numpy as np
import pytest

import strainwave as sw
from strainwave.compile.tree import leaf_of
from strainwave.numerics.balance.first_order import first_order, linearised
from strainwave.numerics.balance.fourier import Samples, crossings, distances
from strainwave.numerics.balance.linear_part import STRENGTH
from strainwave.numerics.stability.first_order import map_along

KINKED = sw.PiecewiseLinear(1e5, 1.4e5, 1.8e5, 1.0, 3.0)
HYSTERESIS = sw.Parallel(KINKED, sw.BoucWen(5e4, 0.0, 1e-5, 1e5, 0.0, 1.0, 1))
COUPLED = sw.train.Elastic(
    0.3, 2.0, sw.Backlash(2e5, 1e-5), sw.train.Elastic(0.4, 2.0, sw.Linear(3e5), sw.train.Load(1.2))
)
ERROR = sw.KinematicError((sw.Line(2, 1e-5, 0.3),))
TRAIN = sw.DriveTrain(sw.train.Motor(2e-4), 50.0, 20.0, KINKED, sw.train.Load(1.2), 140.0, ERROR)
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


def places(system, y):
    return crossings(system, 1.0, y)


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


@pytest.mark.slow
@pytest.mark.parametrize("virtual", [False, True], ids=["itself", "of a strength"])
@pytest.mark.parametrize("name", SYSTEMS)
def test_machine_code_has_the_equations_and_the_period_map_of_numpy(name, virtual):
    system = SYSTEMS[name]
    leaf = leaf_of(system, "omega")
    problem = first_order(system, leaf, leaf, 5)
    value = 140.0
    if virtual:
        problem, value = problem._replace(leaf=STRENGTH), -0.4
    z = np.append((motion(system, 5) / problem.sizes[:, None]).ravel(), value)
    r, jacobian, slope = linearised(problem, z)
    size = problem.size()
    own = np.empty(size), np.empty((size, size)), np.empty(size)
    problem.residual(z, own[0])
    problem.linearise(z, own[1], own[2])
    assert r == pytest.approx(own[0], rel=1e-9, abs=1e-11 * np.max(np.abs(own[0])))
    assert jacobian == pytest.approx(own[1], rel=1e-5, abs=1e-7 * np.max(np.abs(own[1])))
    assert slope == pytest.approx(own[2], rel=1e-5, abs=1e-7 * np.max(np.abs(own[2])))
    if not virtual:
        flow = np.tile(np.eye(len(problem.sizes)), (2, 1, 1))
        first = problem.run_as(problem.native, "samples", map_along, z, True, flow[0])
        assert first == pytest.approx(map_along(problem, z, True, flow[1]), rel=1e-3)
        if first[0] < 1e3:  # the differences over 1e-7 of a state's size have errors that grow along a period
            assert flow[0] == pytest.approx(flow[1], rel=1e-3, abs=1e-3)
