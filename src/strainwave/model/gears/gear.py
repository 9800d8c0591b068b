"""Datasheet record of one strain wave gear, and the laws that follow from it.

Stiffness follows the vendors' definition: three straight lines of slope K1, K2, K3 that meet at the torques T1 and T2
(Harmonic Drive LLC, CSF/CSG catalogue, p. 50).

Friction of a gear from what catalogues print: its efficiency, and its running and starting torque without load.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import pairwise

from ...base.above import above
from ...base.quantities import checked, number, shown
from ...base.units import ARCSEC, RPM
from ..drive import Drive
from ..laws.friction import Coulomb, LoadFriction, Viscous
from ..laws.hysteresis import Parallel
from ..laws.rounded import RoundedPiecewiseLinear
from ..laws.springs import Cubic, PiecewiseLinear
from .fits import LawFit, fit_odd

SPECIAL = "special"  # grade of the selected gears
FIT_REACH = 1.5  # times T2: up to where the fits go

RUNNING = 2000.0 * RPM  # input speed [rad/s] at which catalogues give efficiency and running torque


def load_friction(efficiency: float, torque: float, ratio: float, running_torque: float = 0.0) -> LoadFriction:
    """Return the friction of the meshing that gives an efficiency at one torque.

    The motor gives T (1 + mu)/N + T_0 for the output torque T, so that efficiency = 1/(1 + mu + N T_0/T).

    Parameters
    ----------
    efficiency : float
        Output over input power, above 0 and at most 1.
    torque : float
        Output torque T [N*m] that it holds for.
    ratio : float
        Ratio N.
    running_torque : float
        Torque T_0 without load [N*m, motor side] at the speed that it holds for.

    Raises
    ------
    ValueError
        If a number is out of range, the running torque alone loses more than the efficiency says, or the friction
        would lock the gear.
    """
    eta, T = number("efficiency", efficiency, positive=True), number("torque [N*m]", torque, positive=True)
    N, T_0 = number("ratio", ratio, positive=True), number("running_torque [N*m]", running_torque)
    if eta > 1.0:
        raise ValueError(f"efficiency is {eta:g}; it must be at most 1, 77 % is 0.77")
    if T_0 < 0.0:
        raise ValueError(f"running_torque is {T_0:g} N*m; it must not be negative")
    mu = 1.0 / eta - 1.0 - N * T_0 / T
    if not 0.0 <= mu < 1.0:
        reason = "the running torque alone loses more than that" if mu < 0.0 else "the load could not drive the motor"
        raise ValueError(
            f"an efficiency of {shown(eta)} at {T:g} N*m with {T_0:g} N*m of running torque gives a friction of "
            f"{mu:.3g} of the torque, and it must be from 0 to 1: {reason}; check which number is right"
        )
    return LoadFriction(mu)


def no_load_drag(running_torque: float, starting_torque: float, speed: float = RUNNING) -> Parallel:
    """Return the drag on the motor of a gear without load: dry friction and, up to the running torque, viscous.

    Parameters
    ----------
    running_torque : float
        Torque [N*m, motor side] at the input `speed`.
    starting_torque : float
        Torque [N*m, motor side] that starts the gear: its dry friction.
    speed : float
        Input speed [rad/s] of the running torque. Default: 2000 rpm, as in catalogues.

    Raises
    ------
    ValueError
        If a number is not positive, or the running torque is below the starting one.
    """
    running = number("running_torque [N*m]", running_torque, positive=True)
    starting = number("starting_torque [N*m]", starting_torque, positive=True)
    running_speed = number("speed [rad/s]", speed, positive=True)
    if running < starting:
        raise ValueError(
            f"running_torque is {running:g} and starting_torque {starting:g} N*m; dry and viscous friction together "
            "need at least as much at speed, give a Stribeck law as drag"
        )
    return Parallel(Coulomb(starting), Viscous((running - starting) / running_speed))


@dataclass(frozen=True, kw_only=True)
class Gear:
    """Datasheet record of one gear; None stands for a number that its sources do not give.

    Attributes
    ----------
    name, series, size, ratio
        "CSG-40-50" is series "CSG", size 40 (pitch diameter in inch times 10), reduction ratio 50.
    K1, K2, K3 : float
        Torsional stiffness up to T1, from T1 to T2, and beyond T2 [N*m/rad, output side].
    T1, T2 : float
        Torques at which the slope changes [N*m, output side].
    rated_torque, average_torque, repeated_peak_torque, momentary_torque : float
        Limits of the output torque [N*m]; the rated one at 2000 rpm input speed.
    ratcheting_torque, buckling_torque : float
        Output torques [N*m] at which teeth skip, and at which the flexspline buckles.
    max_rpm, average_rpm : float
        Limits of the input speed with grease as printed [rpm]; `max_speed` and `average_speed` give them in rad/s.
    input_inertia : float
        Inertia of the wave generator [kg m^2, motor side].
    mass : float
        Mass [kg].
    accuracy, special_accuracy : float
        Largest peak-to-peak transmission error over one output turn [rad, output side], and that of the selected grade.
    hysteresis_loss, lost_motion : float
        Largest width of the torque-torsion loop at no torque, and at +-4 % of the rated torque [rad, output side].
    efficiency : float
        At rated torque, as a fraction.
    running_torque, starting_torque : float
        Without load, on the input [N*m, motor side]; running at 2000 rpm.
    back_driving_torque : float
        Without load, on the output [N*m].
    pitch_radius : float
        Of the toothing [m].
    source : str
        Source of the numbers.
    notes : tuple of str
        Doubts about single numbers, full sentences.
    doubts : tuple of (str, str)
        Name of each doubtful number, and the note on it.
    """

    name: str
    series: str
    size: int | None
    ratio: int
    K1: float | None = None
    K2: float | None = None
    K3: float | None = None
    T1: float | None = None
    T2: float | None = None
    rated_torque: float | None = None
    average_torque: float | None = None
    repeated_peak_torque: float | None = None
    momentary_torque: float | None = None
    ratcheting_torque: float | None = None
    buckling_torque: float | None = None
    max_rpm: float | None = None
    average_rpm: float | None = None
    input_inertia: float | None = None
    mass: float | None = None
    accuracy: float | None = None
    special_accuracy: float | None = None
    hysteresis_loss: float | None = None
    lost_motion: float | None = None
    efficiency: float | None = None
    running_torque: float | None = None
    starting_torque: float | None = None
    back_driving_torque: float | None = None
    pitch_radius: float | None = None
    source: str = ""
    notes: tuple[str, ...] = ()
    doubts: tuple[tuple[str, str], ...] = ()

    def _repr_html_(self) -> str:
        """Numbers in a notebook."""
        return str(above("card")(self))

    def accuracy_of(self, grade: str = "catalogue") -> float | None:
        """Accuracy [rad] of the usual grade, or that of the one that is called special."""
        return self.special_accuracy if grade == SPECIAL else self.accuracy

    def doubts_about(self, *names: str) -> tuple[str, ...]:
        """Notes on those of the named numbers that are doubtful, each once."""
        return tuple(dict.fromkeys(note for name, note in self.doubts if name in names))

    @property
    def has_law(self) -> bool:
        """True if the sources give all numbers of the torsion law."""
        return all(getattr(self, name) is not None for name in PiecewiseLinear._fields)

    @property
    def law(self) -> PiecewiseLinear:
        """The vendors' three-slope torsion law.

        Raises
        ------
        ValueError
            If the sources do not give all of K1, K2, K3, T1, T2.
        """
        numbers = {name: getattr(self, name) for name in PiecewiseLinear._fields}
        missing = [name for name, value in numbers.items() if value is None]
        if missing:
            raise ValueError(
                f"{self.name} has no torsion law: {', '.join(missing)} are not tabulated; take a gear of the same size "
                "and ratio that has them, or give ratio and law explicitly"
            )
        return PiecewiseLinear(**numbers)

    def check_law(self) -> None:
        """Refuse a gear without a torsion law (ValueError)."""
        self.law.check()

    @property
    def reach(self) -> float:
        """Torsion [rad] at 1.5 T2, up to where the fits go."""
        law = self.law
        return self.twist(FIT_REACH * law.T2)

    @property
    def cubic(self) -> Cubic:
        """The cubic law T = K (u + alpha u^3) that fits best up to 1.5 T2; `fit(3)` gives its error."""
        law = self.fit(3).law
        assert isinstance(law, Cubic)
        return law

    def fit(self, degree: int = 3) -> LawFit:
        """Fit an odd polynomial to the law by least squares in the torque, uniformly in the torsion up to 1.5 T2.

        Parameters
        ----------
        degree : int
            3 gives a `Cubic`, 5, 7, ... a `Polynomial`.
        """
        return fit_odd(self.law, self.reach, degree)

    def rounded(self, width: float) -> RoundedPiecewiseLinear:
        """Return the law with its corners rounded over a `width` [rad] of torsion."""
        law: RoundedPiecewiseLinear = checked(RoundedPiecewiseLinear(*self.law, number("width [rad]", width)))
        return law

    @property
    def max_speed(self) -> float | None:
        """Largest input speed with grease [rad/s]."""
        return None if self.max_rpm is None else self.max_rpm * RPM

    @property
    def average_speed(self) -> float | None:
        """Largest average input speed with grease [rad/s]."""
        return None if self.average_rpm is None else self.average_rpm * RPM

    def twist(self, torque: float) -> float:
        """Torsion [rad] under a static output torque [N*m] with the input locked (CSF/CSG catalogue, p. 50).

        T/K1 up to T1, T1/K1 + (T - T1)/K2 up to T2, T1/K1 + (T2 - T1)/K2 + (T - T2)/K3 beyond; odd in T.

        Raises
        ------
        ValueError
            If the torque is no finite number, or the gear has no torsion law.
        """
        size, law = abs(number("torque", torque)), self.law
        first, second = min(size, law.T1), min(max(size - law.T1, 0.0), law.T2 - law.T1)
        third = max(size - law.T2, 0.0)
        return math.copysign(first / law.K1 + second / law.K2 + third / law.K3, torque)

    def drive(self, *, load_inertia: float, motor_inertia: float | None = None, B: float) -> Drive:
        """Build the drive of this gear.

        Parameters
        ----------
        load_inertia : float
            Inertia of the load [kg m^2, output side].
        motor_inertia : float, optional
            Everything that turns with the motor shaft, the wave generator included [kg m^2, motor side].
            Default: the wave generator alone.
        B : float
            Damping across the spring [N*m*s/rad, output side].

        Raises
        ------
        ValueError
            If an inertia is not positive or B is negative, or the gear has no torsion law or no input inertia.
        """
        J_m = self.input_inertia if motor_inertia is None else motor_inertia
        if J_m is None:
            raise ValueError(f"{self.name} has no input inertia in its sources; give motor_inertia")
        for name, value in (("load_inertia", load_inertia), ("motor_inertia", J_m)):
            number(name, value, positive=True)
        if number("B", B) < 0.0:
            raise ValueError(f"B is {B} N*m*s/rad; the damping must not be negative")
        return Drive(float(J_m), float(load_inertia), float(self.ratio), float(B), self.law)

    @property
    def friction(self) -> LoadFriction:
        """Load-proportional friction of the meshing, from the efficiency at rated torque and the running torque.

        Raises
        ------
        ValueError
            If the sources do not give the efficiency and the rated torque, or the numbers do not go together.
        """
        if self.efficiency is None or self.rated_torque is None:
            raise ValueError(
                f"no source gives the efficiency of {self.name} at its rated torque; give the friction as a share of "
                "the transmitted torque, for example LoadFriction(0.08)"
            )
        return load_friction(self.efficiency, self.rated_torque, self.ratio, self.running_torque or 0.0)

    @property
    def drag(self) -> Parallel:
        """Drag on the motor without load, from the running and the starting torque.

        Raises
        ------
        ValueError
            If the sources do not give both torques.
        """
        if self.running_torque is None or self.starting_torque is None:
            raise ValueError(
                f"no source gives both running and starting torque of {self.name}; give the motor's drag as a law"
            )
        return no_load_drag(self.running_torque, self.starting_torque)

    def slips(self) -> Iterator[tuple[str, str]]:
        """Name numbers far from what gears of the catalogue have, most likely a slip of a unit or a power of ten."""
        for field, (measure, low, high) in FAR.items():
            value = getattr(self, field)
            size = None if value is None else measure(self, value)
            if size is not None and not low / FACTOR <= size <= high * FACTOR:
                angle = f" ({value / ARCSEC:.4g} arcsec)" if NUMBERS[field] == "rad" else ""
                times = (
                    f"{size / high:.3g} times the largest" if size > high else f"{low / size:.3g} times below the least"
                )
                yield (
                    field,
                    f"{self.name}: {field} is {value:.4g} {NUMBERS[field]}{angle}, {times} that gears of the catalogue "
                    "have beside their other numbers; check its unit.",
                )

    def contradictions(self) -> Iterator[tuple[str, str]]:
        """Name numbers that cannot be true together: the field to blame and a sentence on it.

        A limit must not be below the one that it includes (rated, average, repeated peak, momentary, then ratcheting or
        buckling torque; average, largest speed), stiffness and inertia must be positive, T1 below T2.
        """
        for field in NUMBERS:
            value = getattr(self, field)
            if value is not None and not 0.0 < value < math.inf:
                yield field, f"{field} is {value:g} {NUMBERS[field]}; it must be positive".replace("  ", " ")
        if self.T1 is not None and self.T2 is not None and self.T1 >= self.T2:
            yield "T1", f"T1 is {self.T1:g} and T2 is {self.T2:g} N*m; the first slope must end below the second"
        if self.efficiency is not None and self.efficiency > 1.0:
            yield "efficiency", f"efficiency is {self.efficiency:g}; it must be at most 1 (100 %)"
        reported = set()
        for fields in ASCENDING:
            stated = [(field, getattr(self, field)) for field in fields if getattr(self, field) is not None]
            for (low, smaller), (high, larger) in pairwise(stated):
                if smaller > larger and (low, high) not in reported:
                    reported.add((low, high))
                    unit = NUMBERS[low]
                    yield low, f"{low} is {smaller:g} {unit}, above {high}, {larger:g} {unit}; check which is right"


# Every number of a record with its unit.
NUMBERS = {
    "K1": "N*m/rad", "K2": "N*m/rad", "K3": "N*m/rad", "T1": "N*m", "T2": "N*m",
    "rated_torque": "N*m", "average_torque": "N*m", "repeated_peak_torque": "N*m", "momentary_torque": "N*m",
    "ratcheting_torque": "N*m", "buckling_torque": "N*m", "max_rpm": "rpm", "average_rpm": "rpm",
    "input_inertia": "kg*m**2", "mass": "kg", "accuracy": "rad", "special_accuracy": "rad", "hysteresis_loss": "rad",
    "lost_motion": "rad", "efficiency": "", "running_torque": "N*m", "starting_torque": "N*m",
    "back_driving_torque": "N*m", "pitch_radius": "m",
}  # fmt: skip
FACTOR = 5.0  # beyond what gears have
HEAVY = 100.0  # times the wave generator: a rotor whose unit is doubted


def _over(name: str, power: float = 1.0) -> Callable[[Gear, float], float | None]:
    """A number over a power of another, None where that is not known."""

    def share(gear: Gear, value: float) -> float | None:
        other = getattr(gear, name)
        return None if other is None else value / other**power

    return share


# Sizes of numbers beside others, and their range over the records of the catalogue.
FAR: dict[str, tuple[Callable[[Gear, float], float | None], float, float]] = {
    "K1": (lambda _, value: value, 340.0, 1.45e6), "K2": (_over("K1"), 1.24, 1.65), "K3": (_over("K2"), 1.06, 1.64),
    "rated_torque": (_over("K1"), 5e-4, 3.3e-3), "input_inertia": (_over("K1", 5.0 / 3.0), 1.1e-12, 3.2e-11),
    "mass": (_over("rated_torque"), 0.019, 0.18), "accuracy": (lambda _, value: value, 0.0, 5.8e-4),
    "special_accuracy": (lambda _, value: value, 0.0, 5.8e-4), "lost_motion": (lambda _, value: value, 0.0, 8.8e-4),
    "hysteresis_loss": (lambda _, value: value, 0.0, 8.8e-4),
}  # fmt: skip
ASCENDING = (
    ("rated_torque", "average_torque", "repeated_peak_torque", "momentary_torque", "ratcheting_torque"),
    ("rated_torque", "average_torque", "repeated_peak_torque", "momentary_torque", "buckling_torque"),
    ("average_rpm", "max_rpm"),
    ("special_accuracy", "accuracy"),
)
