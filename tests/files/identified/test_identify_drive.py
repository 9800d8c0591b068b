"""A project from the log of its drive: numbers and scatter against the equations that made the log."""

import numpy as np
import pytest
from measured_axis import ERROR, K1, K2, NOISE, PHASE, PROJECT, RATE, RECORD, B, N, measured
from scipy.integrate import solve_ivp

import strainwave as sw
from strainwave.files.reading import from_text
from strainwave.files.variants.identify_drive import expected_range, usual, with_torsion
from strainwave.files.variants.names import Places

TRUTH = {
    "gear.K1": K1, "gear.K2": K2, "damping.B": B, "kinematic_error.0.amplitude": ERROR,
    "kinematic_error.0.phase": PHASE,
    "torsion.offset": 0.0,
}  # fmt: skip


@pytest.fixture
def project(tmp_path):
    return from_text(PROJECT, tmp_path / "axis.yaml")


@pytest.mark.slow
def test_the_numbers_are_found_and_become_a_project(project):
    found = sw.identify_drive(project, measured())
    assert found.names == ("gear.K1", "gear.K2", "gear.K3", *[*TRUTH][2:])  # the law's torsion passes T2 by 3 %
    low, high = found.interval("gear.K3")
    assert low <= RECORD.K3 <= high
    for name, truth in TRUTH.items():
        low, high = found.interval(name, 0.9999)
        assert low <= truth <= high, name
        low, high = found.interval(name)
        assert high - low < 0.02 * abs(truth or NOISE * 1e3)  # the log tells something
    assert found.found.rms[0] == pytest.approx(NOISE, rel=0.05)
    assert found.remarks == ()
    assert found.unit("gear.K1") == "N*m/rad"
    assert found.unit("torsion.offset") == "rad"
    better = found.project
    assert better.gear == project.gear
    assert better.train.motor == project.train.motor  # the loop is not that of the identification
    assert better.train.load == project.train.load
    law = {name: found.value(f"gear.{name}") for name in ("K1", "K2", "K3")}
    assert better.drive.law == RECORD._replace(**law)
    assert better.drive.B == better.train.B == found.value("damping.B")
    assert better.kinematic_error.lines[0].phase == found.value("kinematic_error.0.phase")
    assert sw.project_text(better) == better.text
    assert "gear.K1" in str(found)


@pytest.mark.slow
def test_drives_that_scatter_have_the_covariance_of_the_numbers(project):
    load = measured()
    load["load_angle"] = -load["load_angle"]  # a load that turns against the motor
    found = sw.identify_drive(project, load, ("gear.K1", "gear.K2", "damping.B"))
    assert [name for name, _ in found.project.scatter] == ["gear.K1", "gear.K2", "damping.B"]
    drawn = np.array([(p.drive.law.K1, p.drive.law.K2, p.drive.B) for p in sw.sample.scattered(found.project, 400)])
    sample, table = np.cov(drawn.T), found.found.covariance
    sizes = np.sqrt(np.outer(np.diag(table), np.diag(table)))
    np.testing.assert_allclose(sample / sizes, table / sizes, atol=0.15)  # 400 drives, cut off at 3 deviations


@pytest.mark.slow
def test_a_phase_lies_within_half_a_turn_and_its_scatter_is_an_angle(tmp_path):
    """And a third slope that the torsion does not reach is kept."""
    gear = "{ratio: 100, law: {type: piecewise_linear, T1: 14 N*m, T2: 90 N*m, K1: 31e3 N*m/rad, K2: 5e4 N*m/rad, "
    text = PROJECT.replace("SHG-25-100", gear + "K3: 57e3 N*m/rad}}")
    text = text.replace("phase: 0.2 rad", f"phase: {0.2 + 8.0 * np.pi!r} rad")
    found = sw.identify_drive(from_text(text, tmp_path / "axis.yaml"), measured())
    assert found.names == tuple(TRUTH)
    (kept,) = found.remarks
    assert "gear.K3 was kept: a torsion of -0.000868 to 0.00117 rad does not reach it" in kept
    assert found.value("kinematic_error.0.phase") == pytest.approx(PHASE, abs=0.01)
    scatter = dict(found.project.scatter)
    deviations = dict(zip(found.names, found.found.deviations, strict=True))
    assert scatter["kinematic_error.0.phase"] == deviations["kinematic_error.0.phase"]
    assert scatter["gear.K1"] == deviations["gear.K1"] / found.value("gear.K1")
    again = from_text(found.project.text, tmp_path / "found.yaml")
    assert again.scatter == found.project.scatter
    assert f"kinematic_error.0.phase: {float(scatter['kinematic_error.0.phase'])!r} rad" in found.project.text


