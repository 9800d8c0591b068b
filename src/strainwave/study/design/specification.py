"""Specification of an axis: loads, speeds, torques, largest error, life, and the gears and motors to choose from.

Cheap rules: what a gear's datasheet says about it before any vibration is computed.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from ...base.quantities import array_of, checked, interval, number, shown
from ...model.excitation import KinematicError
from ...model.gears.gear import SPECIAL, Gear
from ...model.gears.limits import Finding, bearing_life, check_limits, cubic_mean
from ...model.train.filters import control_of

SURE = 1.0 + 1e-9  # of an allowance: rounding
WORDS = {
    "max_rpm": "largest input speed", "average_rpm": "largest average input speed",
    "average_torque": "limit for average torque", "repeated_peak_torque": "repeated peak torque",
    "momentary_torque": "momentary torque",
}  # fmt: skip
DRIVE = ("K1", "K2", "K3", "T1", "T2", "input_inertia")  # numbers that the motion of a drive goes by
POSITIVE = (
    "limit",
    "damping_ratio",
    "accuracy",
    "assumed_accuracy",
    "life",
    "largest_size",
    "largest_mass",
    "average_speed",
)
TORQUES = "mean_torque", "peak_torque", "momentary_torque", "preload"
SPEEDS, LOADS = ("max_rpm", "average_rpm"), ("average_torque", "repeated_peak_torque", "momentary_torque")
PEAKS = ("repeated_peak_torque",)  # of the limits of a peak torque: the others hold for momentary ones


class DutySegment(NamedTuple):
    """A stretch of a duty cycle: torque [N*m] and speed [rad/s] of the load, and how long [s]."""

    torque: float
    speed: float
    duration: float


@dataclass(frozen=True, kw_only=True)
class Specification:
    """Specification of a design, in SI; torques, speeds and inertias of the load are those of the output.

    Attributes
    ----------
    load_inertias : tuple of float
        Inertias of the load [kg*m^2]; a design must serve all of them.
    speeds : (float, float)
        Range of the load's speed [rad/s] in which the error counts.
    limit : float
        Largest oscillation of the pointing error [rad] that is allowed, |error - mean|.
    rotor_inertias : tuple of float
        Inertias of the rotors to choose from [kg*m^2], without the wave generator of the gear; both together are the
        motor's inertia.
    damping_ratio : float
        Of the gear on the held load: B = 2 zeta sqrt(K1 J_l), J_l being that of `tuned`.
    duty : tuple of DutySegment
        The duty cycle; from it follow the four numbers below, where they are not given.
    mean_torque : float
        Cubic mean of the torque, weighted by turns [N*m]: the life goes by it.
    peak_torque : float
        Largest torque that occurs again and again [N*m].
    average_speed : float
        Mean size of the load's speed over the time [rad/s]. Default: that of the duty cycle, else the highest speed.
    momentary_torque : float
        Largest torque of rare events, such as an emergency stop [N*m]. Default: the peak torque.
    preload : float
        Constant torque [N*m] that comes on top of the torques, of a spring or a counterweight.
    life : float or None
        Hours that one bearing in ten may fail after, the L10 life.
    largest_size, largest_mass : float or None
        Largest size, as catalogues count it (pitch diameter in inch times 10), and mass [kg].
    ratios, series : tuple
        Ratios and series of gears to choose from; empty for all.
    accuracy : float, "special" or None
        Peak-to-peak kinematic error [rad]; special is the selected grade of each gear in the catalogue. Default: the
        accuracy class of each gear in the catalogue.
    assumed_accuracy : float or None
        The same for gears whose record has none; without it they are not judged.
    kinematic_error : KinematicError or None
        Its lines, in place of an accuracy.
    loop : Tuning, control or None
        Loop that keeps the motor on its reference; None is an ideally held motor.
    retune : bool
        True for gains of the loop and a damping of each load. Default: one machine has one set, that of its
        smallest load.
    title : str
        Its name.
    remarks : tuple of str
        Remarks on the specification for a reader of the answer.
    """

    load_inertias: tuple[float, ...]
    speeds: tuple[float, float]
    limit: float
    rotor_inertias: tuple[float, ...]
    damping_ratio: float
    duty: tuple[DutySegment, ...] = ()
    mean_torque: float | None = None
    peak_torque: float | None = None
    average_speed: float | None = None
    momentary_torque: float | None = None
    preload: float = 0.0
    life: float | None = None
    largest_size: float | None = None
    largest_mass: float | None = None
    ratios: tuple[int, ...] = ()
    series: tuple[str, ...] = ()
    accuracy: Any = None
    assumed_accuracy: float | None = None
    kinematic_error: KinematicError | None = None
    loop: Any = None
    retune: bool = False
    title: str = ""
    remarks: tuple[str, ...] = ()

    def check(self) -> None:
        """Refuse numbers that are none or contradict each other (ValueError, TypeError)."""
        for name in ("load_inertias", "rotor_inertias"):
            values = getattr(self, name)
            if not tuple(values):
                raise ValueError(f"{name} are {shown(values)}; give one inertia or more [kg*m^2] as a tuple")
            label = f"one of {name} [kg*m^2]"
            object.__setattr__(self, name, tuple(number(label, value, positive=True) for value in values))
        object.__setattr__(self, "speeds", interval("speeds [rad/s]", self.speeds, positive=True))
        for name in (*POSITIVE, *TORQUES):
            value, label = getattr(self, name), f"{name} [N*m]" if name in TORQUES else name
            if (value is not None and value != SPECIAL) or name in ("limit", "damping_ratio", "preload"):
                object.__setattr__(self, name, number(label, value, positive=name in POSITIVE))
        for ratio in tuple(self.ratios):
            number("one of ratios", ratio, positive=True)
        self._check_duty()
        if self.accuracy is not None and self.kinematic_error is not None:
            raise ValueError("the specification has both an accuracy and a kinematic error; remove one of them")
        if getattr(self.loop, "encoder", "motor") != "motor" or hasattr(self.loop, "at_load"):
            raise ValueError("loop uses a load encoder, but a design has a motor encoder only; remove encoder")
        error = None if self.kinematic_error is None else checked(self.kinematic_error)
        if error is not None and any(order % 1 for order in error.orders()):
            raise ValueError(
                "kinematic_error has an order of the output shaft, but the gears differ in ratio; remove this order"
            )

    def _check_duty(self) -> None:
        duty = []
        for i, part in enumerate(tuple(self.duty)):
            if len(tuple(part)) != 3:
                raise ValueError(f"duty[{i}] is {shown(part)}; it must be a DutySegment(torque, speed, duration)")
            named = zip(DutySegment._fields, part, strict=True)
            duty.append(DutySegment(*(number(f"duty[{i}].{n}", v, positive=n == "duration") for n, v in named)))
        object.__setattr__(self, "duty", tuple(duty))
        if len(self.duty) and not any(part[1] for part in self.duty):
            raise ValueError("nothing turns in the duty cycle; give the speed of at least one segment [rad/s]")
        if len(self.duty) and (self.mean_torque is not None or self.peak_torque is not None):
            raise ValueError("the specification has a duty cycle and a mean or peak torque; give one of them")
        if (self.mean_torque is None) != (self.peak_torque is None):
            raise ValueError("mean_torque and peak_torque go together; give both, or a duty cycle")
        if abs(self.mean_torque or 0.0) > abs(self.peak_torque or 0.0):
            raise ValueError(
                f"mean_torque is {self.mean_torque:g} N*m, above peak_torque, {self.peak_torque:g} N*m; "
                "exchange them, or check both"
            )

    @property
    def average_load(self) -> float:
        """Cubic mean of the torque with the preload, weighted by turns [N*m]."""
        if len(self.duty):
            torques = [abs(part[0]) + abs(self.preload) for part in self.duty]
            return cubic_mean(torques, [abs(part[1]) * part[2] for part in self.duty])
        return abs(self.mean_torque or 0.0) + abs(self.preload)

    @property
    def torques(self) -> tuple[float, ...]:
        """Torques of the load [N*m] under which a design must serve: none, and every one of the duty in both signs."""
        given = [part[0] for part in self.duty] or [self.mean_torque or 0.0, self.peak_torque or 0.0]
        sizes = {0.0, *(abs(torque) + abs(self.preload) for torque in (0.0, *given))}
        return tuple(sorted(sizes | {-size for size in sizes if size}))

    def accuracy_of(self, gear: Gear) -> float | None:
        """Accuracy [rad] of a gear; None where nothing gives it."""
        if self.accuracy is not None and self.accuracy != SPECIAL:
            return float(self.accuracy)
        return gear.accuracy_of(self.accuracy or "catalogue") or self.assumed_accuracy

    def tuned(self, load: float) -> float:
        """Inertia [kg*m^2] of the load that loop and damping of a drive with this load are for."""
        return load if self.retune else min(self.load_inertias)

    @property
    def peak_load(self) -> float:
        """Largest torque that occurs again and again, with the preload [N*m]."""
        largest = max((abs(part[0]) for part in self.duty), default=abs(self.peak_torque or 0.0))
        return largest + abs(self.preload)

    @property
    def mean_speed(self) -> float:
        """Mean size of the load's speed over the time [rad/s]."""
        if self.average_speed is not None:
            return self.average_speed
        if self.duty:
            times = np.array([part[2] for part in self.duty])
            return float(np.average([abs(part[1]) for part in self.duty], weights=times))
        return self.speeds[1]

    def control(self, inertia: float) -> Any:
        """Control of the motor on the inertia [kg*m^2, motor side] that it turns; None of an ideally held motor."""
        return control_of(self.loop, inertia)

    def damping(self, K1: float, load_inertia: Any) -> Any:
        """Damping [N*m*s/rad] across the spring for loads [kg*m^2]."""
        K1, inertia = number("K1 [N*m/rad]", K1, positive=True), array_of("load_inertia [kg*m^2]", load_inertia)
        return 2.0 * self.damping_ratio * math.sqrt(K1) * np.sqrt(inertia)[()]


