"""Remedies of an error equation against the closed form of the linear oscillator."""

import math
from dataclasses import replace

import numpy as np
import pytest
from direct_project import project_of

import strainwave as sw
from strainwave.drive.response import exact_response
from strainwave.study.analysis.design_variables import Subject, design_variables, line_that_matters
from strainwave.study.analysis.remedies import every_variable, remedies
from strainwave.study.speed_map.avoid import speeds_to_avoid
from strainwave.study.speed_map.error_equation import operating_point

K, J, ZETA, A = 1e5, 1.0, 0.03, 1e-4
OMEGA_0 = math.sqrt(K / J)
B = 2.0 * ZETA * J * OMEGA_0
ERROR = sw.KinematicError((sw.Line(2, A),))
SYSTEM = sw.Oscillator(J, B, sw.Linear(K), sw.Harmonic(0.0), 100.0, ERROR)
SPEEDS = (100.0, 220.0)
FINE = np.linspace(*SPEEDS, 40001)


def transmissibility(J=J, B=B, K=K):
    """Error at the load over the kinematic error of order 2 (den Hartog 1956, Mechanical Vibrations, sec. 2.12)."""
    s = 2j * FINE
    return np.abs((B * s + K) / (J * s * s + B * s + K))


def project():
    return project_of(sw.Drive(1e-4, J, 50.0, B, sw.Linear(K)), SPEEDS, kinematic_error=ERROR)


def helps(system, torque, limit=None, **more):
    response = exact_response(system, SPEEDS)
    avoid = speeds_to_avoid(system, response, operating_point(system), limit)
    return remedies(Subject(system, None, SPEEDS, project()), response, avoid, torque, **more), avoid


@pytest.fixture(scope="module")
def linear():
    told = []
    (found, left), _ = helps(SYSTEM, 100.0, limit=1.65e-3, progress=told.append)
    return found, left, told


def test_every_change_is_told_before_it_is_tried_and_the_other_direction_only_where_the_first_is_worse(linear):
    _, left, told = linear
    assert left == ()
    assert told == [
        "kinematic error of order 2, -100%", "kinematic error of order 2, -10%", "inertia of the load, +10%",
        "inertia of the load, -10%", "damping of the gear, +10%", "stiffness of the gear, +10%",
    ]  # fmt: skip


def test_remedies_are_those_of_the_closed_form(linear):
    before = np.max(transmissibility())
    changed = {
        "damping of the gear": transmissibility(B=1.1 * B),
        "stiffness of the gear": transmissibility(K=1.1 * K),
        "inertia of the load": transmissibility(J=0.9 * J),
        "kinematic error of order 2": 0.9 * transmissibility(),
    }
    found = {remedy.what: remedy for remedy in linear[0] if remedy.share != -1.0}
    assert sorted(found) == sorted(changed)  # a preload does not stiffen a linear law
    for name, curve in changed.items():
        assert found[name].ratio == pytest.approx(np.max(curve) / before, rel=1e-3), name
        assert found[name].at == pytest.approx(FINE[np.argmax(curve)], rel=2e-3), name
        assert found[name].exceeds is bool(A * np.max(curve) > 1.65e-3), name
    assert {remedy.exceeds for remedy in found.values()} == {True, False}


def test_the_most_helpful_comes_first_and_what_makes_it_worse_last(linear):
    ratios = [remedy.ratio for remedy in linear[0]]
    assert ratios == sorted(ratios)
    assert linear[0][0].what == "kinematic error of order 2"
    assert linear[0][-1].what == "stiffness of the gear"
    assert linear[0][-1].ratio > 1.0


def test_without_its_only_line_nothing_moves(linear):
    notch = linear[0][0]
    assert (notch.share, notch.ratio, notch.after, notch.unit) == (-1.0, 0.0, 0.0, "arcsec")


def test_more_damping_lowers_a_peak_by_the_same_factor(linear):
    damping = next(remedy for remedy in linear[0] if remedy.what == "damping of the gear")
    assert (damping.before, damping.unit) == (pytest.approx(B), "N·m·s/rad")
    # near the peak of a lightly damped drive the oscillation goes with 1/B
    assert damping.ratio == pytest.approx(1.0 / 1.1, rel=2e-3)


