"""Steady motions of a drive through a range of speeds: pointing error of the load, error across the gear, torque.

What motions ask of the gear and of the motor, against the limits of the datasheet and of the project file.
"""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..base.records import Labelled, Result
from ..base.results import Branch, Floats, Orbit, Status
from ..base.sentences import on_screen
from ..base.series import largest_of_samples
from ..model.gears.gear import Gear
from ..model.gears.limits import Finding, check_limits, cubic_means
from ..model.train.drive_train import DriveTrain
from .asked import MotorLimits, motor_findings
from .response import ExactResponse


@dataclass(frozen=True)
class Usage:
    """The torque in the gear, T(u) + B u' at the output, in the steady motions of a speed range.

    Attributes
    ----------
    peak_torque, at_peak : float
        Largest size [N*m], and the base-angle speed [rad/s] there.
    average_torque, at_average : float
        Largest cubic mean over a turn [N*m], and the base-angle speed [rad/s] there.
    """

    peak_torque: float
    at_peak: float
    average_torque: float
    at_average: float


class MotorUse(NamedTuple):
    """What the motions of a speed range ask of the motor.

    Attributes
    ----------
    torque, at : float
        Largest size of its torque [N*m, motor side], and the base-angle speed [rad/s] there.
    holding : float
        Largest size of its mean over a turn [N*m], which loads, gravity and friction take at steady speeds.
    load : float or None
        Torque [N*m] of the load at the largest, where it has a range of them.
    in_run_up : bool
        Whether the largest is in the run-up, what its acceleration takes left out.
    run_up : float or None
        Largest size of the torque [N*m] in the run-up, its acceleration included; None without one.
    """

    torque: float
    at: float
    holding: float
    load: float | None = None
    in_run_up: bool = False
    run_up: float | None = None


def most_asked(some: Iterable[MotorUse | None]) -> MotorUse | None:
    """The largest torques of several, of those that are known."""
    known = [use for use in some if use is not None]
    if not known:
        return None
    run_up = max((use.run_up for use in known if use.run_up is not None), default=None)
    top = max(known, key=lambda use: use.torque)
    return top._replace(holding=max(use.holding for use in known), run_up=run_up)


def most_used(*some: Usage) -> Usage:
    """The largest torques of several."""
    peak, mean = max(some, key=lambda u: u.peak_torque), max(some, key=lambda u: u.average_torque)
    return Usage(peak.peak_torque, peak.at_peak, mean.average_torque, mean.at_average)


def limit_findings(
    gear: Gear | None, used: Usage, fastest: float | None, limits: MotorLimits | None = None,
    motor: MotorUse | None = None,
) -> tuple[Finding, ...]:  # fmt: skip
    """Compare motions with the limits of the gear and of the motor; `Finding.fails` says by which a drive fails.

    `fastest` is the largest input speed [rad/s], None where it is not known. It counts as the mean speed too: every
    speed of the range may be kept up.
    """
    found: tuple[Finding, ...] = ()
    if gear is not None:
        found = check_limits(
            gear, peak_torque=used.peak_torque, average_torque=used.average_torque, max_speed=fastest,
            average_speed=fastest,
        )  # fmt: skip
    if limits is None:
        return found
    torque, holding = (None, 0.0) if motor is None else (motor.torque, motor.holding)
    return found + motor_findings(limits, torque, fastest, holding)


