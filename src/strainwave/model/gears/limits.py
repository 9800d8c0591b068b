"""Loads of a run against the limits of a gear's datasheet. Beyond a limit is a finding, never an error."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...base.quantities import number, numbers
from ...base.units import RPM
from .gear import Gear

RATCHETING = 16.0  # times the rated torque: CSF/CSG catalogue, p. 14, has 4.8 (CSG-17-120) to 15.7 (CSG-14-50)
DUTY = "average_rpm"  # a limit of the mean over a duty cycle: no speed by itself says how long it lasts
RATED = "motor rated speed"  # the same of a motor

# Limits of the peak torque, and what to do beyond them.
TORQUES = (
    ("repeated_peak_torque", "reduce the load or the vibration, or choose a larger gear"),
    ("momentary_torque", "the gear is damaged; reduce the load or the vibration, or choose a larger gear"),
    (
        "ratcheting_torque",
        "the teeth skip and results are invalid; reduce the load or the vibration, or choose a larger gear",
    ),
    ("buckling_torque", "the flexspline collapses; choose a larger gear"),
)


@dataclass(frozen=True)
class Finding:
    """One comparison of a run with a limit.

    Attributes
    ----------
    limit : str
        Name of the limit in the record, for example "repeated_peak_torque".
    value, bound : float
        Value that the run reached, and the limit, both in `unit`.
    unit : str
        "N*m" (output side) or "rpm" (input speed, as datasheets print it).
    sentence : str
        Fact, value and, beyond the limit, the remedy; then the doubts of the record about the limit.
    omega : float or None
        Speed of the motor [rad/s] at which that is, where a limit of the motor depends on it.
    """

    limit: str
    value: float
    bound: float
    unit: str
    sentence: str
    omega: float | None = None

    @property
    def exceeded(self) -> bool:
        """True if the run went beyond the limit (by more than rounding)."""
        return self.value > self.bound * (1.0 + 1e-9)

    @property
    def fails(self) -> bool:
        """True if a drive fails by it: not by the average input speed, beyond which it may turn for a short time."""
        return self.exceeded and self.limit not in (DUTY, RATED)

    def data(self) -> dict[str, Any]:
        """It as plain data; `fails` says whether a drive fails by it."""
        return {name: getattr(self, name) for name in ("limit", "value", "bound", "unit", "exceeded", "fails")}


def check_limits(
    gear: Gear,
    *,
    peak_torque: float | None = None,
    average_torque: float | None = None,
    max_speed: float | None = None,
    average_speed: float | None = None,
) -> tuple[Finding, ...]:
    """Compare what a run did with every limit that the gear's record has.

    Parameters
    ----------
    gear : Gear
        The record.
    peak_torque : float, optional
        Largest size of the torque in the gear [N*m, output side], which the repeated peak, momentary, ratcheting and
        buckling torques limit.
    average_torque : float, optional
        Its cubic mean [N*m, output side], see `cubic_mean`.
    max_speed, average_speed : float, optional
        Largest and mean input speed [rad/s, motor side].

    Returns
    -------
    tuple of Finding
        One for each quantity given and limit known, in the order speed, average torque, peak torques; `exceeded` says
        which matter.

    Raises
    ------
    ValueError
        If a quantity is no finite number.
    """
    findings = []

    def compare(limit: str, value: float, unit: str, fact: str, remedy: str) -> None:
        bound = getattr(gear, limit)
        if bound is not None:
            exceeded = Finding(limit, value, float(bound), unit, "").exceeded
            relation = f"above the {_words(limit)}" if exceeded else f"within the {_words(limit)}"
            end = f"; {remedy}" if exceeded else ""
            sentence = f"{fact} {value:.4g} {unit}, {relation} of {gear.name}, {bound:.6g} {unit}{end}."
            text = " ".join((sentence, *gear.doubts_about(limit)))
            findings.append(Finding(limit, value, float(bound), unit, text))

    if max_speed is not None:
        rpm = abs(number("max_speed", max_speed)) / RPM
        compare("max_rpm", rpm, "rpm", "The input speed reaches", "reduce the speed, or choose a smaller gear")
    if average_speed is not None:
        rpm = abs(number("average_speed", average_speed)) / RPM
        fact = "The input speed reaches" if average_speed == max_speed else "The mean input speed is"
        compare("average_rpm", rpm, "rpm", fact, "run at this speed for a short time only")
    if average_torque is not None:
        mean = abs(number("average_torque", average_torque))
        remedy = "the bearing life is short; reduce the load, or choose a larger gear"
        compare("average_torque", mean, "N*m", "The cubic mean of the gear torque is", remedy)
    if peak_torque is not None:
        peak = abs(number("peak_torque", peak_torque))
        for limit, remedy in TORQUES:
            compare(limit, peak, "N*m", "The gear torque reaches", remedy)
    return tuple(findings)


def gravest(findings: tuple[Finding, ...]) -> tuple[Finding, ...]:
    """Limits that were passed: of the peak torques and of the input speeds only the gravest."""
    exceeded = {f.limit: f for f in findings if f.exceeded}
    for grave, less in (
        ("max_rpm", "average_rpm"),
        ("momentary_torque", "repeated_peak_torque"),
        ("ratcheting_torque", "momentary_torque"),
        ("buckling_torque", "ratcheting_torque"),
    ):
        if grave in exceeded:
            exceeded.pop(less, None)
    return tuple(exceeded.values())


def cubic_mean(torque: Any, weights: Any = None) -> float:
    """Mean torque [N*m] that a bearing's life goes by: the cube root of the mean of |T|^3.

    Parameters
    ----------
    torque : array_like
        Torques [N*m], equally spaced in time unless weighted.
    weights : array_like, optional
        Turns of the input that each torque lasts (size of the speed times time).

    Raises
    ------
    ValueError
        If torques or weights are no finite numbers, or the weights are negative or all zero.

    References
    ----------
    Harmonic Drive LLC, CSF/CSG catalogue, p. 14: life is proportional to (rated/average torque)^3 and to turns.
    """
    size = numbers("torque", torque)
    if weights is not None:
        weights = numbers("weights", weights, count=size.size)
        if np.any(weights < 0.0) or not np.any(weights > 0.0):
            raise ValueError("the weights must not be negative nor all zero; give absolute values of the turns")
    return float(cubic_means(size[None], weights)[0])


def cubic_means(torque: NDArray[np.float64], weights: Any = None) -> NDArray[np.float64]:
    """Cubic means (n,) [N*m] of rows (n, samples) of torques [N*m], each as `cubic_mean`; all have the same weights."""
    size = np.abs(torque)
    top = np.max(size, axis=1, keepdims=True)
    share = np.divide(size, top, out=np.zeros_like(size), where=top > 0.0)
    return np.asarray(top[:, 0] * np.cbrt(np.average(share * share * share, axis=1, weights=weights)))


def _words(limit: str) -> str:
    names = {"max_rpm": "largest input speed (grease)", "average_rpm": "largest average input speed (grease)"}
    return names.get(limit, ("limit for " if limit == "average_torque" else "") + limit.replace("_", " "))


# L10 [h] at rated torque and speed, a fifth of the printed L50.
LONG, USUAL = 10_000.0, 7_000.0
LONG_SERIES = ("CSG", "SHG")
RATED_SPEED = 2000.0 * RPM


def bearing_life(gear: Gear, average_torque: float, average_speed: float) -> float | None:
    """Hours after which one bearing in ten has failed: L10 = L_n (T_rated/T_av)^3 (n_rated/n_av).

    L_n is 10 000 h for the series CSG and SHG, 7000 h for the others; n_rated is 2000 rpm.

    Parameters
    ----------
    gear : Gear
        The record.
    average_torque : float
        Cubic mean of the torque in the gear, weighted by the turns of the input [N*m, output side] (`cubic_mean`).
    average_speed : float
        Mean size of the input speed over the whole time, dwells included [rad/s, motor side].

    Returns
    -------
    float or None
        Hours; None where the record has no rated torque, or nothing turns under torque.

    Raises
    ------
    ValueError
        If a number is not finite.

    References
    ----------
    Harmonic Drive LLC, CSF/CSG catalogue, p. 14, eq. 8; Harmonic Drive SE, engineering data 1019658 (2014), sec. 4.1.2:
    L50 is 50 000 h for CSG and SHG, 35 000 h for HFUC, HFUS, CSD, CSF and SHD, and L10 about a fifth of it.
    """
    torque = abs(number("average_torque [N*m]", average_torque))
    speed = abs(number("average_speed [rad/s]", average_speed))
    if gear.rated_torque is None or not torque * speed > 0.0:
        return None
    hours, share = LONG if gear.series in LONG_SERIES else USUAL, gear.rated_torque / torque
    hours *= share * share * share * (RATED_SPEED / speed)
    return hours if math.isfinite(hours) else None
