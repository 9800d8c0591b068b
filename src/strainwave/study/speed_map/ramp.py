"""A run-up of the whole drive from its lowest to its highest speed: the error about the mean of its turns."""

from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...base.results import Floats
from ...base.series import largest_of_samples, sizes_of_samples
from ...drive.demands.usage import MotorUse, Usage
from ...drive.equation.gear_torque import damping_of
from ...drive.operating_point import with_mean_torques
from ...drive.project import Project
from ...drive.run import DriveRun, drive_run
from ...drive.steady import leaves_angle_out
from ...model.gears.gear import Gear
from ...model.train.drive_train import DriveTrain
from ...model.train.motion import SpeedProfile
from ...numerics.integration.methods import Dopri5
from .size_curve import SizeCurve

RUN_UP_TIME, SETTLING_TIME = 40.0, 8.0  # length of the run-up and of the time before it, in units of 1/mu
ONSET, CORNERS = 0.2, 9  # share of the run-up in which its acceleration begins, and points of the speed in it
MOST_TURNS, SAMPLES, LEAST_SAMPLES = 1000.0, 40, 400  # of the motor in a run-up, per cycle of the highest order, in all
METHOD = Dopri5(rtol=1e-8, atol=1e-12)


class Ramp(NamedTuple):
    """A run-up from the lowest to the highest speed, and the time [s] at which it begins: before it, motion settles."""

    run: DriveRun
    begin: float

    def largest(self, values: Floats) -> tuple[float, float]:
        """Largest size of what was sampled over the run, once it has begun, and the motor speed [rad/s] there."""
        sizes = np.where(self.run.trajectory.t >= self.begin, sizes_of_samples(values), 0.0)
        top = int(np.argmax(sizes))
        return float(sizes[top]), float(self.run.motor_speed[top])

    @property
    def duration(self) -> float:
        """Time [s] from the lowest to the highest speed."""
        return float(self.run.trajectory.t[-1]) - self.begin

    def motor(self) -> MotorUse | None:
        """Demands of the run on the motor once it has begun; None where it did not end well.

        How fast the motor runs up is assumed: `torque` is without what that takes of a rigid drive, `run_up` with it.
        """
        train, path = self.run.train, self.run.trajectory
        if not path.status:
            return None
        begun = path.t >= self.begin
        total = train.motor_torque(train.omega * path.t, tuple(path.y)) * begun
        steady = total - train.loop_inertia * train.reference.curvature(path.t) * begun
        run_up, torque = largest_of_samples(np.array([total, steady])).tolist()
        speed = float(self.run.motor_speed[np.argmax(np.abs(steady))])
        return MotorUse(torque, speed, 0.0, None, True, run_up)

    def added_to(self, used: Usage) -> Usage:
        """Torques of the gear, with the largest of a run that ended well where that is larger."""
        peak, speed = self.largest(self.run.torque)
        if not self.run.trajectory.status or peak <= used.peak_torque:
            return used
        return replace(used, peak_torque=peak, at_peak=speed)


def ramp_of(train: DriveTrain, system: Any, speeds: tuple[float, float], gear: Gear | None = None) -> Ramp:
    """Run-up that takes 40/mu, after 8/mu at the lowest speed; shorter where that were more than 1000 turns.

    Its acceleration begins in steps of an eighth: one step would shake the drive, which no steady motion does.
    """
    low, high = speeds
    top = max(1, *system.orders()) if system.orders() else 1
    mean = 0.5 * (low + high)
    mu = max(damping_of(system) / system.J, 0.02 * mean)
    length = min(RUN_UP_TIME / mu, MOST_TURNS * 2.0 * np.pi / mean)
    begin = min(SETTLING_TIME / mu, 0.2 * length)
    onset = np.linspace(0.0, 1.0, CORNERS)
    first = low + (high - low) * ONSET / (2.0 - ONSET) * onset * onset
    corners = (begin + ONSET * length * onset).tolist()
    profile = SpeedProfile((0.0, *corners, begin + length), (low, *first.tolist(), high))
    timed = with_mean_torques(train)._replace(omega=1.0, reference=profile)
    cycles = top * mean * (begin + length) / (2.0 * np.pi)
    times = np.linspace(0.0, begin + length, max(LEAST_SAMPLES, int(SAMPLES * cycles)) + 2)
    return Ramp(drive_run(timed, None, times, gear=gear, method=METHOD), begin)


def run_up_sizes(project: Project) -> SizeCurve | None:
    """Motions of a run-up that has torques which the steady curve leaves out; None where the curve has all.

    Such a torque follows the angle of the load, as gravity does.
    """
    train = project.train
    if train is None or train.motor.free or not leaves_angle_out(train):
        return None
    run = ramp_of(train, project.system(reduced=True), project.speeds.limits, project.gear)
    return in_run(run.run, run.begin) if run.run.trajectory.status else None


def in_run(run: DriveRun, begin: float) -> SizeCurve | None:
    """Oscillation of the pointing error in every turn of the motor of a run, from a time [s] on.

    It is the largest distance in the turn from the mean of the turns: a line through the mean of each turn at its
    middle. That mean follows what changes slowly, the torque of the load's own angle for one. At a constant speed it is
    |x - mean| of a steady motion. None of a run of less than three turns.
    """
    keep = run.trajectory.t >= begin
    t, speed, error = run.trajectory.t[keep], run.motor_speed[keep], run.pointing[keep]
    starts = turns(t, speed)
    if len(starts) < 4:
        return None
    ends, starts = starts[1:], starts[:-1]
    error, speed, counts = error[: ends[-1]], speed[: ends[-1]], ends - starts
    means, middles = np.add.reduceat(error, starts) / counts, 0.5 * (starts + ends - 1)
    slow = np.interp(np.arange(len(error)), _extended(middles), _extended(means))
    sizes = np.maximum.reduceat(sizes_of_samples(error - slow), starts)
    return SizeCurve(np.add.reduceat(speed, starts) / counts, sizes, np.ones(len(starts), bool))


def turns(t: Floats, speed: Floats) -> NDArray[np.int64]:
    """Numbers of the samples with which each turn of the motor begins, the last of which may not be whole."""
    steps = np.append(0.0, 0.5 * (speed[1:] + speed[:-1]) * np.diff(t)) / (2.0 * np.pi)
    angle = np.maximum.accumulate(np.cumsum(steps))  # a motor that sticks and slips turns back
    return np.searchsorted(angle, np.arange(int(angle[-1]) + 1))


def _extended(row: Any) -> Floats:
    """A row with one number more at each end, on a straight line."""
    return np.concatenate([[2.0 * row[0] - row[1]], row, [2.0 * row[-1] - row[-2]]])
