"""`Move`: what `move` returns."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar

from ...base.facts import Fact
from ...base.number_text import number, percent
from ...base.records import Along, Result
from ...base.results import Floats
from ...model.gears.limits import Finding, gravest
from .passes import Pass

LIFE = "bearing life L10 {} (profile repeated without pause)"
ROUNDING = 1e-6  # of an energy: less is not told


@dataclass(frozen=True, eq=False)
class Move(Result):
    """A drive on a profile, from rest to the time when its vibration has decayed.

    Means and work are over the profile, its dwells included; peaks are over the whole run, between the samples too.

    Attributes
    ----------
    time : (n,) array
        Times [s] of the steps of the integration.
    reference, reference_speed : (n,) arrays
        Commanded angle of the load [rad] and speed of the motor [rad/s].
    pointing_error : (n,) array
        Reference angle of the load minus its angle [rad].
    motor_torque, gear_torque : (n,) arrays
        Torque of the motor [N*m, motor side] and torque that the gear transmits [N*m, output side].
    motor_speed : (n,) array
        Speed of the motor [rad/s].
    duration : float
        End of the profile [s].
    window : float
        Largest distance of a settled pointing error from that at rest [rad].
    settling_time : float or None
        Time [s] after the end of the last motion from which on the pointing error stays within `window` of
        `rest_error`; None if it does not within the run.
    settling_times : tuple of (float or None)
        The same of every motion of the profile, until the next one begins.
    rest_error : float
        Pointing error at rest after the last motion [rad], which waiting does not remove: gravity's twist, for one.
    end_error, peak_error, rms_error : float
        Pointing error at the end of the last motion, largest size, and root mean square [rad].
    peak_motor_torque, rms_motor_torque : float
        Of the motor's torque [N*m].
    peak_gear_torque, rms_gear_torque, average_gear_torque : float
        Of the torque in the gear [N*m]; the average is the cubic mean weighted by the turns of the motor.
    peak_speed, average_speed : float
        Largest and mean size of the motor's speed [rad/s].
    life : float or None
        L10 life of the wave generator's bearing [h] where the profile is repeated without end (`bearing_life`).
    findings : tuple of Finding
        Every comparison with a limit of the gear and of the motor.
    warnings : tuple of str
        Sentences on what is beyond a limit.
    bands : tuple of (float, float)
        Motor speeds to avoid [rad/s], as given.
    time_in_bands : tuple of float
        Time [s] that the reference spends in each.
    passes : tuple of Pass
        Resonances of the lines of the kinematic error that the reference passes.
    work : dict of str to float
        Energies [J] of the whole run by `train.power_names()`: put in by motor torque, control and load torque, then
        lost in each element.
    stored : float
        Energy [J] that the train has gained, kinetic and stored, gravity's among it.
    imbalance : float
        Energy that work and stored energy do not explain, relative to the largest energy moved.
    remarks : tuple of str
        Assumptions, as sentences.
    K_t : float or None
        Torque of the motor's current [N*m/A], where it is known.
    fault : str
        Sentence on a motor's loop that is unstable as its controller samples it: the drive does not follow this move.
    """

    time: Floats
    reference: Floats
    reference_speed: Floats
    pointing_error: Floats
    motor_torque: Floats
    gear_torque: Floats
    motor_speed: Floats
    duration: float
    window: float
    settling_time: float | None
    settling_times: tuple[float | None, ...]
    rest_error: float
    end_error: float
    peak_error: float
    rms_error: float
    peak_motor_torque: float
    rms_motor_torque: float
    peak_gear_torque: float
    rms_gear_torque: float
    average_gear_torque: float
    peak_speed: float
    average_speed: float
    life: float | None
    findings: tuple[Finding, ...]
    warnings: tuple[str, ...]
    bands: tuple[tuple[float, float], ...]
    time_in_bands: tuple[float, ...]
    passes: tuple[Pass, ...]
    work: dict[str, float]
    stored: float
    imbalance: float
    remarks: tuple[str, ...]
    K_t: float | None = None
    fault: str = ""

    rows: ClassVar[str] = "time"
    arrays: ClassVar[Along] = {
        "time": {
            "reference": "rad", "pointing_error": "rad", "motor_speed": "rad/s", "motor_torque": "N*m",
            "gear_torque": "N*m", "reference_speed": "rad/s",
        },
    }  # fmt: skip
    places: ClassVar[Along] = {"time": {"time": "s"}}

    @property
    def motor_work(self) -> float:
        """Mechanical work of the motor [J], its control included; what it takes back in braking counts against it."""
        return self.work["motor torque"] + self.work["control"]

    @property
    def dissipated(self) -> float:
        """Energy [J] that the drive has turned into heat."""
        return sum(list(self.work.values())[3:])

    @property
    def within_limits(self) -> bool | None:
        """True where gear and motor keep their limits in the move; None where none is known."""
        return not self.failures if self.findings or self.fault else None

    @property
    def failures(self) -> tuple[str, ...]:
        """Sentences on an unstable loop, and on the limits by which the move fails."""
        fault = (self.fault,) if self.fault else ()
        return fault + tuple(finding.sentence for finding in gravest(self.findings) if finding.fails)

    def facts(self) -> tuple[Fact, ...]:
        """Every fact of a move, once."""
        times = self.settling_times
        suffix = f" after each of {len(times)} motions" if len(times) > 1 else ""
        settled = ", ".join("not settled" if time is None else f"{number(time)} s" for time in times)
        return (
            Fact("failures", self.failures, "FAIL: {}"),
            Fact("passes", self.within_limits),
            Fact("duration_s", self.duration, "Move of {}"),
            Fact("window_rad", self.window, f"settling time{suffix}: {settled}, to within {{}} of the final error"),
            Fact("settling_time_s", self.settling_time),
            Fact("settling_times_s", times),
            Fact("pointing_error_rad.peak", self.peak_error, "largest {}"),
            Fact("pointing_error_rad.rms", self.rms_error, "rms {}"),
            Fact("pointing_error_rad.end", self.end_error, "at the end of the commanded motion {}"),
            Fact("pointing_error_rad.rest", self.rest_error, "final {}"),
            Fact("motor.peak_torque_N_m", self.peak_motor_torque, "peak torque {}"),
            Fact("motor.rms_torque_N_m", self.rms_motor_torque, "rms torque {}"),
            *self._currents(),
            Fact("motor.peak_speed_rpm", self.peak_speed, "peak speed {}"),
            Fact("motor.average_speed_rpm", self.average_speed, "mean speed {}"),
            Fact("motor.work_J", self.motor_work, "net work {}"),
            Fact("gear.peak_torque_N_m", self.peak_gear_torque, "peak torque {}"),
            Fact("gear.rms_torque_N_m", self.rms_gear_torque, "rms torque {}"),
            Fact("gear.cubic_mean_torque_N_m", self.average_gear_torque, "cubic mean torque {}"),
            Fact("gear.life_L10_h", self.life, "" if self.life is None else LIFE),
            Fact("limits", tuple(finding.data() for finding in self.findings)),
            Fact("speeds_to_avoid", tuple(self._in_bands()), "{}"),
            Fact("resonances_passed", tuple(item.facts() for item in self.passes)),
            Fact("", tuple(self._worst_passes()), "{}"),
            Fact("energy_J.work", self.work),
            Fact("energy_J.dissipated", self.dissipated, "dissipated {}"),
            Fact("energy_J.stored", self.stored, "stored {}" * (abs(self.stored) > ROUNDING * self.dissipated)),
            Fact("energy_J.imbalance", self.imbalance, "unexplained {}" * (self.imbalance > ROUNDING)),
            Fact("warnings", self.warnings),
            Fact("", tuple(item for item in self.warnings if item not in self.failures), "warning: {}"),
            Fact("remarks", tuple(map(str, self.remarks)), "note: {}"),
        )

    def _currents(self) -> Iterator[Fact]:
        """Largest and rms current of the motor, where they are known."""
        if self.K_t is not None:
            yield Fact("motor.peak_current_A", self.peak_motor_torque / self.K_t, "peak current {}")
            yield Fact("motor.rms_current_A", self.rms_motor_torque / self.K_t, "rms current {}")

    def _in_bands(self) -> Iterator[tuple[Fact, ...]]:
        """A row for each band of speeds to avoid: its ends, the time there, and its share of the profile."""
        for (low, high), time in zip(self.bands, self.time_in_bands, strict=True):
            ends = Fact("from_rpm", low, "speeds to avoid: from"), Fact("to_rpm", high, "to")
            share = Fact("", percent(time / self.duration, 3), "share of the move")
            yield *ends, Fact("time_s", time, "time in them"), share

    def _worst_passes(self) -> Iterator[tuple[Fact, ...]]:
        """A row for each speed at which an order meets a resonance."""
        for speed in dict.fromkeys((p.order, p.speed) for p in self.passes):
            every = [p for p in self.passes if (p.order, p.speed) == speed]
            yield max(every, key=lambda one: one.largest).row(len(every))
