"""A drive train as the joint of a robot simulator: MJCF (MuJoCo), with what this format cannot carry."""

from typing import Any

from ...base.archive import version
from ...base.law import polynomial_of, spring_stiffness, states_of, torque_of
from ...base.protocols import Law, terms_of
from ...drive.project import Project
from ...drive.train_curve import torques_of_angle
from ...model.excitation import NoError
from ...model.laws import Linear
from ...model.laws.friction import Coulomb, LuGre, NoFriction, Stribeck, Viscous
from ...model.laws.hysteresis import BoucWen, Parallel
from ...model.train.drive_train import DriveTrain
from ...numerics.roots import bracketed_root
from .xml_text import child, element, written

LEAST_TWIST, DOUBLINGS = 1e-9, 40  # rad; twists at which the torque of a law is looked for
PLASTIC = (
    "The hysteresis is a spring that yields (springyield), a corner for Bouc-Wen's knee: MuJoCo 4 or later reads it."
)
SMALL = "1e-09"  # kg*m^2 of the rotor's body: its inertia is the armature of its joint, and MuJoCo refuses 0


def _friction(law: Law) -> tuple[float, float, list[str]]:
    """Dry friction [N*m] and viscous damping [N*m*s/rad] of a drag, and the laws that are neither."""
    if isinstance(law, Parallel):
        parts = _friction(law.first), _friction(law.second)
        return parts[0][0] + parts[1][0], parts[0][1] + parts[1][1], parts[0][2] + parts[1][2]
    if isinstance(law, Viscous):
        return 0.0, float(law.torque(0.0, 1.0)), []
    if isinstance(law, Coulomb | Stribeck | LuGre):
        viscous, kept = (law.sigma_2, " and sigma_2") if isinstance(law, LuGre) else (0.0, "")
        lost = [] if isinstance(law, Coulomb) else [f"{type(law).__name__} friction but its T_c{kept}"]
        return law.T_c, viscous, lost
    return 0.0, 0.0, [] if law == Linear(0.0) else [f"{type(law).__name__} drag"]


def _parts(law: Any) -> list[Any]:
    """Laws side by side in the torsion law of a gear."""
    return [*_parts(law.first), *_parts(law.second)] if isinstance(law, Parallel) else [law]


def _yielding(law: Law) -> list[tuple[float, float]]:
    """Stiffness [N*m/rad] of a spring for each Bouc-Wen law of a gear, and the twist [rad] at which it yields."""
    laws = [part for part in _parts(law) if isinstance(part, BoucWen)]
    levels = [part.yield_twist * (part.A / (part.beta + part.gamma)) ** (1.0 / part.n) for part in laws]
    return [((1.0 - part.ratio) * part.K * part.A, top / part.A) for part, top in zip(laws, levels, strict=True)]


def working_torque(source: Any, train: DriveTrain) -> float:
    """Largest torque [N*m] that the load puts on the gear, the lines of a torque left out."""
    end = train.load.end()
    if isinstance(source, Project):
        return float(max(map(abs, source.load_torques)))
    mean = sum(getattr(term, "mean", 0.0) for term in terms_of(end.excitation))
    return float(max(abs(mean + torque) for torque in torques_of_angle(end.drag)))


def _twist(law: Law, torque: float) -> float:
    """Twist [rad] at which springs, and what stays of a hysteresis after it yields, carry a torque of at least 0 [N*m].

    0 where they do not carry it.
    """

    def carried(x: float) -> float:
        springs = (torque_of(part, x, 0.0, ()) for part in _parts(law) if not states_of(part))
        after_yield = (part.ratio * part.K * x for part in _parts(law) if isinstance(part, BoucWen))
        return float(sum(springs) + sum(after_yield))

    twists = (2.0**k * LEAST_TWIST for k in range(DOUBLINGS))
    high = next((x for x in twists if carried(x) >= torque), 0.0)
    return 0.0 if torque == 0.0 else bracketed_root(lambda x: carried(x) - torque, 0.0, high, xtol=0.0) if high else 0.0


