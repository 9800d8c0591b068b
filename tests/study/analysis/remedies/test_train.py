"""Remedies of a whole drive train against linear algebra: motor with loop, gear, coupling, load, written by hand."""

from dataclasses import replace
from math import pi

import numpy as np
import pytest
from direct_project import project_of

import strainwave as sw
from strainwave.drive.train_curve import train_curve
from strainwave.model.train.controls import PositionLoop, SpeedLoop, from_bandwidth, tuning_of
from strainwave.model.train.filters import around
from strainwave.model.train.shafts import Elastic, Load
from strainwave.study.analysis.design_variables import Subject, design_variables, stiffer
from strainwave.study.analysis.remedies import neighbours, remedies, with_gear
from strainwave.study.speed_map.avoid import speeds_to_avoid
from strainwave.study.speed_map.error_equation import operating_point

# the torsion stays far below the first kink of the gear, so that its law is the line K1
A2, A4 = 4e-7, 2e-7
GEAR = sw.catalogue.gear("CSG-40-50")
HAND = {
    "J_m": 4.5e-4, "N": 50.0, "K": GEAR.K1, "B": 20.0, "J_g": 0.05, "K_c": 2e5, "B_c": 5.0, "J_l": 1.3,
    "bandwidth": 30.0, "damping": 0.7, "A2": A2, "A4": A4,
}  # fmt: skip
SPEEDS = (90.0, 200.0)


def oscillation(omega, hand):
    """Largest pointing error of the linear train over a turn of the motor, at speeds of it."""
    p = {**HAND, **hand}
    J = p["J_m"] + (p["J_g"] + p["J_l"]) / p["N"] ** 2
    J, w = hand.get("inertia", J), 2.0 * pi * p["bandwidth"]
    K_p, K_d = J * w * w, 2.0 * p["damping"] * J * w
    angles = 2.0 * pi * np.arange(720) / 720
    error = 0.0
    for order, amplitude in ((2, p["A2"]), (4, p["A4"])):
        s = 1j * order * omega
        gear, coupling, none = p["B"] * s + p["K"], p["B_c"] * s + p["K_c"], 0.0 * s
        # motor, output of the gear, load; the torsion is motor/N - output - e
        rows = [
            [p["J_m"] * s * s + K_d * s + K_p + gear / p["N"] ** 2, -gear / p["N"], none],
            [-gear / p["N"], p["J_g"] * s * s + gear + coupling, -coupling],
            [none, -coupling, p["J_l"] * s * s + coupling],
        ]
        forced = amplitude * np.array([gear / p["N"], -gear, none]).T
        load = np.linalg.solve(np.moveaxis(np.array(rows), 2, 0), forced[:, :, None])[:, 2, 0]
        error = error + np.real(load[:, None] * np.exp(1j * order * angles))
    return np.max(np.abs(error), axis=1)


def top(hand=None, speeds=SPEEDS):
    omega = np.linspace(*speeds, 4001)
    sizes = oscillation(omega, hand or {})
    return float(omega[np.argmax(sizes)]), float(np.max(sizes))


def train_of(gear=GEAR, control=None):
    drive = sw.Drive(HAND["J_m"], HAND["J_l"], HAND["N"], HAND["B"], gear.law)
    error = sw.KinematicError((sw.Line(2, A2), sw.Line(4, A4)))
    inertia = HAND["J_m"] + (HAND["J_g"] + HAND["J_l"]) / HAND["N"] ** 2
    if control is None:
        control = from_bandwidth(2.0 * pi * HAND["bandwidth"], inertia, HAND["damping"])
    train = drive.train(kinematic_error=error, omega=100.0, control=control)
    train = train._replace(load=Elastic(HAND["J_g"], HAND["B_c"], sw.Linear(HAND["K_c"]), train.load))
    return drive._replace(J_l=HAND["J_l"] + HAND["J_g"]), train


def subject_of(control=None):
    drive, train = train_of(control=control)
    project = project_of(drive, SPEEDS, gear=GEAR, kinematic_error=train.error)
    return Subject(project.system(100.0), train, SPEEDS, project)


@pytest.fixture(scope="module")
def tried():
    subject = subject_of()
    response = train_curve(subject.train, SPEEDS)
    avoid = speeds_to_avoid(subject.system, response, operating_point(subject.system))
    found, _ = remedies(subject, response, avoid, 100.0)
    return found, avoid


def of_gear(gear):
    J_m = HAND["J_m"] + gear.input_inertia - GEAR.input_inertia
    return {"J_m": J_m, "N": float(gear.ratio), "K": gear.K1, "B": HAND["B"] * (gear.K1 / GEAR.K1) ** 0.5}