@pytest.mark.slow
def test_numbers_of_a_law_stay_those_of_a_gear_where_the_model_does_not_fit(project):
    """A load encoder that is late by 1.5 ms, which the model cannot say: what it takes K3 for is no slope of a gear."""
    log = measured()
    log["load_angle"] = np.interp(log["time"] - 1.5e-3, log["time"], log["load_angle"])
    found = sw.identify_drive(project, log, ("gear.K1", "gear.K2", "gear.K3", "damping.B", "torsion.offset"))
    assert all(found.value(name) > 0.0 for name in ("gear.K1", "gear.K2", "gear.K3", "damping.B"))
    assert not found.usable
    share = 100.0 * (1.0 - found.found.rms[0] / found.found.size[0])
    said = f"The model explains only {share:.0f} % of the motion. Do not use these numbers yet."
    assert str(found).splitlines()[1].strip() == found.quality()[0] == said


@pytest.mark.slow
def test_an_inertia_that_is_kept_is_said_to_scale_stiffness_and_damping(tmp_path):
    """Nothing pulls at the load, and the file has a tenth more inertia: so have K and B, and no residual tells."""
    J, K, t = 2.0, 3e4, np.arange(2000) / RATE

    def motor(s):
        return 100.0 * s - 7.5 * s * s, 100.0 - 15.0 * s

    def equation(s, y):
        angle, speed = motor(s)
        u = angle / N - y[0] - ERROR * np.cos(2.0 * angle)
        return y[1], (K * u + B * (speed / N - y[1] + 2.0 * ERROR * speed * np.sin(2.0 * angle))) / J

    load = solve_ivp(equation, (0.0, t[-1]), (-ERROR, 1.0), "DOP853", t, rtol=1e-10, atol=1e-13, max_step=1e-3).y[0]
    text = PROJECT.replace("gear: SHG-25-100", "gear: {ratio: 100, law: {type: linear, K: 29e3 N*m/rad}}")
    text = text.replace("2.2 kg*m^2, drag: {type: angle_torque, amplitude: 8 N*m}", f"{1.1 * J} kg*m^2")
    log = {"time": t, "motor_angle": motor(t)[0], "load_angle": load}
    project = from_text(text, tmp_path / "axis.yaml")
    found = sw.identify_drive(project, log)
    assert found.value("gear.K") == pytest.approx(1.1 * K, rel=1e-3)
    assert found.value("damping.B") == pytest.approx(1.1 * B, rel=1e-3)
    assert any("in proportion to it" in remark for remark in found.remarks)
    found = sw.identify_drive(project, log, ("load.inertia", "damping.B", *[*TRUTH][3:5]))
    assert found.value("load.inertia") == pytest.approx(29e3 / K * J, rel=1e-3)
    assert found.remarks == ()


def of_law(project, gravity, offset, swing):
    """Torsion of the law, and a log of it at a load angle near 90 deg: that of gravity, and a swing."""
    t = np.arange(3000) / 1000.0
    motor = 0.3 * t + 100.0 * np.pi / 2.0
    low, high = 0.0, 0.01
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if project.drive.law.torque(middle) < gravity else (low, middle)
    u = low + swing * np.sin(2.0 * np.pi * 20.0 * t)
    return u, {"time": t, "motor_angle": motor, "load_angle": motor / N - u + offset}


@pytest.mark.parametrize(("gravity", "reached"), [(20.0, False), (45.0, True), (70.0, True)])
def test_the_torsion_of_the_law_has_the_twist_of_the_load(gravity, reached, tmp_path):
    """Gravity that pulls to one side adds to half the range of the torsion; the encoders' offset does not count."""
    project = from_text(PROJECT.replace("amplitude: 8 N*m", f"amplitude: {gravity} N*m"), tmp_path / "axis.yaml")
    u, log = of_law(project, gravity, 3e-3, 1e-4)
    train = project.whole._replace(omega=1.0)
    low, high = expected_range(train, [with_torsion(log, N)])
    # the mean of the torque is that of gravity; the mean of the torsion is that up to the law's curvature
    assert (low, high) == pytest.approx((u.min(), u.max()), abs=0.05 * u.max())
    free, kept = usual(Places(project, train), (low, high))
    assert ("gear.K3" in free, kept) == (reached, [] if reached else ["gear.K3"])


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
        ({}, {"load_angle": lambda: 0.5 * measured()["load_angle"]}, None, "no gear of ratio 100"),
        ({}, {"load_angle": lambda: 1.25 * measured()["load_angle"]}, None, "no gear of ratio 100; take the gear of"),
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
    log = {name: values() if callable(values) else values for name, values in log.items()}
    channels = {name: values for name, values in (measured() | log).items() if values is not None}
    with pytest.raises(ValueError, match=said):
        sw.identify_drive(from_text(text, tmp_path / "axis.yaml"), channels, free)
