"""Speeds to avoid and what would help, as data and in sentences."""

import math
from typing import Any

from ..study.advice import AMPLIFIED, Advice, Remedy
from ..study.analysis import Analysis
from .console import number
from .facts import ARCSEC, RPM, AngleUnit
from .project import Project

RULE = (
    "A speed is to be avoided where the oscillation of the error (its largest distance from its mean, in a steady "
    "motion) is above 1/√2 of the largest in the range (half power), provided that this largest is more than "
    f"{AMPLIFIED:g} times the oscillation of slow turning; and wherever run-up and coast-down are on different motions."
)
NOTHING = 0.005  # relative change that is called none


def advice_data(project: Project, analysis: Analysis, angle: AngleUnit) -> dict[str, Any] | None:
    """Bands of speed and remedies with their numbers, rule and sentences; None where no motion is stable."""
    advice = analysis.advice
    if advice is None:
        return None
    avoid, rpm = advice.avoid, None if project.shaft == "forcing" else RPM
    return {
        "rule": RULE,
        "bands": [
            {
                "from_rad_per_s": low,
                "to_rad_per_s": high,
                "from_rpm": low * rpm if rpm else None,
                "to_rpm": high * rpm if rpm else None,
            }
            for low, high in avoid.bands
        ],
        "largest_oscillation_rad": avoid.largest,
        "largest_oscillation_arcsec": avoid.largest * ARCSEC,
        "at_rad_per_s": avoid.at,
        "slow_oscillation_rad": avoid.slow,
        "sentence": _avoid(project, analysis, advice, angle),
        "remedies": [
            {
                "what": r.what,
                "change": _change(r),
                "relative_oscillation": r.ratio,
                "at_rad_per_s": r.at,
                "at_rpm": r.at * rpm if rpm else None,
            }
            for r in advice.remedies
        ],
        "remedy_sentence": _remedies(project, advice),
    }


def _speed(project: Project, omega: float) -> str:
    """Speed without its unit, for ends of bands: whole rpm."""
    return number(omega, 4) if project.shaft == "forcing" else f"{omega * RPM:.0f}"


def _unit(project: Project) -> str:
    return "rad/s" if project.shaft == "forcing" else "rpm at the motor"


def _avoid(project: Project, analysis: Analysis, advice: Advice, angle: AngleUnit) -> str:
    avoid, sweep = advice.avoid, analysis.response.sweep
    slow = f"{angle.text(avoid.slow)} of slow turning"
    if not avoid.bands:
        return (
            f"No speed of the range has to be avoided: the error oscillates with at most {angle.text(avoid.largest)}, "
            f"{_times(avoid)} the {slow}, and nothing jumps."
        )
    ends = analysis.speeds
    bands = " and ".join(
        f"{_speed(project, low)} to {_speed(project, high)}"
        + (" (the end of the range)" if math.isclose(high, ends[1]) else "")
        + (" (from the start of the range)" if math.isclose(low, ends[0]) else "")
        for low, high in avoid.bands
    )
    why = (
        f"there the error oscillates with more than 1/√2 of its largest, {angle.text(avoid.largest)} at "
        f"{_speed(project, avoid.at)}, {_times(avoid)} the {slow}"
    )
    jumping = ""
    if sweep is not None and sweep.width > 0.0:
        low, high = sorted((sweep.jump_up, sweep.jump_down))
        jumping = f"the motion jumps between {_speed(project, low)} and {_speed(project, high)}"
    reasons = ", and ".join(part for part in (why if avoid.amplified else "", jumping) if part)
    return f"Avoid {bands} {_unit(project)}: {reasons}."


def _times(avoid: Any) -> str:
    return f"{number(avoid.largest / avoid.slow, 2)} times" if avoid.slow > 0.0 else "many times"


def _remedies(project: Project, advice: Advice) -> str:
    """What helps, the most helpful first, and what does not."""
    found = advice.remedies
    if not found:
        return ""
    told = "; ".join(_told(project, advice, remedy) for remedy in found)
    best = found[0]
    helps = f"Most helpful: {_more(best)}." if best.ratio < 1.0 - NOTHING else "None of them makes it smaller."
    return f"{helps} Computed again with one thing changed at a time: {told}."


def _change(remedy: Remedy) -> str:
    if remedy.by:
        return f"{number(remedy.by, 3)} N·m more"
    return f"{number(100.0 * abs(remedy.share))} % {'more' if remedy.share > 0.0 else 'less'}"


def _more(remedy: Remedy) -> str:
    return f"{_change(remedy)} {'mean torque' if remedy.by else remedy.what}"


def _told(project: Project, advice: Advice, remedy: Remedy) -> str:
    change = 100.0 * (remedy.ratio - 1.0)
    moved = abs(remedy.at / advice.avoid.at - 1.0) > NOTHING
    where = f", at {_speed(project, remedy.at)} in place of {_speed(project, advice.avoid.at)}" if moved else ""
    size = f"{number(abs(change), 2)} % {'less' if change < 0.0 else 'more'}"
    return f"{_more(remedy)}: {size if abs(change) > 100.0 * NOTHING else 'the same'} oscillation{where}"
