"""Result of a compensation: the error before and after, what it costs, and what a wrong model does to it."""

from collections.abc import Iterator
from dataclasses import dataclass
from math import log10
from operator import attrgetter
from typing import Any, ClassVar, NamedTuple

import numpy as np

from ...base.facts import Fact
from ...base.number_text import number
from ...base.quantities import probabilities
from ...base.records import Along, Labelled, Result
from ...base.results import Floats
from ...base.terminal import WIDTH, on_screen
from ...base.units import ARCSEC
from ...drive.speeds import BASES, Speeds
from ...numerics.ensemble.loops import LoopEnsemble

NAME, CELL = 18, 10  # letters of a name, and of a speed
DIFFER = 0.02  # of an rms: runs of the same loop with other samples, noise and places of the encoders differ by less


class Residual(NamedTuple):
    """Pointing error of the load: rms about its mean and slow trend, largest size with the mean, 3 sigma, mean."""

    rms: float
    peak: float
    three_sigma: float
    mean: float


def grows(before: float, after: float) -> bool:
    """True for an rms that is larger than before by more than two runs differ."""
    return after > (1.0 + DIFFER) * before


def gains(before: float, after: float) -> bool:
    """True for an rms that is smaller than before by more than two runs differ."""
    return after < (1.0 - DIFFER) * before


class TorqueUse(NamedTuple):
    """Torque of the motor [N*m]: rms, largest size, and the share of samples at its limit."""

    rms: float
    peak: float
    limited: float


class Robustness(NamedTuple):
    """Compensation on a gear whose stiffness differs by a share from the model: rms [rad] before and after."""

    stiffness: float
    before: float
    after: float

    def __str__(self) -> str:
        gear = f"{abs(100.0 * self.stiffness):.0f} % {'softer' if self.stiffness < 0.0 else 'stiffer'} than the model"
        rms = " → ".join(number(value / ARCSEC, 3) for value in (self.before, self.after))
        return f"rms error before → after, gear {gear}: {rms} arcsec"


@dataclass(frozen=True, eq=False)
class Units(Result):
    """Residuals of many units of one type under one controller.

    Attributes
    ----------
    before, after : LoopEnsemble
        Of every unit, under the plain loop and under the controller.
    stiffness, amplitude : (units,) arrays
        Factors of the gear's stiffness and of the kinematic error.
    unstable : tuple of (int, str)
        Units whose error grew or is not smaller than 0.9 times that before, and the cause as a sentence.
    """

    rows: ClassVar[str] = "lane"
    arrays: ClassVar[Along] = {"lane": {"stiffness": "", "amplitude": ""}}

    before: LoopEnsemble
    after: LoopEnsemble
    stiffness: Floats
    amplitude: Floats
    unstable: tuple[tuple[int, str], ...]

    def quantiles(self, shares: tuple[float, ...] = (0.05, 0.5, 0.95)) -> tuple[float, ...]:
        """Quantiles of the rms of the residual [rad]."""
        return tuple(np.quantile(self.after.rms, probabilities("shares", shares)).tolist())

    def variables(self) -> Labelled:
        """Residuals by unit."""
        residuals = {"before": ("lane", self.before.rms, "rad"), "after": ("lane", self.after.rms, "rad")}
        return {**residuals, **super().variables()}

    def __str__(self) -> str:
        low, middle, high = [number(value / ARCSEC, 3) for value in self.quantiles()]
        before = number(float(np.median(self.before.rms)) / ARCSEC, 3)
        return (
            f"on {len(self.after.rms)} units: median {before} → {middle} arcsec, 5 to 95 %: {low} to {high}; "
            f"{len(self.unstable)} not compensated"
        )


