"""Kinematic errors from few numbers: a vendor's accuracy class, measured values, static sources; their peak-to-peak.

The peak-to-peak of several lines depends on their phases: at most twice the sum of the amplitudes, and mostly less.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial, reduce
from math import gcd, pi
from types import MappingProxyType
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..base.quantities import LARGEST, SMALLEST, checked, number, shown
from ..base.results import Floats
from ..base.units import ARCSEC
from .excitation import KinematicError, Line
from .orders import Turn, order_map

DEFAULT_SHARES: Mapping[int, float] = MappingProxyType({1: 0.25, 2: 1.0, 4: 0.25})
OVERSAMPLING = 16  # points per turn of the highest line
NEWTON = 4  # steps from 16 points a period: the error falls below rounding in three


class LoadedError(NamedTuple):
    """Kinematic error whose amplitudes depend on the torque in the gear and on the direction in which the motor turns.

    `at_rest` has the lines without a torque, `backward` those of backward motion where they are others; `per_torque` is
    the growth [rad/(N*m)] of each amplitude. The torque is the mean or static one, and the direction is that of a
    steady motion: either error is then a function of the motor's angle, and Lagrange's equations of the train hold as
    they are. Were the torque of each moment meant, x = e(theta) + a(theta) T + u(T), the gear would have the compliance
    a(theta) in series, with the energy a T^2/2 and the torque a' T^2/2 on the motor: a stiffness that varies,
    `Variation`. A direction that changes would step from one error to the other, which is a hysteresis of the law.
    """

    at_rest: KinematicError
    per_torque: tuple[float, ...]
    backward: KinematicError | None = None

    def under(self, torque: float, *, backward: bool = False) -> KinematicError:
        """Lines A + per_torque T under a mean torque T [N*m, output side], in backward motion or in forward motion.

        T is what the gear transmits: with a load alone its torque with the sign turned round. An amplitude that has
        become negative is a line half a turn of phase on. Numbers that are none, or not one for each line, are refused
        (ValueError).
        """
        error = checked(self.backward if backward and self.backward is not None else self.at_rest)
        growth, T = tuple(self.per_torque), number("torque [N*m]", torque)
        if len(growth) != len(error.lines):
            raise ValueError(
                f"per_torque has {len(growth)} numbers and the error {len(error.lines)} lines; give one for each"
            )
        grown = zip(error.lines, map(partial(number, "per_torque [rad/(N*m)]"), growth), strict=True)
        return KinematicError(tuple(line._replace(amplitude=line.amplitude + g * T) for line, g in grown))


def extremes(orders: ArrayLike, cosines: ArrayLike, sines: ArrayLike) -> tuple[float, float]:
    """Smallest and largest value over a turn of the sum of cosines_k cos(orders_k t) + sines_k sin(orders_k t).

    Parameters
    ----------
    orders : (m,) int array
        Whole numbers of at least 1.
    cosines, sines : (m,) arrays
        Amplitudes.

    Returns
    -------
    float, float
        To rounding: the extremes of a grid, refined by Newton's method.
    """
    k = np.asarray(orders, int)
    a, b = np.asarray(cosines, float), np.asarray(sines, float)
    used = np.hypot(a, b) > 0.0
    if not used.any():
        return 0.0, 0.0
    k, a, b = k[used], a[used], b[used]
    k = k // reduce(gcd, (int(order) for order in k))
    n = OVERSAMPLING * int(k.max())
    series = np.zeros(n // 2 + 1, complex)
    np.add.at(series, k, 0.5 * n * (a - 1j * b))
    values = np.fft.irfft(series, n)
    return -_largest(k, -a, -b, -values), _largest(k, a, b, values)


def _largest(k: NDArray[np.int_], a: Floats, b: Floats, values: Floats) -> float:
    best = float(np.max(values))
    # a maximum between the points exceeds the largest of them by at most 1/cos(pi/16) (Ehlich & Zeller 1964)
    bound = best - 0.02 * float(np.max(np.abs(values)))
    tops = (values >= np.roll(values, 1)) & (values >= np.roll(values, -1)) & (values >= bound)
    step = 2.0 * pi / len(values)
    start = step * np.flatnonzero(tops)[:, None]
    t = start
    for _ in range(NEWTON):
        c, s = np.cos(k * t), np.sin(k * t)
        slope = ((b * c - a * s) * k).sum(1, keepdims=True)
        bend = -((a * c + b * s) * k * k).sum(1, keepdims=True)
        t = np.clip(t - np.divide(slope, bend, out=np.zeros_like(slope), where=bend < 0.0), start - step, start + step)
    return max(best, float(np.max((a * np.cos(k * t) + b * np.sin(k * t)).sum(1))))


def peak_to_peak(error: KinematicError) -> float:
    """Largest minus smallest value [rad] of a kinematic error over a turn of its base angle.

    Parameters
    ----------
    error : KinematicError
        Its lines.

    Returns
    -------
    float
        Exact to rounding; what vendors call transmission accuracy, for all lines of a gear on the output turn.

    Raises
    ------
    TypeError, ValueError
        If the lines are wrong.
    """
    error = checked(error)
    orders = [line.order for line in error.lines]
    if any(order % 1 for order in orders):
        raise ValueError(
            "a line of the output's turn does not repeat with the turn of its base angle; take on_output_turn(error, "
            "N) first"
        )
    amplitudes = np.array([line.amplitude for line in error.lines])
    phases = np.array([line.phase for line in error.lines])
    low, high = extremes(orders, amplitudes * np.cos(phases), -amplitudes * np.sin(phases))
    return high - low


def accuracy_spectrum(
    accuracy: float, shares: Mapping[int, float] = DEFAULT_SHARES, phases: Mapping[int, float] | None = None
) -> KinematicError:
    """Default kinematic error of a gear that just reaches its vendor's accuracy class.

    A class gives one number, the peak-to-peak transmission error over one output turn without reversal, not a spectrum.
    That order 2 of the wave generator dominates is published (Harmonic Drive, CSF-3 manual, p. 14: two elements of the
    error per input turn; Yao, Chen & Xing 2022), and simulations put orders 1 and 4 beside it. How the amplitudes share
    the class is an assumption, 1 : 4 : 1 for the orders 1, 2, 4 with all phases zero: measure the gear where it matters
    (`error_scan`), units of one type differ by a factor of about 3.

    Parameters
    ----------
    accuracy : float
        Peak-to-peak [rad, output side], for example `catalogue.gear("CSG-40-50").accuracy`.
    shares : mapping of int to float
        Order on the motor turn to relative amplitude.
    phases : mapping of int to float, optional
        Order to phase [rad]; 0 where it is not given.

    Returns
    -------
    KinematicError
        Lines on the motor turn whose true peak-to-peak, not the sum of the amplitudes, is `accuracy`.

    Raises
    ------
    ValueError
        If the accuracy is not positive, a share is negative or no number, all are zero, or a phase has no share.
    """
    if accuracy is None or not SMALLEST <= (accuracy := float(accuracy)) <= LARGEST:
        raise ValueError(
            f"accuracy is {shown(accuracy)}; it must be a positive angle in rad, peak-to-peak; where the catalogue has "
            "none (None), take it from the datasheet"
        )
    phases = {} if phases is None else phases
    for order, share in shares.items():
        if order % 1 != 0:
            raise ValueError(f"an order of the shares must be a whole number, not {shown(order)}")
        if not 0.0 <= share <= LARGEST:
            raise ValueError(f"the share of order {order} is {shown(share)}; it must be a number, zero or more")
    if not any(shares.values()):
        raise ValueError("no order has a share of the accuracy; write for example {1: 0.25, 2: 1.0, 4: 0.25}")
    for order in phases:
        if order not in shares:
            raise ValueError(
                f"order {order} has a phase and no share; shares are given for {', '.join(map(str, shares))}"
            )
    largest = max(shares.values())
    lines = tuple(Line(k, share / largest, phases.get(k, 0.0)) for k, share in shares.items() if share > 0.0)
    unscaled: KinematicError = checked(KinematicError(lines))
    factor = accuracy / peak_to_peak(unscaled)
    return KinematicError(tuple(line._replace(amplitude=factor * line.amplitude) for line in sorted(unscaled.lines)))


@dataclass(frozen=True)
class MeasuredError:
    """A published measurement of a kinematic error.

    Attributes
    ----------
    gear : str
        Measured gear.
    ratio : int or None
        Its ratio.
    peak_to_peak : float
        Largest minus smallest error [rad, output side]; the middle where the source gives a range.
    order : int or None
        Dominant order on the motor turn, None where the source leaves it open.
    source : str
        Publication, and what else it says.
    """

    gear: str
    ratio: int | None
    peak_to_peak: float
    order: int | None
    source: str

    def error(self, order: int = 2) -> KinematicError:
        """One line with this peak-to-peak on the dominant order, on the given one where the source names none."""
        line = Line(self.order or order, 0.5 * self.peak_to_peak)
        return KinematicError((line,))


MEASURED_ERRORS = (
    MeasuredError(
        "CSF-17-100-2UH", 100, 46.0 * ARCSEC, 2,
        "github.com/polvinc/DHEM (MIT), star drift: +-23 arcsec, period about 440 s at one output turn per day",
    ),
    MeasuredError(
        "Rainbow RST-135 mount", 100, 40.0 * ARCSEC, 2,
        "PHD2 wiki: about 40 arcsec peak-to-peak by users (maker: +-30 arcsec), period 430.82 s at the sidereal rate",
    ),
    MeasuredError("ZWO AM5 mount", None, 40.0 * ARCSEC, None, "github.com/polvinc/DHEM (MIT): about +-20 arcsec"),
    MeasuredError(
        "size 20, 160:1, unnamed maker", 160, 132.5 * ARCSEC, None,
        "cloudynights.com/topic/918602, encoders on both sides, no load: 120 to 145 arcsec peak-to-peak, 45 arcsec rms",
    ),
)  # fmt: skip


class Source(NamedTuple):
    """One contributor to the kinematic error.

    `kind` is one of design, manufacture, assembly, deformation; `order` counts repeats per `turn` of the motor (the
    wave generator) or of the output; `amplitude` is 0-to-peak [rad, output side]; `phase` [rad] is None where unknown.
    """

    name: str
    kind: str
    order: int
    amplitude: float
    phase: float | None = None
    turn: Turn = "motor"


def static_sources(N: float) -> dict[str, Source]:
    """List the usual static sources of a gear of ratio N with their kinds and orders, all with the amplitude 0.

    The orders follow from the geometry (`order_map`), to first order in the deviations; sizes and what else a design
    has are the designer's to give: `static_sources(50)["flexspline run-out"]._replace(amplitude=1e-5)`.

    Parameters
    ----------
    N : float
        Ratio, a whole number.

    Returns
    -------
    dict of str to Source
        By name: the kind of each source, its order per motor turn, and its amplitude [rad], 0.

    Raises
    ------
    ValueError
        If N is not an integer of 2 to 10 000.
    """
    engagement = int(order_map(N).order("flexspline tooth engagement").per_output_turn)
    rows: list[tuple[str, str, int, Turn]] = [
        ("approximate tooth profile", "design", 2, "motor"),
        ("wave generator eccentricity", "manufacture", 1, "motor"),
        ("wave generator ellipticity", "manufacture", 2, "motor"),
        ("circular spline ovality", "manufacture", 2, "motor"),
        ("circular spline four-lobed", "manufacture", 4, "motor"),
        ("flexspline ovality", "manufacture", engagement, "output"),
        ("flexspline run-out", "manufacture", 1, "output"),
        ("coupling offset", "assembly", 1, "motor"),
        ("circular spline misalignment", "assembly", 2, "motor"),
        ("output bearing run-out", "assembly", 1, "output"),
        ("flexspline deformation under load", "deformation", 2, "motor"),
        ("circular spline deformation by its screws", "deformation", 4, "motor"),
    ]
    return {name: Source(name, kind, order, 0.0, turn=turn) for name, kind, order, turn in rows}
