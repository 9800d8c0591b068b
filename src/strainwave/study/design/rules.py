"""Cheap rules: what a gear's datasheet says about it before any vibration is computed."""

import math
from collections.abc import Iterator
from typing import NamedTuple

from ...model.gears.gear import Gear
from ...model.gears.life import bearing_life
from ...model.gears.limits import Finding, check_limits
from .specification import Specification

SURE = 1.0 + 1e-9  # of an allowance: rounding
WORDS = {
    "max_rpm": "largest input speed", "average_rpm": "largest average input speed",
    "average_torque": "limit for average torque", "repeated_peak_torque": "repeated peak torque",
    "momentary_torque": "momentary torque",
}  # fmt: skip
PEAKS = ("repeated_peak_torque",)  # of the limits of a peak torque: the others hold for momentary ones


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
    """

    name: str
    use: float
    sentence: str

    @property
    def violated(self) -> bool:
        """Whether the gear does not meet it."""
        return not self.use <= SURE


def checks(gear: Gear, spec: Specification) -> Iterator[Check]:
    """Every constraint on a gear that needs no computation of vibrations."""
    yield from _choice(gear, spec)
    yield from _room(gear, spec)
    for name in ("K1", "input_inertia"):
        if None in ((gear.K1, gear.K2, gear.K3, gear.T1, gear.T2) if name == "K1" else (gear.input_inertia,)):
            what = "all of K1, K2, K3, T1, T2" if name == "K1" else "the input inertia"
            yield Check(name, math.inf, f"No source gives {what} of {gear.name}.")
    if gear.accuracy is None and spec.accuracy is None and spec.kinematic_error is None:
        yield Check("accuracy", math.inf, f"No source gives the accuracy of {gear.name}; give it in the specification.")
    needed = ["max_rpm", "average_rpm"]
    needed += ["average_torque", "repeated_peak_torque", "momentary_torque"] if spec.peak_load > 0.0 else []
    for name in needed:
        if getattr(gear, name) is None:
            yield Check(name, math.inf, f"No source gives the {WORDS[name]} of {gear.name}.")
    yield from map(_check, ratings(gear, spec))
    yield from _life(gear, spec)


def ratings(gear: Gear, spec: Specification) -> Iterator[Finding]:
    """What the specification asks of a gear against every limit of its record."""
    yield from check_limits(
        gear,
        average_torque=spec.average_load,
        max_speed=gear.ratio * spec.highest_speed,
        average_speed=gear.ratio * spec.mean_speed,
    )
    yield from (f for f in check_limits(gear, peak_torque=spec.peak_load) if f.limit in PEAKS)
    yield from (f for f in check_limits(gear, peak_torque=spec.momentary_load) if f.limit not in PEAKS)


def life(gear: Gear, spec: Specification) -> float:
    """L10 life [h] under the specification; inf where nothing loads the gear, nan where its rating is unknown."""
    if not spec.average_load * spec.mean_speed > 0.0:
        return math.inf
    hours = bearing_life(gear, spec.average_load, gear.ratio * spec.mean_speed)
    return math.nan if hours is None else hours


def _check(finding: Finding) -> Check:
    return Check(finding.limit, finding.value / finding.bound, finding.sentence.split(";")[0].rstrip(".") + ".")


def _choice(gear: Gear, spec: Specification) -> Iterator[Check]:
    """What the specification does not choose from."""
    if spec.ratios and gear.ratio not in spec.ratios:
        allowed = ", ".join(map(str, spec.ratios))
        nearest = min(spec.ratios, key=lambda ratio: abs(math.log(ratio / gear.ratio)))
        use = max(gear.ratio / nearest, nearest / gear.ratio)
        yield Check("ratio", use, f"The ratio of {gear.name} is {gear.ratio}, and the specification allows {allowed}.")
    if spec.series and gear.series not in spec.series:
        allowed = ", ".join(spec.series)
        said = f"The series of {gear.name} is {gear.series}, and the specification allows {allowed}."
        yield Check("series", math.inf, said)


def _room(gear: Gear, spec: Specification) -> Iterator[Check]:
    """Size and mass."""
    limits = (("size", gear.size, spec.largest_size, ""), ("mass", gear.mass, spec.largest_mass, " kg"))
    for name, value, bound, unit in limits:
        if bound is None:
            continue
        if value is None:
            yield Check(name, math.inf, f"No source gives the {name} of {gear.name}.")
            continue
        relation = "above" if value > bound * SURE else "within"
        said = f"The {name} of {gear.name} is {value:g}{unit}, {relation} the largest allowed, {bound:g}{unit}."
        yield Check(name, value / bound, said)


def _life(gear: Gear, spec: Specification) -> Iterator[Check]:
    if spec.life is None:
        return
    hours = life(gear, spec)
    if math.isnan(hours):
        yield Check("life", math.inf, f"No source gives the rated torque of {gear.name}, which its life follows from.")
        return
    use = spec.life / hours
    relation = "below" if use > SURE else "at least"
    said = f"The L10 life of {gear.name} is {hours:.4g} h, {relation} the {spec.life:g} h required."
    yield Check("life", use, said)
