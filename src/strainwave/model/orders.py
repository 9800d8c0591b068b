"""Order map of a gear: how often each periodic error repeats per turn of the wave generator and of the output.

Circular spline fixed, wave generator in, flexspline out: z1 = 2 N teeth on the flexspline, z2 = z1 + 2 on the circular
spline. The wave generator has two lobes half a turn apart, so of a deviation that repeats n times around a ring the two
meshes add up the even n and cancel the odd ones. Per motor turn the wave generator turns once against the circular
spline and 1 + 1/N = z2/z1 times against the flexspline, which runs the other way. The output turn is the base angle on
which all these orders are whole numbers.

Static sources of the kinematic error: what a gear's design, manufacture, assembly and deformation contribute.

The source article names design, assembly and the deformation of the flexspline; the manufacturing deviations of the
parts are a kind of their own here. The orders follow from the two lobes of the wave generator.
"""

from dataclasses import dataclass
from fractions import Fraction
from math import pi
from typing import Any, Literal, NamedTuple

from ..base.quantities import checked, number, shown
from ..base.sentences import on_screen
from .excitation import Harmonic, Harmonics, KinematicError

LARGEST_RATIO = 10_000
SAME_ORDER = 1e-9


@dataclass(frozen=True)
class GearOrder:
    """One periodic error of a gear.

    Attributes
    ----------
    name, source : str
        What repeats, and which deviations it comes from.
    formula : str
        Its order per motor turn in N, z1 and z2.
    per_motor_turn : Fraction
        How often it repeats per turn of the wave generator.
    per_output_turn : int
        How often it repeats per turn of the output, N times that.
    """

    name: str
    source: str
    formula: str
    per_motor_turn: Fraction
    per_output_turn: int

    def frequency_hz(self, omega_m: float) -> float:
        """Frequency [Hz] at the motor speed `omega_m` [rad/s]."""
        return float(self.per_motor_turn) * abs(number("omega_m [rad/s]", omega_m)) / (2.0 * pi)


@dataclass(frozen=True)
class OrderMap:
    """The orders of one gear; `str()` prints them as a table.

    Attributes
    ----------
    N : int
        Ratio.
    z1, z2 : int
        Teeth of the flexspline and of the circular spline.
    orders : tuple of GearOrder
        Ascending.
    """

    N: int
    z1: int
    z2: int
    orders: tuple[GearOrder, ...]

    def order(self, name: str) -> GearOrder:
        """Return the order of this name.

        Raises
        ------
        ValueError
            If there is none.
        """
        for found in self.orders:
            if found.name == name:
                return found
        raise ValueError(f"the order map has no {shown(name)}; it has {', '.join(o.name for o in self.orders)}")

    def __str__(self) -> str:
        head = f"ratio {self.N}, z1 = {self.z1}, z2 = {self.z2} teeth (circular spline fixed)\n"
        rows = [("", "per motor turn", "", "per output turn")]
        rows += [(o.name, o.formula, str(o.per_motor_turn), str(o.per_output_turn)) for o in self.orders]
        return on_screen(head + "\n".join(f"{a:<28} {b:<14} {c:>8} {d:>16}" for a, b, c, d in rows))


def order_map(N: float) -> OrderMap:
    """List the orders of a gear of ratio N with the circular spline fixed.

    Parameters
    ----------
    N : float
        Ratio, a whole number of at least 2; z1 = 2 N.

    Returns
    -------
    OrderMap
        Output turn, wave-generator orders 1, 2, 4, 6 and 8, engagement of one flexspline tooth, tooth mesh.

    Raises
    ------
    ValueError
        If N is not an integer of 2 to 10 000.

    References
    ----------
    Yao, Chen & Xing 2022 name 2 f/z1, f, 2 f and the engagement of a flexspline tooth as the main frequencies, f being
    the wave generator's; the counts here follow from the tooth numbers as the module says. A flexspline tooth meets a
    lobe 2 z2/z1 times per motor turn, a circular-spline tooth 2 times.
    """
    ratio = _whole_ratio(N)
    z1, z2 = 2 * ratio, 2 * ratio + 2
    rows = [
        (
            "output turn",
            "run-out of the flexspline's flange and of the output bearing",
            "2/z1 = 1/N",
            Fraction(1, ratio),
        ),
        ("wave generator 1", "eccentricity of the wave generator and its coupling", "1", Fraction(1)),
        ("wave generator 2", "ellipticity of the wave generator, oval circular spline", "2", Fraction(2)),
        ("flexspline tooth engagement", "oval or uneven flexspline under two lobes", "2 z2/z1", Fraction(2 * z2, z1)),
    ]
    rows += [(f"wave generator {k}", f"harmonic {k} of either ring", f"{k}", Fraction(k)) for k in (4, 6, 8)]
    rows.append(("tooth mesh", "profile and pitch of single teeth", "z2 = 2 N + 2", Fraction(z2)))
    found = [GearOrder(name, why, text, order, int(order * ratio)) for name, why, text, order in rows]
    return OrderMap(ratio, z1, z2, tuple(sorted(found, key=lambda o: o.per_motor_turn)))


def on_output_turn(excitation: Any, N: float) -> Any:
    """Tie lines given on the motor turn to the output turn: every order times N, the same amplitudes and phases.

    The base angle is then theta_m/N and its speed omega_m/N; lines that repeat per output turn can stand beside them.

    Parameters
    ----------
    excitation : KinematicError, Harmonic or Harmonics
        Lines on the wave-generator angle.
    N : float
        Ratio, a whole number.

    Raises
    ------
    ValueError
        If N is not an integer, or an order becomes too high for a line (`Line`).
    TypeError
        If `excitation` is of another kind.
    """
    ratio = _whole_ratio(N)
    if isinstance(excitation, KinematicError | Harmonic | Harmonics):
        checked(excitation)
    match excitation:
        case KinematicError(lines=lines):
            moved: Any = KinematicError(tuple(line._replace(order=ratio * line.order) for line in lines))
        case Harmonic(order=order):
            moved = excitation._replace(order=ratio * order)
        case Harmonics(terms=terms):
            moved = Harmonics(tuple(term._replace(order=ratio * term.order) for term in terms))
        case _:
            raise TypeError(f"{shown(excitation)} has no orders; give a KinematicError, a Harmonic or Harmonics")
    return checked(moved)


def order_pair(order: float, N: float) -> tuple[int, int]:
    """Repeats (j, k) per turn of the wave generator and of the output of an order j + k/N, the smallest |k| of all.

    Raises
    ------
    ValueError
        If the order is no such sum with |k| up to half the ratio.
    """
    for k in sorted(range(-int(0.5 * N), int(0.5 * N) + 1), key=abs):
        j = round(order - k / N)
        if abs(order - j - k / N) <= SAME_ORDER:
            return j, k
    raise ValueError(
        f"the order {order:.6g} is no whole number of repeats per turn of the wave generator and of the output, whose "
        f"ratio is {N:g}; write it as j + k/{N:g}, or integrate"
    )


def _whole_ratio(N: float) -> int:
    if not (isinstance(N, int | float) and 2 <= N <= LARGEST_RATIO and N % 1 == 0):
        raise ValueError(
            f"N is {shown(N)}; orders are counted for a whole ratio (motor turns per output turn), 2 to {LARGEST_RATIO}"
        )
    return int(N)


Turn = Literal["motor", "output"]
KINDS = ("design", "manufacture", "assembly", "deformation")


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
    engagement = order_map(N).order("flexspline tooth engagement").per_output_turn
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
