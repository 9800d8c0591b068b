"""The speeds to avoid: bands, the rule that gives them, and the reasons in sentences."""

import math
from typing import TYPE_CHECKING, Any

from ....base.sentences import Angle, Sentence, Speed, listed
from ....study.analysis.verdict_words import apart_said, band_data
from ....study.analysis.words import MOTOR, load_text
from ....study.speed_map.avoid import Avoid
from ....study.speed_map.error_equation import PEAK_AMPLIFICATION
from ...console import number
from ...view import View, sizes
from ..section import Part
from .remedies import bare_speed, remedies_data

if TYPE_CHECKING:
    pass

OSCILLATION = "the oscillation of the error (largest distance from the mean error, in a steady motion)"
APART = "and wherever run-up and run-down lead to different motions"
NOMINAL = (
    "The speeds to avoid are those of the nominal drive. With 'scatter' and 'limit' in the project file, 'strainwave "
    "exceedance' computes the probability that a drive exceeds the limit."
)
BEYOND = " The curve and the speeds to avoid extend 20 % beyond the single speeds of the project file."


def speeds_to_avoid(view: View) -> Part:
    """Bands of speed with their reasons and their rule; no advice where no motion of the whole drive is stable."""
    advice = _advice(view)
    if advice is None:
        return Part(data={"advice": None})
    texts, notes = (advice["sentence"], advice["about"]), (advice["rule"], advice["nominal"])
    return Part(data={"advice": advice}, sentences=texts, notes=notes, kind="do")


def _advice(view: View) -> dict[str, Any] | None:
    """Key `advice` of results.json, the remedies in it; None where no motion of the whole drive is stable."""
    avoid = view.analysis.avoid
    if avoid is None:
        return None
    run_up = dict[str, Any]()  # where the curve leaves out some of its torques
    if avoid.largest_passed is not None:
        speed, size = avoid.largest_passed
        run_up = {**sizes(size, "largest_oscillation_in_run_up"), "in_run_up_at_rad_per_s": speed}
    return {
        "rule": _rule(avoid) + (BEYOND if view.speeds.single else ""),
        "limit_rad": avoid.limit,
        "bands": [band_data(view.speeds, *band) for band in avoid.bands],
        **sizes(avoid.largest, "largest_oscillation"),
        "at_rad_per_s": avoid.at,
        **run_up,
        "slow_oscillation_rad": avoid.slow,
        "peaks": [view.speed_data(w) | {"oscillation_rad": size} for w, size in avoid.peaks],
        "sentence": _avoided(view, avoid) + _avoided_for_limits(view, avoid),
        "by_load_torque": [
            {"load_torque_Nm": case.torque, "bands": [band_data(view.speeds, *band) for band in case.bands]}
            for case in view.analysis.load_cases
        ],
        "run_up_bands": [band_data(view.speeds, *band) for band in avoid.passed],
        "about": _about(view, avoid),
        "nominal": NOMINAL if avoid.bands else "",
        **remedies_data(view, avoid),
    }


def _about(view: View, avoid: Avoid) -> Sentence | str:
    """Say which torques of the load the speeds to avoid are for, and the speeds that the run-up adds."""
    cases, text = view.analysis.load_cases, ""
    if cases:
        ends = f"{len(cases)} load torques from {number(cases[0].torque)} to {number(cases[-1].torque)} N·m"
        torques = ", ".join(number(case.torque) for case in cases if not case.bands)
        free = f" At {torques} N·m there is no speed to avoid." if torques else ""
        each = [f"at {number(case.torque)} N·m " + _ranges(view, case.bands) for case in cases if case.bands]
        bands = ": " + Sentence("; ").join(each) if each else ""
        text = f"These speeds cover {ends} and the gaps between their bands" + bands + "." + free + " "
    if avoid.largest_passed is None:
        return text
    speed, size = avoid.largest_passed
    speeds = _ranges(view, avoid.passed) + " " + Speed() if avoid.passed else "no speed"
    speeds += Sentence(", oscillation about the mean of each turn up to {} at {}", Angle(size), bare_speed(speed))
    if view.analysis.train_curve is None:
        return (
            "These speeds are from the error equation, not from the whole drive train; the run-up of the drive train "
            "adds " + speeds + "."
        )
    return text + "The run-up, with torques that depend on the load angle, adds " + speeds + "."


