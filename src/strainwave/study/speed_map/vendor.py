"""The vendors' resonance rule beside the map: one linear frequency, f_n = sqrt(K1/J_l)/(2 pi), at 30 f_n rpm.

The error of the gear comes twice in a turn of the wave generator, so the motor meets f_n at n = 60 f_n/2 = 30 f_n rpm.
The rule gives a speed and no width; here it forbids 10 % on either side, the separation margin usual for torsional
trains. Required f_n by application are the vendor's advice for dimensioning.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import pi, sqrt

import numpy as np

from ...results import Floats
from ...units import RPM
from ..analysis.avoid import merged
from .rules import MARGIN, Bands, Span, clipped, common, complement

# f_n [Hz] that the vendor's selection procedure asks for, and where
REQUIRED = (
    (4.0, "slow turntables, slow welding base axes, gantry axes"),
    (8.0, "robot base axes, low-dynamic hand axes, tool revolvers, medical and measuring positioning"),
    (15.0, "general mechanical engineering, tilting axes, hand axes, Scara and gantry robots"),
    (20.0, "B and C axes of 5-axis grinding, laser-welding hand axes, milling heads for plastics"),
    (25.0, "C axes of turning machines, milling of light metal and chipboard"),
    (30.0, "milling of hardwood"),
)


@dataclass(frozen=True, eq=False)
class VendorRule:
    """What the vendors' rule says under one load, against the map.

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

    @property
    def meets(self) -> tuple[str, ...]:
        """Applications whose required f_n the drive has."""
        return tuple(name for least, name in REQUIRED if self.frequency >= least)

    @property
    def sentence(self) -> str:
        """What the rule is worth here, in one sentence."""
        speed = f"f_n = {self.frequency:.4g} Hz, {self.speed / RPM:.5g} rpm"
        said = [f"forbids {_listed(self.needless)} needlessly"] * bool(len(self.needless))
        said += [f"allows {_listed(self.misleading)} although the map forbids it"] * bool(len(self.misleading))
        return f"The vendors' rule ({speed}) " + (" and ".join(said) if said else "agrees with the map") + "."


def vendor_sentence(rules: Sequence[VendorRule]) -> str:
    """What the rule is worth over all loads, in one sentence; empty without a rule."""
    if len(rules) < 2:
        return rules[0].sentence if rules else ""
    ends = [min(rules, key=lambda rule: rule.speed), max(rules, key=lambda rule: rule.speed)]
    f_n, speed = (
        " to ".join(dict.fromkeys(f"{value:.{digits}g}" for value in values))
        for values, digits in (([rule.frequency for rule in ends], 4), ([rule.speed / RPM for rule in ends], 5))
    )
    said = []
    for name, text in (
        ("needless", "forbids {} needlessly under {} of {} loads"),
        ("misleading", "allows {}, which the map forbids under {} of {} loads"),
    ):
        some = [getattr(rule, name) for rule in rules if len(getattr(rule, name))]
        if some:
            spans = merged((float(low), float(high)) for low, high in np.concatenate(some))
            said.append(text.format(_listed(np.array(spans)), len(some), len(rules)))
    return f"The vendors' rule (f_n = {f_n} Hz, {speed} rpm) " + (
        ", and ".join(said) + "." if said else "agrees with the map under every load."
    )


def vendor_rule(load: float, K1: float, J_l: float, bands: Bands, span: Span) -> VendorRule:
    """Compare the rule for a stiffness K1 [N*m/rad] and a load inertia J_l [kg*m^2] with the bands of a load."""
    frequency = sqrt(K1 / J_l) / (2.0 * pi)
    speed = 30.0 * frequency * RPM
    band = (1.0 - MARGIN) * speed, (1.0 + MARGIN) * speed
    own = clipped([band], span)
    free = complement(own, span)
    safe, needless, misleading = common(free, bands.allowed), common(own, bands.allowed), common(free, bands.forbidden)
    return VendorRule(load, frequency, speed, band, safe, needless, misleading)


def _listed(intervals: Floats) -> str:
    return ", ".join(f"{low / RPM:.4g} to {high / RPM:.4g} rpm" for low, high in np.asarray(intervals))
