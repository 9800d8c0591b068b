"""Speeds to avoid and what would help, as data and in sentences."""

import math
from collections.abc import Iterable
from typing import Any

from ...sentences import Angle, Sentence, Speed
from ...speeds import Speeds
from ...study.analysis.advice import Advice
from ...study.analysis.analysis import Analysis
from ...study.analysis.avoid import AMPLIFIED, Avoid
from ...study.analysis.remedies import Remedy
from ...units import ARCSEC
from ..console import number
from .resonances import place

OSCILLATION = "the oscillation of the error (its largest distance from its mean, in a steady motion)"
APART = "and wherever run-up and run-down are on different motions"
NOMINAL = (
    "The speeds to avoid are those of the nominal drive; sw.variability computes how far the scatter of its parameters "
    "moves them (page “Ensembles, basins, variability” of the documentation)."
)
NOTHING = 0.005  # relative change that is called none


def advice_data(speeds: Speeds, analysis: Analysis) -> dict[str, Any] | None:
    """Bands of speed and remedies with their numbers, rule and sentences; None where no motion is stable."""
    advice = analysis.advice
    if advice is None:
        return None
    avoid = advice.avoid
    return {
        "rule": _rule(avoid),
        "limit_rad": avoid.limit,
        "bands": [_band(speeds, *band) for band in avoid.bands],
        "largest_oscillation_rad": avoid.largest,
        "largest_oscillation_arcsec": avoid.largest / ARCSEC,
        "at_rad_per_s": avoid.at,
        "slow_oscillation_rad": avoid.slow,
        "peaks": [place(speeds, at) | {"oscillation_rad": size} for at, size in avoid.peaks],
        "sentence": _avoid(analysis, avoid),
        "run_up_bands": [_band(speeds, *band) for band in avoid.passed],
        "about": _about(analysis, avoid),
        "nominal": NOMINAL if avoid.bands else "",
        "remedies": [
            {
                "what": r.what,
                "change": _change(r),
                "relative_oscillation": r.ratio,
                "at_rad_per_s": r.at,
                "at_rpm": speeds.rpm(r.at),
            }
            for r in advice.remedies
        ],
        "remedy_sentence": _remedies(advice),
    }


def _band(speeds: Speeds, low: float, high: float) -> dict[str, Any]:
    ends = {"from_rad_per_s": low, "to_rad_per_s": high}
    return ends | {"from_rpm": speeds.rpm(low), "to_rpm": speeds.rpm(high)}


def _about(analysis: Analysis, avoid: Avoid) -> str:
    """Say which torque the speeds to avoid are for, where the curve has not all of them."""
    if avoid.largest_passed is None:
        return ""
    if analysis.train_curve is None:
        motions, run = "of the error equation, in place of the whole drive train", "the run-up of that train"
    else:
        motions = "under constant mean torques, without the torque that follows the load's own angle"
        run = "the run-up, which has that torque,"
    met = _listed(_range(analysis, *band) for band in avoid.passed)
    return Sentence(
        "The steady motions behind these speeds are {}; {} adds {}. At other angles of the load the speeds move.",
        motions, run, Sentence("{} {}", met, Speed()) if met else "no speed",
    )  # fmt: skip


def _range(analysis: Analysis, low: float, high: float) -> Sentence:
    first, last = analysis.speeds
    return (
        Sentence("{}", _speed(low, high))
        + (" (the end of the range)" if math.isclose(high, last) else "")
        + (" (from the start of the range)" if math.isclose(low, first) else "")
    )


def _speed(*omega: float) -> Speed:
    """Speeds without their unit, for ends of bands."""
    return Speed(*omega, digits=4, between=" to ", bare=True)


def _rule(avoid: Avoid) -> str:
    if avoid.limit is not None:
        text = f"A speed is to be avoided where {OSCILLATION} is above the project's limit of {{}}, {APART}."
        return Sentence(text, Angle(avoid.limit))
    return (
        f"A speed is to be avoided around every peak of the computed curve that is more than {AMPLIFIED:g} times the "
        f"oscillation of quasi-static rotation, as long as {OSCILLATION} is above 1/√2 of that peak (half power), "
        f"{APART}."
    )


