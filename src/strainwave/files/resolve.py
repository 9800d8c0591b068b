"""The parts of a drive from the fields of its project file, in SI: speeds, excitation, damping, the whole train."""

from typing import Any

from ..model.drive import Drive
from ..model.excitation import Harmonic, Harmonics, KinematicError, Line
from ..model.gears.error_spectrum import accuracy_spectrum
from ..model.train.controls import FREE, Held
from ..model.train.drive_train import DriveTrain
from ..model.train.shafts import NO_DRAG, Elastic
from ..quantities import checked
from ..speeds import Speeds
from .contradictions import train_fields
from .loop_fields import control_of
from .schema import LoadSpec, LoadTorqueSpec, ProjectSpec, SpeedSpec, TorqueRange, TorqueSpec

FROM_REST = 0.01  # of the end of a range from 0: where it begins


def kinematic_error(spec: ProjectSpec, accuracy: float | None) -> KinematicError | None:
    """Lines of the file, or those of an accuracy class [rad]."""
    if accuracy is not None:
        return accuracy_spectrum(accuracy)
    error = tuple(Line(line.order, line.amplitude, line.phase) for line in spec.excitation.kinematic_error)
    return KinematicError(error) if error else None


def speeds(spec: SpeedSpec, ratio: float) -> Speeds:
    """The range or the single speeds, of the base angle."""
    factor = ratio if spec.shaft == "load" else 1.0
    if spec.high is not None and spec.low == 0.0:
        return Speeds((FROM_REST * factor * spec.high, factor * spec.high), (), spec.shaft, factor)
    given = sorted({factor * s for s in spec.at or (spec.low, spec.high) if s is not None})
    if spec.at is not None:
        return Speeds.at(tuple(given), spec.shaft, factor)
    return Speeds((given[0], given[-1]), (), spec.shaft, factor)


def torque(spec: TorqueSpec | LoadTorqueSpec | None) -> Harmonics | None:
    """A torque [N*m] with its mean, the middle of a range of means, in the first line."""
    if spec is None or (not spec.lines and not spec.mean):
        return None
    lines = [Harmonic(line.amplitude, line.order, line.phase) for line in spec.lines] or [Harmonic(0.0)]
    mean = 0.5 * (spec.mean.low + spec.mean.high) if isinstance(spec.mean, TorqueRange) else spec.mean
    return Harmonics((lines[0]._replace(mean=mean), *lines[1:]))


def mean_range(spec: LoadTorqueSpec | None) -> tuple[float, float] | None:
    """Least and largest mean [N*m] of a torque that has a range of them."""
    return (spec.mean.low, spec.mean.high) if spec is not None and isinstance(spec.mean, TorqueRange) else None


def whole_inertia(load: LoadSpec) -> float:
    """Inertia [kg*m^2] of the load with what sits before its couplings: that of a rigid load."""
    return load.inertia + sum(coupling.inertia for coupling in load.chain)


def damping(spec: ProjectSpec, drive: Drive) -> float:
    """B [N*m*s/rad]; a ratio and a quality refer to omega_0 of the spring at rest in the project's mode.

    That spring is the catalogue's K1, or `spring_stiffness` of the law: what hysteresis adds until it yields is not in
    it. The inertia is that of the mode: the load's with the motor held, the reduced one with the motor free.
    """
    if spec.damping.B is not None:
        return spec.damping.B
    ratio = spec.damping.ratio if spec.damping.quality is None else 0.5 / spec.damping.quality
    J, omega_0 = (drive.J, drive.omega_0) if spec.motor.mode == "free" else (drive.J_l, drive.omega_0_held)
    return 2.0 * (ratio or 0.0) * J * omega_0


def loop_inertia(drive: Drive) -> float:
    """Inertia [kg*m^2, motor side] that a loop turns: the motor, and the rigid load over N^2."""
    return drive.J_m + drive.J_l / (drive.N * drive.N)


def whole_train(spec: ProjectSpec, drive: Drive, error: KinematicError | None, omega: float) -> DriveTrain:
    """The train with all that the file has, at a motor speed [rad/s]."""
    control: Any = FREE if spec.motor.mode == "free" else Held()
    if spec.motor.loop is not None:
        control = control_of(spec.motor.loop, loop_inertia(drive))
    train = drive._replace(J_l=spec.load.inertia).train(
        motor_torque=torque(spec.excitation.motor_torque),
        load_torque=torque(spec.excitation.load_torque),
        kinematic_error=error,
        omega=omega,
        control=control,
        motor_drag=spec.motor.drag or NO_DRAG,
        load_drag=spec.load.drag or NO_DRAG,
    )
    for coupling in reversed(spec.load.chain):
        train = train._replace(load=Elastic(coupling.inertia, coupling.B, coupling.law, train.load))
    whole: DriveTrain = checked(train)
    return whole


def beyond_equation(spec: ProjectSpec, error: KinematicError | None) -> bool:
    """Whether the whole train holds more than the error equation: its fields, or the ripple of a free motor."""
    return bool(train_fields(spec)) or (spec.motor.mode == "free" and error is not None)
