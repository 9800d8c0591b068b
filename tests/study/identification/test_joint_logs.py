"""`identify_log` on made logs: samples of benchmarks/joint_logs.py, whose integrator is its own, and of SciPy's."""

import sys
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from measured_axis import GRAVITY, J_L, K1, K2, T1, B, measured

import strainwave as sw
from strainwave.files.variants.identified_project import is_certain
from strainwave.study.identification.joint.solve import scatter

sys.path.append(str(Path(__file__).resolve().parents[3] / "benchmarks"))
import joint_logs

pytestmark = pytest.mark.slow


def found(seed, motion=None, outside=None):
    log, truth = joint_logs.made(seed, motion, outside)
    return sw.identify_log(log, gear=truth["gear"], load_inertia=truth["J"]), truth, log


def covers(fit, truth, name, level=0.9999):
    low, high = fit.interval(name, level)
    return low <= truth[name] <= high


def test_a_log_with_skew_gravity_and_dry_friction_is_read_to_its_noise():
    fit, truth, _ = found(4)
    assert fit.usable
    assert fit.answer.residual == pytest.approx(truth["floor"], rel=0.05)
    assert fit.value("K1") == pytest.approx(truth["K1"], rel=2e-3)
    assert fit.value("B") == pytest.approx(truth["B"], rel=0.03)
    assert fit.value("skew") == pytest.approx(truth["skew"], abs=3e-6)
    assert all(covers(fit, truth, name) for name in ("K1", "K2", "T1", "B", "skew", "coulomb", "viscous", "gravity"))
    law = fit.project.subject.law
    assert pytest.approx(fit.value("K1"), rel=1e-9) == law.K1
    (tie,) = [move for names, move in fit.tied if "K3" in names]
    assert "beyond T2" in tie
    with pytest.raises(ValueError, match="does not determine K3"):
        fit.value("K3")
    with pytest.raises(ValueError, match="has no 'mass'"):
        fit.value("mass")


def test_a_log_that_begins_with_a_loaded_hysteresis_gives_its_numbers():
    fit, truth, _ = found(327)
    names = ("K1", "K2", "T1", "B", "skew", "coulomb", "viscous", "gravity")
    assert truth["hysteresis"] > 0.0
    assert all(covers(fit, truth, name) for name in names)
    assert fit.answer.residual < 1.01 * truth["floor"]


def test_torques_of_one_corner_are_not_read_as_a_law_that_softens():
    """Between -8 and 35 N*m, with gravity as its own constant, slopes of 33300 and 45077 may also be the other way."""
    fit, truth, _ = found(9013, "rests")
    assert fit.usable
    assert fit.value("K1") == pytest.approx(33300.0, rel=0.01)
    assert fit.value("K2") == pytest.approx(45077.0, rel=0.01)
    assert all(covers(fit, truth, name) for name in ("K1", "K2", "B"))


def test_one_direction_ties_friction_to_gravity_and_skew_to_friction():
    log = measured()
    fit = sw.identify_log(log, gear="SHG-25-100", load_inertia=J_L)
    assert fit.usable
    truth = {"K1": K1, "K2": K2, "T1": T1, "B": B, "gravity": GRAVITY}
    for name in ("K1", "B"):
        assert covers(fit, truth, name), name
    names = {name for group, _ in fit.tied for name in group}
    assert {"coulomb", "gravity mean", "skew", "viscous"} <= names
    for name in ("coulomb", "skew", "viscous"):
        with pytest.raises(ValueError, match="reversal"):
            fit.interval(name)


def test_without_an_inertia_no_stiffness_is_given_and_that_is_said_first():
    log, truth = joint_logs.made(4)
    fit = sw.identify_log(log, gear=truth["gear"])
    assert not fit.usable
    assert fit.project is None
    assert fit.tied[0][0][:2] == ("load inertia", "K1")
    assert fit.headline().startswith("Without the load's inertia or a torque no stiffness can be known")
    for name in ("K1", "B", "coulomb", "gravity"):
        with pytest.raises(ValueError, match="load's inertia"):
            fit.value(name)
    assert fit.value("skew") == pytest.approx(truth["skew"], abs=1e-5)


def test_readings_that_rest_between_counts_scatter_by_their_counts():
    joint = found(4)[0].answer.joint
    (piece,), (left,) = joint.pieces, joint.residuals()
    count = 2.0 * np.pi / 2**14
    rounded = replace(piece, value=np.round((piece.value - left) / count) * count, counts=np.array([count, 0.0]))
    assert scatter(replace(joint, pieces=(rounded,))) == pytest.approx(count / np.sqrt(12.0), rel=0.05)


def test_a_line_of_both_turns_counts_where_it_is_as_sure_as_one_that_was_looked_for():
    for pair, deviations, counts in (((2, 0), 4.0, True), ((2, 2), 4.0, False), ((2, 2), 7.0, True)):
        estimates = SimpleNamespace(values={f"line({pair[0]}, {pair[1]})": deviations}, covariance=np.eye(1))
        answer = SimpleNamespace(estimates=estimates, joint=SimpleNamespace(weights=np.ones(1000)))
        assert is_certain(answer, pair) is counts


