"""Result of an error scan: lines with their uncertainty, the noise, the change with the direction."""

import math
from dataclasses import dataclass, field
from typing import Literal, NamedTuple

import numpy as np

from ....base.number_text import number
from ....base.results import Floats
from ....base.terminal import on_screen
from ....base.units import ARCSEC
from ....model.error_spectrum import peak_to_peak
from ....model.excitation import KinematicError, Line

Noise = Literal["white", "autocorrelated"]


@dataclass(frozen=True)
class ScanLine:
    """One line of a scan: amplitude cos(order * angle + phase).

    Attributes
    ----------
    order : float
        Repeats per turn of the scan's angle; whole, but for lines between whole orders.
    amplitude, amplitude_error : float
        0-to-peak and its standard error [rad].
    phase, phase_error : float
        Phase and its standard error [rad]; means little where the amplitude is below three standard errors.
    false_alarm : float
        Probability that noise alone makes such a line at one of the orders looked at.
    """

    order: float
    amplitude: float
    amplitude_error: float
    phase: float
    phase_error: float
    false_alarm: float


@dataclass(frozen=True)
class Reversal:
    """Change with the direction of rotation: forward minus backward.

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
    between : tuple of ScanLine
        Lines between whole orders, which `error` and a project file do not hold.
    limit : float
        Order up to which the angles tell lines apart; a line above it shows below it.
    aliases : dict of float to array
        By the order of a line those of a drive that the angles do not tell from it.
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
    between: tuple[ScanLine, ...] = ()
    limit: float = math.inf
    aliases: dict[float, Floats] = field(default_factory=dict)

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
        return peak_to_peak(self.error) if self.lines else 0.0

    def __str__(self) -> str:
        def arcsec(angle: float, digits: int = 4) -> str:
            return number(angle / ARCSEC, digits)

        rows = [f"{'order':>6}  {'amplitude (arcsec)':<24}{'phase (deg)':<20}{'false alarm':>12}  ± one standard error"]
        for line in sorted((*self.lines, *self.between), key=lambda line: line.order):
            amplitude = f"{arcsec(line.amplitude)} ± {arcsec(line.amplitude_error, 2)}"
            phase = f"{number(math.degrees(line.phase))} ± {number(math.degrees(line.phase_error), 2)}"
            rows.append(f"{line.order:>6.6g}  {amplitude:<24}{phase:<20}{line.false_alarm:>12.1e}")
        together, least = arcsec(self.peak_to_peak), arcsec(self.threshold, 2)
        rows.append(f"lines together: {together} arcsec peak-to-peak; detection limit {least} arcsec")
        rows.append(f"{self.samples} samples over {self.turns:.4g} turns")
        if self.between:
            places = ", ".join(f"{line.order:.4g}" for line in self.between)
            rows.append(f"between whole orders: {places}; a project file cannot contain them")
        for order, others in self.aliases.items():
            listing = ", ".join(f"{other:g}" for other in others)
            rows.append(f"order {order:g} may be order {listing}: not separable here; scan at other, uneven angles")
        if not self.aliases:
            rows.append(f"these angles resolve orders below {self.limit:.4g}; higher orders appear as lower ones")
        rows.append(f"residual: {arcsec(self.residual, 3)} arcsec rms, {self.noise} noise")
        if self.reversal is not None:
            lost, error, peak = self.reversal.lost_motion, self.reversal.lost_motion_error, self.reversal.peak_to_peak
            rows.append(
                f"reversal: lost motion {arcsec(lost)} ± {arcsec(error, 2)} arcsec, its variation {arcsec(peak, 3)} "
                "arcsec peak-to-peak"
            )
        return on_screen("\n".join(rows))


class Polar(NamedTuple):
    """A line by amplitude and phase, each with its standard error to first order."""

    amplitude: float
    amplitude_error: float
    phase: float
    phase_error: float


def polar(c: complex, covariance: Floats) -> Polar:
    """Amplitude and phase of c, whose real and imaginary part have this covariance (2, 2)."""
    amplitude = abs(c)
    if amplitude == 0.0:
        return Polar(0.0, math.sqrt(float(np.trace(covariance)) / 2.0), 0.0, math.pi)
    along, across = np.array([c.real, c.imag]) / amplitude, np.array([-c.imag, c.real]) / amplitude
    errors = (math.sqrt(max(float(one @ covariance @ one), 0.0)) for one in (along, across))
    return Polar(amplitude, next(errors), math.atan2(c.imag, c.real), next(errors) / amplitude)