def _avoided_for_limits(view: View, avoid: Avoid) -> Sentence:
    """Say all speeds to avoid where limits of the gear or the motor add some to those of the oscillation."""
    verdict = view.analysis.verdict
    if verdict.fault or verdict.speeds == avoid.bands:
        return Sentence("")
    posed = ["postures"] if view.analysis.postures else []
    of = dict.fromkeys("limits of the motor" if f.limit in MOTOR else "limits of the gear" for f in verdict.exceeded)
    return Sentence(" Because of the {}, avoid {} {}.", listed([*of, *posed]), _ranges(view, verdict.speeds), Speed())


def _between(low: float, high: float) -> Sentence:
    """A band of speeds [rad/s], as the end of a sentence."""
    return "between " + bare_speed(low) + " and " + bare_speed(high)


def _ranges(view: View, bands: tuple[tuple[float, float], ...]) -> Sentence:
    """Bands of speed [rad/s], those that reach an end of the range with a word on it."""
    first, last = view.analysis.speeds
    ends = {last: " (end of the speed range)", first: " (start of the speed range)"}
    return listed(
        bare_speed(*band, ways=(-1, 1))
        + "".join(text for end, text in ends.items() if any(math.isclose(end, speed) for speed in band))
        for band in bands
    )


def _rule(avoid: Avoid) -> str:
    """Say above which oscillation a speed is to be avoided."""
    if avoid.limit is not None:
        text = f"A speed is to be avoided where {OSCILLATION} is above the project limit of "
        return text + Angle(avoid.limit) + f", {APART}."
    level = f"{PEAK_AMPLIFICATION:g} times its value at very low speed"
    return f"A speed is to be avoided where {OSCILLATION} is above {level}, {APART}."


def _avoided(view: View, avoid: Avoid) -> Sentence:
    """Say which speeds to avoid for their oscillation, and why; or how large it is where there are none."""
    if not avoid.bands:
        return _nothing_avoided(view, avoid)
    reasons = list[str]()
    if avoid.peaks:
        slow = Angle(avoid.slow) + " at very low speed"
        tops = listed(Angle(size) + " at " + bare_speed(speed) for speed, size in avoid.peaks)
        fact = f"the oscillation of the error is above {PEAK_AMPLIFICATION:g} times the {{}}: {{}}"
        reasons.append(Sentence(fact, slow, tops))
    if avoid.limit is not None and avoid.largest > avoid.limit:
        text = "the oscillation of the error is above the limit of {}, at most {} at {}"
        reasons.append(Sentence(text, Angle(avoid.limit), Angle(avoid.largest), bare_speed(avoid.at)))
    if avoid.apart is not None and avoid.apart[1] > (avoid.limit or PEAK_AMPLIFICATION * avoid.slow):
        text = "another periodic motion oscillates with up to {}, at {}"
        reasons.append(Sentence(text, apart_said(avoid.apart)[0], bare_speed(avoid.apart[0])))
    if jumps := _jumps(view):
        reasons.append("the oscillation jumps " + listed(jumps))
    if avoid.unstable:
        reasons.append("the steady motion is unstable " + listed(_between(*ends) for ends in avoid.unstable))
    return Sentence("Avoid {} {}: there {}.", _ranges(view, avoid.bands), Speed(), Sentence(", and ").join(reasons))


def _nothing_avoided(view: View, avoid: Avoid) -> Sentence:
    """Say how large the oscillation is at most, beside its limit or that of slow rotation."""
    sweep, passed = view.analysis.drive.sweep, 0.0 if avoid.largest_passed is None else avoid.largest_passed[1]
    largest = max(avoid.largest, passed)
    up_to: Sentence | Angle = Angle(largest)
    if passed > avoid.largest:
        up_to = Sentence("{} in steady motions and {} in the run-up", Angle(avoid.largest), Angle(passed))
    if avoid.limit is not None:
        comparison = "within the limit of " + Angle(avoid.limit)
    else:
        times = f"{number(largest / avoid.slow, 2)} times" if avoid.slow > 0.0 else "many times"
        comparison = f"{times} the " + (Angle(avoid.slow) + " at very low speed")
    jumps = "" if sweep is not None and sweep.alone else ", without jumps"
    return Sentence(
        "No speed of the range has to be avoided: the oscillation of the error is at most {}, {}{}.",
        up_to, comparison, jumps,
    )  # fmt: skip


def _jumps(view: View) -> list[Sentence]:
    """Bands at whose ends a sweep of the drive's curve jumps, or those of its curves under other torques."""
    sweep = view.analysis.drive.sweep
    jumping = [(None, band) for band in sweep.jumping] if sweep is not None else []
    return [_between(band.low, band.high) + load_text(at) for at, band in jumping or view.analysis.jumping]
