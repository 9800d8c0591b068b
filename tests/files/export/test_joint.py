"""A joint of a robot simulator: XML that parses, values in SI on the output side, and what is left out."""

from xml.etree import ElementTree as Xml

import pytest

import strainwave as sw

DRIVE = sw.Drive(J_m=4.5e-4, J_l=1.3, N=50.0, B=40.0, law=sw.Cubic(1e5, 6.9e4))
TRAIN = DRIVE.train(
    kinematic_error=sw.KinematicError((sw.Line(2, 1e-4),)),
    motor_drag=sw.Parallel(sw.laws.Coulomb(0.03), sw.laws.Viscous(2e-4)),
    load_drag=sw.Parallel(sw.laws.LuGre(300.0, 1.0, 0.7, 2.0, 3.0, 0.1), sw.train.AngleTorque(12.0)),
    friction=sw.laws.LoadFriction(0.08),
    control=sw.train.PositionLoop(40.0, 0.4),
)
PLAIN = DRIVE._replace(law=sw.Linear(1e5)).train()


def written(train, path):
    sw.export(train, path, to="mjcf")
    return Xml.parse(path).getroot(), " ".join(path.read_text(encoding="utf-8").split())


def values(element, *names):
    return tuple(float(element.get(name)) for name in names)


def test_mjcf_has_motor_and_load_and_the_gear_between_them(tmp_path):
    root, _ = written(TRAIN, tmp_path / "elbow.xml")
    motor, load = (root.find(f"worldbody/body[@name='elbow_{shaft}']") for shaft in ("motor", "load"))
    joint = motor.find("joint")
    assert values(joint, "armature", "damping", "frictionloss") == pytest.approx((1.125, 0.5, 1.5), rel=1e-12)
    assert values(load.find("joint"), "armature", "damping", "frictionloss") == (0.0, 0.7, 2.0)
    assert load.find("inertial").get("diaginertia") == "1.3 1.3 1.3"
    gear = root.find("tendon/fixed")
    assert values(gear, "stiffness", "damping", "springlength") == (1e5, 40.0, 0.0)
    assert {j.get("joint"): j.get("coef") for j in gear} == {"elbow_motor": "1", "elbow_load": "-1"}
    assert values(root.find("actuator/motor"), "gear") == (50.0,)


def test_what_the_format_cannot_carry_is_named(tmp_path):
    _, text = written(TRAIN, tmp_path / "elbow.xml")
    for lost in (
        "- the kinematic error", "- the torsion law Cubic but its slope at rest", "- the control loop of the motor",
        "- the friction of the meshing", "- AngleTorque drag of the load",
        "- LuGre friction but its T_c and sigma_2 of the load",
    ):  # fmt: skip
        assert lost in text
    hysteretic = PLAIN._replace(law=sw.Parallel(sw.Linear(1e5), sw.BoucWen(2e4, 0.0, 8e-5)))
    assert "- the hysteresis of the gear" in written(hysteretic, tmp_path / "h.xml")[1]
    assert "kinematic" not in written(PLAIN, tmp_path / "p.xml")[1]


def test_inertias_of_rigid_couplings_add_up(tmp_path):
    train = PLAIN._replace(load=sw.train.Elastic(0.4, 3.0, sw.Linear(3e5), sw.train.Load(0.9)))
    root, text = written(train, tmp_path / "axis.xml")
    assert root.find("worldbody/body[@name='axis_load']/inertial").get("diaginertia") == "1.3 1.3 1.3"
    assert "- the couplings behind the gear, which are taken as rigid" in text
