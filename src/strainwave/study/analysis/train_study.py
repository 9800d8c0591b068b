"""The whole drive train beside its error equation: Bode plot, steady motions, and a run-up with its energies.

The same drive with other motors, where nothing says which it has: ideally held, free, and in a position loop.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from ...base.law import depends, spring_stiffness
from ...base.protocols import terms_of
from ...base.results import Floats, SolveError
from ...base.sentences import Sentence
from ...base.terminal import silent
from ...drive.drive_response import DriveResponse
from ...drive.equation.reductions import Reductions, compare_with_train
from ...drive.friction.standstill import Standstill
from ...drive.loops.bode import Bode, bode
from ...drive.operating_point import operating_state
from ...drive.steady import drive_curve
from ...model.excitation import mean_torque
from ...model.gears.gear import Gear
from ...model.train.drive_train import DriveTrain
from ..speed_map.error_equation import OperatingPoint
from ..speed_map.intervals import Span
from ..speed_map.ramp import Ramp, ramp_of
from .time_domain.drive_motion import DriveMotion, train_motion

FREQUENCIES, MOST_HARMONICS = 240, 31
SPEED_GAP = 1e-3  # relative difference of speeds that are looked at once


@dataclass(frozen=True, eq=False)
class MotorCase:
    """The steady motions of a drive with one motor.

    Attributes
    ----------
    name : str
        What drives it, in words.
    drive : DriveResponse or None
        Its motions; None where no curve of them is found.
    """

    name: str
    drive: DriveResponse | None

    @property
    def oscillation(self) -> float:
        """Largest |error - mean| [rad] that a slow run-up or run-down meets; nan without a curve."""
        return float("nan") if self.drive is None else float(self.drive.oscillation[self.drive.top])

    @property
    def omega(self) -> float:
        """Speed [rad/s] of it; nan without a curve."""
        return float("nan") if self.drive is None else float(self.drive.omega[self.drive.top])

    @property
    def jumps(self) -> int:
        """Number of speeds at which a slow run-up or run-down jumps."""
        sweep = None if self.drive is None else self.drive.sweep
        return 0 if sweep is None else len({jump.value for jump in (*sweep.on_run_up, *sweep.on_run_down)})


def motor_cases(
    trains: Mapping[str, DriveTrain], speeds: Span, progress: Callable[[str], None]
) -> Iterator[MotorCase]:  # fmt: skip
    """Follow the motions of a train with every motor through a range of motor speeds [rad/s], told before each."""
    for name, train in trains.items():
        progress(name)
        yield MotorCase(name, drive_curve(train, speeds, coexisting=depends(train.law) == 1))


def spread(cases: tuple[MotorCase, ...]) -> float:
    """Largest oscillation over the smallest; nan where fewer than two motors have a curve."""
    sizes = [case.oscillation for case in cases if case.drive is not None]
    return max(sizes) / min(sizes) if len(sizes) > 1 and min(sizes) > 0.0 else float("nan")


@dataclass(frozen=True, eq=False)
class TrainStudy:
    """Behaviour of the whole train, and of its error equation.

    Attributes
    ----------
    train : DriveTrain
        The train at constant speed.
    curve : DriveResponse or None
        Its steady motions through the range; None where it has none (`has_curve`), or none were found.
    state : (states,) array
        Where the mean torques hold it at `speed`.
    speed : float
        Motor speed [rad/s] of the largest error, at which it is linearised.
    bode : Bode
        Speeds of motor and load over a torque, linear, about that state.
    omega, whole, reduced : (n,) arrays
        Motor speeds [rad/s] where they are compared; largest |error| [rad] of the train on a slow run-up (of a free one
        without a curve |x| across the gear), and |x| of the error equation; nan where there is no motion. Empty where
        nothing is compared.
    ramp : Ramp or None
        Its run-up; None where the motor is free.
    left_out : Reductions or None
        The comparison of a free motor without a curve.
    motions : tuple of DriveMotion or None
        Its own motion at each of the single speeds that the error equation is shown at; None where it has none.
    remarks : tuple of str
        Why a part is missing.
    gravity : (float, float) or None
        Speed [rad/s] and size [rad] of the largest oscillation about the slow mean with gravity exactly in the motion,
        where `curve` leaves it out; None where it is not computed.
    resting : Standstill or None
        Where it rests, and whether it hunts.
    """

    train: DriveTrain
    curve: DriveResponse | None
    state: Floats
    speed: float
    bode: Bode
    omega: Floats
    whole: Floats
    reduced: Floats
    ramp: Ramp | None
    left_out: Reductions | None
    motions: tuple[DriveMotion | None, ...]
    remarks: tuple[str, ...]
    gravity: tuple[float, float] | None = None
    resting: Standstill | None = None

    @property
    def run_alone(self) -> Ramp | None:
        """The run-up where it alone has all torques of the train: there is no steady curve, or one without gravity."""
        ended = self.ramp is not None and self.ramp.run.trajectory.status
        return self.ramp if ended and (self.curve is None or self.curve.without_angle) else None

    @property
    def modes(self) -> list[complex]:
        """Poles [1/s] of its vibrations about the operating point, one of each pair, by ascending frequency."""
        return sorted((p for p in self.bode.poles.tolist() if p.imag > 1e-6 * abs(p)), key=abs)


def train_study(
    train: DriveTrain,
    system: Any,
    speeds: tuple[float, float],
    curve: DriveResponse | None,
    exact: DriveResponse,
    point: OperatingPoint,
    *,
    single: tuple[float, ...] = (),
    gear: Gear | None = None,
    progress: Callable[[str], None] = silent,
) -> TrainStudy:
    """Study a drive train over a range of motor speeds [rad/s].

    Parameters
    ----------
    train : DriveTrain
        The train at constant speed (the `Steady` reference).
    system : Oscillator
        Its error equation.
    curve : DriveResponse or None
        `train_curve` of the same range.
    exact, point : DriveResponse, OperatingPoint
        Response of the error equation over the range, and its equilibrium.
    single : tuple of float
        Speeds [rad/s] at which the train is shown in time.
    gear : Gear, optional
        Record whose limits the run-up is compared with.
    progress : callable
        Told every part before it is computed.
    """
    low, high = speeds
    top = max(1, *system.orders()) if system.orders() else 1
    worst = _speed_of_largest(exact, speeds)
    highest = high if curve is None else _speed_of_largest(curve, speeds)
    speed = worst if curve is None else highest
    progress("modes and Bode plot")
    state, remarks = _operating_state(train, speed, (point.x, *point.z))
    if spring_stiffness(train.law, point.x) < point.stiffness * (1.0 - 1e-9):
        remarks.append("Modes and Bode plot hold for small vibrations, before the hysteresis yields.")
    grid = np.geomspace(0.2 * low, 1.5 * top * high, FREQUENCIES)
    source: Literal["motor", "load"] = "load" if train.motor.held else "motor"
    plot = bode(train, grid, source=source, at=state, speed=speed)
    left_out, probes, peaks, reduced = None, np.empty(0), np.empty(0), np.empty(0)
    ramp = None
    if train.motor.free:
        remarks.append("No run-up is computed: a free motor follows its torque, not a speed. Give the motor a loop.")
        if curve is None:
            probes = np.array([w for w in (0.5 * worst, worst) if low <= w <= high])
            progress("comparison with the error equation")
            left_out = compare_with_train(train, system, probes, min(MOST_HARMONICS, max(top + 2, 4 * top)))
            peaks, reduced = left_out.exact, left_out.free
    else:
        progress("run-up")
        ramp = ramp_of(train, system, speeds, gear)
        if (path := ramp.run.trajectory).t[-1] < ramp.begin:
            remarks.append(Sentence("The run-up ends while the motion settles at the lowest speed: {}.", path.message))
            ramp = None
        elif any(h.amplitude for torque in _torques(train) for h in terms_of(torque)):
            remarks.append("The run-up includes the mean torques and omits torque components that vary with an angle.")
        has = "" if ramp is None else "; the run-up includes "
        if curve is None:
            remarks.append("No steady motion of the drive train that repeats with every turn was found.")
        elif curve.without_angle:
            remarks.append(
                "Gravity and other torques that depend on the load angle repeat once per output turn. The steady "
                f"curve omits them{has and has + 'them'}."
            )
    if curve is not None:
        probes = np.unique([low, *([worst] if abs(worst / highest - 1.0) > SPEED_GAP else []), highest, high])
        peaks, reduced = peaks_at(curve, probes), peaks_at(exact, probes)
    progress("single speeds in time")
    motions = tuple(_motion_at(train, omega) for omega in single)
    return TrainStudy(
        train=train, curve=curve, state=state, speed=speed, bode=plot, omega=probes, whole=peaks, reduced=reduced,
        ramp=ramp, left_out=left_out, motions=motions, remarks=tuple(remarks),
    )  # fmt: skip


def _motion_at(train: DriveTrain, omega: float) -> DriveMotion | None:
    """Motion of a train at a speed [rad/s]; None where its law cannot carry the torque, or nothing holds its speed."""
    try:
        return train_motion(train, omega, mean_torque(train.load.end().excitation))
    except SolveError:
        return None


def peaks_at(response: DriveResponse, omega: Floats) -> Floats:
    """Largest |x| [rad] that a slow run-up meets at speeds [rad/s]; nan beyond it."""
    if response.sweep is None:
        return np.full(len(omega), np.nan)
    path = response.sweep.run_up
    path = path[np.argsort(response.curve.omega[path], kind="stable")]
    speeds, peak = response.curve.omega[path], response.curve.peak[path]
    return np.asarray(np.interp(omega, speeds, peak, left=np.nan, right=np.nan))


def _speed_of_largest(response: DriveResponse, speeds: tuple[float, float]) -> float:
    """Speed [rad/s] of the largest error of a response; the highest one where it has none."""
    top = response.largest()
    return speeds[1] if top is None else float(np.clip(response.curve.omega[top], *speeds))


def _operating_state(train: DriveTrain, speed: float, twist: tuple[float, ...]) -> tuple[Floats, list[str]]:
    """State under the mean torques; without one the state of rest, and a sentence."""
    try:
        return operating_state(train, speed, near=twist), []
    except SolveError as error:
        remark = Sentence("Modes and Bode plot are for the drive train without torques: {}.", error)
        return np.zeros(len(train.state_names())), [remark]


def _torques(train: DriveTrain) -> tuple[Any, Any]:
    """Torques on motor and load."""
    return train.motor.excitation, train.load.end().excitation