def test_the_peak_of_the_train_is_that_of_linear_algebra(tried):
    _, avoid = tried
    at, size = top()
    assert avoid.largest == pytest.approx(size, rel=2e-3)
    assert avoid.at == pytest.approx(at, rel=1e-2)  # that of the nearest point of the curve


def test_each_remedy_does_what_linear_algebra_says(tried):
    found, avoid = tried  # with the gains of the loop that the drive has
    inertia = HAND["J_m"] + (HAND["J_g"] + HAND["J_l"]) / HAND["N"] ** 2
    names = {
        "bandwidth of the loop": "bandwidth", "damping of the loop": "damping", "inertia of the load": "J_l",
        "damping of the gear": "B", "stiffness of the gear": "K", "damping of the coupling": "B_c",
        "stiffness of the coupling": "K_c", "kinematic error of order 2": "A2", "kinematic error of order 4": "A4",
    }  # fmt: skip
    seen = set()
    for remedy in found:
        if remedy.gear:
            gear = sw.catalogue.gear(remedy.gear)
            faster = gear.ratio / GEAR.ratio
            at, size = top(of_gear(gear) | {"inertia": inertia}, (faster * SPEEDS[0], faster * SPEEDS[1]))
        else:
            name = names[remedy.what]
            at, size = top({name: (1.0 + remedy.share) * HAND[name], "inertia": inertia})
        assert remedy.ratio == pytest.approx(size / top()[1], rel=3e-3, abs=1e-3), remedy
        if remedy.share != -1.0:
            assert remedy.at == pytest.approx(at, rel=1e-2), remedy
        seen.add(remedy.gear or remedy.what)
    assert seen >= {"bandwidth of the loop", "damping of the loop", "inertia of the load", "CSG-45-50", "CSG-40-80"}
    assert avoid.at > 0.0


@pytest.mark.parametrize("kind", ["position", "speed"])
@pytest.mark.parametrize("lag", [0.0, 1e-4])
def test_bandwidth_and_damping_are_those_that_the_loop_is_specified_by(kind, lag):
    _, train = train_of()
    inertia = train.loop_inertia
    assert inertia == pytest.approx(HAND["J_m"] + (HAND["J_l"] + HAND["J_g"]) / 2500.0, rel=1e-12)
    subject = subject_of(from_bandwidth(2.0 * pi * 30.0, inertia, 0.7, kind=kind, lag=lag))
    first, second, *_ = design_variables(subject, float, 100.0)
    assert (first.what, first.value, first.unit) == ("bandwidth of the loop", pytest.approx(30.0), "Hz")
    assert (second.what, second.value, second.unit) == ("damping of the loop", pytest.approx(0.7), "")
    for variable, wanted in ((first, (33.0, 0.7)), (second, (30.0, 0.77))):
        tuning = tuning_of(variable.changed_by(0.1).train.motor.control, inertia)
        assert (tuning.bandwidth / (2.0 * pi), tuning.damping) == pytest.approx(wanted)
        assert (tuning.kind, tuning.lag) == (kind, lag)


def test_a_bandwidth_beyond_half_the_inverse_lag_is_refused_with_a_reason():
    _, train = train_of()
    lag = 0.48 / (2.0 * pi * 30.0)
    subject = subject_of(from_bandwidth(2.0 * pi * 30.0, train.loop_inertia, 0.7, lag=lag))
    first = next(iter(design_variables(subject, float, 100.0)))
    assert "above half the inverse lag" in first.changed_by(0.1)
    assert isinstance(first.changed_by(-0.1), Subject)


@pytest.mark.parametrize("encoder", ["load", "both"])
def test_an_encoder_of_the_load_leaves_the_lag_inside_it(encoder):
    _, train = train_of()
    tuning = from_bandwidth(2.0 * pi * 30.0, train.loop_inertia, 0.7, kind="cascade", lag=0.48 / (2.0 * pi * 30.0))
    control = around(tuning.loop, tuning.lag, encoder=encoder, mixing_frequency=100.0)
    first = next(iter(design_variables(subject_of(control), float, 100.0)))
    assert "above half the inverse lag" in first.changed_by(0.1)


def test_a_gain_without_which_there_is_no_bandwidth_or_damping_is_left_alone():
    names = [
        [variable.what for variable in design_variables(subject_of(control), float, 100.0) if "loop" in variable.what]
        for control in (PositionLoop(50.0, 0.0), SpeedLoop(0.5), sw.train.Held())
    ]
    assert names == [["bandwidth of the loop"], ["bandwidth of the loop"], []]


def test_a_loop_of_a_users_class_is_changed_as_that_which_it_inherits_from():
    class Own(PositionLoop):
        pass

    first, second, *_ = design_variables(subject_of(Own(50.0, 0.5)), float, 100.0)
    assert first.changed_by(1.0).train.motor.control == Own(200.0, 1.0)
    assert second.changed_by(1.0).train.motor.control == Own(50.0, 1.0)


