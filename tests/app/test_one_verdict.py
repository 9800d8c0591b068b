"""One verdict on the limits of gear and motor in every face: page, `response`, speed map, analysis and report."""

import json
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from one_joint import HELD

import strainwave as sw
from strainwave.app.commands import cli as command
from strainwave.app.report.report import write
from strainwave.app.web import views
from strainwave.app.web.first_project import first_text
from strainwave.base.units import ARCSEC, RPM
from strainwave.files.reading import from_text
from strainwave.model.error_spectrum import accuracy_spectrum
from strainwave.model.gears.catalogue import gear
from strainwave.study.analysis.verdict import Answer

pytestmark = pytest.mark.slow

LOOP = "motor: {loop: {bandwidth: 30 Hz}%s}"
FASTER = ("to: 4000 rpm", "to: 4400 rpm")
LOADED = ("mean: 0 N*m", "mean: -40 N*m")  # 0.8 N*m at the motor


def text(*changes, motor=""):
    """A drive of CSG-40-50, of at most 4000 rpm and 3000 rpm on average, with a loop."""
    found = HELD.replace("motor: {mode: held}", LOOP % motor)
    for before, after in changes:
        assert before in found
        found = found.replace(before, after)
    return found


def project(*changes, motor=""):
    return from_text(text(*changes, motor=motor), Path("axis.yaml"))


def test_a_first_drive_of_the_app_is_a_cascade_and_its_error_alone_decides():
    for name, passes in (("CSG-20-80", True), ("CSF-17-100", True), ("SHG-45-80", False), ("HFUC-80-160", False)):
        first = from_text(first_text(name), Path("first.yaml"))
        assert str(first.train.motor.control).startswith("CascadeLoop")
        shown = views.response(first)
        assert shown["passes"] is passes
        assert (shown["largest"]["oscillation_arcsec"] <= shown["limit_arcsec"]) is passes
        assert shown["limit_arcsec"] == pytest.approx((first.gear.accuracy or 60.0 * ARCSEC) / ARCSEC, rel=0.005)
        assert not [said for said in (*shown["failures"], *shown["remarks"]) if "input speed reaches" in said]


@pytest.mark.parametrize("name", ["CSG-40-50", "SHG-25-50", "HFUS-50-80"])  # the last two have no accuracy
def test_every_first_drive_of_a_gear_assumes_the_error_of_its_accuracy_class(tmp_path, name):
    path, accuracy = tmp_path / "new.yaml", gear(name).accuracy or 60.0 * ARCSEC
    given = ["new", "--gear", name, "--load-inertia", "1", "-o", str(path)]
    assert CliRunner().invoke(command.cli, given).exit_code == 0
    for drive in (sw.read_project(path), from_text(first_text(name), Path("first.yaml"))):
        assert drive.kinematic_error.lines == pytest.approx(np.array(accuracy_spectrum(accuracy).lines), rel=1e-9)
        assert drive.limit == pytest.approx(accuracy, rel=0.005)
        assert any("peak-to-peak (assumed)" in note for note in drive.notes) is (gear(name).accuracy is None)
        assert ("excitation.accuracy", "assumed") in {(one.name, one.word) for one in drive.sources}


def test_an_average_speed_beyond_that_of_the_gear_is_a_remark():
    drive = project()
    shown, found = views.response(drive), sw.speed_map(drive, search=False)
    assert shown["passes"] is True
    assert shown["failures"] == []
    assert found.failures == ()
    np.testing.assert_allclose(found.windows, [drive.speeds.limits], rtol=1e-12)
    for remarks in (shown["remarks"], found.remarks):
        (duty,) = [said for said in remarks if "average input speed" in said]
        assert duty.endswith("3000 rpm; run at this speed for a short time only.")


