"""Parts of a drive train that its error equation leaves out."""

from ...base.protocols import lines_of
from ...model.laws.friction import NO_FRICTION
from ...model.train.drive_train import DriveTrain
from ...model.train.motion import AngleTorque
from ...model.train.shafts import NO_DRAG

LOOP_PART = "the motor's loop"


def left_out(train: DriveTrain) -> tuple[str, ...]:
    """Parts of a train that its error equation does not hold and that change the dynamic error, in words.

    That equation has a motor ideally held or free, the gear, and a rigid load. The drag of a motor that is ideally held
    changes nothing: the motor keeps its speed whatever opposes it. What a free motor does with the kinematic error is
    the approximation that `compare_with_train` measures, no part that is missing.
    """
    motor, load = train.motor, train.load.end()
    held, couplings = motor.held, len(train.load.couplings())
    parts = (
        (not held and not motor.free, LOOP_PART),
        (not held and motor.drag != NO_DRAG, "the motor's drag"),
        (not held and train.friction != NO_FRICTION, "the friction of the meshing"),
        (load.drag != NO_DRAG, "the gravity of the load" if isinstance(load.drag, AngleTorque) else "the load's drag"),
        (couplings > 0, "the coupling" if couplings == 1 else f"the {couplings} couplings"),
    )
    return tuple(words for present, words in parts if present)


def beyond_equation(train: DriveTrain) -> bool:
    """True if a train has anything that its error equation has not; for a held motor also what loads that alone."""
    motor = train.motor
    more = motor.drag != NO_DRAG or train.friction != NO_FRICTION or (motor.free and bool(lines_of(train.error)))
    return more or bool(left_out(train))