@dataclass(frozen=True, eq=False)
class Compensation(Result):
    """A controller against the plain loop, at one motor speed.

    Attributes
    ----------
    name, title : str
        Of the controller, and in words.
    speed : float
        Speed of the motor or of a forcing [rad/s], negative in backward motion.
    before, after : Residual
        Pointing error of the load under the plain loop and under the controller.
    torque, torque_before : TorqueUse
        Of the motor, under the controller and under the plain loop.
    gear_torque : float
        Largest torque in the gear [N*m] under the controller.
    orders : (orders,) array
        Orders of the kinematic error and of torques.
    amplitude_before, amplitude_after : (orders,) arrays
        0-to-peak amplitudes of the pointing error [rad].
    robustness : tuple of Robustness
        The same controller on gears of another stiffness.
    stable : bool
        True where small motions of the sampled loop decay about its operating point, and the error stayed bounded and
        did not grow.
    condition : str
        Condition under which the controller is stable, as a sentence.
    load_encoder : bool
        True for a controller that measures the load's angle.
    excluded : str
        Reason why the speed does not count: a limit of torque or gear; empty where it does.
    units : Units or None
        Many units of the type, where they were asked for.
    controller : NamedTuple
        The controller itself, with all its numbers.
    warnings, remarks : tuple of str
        Faults, and assumptions, as sentences.
    load_angle : float
        Angle of the load [rad] at which gravity is held.
    shaft : {"motor", "forcing"}
        Shaft that turns at the speed.
    rate, converged : float
        Of a controller that adapts: its slowest rate [1/s], and the time [s] from the first sample after which the rms
        of the error stays below a tenth of that under the plain loop, inf where it does not; 0 of the others.
    """

    rows: ClassVar[str] = "order"
    arrays: ClassVar[Along] = {"order": {"amplitude_before": "rad", "amplitude_after": "rad"}}

    name: str
    title: str
    speed: float
    before: Residual
    after: Residual
    torque: TorqueUse
    torque_before: TorqueUse
    gear_torque: float
    orders: Floats
    amplitude_before: Floats
    amplitude_after: Floats
    robustness: tuple[Robustness, ...]
    stable: bool
    condition: str
    load_encoder: bool
    excluded: str
    units: Units | None
    controller: Any
    warnings: tuple[str, ...]
    remarks: tuple[str, ...]
    load_angle: float = 0.0
    shaft: str = "motor"
    rate: float = 0.0
    converged: float = 0.0

    @property
    def axis(self) -> Speeds:
        """Name and unit of its speed."""
        return BASES[self.shaft]

    @property
    def pace(self) -> str:
        """Sentence on the rate of a controller that adapts; empty of the others."""
        if not self.rate:
            return ""
        left = f"the error is below a tenth of its first value after {number(self.converged, 3)} s"
        left = left if self.converged < float("inf") else "the error stays above a tenth of its first value"
        return f"{left}; slowest time constant of the adaptation {1.0 / self.rate:.3g} s"

    @property
    def gains(self) -> bool:
        """True where the rms of the error, or its mean, is below that of the plain loop by more than runs differ."""
        mean = abs(self.before.mean) - abs(self.after.mean)
        return self.stable and (gains(self.before.rms, self.after.rms) or mean > DIFFER * self.before.rms)

    @property
    def mark(self) -> str:
        """Mark of a fault in a table: "!" where the error grows, "x" where the speed does not count."""
        return "!" if not self.stable else "x" if self.excluded else ""

    @property
    def reduction(self) -> float:
        """Reduction of the rms [dB]; negative where the error grew."""
        return 20.0 * log10(self.before.rms / self.after.rms) if self.after.rms > 0.0 else float("inf")

    @property
    def rms_text(self) -> str:
        """Words on the rms of the error, before and after."""
        rms = [number(one.rms / ARCSEC, 3) for one in (self.before, self.after)]
        return f"rms pointing error {' → '.join(rms)} arcsec (before → after)"

    def on_others(self) -> tuple[str, ...]:
        """Sentences on its rate, and on its error on gears and units that differ from the model."""
        units = "" if self.units is None else str(self.units)
        return tuple(filter(None, (self.pace, *map(str, self.robustness), units)))

    def facts(self) -> tuple[Fact, ...]:
        """Row of a table."""
        return (
            Fact("controller", self.name, "controller"),
            Fact("motor_speed_rpm", self.speed), Fact("speed_rad_per_s", self.speed), Fact("shaft", self.shaft),
            Fact("", self.axis.scale * self.speed, f"{self.axis.base} {self.axis.unit}"),
            Fact("rms_before_arcsec", self.before.rms), Fact("rms_after_arcsec", self.after.rms, "after"),
            Fact("reduction_dB", self.reduction, "dB"),
            Fact("peak_before_arcsec", self.before.peak), Fact("peak_after_arcsec", self.after.peak),
            Fact("three_sigma_after_arcsec", self.after.three_sigma),
            Fact("motor_torque_rms_N_m", self.torque.rms, "rms"),
            Fact("motor_torque_peak_N_m", self.torque.peak, "peak"),
            Fact("at_limit_share", self.torque.limited), Fact("gear_torque_peak_N_m", self.gear_torque),
            Fact("load_encoder", int(self.load_encoder)), Fact("slowest_rate_per_s", self.rate),
            Fact("converged_s", self.converged), Fact("stable", int(self.stable)), Fact("excluded", self.excluded),
        )  # fmt: skip

    def coordinates(self) -> Labelled:
        """Orders of the kinematic error."""
        return {"order": ("order", self.orders, "")}

    def __str__(self) -> str:
        lines = [
            f"Compensation: {self.title}, {self.shaft} at {self.axis.said(self.speed)}",
            f"  pointing error at the samples, rms: {self.before.rms / ARCSEC:.4g} arcsec before, "
            f"{self.after.rms / ARCSEC:.4g} after ({self.reduction:.1f} dB)",
            f"  largest, with the mean of {self.after.mean / ARCSEC:.4g} arcsec: {self.before.peak / ARCSEC:.4g} "
            f"before, {self.after.peak / ARCSEC:.4g} after; 3 sigma after: {self.after.three_sigma / ARCSEC:.4g}",
            f"  torque of the motor: rms {self.torque.rms:.3g} N*m, largest {self.torque.peak:.3g} N*m, at its limit "
            f"in {100.0 * self.torque.limited:.3g} % of the samples; in the gear up to {self.gear_torque:.4g} N*m",
        ]
        lines += [f"  {sentence}" for sentence in (self.condition, *self.on_others())]
        if self.excluded:
            lines.append(f"  This speed is excluded: {self.excluded}")
        lines += [f"  Warning: {text}" for text in self.warnings] + [f"  {text}" for text in self.remarks]
        return on_screen("\n".join(lines))


