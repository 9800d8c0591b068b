"""Limits of a motor, and the torque and speed that motions need against them."""

import math
from collections.abc import Iterable, Iterator
from itertools import pairwise
from typing import Annotated, Any, NamedTuple

import numpy as np

from ...base.quantities import AngularSpeed, Torque, number, shown
from ...base.results import Floats
from ...base.units import RPM
from ...model.gears.limits import RATED, Finding

TorqueConstant = Annotated[float, "N*m/A"]
STRONGER, SLOWER = "choose a stronger motor, another ratio or less load", "reduce the speed, or choose a smaller ratio"
PEAK, RMS, BRAKE = "motor torque", "motor rms torque", "motor brake torque"
Curve = tuple[tuple[float, float], ...]  # speeds [rad/s], from 0 on and ascending, each with a torque [N*m]
CURVES = ("peak_torque", "continuous_torque")


class MotorLimits(NamedTuple):
    """Sheet of a motor: what it gives at most; infinite, or no points, where nothing is known.

    `torque` and `speed` are the largest torque [N*m] and speed [rad/s]. The curves over the speed are `peak_torque`, of
    short duty (S3), and `continuous_torque`, of continuous duty (S1). `rms_torque` [N*m] is the largest rms torque that
    the winding stands, `rated_speed` [rad/s] the largest mean speed, `brake` [N*m] what the brake holds, `K_t` [N*m/A]
    the torque of a current.
    """

    torque: Torque = math.inf
    speed: AngularSpeed = math.inf
    peak_torque: Curve = ()
    continuous_torque: Curve = ()
    rms_torque: Torque = math.inf
    rated_speed: AngularSpeed = math.inf
    brake: Torque = math.inf
    K_t: TorqueConstant = math.inf

    def check(self) -> None:
        """Refuse limits that are not positive, and curves with holes (ValueError)."""
        for name in self._fields:
            value = getattr(self, name)
            if name in CURVES:
                if value and (fault := curve_fault(value)):
                    raise ValueError(f"MotorLimits.{name} {fault}")
            elif value != math.inf:
                number(f"MotorLimits.{name}", value, positive=True)
        if fault := self.crossing():
            raise ValueError(f"MotorLimits.continuous_torque {fault}")

    def crossing(self) -> str:
        """End of a sentence on a continuous torque above the peak torque at a speed; empty where it is below."""
        if not (self.peak_torque and self.continuous_torque):
            return ""
        speeds = np.array([speed for speed, _ in (*self.peak_torque, *self.continuous_torque)])
        speeds = speeds[speeds <= self.fastest]
        peak, lasting = along(self.peak_torque, speeds), along(self.continuous_torque, speeds)
        i = int(np.argmax(lasting - peak))
        fact = f"is {lasting[i]:.4g} N*m at {speeds[i] / RPM:.5g} rpm, above the peak torque of {peak[i]:.4g} N*m"
        return f"{fact}; swap or correct the curves" if lasting[i] > peak[i] else ""

    @property
    def most(self) -> float:
        """Largest torque [N*m] at any speed."""
        return min(self.torque, max((torque for _, torque in self.peak_torque), default=math.inf))

    @property
    def fastest(self) -> float:
        """Largest speed [rad/s]: that of the motor, or where a curve of its torque ends."""
        curves = self.peak_torque, self.continuous_torque
        return min(self.speed, *(curve[-1][0] for curve in curves if curve), math.inf)

    @property
    def lasts(self) -> bool:
        """True if a limit of the rms torque is known."""
        return bool(self.continuous_torque) or math.isfinite(self.rms_torque)

    def at(self, limit: str, speed: Any) -> Floats:
        """Peak torque, or by its limit `RMS` continuous torque [N*m], at speeds [rad/s] of either sign."""
        constant, curve = (self.rms_torque, self.continuous_torque) if limit == RMS else (self.torque, self.peak_torque)
        return np.minimum(constant, along(curve, speed))


def along(curve: Curve, speed: Floats) -> Floats:
    """Torque [N*m] of a curve at speeds [rad/s]; infinite without points, and beyond the last point as there."""
    speeds, torques = np.array(curve or ((0.0, math.inf),)).T
    return np.asarray(np.interp(np.abs(speed), speeds, torques))


def curve_fault(curve: Curve) -> str:
    """Fault of the points of a curve, as the end of a sentence; empty without one."""
    if not all(isinstance(point, tuple) and len(point) == 2 for point in curve):
        return f"is {shown(curve)}; give points ((speed, torque), ...)"
    speeds = [speed for speed, _ in curve]
    if len(curve) < 2:
        return "has fewer than two points; give a torque at speed 0 and one at the largest speed"
    if speeds[0] != 0.0:
        return f"begins at {speeds[0] / RPM:.5g} rpm; give the torque at standstill too, at 0 rpm"
    for before, after in pairwise(speeds):
        if not after > before:
            return f"has {after / RPM:.5g} rpm after {before / RPM:.5g} rpm; give speeds that ascend"
    for speed, torque in curve:
        if not 0.0 <= torque < math.inf:
            return f"has {torque:.4g} N*m at {speed / RPM:.5g} rpm; give torques from 0 on, as sizes"
    return ""


