"""The energy balance closes: over settled orbits and transients, for springs, friction and hysteresis."""

from typing import NamedTuple

import numpy as np
import pytest
from canonical import DISSIPATIVE, ERRORS

import strainwave as sw

LAWS = ["BoucWen", "LuGre", "Coulomb", "Parallel, nested"]


def system(name):
    law = sw.Parallel(sw.Cubic(1.0, 0.1), DISSIPATIVE[name])
    return sw.Oscillator(1.0, 0.05, law, sw.Harmonic(0.4), 1.2, ERRORS["KinematicError"])


@pytest.mark.slow
@pytest.mark.parametrize("name", LAWS)
def test_balance_of_a_transient_closes(name):
    model = system(name)
    start = np.zeros(len(model.state_names()))
    start[0] = 0.3
    balance = sw.study.energy_balance(model, start, 6.0)
    assert balance.closure < 1e-8
    assert abs(balance.stored) > 1e-3  # so that it counts
    assert all(loss > 0.0 for loss in balance.losses.values())


@pytest.mark.slow
@pytest.mark.parametrize("name", LAWS)
def test_balance_of_a_settled_orbit_closes_and_stores_nothing(name):
    model = system(name)
    balance = sw.study.energy_balance(model, sw.find_orbit(model))
    assert balance.closure < 1e-8
    assert abs(balance.stored) < 1e-8 * balance.work
    spent = sum(balance.losses.values())
    assert balance.work + balance.error_work == pytest.approx(spent, rel=1e-8)


def test_viscous_friction_across_the_gear_is_damping():
    # B = 0.05 as a law or as the oscillator's own damping
    inside = sw.Oscillator(1.0, 0.0, sw.Parallel(sw.Linear(1.0), sw.laws.Viscous(0.05)), sw.Harmonic(0.4), 1.2)
    outside = sw.Oscillator(1.0, 0.05, sw.Linear(1.0), sw.Harmonic(0.4), 1.2)
    orbit = sw.find_orbit(outside)
    one, other = (
        sw.study.energy_balance(inside, orbit.state(0.0), 5.0),
        sw.study.energy_balance(outside, orbit.state(0.0), 5.0),
    )
    assert one.losses["Viscous"] == pytest.approx(other.losses["damping B"], rel=1e-10)
    # a linear oscillator loses pi B omega a^2 a period
    full = sw.study.energy_balance(outside, orbit)
    assert full.losses == {"damping B": full.losses["damping B"]}
    assert full.losses["damping B"] == pytest.approx(np.pi * 0.05 * 1.2 * orbit.amplitude(1) ** 2, rel=1e-9)


class Lying(NamedTuple):
    """A law that says it loses half of what it loses."""

    K: float
    r: float
    states = 1

    def torque(self, x, v, z):
        return self.K * z[0]

    def z_rate(self, x, v, z):
        return (v - z[0] / self.r,)

    def energy(self, x, z):
        return 0.5 * self.K * z[0] * z[0]

    def losses(self, x, v, z):
        return (0.5 * self.K * z[0] * z[0] / self.r,)


def test_balance_does_not_close_for_a_law_whose_losses_are_wrong():
    model = sw.Oscillator(1.0, 0.05, Lying(1.0, 2.0), sw.Harmonic(0.4), 1.2)
    assert sw.study.energy_balance(model, (0.1, 0.0, 0.0), 6.0).closure > 1e-2


def test_bad_input_ends_in_one_sentence():
    with pytest.raises(ValueError, match="the start is a state; give the duration of the motion too"):
        sw.study.energy_balance(system("BoucWen"), (0.0, 0.0, 0.0))
    for duration in (1e-30, 1e-12, 1e12, 1e50):  # of cycles of 5 s
        with pytest.raises(
            ValueError, match=r"duration \[s\] is 1e.*; give one from 1.*e-06 to 1.*e\+05 s, 1e-06 to 1"
        ):
            sw.study.energy_balance(system("BoucWen"), (0.1, 0.0, 0.0), duration)
    with pytest.raises(ValueError, match="it must be x, x', z1"):
        sw.study.energy_balance(system("BoucWen"), (0.0, 0.0), 1.0)