def _avoid(analysis: Analysis, avoid: Avoid) -> Sentence:
    sweep = analysis.response.sweep
    slow = Sentence("{} of quasi-static rotation", Angle(avoid.slow))
    if not avoid.bands:
        largest = avoid.largest if avoid.largest_passed is None else max(avoid.largest, avoid.largest_passed[1])
        times = f"{number(largest / avoid.slow, 2)} times" if avoid.slow > 0.0 else "many times"
        beside = Sentence("{} the {}", times, slow)
        if avoid.limit is not None:
            beside = Sentence("within the limit of {}", Angle(avoid.limit))
        return Sentence(
            "No speed of the range has to be avoided: the error oscillates with at most {}, {}{}.",
            Angle(largest), beside, "" if sweep is not None and sweep.alone else ", and nothing jumps",
        )  # fmt: skip
    reasons: list[str] = []
    if avoid.peaks:
        tops = _listed(Sentence("{} at {}", Angle(size), _speed(at)) for at, size in avoid.peaks)
        whose = "its peak" if len(avoid.peaks) == 1 else "the peak there"
        reasons.append(Sentence("the error oscillates with more than 1/√2 of {}, {}, against {}", whose, tops, slow))
    if avoid.limit is not None and avoid.largest > avoid.limit:
        text = "the error oscillates with more than the limit of {}, at most {} at {}"
        reasons.append(Sentence(text, Angle(avoid.limit), Angle(avoid.largest), _speed(avoid.at)))
    if avoid.passed and avoid.largest_passed is not None:
        at, size = avoid.largest_passed
        reasons.append(Sentence("in the run-up the error oscillates with up to {}, at {}", Angle(size), _speed(at)))
    if sweep is not None and sweep.jumping:
        between = _listed(Sentence("between {} and {}", _speed(b.low), _speed(b.high)) for b in sweep.jumping)
        reasons.append(Sentence("the motion jumps {}", between))
    bands = _listed(_range(analysis, *band) for band in avoid.bands)
    return Sentence("Avoid {} {}: there {}.", bands, Speed(), Sentence(", and ").join(reasons))


def _listed(parts: Iterable[str]) -> Sentence:
    said = list(parts)
    return Sentence(" and ").join([Sentence(", ").join(said[:-1]), said[-1]] if len(said) > 1 else said)


def _remedies(advice: Advice) -> str:
    """What helps, the most helpful first, and what does not."""
    found = advice.remedies
    if not found:
        return ""
    best = found[0]
    helps = f"Most helpful: {_more(best)}." if best.ratio < 1.0 - NOTHING else "None of them makes it smaller."
    said = Sentence("; ").join(_effect(advice, remedy) for remedy in found)
    return Sentence("{} Computed again with one thing changed at a time: {}.", helps, said)


def _change(remedy: Remedy) -> str:
    if remedy.by:
        return f"{number(remedy.by, 3)} N·m more"
    return f"{number(100.0 * abs(remedy.share))} % {'more' if remedy.share > 0.0 else 'less'}"


def _more(remedy: Remedy) -> str:
    return f"{_change(remedy)} {'mean torque' if remedy.by else remedy.what}"


def _effect(advice: Advice, remedy: Remedy) -> Sentence:
    change, at = 100.0 * (remedy.ratio - 1.0), advice.avoid.at
    moved = abs(remedy.at / at - 1.0) > NOTHING
    where = Sentence(", at {} instead of {}", _speed(remedy.at), _speed(at)) if moved else ""
    size = f"{number(abs(change), 2)} % {'less' if change < 0.0 else 'more'}"
    return Sentence(
        "{}: {} oscillation{}", _more(remedy), size if abs(change) > 100.0 * NOTHING else "the same", where
    )  # fmt: skip
