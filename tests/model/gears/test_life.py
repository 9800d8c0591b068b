"""Life of the bearing: the catalogue's formula, worked by hand."""

import math
from dataclasses import replace

import pytest

import strainwave as sw
from strainwave.base.units import RPM


def test_life_is_that_of_the_catalogues_formula():
    # CSG-40-50: 178 N m at 2000 rpm for 10 000 h; half the torque and half the speed: 2^4 times as long
    gear = sw.catalogue.gear("CSG-40-50")
    assert sw.gears.bearing_life(gear, 178.0, 2000.0 * RPM) == pytest.approx(10_000.0)
    assert sw.gears.bearing_life(gear, -89.0, 1000.0 * RPM) == pytest.approx(160_000.0)
    # 7000 h for CSF and HFUC, 10 000 h for SHG
    usual = replace(gear, series="CSF")
    assert sw.gears.bearing_life(usual, 178.0, 2000.0 * RPM) == pytest.approx(7_000.0)
    shg = sw.catalogue.gear("SHG-25-100")
    assert sw.gears.bearing_life(shg, 174.0, 1000.0 * RPM) == pytest.approx(10_000.0 / 8.0 * 2.0)


def test_nothing_is_said_without_a_rating_or_a_load():
    gear = sw.catalogue.gear("CSG-40-50")
    assert sw.gears.bearing_life(replace(gear, rated_torque=None), 178.0, 100.0) is None
    assert sw.gears.bearing_life(gear, 0.0, 100.0) is None
    assert sw.gears.bearing_life(gear, 178.0, 0.0) is None
    with pytest.raises(ValueError, match="average_torque"):
        sw.gears.bearing_life(gear, math.nan, 100.0)