class Need(NamedTuple):
    """Torque and speed of a motor that motions along a curve need.

    Attributes
    ----------
    omega : (n,) array
        Speeds of the motor [rad/s].
    peak, rms : (n,) arrays
        Largest size and root mean square of its torque over a turn [N*m].
    joined : (n - 1,) bool array
        Whether each motion leads to the next.
    """

    omega: Floats
    peak: Floats
    rms: Floats
    joined: Any

    def against(self, limits: MotorLimits, limit: str) -> tuple[Floats, Floats, Floats, Any]:
        """Speeds [rad/s], torque asked and available [N*m], and whether joined; where a curve bends, too."""
        omega, n = self.omega, np.arange(len(self.omega), dtype=float)
        indices = [n]
        for knot, _ in limits.continuous_torque if limit == RMS else limits.peak_torque:
            i = np.flatnonzero(self.joined & ((omega[:-1] - knot) * (omega[1:] - knot) < 0.0))
            indices.append(i + (knot - omega[i]) / (omega[i + 1] - omega[i]))
        index = np.unique(np.concatenate(indices))
        speeds, torque = np.interp(index, n, omega), np.interp(index, n, self.rms if limit == RMS else self.peak)
        return speeds, torque, limits.at(limit, speeds), self.joined[index[:-1].astype(int)]

    def share(self, limits: MotorLimits, limit: str) -> float:
        """Largest share of the torque that is available."""
        _, torque, available, _ = self.against(limits, limit)
        return float(np.max(torque / np.maximum(available, 1e-300)))


def motor_findings(
    limits: MotorLimits, torque: float | None, speed: float | None, holding: float = 0.0,
    remedies: tuple[str, str] = (STRONGER, SLOWER),
) -> Iterator[Finding]:  # fmt: skip
    """Compare a motor's largest torque [N*m] and speed [rad/s] with its limits, where both are known.

    `holding` is the part of the torque that loads and friction take at steady speed, `remedies` what helps beyond.
    """
    rpm = None if speed is None else speed / RPM
    by_curve = limits.fastest < limits.speed
    parts = (("torque", torque, limits.torque, "N*m"), ("speed", rpm, limits.fastest / RPM, "rpm"))
    for (name, value, bound, unit), remedy in zip(parts, remedies, strict=True):
        if value is None or not math.isfinite(bound):
            continue
        beyond = Finding(f"motor {name}", value, bound, unit, "").exceeded
        of_curve = ", where its torque curve ends" if by_curve and name == "speed" else ""
        end = f"within its limit of {bound:.4g} {unit}{of_curve}"
        if beyond:
            steady = name == "torque" and holding > bound
            alone = f" (loads and friction alone require {holding:.4g} N*m)" if steady else ""
            further = "extend the torque curve, " if of_curve else ""
            end = f"above its limit of {bound:.4g} {unit}{of_curve}{alone}; {further}{remedy}"
        sentence = f"The {name} of the motor reaches {value:.4g} {unit}, {end}."
        yield Finding(f"motor {name}", value, bound, unit, sentence)


def torque_finding(limits: MotorLimits, limit: str, needs: Iterable[Need], remedy: str) -> Finding:
    """Compare torques of a motor with its peak torque, or by `RMS` rms torques with its continuous torque.

    The worst is where it is most above, or least below.
    """
    worst = []
    for need in needs:
        speeds, torque, available, _ = need.against(limits, limit)
        i = int(np.argmax(torque - available))
        worst.append((float(torque[i]), float(available[i]), float(speeds[i])))
    value, bound, speed = max(worst, key=lambda row: row[0] - row[1])
    name, kind = limit.removeprefix("motor "), "continuous" if limit == RMS else "peak"
    fact = f"The {name} of the motor is {value:.4g} N*m at {speed / RPM:.5g} rpm, its available {kind} torque {{}}"
    return short_finding(limit, value, bound, fact, remedy, speed)


def short_finding(
    limit: str, value: float, bound: float, fact: str, remedy: str, omega: float | None = None
) -> Finding:  # fmt: skip
    """A torque [N*m] against its bound, which stands in the fact, and by how much it is too large."""
    exceeded = Finding(limit, value, bound, "N*m", "").exceeded
    end = f": {value - bound:.4g} N*m short; {remedy}" if exceeded else ""
    return Finding(limit, value, bound, "N*m", fact.format(f"{bound:.4g} N*m") + end + ".", omega)


def sheet_findings(
    limits: MotorLimits, needs: list[Need], speed: float | None = None, resting: float | None = None
) -> Iterator[Finding]:  # fmt: skip
    """Compare motions with a motor's curves, rms torque, rated speed [rad/s] and brake, where they are known.

    `speed` is the largest mean speed [rad/s], `resting` the torque [N*m, motor side] of the load at rest.
    """
    if needs and limits.peak_torque:
        yield torque_finding(limits, PEAK, needs, STRONGER)
    if needs and limits.lasts:
        yield torque_finding(limits, RMS, needs, "run so for a short time only, or " + STRONGER)
    if speed is not None and math.isfinite(limits.rated_speed):
        rpm, bound = speed / RPM, limits.rated_speed / RPM
        end = "; run at this speed for a short time only" if rpm > bound else ""
        fact = f"The mean speed of the motor is {rpm:.5g} rpm, its rated speed {bound:.5g} rpm{end}."
        yield Finding(RATED, rpm, bound, "rpm", fact)
    if resting is not None and math.isfinite(limits.brake):
        fact = f"At rest, without friction, the brake needs {resting:.4g} N*m for the load and has {{}}"
        yield short_finding(BRAKE, resting, limits.brake, fact, "choose a stronger brake")