@dataclass(frozen=True, eq=False)
class DriveResponse(Result):
    """Steady motions of a drive that repeat with the base angle, in arc order over its speed.

    Its error is the pointing error of the load: the reference angle, that of the motor over N, minus the load's angle,
    twists of couplings and the motor's own deviation included. With an ideally held motor it is x = theta_m/N -
    theta_l of the load. A motor that follows its torque alone has no reference: there the error is x.

    Attributes
    ----------
    response : ExactResponse
        The curve of the error with its jumps; its `elsewhere` has motions at the ends of the range that are not
        connected to it, and its `message` lists them.
    across : (n,) array
        Largest |x| across the gear alone [rad], at every point.
    torque, mean_torque : (n,) arrays
        Largest size and cubic mean over a turn of the torque in the gear [N*m, output side], at every point.
    has_reference : bool
        Whether the error is the pointing error.
    without_angle : bool
        Whether a torque that follows the load's own angle, gravity for one, is left out: it repeats once in N turns of
        the motor, so that no motion with it repeats with every turn.
    motor_torque, motor_mean : (n,) arrays or None
        Largest size, and mean over a turn, of the torque of the motor [N*m, motor side], at every point; of a free
        motor that which it is given. None where the ratio is not known.
    """

    response: ExactResponse
    across: Floats
    torque: Floats
    mean_torque: Floats
    has_reference: bool = True
    without_angle: bool = False
    motor_torque: Floats | None = None
    motor_mean: Floats | None = None

    def coordinates(self) -> Labelled:
        """As of the curve."""
        return self.response.coordinates()

    def variables(self) -> Labelled:
        """Those of the curve of the error, and what the gear is asked for at every point."""
        across = {"across": ("point", self.across, "rad")}
        torques = {name: ("point", getattr(self, name), "N*m") for name in ("torque", "mean_torque")}
        if self.motor_torque is not None:
            torques |= {name: ("point", getattr(self, name), "N*m") for name in ("motor_torque", "motor_mean")}
        return {**self.response.variables(), **across, **torques}

    @property
    def name(self) -> str:
        """What the error is, in words."""
        return "pointing error" if self.has_reference else "error between motor and load"

    @property
    def curve(self) -> Branch:
        """The curve of the error."""
        return self.response.curve

    @property
    def omega(self) -> Floats:
        """Speed (n,) of the base angle [rad/s]."""
        return self.curve.omega

    @property
    def peak(self) -> Floats:
        """Largest |error| (n,) [rad], its mean included: the static wind-up is in it."""
        return self.curve.peak

    @property
    def oscillation(self) -> Floats:
        """Largest |error - mean| (n,) [rad]."""
        return self.curve.oscillation

    @property
    def stable(self) -> Any:
        """Whether each motion is stable, (n,) bool."""
        return self.curve.stable

    @property
    def folds(self) -> list[Orbit]:
        """Turning points of the speed."""
        return self.curve.folds

    @property
    def status(self) -> Status:
        """`Status.OK`, `Status.TRUNCATED`, or why the curve ends inside the range."""
        return self.curve.status

    @property
    def message(self) -> str:
        """One sentence on the curve."""
        return self.curve.message

    def visited(self) -> NDArray[np.int64]:
        """Numbers of the motions that a slow run-up or run-down visits; all in the range where there is no sweep."""
        visited = self.response.visited()
        return visited if len(visited) else np.flatnonzero(self.curve.inside)

    @property
    def gear_peak(self) -> float:
        """Largest |x| across the gear alone [rad] in the motions that a slow run-up or run-down visits."""
        return float(np.max(self.across[self.visited()], initial=0.0))

    @property
    def usage(self) -> Usage:
        """Largest torques in the gear over the same motions."""
        at = self.visited()
        peak, mean = (at[int(np.argmax(values[at]))] for values in (self.torque, self.mean_torque))
        omega = self.omega
        return Usage(
            float(self.torque[peak]), float(omega[peak]), float(self.mean_torque[mean]), float(omega[mean])
        )  # fmt: skip

    @property
    def motor(self) -> MotorUse | None:
        """What the same motions ask of the motor, where it is known."""
        if self.motor_torque is None or self.motor_mean is None:
            return None
        at = self.visited()
        top = at[int(np.argmax(self.motor_torque[at]))]
        holding = float(np.max(np.abs(self.motor_mean[at])))
        return MotorUse(float(self.motor_torque[top]), float(self.omega[top]), holding)

    def asked(self, mean: float, loads: tuple[float, float], N: float) -> tuple[Usage, MotorUse | None]:
        """What the motions ask of gear and motor, and at least what a range of `loads` [N*m] takes at steady speed.

        The curve is for the `mean` torque of the load; over the ratio `N` the motor holds the others too.
        """
        used, motor = self.usage, self.motor
        used = replace(used, peak_torque=max(used.peak_torque, *map(abs, loads)))
        if motor is not None and self.motor_mean is not None:
            means = np.abs(self.motor_mean[self.visited()] + (mean - np.array(loads)[:, None]) / N)
            holding, at = float(np.max(means)), self.omega[self.visited()][int(np.argmax(np.max(means, axis=0)))]
            motor = motor._replace(holding=holding)
            if holding > motor.torque:
                motor = motor._replace(torque=holding, at=float(at))
        return used, motor

    def __str__(self) -> str:
        visited = self.visited()
        top = visited[int(np.argmax(self.oscillation[visited]))]
        folds = ", ".join(f"{fold.omega:.6g}" for fold in self.folds)
        turns = f"folds at {folds} rad/s" if folds else "no folds"
        return on_screen(
            f"DriveResponse: {len(self.omega)} steady motions, {self.omega.min():.6g} to {self.omega.max():.6g} rad/s\n"
            f"  largest oscillation of the {self.name} {self.oscillation[top]:.6g} rad at {self.omega[top]:.6g} rad/s\n"
            f"  largest |x| across the gear {self.gear_peak:.6g} rad, torque in it {self.usage.peak_torque:.6g} N*m\n"
            f"  {turns}; {int(np.sum(self.stable))} motions stable; {self.message}"
        )


def of_equation(
    system: Any, exact: ExactResponse, has_reference: bool = True, train: DriveTrain | None = None
) -> DriveResponse:
    """Motions of an error equation with its response: a rigid load, and a motor that is held, or free.

    `train` is the same drive with its ratio, for the torque of the motor.
    """
    torque = exact.torque(system)
    found = DriveResponse(exact, exact.curve.peak, largest_of_samples(torque), cubic_means(torque), has_reference)
    if train is None:
        return found
    angles = 2.0 * np.pi * np.arange(torque.shape[1]) / torque.shape[1]
    motor = motor_torque(train, angles, torque)
    return replace(found, motor_torque=largest_of_samples(motor), motor_mean=np.mean(motor, axis=1))


def motor_torque(train: DriveTrain, angles: Floats, torque: Floats) -> Floats:
    """Torque (n, samples) [N*m] of a motor that turns steadily, at base angles [rad], from that in the gear [N*m].

    It is (1/N - e') T without drag; of a free motor that which it is given.
    """
    if train.motor.free:
        return np.asarray(train.motor.excitation.torque(angles) + 0.0 * torque)
    return np.asarray((1.0 / train.N - train.error.slope(angles)) * torque)