@dataclass(frozen=True, eq=False)
class CompensationBench(Result):
    """Controllers against the plain loop, at several motor speeds.

    Attributes
    ----------
    speeds : (n,) array
        Speeds of the motor [rad/s].
    names : tuple of str
        Of the controllers.
    results : tuple of tuple of Compensation
        For every controller one result a speed.
    """

    rows: ClassVar[str] = "speed"

    speeds: Floats
    names: tuple[str, ...]
    results: tuple[tuple[Compensation, ...], ...]

    @property
    def axis(self) -> Speeds:
        """Name and unit of its speeds."""
        return self.results[0][0].axis

    @property
    def reduction(self) -> Floats:
        """Reductions (controllers, speeds) of the rms [dB]."""
        return np.array([[one.reduction for one in row] for row in self.results])

    def best(self, *, load_encoder: bool = True) -> tuple[Compensation, ...]:
        """The best controller at every speed, with a load's encoder or without one."""
        rows = [row for row in self.results if load_encoder or not row[0].load_encoder]

        def rank(one: Compensation) -> tuple[bool, bool, float]:  # stable, then within limits
            return not one.stable, bool(one.excluded), one.after.rms

        return tuple(min(column, key=rank) for column in zip(*rows, strict=True))

    def residuals(self, width: int) -> Iterator[str]:
        """Lines of the rms that is left [arcsec], controllers down and speeds across, in blocks of so many letters."""
        name = max(NAME, *map(len, self.names))
        at_once = max(1, (width - name - 2) // CELL)
        for begin in range(0, len(self.speeds), at_once):
            part = slice(begin, begin + at_once)
            head, scale = f"{self.axis.base} {self.axis.unit}", self.axis.scale
            yield f"  {head:{name}}" + "".join(f"{w * scale:{CELL}.5g}" for w in self.speeds[part])
            for row in self.results:
                cells = (f"{number(one.after.rms / ARCSEC, 3) + one.mark:>{CELL}}" for one in row[part])
                yield f"  {row[0].name:{name}}" + "".join(cells)
        if any(one.mark for row in self.results for one in row):
            yield "  x: motor or gear at its limit; !: the error grows"

    def coordinates(self) -> Labelled:
        """Speeds and names of the controllers."""
        return {"speed": ("speed", self.speeds, "rad/s"), "controller": ("controller", list(self.names), "")}

    def variables(self) -> Labelled:
        """Residuals and torques."""
        paths = {"before": "before.rms", "after": "after.rms", "peak": "after.peak", "torque": "torque.peak"}
        units = {"before": "rad", "after": "rad", "peak": "rad", "torque": "N*m", "stable": ""}
        values = {n: [list(map(attrgetter(paths.get(n, n)), row)) for row in self.results] for n in units}
        return {n: (("controller", "speed"), np.array(values[n]), u) for n, u in units.items()}

    def __str__(self) -> str:
        lines = ["CompensationBench: rms of the pointing error at the samples [arcsec]", *self.residuals(WIDTH)]
        notes = dict.fromkeys(text for row in self.results for one in row for text in (*one.warnings, *one.remarks))
        out = [one for row in self.results for one in row if one.excluded]
        excluded = dict.fromkeys(f"At {one.axis.said(one.speed)} {one.name}: {one.excluded}" for one in out)
        return on_screen("\n".join([*lines, *(f"  {text}" for text in (*excluded, *notes))]))