@pytest.mark.parametrize(("seed", "times"), [(2, 10.0), (7, 10.0), (2, 3.0), (7, 3.0), (4, 0.1), (4, 0.01)])
def test_an_inertia_far_off_is_said_not_to_fit(seed, times):
    log, truth = joint_logs.made(seed)
    fit = sw.identify_log(log, gear=truth["gear"], load_inertia=times * truth["J"])
    assert not fit.usable
    (cause,) = fit.causes
    assert f"given load inertia of {times * truth['J']:.3g} kg·m² is wrong" in cause
    near = float(cause.split("near ")[1].split()[0])
    assert near == pytest.approx(truth["J"], rel=0.12)  # as far as K1 is off its datasheet


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda m, q: (q, m), "swapped"),
        (lambda m, _: (m, m), "refer to one shaft"),
        (lambda m, q: (np.degrees(m), q), "in deg"),
        (lambda m, q: (np.degrees(m), np.degrees(q)), "gear allows 4000 rpm; the angles seem to be in deg"),
        (lambda m, q: (m, q / (2.0 * np.pi)), "in rev"),
        (lambda m, q: (m / 0.62, q), "use the gear of the log"),
        (lambda m, q: (0.0 * m, q), "nothing moves"),
        (lambda m, q: (m[:1], q[:1]), "1 samples"),
    ],
)
def test_angles_of_no_such_gear_are_named(change, said):
    log, truth = joint_logs.made(2)
    motor, load = change(log["motor_angle"], log["load_angle"])
    wrong = {"time": log["time"][: len(motor)], "motor_angle": motor, "load_angle": load}
    with pytest.raises(ValueError, match=said):
        sw.identify_log(wrong, gear=truth["gear"], load_inertia=1.0)


def test_arguments_are_checked():
    log = joint_logs.made(2)[0]
    with pytest.raises(ValueError, match="one of the two"):
        sw.identify_log(log, load_inertia=1.0)
    with pytest.raises(ValueError, match="no channel 'motor_angle'"):
        sw.identify_log({"time": log["time"], "load_angle": log["load_angle"]}, gear="CSG-40-50", load_inertia=1.0)
    back = log | {"time": log["time"][::-1]}
    with pytest.raises(ValueError, match="stamps go back"):
        sw.identify_log(back, gear="CSG-40-50", load_inertia=1.0)
    with pytest.raises(ValueError, match="load_inertia"):
        sw.identify_log(log, gear="CSG-40-50", load_inertia=-1.0)


def test_a_load_that_turns_against_the_motor_and_a_gap_in_the_log_change_nothing():
    log, truth = joint_logs.made(4)
    keep = (log["time"] < 2.4) | (log["time"] > 2.6)
    other = {name: values[keep] for name, values in log.items()}
    other["load_angle"] = -other["load_angle"]
    fit = sw.identify_log([other], gear=truth["gear"], load_inertia=truth["J"])
    assert len(fit.answer.joint.pieces) == 2
    assert fit.usable
    assert all(covers(fit, truth, name) for name in ("K1", "B", "skew", "gravity"))


def test_angles_with_times_of_their_own_are_compared_at_these(tmp_path):
    log, truth = joint_logs.made(4)
    np.savez(
        tmp_path / "run.npz", motor_angle=log["motor_angle"], motor_angle_time=log["time"],
        load_angle=log["load_angle"][::3], load_angle_time=log["time"][::3],
    )  # fmt: skip
    fit = sw.identify_log(tmp_path / "run.npz", gear=truth["gear"], load_inertia=truth["J"])
    assert sum(len(piece.time) for piece in fit.answer.joint.pieces) == pytest.approx(len(log["time"]) / 3, abs=20)
    assert fit.answer.residual == pytest.approx(truth["floor"], rel=0.05)
    assert all(covers(fit, truth, name) for name in ("K1", "B", "skew", "gravity"))


@pytest.mark.slow
def test_twelve_logs_with_reversals_are_answered():
    answered = within = 0
    covered = []
    for seed in range(1, 13):
        fit, truth, _ = found(seed)
        answered += fit.usable
        rows = joint_logs.errors(fit, truth)
        within += rows["K1"][0] < 0.01
        covered += [inside for _, inside in rows.values()]
    assert answered >= 10
    assert within >= 10
    assert np.mean(covered) > 0.9


@pytest.mark.slow
def test_twelve_logs_of_one_direction_name_what_they_cannot_tell():
    for seed in range(1001, 1013):
        fit, _, _ = found(seed, "runup" if seed % 2 else "constant")
        names = {name for group, _ in fit.tied for name in group}
        assert {"coulomb", "skew"} <= names
        assert not {"coulomb", "skew", "viscous"} & set(fit.values)


@pytest.mark.slow
def test_twelve_machines_outside_the_class_are_refused_or_named_and_not_misnamed():
    kinds = ("gap", "asymmetry", "drag", "resonance")
    drives = [kinds[seed % 4] for seed in range(2001, 2013)]
    fits = [found(seed, outside=kind)[0] for seed, kind in zip(range(2001, 2013), drives, strict=True)]
    assert all(joint_logs.warned(fit, kind) for fit, kind in zip(fits, drives, strict=True))
    assert "drag" in fits[1].causes[0]
    assert "vibration near" in fits[2].causes[0]
    assert "backlash" in fits[3].causes[0]
    assert "asymmetry" in fits[4].causes[0]
    rings = {
        kind for fit, kind in zip(fits, drives, strict=True) if any("vibration near" in cause for cause in fit.causes)
    }
    assert rings == {"resonance"}
