"""Rules of the datasheet: each turns a gear away for the value that a hand computes."""

import math
from dataclasses import replace

import pytest

import strainwave as sw
from strainwave.base.units import ARCSEC, RPM
from strainwave.study.design.specification import checks, life

GEAR = sw.catalogue.gear("CSG-40-50")
SPEC = sw.Specification(
    load_inertias=(1.3,),
    speeds=(2.0 * RPM, 40.0 * RPM),
    limit=90.0 * ARCSEC,
    rotor_inertias=(1e-4,),
    damping_ratio=0.03,
)


def violated(spec, gear=GEAR):
    return {check.name: check for check in checks(gear, spec) if check.violated}


def test_a_gear_that_meets_everything_violates_nothing():
    assert violated(SPEC) == {}


def test_the_fastest_input_is_compared_with_its_limit():
    # 90 rpm of the load times 50 are 4500 rpm; the datasheet allows 4000
    found = violated(replace(SPEC, speeds=(2.0 * RPM, 90.0 * RPM), average_speed=10.0 * RPM))
    assert list(found) == ["max_rpm"]
    assert found["max_rpm"].use == pytest.approx(4500.0 / 4000.0)


def test_the_mean_input_speed_goes_by_the_time():
    # 70 rpm for 3 s and 40 rpm for 1 s are 62.5 rpm, 3125 rpm of the input; the datasheet allows 3000
    duty = (sw.DutySegment(0.0, 70.0 * RPM, 3.0), sw.DutySegment(0.0, -40.0 * RPM, 1.0))
    found = violated(replace(SPEC, duty=duty))
    assert list(found) == ["average_rpm"]
    assert found["average_rpm"].use == pytest.approx(3125.0 / 3000.0)


def test_the_mean_torque_is_cubic_and_goes_by_turns():
    # (300^3 * 20 * 2 + 100^3 * 10 * 1)/(20 * 2 + 10 * 1), cube root 278.6 N m; the datasheet allows 255
    duty = (sw.DutySegment(300.0, 20.0 * RPM, 2.0), sw.DutySegment(-100.0, 10.0 * RPM, 1.0))
    mean = ((300.0**3 * 40.0 + 100.0**3 * 10.0) / 50.0) ** (1.0 / 3.0)
    found = violated(replace(SPEC, duty=duty))
    assert list(found) == ["average_torque"]
    assert found["average_torque"].use == pytest.approx(mean / 255.0, rel=1e-12)


def test_preload_comes_on_top_of_every_torque():
    found = violated(replace(SPEC, mean_torque=200.0, peak_torque=500.0, preload=-30.0))
    assert list(found) == ["repeated_peak_torque"]
    assert found["repeated_peak_torque"].use == pytest.approx(530.0 / 523.0)


@pytest.mark.parametrize(
    ("gear", "change", "rule", "said"),
    [
        ("SHG-40-120", {}, "average_rpm", "looks mistyped"),
        ("HFUS-50-80", {"mean_torque": 800.0, "peak_torque": 900.0}, "average_torque", "digit for digit"),
        ("HFUS-50-80", {"mean_torque": 600.0, "peak_torque": 600.0, "life": 1e6}, "life", "digit for digit"),
        ("CSG-40-50", {"largest_mass": 4.0}, "mass", "(5, 3.5)"),
        ("HFUS-50-50", {"mean_torque": 800.0, "peak_torque": 900.0}, "average_torque", ""),
    ],
)
def test_a_rule_says_what_the_catalogue_doubts_of_its_number(gear, change, rule, said):
    found = violated(replace(SPEC, accuracy=60.0 * ARCSEC, **change), sw.catalogue.gear(gear))[rule]
    assert "; " not in found.sentence
    assert found.doubts == () if not said else said in " ".join(found.doubts)


def test_a_rare_torque_is_compared_with_the_momentary_limit_alone():
    found = violated(replace(SPEC, mean_torque=100.0, peak_torque=500.0, momentary_torque=900.0))
    assert list(found) == ["momentary_torque"]
    assert found["momentary_torque"].use == pytest.approx(900.0 / 892.0)


def test_ratcheting_and_buckling_are_compared_where_they_are_tabulated():
    found = violated(replace(SPEC, mean_torque=100.0, peak_torque=500.0, momentary_torque=2400.0))
    assert found["ratcheting_torque"].use == pytest.approx(2400.0 / 2300.0)
    assert "buckling_torque" not in found  # 6700 N m


def test_the_life_is_that_of_the_catalogues_formula():
    # 10 000 h at 178 N m and 2000 rpm; 150 N m at 40 rpm of the load, 2000 rpm of the input
    spec = replace(SPEC, mean_torque=150.0, peak_torque=150.0, life=20_000.0)
    hours = 10_000.0 * (178.0 / 150.0) ** 3
    assert life(GEAR, spec) == pytest.approx(hours)
    assert violated(spec)["life"].use == pytest.approx(20_000.0 / hours)
    assert violated(replace(spec, life=16_000.0)) == {}
    assert life(GEAR, SPEC) == math.inf


def test_room_and_choice_are_compared():
    assert violated(replace(SPEC, largest_size=32))["size"].use == pytest.approx(40.0 / 32.0)
    heavy = replace(GEAR, mass=3.3)
    assert violated(replace(SPEC, largest_mass=3.0), heavy)["mass"].use == pytest.approx(1.1)
    assert violated(replace(SPEC, ratios=(80, 100)))["ratio"].use == pytest.approx(1.6)
    assert violated(replace(SPEC, series=("SHG",)))["series"].use == math.inf
    assert violated(replace(SPEC, ratios=(50,), series=("CSG",), largest_size=40)) == {}


@pytest.mark.parametrize(
    ("field", "name", "spec"),
    [
        ("accuracy", "accuracy", SPEC),
        ("input_inertia", "input_inertia", SPEC),
        ("K2", "K1", SPEC),
        ("max_rpm", "max_rpm", SPEC),
        ("mass", "mass", replace(SPEC, largest_mass=3.0)),
        ("size", "size", replace(SPEC, largest_size=40)),
        ("momentary_torque", "momentary_torque", replace(SPEC, mean_torque=1.0, peak_torque=1.0)),
        ("rated_torque", "life", replace(SPEC, mean_torque=1.0, peak_torque=1.0, life=1.0)),
    ],
)
def test_a_number_that_no_source_gives_turns_a_gear_away_where_it_is_needed(field, name, spec):
    full = replace(GEAR, mass=1.0)
    assert violated(spec, full) == {}
    found = violated(spec, replace(full, **{field: None}))
    assert list(found) == [name]
    assert found[name].sentence.startswith("No source gives")
    assert "CSG-40-50" in found[name].sentence
