"""A project from the log of its drive: numbers and scatter against the equations that made the log."""

import numpy as np
import pytest
from measured_axis import ERROR, K1, K2, NOISE, PHASE, PROJECT, RECORD, B, N, measured

import strainwave as sw
from strainwave.files.identified.places import Places
from strainwave.files.identified.torsion import with_torsion
from strainwave.files.reading import from_text

TRUTH = {
    "gear.K1": K1, "gear.K2": K2, "damping.B": B, "kinematic_error.0.amplitude": ERROR,
    "kinematic_error.0.phase": PHASE,
    "torsion.offset": 0.0,
}  # fmt: skip
compiled = pytest.mark.compiled


@pytest.fixture
def project(tmp_path):
    return from_text(PROJECT, tmp_path / "axis.yaml")


@compiled
@pytest.mark.slow
def test_the_numbers_are_found_and_become_a_project(project):
    found = sw.identify_drive(project, measured())
    assert found.names == tuple(TRUTH)
    for name, truth in TRUTH.items():
        low, high = found.interval(name, 0.9999)
        assert low <= truth <= high, name
        low, high = found.interval(name)
        assert high - low < 0.02 * abs(truth or NOISE * 1e3)  # the log tells something
    assert found.found.rms[0] == pytest.approx(NOISE, rel=0.05)
    assert any("gear.K3 was kept" in remark for remark in found.remarks)
    assert found.unit("gear.K1") == "N*m/rad"
    assert found.unit("torsion.offset") == "rad"
    better = found.project
    assert better.gear == project.gear
    assert better.train.motor == project.train.motor  # the loop is not that of the identification
    assert better.train.load == project.train.load
    assert better.drive.law == RECORD._replace(K1=found.value("gear.K1"), K2=found.value("gear.K2"))
    assert better.drive.B == better.train.B == found.value("damping.B")
    assert better.kinematic_error.lines[0].phase == found.value("kinematic_error.0.phase")
    assert sw.project_text(better) == better.text
    assert "gear.K1" in str(found)


@compiled
@pytest.mark.slow
def test_drives_that_scatter_have_the_covariance_of_the_numbers(project):
    load = measured()
    load["load_angle"] = -load["load_angle"]  # a load that turns against the motor
    found = sw.identify_drive(project, load, ("gear.K1", "gear.K2", "damping.B"))
    assert [name for name, _ in found.project.scatter] == ["gear.K1", "gear.K2", "damping.B"]
    drawn = np.array([(p.drive.law.K1, p.drive.law.K2, p.drive.B) for p in sw.scattered(found.project, 400)])
    sample, table = np.cov(drawn.T), found.found.covariance
    sizes = np.sqrt(np.outer(np.diag(table), np.diag(table)))
    np.testing.assert_allclose(sample / sizes, table / sizes, atol=0.15)  # 400 drives, cut off at 3 deviations


def test_a_load_against_the_motor_gives_the_same_torsion():
    log = measured()
    turned = {**log, "load_angle": -log["load_angle"]}
    np.testing.assert_array_equal(with_torsion(log, N)["torsion"], with_torsion(turned, N)["torsion"])


@pytest.mark.parametrize(
    ("name", "path"),
    [
        ("gear.K1", "law.first.K1"), ("hysteresis.yield_twist", "law.second.yield_twist"), ("damping", "B"),
        ("damping.ratio", "B"), ("load.inertia", "load.J"), ("load.drag.amplitude", "load.drag.amplitude"),
        ("kinematic_error.0.phase", "error.lines.0.phase"), ("torsion.offset", "x.offset"),
        ("excitation.kinematic_error.0.amplitude", "error.lines.0.amplitude"), ("motor_angle.delay", "reference.delay"),
    ],
)  # fmt: skip
def test_names_of_the_file_are_paths_of_the_train(name, path, tmp_path):
    hysteresis = "hysteresis: {type: bouc_wen, K: 6e4 N*m/rad, ratio: 0, yield_twist: 0.05 mrad}\n"
    project = from_text(PROJECT + hysteresis, tmp_path / "a.yaml")
    places = Places(project, project.whole)
    assert places.path(name) == path
    if name in places.names() and not path.startswith("x."):
        assert places.name(path) == name


@pytest.mark.parametrize(
    ("change", "log", "free", "said"),
    [
        ({}, {"load_angle": None}, None, "log has no channel 'load_angle'; it has time, motor_angle"),
        ({}, {"load_angle": np.zeros(7)}, None, "motor_angle has 2000 samples and load_angle 7"),
        ({}, {"load_angle": np.full(2000, np.nan)}, None, "no two samples in common"),
        ({}, {"load_angle": 0.5 * measured()["load_angle"]}, None, "no gear of ratio 100"),
        ({}, {}, ("motor.inertia",), "'motor.inertia' is no number that the angles of motor and load tell; those are"),
        ({}, {}, ("gear.K9",), "'gear.K9' is no number"),
        ({}, {}, (), "free"),
        ({"load: {": "load: {coupling: {inertia: 0.1 kg*m^2, law: {type: linear, K: 1e5 N*m/rad}}, "}, {}, None,
         "two angles do not tell a coupling from the gear"),
        ({"excitation: {": "excitation: {load_torque: {lines: [{order: 1, amplitude: 1 N*m}]}, "}, {}, None,
         "has lines over the motor's turn"),
        ({"damping: {": "damping: {warming: 5 K, ", "drag: {type: angle_torque, amplitude: 8 N*m}": "",
          ", loop: {type: position_loop, K_p: 60 N*m/rad, K_d: 0.25 N*m*s/rad}": ""}, {}, None, "that varies"),
    ],
)  # fmt: skip
def test_what_the_log_or_the_drive_does_not_allow_is_one_sentence(change, log, free, said, tmp_path):
    text = PROJECT
    for old, new in change.items():
        text = text.replace(old, new)
    channels = {name: values for name, values in (measured() | log).items() if values is not None}
    with pytest.raises(ValueError, match=said):
        sw.identify_drive(from_text(text, tmp_path / "axis.yaml"), channels, free)


@compiled
@pytest.mark.slow
def test_an_order_that_the_file_lacks_is_named(project):
    """A line of five times z2/z1 = 1.01, which no project file holds."""
    log = measured()
    log["load_angle"] -= 3e-5 * np.cos(5.05 * log["motor_angle"] + 1.0)
    found = sw.identify_drive(project, log, tuple(TRUTH))
    (said,) = [remark for remark in found.remarks if "repeats with the motor's angle" in remark]
    assert "order 5.0" in said
