"""A joint of a robot simulator: XML that parses, values in SI on the output side, and what is left out."""

from xml.etree import ElementTree as Xml

import numpy as np
import pytest
from scipy.integrate import solve_ivp

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
    twist = np.roots([1e5 * 6.9e4, 0.0, 1e5, -12.0]).real.max()  # K (x + alpha x^3) = 12 N*m of gravity
    slope = 1e5 * (1.0 + 3.0 * 6.9e4 * twist**2)
    assert values(gear, "stiffness", "damping", "springlength") == (pytest.approx(slope, rel=1e-9), 40.0, 0.0)
    assert {j.get("joint"): j.get("coef") for j in gear} == {"elbow_motor": "1", "elbow_load": "-1"}
    assert values(root.find("actuator/motor"), "gear") == (50.0,)


def test_what_the_format_cannot_carry_is_named(tmp_path):
    _, text = written(TRAIN, tmp_path / "elbow.xml")
    for lost in (
        "- the kinematic error", "- the torsion law Cubic but its slope at 12 N*m", "- the control loop of the motor",
        "- the friction of the meshing", "- AngleTorque drag of the load",
        "- LuGre friction but its T_c and sigma_2 of the load",
    ):  # fmt: skip
        assert lost in text
    sliding = PLAIN._replace(law=sw.Parallel(sw.Linear(1e5), sw.laws.LuGre(300.0, 1.0, 0.7, 2.0, 3.0, 0.1)))
    assert "- the hysteresis of the gear" in written(sliding, tmp_path / "h.xml")[1]
    assert "kinematic" not in written(PLAIN, tmp_path / "p.xml")[1]


THREE = sw.laws.PiecewiseLinear(3.1e4, 5e4, 5.7e4, 14.0, 48.0)


@pytest.mark.parametrize(("gravity", "slope"), [(0.0, 3.1e4), (13.9, 3.1e4), (30.0, 5e4), (48.1, 5.7e4)])
def test_the_spring_has_the_slope_at_the_torque_of_the_load(tmp_path, gravity, slope):
    train = DRIVE._replace(law=THREE).train(load_drag=sw.train.AngleTorque(gravity)) if gravity else PLAIN
    train = train._replace(law=THREE)
    root, text = written(train, tmp_path / "axis.xml")
    assert values(root.find("tendon/fixed"), "stiffness") == (slope,)
    assert f"PiecewiseLinear but its slope {f'at {gravity:g} N*m' if gravity else 'at rest'}" in text


def test_hysteresis_is_a_spring_that_yields(tmp_path):
    train = PLAIN._replace(law=sw.Parallel(THREE, sw.BoucWen(4e4, 0.25, 2e-4, A=2.0, n=2)))
    root, text = written(train, tmp_path / "axis.xml")
    elastic, plastic = root.findall("tendon/fixed")
    assert values(elastic, "stiffness") == pytest.approx((3.1e4 + 0.25 * 4e4,))
    stiffness, twist = values(plastic, "stiffness", "springyield")
    assert stiffness == pytest.approx(0.75 * 4e4 * 2.0)  # the slope of the loop at rest
    x = np.linspace(0.0, 40e-4, 40001)  # own integration of z' = A - (z/x_y)^2: the level of its torque
    z = solve_ivp(lambda _, z: 2.0 - (z / 2e-4) ** 2, x[[0, -1]], [0.0], rtol=1e-9, atol=1e-14).y[0, -1]
    assert stiffness * twist == pytest.approx(0.75 * 4e4 * z, rel=1e-6)
    assert "MuJoCo 4 or later" in text
    assert "- the hysteresis" not in text
    bare = written(train._replace(law=THREE), tmp_path / "bare.xml")
    assert len(bare[0].findall("tendon/fixed")) == 1
    assert "MuJoCo 4" not in bare[1]


def test_inertias_of_rigid_couplings_add_up(tmp_path):
    train = PLAIN._replace(load=sw.train.Elastic(0.4, 3.0, sw.Linear(3e5), sw.train.Load(0.9)))
    root, text = written(train, tmp_path / "axis.xml")
    assert root.find("worldbody/body[@name='axis_load']/inertial").get("diaginertia") == "1.3 1.3 1.3"
    assert "- the couplings behind the gear, which are taken as rigid" in text
