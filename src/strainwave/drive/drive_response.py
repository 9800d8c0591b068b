"""Steady motions of a drive through a range of speeds: pointing error of the load, error across the gear, torque.

What motions ask of the gear and of the motor, against the limits of the datasheet and of the project file.
"""

import math
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, ClassVar

import numpy as np

from ..base.protocols import lines_of
from ..base.records import Labelled, Result
from ..base.results import Branch, Floats, Integers, Orbit, Status
from ..base.sentences import Sentence
from ..base.terminal import on_screen
from .demands.motor_limits import Need
from .demands.usage import MotorUse, Usage
from .jumps import Jumps, pieces_of


@dataclass(frozen=True, eq=False)
class DriveResponse(Result):
    """Steady motions of a drive that repeat with the base angle, in arc order over its speed.

    They are those of the whole train, or of its error equation: the same drive with a rigid load and an ideal motor.
    The error is the pointing error of the load: the reference angle, that of the motor over N, minus the load's angle,
    twists of couplings and the motor's own deviation included. With an ideally held motor it is x = theta_m/N -
    theta_l of the load. A motor that follows its torque alone has no reference: there the error is x.

    Attributes
    ----------
    curve : Branch
        Points of the error with stability and folds; its `elsewhere` has motions at the ends of the range that are not
        connected to it, and its `message` lists them.
    sweep : Jumps or None
        What a slow run-up and run-down do on it; None where no motion is stable, as without damping.
    across : (n,) array
        Largest |x| across the gear alone [rad], at every point.
    torque, mean_torque : (n,) arrays
        Largest size and cubic mean over a turn of the torque in the gear [N*m, output side], at every point.
    has_reference : bool
        Whether the error is the pointing error.
    without_angle : bool
        Whether a torque that follows the load's own angle, gravity for one, is left out: it repeats once in N turns of
        the motor, so that no motion with it repeats with every turn.
    motor_torque, motor_mean, motor_rms : (n,) arrays or None
        Largest size, mean and root mean square over a turn of the torque of the motor [N*m, motor side], at every
        point; of a free motor with the mean that keeps its speed, of an error equation that which it is given. None
        where the ratio is not known.
    rounding : str
        How wide the corners of the law are rounded for the curve, a sentence; empty where they are not.
    starts : (n, states) array or None
        State of the train at the angle 0 of motor and output, of motions that beat.
    """

    curve: Branch
    sweep: Jumps | None
    across: Floats = field(default_factory=lambda: np.empty(0))
    torque: Floats = field(default_factory=lambda: np.empty(0))
    mean_torque: Floats = field(default_factory=lambda: np.empty(0))
    has_reference: bool = True
    without_angle: bool = False
    motor_torque: Floats | None = None
    motor_mean: Floats | None = None
    motor_rms: Floats | None = None
    rounding: str = ""
    starts: Floats | None = None

    method: ClassVar[str] = "harmonic balance"

    def coordinates(self) -> Labelled:
        """Coordinates of the curve."""
        return self.curve.coordinates()

    def variables(self) -> Labelled:
        """Those of the curve, whether a slow sweep visits a point, and what gear and motor are asked for there."""
        torques = ("torque", "mean_torque", "motor_torque", "motor_mean", "motor_rms")
        units = {"across": "rad"} | dict.fromkeys(torques, "N*m")
        sizes = ((name, getattr(self, name), unit) for name, unit in units.items())
        asked = {name: ("point", values, unit) for name, values, unit in sizes if values is not None and len(values)}
        path = () if self.sweep is None else (*self.sweep.run_up, *self.sweep.run_down)
        visited = np.isin(np.arange(len(self.curve)), path)
        return {**self.curve.variables(), "visited": ("point", visited, ""), **asked}

    @property
    def name(self) -> str:
        """Name of the error."""
        return "pointing error" if self.has_reference else "error between motor and load"

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
        """Stability of each motion, (n,) bool."""
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
        return Sentence("; ").join(filter(None, (self.curve.message, self.rounding)))

    @cached_property
    def counted(self) -> Integers:
        """Numbers of the stable motions in the range, the ends of their stability included; empty where none is."""
        pieces = pieces_of(self.curve, self.curve.stable)
        some = np.unique(np.concatenate([np.empty(0, np.int64), *pieces]))
        return np.asarray(some[self.curve.inside[some]])

    def visited(self) -> Integers:
        """Numbers of the stable motions in the range; of all motions in it where none is stable."""
        return self.counted if len(self.counted) else np.flatnonzero(self.curve.inside)

    def top_of(self, values: Floats) -> int:
        """Number of the stable motion with the largest of some values (n,)."""
        return int(self.visited()[np.argmax(values[self.visited()])])

    @property
    def top(self) -> int:
        """Number of the stable motion with the largest |error - mean|."""
        return self.top_of(self.oscillation)

    def largest(self) -> int | None:
        """Number of the stable motion with the largest |error|; None where none is stable."""
        return self.top_of(self.peak) if len(self.counted) else None

    def largest_oscillation(self) -> int | None:
        """Number of the stable motion with the largest |error - mean|; None where none is stable."""
        return self.top if len(self.counted) else None

    def torsion_amplitude(self, system: Any, order: int) -> Floats:
        """0-to-peak amplitude [rad] of the torsion of an error equation at `order` times the base speed."""
        x = self.curve.coefficients
        if 2 * order >= x.shape[1]:
            return 0.0 * self.omega
        lines = [line for line in lines_of(system.error) if line.order == order]
        even = x[:, 2 * order - 1] - sum(line.amplitude * math.cos(line.phase) for line in lines)
        odd = x[:, 2 * order] + sum(line.amplitude * math.sin(line.phase) for line in lines)
        return np.asarray(np.hypot(even, odd))

    @property
    def gear_peak(self) -> float:
        """Largest |x| across the gear alone [rad] in the stable motions."""
        return float(np.max(self.across[self.visited()], initial=0.0))

    @property
    def usage(self) -> Usage:
        """Largest torques in the gear in the stable motions."""
        peak, mean = self.top_of(self.torque), self.top_of(self.mean_torque)
        sizes = self.torque[peak], self.omega[peak], self.mean_torque[mean], self.omega[mean]
        return Usage(*map(float, sizes))

    @property
    def motor(self) -> MotorUse | None:
        """Largest demands of the stable motions on the motor; None where they are not known."""
        if self.motor_torque is None or self.motor_mean is None:
            return None
        top = self.top_of(self.motor_torque)
        holding = float(np.max(np.abs(self.motor_mean[self.visited()])))
        return MotorUse(float(self.motor_torque[top]), float(self.omega[top]), holding)

    def need(self, shifts: tuple[float, ...] = (0.0,)) -> Need | None:
        """Demands of the stable motions on the motor at every speed; None where they are not known.

        Of the `shifts` of its mean torque [N*m], those of other loads, the largest counts; the vibration is that of the
        curve.
        """
        if self.motor_torque is None or self.motor_mean is None or self.motor_rms is None:
            return None
        visited = self.visited()
        mean, peak = self.motor_mean[visited], self.motor_torque[visited]
        moved = np.max(np.abs(mean + np.array(shifts)[:, None]), axis=0)
        ripple = np.maximum(self.motor_rms[visited] ** 2 - mean * mean, 0.0)
        peak = np.maximum(peak, moved + peak - np.abs(mean))
        return Need(self.omega[visited], peak, np.sqrt(moved**2 + ripple), np.diff(visited) == 1)

    def demands(self, mean: float, loads: tuple[float, float], N: float) -> tuple[Usage, MotorUse | None]:
        """Demands of the motions on gear and motor, at least those of a range of `loads` [N*m] at steady speed.

        The curve is for the `mean` torque of the load; over the ratio `N` the motor holds the others too.
        """
        usage, motor = self.usage, self.motor
        usage = replace(usage, peak_torque=max(usage.peak_torque, *map(abs, loads)))
        if motor is not None and self.motor_mean is not None:
            means = np.abs(self.motor_mean[self.visited()] + (mean - np.array(loads)[:, None]) / N)
            holding, speed = float(np.max(means)), self.omega[self.visited()][int(np.argmax(np.max(means, axis=0)))]
            motor = motor._replace(holding=holding)
            if holding > motor.torque:
                motor = motor._replace(torque=holding, at=float(speed))
        return usage, motor

    def __str__(self) -> str:
        if not len(self.torque):
            return on_screen(f"DriveResponse: {self.curve}" + ("" if self.sweep is None else f"\n{self.sweep}"))
        top = self.top
        folds = ", ".join(f"{fold.omega:.6g}" for fold in self.folds)
        turns = f"folds at {folds} rad/s" if folds else "no folds"
        return on_screen(
            f"DriveResponse: {len(self.omega)} steady motions, {self.omega.min():.6g} to {self.omega.max():.6g} rad/s\n"
            f"  largest oscillation of the {self.name} {self.oscillation[top]:.6g} rad at {self.omega[top]:.6g} rad/s\n"
            f"  largest |x| across the gear {self.gear_peak:.6g} rad, torque in it {self.usage.peak_torque:.6g} N*m\n"
            f"  {turns}; {int(np.sum(self.stable))} motions stable; {self.message}"
        )
