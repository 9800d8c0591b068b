"""The torque in the gear over a speed range, by two routes, and the limits that it passes."""

import math

import numpy as np
import pytest

import strainwave as sw
from strainwave.drive.demands.usage import Usage, limit_findings
from strainwave.drive.response import exact_response
from strainwave.model.gears.limits import gravest
from strainwave.numerics.steady import settle
from strainwave.study.analysis.time_domain.time_case import usage

RPM = math.pi / 30.0


def test_the_torque_of_a_linear_drive_is_that_of_its_closed_form():
    # J x'' + B x' + K x = 3 cos(w t): the gear carries K x + B x', of amplitude |K + i w B| |x|
    system = sw.Oscillator(1.0, 0.2, sw.Linear(4.0), sw.Harmonic(3.0), 1.0)
    exact = exact_response(system, (1.0, 3.0))
    used = usage(system, exact, ())
    w = exact.curve.omega
    closed = 3.0 * np.abs(4.0 + 0.2j * w) / np.abs(4.0 - w * w + 0.2j * w)
    assert used.peak_torque == pytest.approx(np.max(closed), rel=4e-4)  # 16 samples a harmonic, 7 of them: cos(pi/112)
    assert used.at_peak == pytest.approx(w[np.argmax(closed)], rel=1e-3)  # between two points of the flat top
    assert used.average_torque == pytest.approx(np.max(closed) * (4.0 / (3.0 * math.pi)) ** (1.0 / 3.0), rel=1e-4)


def test_with_a_kinematic_error_the_torsion_counts_and_not_the_error():
    error = sw.KinematicError((sw.Line(2, 0.05, 0.4),))
    system = sw.Oscillator(1.0, 0.2, sw.Linear(4.0), sw.Harmonic(0.0, mean=1.5), 1.0, error)
    exact = exact_response(system, (0.5, 0.8))
    used = usage(system, exact, ())
    k = 2.0 * exact.curve.omega  # u'' + B u' + K u = -e'' + 1.5
    closed = 1.5 + 0.05 * k**2 * np.abs(4.0 + 0.2j * k) / np.abs(4.0 - k * k + 0.2j * k)
    assert used.peak_torque == pytest.approx(np.max(closed), rel=1e-3)


def test_a_simulated_motion_that_is_on_no_curve_counts():
    system = sw.Oscillator(1.0, 0.2, sw.Linear(4.0), sw.Harmonic(3.0), 1.0)
    exact = exact_response(system, (1.0, 1.2))
    motion = settle(system._replace(omega=2.0), (0.0, 0.0), time=30.0)
    used = usage(system, exact, (motion,))
    assert used.at_peak == used.at_average == 2.0
    assert used.peak_torque == pytest.approx(3.0 * abs(4.0 + 0.4j) / 0.4, rel=1e-3)


def test_of_several_limits_passed_the_gravest_is_said():
    gear = sw.catalogue.gear("CSG-40-50")
    findings = limit_findings(gear, Usage(900.0, 1.0, 300.0, 1.0), 5000 * RPM)
    said = [finding.sentence for finding in gravest(findings)]
    assert [sentence.split(",")[0] for sentence in said] == [
        "The input speed reaches 5000 rpm",
        "The cubic mean of the gear torque is 300 N*m",
        "The gear torque reaches 900 N*m",
    ]
    assert "momentary torque of CSG-40-50, 892 N*m" in said[-1]
    assert gravest(limit_findings(gear, Usage(100.0, 1.0, 60.0, 1.0), 2000 * RPM)) == ()
    (fast,) = gravest(limit_findings(gear, Usage(100.0, 1.0, 60.0, 1.0), 3500 * RPM))
    assert fast.sentence == (
        "The input speed reaches 3500 rpm, above the largest average input speed (grease) of CSG-40-50, 3000 rpm; run "
        "at this speed for a short time only."
    )
    assert gravest(limit_findings(gear, Usage(100.0, 1.0, 60.0, 1.0), None)) == ()