def _left_out(train: DriveTrain, torque: float) -> list[str]:
    """Parts of a train that no joint has; `torque` [N*m] is that at which the slope of its law is taken."""
    springs = [part for part in _parts(train.law) if not isinstance(part, BoucWen)]
    curved = [type(part).__name__ for part in springs if any((polynomial_of(part) or (0.0, 0.0, 1.0))[2:])]
    where = f"at {torque:.4g} N*m" if torque else "at rest"
    parts = {
        "the kinematic error": not isinstance(train.error, NoError),
        "the hysteresis of the gear": states_of(train.law) > len(_yielding(train.law)),
        f"the torsion law {' and '.join(curved)} but its slope {where}": bool(curved),
        "the friction of the meshing, a share of the torque": not isinstance(train.friction, NoFriction),
        "the couplings behind the gear, which are taken as rigid": bool(train.load.couplings()),
        "the control loop of the motor": not train.motor.free,
    }
    return [part for part, lost in parts.items() if lost]


def mjcf(train: DriveTrain, name: str, torque: float = 0.0) -> tuple[str, tuple[str, ...]]:
    """Text of an MJCF file, and notes: motor and load as two joints of one parent, the gear as springs between them.

    All is on the output side. A spring has the slope of the gear's law at a `torque` [N*m]; each Bouc-Wen law is one
    more, which is ideally plastic beyond the twist at which it yields.
    """
    N, end = train.N, train.load.end()
    motor, load = _friction(train.motor.drag), _friction(end.drag)
    root = element("mujoco", {"model": name})
    world = child(root, "worldbody")
    for shaft, mass, inertia, armature, viscous, dry in (
        ("motor", "1e-06", SMALL, N * N * train.motor.J, N * N * motor[1], N * motor[0]),
        ("load", "1", repr(train.load_inertia), 0.0, load[1], load[0]),
    ):
        body = child(world, "body", name=f"{name}_{shaft}")
        child(body, "inertial", pos="0 0 0", mass=mass, diaginertia=" ".join([inertia] * 3))
        attributes = {"armature": repr(armature), "damping": repr(viscous), "frictionloss": repr(dry)}
        child(body, "joint", name=f"{name}_{shaft}", type="hinge", axis="0 0 1", **attributes)
    slope, plastic = float(spring_stiffness(train.law, _twist(train.law, torque))), _yielding(train.law)
    springs = [{"stiffness": repr(slope), "damping": repr(train.B)}]
    springs += [{"stiffness": repr(K), "springyield": repr(twist)} for K, twist in plastic]
    tendon = child(root, "tendon")
    for i, spring in enumerate(springs):
        gear = child(tendon, "fixed", name=f"{name}_gear{'_' * bool(i)}{i or ''}", springlength="0", **spring)
        child(gear, "joint", joint=f"{name}_motor", coef="1")
        child(gear, "joint", joint=f"{name}_load", coef="-1")
    child(child(root, "actuator"), "motor", name=f"{name}_torque", joint=f"{name}_motor", gear=repr(N))
    of_shafts = [f"{what} of the {shaft}" for shaft, drag in (("motor", motor), ("load", load)) for what in drag[2]]
    lost = [*_left_out(train, torque), *of_shafts]
    remarks = [PLASTIC] if plastic else []
    text = written(root, "\n".join(f"  {line}" for line in [
        f"Written by strainwave {version()}; SI units.",
        f"Angles and torques are on the output side: {name}_motor is the motor's angle over {N:g}.",
        f"The control of {name}_torque is the torque of the motor [N*m]; gear multiplies it by the ratio.",
        "A flexible gear takes two joints. For a rigid one put armature, damping and frictionloss on the load's joint.",
        "Masses are placeholders, and so is the shape of the load: its inertia about the axis counts.",
        *remarks,
        "Omitted, because the format does not support it:",
        *([f"- {what}" for what in lost] or ["- nothing"]),
    ]))  # fmt: skip
    return text, (*remarks, f"omitted, because the format does not support it: {'; '.join(lost) or 'nothing'}")
