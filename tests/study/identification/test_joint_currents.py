"""What a current or a torque tells `identify_log`: samples of benchmarks/joint_logs.py, and of SciPy's."""

import sys
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from measured_axis import GRAVITY, J_L, J_M, K1, K2, T1, B, angles, current, measured
from scipy.interpolate import make_interp_spline

import strainwave as sw
from strainwave.study.identification.joint.meter import OF_GEAR, OF_MOTOR, meters
from strainwave.study.identification.joint.metered import linear, metered

sys.path.append(str(Path(__file__).resolve().parents[3] / "benchmarks"))
import joint_logs

pytestmark = pytest.mark.slow
SHAFT = ("motor_inertia", "motor_coulomb", "motor_viscous", "motor_load_friction", "torque_constant", "current_skew")


@cache
def made():
    return joint_logs.made(3002, shaft=True)


@cache
def found():
    """A fit of the angles, to which currents of any kind are added."""
    log, truth = made()
    angles_alone = {name: values for name, values in log.items() if name != "current"}
    return sw.identify_log(angles_alone, gear=truth["gear"], load_inertia=truth["J"])


def told(name, values, constant=None, weighs=False):
    """What a channel beside the fitted angles tells, and what is said of it."""
    answer = found().answer
    meter, said = meters(answer.joint, [made()[0] | {name: values}], OF_MOTOR + OF_GEAR)
    if meter is None:
        return None, said
    fit = metered(meter, linear(meter), answer.estimates.of_free, constant, weighs)
    return fit, said + fit.notes


def covers(fit, truth, name, level=0.9999):
    low, high = fit.interval(name, level)
    return low <= truth[name] <= high


@pytest.mark.parametrize("seed", [3002, 3022])
def test_a_current_gives_its_constant_and_the_motor(seed):
    log, truth = joint_logs.made(seed, shaft=True)
    fit = sw.identify_log(log, gear=truth["gear"], load_inertia=truth["J"])
    assert all(covers(fit, truth, name) for name in (*SHAFT, "K1", "B"))
    assert fit.value("torque_constant") == pytest.approx(truth["torque_constant"], rel=3e-3)
    assert fit.value("motor_inertia") == pytest.approx(truth["motor_inertia"], rel=0.05)
    assert fit.value("motor_coulomb") == pytest.approx(truth["motor_coulomb"], rel=0.05)
    motor, sheet = fit.project.subject.motor, fit.project.motor_limits
    assert (motor.J, sheet.K_t) == pytest.approx((fit.value("motor_inertia"), fit.value("torque_constant")), rel=1e-9)
    assert motor.drag.first.T_c == pytest.approx(fit.value("motor_coulomb"), rel=1e-9)
    assert any("proportional to the load inertia" in line for line in fit.quality())


# M3 of the friction models of Duclusaud et al. 2025 (BAM, arXiv 2410.08650), eRob80 of 100 and 50, on the joint: dry
# [N*m], viscous [N*m*s/rad], share of the torque; their torque of the gearbox is that of both its sides together.
@pytest.mark.parametrize(
    ("seed", "dry", "viscous", "share"),
    [(3002, 4.832, 7.395, 2.0 * 0.148), (3003, 3.467, 1.207, 2.0 * 0.0629)],
)
def test_friction_of_real_joints_comes_back(seed, dry, viscous, share):
    N = joint_logs.GEARS[joint_logs.made(seed)[1]["gear"]][5]
    log, truth = joint_logs.made(seed, shaft=(dry / N, viscous / N**2, share))
    fit = sw.identify_log(log, gear=truth["gear"], load_inertia=truth["J"])
    assert all(covers(fit, truth, name) for name in SHAFT)
    assert fit.value("motor_load_friction") == pytest.approx(share, rel=0.03)
    assert N * fit.value("motor_coulomb") == pytest.approx(dry, rel=0.05)


def test_without_a_current_the_motors_numbers_are_said_to_be_unknown():
    names = {name for group, _ in found().tied for name in group}
    assert {"motor_inertia", "motor_coulomb", "motor_viscous"} <= names
    with pytest.raises(ValueError, match="required: a current or a torque of the motor"):
        found().value("motor_coulomb")


