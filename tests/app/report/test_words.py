"""Limits that a run passes are the first warnings of the report, each with the speed where it happens."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from assumed_axis import axis

import strainwave as sw
from strainwave.app.report.section import cell, head
from strainwave.app.report.sections.basis import certificates
from strainwave.app.report.sections.cautions import warnings
from strainwave.app.report.sections.derived import quantities
from strainwave.app.report.sections.resonances import peak_verdict
from strainwave.app.report.sections.speeds_to_avoid import speeds_to_avoid
from strainwave.app.view import AngleUnit, View
from strainwave.base.units import ARCSEC, RPM
from strainwave.drive.demands.motor_limits import MotorLimits
from strainwave.drive.demands.usage import MotorUse, Usage, limit_findings
from strainwave.drive.speeds import Speeds
from strainwave.study.analysis.analysis import Largest
from strainwave.study.analysis.remedies import Remedy
from strainwave.study.analysis.verdict import Answer, Verdict
from strainwave.study.analysis.verdict_words import _worst
from strainwave.study.speed_map.avoid import Avoid
from strainwave.study.speed_map.error_equation import operating_point
from strainwave.study.speed_map.intervals import merged

ARCSECONDS = AngleUnit("arcsec", 1.0 / ARCSEC)
SPEEDS = Speeds((60.0, 200.0))


def view(analysis, **project):
    of = SimpleNamespace(**{"speeds": SPEEDS, "limit": None, "loop": None, "digits": lambda most=4: most} | project)
    if analysis is not None:
        analysis.project = of
    return View(of, analysis, ARCSECONDS)


def told(data):
    return view(None).rendered(data)


def test_what_the_run_asks_beyond_the_datasheet_is_said_first():
    gear = sw.catalogue.gear("CSG-40-50")
    used = Usage(peak_torque=600.0, at_peak=2400 * RPM, average_torque=300.0, at_average=2350 * RPM)
    limits = limit_findings(gear, used, 4500 * RPM)
    drive = gear.drive(load_inertia=1.3, B=20.0)
    response = SimpleNamespace(sweep=None)
    analysis = SimpleNamespace(usage=used, limits=limits, warnings=("a warning",), drive=response, train=None)
    said = told(warnings(view(analysis, gear=gear, drive=drive, notes=("a doubt",))))
    assert [sentence.split(",")[0] for sentence in said[:3]] == [
        "At 2400 rpm at the motor: The gear torque reaches 600 N·m",
        "The input speed reaches 4500 rpm",
        "At 2350 rpm at the motor: The cubic mean of the gear torque is 300 N·m",
    ]
    assert said[3:] == ["a warning", "a doubt"]


def test_numbers_of_the_error_equation_say_so_where_the_whole_drive_has_no_stable_motion():
    largest = Largest(9e-4, 100.0 * RPM, "error equation", "harmonic balance", None)
    for train, alone in (
        (None, ""),
        (axis().train, " in the error equation alone, with the motor ideally held and the load rigid"),
    ):
        study = None if train is None else SimpleNamespace(train=train, ramp=None)
        analysis = SimpleNamespace(train=study, train_curve=None, largest_oscillation=lambda: largest)
        shown = view(analysis, has_memory=False, motor="loop")
        assert shown.rendered(_worst(shown.analysis)).endswith(f" arcsec at 100 rpm at the motor{alone}.")


def test_the_facts_name_the_frequencies_before_and_after_hysteresis_yields_and_the_ratio_of_the_spring():
    """K1 = 1e5 N*m/rad holds 1.3 kg*m^2 at 277.35 rad/s, with the 6e4 of the hysteresis at 350.82 rad/s."""
    law = sw.Parallel(sw.catalogue.gear("CSG-40-50").law, sw.BoucWen(6e4, 0.0, 8e-5))
    damping = 2.0 * 0.03 * math.sqrt(1e5 * 1.3)
    drive = sw.Drive(4.5e-4, 1.3, 50.0, damping, law)
    system = drive.error_equation(kinematic_error=sw.KinematicError((sw.Line(2, 1e-4),)), motor="held")
    analysis = SimpleNamespace(point=operating_point(system), system=system, loop=None, train=None)
    shown = view(analysis, drive=drive, motor="held", kinematic_error=None, gear=None)
    rows = {fact.name: fact for fact in quantities(shown)}
    before, after = rows["Natural frequency, motor held"], rows["Natural frequency of the spring alone, motor held"]
    assert (before.value, after.value) == (pytest.approx(350.823, abs=1e-3), pytest.approx(277.350, abs=1e-3))
    assert "before the hysteresis yields" in before.note
    assert "hysteresis yielded" in after.note
    assert rows["Damping ratio, motor held"].value == pytest.approx(0.03, rel=1e-12)
    assert rows["Torsional stiffness of the spring alone"].value == 1e5
    assert rows["Damping across the spring"].value == damping


def resonance(**more):
    speeds = {"omega_rad_per_s": 138.7, "motor_speed_rpm": 1324.5}
    row = {"name": "primary", "order": 2, "top": None, "jumps": [], "peak": None, "peak_error": None}
    return row | speeds | more


def test_a_peak_by_multiple_scales_is_measured_against_the_curve_or_said_to_be_estimated():
    measured = {"amplitude": 0.27, "speed": -0.05, "predicted": False}
    assert peak_verdict(resonance(peak_error=measured)) == (
        "relative to the computed curve, the amplitude is 27 % too large and the resonance speed 5 % too low"
    )
    guessed = {"amplitude": 0.27, "speed": 0.05, "predicted": True}
    assert "estimated error: about 27 %" in peak_verdict(resonance(peak_error=guessed))


def test_the_certificate_of_a_train_is_that_of_its_own_curve_beside_that_of_the_error_equation():
    own, reduced = (
        SimpleNamespace(curve=SimpleNamespace(coefficients=np.zeros((1, 2 * h + 1)), tail=tail, waves=None))
        for h, tail in ((16, 1e-4), (15, 2e-3))
    )
    more = {"beat": None, "regimes": (), "run_up": SimpleNamespace(difference=lambda: 3e-3)}
    for curve, names in (
        (
            own,
            ["response curve, 16", "response curve of the error equation, 15", "response curve of the error equation"],
        ),
        (None, ["response curve, 15", "response curve"]),
    ):
        analysis = SimpleNamespace(train_curve=curve, drive=curve or reduced, exact=reduced, **more)
        rows = certificates(view(analysis))
        assert [row["what"].removesuffix(" harmonics") for row in rows] == names
        sizes = [1e-4] * (curve is own) + [2e-3, 3e-3]
        assert [row["relative_difference"] for row in rows] == sizes


def advised(
    bands, largest, slow, remedies=(), sweep=None, peaks=(), limit=None, beyond=(), exceeded=(), run_up=None, jumping=()
):  # fmt: skip
    avoid = Avoid(bands, largest, 140.0, slow, peaks, limit, largest_passed=run_up and (100.0, run_up))
    response = SimpleNamespace(sweep=sweep)
    analysis = SimpleNamespace(
        avoid=avoid, remedies=remedies, not_tried=(), drive=response, speeds=(60.0, 200.0), load_cases=(),
        train_curve=None, verdict=Verdict(Answer.BUT, merged([*bands, *beyond]), (), exceeded), jumping=jumping,
        postures=(),
    )  # fmt: skip
    return told(speeds_to_avoid(view(analysis)).data["advice"])


def test_speeds_to_avoid_are_one_sentence_with_the_reason_and_the_jumps():
    sweep = SimpleNamespace(jumping=(SimpleNamespace(low=148.0, high=153.0), SimpleNamespace(low=190.0, high=195.0)))
    peaks = ((140.0, 1e-3), (200.0, 3e-4))
    advice = advised(((135.0, 155.0), (190.0, 200.0)), 1e-3, 1e-4, sweep=sweep, peaks=peaks)
    assert advice["sentence"] == (
        "Avoid 1289 to 1481 and 1814 to 1910 (end of the speed range) rpm at the motor: there the oscillation of the "
        "error is above 2 times the 20.63 arcsec at very low speed: 206.3 arcsec at 1337 and 61.88 arcsec at 1910, "
        "and the oscillation jumps between 1413 and 1461 and between 1814 and 1862."
    )
    assert "nominal drive. With 'scatter' and 'limit' in the project file, 'strainwave exceedance'" in advice["nominal"]
    assert advice["bands"][0]["to_rpm"] == pytest.approx(155.0 / RPM)


def test_a_jump_under_another_torque_than_that_of_the_curve_is_said_with_its_torque():
    jumping = ((-5.0, SimpleNamespace(low=135.0, high=136.0)),)
    assert advised(((135.0, 136.0),), 1e-4, 1e-4, limit=5e-4, jumping=jumping)["sentence"] == (
        "Avoid 1289 to 1299 rpm at the motor: there the oscillation jumps between 1289 and 1299 under a load "
        "torque of −5 N·m."
    )


def test_a_drive_without_a_resonance_in_its_range_has_no_speed_to_avoid():
    assert advised((), 1.5e-4, 1e-4)["sentence"] == (
        "No speed of the range has to be avoided: the oscillation of the error is at most 30.94 arcsec, 1.5 times the "
        "20.63 arcsec at very low speed, without jumps."
    )
    assert advised((), 1.5e-4, 1e-4, limit=3e-4, run_up=2e-4)["sentence"] == (
        "No speed of the range has to be avoided: the oscillation of the error is at most 30.94 arcsec in steady "
        "motions and 41.25 arcsec in the run-up, within the limit of 61.88 arcsec, without jumps."
    )


def test_speeds_that_only_a_limit_of_the_motor_forbids_are_to_be_avoided_too():
    motor = MotorUse(torque=0.5, at=100.0, holding=0.4)
    used = Usage(peak_torque=1.0, at_peak=100.0, average_torque=1.0, at_average=100.0)
    found = limit_findings(None, used, None, MotorLimits(0.3), motor)
    said = advised((), 1.5e-4, 1e-4, beyond=((90.0, 155.0),), exceeded=tuple(found))["sentence"]
    assert said.startswith("No speed of the range has to be avoided: ")
    assert said.endswith("without jumps. Because of the limits of the motor, avoid 859.4 to 1481 rpm at the motor.")


def test_a_limit_of_the_project_is_the_rule_in_place_of_twice_the_error_of_slow_rotation():
    advice = advised(((135.0, 155.0),), 1e-3, 1e-4, limit=5e-4)
    assert advice["sentence"] == (
        "Avoid 1289 to 1481 rpm at the motor: there the oscillation of the error is above the limit of 103.1 arcsec, "
        "at most 206.3 arcsec at 1337."
    )
    assert "is above the project limit of 103.1 arcsec" in advice["rule"]
    assert "times its value at very low speed" not in advice["rule"]
    assert "arcsec, within the limit of 412.5 arcsec, without" in advised((), 1e-3, 1e-4, limit=2e-3)["sentence"]


def test_remedies_are_told_with_their_effect_and_none_is_recommended_that_makes_it_worse():
    better = Remedy("damping of the gear", 0.1, 0.0, 0.92, 140.0)
    worse = Remedy("preload", 0.0, 12.0, 1.05, 150.0)
    assert advised(((135.0, 155.0),), 1e-3, 1e-4, (better, worse))["remedy_sentence"] == (
        "Most helpful: 10 % more damping of the gear. Recomputed with one change at a time: 10 % more "
        "damping of the gear: 8 % less oscillation. These changes do not help: 12 N·m more mean torque."
    )
    assert advised(((135.0, 155.0),), 1e-3, 1e-4, (worse,))["remedy_sentence"] == (
        "These changes do not help: 12 N·m more mean torque."
    )


def test_tables_have_no_more_digits_than_what_they_rest_on():
    sizes = {}
    for project in (axis(), axis(band="30 Hz, damping: 0.7", more="")):
        shown = View(project, None, ARCSECONDS)
        sizes[project.digits()] = [cell(shown, "x_rad", size * ARCSEC) for size in (123.456, 12.3456)]
        assert cell(shown, "x_rad", project.limit) == "60"
        assert cell(shown, "at_rad_per_s", [project.speeds.limits[1], None]) == "3000, –"
        sizes[project.digits()].append(cell(shown, "at_rad_per_s", 98.7654321 * RPM))
        assert (cell(shown, "phase_rad", 1.5), head(shown, "phase_rad")) == ("1.5", "phase (rad)")
        assert head(shown, "peak_from_rest_rad") == "peak from rest (arcsec)"
    assert sizes == {3: ["123", "12.3", "98.8"], 4: ["123.5", "12.35", "98.765"]}
