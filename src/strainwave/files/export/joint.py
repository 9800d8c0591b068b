"""A drive train as the joint of a robot simulator: MJCF (MuJoCo) and URDF, with what these formats cannot carry.

All numbers are in SI on the output side: a motor behind the ratio N has the inertia N^2 J_m, the friction N T.
"""

from dataclasses import dataclass, field
from typing import Any

from ...archive import version
from ...law import spring_stiffness, states_of
from ...model.excitation import NoError
from ...model.laws.friction import Coulomb, LuGre, Stribeck, Viscous
from ...model.laws.hysteresis import Parallel
from ...model.laws.meshing import NoFriction
from ...model.laws.springs import Linear
from ...model.train.drive_train import DriveTrain
from .xml_text import child, element, written

SMALL = "1e-09"  # kg*m^2 of the rotor's body: its inertia is the armature of its joint, and MuJoCo refuses 0


@dataclass
class Joint:
    """What both formats can say of a train, on the output side, and what they leave out.

    Attributes
    ----------
    ratio, stiffness, damping : float
        N, the slope of the gear's law at rest [N*m/rad], B [N*m*s/rad].
    armature, inertia : float
        N^2 J_m, and the inertia behind the gear [kg*m^2].
    dry, viscous : (float, float)
        Friction [N*m] and damping [N*m*s/rad] of motor and load.
    lost : list of str
        What is left out, in words.
    """

    ratio: float
    stiffness: float
    damping: float
    armature: float
    inertia: float
    dry: tuple[float, float] = (0.0, 0.0)
    viscous: tuple[float, float] = (0.0, 0.0)
    lost: list[str] = field(default_factory=list)


def joint_of(train: DriveTrain) -> Joint:
    """Numbers of a train that a joint can have."""
    N, end = train.N, train.load.end()
    inertia = end.J + sum(J for J, _, _ in train.load.chain())
    stiffness = float(spring_stiffness(train.law, 0.0))
    motor, load = _friction(train.motor.drag), _friction(end.drag)
    joint = Joint(N, stiffness, train.B, N * N * train.motor.J, inertia)
    joint.dry, joint.viscous = (N * motor[0], load[0]), (N * N * motor[1], load[1])
    joint.lost += (
        _left_out(train) + [f"{name} of the motor" for name in motor[2]] + [f"{n} of the load" for n in load[2]]
    )
    return joint


def _friction(law: Any) -> tuple[float, float, list[str]]:
    """Dry friction [N*m] and viscous damping [N*m*s/rad] of a drag, and the laws that are neither."""
    if isinstance(law, Parallel):
        parts = _friction(law.first), _friction(law.second)
        return parts[0][0] + parts[1][0], parts[0][1] + parts[1][1], parts[0][2] + parts[1][2]
    if isinstance(law, Viscous):
        return 0.0, float(law.torque(0.0, 1.0)), []
    if isinstance(law, Coulomb | Stribeck | LuGre):
        viscous, kept = (law.sigma_2, " and sigma_2") if isinstance(law, LuGre) else (0.0, "")
        return (
            law.T_c,
            viscous,
            [] if isinstance(law, Coulomb) else [f"{type(law).__name__} friction but its T_c{kept}"],
        )
    return 0.0, 0.0, [] if law == Linear(0.0) else [f"{type(law).__name__} drag"]


def _left_out(train: DriveTrain) -> list[str]:
    """Parts of a train that no joint has."""
    lost = []
    if not isinstance(train.error, NoError):
        lost.append("the kinematic error")
    if states_of(train.law):
        lost.append("the hysteresis of the gear")
    elif not isinstance(train.law, Linear):
        lost.append(f"the torsion law {type(train.law).__name__} but its slope at rest")
    if not isinstance(train.friction, NoFriction):
        lost.append("the friction of the meshing, a share of the torque")
    if train.load.couplings():
        lost.append("the couplings behind the gear, which are taken as rigid")
    if not train.motor.free:
        lost.append("the control loop of the motor")
    return lost