def test_what_does_next_to_nothing_at_ten_percent_is_tried_at_thirty():
    speeds = (20.0, 40.0)  # far below the resonance, where damping does not count
    response = exact_response(SYSTEM, speeds)
    avoid = speeds_to_avoid(SYSTEM, response, operating_point(SYSTEM), limit=1e-5)
    found, _ = remedies(Subject(SYSTEM, None, speeds), response, avoid, 100.0)
    shares = {remedy.what: remedy.share for remedy in found if remedy.share != -1.0}
    assert shares == {
        "damping of the gear": 0.3, "stiffness of the gear": 0.3, "kinematic error of order 2": -0.1,
    }  # fmt: skip
    by = next(remedy for remedy in found if remedy.what == "stiffness of the gear")
    at = 2.0 * speeds[1]
    assert by.ratio == pytest.approx((1 - at**2 / OMEGA_0**2) / (1 - at**2 / (1.3 * OMEGA_0**2)), rel=1e-3)


def test_what_is_beyond_the_number_of_drives_is_left_out_and_named():
    response = exact_response(SYSTEM, SPEEDS)
    avoid = speeds_to_avoid(SYSTEM, response, operating_point(SYSTEM))
    subject = Subject(SYSTEM, None, SPEEDS, project())
    # the line cancelled and 10 % smaller are two drives; the inertia begins with the third and ends with the fourth
    found, left = remedies(subject, response, avoid, 100.0, drives=3)
    assert {(remedy.what, remedy.share) for remedy in found} == {
        ("kinematic error of order 2", -1.0), ("kinematic error of order 2", -0.1), ("inertia of the load", -0.1),
    }  # fmt: skip
    assert left == ("damping of the gear and stiffness of the gear: not tried after 3 other changes",)


def test_other_gears_come_first_so_that_no_number_of_drives_leaves_them_out():
    gear = sw.catalogue.gear("CSG-40-80")
    drive = replace(project(), gear=gear, subject=gear.drive(load_inertia=J, B=B).train(control=sw.train.Held()))
    subject, response = Subject(SYSTEM, None, SPEEDS, drive), exact_response(SYSTEM, SPEEDS)
    known = [variable.what for variable in every_variable(subject, response, 100.0)]
    others = [what for what in known if what.startswith("next ")]
    assert known[: len(others)] == others
    assert known[0].startswith("next size of the gear")


def test_a_preload_is_among_the_remedies_of_a_law_that_it_stiffens():
    (found, _), avoid = helps(SYSTEM._replace(law=sw.Cubic(K, 6.9e4), B=3.0 * B), 1500.0)
    preload = next(remedy for remedy in found if remedy.what == "preload")
    assert (preload.by, preload.share, preload.after) == (150.0, 0.0, 150.0)
    assert preload.at > avoid.at


def test_where_the_load_has_a_range_of_torques_more_of_it_is_no_remedy():
    subject = Subject(SYSTEM._replace(law=sw.Cubic(K, 6.9e4)), None, SPEEDS)
    assert "preload" in {variable.what for variable in design_variables(subject, float, 1500.0)}
    assert "preload" not in {
        variable.what for variable in design_variables(subject._replace(load_torque=10.0), float, 1500.0)
    }


def test_the_line_that_matters_is_the_one_that_is_largest_at_the_peak():
    error = sw.KinematicError((sw.Line(2, 5e-5), sw.Line(4, 1e-5), sw.Line(40, 1e-3)))
    sizes = {2: 1e-4, 4: 3e-4}
    assert line_that_matters(error, lambda order: sizes.get(order, 0.0)) == 1
    assert line_that_matters(sw.KinematicError(()), lambda order: sizes.get(order, 0.0)) is None


@pytest.mark.slow
def test_laws_with_memory_are_followed_to_the_same_peak():
    law = sw.Parallel(sw.Linear(K), sw.BoucWen(1e-3 * K, 0.0, 1.0))  # a hysteresis that never yields: a spring beside K
    system = SYSTEM._replace(law=law, B=2.0 * B)
    at, size = Subject(system, None, (120.0, 200.0)).largest(7, False, None)
    exact = A * transmissibility(B=2.0 * B, K=1.001 * K)
    assert size == pytest.approx(np.max(exact), rel=2e-3)
    assert at == pytest.approx(FINE[np.argmax(exact)], rel=3e-3)
