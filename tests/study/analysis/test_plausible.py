"""Results that no gear gives are said: a loop wider than catalogues print, a torque at which the teeth skip."""

import math

import pytest

import strainwave as sw
from strainwave.drive.demands.usage import Usage
from strainwave.study.analysis.cautions import implausible
from strainwave.study.gear.hysteresis_loop import gear_loop

ARCMIN = math.pi / 10800.0
CSG, CALM = sw.catalogue.gear("CSG-40-50"), Usage(200.0, 150.0, 100.0, 150.0)


def loop(friction):
    """Loop at 178 N*m of a spring with friction; its width is 2 friction/K."""
    return gear_loop(sw.Parallel(sw.Linear(1e5), sw.BoucWen(1e6 * friction, 0.0, 1e-6)), 178.0, rated=True)


@pytest.mark.parametrize(("gear", "most"), [(CSG, 1.0), (None, 3.0)])
def test_a_hysteresis_wider_than_the_catalogue_prints_is_said(gear, most):
    friction = 0.5 * most * ARCMIN * 1e5
    assert loop(friction).full.loss == pytest.approx(most * ARCMIN, rel=0.01)
    assert list(implausible(gear, 178.0, loop(friction), CALM)) == []
    (said,) = implausible(gear, 178.0, loop(1.2 * friction), CALM)
    name = "CSG-40-50" if gear else "catalogue gears"
    assert said.startswith("The hysteresis loss at the rated torque of 178 N*m is 0.0")
    assert f"above the largest loss of {name}, 0.000" in said


def test_a_torque_at_which_the_teeth_skip_is_said_of_a_gear_without_a_ratcheting_torque():
    strained = Usage(17.0 * 178.0, 150.0, 100.0, 150.0)
    (said,) = implausible(None, 178.0, None, strained)
    assert said.startswith("The gear torque reaches 3026 N*m at 150 rad/s, 17 times the rated torque. Gear")
    assert list(implausible(None, 178.0, None, CALM)) == []
    assert list(implausible(None, None, None, strained)) == []
    assert list(implausible(CSG, 178.0, None, strained)) == []  # its own ratcheting torque is among the limits


def test_the_catalogue_has_the_numbers_that_these_thresholds_stand_on():
    gears = [sw.catalogue.gear(name) for name in sw.catalogue.names()]
    ratcheting = [g.ratcheting_torque / g.rated_torque for g in gears if g.ratcheting_torque and g.rated_torque]
    twists = [g.twist(g.rated_torque) for g in gears if g.rated_torque and g.K2]
    assert (min(ratcheting), max(ratcheting)) == pytest.approx((4.8, 15.7), abs=0.05)
    assert (min(twists), max(twists)) == pytest.approx((0.5e-3, 2.4e-3), abs=1e-6)
    assert max(g.hysteresis_loss for g in gears if g.hysteresis_loss) == pytest.approx(3.0 * ARCMIN, rel=1e-4)
    assert (min(g.K1 for g in gears), max(g.K1 for g in gears)) == (340.0, 1.45e6)
    assert max(g.max_rpm for g in gears if g.max_rpm) == 8500.0