def mjcf(train: DriveTrain, name: str) -> str:
    """Text of an MJCF file: motor and load as two joints of one parent, the gear as a spring between them."""
    joint = joint_of(train)
    root = element("mujoco", {"model": name})
    world = child(root, "worldbody")
    for i, (shaft, mass, inertia, armature) in enumerate(
        (("motor", "1e-06", SMALL, joint.armature), ("load", "1", repr(joint.inertia), 0.0))
    ):
        body = child(world, "body", name=f"{name}_{shaft}")
        child(body, "inertial", pos="0 0 0", mass=mass, diaginertia=" ".join([inertia] * 3))
        own = {"armature": repr(armature), "damping": repr(joint.viscous[i]), "frictionloss": repr(joint.dry[i])}
        child(body, "joint", name=f"{name}_{shaft}", type="hinge", axis="0 0 1", **own)
    spring = {"stiffness": repr(joint.stiffness), "damping": repr(joint.damping), "springlength": "0"}
    gear = child(child(root, "tendon"), "fixed", name=f"{name}_gear", **spring)
    child(gear, "joint", joint=f"{name}_motor", coef="1")
    child(gear, "joint", joint=f"{name}_load", coef="-1")
    child(child(root, "actuator"), "motor", name=f"{name}_torque", joint=f"{name}_motor", gear=repr(joint.ratio))
    return written(root, _comment(joint, [
        f"Angles and torques are on the output side: {name}_motor is the motor's angle over {joint.ratio:g}.",
        f"The control of {name}_torque is the torque of the motor [N*m]; gear multiplies it by the ratio.",
        "A flexible gear takes two joints. For a rigid one put armature, damping and frictionloss on the load's joint.",
        "Masses are placeholders, and so is the shape of the load: its inertia about the axis counts.",
    ]))  # fmt: skip


def urdf(train: DriveTrain, name: str) -> str:
    """Text of a URDF file: the rigid joint with its friction and its ratio."""
    joint = joint_of(train)
    joint.lost[:0] = [
        f"the inertia of the motor, {joint.armature:.6g} kg*m^2 on the output side (MuJoCo's armature)",
        f"the stiffness of the gear, {joint.stiffness:.6g} N*m/rad, and its damping, {joint.damping:.6g} N*m*s/rad",
    ]
    root, J = element("robot", {"name": name}), repr(joint.inertia)
    child(root, "link", name=f"{name}_base")
    inertial = child(child(root, "link", name=f"{name}_load"), "inertial")
    child(inertial, "mass", value="1")
    child(inertial, "inertia", ixx=J, ixy="0", ixz="0", iyy=J, iyz="0", izz=J)
    hinge = child(root, "joint", name=name, type="continuous")
    child(hinge, "parent", link=f"{name}_base")
    child(hinge, "child", link=f"{name}_load")
    child(hinge, "axis", xyz="0 0 1")
    child(hinge, "dynamics", damping=repr(sum(joint.viscous)), friction=repr(sum(joint.dry)))
    transmission = child(root, "transmission", name=f"{name}_gear")
    child(transmission, "type", "transmission_interface/SimpleTransmission")
    child(transmission, "joint", name=name)
    child(child(transmission, "actuator", name=f"{name}_motor"), "mechanicalReduction", repr(joint.ratio))
    return written(root, _comment(joint, [
        "Damping and friction are those of motor and load together, on the output side, of a rigid gear.",
        "The mass is a placeholder, and so is the shape of the load: its inertia about the axis counts.",
    ]))  # fmt: skip


def _comment(joint: Joint, facts: list[str]) -> str:
    lines = [f"Written by strainwave {version()}; SI units.", *facts, "Left out, as the format does not have it:"]
    return "\n".join(f"  {line}" for line in lines + ([f"- {what}" for what in joint.lost] or ["- nothing"]))
