"""Arrangements of a gear, and how often each of its periodic errors repeats per turn of the motor and of the output.

The flexspline has z1 = 2 N teeth, the circular spline z2 = z1 + 2. Against the wave generator the splines turn as their
teeth say, z1 (w_fs - w_wg) = z2 (w_cs - w_wg) (Willis 1841). One member is fixed to the housing, one is the output, the
motor turns the third. The wave generator has two lobes half a turn apart, so of a deviation that repeats n times around
a ring the two meshes add up the even n and cancel the odd ones. A line j theta_1 + k theta_2 of the motor's and the
output's angle in the housing has the pair (j, k). The output turn is the base angle on which these orders are whole.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from math import pi
from typing import Any, Literal, NamedTuple

from ..base.quantities import checked, choice, number, positive_count, shown, whole
from ..base.terminal import on_screen
from .excitation import Harmonic, Harmonics, KinematicError

LARGEST_RATIO = 10_000
SAME_ORDER = 1e-9
Pair = tuple[int, int]
Turn = Literal["motor", "output"]
Member = Literal["wave generator", "flexspline", "circular spline"]
MEMBERS: tuple[Member, ...] = ("wave generator", "flexspline", "circular spline")


class Arrangement(NamedTuple):
    """Member that is fixed to the housing, and the one that is the output; the motor turns the third."""

    fixed: Member = "circular spline"
    output: Member = "flexspline"

    @property
    def driven(self) -> Member:
        """Member that the motor turns.

        Raises
        ------
        ValueError
            If the gear has no such members, or one is both.
        """
        others = [member for member in MEMBERS if member not in self]
        if len(others) != 1:
            raise ValueError(
                f"fixed is {shown(self.fixed)} and output {shown(self.output)}; give two of {', '.join(MEMBERS)}"
            )
        return others[0]

    def ratio(self, N: float) -> Fraction:
        """Motor turns per output turn, negative where the output turns the other way; N of the teeth, z1 = 2 N."""
        z1, driven = 2 * whole_ratio(N), self.driven
        weights = {"flexspline": z1, "circular spline": -z1 - 2, "wave generator": 2}
        return Fraction(-weights[self.output], weights[driven])

    def teeth(self, ratio: float) -> int:
        """N = z1/2 from the motor turns per output turn, whichever way the output turns.

        Raises
        ------
        ValueError
            If no teeth give this ratio.
        """
        ratio = number("ratio", ratio, positive=True)
        guesses = [round(x) for x in (ratio, ratio - 1.0, 1.0 / (ratio - 1.0) if ratio > 1.0 else 0.0) if x >= 1.5]
        for N in guesses:
            if N <= LARGEST_RATIO and abs(abs(float(self.ratio(N))) - ratio) <= SAME_ORDER * ratio:
                return N
        of_teeth = {Fraction(50): "N", Fraction(51): "N + 1", Fraction(51, 50): "1 + 1/N"}
        means = of_teeth.get(abs(self.ratio(50)), "what the teeth give")
        raise ValueError(
            f"{ratio:.6g} is no ratio with the {self.fixed} fixed and z1 = 2 N and z2 = 2 N + 2 teeth; it is {means} "
            "of a whole N from 2 on"
        )

    def torques(self, N: float) -> dict[Member, Fraction]:
        """Torques of a gear without losses on its members, in the housing's sense, per N*m on its output member.

        Their sum is 0, and so is their power: the fixed member gets 1/R - 1 of the output's torque, R with its sign.
        """
        R = self.ratio(N)
        return {self.output: Fraction(1), self.driven: -1 / R, self.fixed: 1 / R - 1}

    def turn(self, member: Member) -> Pair:
        """Turns of the motor and of the output that a member makes in the housing."""
        choice("member", member, *MEMBERS)
        return int(member == self.driven), int(member == self.output)

    def lobes(self, spline: Member, times: int) -> Pair:
        """Pair of what repeats a number of `times` per turn of the wave generator against a spline."""
        (a, b), (c, d), times = self.turn("wave generator"), self.turn(spline), int(times)
        j, k = times * (a - c), times * (b - d)
        return (j, k) if (j, k) > (0, 0) else (-j, -k)

    def __str__(self) -> str:
        return f"{self.fixed} fixed, {self.output} at the output"


USUAL = Arrangement()
TURNING_SPLINE = Arrangement("flexspline", "circular spline")
BY_FIXED = {  # with the output that a gear has then
    arrangement.fixed.replace(" ", "_"): arrangement
    for arrangement in (USUAL, TURNING_SPLINE, Arrangement("wave generator", "circular spline"))
}


@dataclass(frozen=True)
class GearOrder:
    """One periodic error of a gear.

    Attributes
    ----------
    name, source : str
        Part that repeats, and the deviations that it comes from.
    formula : str
        Its order per motor turn in N, z1 and z2; its pair where the motor does not turn the wave generator.
    per_motor_turn : Fraction
        Repeats per turn of the motor.
    per_output_turn : int or Fraction
        Repeats per turn of the output.
    pair : (int, int)
        j and k of its angle j theta_1 + k theta_2, of the motor's and the output's angle in the housing.
    """

    name: str
    source: str
    formula: str
    per_motor_turn: Fraction
    per_output_turn: int | Fraction
    pair: Pair

    def frequency_hz(self, omega_m: float) -> float:
        """Frequency [Hz] at the motor speed `omega_m` [rad/s]."""
        return float(self.per_motor_turn) * abs(number("omega_m [rad/s]", omega_m)) / (2.0 * pi)


@dataclass(frozen=True)
class OrderMap:
    """The orders of one gear; `str()` prints them as a table.

    Attributes
    ----------
    N : int
        Ratio with the circular spline fixed, z1/2.
    z1, z2 : int
        Teeth of the flexspline and of the circular spline.
    orders : tuple of GearOrder
        Ascending.
    arrangement : Arrangement
        Members that are fixed and the output.
    """

    N: int
    z1: int
    z2: int
    orders: tuple[GearOrder, ...]
    arrangement: Arrangement = USUAL

    def order(self, name: str) -> GearOrder:
        """Return the order of this name.

        Raises
        ------
        ValueError
            If there is none.
        """
        for order in self.orders:
            if order.name == name:
                return order
        raise ValueError(f"the order map has no {shown(name)}; it has {', '.join(o.name for o in self.orders)}")

    def __str__(self) -> str:
        ratio = self.arrangement.ratio(self.N)
        sense = "with" if ratio > 0 else "against"
        head = (
            f"ratio {abs(ratio)}, output {sense} the motor, z1 = {self.z1}, z2 = {self.z2} teeth ({self.arrangement})\n"
        )
        rows = [("", "per motor turn", "", "per output turn", "pair")]
        rows += [(o.name, o.formula, str(o.per_motor_turn), str(o.per_output_turn), str(o.pair)) for o in self.orders]
        width = max(28, *(len(row[0]) for row in rows))
        return on_screen(head + "\n".join(f"{a:<{width}} {b:<14} {c:>8} {d:>16}   {e}" for a, b, c, d, e in rows))


def order_map(N: float, arrangement: Arrangement = USUAL, *, cogging: int = 0) -> OrderMap:
    """List the orders of a gear, by the turns of the motor and of the output.

    Parameters
    ----------
    N : float
        Ratio of the gear with its circular spline fixed, a whole number of at least 2; z1 = 2 N.
    arrangement : Arrangement
        Fixed member and output member. Default: circular spline fixed, flexspline out. The ratio is
        then -N, N + 1 with the flexspline fixed and the circular spline out.
    cogging : int
        Cogging torque's periods per turn of the motor; 0 leaves it out.

    Returns
    -------
    OrderMap
        Output turn, wave-generator orders 1, 2, 4, 6 and 8, engagement of one tooth of the spline that turns, tooth
        mesh, motor cogging.

    Raises
    ------
    ValueError
        If N is not an integer of 2 to 10 000, the arrangement is none, or cogging is no count.

    References
    ----------
    Yao, Chen & Xing 2022 name 2 f/z1, f, 2 f and the engagement of a flexspline tooth as the main frequencies, f being
    the wave generator's; the counts here follow from the tooth numbers as the module says. A flexspline tooth meets a
    lobe 2 z2/z1 times per motor turn, a circular-spline tooth 2 times, with the circular spline fixed.
    """
    n, ratio = whole_ratio(N), arrangement.ratio(N)
    cogging = positive_count("cogging", cogging, 10_000) if whole("cogging", cogging) else 0
    first: Member = "flexspline" if arrangement.fixed == "flexspline" else "circular spline"
    second: Member = "circular spline" if first == "flexspline" else "flexspline"
    teeth = {"flexspline": 2 * n, "circular spline": 2 * n + 2}
    usual = arrangement.driven == "wave generator"
    z, other, text, R = (
        ("z2", "z1", "z2 = 2 N + 2", "N") if second == "flexspline" else ("z1", "z2", "z1 = 2 N", "(N + 1)")
    )
    rows: list[tuple[str, str, str, Pair]] = [
        ("output turn", "run-out of the output, its bearing and its encoder", f"2/{other} = 1/{R}", (0, 1)),
        (f"{second} tooth engagement", f"oval or uneven {second} under two lobes", f"2 {z}/{other}",
         arrangement.lobes(second, 2)),
        ("tooth mesh", "profile and pitch of single teeth", text, arrangement.lobes(first, teeth[first])),
    ]  # fmt: skip
    if arrangement.fixed != "wave generator":
        once = "eccentricity of the wave generator, its coupling and its encoder"
        rows.append(("wave generator 1", once, "1", arrangement.turn("wave generator")))
    sources = {2: f"ellipticity of the wave generator, oval {first}"}
    for k in (2, 4, 6, 8):
        rows.append(
            (f"wave generator {k}", sources.get(k, f"harmonic {k} of either ring"), f"{k}", arrangement.lobes(first, k))
        )
    if cogging:
        rows.append(("motor cogging", "slots and poles of the motor", f"{cogging}", (cogging, 0)))
    listed = []
    for name, source, formula, pair in rows:
        order = abs(pair[0] + pair[1] / ratio)
        listed.append(GearOrder(name, source, formula if usual else str(pair), order, _plain(order * abs(ratio)), pair))
    return OrderMap(n, 2 * n, 2 * n + 2, tuple(sorted(listed, key=lambda o: o.per_motor_turn)), arrangement)


def _plain(order: Fraction) -> int | Fraction:
    return int(order) if order.denominator == 1 else order


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
    ratio = whole_ratio(N)
    if isinstance(excitation, KinematicError | Harmonic | Harmonics):
        excitation = checked(excitation)
    match excitation:
        case KinematicError(lines=lines):
            moved: Any = KinematicError(tuple(line._replace(order=_counted(ratio * line.order)) for line in lines))
        case Harmonic(order=order):
            moved = excitation._replace(order=ratio * order)
        case Harmonics(terms=terms):
            moved = Harmonics(tuple(term._replace(order=ratio * term.order) for term in terms))
        case _:
            raise TypeError(f"{shown(excitation)} has no orders; give a KinematicError, a Harmonic or Harmonics")
    return checked(moved)


def _counted(order: float) -> float:
    return round(order) if abs(order - round(order)) <= SAME_ORDER * max(1.0, order) else order


def order_pair(order: float, N: float) -> tuple[int, int]:
    """Repeats (j, k) per turn of the wave generator and of the output of an order j + k/N, the smallest |k| of all.

    Raises
    ------
    ValueError
        If the order is no such sum with |k| up to half the ratio.
    """
    if N > LARGEST_RATIO:
        raise ValueError(f"the ratio is {N:g}; orders are counted for one of at most {LARGEST_RATIO}")
    for k in sorted(range(-int(0.5 * N), int(0.5 * N) + 1), key=abs):
        j = round(order - k / N)
        if abs(order - j - k / N) <= SAME_ORDER:
            return j, k
    if N < 2.0:
        raise ValueError(
            f"the ratio is {N:g}: motor and output turn nearly alike, so that the order {order:.6g} beats with neither "
            "turn; integrate it with simulate or strainwave move"
        )
    raise ValueError(
        f"the order {order:.6g} is no whole number of repeats per turn of the wave generator and up to {int(0.5 * N)} "
        f"of the output, whose ratio is {N:g}; write it as j + k/{N:g}, or integrate"
    )


def without_teeth(ratio: float) -> Iterator[str]:
    """Sentence on a ratio that no strain wave gear has, whichever member is fixed."""
    counts = ratio, 1.0 / (ratio - 1.0) if ratio > 1.0 else 0.0
    if not any(x > 1.5 and abs(x - round(x)) <= SAME_ORDER * x for x in counts):
        yield (
            f"gear.ratio: {ratio:.6g} is no ratio of a strain wave gear alone, whose teeth give N, N + 1 or 1 + 1/N of "
            "a whole N; it is taken as that of gear and further stages together. Correct it where there are none."
        )


def whole_ratio(N: float) -> int:
    """Ratio that the teeth of a gear can have, as a whole number; others are refused (ValueError)."""
    if not (2 <= N <= LARGEST_RATIO and N % 1 == 0):
        raise ValueError(
            f"N is {shown(N)}; orders are counted for a whole ratio (motor turns per output turn), 2 to {LARGEST_RATIO}"
        )
    return int(N)
