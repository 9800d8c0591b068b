"""The vendors' resonance rule beside the map: one linear frequency, f_n = sqrt(K1/J_l)/(2 pi), at 30 f_n rpm."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import pi, sqrt

import numpy as np

from ...base.facts import Fact
from ...base.number_text import number
from ...base.results import Floats
from ...base.sentences import listed
from ...base.units import RPM
from ...drive.project import Project
from .intervals import Span, clipped, common, complement, merged
from .rules import Bands

# f_n [Hz] that the vendor's selection procedure asks for, and where
REQUIRED = (
    (4.0, "slow turntables, slow welding base axes, gantry axes"),
    (8.0, "robot base axes, low-dynamic hand axes, tool revolvers, medical and measuring positioning"),
    (15.0, "general mechanical engineering, tilting axes, hand axes, Scara and gantry robots"),
    (20.0, "B and C axes of 5-axis grinding, laser-welding hand axes, milling heads for plastics"),
    (25.0, "C axes of turning machines, milling of light metal and chipboard"),
    (30.0, "milling of hardwood"),
)

SEPARATION = 0.1  # separation margin of torsional trains: 10 % (API 617 after Wang, Feese & Pettinato 2012)
DIGITS = 3  # of a datasheet's stiffness


@dataclass(frozen=True, eq=False)
class VendorRule:
    """Vendors' rule under one load, against the map.

    Attributes
    ----------
    load : float
        Torque [N*m] or inertia [kg*m^2].
    frequency : float
        f_n [Hz].
    speed : float
        Resonance speed of the motor [rad/s], 30 f_n rpm.
    band : (low, high)
        What it is taken to forbid [rad/s].
    safe, needless, misleading : (n, 2) arrays
        Speeds [rad/s] that it and the map allow; that it alone forbids; that it allows and the map forbids.
    """

    load: float
    frequency: float
    speed: float
    band: Span
    safe: Floats
    needless: Floats
    misleading: Floats

    def facts(self) -> tuple[Fact, ...]:
        """Its numbers."""
        return (
            Fact("f_n_Hz", self.frequency), Fact("speed_rpm", self.speed), Fact("safe_rpm", self.safe),
            Fact("needless_rpm", self.needless), Fact("misleading_rpm", self.misleading),
            Fact("sentence", self.sentence), Fact("meets", self.meets),
        )  # fmt: skip

    @property
    def meets(self) -> tuple[str, ...]:
        """Applications whose required f_n the drive has."""
        return tuple(name for least, name in REQUIRED if self.frequency >= least)

    @property
    def sentence(self) -> str:
        """Sentence on the rule under this load."""
        return vendor_sentence([self])


def vendor_sentence(rules: Sequence[VendorRule]) -> str:
    """Sentence on the rule over all loads; empty without a rule."""
    if not rules:
        return ""
    ends = [min(rules, key=lambda rule: rule.speed), max(rules, key=lambda rule: rule.speed)]
    f_n = " to ".join(dict.fromkeys(number(rule.frequency, DIGITS) for rule in ends))
    speed = " to ".join(dict.fromkeys(number(rule.speed / RPM, DIGITS) for rule in ends))
    parts, several = [], len(rules) > 1
    for name, verb, other in (("needless", "forbids", "allows"), ("misleading", "allows", "forbids")):
        some = [getattr(rule, name) for rule in rules if len(getattr(rule, name))]
        if some:
            bands = merged((float(low), float(high)) for low, high in np.concatenate(some))
            spans = listed(" to ".join(number(end / RPM, DIGITS) for end in band) for band in bands)
            loads = f"under {len(some)} of {len(rules)} loads " if several else ""
            parts.append(f"{loads}the rule {verb} {spans} rpm, but the map {other} these speeds")
    text = "; ".join(parts) or "the rule agrees with the map" + " under every load" * several
    return f"The vendors' rule for order 2 (±{100.0 * SEPARATION:g} % around {speed} rpm, f_n = {f_n} Hz): {text}."


def vendor_rules(
    projects: Sequence[Project], loads: Floats, bands: Sequence[Bands], span: Span
) -> Iterator[VendorRule]:
    """Compare the rule for the stiffness of the gear and the inertia of the load with the bands of every load.

    It is about order 2 of a motor, so that the speeds of a forcing have none.
    """
    for project, load, ruled in zip(projects, loads.tolist(), bands, strict=True):
        drive, gear = project.drive, project.gear
        K1 = drive.J_l * drive.omega_0_held**2 if gear is None else float(gear.law.stiffness(0.0))
        if K1 > 0.0 and project.speeds.by_motor:
            frequency = sqrt(K1 / drive.J_l) / (2.0 * pi)
            speed = 30.0 * frequency * RPM
            band = (1.0 - SEPARATION) * speed, (1.0 + SEPARATION) * speed
            inside = clipped([band], span)
            outside = complement(inside, span)
            parts = (outside, ruled.allowed), (inside, ruled.allowed), (outside, ruled.forbidden)
            yield VendorRule(load, frequency, speed, band, *(common(*both) for both in parts))