class Check(NamedTuple):
    """One constraint on a gear.

    Attributes
    ----------
    name : str
        The constraint, for example "life" or "repeated_peak_torque".
    use : float
        Share of the allowance that is used: above 1 the constraint is violated; inf where the number is unknown.
    sentence : str
        Fact, value and bound.
    doubts : tuple of str
        Doubts of the record about the numbers of the constraint.
    recorded : bool
        True where the record has the number of the constraint.
    """

    name: str
    use: float
    sentence: str
    doubts: tuple[str, ...] = ()
    recorded: bool = True

    @property
    def violated(self) -> bool:
        """True for a gear that does not meet it."""
        return not self.use <= SURE


def checks(gear: Gear, spec: Specification) -> Iterator[Check]:
    """Every constraint on a gear that needs no computation of vibrations."""
    yield from _choice(gear, spec)
    yield from _room(gear, spec)
    for name in ("K1", "input_inertia"):
        if None in ((gear.K1, gear.K2, gear.K3, gear.T1, gear.T2) if name == "K1" else (gear.input_inertia,)):
            what = "all of K1, K2, K3, T1, T2" if name == "K1" else "the input inertia"
            yield Check(name, math.inf, f"No source gives {what} of {gear.name}.", recorded=False)
    if spec.accuracy_of(gear) is None and spec.kinematic_error is None:
        word = "special accuracy" if spec.accuracy == SPECIAL else "accuracy"
        sentence = f"No source gives the {word} of {gear.name}; give it in the specification."
        yield Check("accuracy", math.inf, sentence, recorded=False)
    for name in (*SPEEDS, *(LOADS if spec.peak_load > 0.0 else ())):
        if getattr(gear, name) is None:
            yield Check(name, math.inf, f"No source gives the {WORDS[name]} of {gear.name}.", recorded=False)
    yield from (_check(gear, finding) for finding in ratings(gear, spec))
    yield from _life(gear, spec)