def test_a_torque_of_the_motor_from_scipy_gives_its_inertia_and_one_way_no_dry_friction():
    log = measured()
    fit = sw.identify_log(log | {"motor_torque": current(log, 1.0)}, gear="SHG-25-100", load_inertia=J_L)
    truth = {"motor_inertia": J_M, "torque_scale": 1.0, "motor_viscous": 0.0, "motor_load_friction": 0.0}
    assert all(covers(fit, truth, name) for name in truth)
    assert fit.value("motor_inertia") == pytest.approx(J_M, rel=0.03)
    with pytest.raises(ValueError, match="a reversal of the motor"):
        fit.value("motor_coulomb")


def test_a_torque_at_the_load_gives_the_stiffness_without_an_inertia():
    log = measured()
    t, _, load = angles()
    log["torque"] = J_L * make_interp_spline(t, load, 5)(t, 2) + GRAVITY * np.sin(load) + 0.4
    fit = sw.identify_log(log, gear="SHG-25-100")
    truth = {"load_inertia": J_L, "K1": K1, "K2": K2, "T1": T1, "B": B, "gravity": GRAVITY}
    assert fit.usable
    assert all(covers(fit, truth, name) for name in truth)
    assert fit.value("K1") == pytest.approx(K1, rel=3e-3)
    assert pytest.approx(J_L, rel=3e-3) == fit.project.subject.load.J


def test_a_current_of_known_constant_weighs_the_load_and_one_of_unknown_does_not():
    log, truth = made()
    truth = truth | {"load_inertia": truth["J"]}
    fit = sw.identify_log(log, gear=truth["gear"], torque_constant=truth["torque_constant"])
    assert fit.usable
    assert all(covers(fit, truth, name) for name in ("load_inertia", "K1", "B", "motor_inertia", "gravity"))
    assert fit.value("load_inertia") == pytest.approx(truth["J"], rel=3e-3)
    fit = sw.identify_log(log, gear=truth["gear"])
    assert not fit.usable
    for name in ("K1", "motor_inertia", "torque_constant"):
        with pytest.raises(ValueError, match="load's inertia"):
            fit.value(name)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda i: 0.0 * i + 0.2, "stays at 0.2: it contains no information"),
        (lambda i: np.where(np.arange(len(i)) == 7, i, np.nan), "has 1 samples: it contains no information"),
        (lambda i: np.clip(i, -np.inf, 0.8 * np.max(i)), "seems saturated"),
        (lambda i: 1e3 * i, "seems to be in mA"),
        (lambda i: -i, "the opposite sign"),
    ],
)
def test_a_current_that_cannot_be_is_said(change, said):
    fit, sentences = told("current", change(made()[0]["current"]))
    assert any(said in line for line in sentences)
    if fit is not None and "motor_inertia" in fit.estimates.values:  # neither a sign nor a unit changes the motor
        assert fit.estimates.values["motor_inertia"] == pytest.approx(made()[1]["motor_inertia"], rel=0.05)


def test_torques_that_contradict_what_is_known_are_said():
    log, truth = made()
    torque = truth["torque_constant"] * log["current"]
    assert any("wrong by a factor of 1000" in s for s in told("motor_torque", 1e3 * torque, 1.0)[1])
    assert any("name it torque" in s for s in told("motor_torque", truth["N"] * torque, 1.0)[1])
    assert any("check its unit" in s for s in told("current", log["current"], 1.5 * truth["torque_constant"])[1])
    assert not any("times" in s for s in told("current", log["current"], truth["torque_constant"])[1])


def test_a_current_of_another_motor_gives_no_number():
    noise = np.random.default_rng(0).standard_normal(len(made()[0]["current"]))
    fit, _ = told("current", noise)
    assert not {*SHAFT[:5]} & set(fit.estimates.values)
    assert all("another channel" in fit.estimates.unidentified[name] for name in SHAFT[:5])


def test_a_torque_that_has_nothing_of_the_joint_weighs_nothing():
    log, truth = made()
    noise = np.random.default_rng(0).standard_normal(len(log["current"]))
    fit = sw.identify_log(log | {"torque": 60.0 * noise}, gear=truth["gear"])
    assert not fit.usable
    with pytest.raises(ValueError, match="load's inertia"):
        fit.value("K1")


def test_a_channel_of_another_length_is_refused():
    log, truth = made()
    with pytest.raises(ValueError, match="channel 'current' has the shape"):
        sw.identify_log(log | {"current": log["current"][:1]}, gear=truth["gear"], load_inertia=truth["J"])
    with pytest.raises(ValueError, match="torque_constant"):
        sw.identify_log(log, gear=truth["gear"], torque_constant=-0.1)
