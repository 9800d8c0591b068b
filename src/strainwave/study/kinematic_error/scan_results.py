"""What a measured error scan gives: lines with their uncertainty, the noise, what changes with the direction."""

import math
from dataclasses import dataclass
from typing import Literal

from ...model.excitation import KinematicError, Line
from ...model.gears.error_spectrum import extremes
from ...sentences import on_screen

Noise = Literal["white", "autocorrelated"]


@dataclass(frozen=True)
class ScanLine:
    """One line of a scan: amplitude cos(order * angle + phase).

    Attributes
    ----------
    order : int
        Repeats per turn of the scan's angle.
    amplitude, amplitude_error : float
        0-to-peak and its standard error [rad].
    phase, phase_error : float
        Phase and its standard error [rad]; means little where the amplitude is below three standard errors.
    false_alarm : float
        Probability that noise alone makes such a line at one of the orders looked at.
    """

    order: int
    amplitude: float
    amplitude_error: float
    phase: float
    phase_error: float
    false_alarm: float


@dataclass(frozen=True)
class Reversal:
    """What changes with the direction of rotation: forward minus backward.

    Attributes
    ----------
    lost_motion, lost_motion_error : float
        Difference of the mean errors and its standard error [rad]; positive where friction winds up the gear.
    peak_to_peak : float
        Peak-to-peak [rad] of the lines of the difference.
    """

    lost_motion: float
    lost_motion_error: float
    peak_to_peak: float


@dataclass(frozen=True)
class ErrorScan:
    """Lines of a measured error; `str()` prints them as a table.

    Attributes
    ----------
    lines : tuple of ScanLine
        Ascending in the order; with both directions the mean of the two.
    mean : float
        Error at the middle of the scan without lines [rad].
    drift : float
        Its change [rad per rad of the angle], removed with the mean.
    residual : float
        Root mean square [rad] of what neither lines nor drift explain.
    autocorrelation : float
        Of neighbouring residuals, -1 to 1.
    noise : {"white", "autocorrelated"}
        What the standard errors take the residual for. White: s^2 (X'X)^-1. Autocorrelated: the same with the
        residual's spectrum around each order instead of s^2.
    threshold : float
        Amplitude [rad] above which a line is found, at the median noise over the orders.
    samples : int
        Samples of both directions.
    turns : float
        Turns of the angle scanned, the smaller where there are two directions.
    reversal : Reversal or None
        What changes with the direction, if both were scanned.
    """

    lines: tuple[ScanLine, ...]
    mean: float
    drift: float
    residual: float
    autocorrelation: float
    noise: Noise
    threshold: float
    samples: int
    turns: float
    reversal: Reversal | None

    @property
    def error(self) -> KinematicError:
        """The lines as a kinematic error.

        Raises
        ------
        ValueError
            If the scan has none.
        """
        if not self.lines:
            raise ValueError(f"the scan has no line above {self.threshold:.3g} rad; use NoError(), or scan more turns")
        return KinematicError(tuple(Line(line.order, line.amplitude, line.phase) for line in self.lines))

    @property
    def peak_to_peak(self) -> float:
        """Peak-to-peak [rad] of all lines together over a turn."""
        a = [line.amplitude * math.cos(line.phase) for line in self.lines]
        b = [-line.amplitude * math.sin(line.phase) for line in self.lines]
        low, high = extremes([line.order for line in self.lines], a, b)
        return high - low

    def __str__(self) -> str:
        rows = [f"{'order':>6}  {'amplitude (rad)':<24}{'phase (rad)':<20}{'false alarm':>12}"]
        for line in self.lines:
            amplitude = f"{line.amplitude:.4g} ± {line.amplitude_error:.2g}"
            phase = f"{line.phase:.3f} ± {line.phase_error:.2g}"
            rows.append(f"{line.order:>6}  {amplitude:<24}{phase:<20}{line.false_alarm:>12.1e}")
        rows.append(f"lines together: {self.peak_to_peak:.4g} rad peak-to-peak; found above {self.threshold:.2g} rad")
        rows.append(f"{self.samples} samples over {self.turns:.4g} turns")
        rows.append(f"residual: {self.residual:.3g} rad rms, {self.noise} noise")
        if self.reversal is not None:
            r = self.reversal
            rows.append(
                f"reversal: lost motion {r.lost_motion:.4g} ± {r.lost_motion_error:.2g} rad, its variation "
                f"{r.peak_to_peak:.3g} rad peak-to-peak"
            )
        return on_screen("\n".join(rows))