def miss_of(check: Check) -> str:
    """Sentence of a constraint with the factor by which it is missed."""
    text = check.sentence
    if math.isfinite(check.use) and check.use > 1.0:
        use = f"{check.use:.{digits_apart(check.use)}g} times"
        text = f"{text[:-1]}: {use} {'too short' if check.name == 'life' else 'the allowed value'}."
    return " ".join((text, *check.doubts))


def digits_apart(use: float) -> int:
    """Significant digits with which a number differs from the allowance that it is a share of; at least 4."""
    miss = abs(use - 1.0)
    return 4 if miss == 0.0 or not math.isfinite(miss) else min(16, max(4, 2 - math.floor(math.log10(miss))))


def needed(spec: Specification) -> Iterator[str]:
    """Names of the numbers of a record that a specification needs."""
    yield from (*DRIVE, *SPEEDS)
    yield from LOADS if spec.peak_load > 0.0 else ()
    yield from () if spec.life is None else ("rated_torque",)
    yield from () if spec.largest_mass is None else ("mass",)
    yield from ("accuracy",) if spec.accuracy is None and spec.kinematic_error is None else ()


def ratings(gear: Gear, spec: Specification) -> Iterator[Finding]:
    """Comparison of the specification with every limit of a gear's record."""
    yield from check_limits(
        gear,
        average_torque=spec.average_load,
        max_speed=gear.ratio * max([spec.speeds[1], *(abs(part[1]) for part in spec.duty)]),
        average_speed=gear.ratio * spec.mean_speed,
    )
    yield from (f for f in check_limits(gear, peak_torque=spec.peak_load) if f.limit in PEAKS)
    momentary = max(spec.peak_load, abs(spec.momentary_torque or 0.0) + abs(spec.preload))
    yield from (f for f in check_limits(gear, peak_torque=momentary) if f.limit not in PEAKS)


