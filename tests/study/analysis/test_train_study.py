"""A whole train beside its error equation: which of the two is compared with what."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from strainwave import BoucWen, SolveError
from strainwave.app.report.sections.variants import motor_in_words
from strainwave.app.report.sections.whole_train import parts, reduction
from strainwave.app.view import AngleUnit, View
from strainwave.base.results import Status
from strainwave.drive.motor_words import motor_name
from strainwave.drive.response import exact_response
from strainwave.drive.run import drive_run
from strainwave.drive.train_curve import train_curve
from strainwave.files.reading import from_text
from strainwave.study.analysis.load_cases import load_cases
from strainwave.study.analysis.train_study import train_study
from strainwave.study.speed_map import ramp as of_ramps
from strainwave.study.speed_map.decide import decide
from strainwave.study.speed_map.error_equation import operating_point
from strainwave.study.speed_map.ramp import in_run
from strainwave.study.speed_map.rules import Rules

PROJECT = """\
gear: {{ratio: 50, law: {{type: linear, K: 1e5 N*m/rad}}}}
motor: {{inertia: 4.5 kg*cm^2, {motor}}}
load: {{inertia: 1.2 kg*m^2{load}}}
damping: {{B: 15 N*m*s/rad}}
speed: {{from: 800 rpm, to: 1300 rpm, shaft: motor}}
excitation: {excitation}
"""
COUPLING = "{inertia: 0.1 kg*m^2, B: 5 N*m*s/rad, law: {type: linear, K: 1.5e5 N*m/rad}}"
ERROR = "{kinematic_error: [{order: 2, amplitude: 20 arcsec}]}"


def project(motor, load="", excitation=ERROR):
    return from_text(PROJECT.format(motor=motor, load=load and ", " + load, excitation=excitation), Path("p.yaml"))


def test_a_free_motor_with_a_coupling_is_compared_by_its_curve_and_named_in_the_sentence():
    of = project("mode: free", f"coupling: {COUPLING}")
    system, limits = of.system(reduced=True), of.speeds.limits
    exact, curve = exact_response(system, limits), train_curve(of.train, limits)
    study = train_study(of.train, system, limits, curve, exact, operating_point(system))
    assert study.left_out is None
    assert study.ramp is None
    # both ends of the range are on the curve, whose error is that at the load and not across the gear
    assert study.whole[[0, -1]] == pytest.approx(curve.peak[[0, -1]], rel=1e-9)
    assert np.all(study.whole > 1.05 * np.interp(study.omega, curve.omega, curve.across))

    class Found:
        train_curve, load_cases = curve, ()

    Found.exact = exact
    said = View(of, Found, AngleUnit("rad", 1.0)).rendered(reduction(View(of, Found, AngleUnit("rad", 1.0))))[
        "sentence"
    ]
    assert said.startswith(
        "For comparison, with a free motor and a rigid load (error equation) the oscillation would reach "
    )


@pytest.mark.slow
def test_a_run_up_that_ends_before_it_begins_is_left_out_and_the_remark_says_so(monkeypatch):
    of = project("loop: {bandwidth: 20 Hz, damping: 0.7}")
    system, limits = of.system(reduced=True), of.speeds.limits
    exact = exact_response(system, limits)
    monkeypatch.setattr(of_ramps, "drive_run", lambda *args, **options: begun(drive_run(*args, **options)))
    study = train_study(of.train, system, limits, None, exact, operating_point(system))
    assert study.ramp is None
    assert f"The run-up ends while the motion settles at the lowest speed: {Status.DIVERGED.value}." in study.remarks
    assert "No steady motion of the drive train that repeats with every turn was found." in study.remarks


@pytest.mark.slow
def test_the_begin_of_a_run_up_shakes_no_more_than_steady_motions_do():
    """With one step of the acceleration the first turn has 2.4 times the steady oscillation."""
    of, limits = project("loop: {type: cascade, bandwidth: 15 Hz, damping: 1}"), (60.0, 240.0)
    system = of.system(reduced=True)
    exact, curve = exact_response(system, limits), train_curve(of.train, limits)
    turns = in_run(*train_study(of.train, system, limits, curve, exact, operating_point(system)).ramp)
    slow = turns.omega < 100.0
    assert np.count_nonzero(slow) > 5
    assert np.max(turns.sizes[slow] / np.interp(turns.omega[slow], curve.omega, curve.oscillation)) < 1.15


def begun(run):
    """The first samples of a run, as an integration leaves them that diverges."""
    path = run.trajectory
    return replace(run, trajectory=replace(path, t=path.t[:3], message=Status.DIVERGED.value))


def test_parts_of_a_train_are_named_as_the_file_has_them():
    of = project(
        "loop: {bandwidth: 20 Hz, damping: 0.7, lag: 1 ms}, drag: {type: viscous, B: 1e-3 N*m*s/rad}",
        f"couplings: [{COUPLING}, {COUPLING}]",
    )
    assert parts(View(of, None, None)) == (
        "a motor in a position loop of 20 Hz, damping 0.7, lag 1 ms, a load behind 2 couplings in series, "
        "friction or gravity on the motor"
    )
    assert of.left_out[1:] == ("the motor's drag", "the 2 couplings")
    held = project("mode: held", f"coupling: {COUPLING}")
    assert parts(View(held, None, None)) == "a motor that is ideally held, a load behind a coupling"


def test_a_loop_that_has_no_tuning_is_named_by_its_kind():
    control = project("loop: {type: speed, K_p: 0.1 N*m*s/rad, lag: 0.5 ms}").train.motor.control
    assert motor_in_words(motor_name(control, 1e-3)) == "a motor in a speed loop, lag 0.5 ms"
    assert motor_in_words("resonant") == "a motor with the control resonant"


def test_the_error_of_a_free_motor_is_no_pointing_error_under_any_torque_of_the_load():
    excitation = (
        "{motor_torque: {lines: [{order: 2, amplitude: 0.1 N*m}]}, load_torque: {mean: {from: -30 N*m, to: 30 N*m}}}"
    )
    of = project("mode: free", excitation=excitation)
    cases = load_cases(of, decide(of, Rules(amplification=2.0), search=False))
    assert len(cases) > 2
    assert {case.drive.name for case in cases} == {"error between motor and load"}


@pytest.mark.parametrize("motor", ["mode: held", "loop: {bandwidth: 30 Hz, damping: 0.7}"])
def test_a_torque_that_the_law_cannot_bear_is_said_before_a_curve_is_looked_for(motor):
    excitation = (
        "{kinematic_error: [{order: 2, amplitude: 20 arcsec}], load_torque: {mean: {from: -60 N*m, to: 60 N*m}}}"
    )
    of = project(motor, excitation=excitation)
    law = BoucWen(6e4, 0.0, 5e-4)
    of = replace(of, subject=of.subject._replace(law=law))
    with pytest.raises(SolveError, match=r"BoucWen carries at most -?30 N\*m"):
        decide(of, Rules(amplification=2.0), search=False)