def test_every_coupling_of_a_chain_has_its_stiffness_and_damping():
    subject = subject_of()
    chain = Elastic(0.1, 1.0, sw.Linear(1e5), Elastic(0.2, 0.0, sw.Linear(2e5), Load(1.0)))
    subject = subject._replace(train=subject.train._replace(load=chain))
    found = {
        variable.what: variable for variable in design_variables(subject, float, 100.0) if "coupling" in variable.what
    }
    assert sorted(found) == ["damping of the coupling 1", "stiffness of the coupling 1", "stiffness of the coupling 2"]
    assert pytest.approx(2.2e5) == found["stiffness of the coupling 2"].changed_by(0.1).train.load.load.law.K
    assert pytest.approx(1.1e5) == found["stiffness of the coupling 1"].changed_by(0.1).train.load.law.K
    assert pytest.approx(1.3) == found["damping of the coupling 1"].changed_by(0.3).train.load.B


def test_the_neighbours_of_a_gear_are_of_its_series():
    found = {what: gear.name for what, gear in neighbours(sw.catalogue.gear("CSG-40-80"))}
    assert found == {
        "next size of the gear": "CSG-45-80", "next larger ratio of the gear": "CSG-40-100",
        "next smaller ratio of the gear": "CSG-40-50",
    }  # fmt: skip
    assert [what for what, _ in neighbours(sw.catalogue.gear("CSG-65-160"))] == ["next smaller ratio of the gear"]


def test_another_gear_keeps_hysteresis_loop_and_speeds_of_the_load():
    subject = subject_of()
    law = sw.Parallel(GEAR.law, sw.BoucWen(6e4, 0.0, 8e-5))
    project = replace(subject.project, subject=subject.project.subject._replace(law=law))
    changed = with_gear(subject, project, sw.catalogue.gear("CSG-40-80"))
    train = changed.train
    assert changed.speeds == pytest.approx((1.6 * SPEEDS[0], 1.6 * SPEEDS[1]))
    assert train.law == law._replace(first=sw.catalogue.gear("CSG-40-80").law)
    assert (train.N, changed.system.law) == (80.0, train.law)
    assert train.motor.control == subject.train.motor.control


def test_ratios_of_one_stiffness_are_other_gears_too_and_a_law_of_the_users_own_has_none():
    old, new = sw.catalogue.gear("CSG-40-80"), sw.catalogue.gear("CSG-40-100")
    assert old.law == new.law
    subject = subject_of()
    drive = subject.project.subject._replace(N=80.0, law=old.law)
    changed = with_gear(subject, replace(subject.project, gear=old, subject=drive), new)
    assert (100.0, HAND["B"]) == (changed.train.N, changed.train.B)
    assert changed.speeds == pytest.approx((1.25 * SPEEDS[0], 1.25 * SPEEDS[1]))
    own = replace(subject.project, gear=old, subject=drive._replace(law=sw.Linear(1e5)))
    assert with_gear(subject, own, new) == "the torsion law of the drive is not that of the catalogue"


def test_a_gear_that_may_not_turn_so_fast_is_refused_with_its_limit():
    subject = subject_of()._replace(speeds=(100.0, 400.0))
    assert with_gear(subject, subject.project, sw.catalogue.gear("CSG-40-80")) == (
        "its input speed is limited to 4000 rpm"
    )


def test_the_error_of_an_accuracy_class_follows_the_gear():
    old, new = sw.catalogue.gear("CSG-17-50"), sw.catalogue.gear("CSG-20-50")
    drive = sw.Drive(1e-4, 0.1, 50.0, 1.0, old.law)
    error = sw.gears.accuracy_spectrum(old.accuracy)
    project = project_of(drive, SPEEDS, gear=old, kinematic_error=error)
    subject = Subject(project.system(100.0), None, SPEEDS, project)
    lines = with_gear(subject, project, new).system.error.lines
    assert [line.amplitude for line in lines] == pytest.approx(
        [line.amplitude * 2.9 / 4.4 for line in error.lines], rel=1e-9
    )
    measured = subject._replace(system=subject.system._replace(error=sw.KinematicError((sw.Line(2, 1e-4),))))
    assert with_gear(measured, project, new).system.error.lines == (sw.Line(2, 1e-4),)


def test_a_stiffer_law_has_more_torque_at_every_torsion():
    x = np.linspace(-0.01, 0.01, 7)
    for law in (GEAR.law, sw.Cubic(1e5, 6.9e4)):
        assert stiffer(law, 0.3).torque(x) == pytest.approx(1.3 * law.torque(x), rel=1e-12)
    assert stiffer(sw.Polynomial((0.0, 1e5, 0.0, 1e9)), 0.3) is None
