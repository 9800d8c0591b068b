"""Speeds to avoid and what would help, as data and in sentences."""

import math
from collections.abc import Iterable
from typing import Any

from ...files.project import Project
from ...study.analysis.advice import Advice
from ...study.analysis.analysis import Analysis
from ...study.analysis.avoid import AMPLIFIED, Avoid
from ...study.analysis.remedies import Remedy
from ...units import ARCSEC, RPM
from ..console import number
from ..units import AngleUnit
from .resonances import place

OSCILLATION = "the oscillation of the error (its largest distance from its mean, in a steady motion)"
APART = "and wherever run-up and coast-down are on different motions"
NOMINAL = (
    "The speeds to avoid are those of the nominal drive; sw.variability tells how far the scatter of its parameters "
    "moves them (page “Ensembles, basins, variability” of the documentation)."
)
NOTHING = 0.005  # relative change that is called none


def advice_data(project: Project, analysis: Analysis, angle: AngleUnit) -> dict[str, Any] | None:
    """Bands of speed and remedies with their numbers, rule and sentences; None where no motion is stable."""
    advice = analysis.advice
    if advice is None:
        return None
    avoid, rpm = advice.avoid, None if project.shaft == "forcing" else 1.0 / RPM
    return {
        "rule": _rule(avoid, angle),
        "limit_rad": avoid.limit,
        "bands": [_band(project, *band) for band in avoid.bands],
        "largest_oscillation_rad": avoid.largest,
        "largest_oscillation_arcsec": avoid.largest / ARCSEC,
        "at_rad_per_s": avoid.at,
        "slow_oscillation_rad": avoid.slow,
        "peaks": [place(project, at) | {"oscillation_rad": size} for at, size in avoid.peaks],
        "sentence": _avoid(project, analysis, avoid, angle),
        "run_up_bands": [_band(project, *band) for band in avoid.passed],
        "about": _about(project, analysis, avoid),
        "nominal": NOMINAL if avoid.bands else "",
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


def _band(project: Project, low: float, high: float) -> dict[str, Any]:
    rpm = None if project.shaft == "forcing" else 1.0 / RPM
    return {
        "from_rad_per_s": low,
        "to_rad_per_s": high,
        "from_rpm": low * rpm if rpm else None,
        "to_rpm": high * rpm if rpm else None,
    }


def _about(project: Project, analysis: Analysis, avoid: Avoid) -> str:
    """Say which torque the speeds to avoid are for, where the curve has not all of them."""
    if avoid.largest_passed is None:
        return ""
    if analysis.train_curve is None:
        motions, run = "of the error equation, in place of the whole drive train", "the run-up of that train"
    else:
        motions = "under constant mean torques, without the torque that follows the load's own angle"
        run = "the run-up, which has that torque,"
    met = _listed(_range(project, analysis, *band) for band in avoid.passed)
    adds = f"adds {met} {_unit(project)}" if met else "adds no speed"
    return (
        f"The steady motions behind these speeds are {motions}; {run} {adds}. At other angles of the load the speeds "
        "move."
    )


def _range(project: Project, analysis: Analysis, low: float, high: float) -> str:
    ends = analysis.speeds
    return (
        f"{_speed(project, low)} to {_speed(project, high)}"
        + (" (the end of the range)" if math.isclose(high, ends[1]) else "")
        + (" (from the start of the range)" if math.isclose(low, ends[0]) else "")
    )


def _speed(project: Project, omega: float) -> str:
    """Speed without its unit, for ends of bands: whole rpm."""
    return number(omega, 4) if project.shaft == "forcing" else f"{omega / RPM:.0f}"


def _unit(project: Project) -> str:
    return "rad/s" if project.shaft == "forcing" else "rpm at the motor"


def _rule(avoid: Avoid, angle: AngleUnit) -> str:
    if avoid.limit is not None:
        return (
            f"A speed is to be avoided where {OSCILLATION} is above the project's limit of {angle.text(avoid.limit)}, "
            f"{APART}."
        )
    return (
        f"A speed is to be avoided around every peak of the computed curve that is more than {AMPLIFIED:g} times the "
        f"oscillation of slow turning, as long as {OSCILLATION} is above 1/√2 of that peak (half power), {APART}."
    )


def _avoid(project: Project, analysis: Analysis, avoid: Avoid, angle: AngleUnit) -> str:
    sweep = analysis.response.sweep
    slow = f"{angle.text(avoid.slow)} of slow turning"
    if not avoid.bands:
        largest = avoid.largest if avoid.largest_passed is None else max(avoid.largest, avoid.largest_passed[1])
        times = f"{number(largest / avoid.slow, 2)} times" if avoid.slow > 0.0 else "many times"
        beside = f"{times} the {slow}" if avoid.limit is None else f"within the limit of {angle.text(avoid.limit)}"
        return (
            f"No speed of the range has to be avoided: the error oscillates with at most {angle.text(largest)}, "
            f"{beside}{'' if sweep is not None and sweep.alone else ', and nothing jumps'}."
        )
    bands = _listed(_range(project, analysis, *band) for band in avoid.bands)
    reasons = []
    if avoid.peaks:
        tops = _listed(f"{angle.text(size)} at {_speed(project, at)}" for at, size in avoid.peaks)
        whose = "its peak" if len(avoid.peaks) == 1 else "the peak there"
        reasons.append(f"the error oscillates with more than 1/√2 of {whose}, {tops}, against {slow}")
    if avoid.limit is not None and avoid.largest > avoid.limit:
        most = f"{angle.text(avoid.largest)} at {_speed(project, avoid.at)}"
        reasons.append(f"the error oscillates with more than the limit of {angle.text(avoid.limit)}, at most {most}")
    if avoid.passed and avoid.largest_passed is not None:
        at, size = avoid.largest_passed
        reasons.append(f"in the run-up the error oscillates with up to {angle.text(size)}, at {_speed(project, at)}")
    if sweep is not None and sweep.jumping:
        between = _listed(f"between {_speed(project, b.low)} and {_speed(project, b.high)}" for b in sweep.jumping)
        reasons.append(f"the motion jumps {between}")
    return f"Avoid {bands} {_unit(project)}: there {', and '.join(reasons)}."


def _listed(parts: Iterable[str]) -> str:
    told = list(parts)
    return f"{', '.join(told[:-1])} and {told[-1]}" if len(told) > 1 else "".join(told)


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