def life(gear: Gear, spec: Specification) -> float:
    """L10 life [h] under the specification; inf where nothing loads the gear, nan where its rating is unknown."""
    if not spec.average_load * spec.mean_speed > 0.0:
        return math.inf
    hours = bearing_life(gear, spec.average_load, gear.ratio * spec.mean_speed)
    return math.nan if hours is None else hours


def _check(gear: Gear, finding: Finding) -> Check:
    doubts = gear.doubts_about(finding.limit)
    sentence = finding.sentence.removesuffix(" ".join(("", *doubts))).split(";")[0].rstrip(".") + "."
    return Check(finding.limit, finding.value / finding.bound, sentence, doubts)


def _choice(gear: Gear, spec: Specification) -> Iterator[Check]:
    """Refusals of a gear that is not among the ratios and the series to choose from."""
    if len(spec.ratios) and gear.ratio not in spec.ratios:
        allowed = ", ".join(map(str, spec.ratios))
        nearest = min(spec.ratios, key=lambda ratio: abs(math.log(ratio / gear.ratio)))
        use = max(gear.ratio / nearest, nearest / gear.ratio)
        yield Check("ratio", use, f"The ratio of {gear.name} is {gear.ratio}; the specification requires {allowed}.")
    if spec.series and gear.series not in spec.series:
        allowed = ", ".join(spec.series)
        sentence = f"The series of {gear.name} is {gear.series}; the specification requires {allowed}."
        yield Check("series", math.inf, sentence)


def _room(gear: Gear, spec: Specification) -> Iterator[Check]:
    """Size and mass."""
    limits = (("size", gear.size, spec.largest_size, ""), ("mass", gear.mass, spec.largest_mass, " kg"))
    for name, value, bound, unit in limits:
        if bound is None:
            continue
        if value is None:
            yield Check(name, math.inf, f"No source gives the {name} of {gear.name}.", gear.doubts_about(name), False)
            continue
        relation = "above" if value > bound * SURE else "within"
        sentence = f"The {name} of {gear.name} is {value:g}{unit}, {relation} the limit of {bound:g}{unit}."
        yield Check(name, value / bound, sentence)


def _life(gear: Gear, spec: Specification) -> Iterator[Check]:
    if spec.life is None:
        return
    hours = life(gear, spec)
    if math.isnan(hours):
        fact = f"No source gives the rated torque of {gear.name}, required to compute the life."
        yield Check("life", math.inf, fact, recorded=False)
        return
    use = spec.life / hours
    relation = "below" if use > SURE else "at least"
    fact = f"The L10 life of {gear.name} is {hours:.{digits_apart(use)}g} h, {relation} the {spec.life:g} h required."
    yield Check("life", use, fact, gear.doubts_about("rated_torque"))
