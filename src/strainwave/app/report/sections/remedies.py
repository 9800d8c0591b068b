"""Remedies that make the error smaller: as data and in a sentence."""

from typing import Any

from ....base.sentences import Sentence, Speed
from ....study.analysis.load_cases import largest_case
from ....study.analysis.remedies import CANCELLED, NO_EFFECT, Remedy
from ....study.speed_map.avoid import Avoid
from ...console import number
from ...view import View, sizes
from ..section import Part, Table

MOST_EFFECTS = 6  # remedies of the sentence; the table has all


def remedies_data(view: View, avoid: Avoid) -> dict[str, Any]:
    """Keys of `advice` about remedies: a row each, their sentence, what does not help, and what was not tried."""
    remedies = view.analysis.remedies
    largest, speed = largest_of(view, avoid)
    return {
        "remedies": [_row(view, remedy, largest) for remedy in remedies],
        "remedy_sentence": _sentence(view, remedies, speed),
        "no_help": no_help(remedies),
        "not_tried": list(view.analysis.not_tried),
    }


def largest_of(view: View, avoid: Avoid) -> tuple[float, float]:
    """Oscillation [rad] to which the remedies are related, and its speed [rad/s]."""
    worst = largest_case(view.analysis.load_cases)
    deciding = avoid if worst is None or worst.avoid is None else worst.avoid
    return deciding.largest, deciding.at


def _row(view: View, remedy: Remedy, largest: float) -> dict[str, Any]:
    return {
        "what": remedy.what,
        "change": remedy.change,
        "from": remedy.before,
        "to": remedy.gear or remedy.after,
        "unit": remedy.unit,
        "relative_oscillation": remedy.ratio,
        **sizes(remedy.ratio * largest, "oscillation"),
        "at_rad_per_s": remedy.at,
        "at_rpm": view.speeds.rpm(remedy.at),
        "above_limit": remedy.exceeds,
        "helps": remedy.helps,
    }


def can_be_ordered(remedy: Remedy) -> bool:
    """True for a change that can be bought or set: another gear, the loop, a preload, damping."""
    return bool(remedy.gear or remedy.by or "loop" in remedy.what or remedy.what.startswith("damping"))


def after_change(view: View, remedy: Remedy) -> dict[str, Any]:
    """Largest oscillation after a change."""
    avoid = view.analysis.avoid
    return sizes(None if avoid is None else remedy.ratio * largest_of(view, avoid)[0], "oscillation")


def no_help(remedies: tuple[Remedy, ...]) -> str:
    """Sentence on the changes that leave the oscillation as it is or make it larger; "" without one."""
    useless = ", ".join(str(remedy) for remedy in remedies if not remedy.helps)
    return f"These changes do not help: {useless}." if useless else ""


def _sentence(view: View, remedies: tuple[Remedy, ...], speed: float) -> str:
    """Sentence on the remedies of the peak at a speed [rad/s], the most helpful first, and those that do not help."""
    remedies = tuple(remedy for remedy in remedies if remedy.share != CANCELLED)
    helpful, useless = [remedy for remedy in remedies if remedy.helps], no_help(remedies)
    if not helpful:
        return useless
    worst = largest_case(view.analysis.load_cases)
    load = "" if worst is None else f" under a load torque of {number(worst.torque)} N·m"
    effects = Sentence("; ").join(_effect(remedy, speed) for remedy in helpful[:MOST_EFFECTS])
    others = f"; {len(helpful) - MOST_EFFECTS} more in the table of the report" if len(helpful) > MOST_EFFECTS else ""
    text = f"Most helpful: {helpful[0]}. Recomputed{load} with one change at a time: " + effects
    return text + others + "." + (f" {useless}" if useless else "")


def _effect(remedy: Remedy, speed: float) -> str:
    shifted = abs(remedy.at / speed - 1.0) > NO_EFFECT and remedy.ratio > NO_EFFECT
    speed_text = ", at " + bare_speed(remedy.at) + " instead of " + bare_speed(speed) if shifted else ""
    within = ", within the limit" if remedy.exceeds is False else ""
    return f"{remedy}: {number(100.0 * (1.0 - remedy.ratio), 2)} % less oscillation{within}" + speed_text


def bare_speed(*omega: float, ways: tuple[int, ...] = ()) -> Speed:
    """Speeds without their unit, for ends of bands."""
    return Speed(*omega, digits=4, between=" to ", bare=True, ways=ways)


BARS = (
    "Each value is changed by 10 % (30 % where 10 % has little effect), one at a time, in the better direction. The "
    "load speeds are kept when the gear is changed."
)
FEED_FORWARD = (
    "A feed-forward that cancels one order of the kinematic error requires the phase of this order, which no datasheet "
    "gives. The residual error with a real controller: strainwave compensate."
)


def remedies(view: View) -> Part:
    """Changes that make the error smaller, the most helpful first; its numbers are those of `speeds_to_avoid`."""
    avoid, changes = view.analysis.avoid, view.analysis.remedies
    if avoid is None:
        return Part()
    rows = [row for row in remedies_data(view, avoid)["remedies"] if row["helps"]]
    limit = "" if view.project.limit is None else " above_limit"
    columns = f"what change from to unit relative_oscillation oscillation_rad at_rad_per_s{limit}"
    cancelled = FEED_FORWARD * any(one.share == CANCELLED for one in changes)
    tried = [f"Not tried: {sentence}." for sentence in view.analysis.not_tried]
    notes = [BARS * bool(rows), cancelled, no_help(changes), *tried]
    return Part("What would help", tables=[Table(rows, columns)], notes=notes)
