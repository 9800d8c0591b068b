"""Results of sampled loops: one in time, and what was measured of many."""

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from ...records import Labelled, Result
from ...results import Floats
from ...sentences import on_screen
from ...units import ARCSEC


@dataclass(frozen=True, eq=False)
class LoopRun(Result):
    """One sampled loop in time.

    Attributes
    ----------
    time : (n,) array
        Times [s] of the samples that were kept.
    error : (n,) array
        What the loop watches first [rad]: of a drive the pointing error of the load.
    torque : (n,) array
        Torque [N*m] that the sample asked for, after its limit; it acts a delay later.
    gear_torque : (n,) array
        What the loop watches second [N*m].
    states : (states, n) array
        States of the plant.
    memory : NamedTuple
        What the loop remembers at the end.
    steps : int
        Steps of the integration between two samples.
    """

    rows: ClassVar[str] = "time"

    time: Floats
    error: Floats
    torque: Floats
    gear_torque: Floats
    states: Floats
    memory: Any
    steps: int

    def coordinates(self) -> Labelled:
        """Times of the samples."""
        return {"time": ("time", self.time, "s")}

    def variables(self) -> Labelled:
        """Error, torques and states."""
        return {
            "error": ("time", self.error, "rad"),
            "torque": ("time", self.torque, "N*m"),
            "gear_torque": ("time", self.gear_torque, "N*m"),
            "states": (("state", "time"), self.states, ""),
        }

    def rms(self, settle: float = 0.0) -> float:
        """Root mean square of the error [rad] from a time [s] on, its mean taken away."""
        return float(np.std(self.error[self.time >= settle]))

    def __str__(self) -> str:
        late = self.error[len(self.error) // 2 :]
        return on_screen(
            f"LoopRun: {len(self.time)} samples to {self.time[-1]:.4g} s; in the second half the error has an rms of "
            f"{np.std(late) / ARCSEC:.4g} arcsec about {np.mean(late) / ARCSEC:.4g} arcsec, torque up to "
            f"{np.max(np.abs(self.torque)):.4g} N*m"
        )

    __repr__ = __str__


@dataclass(frozen=True, eq=False)
class LoopEnsemble(Result):
    """What was measured of many sampled loops, of each over the samples after `settle`.

    Attributes
    ----------
    mean, rms, peak : (lanes,) arrays
        Mean of the error [rad], root mean square about it and about its trend, a straight line, and largest size.
    torque_rms, torque_peak : (lanes,) arrays
        Of the controller's torque [N*m] after its limit.
    gear_torque : (lanes,) array
        Largest torque in the gear [N*m].
    limited, lost : (lanes,) arrays
        Shares of all samples whose torque was limited, and whose angle of the motor was lost.
    amplitude, phase : (orders, lanes) arrays
        0-to-peak [rad] and phase [rad] of the error at each order of the reference angle: amplitude cos(order angle +
        phase).
    orders : (orders,) array
        The orders.
    stable : (lanes,) array of bool
        Whether the error stayed bounded, and its root mean square did not grow by half from the first half of what is
        measured to the second, decayed errors and those below a step of the encoders apart.
    steps : int
        Steps of the integration between two samples.
    """

    rows: ClassVar[str] = "lane"

    mean: Floats
    rms: Floats
    peak: Floats
    torque_rms: Floats
    torque_peak: Floats
    gear_torque: Floats
    limited: Floats
    lost: Floats
    amplitude: Floats
    phase: Floats
    orders: Floats
    stable: Any
    steps: int

    def coordinates(self) -> Labelled:
        """Orders of the amplitudes."""
        return {"order": ("order", self.orders, "")}

    def variables(self) -> Labelled:
        """Every measure by lane."""
        units = {"mean": "rad", "rms": "rad", "peak": "rad", "torque_rms": "N*m", "torque_peak": "N*m",
                 "gear_torque": "N*m", "limited": "", "lost": "", "stable": ""}  # fmt: skip
        found: dict[str, Any] = {name: ("lane", getattr(self, name), unit) for name, unit in units.items()}
        return found | {
            "amplitude": (("order", "lane"), self.amplitude, "rad"),
            "phase": (("order", "lane"), self.phase, "rad"),
        }

    def __str__(self) -> str:
        low, middle, high = np.quantile(self.rms, (0.05, 0.5, 0.95)) / ARCSEC
        return on_screen(
            f"LoopEnsemble: {len(self.rms)} loops, {int(np.sum(~self.stable))} of them unstable; rms of the error "
            f"{middle:.4g} arcsec (5 to 95 %: {low:.4g} to {high:.4g})"
        )

    __repr__ = __str__
