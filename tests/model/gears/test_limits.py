"""What a run asks of a gear against its datasheet: who exceeds what, and what the sentence says."""

import dataclasses
import math

import numpy as np
import pytest

import strainwave as sw

GEAR = sw.catalogue.gear("CSG-40-50")  # 255, 523, 892 N*m; 4000 rpm, 3000 rpm on average; ratcheting 2300 N*m
RPM = math.pi / 30.0


def exceeded(**run):
    return {finding.limit: finding for finding in sw.gears.check_limits(GEAR, **run) if finding.exceeded}


@pytest.mark.parametrize(
    ("run", "limits"),
    [
        ({"peak_torque": 523.0, "average_torque": 255.0, "max_speed": 4000 * RPM, "average_speed": 3000 * RPM}, set()),
        ({"peak_torque": 524.0}, {"repeated_peak_torque"}),
        ({"peak_torque": -893.0}, {"repeated_peak_torque", "momentary_torque"}),
        ({"peak_torque": 2301.0}, {"repeated_peak_torque", "momentary_torque", "ratcheting_torque"}),
        ({"average_torque": 256.0}, {"average_torque"}),
        ({"max_speed": 4001 * RPM}, {"max_rpm"}),
        ({"average_speed": 3001 * RPM}, {"average_rpm"}),
        ({}, set()),
    ],
)
def test_each_limit_is_passed_just_beyond_its_number(run, limits):
    assert set(exceeded(**run)) == limits


def test_a_doubt_about_a_limit_follows_it():
    gear = sw.catalogue.gear("SHG-40-120")
    mean, most = sw.gears.check_limits(gear, average_speed=1200.0 * RPM, max_speed=1200.0 * RPM)[::-1]
    assert mean.exceeded
    assert mean.sentence.endswith(
        " for a short time only. SHG-40-120: the average input speed of 950 rpm looks mistyped in the source, "
        "other ratios of this size say 3000 rpm; check the maker's datasheet."
    )
    assert "mistyped" not in most.sentence


def test_the_sentence_has_fact_value_limit_and_remedy():
    found = exceeded(peak_torque=600.0, max_speed=5000 * RPM)
    assert found["repeated_peak_torque"].sentence == (
        "The gear torque reaches 600 N*m, above the repeated peak torque of CSG-40-50, 523 N*m; reduce the load "
        "or the vibration, or choose a larger gear."
    )
    assert (
        "reaches 5000 rpm, above the largest input speed (grease) of CSG-40-50, 4000 rpm" in found["max_rpm"].sentence
    )


def test_what_stays_within_its_limit_is_found_too_and_says_so():
    (finding,) = sw.gears.check_limits(GEAR, max_speed=3000 * RPM)
    assert (finding.limit, finding.value, finding.bound, finding.unit) == (
        "max_rpm",
        pytest.approx(3000.0),
        4000.0,
        "rpm",
    )
    assert "within the largest input speed" in finding.sentence


def test_limits_that_no_source_gives_are_not_compared():
    found = sw.gears.check_limits(sw.catalogue.gear("CSF-40-50"), peak_torque=1e4, average_torque=1e4, max_speed=1e4)
    assert [finding.limit for finding in found] == ["ratcheting_torque", "buckling_torque"]


def test_the_cubic_mean_is_the_vendors():
    # T_av = cbrt(sum(n t |T|^3)/sum(n t)): CSF/CSG catalogue, p. 14; by hand 4^3 = 64, 2^3 = 8, (3*64 + 8)/4 = 50
    assert sw.gears.cubic_mean([4.0, -2.0], weights=[3.0, 1.0]) == pytest.approx(50.0 ** (1.0 / 3.0), rel=1e-15)
    angle = 2.0 * np.pi * np.arange(256) / 256
    assert sw.gears.cubic_mean(5.0 * np.cos(angle)) == pytest.approx(
        5.0 * (4.0 / (3.0 * np.pi)) ** (1.0 / 3.0), rel=1e-6
    )
    assert sw.gears.cubic_mean([0.0, 0.0]) == 0.0


@pytest.mark.parametrize(
    ("torque", "weights"),
    [([], None), ([math.nan], None), ([1.0, 2.0], [1.0, -3.0]), ([1.0, 2.0], [0.0, 0.0]), ([1.0, 2.0], [1.0])],
)
def test_a_cubic_mean_of_no_numbers_or_with_impossible_weights_is_refused(torque, weights):
    with pytest.raises(ValueError, match="must"):
        sw.gears.cubic_mean(torque, weights)


def test_a_flexspline_that_fails_below_a_limit_contradicts_it():
    gear = sw.catalogue.gear("CSG-40-50")
    low = dataclasses.replace(gear, momentary_torque=None, ratcheting_torque=100.0)
    assert [field for field, _ in low.contradictions()] == ["repeated_peak_torque"]
    low = dataclasses.replace(gear, buckling_torque=100.0)
    assert [field for field, _ in low.contradictions()] == ["momentary_torque"]