def test_a_speed_above_the_largest_of_the_gear_fails_alike(tmp_path):
    drive, limit = project(FASTER), 4000.0 * RPM
    said = "The input speed reaches 4400 rpm, above the largest input speed (grease) of CSG-40-50, 4000 rpm"
    shown, found = views.response(drive), sw.speed_map(drive, search=False)
    mapped = views.mapped(drive, False, [], lambda *_: None)
    assert shown["passes"] is False
    assert shown["failures"][0].startswith(said)
    np.testing.assert_allclose(shown["avoid"], [(4000.0, 4400.0)], rtol=1e-9)
    assert found.failures[0].startswith(said)
    assert mapped["failures"] == list(found.failures)
    np.testing.assert_allclose(found.forbidden[0], [(limit, 1.1 * limit)], rtol=1e-9)
    assert " or faster than 4000 rpm or gear torque above 523 N*m" in found.rule
    path = tmp_path / "axis.yaml"
    path.write_text(text(FASTER), encoding="utf-8")
    printed = CliRunner().invoke(command.cli, ["response", str(path)])
    assert f"FAIL: {said}" in printed.stdout
    data = json.loads(CliRunner().invoke(command.cli, ["response", str(path), "--json"]).stdout)
    assert data["passes"] is False
    assert data["failures"] == shown["failures"]
    listed = CliRunner().invoke(command.cli, ["speed-map", str(path), "-o", str(tmp_path / "map")])
    assert listed.stdout.startswith(f"FAIL: {said}")


def test_a_motor_weaker_than_its_load_fails_on_the_page_and_forbids_every_speed_of_a_map():
    drive = project(LOADED, motor=", max_torque: 0.3 N*m, max_speed: 3500 rpm")
    shown, found = views.response(drive), sw.speed_map(drive, search=False)
    assert shown["passes"] is False
    torque, speed = shown["failures"]
    assert "above its limit of 0.3 N*m (loads and friction alone require 0.80" in torque
    assert speed.startswith("The speed of the motor reaches 4000 rpm, above its limit of 3500 rpm")
    assert shown["required_motor"]["max_torque"] == 0.3
    np.testing.assert_allclose(shown["avoid"], [(500.0, 4000.0)], rtol=1e-9)
    assert len(found.windows) == 0
    assert [said.split(" of")[0] for said in found.failures] == ["The torque", "The speed"]
    assert "motor torque above 0.3 N*m" in found.rule


def test_the_page_finds_the_motor_torque_of_a_held_drive_over_its_short_period():
    drive = from_text(HELD.replace(*LOADED), Path("held.yaml"))
    whole, shown = drive.response(coexisting=False), views.response(drive)["required_motor"]
    assert shown["torque"] == pytest.approx(whole.motor.torque, rel=2e-3)
    assert shown["holding_torque"] == pytest.approx(whole.motor.holding, rel=2e-3)
    assert whole.motor.holding == pytest.approx(40.0 / 50.0, rel=0.05)


def test_a_limit_below_the_error_of_slow_rotation_is_named_with_it():
    shown = views.response(project(("120 arcsec", "5 arcsec")))
    assert shown["passes"] is False
    assert shown["failures"][0].startswith("The limit of 5 arcsec is below the gear error at very low speed, 19.9 ")


def test_jumps_below_the_limit_fail_and_are_named():
    shown = views.response(from_text(HELD.replace("120 arcsec", "1000 arcsec"), Path("held.yaml")))
    assert shown["passes"] is False
    assert shown["failures"] == ["The oscillation jumps in a slow run-up or run-down."]


@pytest.mark.slow
def test_the_report_decides_as_the_page_does(tmp_path):
    motor = ", max_torque: 0.3 N*m, max_speed: 3500 rpm"
    for drive in (project(), project(FASTER), project(LOADED, motor=motor)):
        shown = views.response(drive)
        report = write(drive, tmp_path / "report")
        verdict = report.view.analysis.verdict
        assert (verdict.answer is Answer.ALL_RIGHT) == shown["passes"]
        np.testing.assert_allclose(np.ravel(verdict.speeds) / RPM, np.ravel(shown["avoid"]), rtol=2e-3)
        judged = {one["limit"]: one["fails"] for one in report.results["limits"]}
        assert judged == {one["limit"]: one["fails"] for one in shown["limits"]}
        asked, steady = report.results["required_motor"], report.view.analysis.drive.motor
        assert steady.torque == pytest.approx(shown["required_motor"]["torque"], rel=2e-3)
        assert asked["torque_Nm"] >= steady.torque  # in the run-up it may be more
        assert asked["speed_rpm"] == pytest.approx(shown["required_motor"]["largest_speed"], rel=1e-12)
    headline = report.results["verdict"]["headline"]
    assert headline.startswith("Fail; ")
    assert headline.endswith(
        "motor's largest torque of 0.3 N·m; 4000 rpm exceeds the motor's largest speed of 3500 rpm"
    )
    assert " (only 0.3 N·m available), at " in report.results["verdict"]["answers"]["motor"]
